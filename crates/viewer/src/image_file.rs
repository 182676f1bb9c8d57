//! Reading of pictures from files.

use image::{DynamicImage, ImageFormat, ImageReader};
use planish_files::failure::Failure;
use planish_files::input;
use std::io::Cursor;
use std::path::Path;

/// Reads and decodes a picture. Its content says which format it has, whatever its name ends in.
pub(crate) fn read(path: &Path) -> Result<DynamicImage, Failure> {
    decode(&input::read(path)?, path)
}

/// Decodes the bytes of a picture; `path` is for the error message.
pub(crate) fn decode(bytes: &[u8], path: &Path) -> Result<DynamicImage, Failure> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| Failure::at(path, e))?;
    if reader.format().is_none() {
        // A TGA file has no mark at its beginning, and is told by its name.
        if let Ok(ImageFormat::Tga) = ImageFormat::from_path(path) {
            reader.set_format(ImageFormat::Tga);
        }
    }
    reader.decode().map_err(|e| Failure::at(path, e))
}
