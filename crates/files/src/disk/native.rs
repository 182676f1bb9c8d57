//! Files of the operating system.

use super::Entry;
use std::ffi::OsString;
use std::io::{Read as _, Result};
use std::path::{Path, PathBuf};

/// Reads all bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path)
}

/// Reads a file, and no more bytes of it than `largest`.
pub(crate) fn read_up_to(path: &Path, largest: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(largest).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Tells what a path leads to, all links followed.
pub(crate) fn entry(path: &Path) -> Result<Entry> {
    let metadata = path.metadata()?;
    Ok(match (metadata.is_file(), metadata.is_dir()) {
        (true, _) => Entry::File(metadata.len()),
        (_, true) => Entry::Folder,
        _ => Entry::Other,
    })
}

/// Absolute path of what is there, all links followed.
pub(crate) fn canonicalize(path: &Path) -> Result<PathBuf> {
    path.canonicalize()
}

/// Absolute path of what need not be there.
pub(crate) fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path)
}

/// Names of what is in a folder.
pub(crate) fn names(folder: &Path) -> Result<Vec<OsString>> {
    Ok(std::fs::read_dir(folder)?.filter_map(|entry| Some(entry.ok()?.file_name())).collect())
}
