//! Reads files, with errors that name them.
//!
//! ```
//! use planish_files::compression;
//! use planish_files::input::{self, Trust};
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//!
//! let folder = tempfile::tempdir()?;
//! let at = |name: &str| folder.path().join(name);
//! std::fs::write(at("square.obj.gz"), compression::compressed(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"))?;
//! let model = input::model(&at("square.obj.gz"), Welding::Exact, Trust::Folder, &Silent)?;
//! assert_eq!(model.surface().area(), 1.0);
//!
//! // Errors say where in which file.
//! std::fs::write(at("broken.obj"), "v 0 0 0\nv 1 nothing 0\n")?;
//! let failure = input::source(&at("broken.obj"), Trust::Folder).unwrap_err();
//! assert!(failure.to_string().contains("broken.obj: line 2: "), "{failure}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use crate::named_file::{LARGEST_LIBRARY, LARGEST_MESH, LARGEST_PICTURE, LARGEST_WEIGHTS, NamedFile, Trust};
pub use crate::text::plain;

use crate::compression;
use crate::disk;
use crate::failure::Failure;
use crate::named_path::{self, NamedPath};
use crate::text::one_line;
use glam::DVec3;
use planish_geometry::denoise::limits::Mask;
use planish_geometry::map::manifest::Manifest;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::format::Format;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use planish_geometry::source::{MeshData, Source, materials};
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Fraction of the diagonal of a mesh above which a welding distance can only be a mistake.
const LARGEST_WELD: f64 = 0.01;
/// Largest absolute coordinate, model units: its sixth power is finite in double precision.
const LARGEST_COORDINATE: f64 = 1e50;
/// Smallest diagonal of a mesh, model units, with which products of lengths are not lost.
const SMALLEST_SIZE: f64 = 1e-50;

/// Reads all bytes of a file that the user names. It may be a pipe.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    work_on(path);
    if path.as_os_str().is_empty() {
        return Err(Failure::at(path, "names no file"));
    }
    if disk::is_folder(path) {
        return Err(Failure::at(path, "is a directory, not a file"));
    }
    disk::read(path).map_err(|e| Failure::at(path, plain(&e)))
}

/// Notes the file that is being worked on, for the last words of a program that runs out of memory.
fn work_on(path: &Path) {
    #[cfg(not(target_family = "wasm"))]
    crate::terminal::work_on(path);
    #[cfg(target_family = "wasm")]
    let _ = path;
}

/// Returns the folder of a file: that in which the names in it are looked up.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Reads a mesh in any format that planish knows. It may be compressed, and its numbers may be in other files, which are read by
/// the rule.
pub fn source(path: &Path, trust: Trust) -> Result<Source, Failure> {
    parse(read(path)?, path, trust)
}

/// Reads a mesh from the bytes of the file at `path`, as [`source`] does.
pub fn parse(bytes: Vec<u8>, path: &Path, trust: Trust) -> Result<Source, Failure> {
    work_on(path);
    parse_content(content(bytes, path)?, path, trust)
}

fn parse_content(content: Vec<u8>, path: &Path, trust: Trust) -> Result<Source, Failure> {
    let refused = RefCell::new(None);
    let beside = |name: &str| {
        let folder = folder_of(path);
        let file = NamedFile { path: &folder.join(name), folder, trust, largest: LARGEST_MESH };
        file.read().map_err(|reason| refused.replace(Some(reason))).ok()
    };
    Source::parse_beside(content, format_of(path), &beside).map_err(|e| match refused.take() {
        Some(reason) => Failure::at(path, format!("{e}: {reason}")),
        None => Failure::at(path, e),
    })
}

/// Content of the file at `path`, uncompressed if its bytes are those of a compressed file.
fn content(bytes: Vec<u8>, path: &Path) -> Result<Vec<u8>, Failure> {
    compression::decompressed(bytes).map_err(|e| Failure::at(path, e))
}

/// Bytes that identify the mesh in the bytes of the file at `path`, as [`Source::bytes`] has them.
pub fn identity(bytes: Vec<u8>, path: &Path, trust: Trust) -> Result<Vec<u8>, Failure> {
    let content = content(bytes, path)?;
    match Format::of_content(&content, format_of(path)) {
        // Its numbers may be in other files.
        Format::Glb | Format::Gltf => Ok(parse_content(content, path, trust)?.bytes().into_owned()),
        _ => Ok(content),
    }
}

/// Format of a mesh that the name of a file stands for, compressed or not; `None` if its extension is that of no mesh.
pub fn format_of(path: &Path) -> Option<Format> {
    Format::of_extension(&compression::uncompressed_name(path).extension()?.to_string_lossy())
}

