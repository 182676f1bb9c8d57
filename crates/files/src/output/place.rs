//! The place that the path of an output leads to: a file behind links, a device, or standard output.

use crate::failure::Failure;
use crate::input::plain;
use std::fs::{File, Metadata, OpenOptions, Permissions};
use std::io;
use std::path::{Component, Path, PathBuf};

/// Largest number of links in a row, as in Linux.
const MOST_LINKS: usize = 40;

/// A place to write to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Standard output.
    Stdout,
    /// A pipe, a device, or a file that is open already: it is written to where it is, since renaming would replace it.
    Device(PathBuf),
    /// A file that need not exist; all links are followed.
    File(PathBuf),
}

impl Place {
    /// Finds where a path leads. `-` is standard output, as are `/dev/stdout` and its other names.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        let mut path = path.to_path_buf();
        for _ in 0..MOST_LINKS {
            if let Some(descriptor) = descriptor(&path) {
                return Ok(if descriptor == Descriptor::Own(1) { Self::Stdout } else { Self::Device(path) });
            }
            let Ok(metadata) = path.symlink_metadata() else { return Ok(Self::File(path)) };
            if !metadata.is_symlink() {
                return Ok(if metadata.is_file() || metadata.is_dir() { Self::File(path) } else { Self::Device(path) });
            }
            let target = std::fs::read_link(&path)?;
            path = path.parent().unwrap_or(Path::new("")).join(target);
        }
        Err(io::Error::other("too many links"))
    }
}

/// A descriptor that a path names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Descriptor {
    /// A descriptor of this process.
    Own(u32),
    /// A descriptor of another process.
    Foreign,
}

/// Returns the descriptor that a path names, as `/dev/fd/1` and `/proc/self/fd/1` do. Such a path looks like a link to the file
/// that is open there, and that file must be written to where it is open.
fn descriptor(path: &Path) -> Option<Descriptor> {
    let number: u32 = path.file_name()?.to_str()?.parse().ok()?;
    let folder = path.parent()?.canonicalize().ok()?;
    let parts: Vec<&str> = folder
        .components()
        .map(|c| match c {
            Component::Normal(part) => part.to_str().unwrap_or_default(),
            _ => "",
        })
        .collect();
    match parts.as_slice() {
        ["", "dev", "fd"] => Some(Descriptor::Own(number)),
        ["", "proc", process, .., "fd"] => {
            let is_own = *process == std::process::id().to_string();
            Some(if is_own { Descriptor::Own(number) } else { Descriptor::Foreign })
        }
        _ => None,
    }
}

/// Opens a device, or a file that is open already, for writing. Behind `>>` a shell has opened a file at its end.
pub(super) fn open_device(path: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).open(path)
}

/// A file that an output replaces.
#[derive(Debug)]
pub(super) struct Replaced {
    metadata: Metadata,
}

impl Replaced {
    /// Looks at the file at `path`, and fails if it must not be replaced: a directory, or a file that may not be written.
    /// `None` if there is no file yet.
    pub(super) fn at(path: &Path) -> Result<Option<Self>, Failure> {
        let Ok(metadata) = path.metadata() else { return Ok(None) };
        if metadata.is_dir() {
            return Err(Failure::at(path, "is a directory, and a file has to go there"));
        }
        // Renaming needs no permission of the file itself. Root may write everything, and still respects the mode.
        if metadata.permissions().readonly() {
            return Err(Failure::at(path, "is read-only"));
        }
        let opened = OpenOptions::new().write(true).open(path);
        opened.map_err(|e| Failure::at(path, format!("cannot be written: {}", plain(&e))))?;
        Ok(Some(Self { metadata }))
    }

    /// Permissions that the new file has to have.
    pub(super) fn permissions(&self) -> Permissions {
        self.metadata.permissions()
    }

    /// Gives the new file the owner of the old one, as far as that is allowed.
    pub(super) fn keep_owner(&self, file: &File) {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            let new = file.metadata().map(|m| (m.uid(), m.gid()));
            let old = (self.metadata.uid(), self.metadata.gid());
            if new.is_ok_and(|new| new != old) {
                let _ = std::os::unix::fs::fchown(file, Some(old.0), Some(old.1));
            }
        }
        #[cfg(not(unix))]
        let _ = file;
    }
}
