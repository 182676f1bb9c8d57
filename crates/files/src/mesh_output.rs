//! Meshes written to files, in the format that the name of the file asks for.

use crate::compression;
use crate::input;
use planish_geometry::source::format::Format;
use planish_geometry::source::{Source, Written};
use std::path::Path;

/// Rounding of positions, in mean edge lengths, above which people are told about it.
const MUCH: f64 = 1e-3;

/// Format of an output file: the one that its extension stands for, else that of the source.
fn format(path: &Path, source: &Source) -> Format {
    input::format_of(path).unwrap_or_else(|| source.format())
}

/// Writes a mesh into memory, with other positions (#v×3, model units) and, if given, other normals (#vn×3), as the file `path`
/// should have it.
///
/// # Panics
/// If there is not one position for each source vertex, or not one normal for each normal of the source.
pub fn write(
    path: &Path,
    source: &Source,
    positions: &[glam::DVec3],
    normals: Option<&[glam::DVec3]>,
) -> Written {
    let mut written = source.written_as(format(path, source), positions, normals);
    if compression::is_compressed_name(path) {
        written.bytes = compression::compressed(&written.bytes);
    }
    written
}

/// Lists what people should know about a mesh that was written: what was left behind, and rounding that shows. `mean_edge` is in
/// model units.
pub fn warnings(path: &Path, source: &Source, written: &Written, mean_edge: f64) -> Vec<String> {
    let mut warnings = Vec::new();
    let named = format(path, source).name().to_uppercase();
    if !written.lost.is_empty() {
        warnings.push(format!("{}: {named} has no place for what the source has: {}", path.display(), written.lost.join(", ")));
    }
    if written.rounding > MUCH * mean_edge {
        let edges = written.rounding / mean_edge;
        warnings.push(format!("{}: positions are rounded by up to {edges:.2} mean edge lengths", path.display()));
    }
    warnings
}
