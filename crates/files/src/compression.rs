//! Compressed files: meshes are read from gzip and xz, and written as gzip.
//!
//! ```
//! use planish_files::compression::{self, CompressionError};
//! use std::path::Path;
//!
//! let text = b"v 0 0 0\n".repeat(1000);
//! let compressed = compression::compressed(&text);
//! assert!(compressed.len() < text.len() / 10);
//! assert_eq!(compression::decompressed_to(&compressed, 7999), Err(CompressionError::TooLarge));
//! assert_eq!(compression::decompressed(compressed)?, text);
//!
//! // The name says how a file is written, and the content how it is read.
//! assert!(compression::is_compressed_name(Path::new("scan.obj.gz")));
//! assert_eq!(compression::uncompressed_name(Path::new("scan.obj.gz")), Path::new("scan.obj"));
//! assert_eq!(compression::decompressed(text.clone())?, text);
//! # Ok::<(), CompressionError>(())
//! ```

use flate2::read::MultiGzDecoder;
use flate2::{Compression, GzBuilder};
use std::ffi::OsStr;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Extension of a compressed file.
const EXTENSION: &str = "gz";
/// Extensions of files that are read.
const EXTENSIONS: [&str; 2] = [EXTENSION, "xz"];
/// First bytes of a gzip file.
const GZIP: &[u8] = &[0x1f, 0x8b];
/// First bytes of an xz file.
const XZ: &[u8] = &[0xfd, b'7', b'z', b'X', b'Z', 0];
/// Largest content of a compressed file, bytes: a small file can hold more than any memory.
const LARGEST: u64 = 16 << 30;

/// Reasons why a compressed file cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompressionError {
    /// The compressed data is damaged or cut.
    #[error("this compressed file is damaged or cut")]
    Damaged,
    /// The content is too large.
    #[error("the content of this compressed file has more than {} GiB", LARGEST >> 30)]
    TooLarge,
}

/// Returns whether a file of this name is written compressed.
pub fn is_compressed_name(path: &Path) -> bool {
    has_extension(path, &[EXTENSION])
}

/// Returns whether a file of this name is compressed in a way that is only read.
pub fn is_only_read(path: &Path) -> bool {
    has_extension(path, &EXTENSIONS) && !is_compressed_name(path)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str);
    extension.is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// Path of a file without the extension of compression.
pub fn uncompressed_name(path: &Path) -> PathBuf {
    if has_extension(path, &EXTENSIONS) { path.with_extension("") } else { path.to_path_buf() }
}

/// Content of a file, uncompressed if its first bytes are those of a compressed file.
pub fn decompressed(bytes: Vec<u8>) -> Result<Vec<u8>, CompressionError> {
    if bytes.starts_with(GZIP) || bytes.starts_with(XZ) { decompressed_to(&bytes, LARGEST) } else { Ok(bytes) }
}

/// Content of a compressed file of at most `largest` bytes.
pub fn decompressed_to(bytes: &[u8], largest: u64) -> Result<Vec<u8>, CompressionError> {
    if bytes.starts_with(XZ) {
        let mut content = Limited { bytes: Vec::new(), largest, is_full: false };
        let done = lzma_rs::xz_decompress(&mut &bytes[..], &mut content);
        return match done {
            Ok(()) => Ok(content.bytes),
            Err(_) if content.is_full => Err(CompressionError::TooLarge),
            Err(_) => Err(CompressionError::Damaged),
        };
    }
    let mut content = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(largest + 1);
    decoder.read_to_end(&mut content).map_err(|_| CompressionError::Damaged)?;
    if content.len() as u64 > largest { Err(CompressionError::TooLarge) } else { Ok(content) }
}

/// Bytes in memory that do not grow beyond a limit.
struct Limited {
    bytes: Vec<u8>,
    largest: u64,
    /// True after a write that was refused.
    is_full: bool,
}

impl std::io::Write for Limited {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if (self.bytes.len() + bytes.len()) as u64 > self.largest {
            self.is_full = true;
            return Err(std::io::ErrorKind::FileTooLarge.into());
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
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

    /// 800 bytes as `xz` writes them.
    const XZ_FILE: &[u8] = &[
        0xfd, 0x37, 0x7a, 0x58, 0x5a, 0x00, 0x00, 0x04, 0xe6, 0xd6, 0xb4, 0x46, 0x02, 0x00, 0x21, 0x01, 0x16, 0x00,
        0x00, 0x00, 0x74, 0x2f, 0xe5, 0xa3, 0xe0, 0x03, 0x1f, 0x00, 0x0f, 0x5d, 0x00, 0x3b, 0x08, 0x02, 0x11, 0x02,
        0x0a, 0xbf, 0xf1, 0xf0, 0x1f, 0xf0, 0x40, 0x70, 0x01, 0x00, 0x00, 0x00, 0x2c, 0xd4, 0x41, 0x2e, 0x8a, 0xb0,
        0x38, 0xf3, 0x00, 0x01, 0x2b, 0xa0, 0x06, 0x00, 0x00, 0x00, 0x62, 0xe1, 0x72, 0xfb, 0xb1, 0xc4, 0x67, 0xfb,
        0x02, 0x00, 0x00, 0x00, 0x00, 0x04, 0x59, 0x5a,
    ];

    #[test]
    fn xz_files_are_read() {
        let content = b"v 0 0 0\n".repeat(100);
        assert_eq!(decompressed(XZ_FILE.to_vec()), Ok(content.clone()));
        for end in 6..XZ_FILE.len() {
            assert_eq!(decompressed(XZ_FILE[..end].to_vec()), Err(CompressionError::Damaged), "{end}");
        }
        assert_eq!(decompressed_to(XZ_FILE, 799), Err(CompressionError::TooLarge));
        assert_eq!(decompressed_to(XZ_FILE, 800), Ok(content));
        for at in 6..XZ_FILE.len() {
            for bit in 0..8 {
                let mut damaged = XZ_FILE.to_vec();
                damaged[at] ^= 1 << bit;
                // Nothing but an error, or the content where the bit says nothing.
                let read = decompressed(damaged);
                assert!(read.is_err() || read == decompressed(XZ_FILE.to_vec()), "{at} {bit}");
            }
        }
    }

    #[test]
    fn names_lose_the_extension_of_compression_alone() {
        let name = |path: &str| uncompressed_name(Path::new(path)).display().to_string();
        assert_eq!(
            (name("a/scan.ply.gz"), name("scan.ply"), name("x.GZ")),
            ("a/scan.ply".into(), "scan.ply".into(), "x".into())
        );
    }
}
