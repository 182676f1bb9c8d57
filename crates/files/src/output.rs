//! Writes files whole or not at all: under a temporary name in the same folder first, then renamed.

use crate::compression;
use crate::failure::Failure;
use crate::input::plain;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A folder for outputs. It is created if it is missing, and removed again if nothing was written to it.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Topmost folder that was created, and has to be removed if nothing is written.
    created: Option<PathBuf>,
}

impl Folder {
    /// Creates the folder if it is missing, and checks before any work is done that files can be written to it.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        if path.exists() && !path.is_dir() {
            return Err(Failure::at(path, "is a file, and a folder is needed here"));
        }
        let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).last();
        let created = missing.map(Path::to_path_buf);
        std::fs::create_dir_all(path).map_err(|e| Failure::at(path, format!("cannot be created: {}", plain(&e))))?;
        let folder = Self { path: path.to_path_buf(), created };
        folder.temporary()?;
        Ok(folder)
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        here_if_empty(&self.path)
    }

    /// Creates an empty file with a temporary name in the folder.
    fn temporary(&self) -> Result<NamedTempFile, Failure> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".planish-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // These are the permissions of any new file, before the umask.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let refused = |e| Failure::at(self.path(), format!("cannot be written to: {}", plain(&e)));
        builder.tempfile_in(self.path()).map_err(refused)
    }

    /// Writes a file under a temporary name, ready to be renamed to `path`.
    fn stage(&self, path: &Path, bytes: &[u8]) -> Result<NamedTempFile, Failure> {
        if path.is_dir() {
            return Err(Failure::at(path, "is a directory, and a file has to go there"));
        }
        let mut file = self.temporary()?;
        file.write_all(bytes).and_then(|()| file.flush()).map_err(|e| refused(path, &e))?;
        Ok(file)
    }

    /// Writes all files under temporary names, then renames them, and returns their paths.
    pub fn write<'a>(mut self, files: impl IntoIterator<Item = (&'a Path, &'a [u8])>) -> Result<Vec<PathBuf>, Failure> {
        let mut staged = Vec::new();
        for (name, bytes) in files {
            let path = self.path.join(name);
            staged.push((self.stage(&path, bytes)?, path));
        }
        let mut written = Vec::new();
        for (file, path) in staged {
            file.persist(&path).map_err(|e| refused(&path, &e.error))?;
            written.push(path);
        }
        self.created = None;
        Ok(written)
    }
}

/// Makes the error of a file that cannot be written.
fn refused(path: &Path, e: &std::io::Error) -> Failure {
    Failure::at(path, format!("cannot be written: {}", plain(e)))
}

/// Returns the working folder for an empty path: the parent of a file that is named without a folder.
fn here_if_empty(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Some(created) = &self.created {
            // Only empty folders are removed, innermost first: files that somebody else wrote meanwhile stay.
            for folder in self.path.ancestors() {
                if std::fs::remove_dir(folder).is_err() || folder == created {
                    break;
                }
            }
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

/// Returns whether two paths lead to one existing file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// A single output file.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    /// Folder of the file; `None` for a pipe or a device such as /dev/stdout, which renaming would replace.
    folder: Option<Folder>,
}

impl Output {
    /// Checks before any work is done that the file can be written and is none of the inputs.
    pub fn open(path: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
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
        let special = path.metadata().is_ok_and(|m| !m.is_file());
        let folder = (!special).then(|| Folder::open(path.parent().unwrap_or(Path::new("")))).transpose()?;
        Ok(Self { path: path.to_path_buf(), folder })
    }

    /// Writes the file and returns its path.
    pub fn write(self, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let path = self.path.clone();
        write_all(vec![(self, bytes.to_vec())])?;
        Ok(path)
    }
}

/// Writes files in any folders under temporary names, then renames all of them.
pub fn write_all(files: Vec<(Output, Vec<u8>)>) -> Result<(), Failure> {
    let mut staged = Vec::new();
    for (output, bytes) in &files {
        staged.push(output.folder.as_ref().map(|folder| folder.stage(&output.path, bytes)).transpose()?);
    }
    for ((output, bytes), staged) in files.into_iter().zip(staged) {
        let Output { path, folder } = output;
        let done = match staged {
            Some(file) => file.persist(&path).map(drop).map_err(|e| e.error),
            None => std::fs::OpenOptions::new().write(true).open(&path).and_then(|mut f| f.write_all(&bytes)),
        };
        done.map_err(|e| refused(&path, &e))?;
        if let Some(mut folder) = folder {
            folder.created = None;
        }
    }
    Ok(())
}
