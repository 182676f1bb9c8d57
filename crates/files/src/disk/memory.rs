//! Files in memory, with folders as on a disk whose root is the working folder.

use super::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io::{Error, ErrorKind, Result};
use std::path::{Component, Path, PathBuf};

/// Files by their absolute paths. A folder is there while a file is in it or below it.
#[derive(Debug)]
struct Files(BTreeMap<PathBuf, Vec<u8>>);

/// Path from the root, without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::from("/");
    for component in path.components() {
        match component {
            Component::Normal(name) => normal.push(name),
            // The root is above itself.
            Component::ParentDir => _ = normal.pop(),
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    normal
}

impl Files {
    const NONE: Self = Self(BTreeMap::new());

    fn put(&mut self, path: &Path, bytes: Vec<u8>) {
        self.0.insert(normal(path), bytes);
    }

    fn remove(&mut self, folder: &Path) {
        let folder = normal(folder);
        self.0.retain(|path, _| !path.starts_with(&folder));
    }

    fn get(&self, path: &Path) -> Result<&[u8]> {
        // The words of a system for a file that is missing.
        let missing = || Error::new(ErrorKind::NotFound, "No such file or directory");
        // An empty path leads nowhere, as on a disk.
        if path.as_os_str().is_empty() {
            return Err(missing());
        }
        self.0.get(&normal(path)).map(Vec::as_slice).ok_or_else(missing)
    }

    /// Paths of the files below a folder, from that folder.
    fn below(&self, folder: &Path) -> impl Iterator<Item = &Path> {
        let folder = normal(folder);
        self.0.keys().filter_map(move |path| path.strip_prefix(&folder).ok())
    }

    fn entry(&self, path: &Path) -> Result<Entry> {
        match self.get(path) {
            Ok(bytes) => Ok(Entry::File(bytes.len() as u64)),
            Err(_) if !path.as_os_str().is_empty() && self.below(path).next().is_some() => Ok(Entry::Folder),
            Err(missing) => Err(missing),
        }
    }

    fn names(&self, folder: &Path) -> Vec<OsString> {
        let names = self.below(folder).filter_map(|path| Some(path.components().next()?.as_os_str().to_owned()));
        names.collect::<BTreeSet<_>>().into_iter().collect()
    }
}

#[cfg(target_family = "wasm")]
mod global {
    use super::*;
    use std::sync::{Mutex, MutexGuard, PoisonError};

    static FILES: Mutex<Files> = Mutex::new(Files::NONE);

    fn files() -> MutexGuard<'static, Files> {
        FILES.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a file into memory, in place of one that is there.
    pub fn put(path: &Path, bytes: Vec<u8>) {
        files().put(path, bytes);
    }

    /// Takes a folder and all files below it out of memory.
    pub fn remove(folder: &Path) {
        files().remove(folder);
    }

    /// Takes all files out of memory.
    pub fn clear() {
        *files() = Files::NONE;
    }

    /// Reads all bytes of a file.
    pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
        files().get(path).map(<[u8]>::to_vec)
    }

    /// Reads a file to its end, or the first `largest` + 1 bytes of one that has more than `largest`.
    pub(crate) fn read_up_to(path: &Path, largest: u64) -> Result<Vec<u8>> {
        let end = usize::try_from(largest.saturating_add(1)).unwrap_or(usize::MAX);
        files().get(path).map(|bytes| bytes[..bytes.len().min(end)].to_vec())
    }

    /// Tells what a path leads to.
    pub(crate) fn entry(path: &Path) -> Result<Entry> {
        files().entry(path)
    }

    /// Absolute path of what is there.
    pub(crate) fn canonicalize(path: &Path) -> Result<PathBuf> {
        files().entry(path).map(|_| normal(path))
    }

    /// Absolute path of what need not be there.
    pub(crate) fn absolute(path: &Path) -> Result<PathBuf> {
        Ok(normal(path))
    }

    /// Names of what is in a folder.
    pub(crate) fn names(folder: &Path) -> Result<Vec<OsString>> {
        Ok(files().names(folder))
    }
}

#[cfg(target_family = "wasm")]
pub(crate) use global::{absolute, canonicalize, entry, names, read, read_up_to};
#[cfg(target_family = "wasm")]
pub use global::{clear, put, remove};

#[cfg(test)]
mod tests {
    use super::*;

    /// The same files in memory and on the disk.
    fn both() -> (Files, tempfile::TempDir) {
        let (mut memory, disk) = (Files::NONE, tempfile::tempdir().unwrap());
        for path in ["scan.obj", "tex/skin.png", "tex/more/a.png"] {
            memory.put(Path::new(path), path.into());
            let path = disk.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, path.strip_prefix(disk.path()).unwrap().to_str().unwrap()).unwrap();
        }
        (memory, disk)
    }

    #[test]
    fn files_in_memory_are_found_as_on_a_disk() {
        let (memory, disk) = both();
        for path in
            ["scan.obj", "tex", "tex/../scan.obj", "./tex//skin.png", "Scan.obj", "tex/more", "none", "tex/more/a"]
        {
            let (there, here) = (super::super::native::entry(&disk.path().join(path)), memory.entry(Path::new(path)));
            let kinds = [&there, &here].map(|entry| entry.as_ref().ok().copied());
            assert_eq!(kinds[0], kinds[1], "{path}");
            if let (Err(there), Err(here)) = (there, here) {
                assert_eq!(there.to_string().split(" (os").next(), Some(here.to_string().as_str()), "{path}");
            }
        }
        for folder in ["tex", "tex/more", "."] {
            let mut there = super::super::native::names(&disk.path().join(folder)).unwrap();
            there.sort();
            assert_eq!(there, memory.names(Path::new(folder)), "{folder}");
        }
    }

    #[test]
    fn a_folder_is_removed_with_all_that_is_below_it() {
        let (mut memory, _disk) = both();
        memory.put(Path::new("text"), Vec::new());
        memory.remove(Path::new("./tex"));
        assert_eq!(memory.names(Path::new("/")), ["scan.obj", "text"]);
        assert!(memory.entry(Path::new("tex")).is_err());
    }

    #[test]
    fn nothing_is_above_the_root_and_an_empty_path_leads_nowhere() {
        let (memory, _disk) = both();
        assert_eq!(memory.get(Path::new("../../scan.obj")).unwrap(), b"scan.obj");
        assert_eq!(normal(Path::new("/a/./b/../c")), Path::new("/a/c"));
        assert!(memory.entry(Path::new("")).is_err());
    }
}
