//! Files of the operating system.

use super::Entry;
use std::ffi::OsString;
use std::io::{Read as _, Result};
use std::path::{Path, PathBuf};

/// Reads all bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    #[cfg(unix)]
    if let Some(bytes) = in_parallel(path) {
        return Ok(bytes);
    }
    std::fs::read(path)
}

/// Reads a large plain file with all threads, which are quicker than one where the bytes are in memory already. `None` for any other
/// file, and if the file gets shorter meanwhile.
#[cfg(unix)]
fn in_parallel(path: &Path) -> Option<Vec<u8>> {
    use rayon::prelude::*;
    use std::os::unix::fs::FileExt as _;
    /// Bytes that a thread reads at a time.
    const CHUNK: usize = 4 << 20;
    let metadata = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
    let size = usize::try_from(metadata.len()).ok().filter(|size| *size > CHUNK)?;
    let file = std::fs::File::open(path).ok()?;
    let mut bytes = vec![0; size];
    let chunks = bytes.par_chunks_mut(CHUNK).enumerate();
    chunks.try_for_each(|(k, chunk)| file.read_exact_at(chunk, (k * CHUNK) as u64)).ok()?;
    Some(bytes)
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
