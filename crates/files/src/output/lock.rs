//! Lock of a folder while files are written to it, so that two programs never mix their files, and so that the temporary files of
//! a program that was killed can be told from those of one that is still writing.
//!
//! The lock is a file in the folder, which the operating system unlocks when its program ends, however it ends. While a bundle is
//! renamed into place, that file lists the names; if the program is killed then, the next one knows whose these files are.

use crate::failure::Failure;
use crate::terminal;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Prefix of the names of temporary files, and of the lock itself.
pub(super) const PREFIX: &str = ".planish-";
/// Name of the lock.
const NAME: &str = ".planish-lock";
/// Time after which another program that holds the lock is taken for stuck.
const PATIENCE: Duration = Duration::from_secs(60);

/// Whether other programs may write to the folder meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sharing {
    /// Nobody else may write: the files belong together.
    Alone,
    /// Others may write single files too.
    Together,
}

/// A lock that is held. It is removed when this value is dropped, unless others hold it too.
#[derive(Debug)]
pub(super) struct Lock {
    file: File,
    path: PathBuf,
    /// Names that a program was renaming into place when it was killed.
    interrupted: Vec<String>,
}

impl Lock {
    /// Waits for the lock of a folder. `None` where the file system has no locks; then everything works as if one were alone.
    /// Whoever has the folder for himself removes what killed programs left there.
    pub(super) fn acquire(folder: &Path, sharing: Sharing) -> Result<Option<Self>, Failure> {
        let path = folder.join(NAME);
        let start = Instant::now();
        loop {
            let Some(file) = open(&path) else { return Ok(None) };
            let is_alone = match file.try_lock() {
                Ok(()) => true,
                Err(TryLockError::Error(_)) => return Ok(None),
                Err(TryLockError::WouldBlock) => false,
            };
            let is_held = is_alone || (sharing == Sharing::Together && file.try_lock_shared().is_ok());
            // Whoever held the lock before may have removed it meanwhile.
            if is_held && is_same(&file, &path) {
                let mut lock = Self { file, path, interrupted: Vec::new() };
                if is_alone {
                    lock.interrupted = lock.names();
                    remove_stale(folder);
                    if sharing == Sharing::Together {
                        // The names have to stay for the next bake; if others take the lock for themselves, this is not held.
                        let _ = lock.file.lock_shared();
                    }
                }
                return Ok(Some(lock));
            }
            terminal::check_interrupt()?;
            if start.elapsed() > PATIENCE {
                return Err(Failure::Internal(format!(
                    "{}: another planish has been writing to this folder for a minute; nothing was written",
                    crate::text::shown(folder)
                )));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Names that a killed program was renaming into place, so that these files are those of a bake.
    pub(super) fn interrupted(&self) -> &[String] {
        &self.interrupted
    }

    /// Notes the names that are about to be renamed into place.
    pub(super) fn note(&mut self, names: &[&str]) {
        let all = names.iter().copied().chain(self.interrupted.iter().map(String::as_str));
        let text: String = all.map(|name| format!("{name}\n")).collect();
        // Without the note the files of a killed program are taken for the user's own, which is safe.
        if let Ok(mut file) = OpenOptions::new().write(true).truncate(true).open(&self.path) {
            let _ = file.write_all(text.as_bytes()).and_then(|()| file.sync_data());
        }
    }

    /// Forgets the names: all files are in place.
    pub(super) fn settle(&mut self) {
        self.interrupted.clear();
    }

    fn names(&self) -> Vec<String> {
        let mut text = String::new();
        let _ = (&self.file).take(1 << 16).read_to_string(&mut text);
        text.lines().map(str::to_owned).collect()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A lock with names of a killed bake stays until the next bake, which removes them.
        let has_note = !self.interrupted.is_empty();
        if !has_note && self.file.try_lock().is_ok() && is_same(&self.file, &self.path) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Opens the lock, and creates it if it is missing; `None` if that is impossible, or if something else has its name.
fn open(path: &Path) -> Option<File> {
    use std::io::ErrorKind::{AlreadyExists, NotFound};
    loop {
        match OpenOptions::new().read(true).write(true).create_new(true).open(path) {
            Ok(file) => return Some(file),
            Err(e) if e.kind() == AlreadyExists => {}
            // Whoever had made the folder has failed and removed it.
            Err(e) if e.kind() == NotFound => {
                std::fs::create_dir_all(path.parent()?).ok()?;
                continue;
            }
            Err(_) => return None,
        }
        match path.symlink_metadata().and_then(|there| there.is_file().then(|| File::open(path)).transpose()) {
            Ok(file) => return file,
            // Whoever held the lock has removed it meanwhile.
            Err(e) if e.kind() == NotFound => {}
            Err(_) => return None,
        }
    }
}

/// Returns true if the file that is open is still the one of that name.
#[cfg(unix)]
fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let id = |m: std::io::Result<std::fs::Metadata>| m.map(|m| (m.dev(), m.ino())).ok();
    id(file.metadata()).is_some_and(|open| id(path.symlink_metadata()) == Some(open))
}

/// Returns true if the file that is open is still the one of that name.
#[cfg(not(unix))]
fn is_same(_: &File, path: &Path) -> bool {
    path.is_file()
}

/// Removes the temporary files of programs that were killed; nobody else is writing to the folder.
fn remove_stale(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_temporary = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name != NAME);
        if is_temporary && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_that_others_remove_meanwhile_is_held_all_the_same() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..2000 {
                        assert!(Lock::acquire(folder.path(), Sharing::Together).unwrap().is_some());
                    }
                });
            }
        });
    }
}
