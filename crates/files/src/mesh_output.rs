//! Meshes written to files, in the format that the name of the file asks for.
//!
//! ```
//! use planish_files::mesh_output;
//! use planish_geometry::source::{Source, obj::Obj};
//! use std::path::Path;
//!
//! // A triangle with texture coordinates, which STL files do not have.
//! let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
//! let mesh = Source::from(Obj::parse(text.into())?);
//! let [input, output] = ["triangle.obj", "triangle.stl"].map(Path::new);
//! let written = mesh_output::write(output, &mesh, mesh.data().positions(), None)?;
//! assert_eq!(written.bytes.len(), 84 + 50, "a head and one triangle");
//! let warnings = mesh_output::warnings(output, input, &mesh, &written, 1.0);
//! assert!(warnings[0].starts_with("triangle.stl: STL has no place for what the source has: "), "{warnings:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::compression;
use crate::disk;
use crate::failure::Failure;
use crate::input;
use crate::text::shown;
use planish_geometry::source::format::Format;
use planish_geometry::source::materials;
use planish_geometry::source::{Source, Written};
use std::borrow::Cow;
use std::path::Path;

/// Rounding of positions, in mean edge lengths, above which people are told about it.
const MUCH: f64 = 1e-3;

/// Format of an output file: the one that its extension stands for, else that of the source.
fn format(path: &Path, source: &Source) -> Format {
    input::format_of(path).unwrap_or_else(|| source.format())
}

/// Writes a mesh into memory as [`pieces`] does, in one piece.
///
/// # Panics
/// If there is not one position for each source vertex, or not one normal for each normal of the source.
pub fn write(
    path: &Path,
    source: &Source,
    positions: &[glam::DVec3],
    normals: Option<&[glam::DVec3]>,
) -> Result<Written, Failure> {
    Ok(pieces(path, source, positions, normals)?.joined())
}

/// Writes a mesh into memory, with other positions (#v×3, model units) and, if given, other normals (#vn×3), as the file `path`
/// should have it. Fails if the format cannot hold it.
///
/// # Panics
/// If there is not one position for each source vertex, or not one normal for each normal of the source.
pub fn pieces<'a>(
    path: &Path,
    source: &'a Source,
    positions: &[glam::DVec3],
    normals: Option<&[glam::DVec3]>,
) -> Result<Written<Vec<Cow<'a, [u8]>>>, Failure> {
    let format = format(path, source);
    let mut written = source.pieces_as(format, positions, normals);
    if !written.rounding.is_finite() {
        return Err(Failure::at(
            path,
            "a position is too large for single precision, which the file has; write OBJ instead",
        ));
    }
    if format == Format::Glb && u32::try_from(written.bytes.iter().map(|piece| piece.len()).sum::<usize>()).is_err() {
        return Err(Failure::at(path, "a binary glTF file of more than 4 GiB cannot be written"));
    }
    if compression::is_compressed_name(path) {
        written.bytes = vec![compression::compressed(&written.bytes.concat()).into()];
    }
    Ok(written)
}

/// Lists what people should know about a mesh that was read from `input` and written to `path`: what was left behind, names that
/// lead to nothing from there, and rounding that shows. `mean_edge` is in model units.
pub fn warnings<B>(path: &Path, input: &Path, source: &Source, written: &Written<B>, mean_edge: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    if format(path, source) == source.format() {
        warnings.extend(dangling(path, input, source));
    }
    let named = format(path, source).name().to_uppercase();
    if !written.lost.is_empty() {
        warnings.push(format!(
            "{}: {named} has no place for what the source has: {}",
            shown(path),
            written.lost.join(", ")
        ));
    }
    if written.rounding > MUCH * mean_edge {
        let edges = written.rounding / mean_edge;
        warnings.push(format!("{}: positions are rounded by up to {edges:.2} mean edge lengths", shown(path)));
    }
    warnings
}

/// Warns if the mesh names files that lie beside the input and not beside the output.
fn dangling(path: &Path, input: &Path, source: &Source) -> Option<String> {
    let file = source.file()?;
    let libraries = file.material_libraries().iter().map(|name| String::from_utf8_lossy(name).into_owned());
    let inside = materials::textures(&file.embedded_library()).into_iter();
    let textures = inside.filter(|texture| file.embedded_texture(texture).is_none());
    let is_lost =
        |name: &String| disk::is_file(&input.with_file_name(name)) && !disk::is_file(&path.with_file_name(name));
    let lost: Vec<String> = libraries.chain(textures).filter(is_lost).collect();
    (!lost.is_empty()).then(|| format!("{}: names {}, which lies beside the input alone", shown(path), lost.join(", ")))
}