/// Reads and welds a mesh. Fails if no face is left, or if the welding distance is too large.
pub fn model(path: &Path, welding: Welding, trust: Trust, progress: &dyn Progress) -> Result<Model, Failure> {
    progress.stage("reading");
    let source = source(path, trust)?;
    weld(source, path, welding, progress)
}

/// Welds a mesh that was read from `path`. Fails if no face is left, if the welding distance is too large, or if coordinates are.
pub fn weld(source: Source, path: &Path, welding: Welding, progress: &dyn Progress) -> Result<Model, Failure> {
    progress.check()?;
    let corners = source.data().faces().items();
    check_numbers(source.data().positions(), corners, |corner| corner.position, welding, |v| vertex_place(&source, v))
        .map_err(|reason| Failure::at(path, reason))?;
    progress.stage("connecting");
    let model = Model::new(source, welding);
    progress.check()?;
    if model.surface().topology().faces().is_empty() {
        return Err(Failure::at(path, "no face has three different vertices"));
    }
    Ok(model)
}

/// Bounding box of positions, those of `used` (#c).
fn bounds(positions: &[DVec3], used: impl ParallelIterator<Item = Index>) -> [DVec3; 2] {
    let none = || [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let joined = |[low, high]: [DVec3; 2], [l, h]: [DVec3; 2]| [low.min(l), high.max(h)];
    used.map(|v| [positions[v as usize]; 2]).fold(none, joined).reduce(none, joined)
}

/// Fails if the welding distance is too large, or if coordinates are so large or so small that products of them leave double
/// precision: then nothing can be measured. `position` gives the index of the position that each of the `corners` of faces
/// names, and `place` names a position for the beginning of a message.
pub fn check_numbers<C: Sync>(
    positions: &[DVec3],
    corners: &[C],
    position: impl Fn(&C) -> Index + Sync,
    welding: Welding,
    place: impl Fn(Index) -> String,
) -> Result<(), String> {
    let used = || corners.par_iter().map(&position);
    let [low, high] = bounds(positions, used());
    let diagonal = low.distance(high);
    if let Welding::Epsilon(epsilon) = welding
        && epsilon > LARGEST_WELD * diagonal
    {
        let limit = LARGEST_WELD * diagonal;
        return Err(format!("--weld {epsilon} is more than a hundredth of the mesh (at most {limit:.3e})"));
    }
    let beyond = |v: &Index| positions[*v as usize].abs().max_element() > LARGEST_COORDINATE;
    let advice =
        format!("planish computes with sizes from {SMALLEST_SIZE:e} to {LARGEST_COORDINATE:e}; scale the mesh");
    // Most meshes need one look at each vertex only.
    let is_any = (0..positions.len() as Index).into_par_iter().any(|v| beyond(&v));
    if let Some(v) = if is_any { used().filter(beyond).min() } else { None } {
        return Err(format!("{}a coordinate is too large: {advice}", place(v)));
    }
    if 0.0 < diagonal && diagonal < SMALLEST_SIZE || diagonal == 0.0 && low != high {
        return Err(format!("the mesh is too small: {advice}"));
    }
    Ok(())
}

/// Names a source vertex for the beginning of a message, by its line where the format has lines.
pub fn vertex_place(source: &Source, vertex: Index) -> String {
    match source.as_obj().and_then(|obj| obj.vertex_line(vertex)) {
        Some(line) => format!("line {line}: "),
        None => format!("vertex {vertex} (counted from 0): "),
    }
}

/// Reads a text file of source vertices that stay, such as `7 12-40`, for a mesh that has `source_vertices` of them.
pub fn fixed_vertices(path: &Path, source_vertices: usize) -> Result<Mask, Failure> {
    let text = String::from_utf8(read(path)?);
    let text = text.map_err(|_| Failure::at(path, "is not a text file with numbers of `v` lines"))?;
    Mask::parse(&text, source_vertices).map_err(|e| Failure::at(path, e))
}

/// Reads the manifest of a displacement map.
pub fn manifest(path: &Path) -> Result<Manifest, Failure> {
    Manifest::from_json(&read(path)?).map_err(|e| Failure::at(path, e))
}

/// Reads the numbers of a text file, separated by white space.
pub fn numbers(path: &Path) -> Result<Vec<f32>, Failure> {
    let bytes = read(path)?;
    let wrong = |token: &str| Failure::at(path, format!("`{}` is not a number", one_line(token)));
    let number = |token: &str| token.parse().map_err(|_| wrong(token));
    String::from_utf8_lossy(&bytes).split_whitespace().map(number).collect()
}

/// A material library that a mesh names.
#[derive(Clone, Debug)]
pub struct Library {
    /// Path of the library: where the mesh says, or beside the mesh.
    pub path: PathBuf,
    /// Content of the library in the usual spelling, or the reason why it is not used.
    pub bytes: Result<Vec<u8>, Failure>,
    /// Note for the user if the library is another file than the mesh names.
    pub note: Option<String>,
}

/// Reads the material libraries that a mesh names from the folder of the mesh. Materials inside the mesh file are a library at the
/// path of the mesh.
pub fn libraries(mesh: &Path, source: &Source, trust: Trust) -> Vec<Library> {
    let folder = folder_of(mesh);
    let (mut found, mut known) = (Vec::new(), HashSet::new());
    let embedded = source.file().map(MeshFile::embedded_library).filter(|library| !library.is_empty());
    found.extend(embedded.map(|bytes| Library { path: mesh.to_owned(), bytes: Ok(bytes), note: None }));
    for argument in source.material_libraries() {
        for NamedPath { path, note } in named_libraries(&String::from_utf8_lossy(argument), folder, trust) {
            if known.insert(path.clone()) {
                let bytes = library(NamedFile { path: &path, folder, trust, largest: LARGEST_LIBRARY }, source.data());
                found.push(Library { path, note: note.filter(|_| bytes.is_ok()), bytes });
            }
        }
    }
    found
}

/// Paths of the libraries in one argument: a name that may contain blanks and stand in quotes, or several names.
fn named_libraries(argument: &str, folder: &Path, trust: Trust) -> Vec<NamedPath> {
    let argument = argument.trim();
    let bare = argument.strip_prefix('"').and_then(|name| name.strip_suffix('"'));
    let find = |name: &str| named_path::find(folder, name, trust);
    let whole = find(bare.unwrap_or(argument));
    if bare.is_some() || (whole.note.is_none() && disk::exists(&whole.path)) {
        return vec![whole];
    }
    let several: Vec<NamedPath> = argument.split_whitespace().map(find).collect();
    if whole.note.is_some() && several.iter().any(|named| !disk::exists(&named.path)) { vec![whole] } else { several }
}

/// Reads a material library in the usual spelling.
fn library(file: NamedFile, mesh: &MeshData) -> Result<Vec<u8>, Failure> {
    let bytes = materials::usual_spelling(&file.read()?, mesh);
    if materials::is_library(&bytes) {
        Ok(bytes)
    } else {
        Err(Failure::at(file.path, "is no material library: it has no `newmtl`"))
    }
}

/// Notes on the libraries of a mesh: other files than the mesh names, and materials that no library defines, if all were read.
pub fn library_notes(libraries: &[Library], mesh: &MeshData) -> Vec<String> {
    const SHOWN: usize = 3;
    let mut notes: Vec<String> = libraries.iter().filter_map(|library| library.note.clone()).collect();
    let read: Result<Vec<&[u8]>, ()> = libraries.iter().map(|l| l.bytes.as_deref().map_err(|_| ())).collect();
    let Ok(read) = read else { return notes };
    let defined = materials::defined(&read);
    let absent = mesh.materials().iter().filter(|name| !defined.contains(name.as_slice()));
    let absent: Vec<String> = absent.map(|name| one_line(&String::from_utf8_lossy(name))).collect();
    if !absent.is_empty() {
        let more = if absent.len() > SHOWN { format!(" and {} more", absent.len() - SHOWN) } else { String::new() };
        let names = absent[..absent.len().min(SHOWN)].join(", ");
        let library = if libraries.is_empty() { "the mesh names no library" } else { "no library defines them" };
        notes.push(format!("materials without a definition: {names}{more}; {library}, and they are grey"));
    }
    notes
}

/// Sums up failures that do not stop the work, of which there may be as many as a file has lines: the first few, and a count.
pub fn summary(failures: impl IntoIterator<Item = String>) -> Vec<String> {
    first_few(failures, "more files that are named cannot be used")
}

/// Sums up notes as [`summary`] sums up failures.
pub fn summary_of_notes(notes: impl IntoIterator<Item = String>) -> Vec<String> {
    first_few(notes, "more notes on libraries and textures")
}

fn first_few(lines: impl IntoIterator<Item = String>, rest: &str) -> Vec<String> {
    const SHOWN: usize = 5;
    let mut all: Vec<String> = lines.into_iter().collect();
    if all.len() > SHOWN {
        let more = all.len() - SHOWN;
        all.truncate(SHOWN);
        all.push(format!("{more} {rest}"));
    }
    all
}
