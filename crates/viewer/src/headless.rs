//! Files in, a picture out.

use crate::args::Args;
use image::{ImageFormat, ImageReader};
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::weld::Welding;
use planish_viewer::settings::{Settings, Shading};
use planish_viewer::texture::Texture;
use planish_viewer::{input, software};
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why there is no picture.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// A file that cannot be read or makes no sense.
    #[error("{}: {reason}", path.display())]
    Input { path: PathBuf, reason: String },
    /// Options that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A file that cannot be written.
    #[error("{}: {reason}", path.display())]
    Output { path: PathBuf, reason: String },
    /// No `--headless`.
    #[error("the window is not part of this version; draw into a file with --headless OUT.png")]
    NoWindow,
}

impl Failure {
    /// Exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Output { .. } | Self::NoWindow => 1,
            Self::Input { .. } | Self::Usage(_) => 2,
        }
    }
}

/// Gives errors about a file that was read its name.
fn input_failure<E: ToString>(path: &Path) -> impl Fn(E) -> Failure + '_ {
    move |e| Failure::Input { path: path.to_owned(), reason: e.to_string() }
}

/// Does what the command line says.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let output = args.headless.as_deref().ok_or(Failure::NoWindow)?;
    let settings = match &args.settings {
        Some(path) => Settings::from_json(&read(path)?).map_err(input_failure(path))?,
        None => Settings::default(),
    };
    let settings = args.override_settings(settings);
    settings.check().map_err(|e| Failure::Usage(e.to_string()))?;
    if settings.shading == Shading::Heat && args.scalars.is_none() {
        return Err(Failure::Usage("heat shading needs numbers: --scalars IN.txt".to_owned()));
    }

    let obj = Obj::parse(read(&args.input)?).map_err(input_failure(&args.input))?;
    let scalars = args.scalars.as_deref().map(read_scalars).transpose()?;
    // Only the count of numbers can be wrong: the model's own indices are in range.
    let blamed = args.scalars.as_deref().unwrap_or(&args.input);
    let mut scene =
        input::scene(&Model::new(obj, Welding::Exact), scalars.as_deref()).map_err(input_failure(blamed))?;
    scene.texture = args.texture.as_deref().map(read_texture).transpose()?;

    let mut png = Cursor::new(Vec::new());
    let failed = |reason: String| Failure::Output { path: output.to_owned(), reason };
    software::render(&scene, &settings).write_to(&mut png, ImageFormat::Png).map_err(|e| failed(e.to_string()))?;
    write(output, png.get_ref())?;
    if let Some(path) = &args.save_settings {
        write(path, settings.to_json().map_err(|e| failed(e.to_string()))?.as_bytes())?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(input_failure(path))
}

fn read_scalars(path: &Path) -> Result<Vec<f32>, Failure> {
    let bytes = read(path)?;
    let number = |token: &str| token.parse().map_err(|_| input_failure(path)(format!("`{token}` is not a number")));
    String::from_utf8_lossy(&bytes).split_whitespace().map(number).collect()
}

fn read_texture(path: &Path) -> Result<Texture, Failure> {
    let reader = ImageReader::new(Cursor::new(read(path)?)).with_guessed_format().map_err(input_failure(path))?;
    let image = reader.decode().map_err(input_failure(path))?;
    Texture::new(image.into_rgba8()).ok_or_else(|| input_failure(path)("the image is empty"))
}

/// Writes beside the file and renames, so that no reader ever sees half a file.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
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
