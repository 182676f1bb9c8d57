//! Writes files whole or not at all: under a temporary name in the same folder first, then renamed.
//!
//! ```
//! use planish_files::output::Output;
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("results/denoised.obj");
//! // The output is checked before the work begins. If the work fails, nothing is left behind.
//! drop(Output::open(&path, &[])?);
//! assert!(!path.parent().unwrap().exists());
//!
//! Output::open(&path, &[])?.write(b"v 0 0 0\n")?;
//! assert_eq!(std::fs::read(&path)?, b"v 0 0 0\n");
//! let failure = Output::open(&path, &[&path]).unwrap_err();
//! assert!(failure.to_string().ends_with("is an input; name another output, so that nothing is lost"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod lock;
mod place;

pub use crate::disk::same_file;

use crate::cleanup;
use crate::compression;
use crate::failure::Failure;
use crate::input::plain;
use crate::terminal;
use crate::text::shown;
use lock::{Lock, Sharing};
use place::{Place, Replaced};
use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The files of an earlier bundle in a folder.
#[derive(Debug, Default)]
pub(crate) struct Earlier {
    /// Names of files that may be replaced.
    pub(crate) replaceable: HashSet<PathBuf>,
    /// Paths of files that the new bundle does not have, and nobody has changed since.
    pub(crate) obsolete: Vec<PathBuf>,
}

/// A folder for outputs. It is created if it is missing, and removed again if nothing was written to it.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Topmost folder that was created, and has to be removed if nothing is written.
    created: Option<(PathBuf, cleanup::Entry)>,
}

impl Folder {
    /// Creates the folder if it is missing, and checks before any work is done that files can be written to it.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        if path.exists() && !path.is_dir() {
            return Err(Failure::at(path, "is a file, and a folder is needed here"));
        }
        let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).last();
        let created = missing.map(|topmost| (topmost.to_path_buf(), cleanup::Entry::folder(path, topmost)));
        let folder = Self { path: path.to_path_buf(), created };
        create(path).map_err(|e| refusal(path, "cannot be created", &e))?;
        temporary(folder.path())?;
        Ok(folder)
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        here_if_empty(&self.path)
    }

    /// Writes all files under temporary names, then renames them in their order, and returns their paths.
    pub fn write<'a>(mut self, files: impl IntoIterator<Item = (&'a Path, &'a [u8])>) -> Result<Vec<PathBuf>, Failure> {
        let _lock = Lock::acquire(self.path(), Sharing::Alone)?;
        let staged = stage(&self.path, files)?;
        self.rename(staged)
    }

    /// Writes the files of a bundle, the manifest last. `earlier` finds the files of an earlier bundle, once nobody else writes.
    pub(crate) fn write_bundle<'a>(
        self,
        files: &[(&'a Path, &'a [u8])],
        earlier: impl FnOnce() -> Earlier,
    ) -> Result<Vec<PathBuf>, Failure> {
        let names: Vec<&Path> = files.iter().map(|(name, _)| *name).collect();
        let is_same = |name: &Path, path: &Path| {
            let bytes = files.iter().find(|(new, _)| *new == name).map(|(_, bytes)| *bytes);
            std::fs::read(path).is_ok_and(|there| Some(there.as_slice()) == bytes)
        };
        self.write_staged(&names, earlier, is_same, |folder| stage(folder, files.iter().copied()))
    }

    /// Writes the files of a bundle as [`Self::write_bundle`] does. `stage` writes them under temporary names to the folder that it is
    /// given, in the order of `names`; `is_same` says whether the file of a name that is there already is what will be written.
    pub(crate) fn write_staged(
        mut self,
        names: &[&Path],
        earlier: impl FnOnce() -> Earlier,
        is_same: impl Fn(&Path, &Path) -> bool,
        stage: impl FnOnce(&Path) -> Result<Vec<Staged>, Failure>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut lock = Lock::acquire(self.path(), Sharing::Alone)?;
        let earlier = earlier();
        for name in names {
            let path = self.path.join(name);
            let interrupted =
                lock.as_ref().is_some_and(|lock| lock.interrupted().iter().any(|n| Path::new(n) == *name));
            if path.symlink_metadata().is_ok()
                && !path.is_dir()
                && !interrupted
                && !earlier.replaceable.contains(*name)
                && !is_same(name, &path)
            {
                let reason = "exists and is not a file of an earlier bake; remove it, or name another folder with -o";
                return Err(Failure::at(&path, reason));
            }
        }
        if let Some(lock) = &mut lock {
            lock.note(&names.iter().filter_map(|name| name.to_str()).collect::<Vec<_>>());
        }
        let staged = stage(&self.path)?;
        let written = self.rename(staged)?;
        if let Some(lock) = &mut lock {
            lock.settle();
        }
        for path in earlier.obsolete {
            let _ = std::fs::remove_file(path);
        }
        Ok(written)
    }

    /// Gives files their names, in their order, and returns their paths.
    fn rename(&mut self, staged: Vec<Staged>) -> Result<Vec<PathBuf>, Failure> {
        let written = staged.iter().map(|staged| staged.path.clone()).collect();
        cleanup::commit(|| staged.into_iter().try_for_each(Staged::persist))?;
        sync_folder(self.path());
        self.created = None;
        Ok(written)
    }
}

