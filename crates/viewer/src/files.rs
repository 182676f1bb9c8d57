//! Reading files, with errors that name them, and writing files that appear whole or not at all.

use crate::failure::Failure;
use image::ImageReader;
use planish_viewer::texture::Texture;
use std::io::{Cursor, Write as _};
use std::path::Path;

/// Gives errors about a file that was read its name.
pub(crate) fn at<E: ToString>(path: &Path) -> impl Fn(E) -> Failure + '_ {
    move |e| Failure::Input { path: path.to_owned(), reason: e.to_string() }
}

pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(at(path))
}

/// Numbers between blanks.
pub(crate) fn scalars(path: &Path) -> Result<Vec<f32>, Failure> {
    let bytes = read(path)?;
    let number = |token: &str| token.parse().map_err(|_| at(path)(format!("`{token}` is not a number")));
    String::from_utf8_lossy(&bytes).split_whitespace().map(number).collect()
}

/// An image from its bytes; the path names it in errors.
pub(crate) fn texture(bytes: Vec<u8>, path: &Path) -> Result<Texture, Failure> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(at(path))?;
    let image = reader.decode().map_err(at(path))?;
    Texture::new(image.into_rgba8()).ok_or_else(|| at(path)("the image is empty"))
}

/// Writes beside the file and renames, so that no reader ever sees half a file.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let attempt = || {
        let builder = &mut tempfile::Builder::new();
        // A picture is no secret: the permissions of any new file, less the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder)?;
        file.write_all(bytes)?;
        file.persist(path).map(drop).map_err(|e| e.error)
    };
    attempt().map_err(|e: std::io::Error| Failure::Output { path: path.to_owned(), reason: e.to_string() })
}
