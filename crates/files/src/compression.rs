//! Files compressed with gzip: meshes are read and written in them.

use flate2::read::MultiGzDecoder;
use flate2::{Compression, GzBuilder};
use std::ffi::OsStr;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Extension of a compressed file.
const EXTENSION: &str = "gz";
/// First bytes of a gzip file.
const MAGIC: &[u8] = &[0x1f, 0x8b];
/// Largest content of a compressed file, bytes: a small file can hold more than any memory.
const LARGEST: u64 = 16 << 30;

/// Reasons why a compressed file cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompressionError {
    /// The compressed data is damaged or cut.
    #[error("this gzip file is damaged or cut")]
    Damaged,
    /// The content is too large.
    #[error("the content of this gzip file has more than {} GiB", LARGEST >> 30)]
    TooLarge,
}

/// Returns whether a file name is that of a compressed file.
pub fn is_compressed_name(path: &Path) -> bool {
    path.extension().and_then(OsStr::to_str).is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION))
}

/// Path of a file without the extension of compression.
pub fn uncompressed_name(path: &Path) -> PathBuf {
    if is_compressed_name(path) { path.with_extension("") } else { path.to_path_buf() }
}

/// Content of a file, uncompressed if its first bytes are those of a gzip file.
pub fn decompressed(bytes: Vec<u8>) -> Result<Vec<u8>, CompressionError> {
    if bytes.starts_with(MAGIC) { decompressed_to(&bytes, LARGEST) } else { Ok(bytes) }
}

fn decompressed_to(bytes: &[u8], largest: u64) -> Result<Vec<u8>, CompressionError> {
    let mut content = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(largest + 1);
    decoder.read_to_end(&mut content).map_err(|_| CompressionError::Damaged)?;
    if content.len() as u64 > largest { Err(CompressionError::TooLarge) } else { Ok(content) }
}

/// Content as a gzip file. Equal content gives equal bytes: the file names no time and no system.
pub fn compressed(content: &[u8]) -> Vec<u8> {
    let mut encoder = GzBuilder::new().operating_system(255).write(Vec::new(), Compression::default());
    // Writing to memory cannot fail.
    _ = encoder.write_all(content);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_comes_back_and_damage_is_told() {
        let content = b"v 0 0 0\n".repeat(100);
        let file = compressed(&content);
        assert!(file.len() < content.len() / 4);
        assert_eq!(decompressed(file.clone()), Ok(content.clone()));
        assert_eq!(decompressed([file.clone(), file.clone()].concat()), Ok(content.repeat(2)), "files joined are one");
        assert_eq!(decompressed(content.clone()), Ok(content.clone()), "what is not compressed stays");
        for end in 2..file.len() {
            assert_eq!(decompressed(file[..end].to_vec()), Err(CompressionError::Damaged), "{end}");
        }
        assert_eq!(decompressed_to(&file, 799), Err(CompressionError::TooLarge));
        assert_eq!(decompressed_to(&file, 800), Ok(content));
    }

    #[test]
    fn names_lose_the_extension_of_compression_alone() {
        let name = |path: &str| uncompressed_name(Path::new(path)).display().to_string();
        assert_eq!((name("a/scan.ply.gz"), name("scan.ply"), name("x.GZ")), ("a/scan.ply".into(), "scan.ply".into(), "x".into()));
    }
}