/// Writes files under temporary names to a folder.
fn stage<'a>(folder: &Path, files: impl IntoIterator<Item = (&'a Path, &'a [u8])>) -> Result<Vec<Staged>, Failure> {
    files.into_iter().map(|(name, bytes)| Staged::new(&folder.join(name), [bytes])).collect()
}

/// Creates an empty file with a temporary name in a folder.
fn temporary(folder: &Path) -> Result<NamedTempFile, Failure> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(lock::PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // These are the permissions of any new file, before the umask.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = again_if_gone(|| match builder.tempfile_in(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            create(folder)?;
            builder.tempfile_in(folder)
        }
        done => done,
    });
    file.map_err(|e| refusal(folder, "cannot be written to", &e))
}

/// Creates a folder and those above it, as far as they are missing.
fn create(folder: &Path) -> std::io::Result<()> {
    again_if_gone(|| std::fs::create_dir_all(folder))
}

/// Tries again where a folder is not found: whoever had made it and has failed removes it while it is empty.
fn again_if_gone<T>(mut work: impl FnMut() -> std::io::Result<T>) -> std::io::Result<T> {
    /// Number of further tries. Each needs somebody else who fails just then.
    const TRIES: usize = 20;
    for _ in 0..TRIES {
        match work() {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
            done => return done,
        }
    }
    work()
}

/// A file under a temporary name, with its content on the disk, ready to be renamed.
#[derive(Debug)]
pub(crate) struct Staged {
    file: NamedTempFile,
    /// Path under which the file was asked for.
    path: PathBuf,
    /// Path that it is renamed to, behind all links.
    target: PathBuf,
    entry: cleanup::Entry,
}

impl Staged {
    /// Writes a file that will replace the one that `path` leads to, and keeps its permissions.
    pub(crate) fn new<'a>(path: &Path, pieces: impl IntoIterator<Item = &'a [u8]>) -> Result<Self, Failure> {
        let mut staged = Self::begin(path)?;
        pieces.into_iter().try_for_each(|bytes| staged.append(bytes))?;
        staged.settle()?;
        Ok(staged)
    }

    /// Begins a file that will replace the one that `path` leads to, and keeps its permissions.
    pub(crate) fn begin(path: &Path) -> Result<Self, Failure> {
        let target = match Place::of(path).map_err(|e| unwritable(path, &e))? {
            Place::File(target) => target,
            Place::Stdout | Place::Device(_) => {
                return Err(Failure::at(path, "is a device, and a file has to go there"));
            }
        };
        let replaced = Replaced::at(&target)?;
        let file = temporary(here_if_empty(target.parent().unwrap_or(Path::new(""))))?;
        let entry = cleanup::Entry::file(file.path());
        if let Some(replaced) = replaced {
            // Before anything is written: what was private is so at any time.
            let kept = file.as_file().set_permissions(replaced.permissions());
            kept.map_err(|e| unwritable(path, &e))?;
            replaced.keep_owner(file.as_file());
        }
        Ok(Self { file, path: path.to_path_buf(), target, entry })
    }

    /// Appends bytes.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file.write_all(bytes).map_err(|e| unwritable(&self.path, &e))
    }

    /// Brings the content to the disk.
    pub(crate) fn settle(&mut self) -> Result<(), Failure> {
        self.file.flush().map_err(|e| unwritable(&self.path, &e))?;
        // Otherwise a power cut could leave the new name with no content. Some file systems cannot, which is no failure.
        match self.file.as_file().sync_all() {
            Err(e) if is_full(&e) => Err(unwritable(&self.path, &e)),
            _ => Ok(()),
        }
    }

    /// Gives a file that was written in pieces its name.
    pub(crate) fn finish(mut self) -> Result<(), Failure> {
        self.settle()?;
        cleanup::commit(|| self.persist())
    }

    fn persist(self) -> Result<(), Failure> {
        let Self { file, path, target, entry } = self;
        file.persist(&target).map_err(|e| unwritable(&path, &e.error))?;
        drop(entry);
        Ok(())
    }
}

/// Makes the names of new files lasting, where the file system can.
fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    #[cfg(not(unix))]
    let _ = folder;
}

