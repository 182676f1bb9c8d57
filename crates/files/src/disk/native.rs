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
    // Opening a pipe would wait for its writer.
    path.metadata().ok().filter(std::fs::Metadata::is_file)?;
    let file = std::fs::File::open(path).ok()?;
    let size = usize::try_from(file.metadata().ok()?.len()).ok().filter(|size| *size > CHUNK)?;
    of_at_least(file, size)
}

/// Bytes that a thread reads at a time.
#[cfg(unix)]
const CHUNK: usize = 4 << 20;

/// Reads a file that had `size` bytes a moment ago to its end, which may be farther by now. `None` if the file has got shorter.
#[cfg(unix)]
fn of_at_least(mut file: std::fs::File, size: usize) -> Option<Vec<u8>> {
    use rayon::prelude::*;
    use std::io::{Seek as _, SeekFrom};
    use std::os::unix::fs::FileExt as _;
    let mut bytes = vec![0; size];
    let chunks = bytes.par_chunks_mut(CHUNK).enumerate();
    chunks.try_for_each(|(k, chunk)| file.read_exact_at(chunk, (k * CHUNK) as u64)).ok()?;
    file.seek(SeekFrom::Start(size as u64)).ok()?;
    file.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// Reads a file to its end, or the first `largest` + 1 bytes of one that has more than `largest`.
pub(crate) fn read_up_to(path: &Path, largest: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(largest.saturating_add(1)).read_to_end(&mut bytes)?;
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_grows_or_shrinks_while_it_is_read_is_not_cut_at_its_first_size() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.obj");
        let content: Vec<u8> = (0..2 * CHUNK + 12345).map(|i| (i % 251) as u8).collect();
        std::fs::write(&path, &content).unwrap();
        let read_after = |size: usize| of_at_least(std::fs::File::open(&path).unwrap(), size);
        // The file had fewer bytes when its size was taken, the same, or more.
        for before in [CHUNK + 1, 2 * CHUNK, content.len()] {
            assert!(read_after(before).as_ref() == Some(&content), "{before} bytes before");
        }
        assert_eq!(read_after(content.len() + 1), None);
        assert!(read(&path).unwrap() == content);
    }

    #[test]
    fn a_file_with_too_many_bytes_is_told_from_one_with_just_as_many() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("library.mtl");
        std::fs::write(&path, [7; 100]).unwrap();
        let lengths = [99, 100, 101, u64::MAX].map(|largest| read_up_to(&path, largest).unwrap().len());
        assert_eq!(lengths, [100, 100, 100, 100]);
        assert_eq!(read_up_to(&path, 20).unwrap().len(), 21);
    }
}
