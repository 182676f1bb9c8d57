//! Finds the libraries and textures that a mesh names: where it says, or else beside it, because the names come from another
//! machine, with folders that are not here or in another case.
//!
//! ```
//! use planish_files::input::Trust;
//! use planish_files::named_path;
//!
//! let folder = tempfile::tempdir()?;
//! std::fs::write(folder.path().join("oak.png"), "a picture")?;
//! let oak = named_path::find(folder.path(), r"D:\textures\oak.png", Trust::Folder);
//! assert_eq!(oak.path, folder.path().join("oak.png"));
//! assert!(oak.note.is_some_and(|note| note.ends_with(": oak.png beside the mesh is used")));
//!
//! // There is nothing like it.
//! let ash = named_path::find(folder.path(), "textures/ash.png", Trust::Folder);
//! assert_eq!((ash.path, ash.note), (folder.path().join("textures/ash.png"), None));
//! # Ok::<(), std::io::Error>(())
//! ```

use crate::disk;
use crate::named_file::{NamedFile, Trust};
use crate::text::one_line;
use std::path::{Component, Path, PathBuf};

/// Path of a file that a mesh names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedPath {
    /// Path of the file; the one that the mesh names if there is no file.
    pub path: PathBuf,
    /// Note for the user if the file is another one than the mesh names.
    pub note: Option<String>,
}

/// Finds a file by the name that a mesh in `folder` gives it, which may have folders with `/` or `\`. Tried are, in this order: the
/// name as it is, in another case, without its folders, and that in another case. A file that may not be read counts as missing.
pub fn find(folder: &Path, name: &str, trust: Trust) -> NamedPath {
    let name_with_slashes = name.replace('\\', "/");
    let written = folder.join(&name_with_slashes);
    let may_be_read = |path: &PathBuf| NamedFile { path, folder, trust, largest: u64::MAX }.check().is_ok();
    if may_be_read(&written) {
        return NamedPath { path: written, note: None };
    }
    let bare = name_with_slashes.rsplit('/').next().unwrap_or_default();
    let others = [Some(Path::new(&name_with_slashes)), Some(Path::new(bare)).filter(|_| !bare.is_empty())];
    let found = others.into_iter().flatten().filter_map(|path| in_any_case(folder, path)).find(may_be_read);
    match found {
        Some(path) => {
            let shown = path.strip_prefix(folder).unwrap_or(&path).display().to_string();
            let note = format!("{} is not there: {} beside the mesh is used", one_line(name), one_line(&shown));
            NamedPath { path, note: Some(note) }
        }
        None => NamedPath { path: written, note: None },
    }
}

/// The path in a folder whose components differ in nothing but case; of several the first by name. `None` if there is none, or if
/// the path leads out of the folder.
fn in_any_case(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut found = folder.to_path_buf();
    for component in path.components() {
        let Component::Normal(name) = component else {
            if component == Component::CurDir {
                continue;
            }
            return None;
        };
        let exact = found.join(name);
        if disk::exists(&exact) {
            found = exact;
            continue;
        }
        let here = if found.as_os_str().is_empty() { Path::new(".") } else { &found };
        let lower = |name: &std::ffi::OsStr| name.to_string_lossy().to_lowercase();
        let same = |entry: &std::ffi::OsString| lower(entry) == lower(name);
        let entries = disk::names(here).ok()?.into_iter();
        found.push(entries.filter(same).min()?);
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("Tex")).unwrap();
        for file in ["a.mtl", "B.mtl", "Tex/skin.PNG", "two", "TWO"] {
            std::fs::write(folder.path().join(file), file).unwrap();
        }
        folder
    }

    #[test]
    fn names_of_another_machine_are_found_beside_the_mesh() {
        let folder = folder();
        for (name, expected) in [
            ("meshes\\a.mtl", "a.mtl"),
            ("C:\\Users\\me\\a.mtl", "a.mtl"),
            ("/home/me/A.MTL", "a.mtl"),
            ("b.MTL", "B.mtl"),
            ("tex\\SKIN.png", "Tex/skin.PNG"),
            ("..\\..\\b.mtl", "B.mtl"),
            ("Two", "TWO"),
        ] {
            let found = find(folder.path(), name, Trust::Folder);
            assert_eq!(found.path, folder.path().join(expected), "{name}");
            assert!(found.note.unwrap().contains(expected), "{name}");
        }
    }

    #[test]
    fn what_is_there_is_taken_and_what_is_nowhere_keeps_its_name() {
        let folder = folder();
        for (name, path) in
            [("a.mtl", "a.mtl"), ("Tex\\skin.PNG", "Tex/skin.PNG"), ("none\\c.mtl", "none/c.mtl"), ("", "")]
        {
            let found = find(folder.path(), name, Trust::Folder);
            assert_eq!(found, NamedPath { path: folder.path().join(path), note: None }, "{name}");
        }
    }

    #[test]
    fn files_outside_of_the_folder_are_found_with_trust_only() {
        let (folder, outside) = (folder(), folder());
        let name = outside.path().join("a.mtl").display().to_string();
        assert_eq!(find(folder.path(), &name, Trust::Anywhere).path, outside.path().join("a.mtl"));
        assert_eq!(find(folder.path(), &name, Trust::Folder).path, folder.path().join("a.mtl"));
    }
}
