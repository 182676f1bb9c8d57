//! Reads files, with errors that name them.

use crate::compression;
use crate::failure::Failure;
use planish_geometry::denoise::limits::Mask;
use planish_geometry::map::manifest::Manifest;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::Source;
use planish_geometry::source::format::Format;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use std::path::{Path, PathBuf};

/// Fraction of the diagonal of a mesh above which a welding distance can only be a mistake.
const LARGEST_WELD: f64 = 0.01;

/// Reads all bytes of a file.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    if path.is_dir() {
        return Err(Failure::at(path, "is a directory, not a file"));
    }
    std::fs::read(path).map_err(|e| Failure::at(path, plain(&e)))
}

/// Reads a mesh in any format that planish knows.
pub fn source(path: &Path) -> Result<Source, Failure> {
    let beside = |name: &str| std::fs::read(path.with_file_name(name)).ok();
    Source::parse_beside(content(path)?, format_of(path), &beside).map_err(|e| Failure::at(path, e))
}

/// Reads all bytes of a file, uncompressed if it is a gzip file.
pub fn content(path: &Path) -> Result<Vec<u8>, Failure> {
    compression::decompressed(read(path)?).map_err(|e| Failure::at(path, e))
}

/// Bytes that identify the mesh in a file, as [`Source::bytes`] has them.
pub fn identity(path: &Path) -> Result<Vec<u8>, Failure> {
    match format_of(path) {
        // Its numbers may be in other files.
        Some(Format::Gltf) => Ok(source(path)?.bytes().into_owned()),
        _ => content(path),
    }
}

/// Format of a mesh that the name of a file stands for, compressed or not; `None` if its extension is that of no mesh.
pub fn format_of(path: &Path) -> Option<Format> {
    Format::of_extension(&compression::uncompressed_name(path).extension()?.to_string_lossy())
}

/// Reads an OBJ file.
pub fn obj(path: &Path) -> Result<Obj, Failure> {
    Obj::parse(content(path)?).map_err(|e| Failure::at(path, e))
}

/// Reads and welds a mesh. Fails if no face is left, or if the welding distance is too large.
pub fn model(path: &Path, welding: Welding, progress: &dyn Progress) -> Result<Model, Failure> {
    progress.stage("reading");
    let source = source(path)?;
    progress.check()?;
    if let Welding::Epsilon(epsilon) = welding {
        let bounds = source
            .data()
            .positions()
            .iter()
            .fold([glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY], |[l, h], p| [l.min(*p), h.max(*p)]);
        let diagonal = bounds[0].distance(bounds[1]);
        if epsilon > LARGEST_WELD * diagonal {
            let limit = LARGEST_WELD * diagonal;
            let reason = format!("--weld {epsilon} is more than a hundredth of the mesh (at most {limit:.3e})");
            return Err(Failure::at(path, reason));
        }
    }
    progress.stage("connecting");
    let model = Model::new(source, welding);
    progress.check()?;
    if model.surface().topology().faces().is_empty() {
        return Err(Failure::at(path, "no face has three different vertices"));
    }
    Ok(model)
}

/// Reads a text file of source vertices, such as `7 12-40`, for a mesh that has `source_vertices` of them.
pub fn mask(path: &Path, source_vertices: usize) -> Result<Mask, Failure> {
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
    let number = |token: &str| token.parse().map_err(|_| Failure::at(path, format!("`{token}` is not a number")));
    String::from_utf8_lossy(&bytes).split_whitespace().map(number).collect()
}

/// Returns the text of an operating system error without its number.
pub fn plain(e: &std::io::Error) -> String {
    let text = e.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// A material library that a mesh names.
#[derive(Clone, Debug)]
pub struct Library {
    /// Path of the library: beside the mesh, under the name that the mesh gives.
    pub path: PathBuf,
    /// Content of the library; `None` if it cannot be read.
    pub bytes: Option<Vec<u8>>,
}

/// Reads the material libraries that a mesh names from the folder of the mesh. Materials inside the mesh file are a library at the
/// path of the mesh.
pub fn libraries(mesh: &Path, source: &Source) -> Vec<Library> {
    let folder = mesh.parent().unwrap_or(Path::new(""));
    let mut found: Vec<Library> = Vec::new();
    let embedded = source.file().map(MeshFile::embedded_library).filter(|library| !library.is_empty());
    found.extend(embedded.map(|bytes| Library { path: mesh.to_owned(), bytes: Some(bytes) }));
    let load = |name: &str| {
        let path = folder.join(name.replace('\\', "/"));
        let bytes = std::fs::read(&path).ok();
        Library { path, bytes }
    };
    for argument in source.material_libraries() {
        let argument = String::from_utf8_lossy(argument);
        // The argument is one name that may contain blanks, or several names.
        let whole = load(&argument);
        let libraries =
            if whole.bytes.is_some() { vec![whole] } else { argument.split_whitespace().map(load).collect() };
        for library in libraries {
            if found.iter().all(|known| known.path != library.path) {
                found.push(library);
            }
        }
    }
    found
}
