//! Files that appear whole or not at all: written beside their place, then renamed.

use crate::failure::Failure;
use crate::input::plain;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A folder that outputs go to; made where it is missing, taken away again if nothing came of it.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    made: Option<PathBuf>,
}

impl Folder {
    /// Makes sure that files can be written, before any work is done.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        if path.exists() && !path.is_dir() {
            return Err(Failure::at(path, "is a file, and a folder is needed here"));
        }
        // The topmost folder that is missing is what has to go if this fails.
        let missing = path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).last();
        let made = missing.map(Path::to_path_buf);
        std::fs::create_dir_all(path).map_err(|e| Failure::at(path, format!("cannot be made: {}", plain(&e))))?;
        let folder = Self { path: path.to_path_buf(), made };
        folder.temporary()?;
        Ok(folder)
    }

    /// Its place.
    pub fn path(&self) -> &Path {
        here_if_empty(&self.path)
    }

    fn temporary(&self) -> Result<NamedTempFile, Failure> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".planish-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // As any new file; the umask takes its share.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let refused = |e| Failure::at(self.path(), format!("cannot be written to: {}", plain(&e)));
        builder.tempfile_in(self.path()).map_err(refused)
    }

    /// A file beside its place, without its name.
    fn stage(&self, place: &Path, bytes: &[u8]) -> Result<NamedTempFile, Failure> {
        if place.is_dir() {
            return Err(Failure::at(place, "is a directory, and a file has to go there"));
        }
        let mut file = self.temporary()?;
        file.write_all(bytes).and_then(|()| file.flush()).map_err(|e| refused(place, &e))?;
        Ok(file)
    }

    /// Writes all files, then gives all of them their names.
    pub fn write<'a>(mut self, files: impl IntoIterator<Item = (&'a Path, &'a [u8])>) -> Result<Vec<PathBuf>, Failure> {
        let mut staged = Vec::new();
        for (name, bytes) in files {
            let place = self.path.join(name);
            staged.push((self.stage(&place, bytes)?, place));
        }
        let mut places = Vec::new();
        for (file, place) in staged {
            file.persist(&place).map_err(|e| refused(&place, &e.error))?;
            places.push(place);
        }
        self.made = None;
        Ok(places)
    }
}

fn refused(place: &Path, e: &std::io::Error) -> Failure {
    Failure::at(place, format!("cannot be written: {}", plain(e)))
}

/// The folder of a file that is named without one.
fn here_if_empty(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if let Some(made) = &self.made {
            // Only empty folders, innermost first: what somebody else put there meanwhile stays.
            for folder in self.path.ancestors() {
                if std::fs::remove_dir(folder).is_err() || folder == made {
                    break;
                }
            }
        }
    }
}

/// Refuses to write over an input.
pub fn spare(place: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    if inputs.iter().any(|input| same_file(input.as_ref(), place)) {
        return Err(Failure::at(place, "is an input; name another output, so that nothing is lost"));
    }
    Ok(())
}

/// Whether both are there and one.
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// A single output file.
#[derive(Debug)]
pub struct Output {
    place: PathBuf,
    /// None where a pipe or a device is written to, such as /dev/stdout: renaming would replace it.
    folder: Option<Folder>,
}

impl Output {
    /// Makes sure that the file can be written and is none of the inputs.
    pub fn open(place: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
        if place.is_dir() {
            return Err(Failure::at(place, "is a directory; name a file"));
        }
        spare(place, inputs)?;
        if place.file_name().is_none() {
            return Err(Failure::at(place, "names no file"));
        }
        let special = place.metadata().is_ok_and(|m| !m.is_file());
        let folder = (!special).then(|| Folder::open(place.parent().unwrap_or(Path::new("")))).transpose()?;
        Ok(Self { place: place.to_path_buf(), folder })
    }

    /// Writes the file and says where.
    pub fn write(self, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let place = self.place.clone();
        write_all(vec![(self, bytes.to_vec())])?;
        Ok(place)
    }
}

/// Writes all files, wherever they are, then gives all of them their names.
pub fn write_all(files: Vec<(Output, Vec<u8>)>) -> Result<(), Failure> {
    let mut staged = Vec::new();
    for (output, bytes) in &files {
        staged.push(output.folder.as_ref().map(|folder| folder.stage(&output.place, bytes)).transpose()?);
    }
    for ((output, bytes), staged) in files.into_iter().zip(staged) {
        let Output { place, folder } = output;
        let done = match staged {
            Some(file) => file.persist(&place).map(drop).map_err(|e| e.error),
            None => std::fs::OpenOptions::new().write(true).open(&place).and_then(|mut f| f.write_all(&bytes)),
        };
        done.map_err(|e| refused(&place, &e))?;
        if let Some(mut folder) = folder {
            folder.made = None;
        }
    }
    Ok(())
}
