//! The files that other modules read: those of the disk or, in a browser, which has no disk, those that the page has put into
//! memory. Names, folders and messages are alike, so what is baked from either is the same.
//!
//! ```
//! use planish_files::disk;
//!
//! let folder = tempfile::tempdir()?;
//! let at = |name: &str| folder.path().join(name);
//! std::fs::write(at("scan.obj"), "v 0 0 0\n")?;
//! std::fs::write(at("copy.obj"), "v 0 0 0\n")?;
//! assert!(disk::same_file(&at("scan.obj"), &at("./scan.obj")));
//! assert!(!disk::same_file(&at("scan.obj"), &at("copy.obj")));
//! // Nothing is at risk where there is no file yet.
//! assert!(!disk::same_file(&at("new.obj"), &at("new.obj")));
//! # Ok::<(), std::io::Error>(())
//! ```

#[cfg(any(test, target_family = "wasm"))]
mod memory;
#[cfg(not(target_family = "wasm"))]
mod native;

#[cfg(target_family = "wasm")]
pub(crate) use memory::{absolute, canonicalize, entry, names, read, read_up_to};
#[cfg(target_family = "wasm")]
pub use memory::{clear, put, remove};
#[cfg(not(target_family = "wasm"))]
pub(crate) use native::{absolute, canonicalize, entry, names, read, read_up_to};

use std::path::Path;

/// Kind of thing that a path leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    /// A plain file with its size in bytes.
    File(u64),
    /// A folder.
    Folder,
    /// A pipe or a device, which memory has none of.
    #[cfg_attr(target_family = "wasm", allow(dead_code))]
    Other,
}

/// Returns true if the path leads to anything.
pub(crate) fn exists(path: &Path) -> bool {
    entry(path).is_ok()
}

/// Returns true if the path leads to a plain file.
pub(crate) fn is_file(path: &Path) -> bool {
    matches!(entry(path), Ok(Entry::File(_)))
}

/// Returns true if the path leads to a folder.
pub(crate) fn is_folder(path: &Path) -> bool {
    matches!(entry(path), Ok(Entry::Folder))
}

/// Returns whether two paths lead to one existing file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((canonicalize(a), canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
