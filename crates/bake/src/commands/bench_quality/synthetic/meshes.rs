//! Clean meshes of a folder, and the groups of shapes that they belong to.

use crate::failure::Failure;
use crate::input;
use std::path::{Path, PathBuf};

/// Group of meshes that the table does not list, or that have no table.
const NO_GROUP: &str = "-";

/// A clean mesh.
pub(super) struct CleanMesh {
    /// Name of its file, without the ending.
    pub(super) name: String,
    pub(super) path: PathBuf,
    /// Groups of shapes; at least one.
    pub(super) groups: Vec<String>,
}

impl CleanMesh {
    /// Seed of the noise of a kind: a hash (FNV-1a) of the name of the mesh and of the kind, so that a result depends on neither
    /// the other meshes nor the other kinds.
    pub(super) fn seed(&self, kind: &str) -> u64 {
        let (basis, prime) = (0xcbf2_9ce4_8422_2325, 0x0100_0000_01b3);
        let bytes = self.name.bytes().chain([0]).chain(kind.bytes());
        bytes.fold(basis, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(prime))
    }
}

/// Finds the meshes of a folder by their endings, in the order of their names: all if `names` is empty, or those that it names.
pub(super) fn find(folder: &Path, names: &[String]) -> Result<Vec<CleanMesh>, Failure> {
    let failed = |e: std::io::Error| Failure::at(folder, input::plain(&e));
    let groups = groups(&folder.join("MANIFEST.tsv"))?;
    let mut meshes = Vec::new();
    for entry in folder.read_dir().map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_obj = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"));
        if let Some(name) = path.file_stem().and_then(|name| name.to_str()).filter(|_| is_obj) {
            let name = name.to_owned();
            let listed = groups.iter().find(|(known, _)| *known == name).map(|(_, groups)| groups.clone());
            let groups = listed.unwrap_or_else(|| vec![NO_GROUP.to_owned()]);
            meshes.push(CleanMesh { name, path, groups });
        }
    }
    meshes.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(unknown) = names.iter().find(|name| meshes.iter().all(|mesh| mesh.name != **name)) {
        return Err(Failure::at(folder, format!("has no mesh {unknown}.obj")));
    }
    meshes.retain(|mesh| names.is_empty() || names.contains(&mesh.name));
    if meshes.is_empty() {
        return Err(Failure::at(folder, "has no mesh *.obj"));
    }
    Ok(meshes)
}

/// Reads the names of meshes with their groups from a table, if there is one that has groups.
fn groups(manifest: &Path) -> Result<Vec<(String, Vec<String>)>, Failure> {
    if !manifest.is_file() {
        return Ok(Vec::new());
    }
    let bytes = input::read(manifest)?;
    let mut reader = csv::ReaderBuilder::new().delimiter(b'\t').quoting(false).from_reader(bytes.as_slice());
    let failed = |e: &csv::Error| Failure::at(manifest, e);
    let heads = reader.headers().map_err(|e| failed(&e))?.clone();
    let column = |names: [&str; 2]| heads.iter().position(|head| names.contains(&head));
    let Some(group) = column(["group", "groups"]) else { return Ok(Vec::new()) };
    let Some(name) = column(["name", "file"]) else {
        return Err(Failure::at(manifest, "has a column of groups, but no column name or file"));
    };
    let mut all = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| failed(&e))?;
        let groups: Vec<String> = row[group].split(',').map(|group| group.trim().to_owned()).collect();
        let stem = row[name].strip_suffix(".xz").unwrap_or(&row[name]);
        all.push((stem.strip_suffix(".obj").unwrap_or(stem).to_owned(), groups));
    }
    Ok(all)
}
