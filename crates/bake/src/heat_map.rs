//! Heat maps: meshes whose vertex colours show a number each.

use crate::failure::Failure;
use planish_geometry::metrics::{self, Triangles, coloured_mesh};
use std::path::Path;

/// Returns the extension of a path if a heat map can be written there by the `option` that names it.
pub(crate) fn extension<'a>(path: &'a Path, option: &str) -> Result<&'a str, Failure> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    if ["ply", "obj"].iter().any(|known| extension.eq_ignore_ascii_case(known)) {
        return Ok(extension);
    }
    Err(Failure::at(path, format!("{option} writes .ply and .obj")))
}

/// Returns the 99th percentile of the finite numbers. The maximum would let one bad vertex leave all others in one colour.
pub(crate) fn percentile_99(heat: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = heat.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    metrics::percentile(&sorted, 0.99)
}

/// Formats a heat map as OBJ or PLY, by the extension of its path; from `max` on all is yellow.
pub(crate) fn paint(path: &Path, mesh: &Triangles, heat: &[f64], max: f64, legend: &str) -> Vec<u8> {
    let colours = metrics::colours(heat, max);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        coloured_mesh::obj(mesh, &colours, legend)
    } else {
        coloured_mesh::ply(mesh, &colours, heat, legend)
    }
}
