//! Files and folders that have to go if the program ends in the middle of its work.
//!
//! Values remove what they made when they are dropped. A program that is told to end at once drops nothing, so what exists
//! under a temporary name is listed here as well.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Something that is not finished.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Unfinished {
    /// A file under a temporary name.
    File(PathBuf),
    /// A new folder up to the topmost one that is new, which goes if it is empty.
    Folder { innermost: PathBuf, topmost: PathBuf },
}

static UNFINISHED: Mutex<Vec<(u64, Unfinished)>> = Mutex::new(Vec::new());

fn list() -> MutexGuard<'static, Vec<(u64, Unfinished)>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An entry of the list, which leaves the list when it is dropped.
#[derive(Debug)]
pub(crate) struct Entry(u64);

impl Entry {
    fn new(what: Unfinished) -> Self {
        let mut list = list();
        let number = list.last().map_or(0, |(number, _)| number + 1);
        list.push((number, what));
        Self(number)
    }
    /// Lists a file under a temporary name.
    pub(crate) fn file(path: &Path) -> Self {
        Self::new(Unfinished::File(path.to_path_buf()))
    }
    /// Lists a new folder, and all new folders above it up to `topmost`.
    pub(crate) fn folder(innermost: &Path, topmost: &Path) -> Self {
        Self::new(Unfinished::Folder { innermost: innermost.to_path_buf(), topmost: topmost.to_path_buf() })
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        list().retain(|(number, _)| *number != self.0);
    }
}

/// Removes empty folders from `innermost` up to `topmost`. Folders with files that somebody else wrote meanwhile stay.
pub(crate) fn remove_folders(innermost: &Path, topmost: &Path) {
    for folder in innermost.ancestors() {
        let is_gone = match std::fs::remove_dir(folder) {
            Ok(()) => true,
            Err(e) => e.kind() == std::io::ErrorKind::NotFound,
        };
        if !is_gone || folder == topmost {
            break;
        }
    }
}

/// True once files have been renamed into place.
static COMMITTED: AtomicBool = AtomicBool::new(false);

/// Renames files into place, during which the program does not end.
pub(crate) fn commit<T>(rename: impl FnOnce() -> T) -> T {
    undisturbed(|| {
        COMMITTED.store(true, Ordering::Relaxed);
        rename()
    })
}

/// Returns true once files have been renamed into place.
pub(crate) fn has_committed() -> bool {
    COMMITTED.load(Ordering::Relaxed)
}

fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    static COMMIT: Mutex<()> = Mutex::new(());
    let _guard = COMMIT.lock().unwrap_or_else(PoisonError::into_inner);
    work()
}

/// Removes all that is unfinished, files before folders, and keeps others from finishing anything: the caller ends the program.
pub(crate) fn give_up(end: impl FnOnce()) {
    undisturbed(|| {
        remove(&std::mem::take(&mut *list()));
        end();
    });
}

/// Does the same without waiting for anybody, because nobody can go on.
pub(crate) fn give_up_now(end: impl FnOnce()) {
    if let Ok(mut list) = UNFINISHED.try_lock() {
        remove(&std::mem::take(&mut *list));
    }
    end();
}

fn remove(list: &[(u64, Unfinished)]) {
    for (_, unfinished) in list.iter().rev() {
        if let Unfinished::File(path) = unfinished {
            let _ = std::fs::remove_file(path);
        }
    }
    for (_, unfinished) in list.iter().rev() {
        if let Unfinished::Folder { innermost, topmost } = unfinished {
            remove_folders(innermost, topmost);
        }
    }
}
