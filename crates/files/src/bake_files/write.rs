//! Writes a bundle to its folder.

use super::Baked;
use crate::failure::Failure;
use crate::input;
use crate::output::{self, Earlier, Folder};
use planish_geometry::map::manifest::{self, FileEntry};
use std::path::{Path, PathBuf};

impl Baked {
    /// Writes all files or none, and returns their paths. Fails if one of them would overwrite an input.
    pub fn write(&self, folder: Folder) -> Result<Vec<PathBuf>, Failure> {
        let files = &self.bundle.files;
        files.iter().try_for_each(|f| output::refuse_overwrite(&folder.path().join(&f.name), &self.inputs))?;
        let path = folder.path().to_path_buf();
        let manifest = files.last().map(|file| path.join(&file.name)).unwrap_or_default();
        let new: Vec<(&Path, &[u8])> = files.iter().map(|f| (Path::new(&f.name), f.bytes.as_slice())).collect();
        let is_new = |name: &str| files.iter().any(|file| file.name == name);
        folder.write_bundle(&new, || {
            let mut earlier = earlier(&manifest, &path, is_new);
            // A manifest of this name that names such a mesh was made of arrays, too.
            earlier
                .replaceable
                .extend(self.own_source.iter().filter(|own| names_source(&manifest, own)).map(PathBuf::from));
            earlier
        })
    }
}

/// Returns true if there is a manifest that says that its mesh is `name`.
fn names_source(manifest: &Path, name: &str) -> bool {
    input::manifest(manifest).is_ok_and(|manifest| manifest.source.file == name)
}

/// Finds the files of an earlier bake under the same name, by its manifest.
pub(crate) fn earlier(manifest: &Path, folder: &Path, is_new: impl Fn(&str) -> bool) -> Earlier {
    let Some(files) = std::fs::read(manifest).ok().and_then(|bytes| manifest::named_files(&bytes)) else {
        return Earlier::default();
    };
    let names = files.iter().map(|entry| PathBuf::from(&entry.file));
    let replaceable = names.chain(manifest.file_name().map(PathBuf::from)).collect();
    let is_plain_name = |name: &str| Path::new(name).file_name() == Some(name.as_ref());
    let unchanged = |entry: &&FileEntry| {
        let bytes = std::fs::read(folder.join(&entry.file));
        bytes.is_ok_and(|bytes| manifest::sha256(&bytes) == entry.sha256)
    };
    let old = files.iter().filter(|entry| is_plain_name(&entry.file) && !is_new(&entry.file));
    let obsolete = old.filter(unchanged).map(|entry| folder.join(&entry.file)).collect();
    Earlier { replaceable, obsolete }
}
