//! Files that appear whole or not at all: written beside their place, then renamed.

use crate::failure::Failure;
use crate::input::plain;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A folder that outputs go to; made where it is missing, taken away again if nothing came of it.
pub(crate) struct Folder {
    path: PathBuf,
    made: Option<PathBuf>,
}

impl Folder {
    /// Makes sure that files can be written, before any work is done.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
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

    pub(crate) fn path(&self) -> &Path {
        &self.path
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
        let refused = |e| Failure::at(&self.path, format!("cannot be written to: {}", plain(&e)));
        builder.tempfile_in(&self.path).map_err(refused)
    }

    /// Writes all files, then gives all of them their names.
    pub(crate) fn write<'a>(
        mut self,
        files: impl IntoIterator<Item = (&'a str, &'a [u8])>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut staged = Vec::new();
        for (name, bytes) in files {
            let place = self.path.join(name);
            let refused = |e: std::io::Error| Failure::at(&place, format!("cannot be written: {}", plain(&e)));
            if place.is_dir() {
                return Err(Failure::at(&place, "is a directory, and a file has to go there"));
            }
            let mut file = self.temporary()?;
            file.write_all(bytes).and_then(|()| file.flush()).map_err(refused)?;
            staged.push((file, place));
        }
        let mut places = Vec::new();
        for (file, place) in staged {
            file.persist(&place).map_err(|e| Failure::at(&place, format!("cannot be written: {}", plain(&e.error))))?;
            places.push(place);
        }
        self.made = None;
        Ok(places)
    }
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

/// A single output file.
pub(crate) struct Output {
    folder: Folder,
    place: PathBuf,
}

impl Output {
    /// Makes sure that the file can be written and is none of the inputs.
    pub(crate) fn open(place: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
        if place.is_dir() {
            return Err(Failure::at(place, "is a directory; name a file"));
        }
        let same = |input: &&&Path| matches!((input.canonicalize(), place.canonicalize()), (Ok(a), Ok(b)) if a == b);
        if inputs.iter().find(same).is_some() {
            return Err(Failure::at(place, "is an input; name another output, so that nothing is lost"));
        }
        if place.file_name().is_none() {
            return Err(Failure::at(place, "names no file"));
        }
        let folder = Folder::open(place.parent().unwrap_or(Path::new("")))?;
        Ok(Self { folder, place: place.to_path_buf() })
    }

    pub(crate) fn write(self, bytes: &[u8]) -> Result<PathBuf, Failure> {
        let special = self.place.metadata().is_ok_and(|m| !m.is_file());
        if special {
            // A pipe or a device, such as /dev/stdout: renaming would replace it.
            let refused = |e: std::io::Error| Failure::at(&self.place, format!("cannot be written: {}", plain(&e)));
            std::fs::OpenOptions::new()
                .write(true)
                .open(&self.place)
                .and_then(|mut f| f.write_all(bytes))
                .map_err(refused)?;
            return Ok(self.place);
        }
        let name = self.place.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(self.folder.write([(name.as_str(), bytes)])?.remove(0))
    }
}
