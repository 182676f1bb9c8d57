//! Files that another file names, and the rule on where they may lie.

use crate::disk::{self, Entry};
use crate::failure::Failure;
use crate::text::plain;
use std::path::{Path, PathBuf};

/// Rule on the files that another file may name: libraries and textures by a mesh, all files of a map by its manifest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Files are read from the folder of the file that names them, and from the folders below.
    #[default]
    Folder,
    /// Files are read from anywhere.
    Anywhere,
}

/// Bytes of a material library that are read at most.
pub const LARGEST_LIBRARY: u64 = 64 << 20;
/// Bytes of a picture that are read at most, if a file names it.
pub const LARGEST_PICTURE: u64 = 1 << 30;
/// Bytes of a file of weights that are read at most.
pub const LARGEST_WEIGHTS: u64 = 64 << 20;
/// Bytes of a mesh that are read at most, if a manifest names it.
pub const LARGEST_MESH: u64 = 16 << 30;

/// A file that another file names, and the rule for reading it.
#[derive(Clone, Copy, Debug)]
pub struct NamedFile<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Folder of the file that names it.
    pub folder: &'a Path,
    /// Rule on where the file may lie.
    pub trust: Trust,
    /// Largest number of bytes.
    pub largest: u64,
}

impl NamedFile<'_> {
    /// Checks the rule without reading the file: it has to be a plain file that is not too large and, by [`Trust::Folder`], lie in
    /// the folder or below, all links followed. Returns the path that was checked.
    pub fn check(&self) -> Result<PathBuf, Failure> {
        let Self { path, folder, trust, largest } = *self;
        let failed = |e: std::io::Error| Failure::at(path, plain(&e));
        let real = disk::canonicalize(path).map_err(failed)?;
        if trust == Trust::Folder {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            if !disk::canonicalize(folder).is_ok_and(|folder| real.starts_with(folder)) {
                let reason = "lies outside of the folder of the file that names it, and is read with --trust only";
                return Err(Failure::at(path, reason));
            }
        }
        let reason = match disk::entry(&real).map_err(failed)? {
            Entry::File(size) if size <= largest => return Ok(real),
            Entry::File(size) => format!("has {size} bytes, and at most {largest} are read"),
            Entry::Folder => "is a directory, not a file".to_owned(),
            Entry::Other => "is a pipe or a device, and another file may name plain files only".to_owned(),
        };
        Err(Failure::at(path, reason))
    }

    /// Reads the file by the rule.
    pub fn read(&self) -> Result<Vec<u8>, Failure> {
        let real = self.check()?;
        let bytes = disk::read_up_to(&real, self.largest).map_err(|e| Failure::at(self.path, plain(&e)))?;
        // The file may have grown meanwhile.
        if bytes.len() as u64 > self.largest {
            return Err(Failure::at(self.path, format!("has grown, and at most {} bytes are read", self.largest)));
        }
        Ok(bytes)
    }
}