/// Returns true if there is no space left, which is nobody's fault.
fn is_full(e: &std::io::Error) -> bool {
    use std::io::ErrorKind::{FileTooLarge, OutOfMemory, QuotaExceeded, StorageFull};
    matches!(e.kind(), StorageFull | QuotaExceeded | FileTooLarge | OutOfMemory)
}

/// Makes the error of a place that refuses to be written: an error of the input where another place would help.
fn refusal(path: &Path, what: &str, e: &std::io::Error) -> Failure {
    let text = format!("{}: {what}: {}", shown(path), plain(e));
    if is_full(e) { Failure::Internal(text) } else { Failure::Input(text) }
}

/// Makes the error of a file that cannot be written.
fn unwritable(path: &Path, e: &std::io::Error) -> Failure {
    refusal(path, "cannot be written", e)
}

/// Returns the working folder for an empty path: the parent of a file that is named without a folder.
fn here_if_empty(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Some((topmost, _)) = &self.created {
            cleanup::remove_folders(&self.path, topmost);
        }
    }
}

/// Fails if `path` is one of the inputs, however either is spelt.
pub fn refuse_overwrite(path: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    if inputs.iter().any(|input| same_file(input.as_ref(), path)) {
        return Err(Failure::at(path, "is an input; name another output, so that nothing is lost"));
    }
    Ok(())
}

/// A single output: a file, a device, or standard output.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    place: Place,
    /// Folder of the file; `None` for other outputs.
    folder: Option<Folder>,
}

impl Output {
    /// Checks before any work is done that the output can be written and is none of the inputs. `-` is standard output.
    pub fn open(path: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
        let place = Place::of(path).map_err(|e| unwritable(path, &e))?;
        if place == Place::Stdout {
            refuse_overwrite(Path::new("/dev/stdout"), inputs)?;
            return Ok(Self { path: path.to_path_buf(), place, folder: None });
        }
        if path.is_dir() {
            return Err(Failure::at(path, "is a directory; name a file"));
        }
        refuse_overwrite(path, inputs)?;
        if compression::is_only_read(path) {
            return Err(Failure::at(path, "xz files are read, but not written; use .gz"));
        }
        if path.file_name().is_none() {
            return Err(Failure::at(path, "names no file"));
        }
        let folder = match &place {
            Place::File(target) => {
                let folder = Folder::open(target.parent().unwrap_or(Path::new("")))?;
                Replaced::at(target)?;
                Some(folder)
            }
            Place::Stdout | Place::Device(_) => None,
        };
        Ok(Self { path: path.to_path_buf(), place, folder })
    }

    /// Path of the file, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns true if this is standard output, to which nothing else should go.
    pub fn is_stdout(&self) -> bool {
        self.place == Place::Stdout
    }

    /// Writes the file and returns its path.
    pub fn write(self, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let path = self.path.clone();
        write_all(vec![(self, bytes.to_vec())])?;
        Ok(path)
    }
}

/// Writes files in any folders under temporary names, then renames all of them, and writes to devices and standard output last.
pub fn write_all(files: Vec<(Output, Vec<u8>)>) -> Result<(), Failure> {
    write_all_in_pieces(files.into_iter().map(|(output, bytes)| (output, vec![bytes.into()])).collect())
}

/// Writes files as [`write_all`] does, each of which is given in pieces.
pub fn write_all_in_pieces(files: Vec<(Output, Vec<Cow<'_, [u8]>>)>) -> Result<(), Failure> {
    let (mut staged, mut locks) = (Vec::new(), Vec::new());
    for (output, pieces) in &files {
        if let Some(folder) = &output.folder {
            locks.push(Lock::acquire(folder.path(), Sharing::Together)?);
            staged.push(Staged::new(&output.path, pieces.iter().map(AsRef::as_ref))?);
        }
    }
    if !staged.is_empty() {
        cleanup::commit(|| staged.into_iter().try_for_each(Staged::persist))?;
    }
    drop(locks);
    for (output, pieces) in files {
        let Output { path, place, folder } = output;
        match place {
            Place::File(_) => {}
            Place::Stdout => pieces.iter().try_for_each(|bytes| terminal::print(bytes))?,
            Place::Device(target) => {
                let done = place::open_device(&target)
                    .and_then(|mut device| pieces.iter().try_for_each(|bytes| device.write_all(bytes)));
                done.map_err(|e| unwritable(&path, &e))?;
            }
        }
        if let Some(mut folder) = folder {
            sync_folder(folder.path());
            folder.created = None;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_another_output_made_and_removes_stays_for_this_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new").join("mesh.obj");
        let given_up = Output::open(&path.with_file_name("failed.obj"), &[]).unwrap();
        let output = Output::open(&path, &[]).unwrap();
        drop(given_up);
        assert!(!path.parent().unwrap().exists());
        output.write(b"v 0 0 0\n").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"v 0 0 0\n");
    }
}
