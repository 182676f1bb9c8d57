//! Measures what the written bytes do.

use super::BakeError;
use crate::apply;
use crate::atlas::Atlas;
use crate::displacement::Displacement;
use crate::manifest::{Manifest, Report};
use crate::metrics::percentile;
use crate::model::Model;
use crate::obj::Obj;
use crate::ragged::Index;
use crate::texture::Coverage;
use crate::texture::resolution::{self, Spacing};
use glam::{DVec3, Vec3};

/// What is known of the layout before anything is written.
pub(super) struct LayoutFindings {
    coverage: f64,
    crowded_vertices: usize,
    smallest_distance: f64,
    out_of_range_vertices: usize,
    overlapping_texels: usize,
}

impl LayoutFindings {
    pub(super) fn of(atlas: &Atlas, spacing: &Spacing, coverage: &Coverage) -> Self {
        let side = coverage.size().width;
        Self {
            coverage: coverage.share(),
            crowded_vertices: spacing.crowded(side),
            smallest_distance: spacing.smallest(side),
            out_of_range_vertices: resolution::out_of_range(atlas),
            overlapping_texels: coverage.overlaps(),
        }
    }
}

/// Decodes the map and compares what a shader makes of it and the carrier, as read back, with `expected` (#V×3, λ = 1), which lies along
/// `normals` (#V×3).
pub(super) fn measure(
    model: &Model,
    expected: &[DVec3],
    normals: &[Vec3],
    manifest: &Manifest,
    map: &[u8],
    carrier: &Obj,
    layout: &LayoutFindings,
) -> Result<Report, BakeError> {
    let entry = &manifest.displacement;
    let map = Displacement::decode(map, entry.size(), entry.encoding())?;
    let shader = apply::carrier_vertices(carrier, &manifest.dominant_uv.pairs(), entry.origin);
    let displaced: Vec<Vec3> = shader.iter().map(|v| v.displaced(&map, 1.0)).collect();

    // Only lines that a face names are drawn; of the others a shader hears nothing.
    let mut drawn = vec![false; shader.len()];
    for corner in carrier.faces().items() {
        drawn[corner.position as usize] = true;
    }
    let topology = model.surface().topology();
    let mut first = vec![None; topology.vertex_count()];
    let mut seam_gap = 0.0f32;
    for (line, &v) in model.weld().vertex_of().iter().enumerate().filter(|(line, _)| drawn[*line]) {
        // Wedges of one line differ in nothing that the shader uses.
        let first = *first[v as usize].get_or_insert(line);
        seam_gap = seam_gap.max(displaced[line].distance(displaced[first]));
    }
    let used = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_isolated(v));
    let used: Vec<(Index, usize)> = used.filter_map(|v| Some((v, first[v as usize]?))).collect();
    let error =
        |&(v, line): &(Index, usize)| (displaced[line].as_dvec3() + entry.origin).distance(expected[v as usize]);
    let mut errors: Vec<f64> = used.iter().map(error).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let max_error = errors.last().copied().unwrap_or(0.0);
    let (p99_error, mean_error) = (percentile(&errors, 0.99), errors.iter().sum::<f64>() / errors.len().max(1) as f64);

    let largest = displaced.iter().fold(0.0, |m: f32, p| m.max(p.abs().max_element()));
    let quantum = entry.encoding().quantum();
    let ulp = f64::from(largest.next_up() - largest);
    // What blending four texels in single precision may cost.
    let rounding = 4.0 * f64::from(f32::EPSILON) * f64::from(entry.encoding().scale);
    let resolved = |error: &f64| *error <= quantum + ulp + rounding;
    let in_quanta = |error: f64| (quantum > 0.0).then(|| error / quantum);
    Ok(Report {
        max_error,
        p99_error,
        mean_error,
        error_bound: max_error + ulp,
        quantum,
        max_error_quanta: in_quanta(max_error),
        p99_error_quanta: in_quanta(p99_error),
        mean_error_quanta: in_quanta(mean_error),
        seam_gap: seam_gap.into(),
        coverage: layout.coverage,
        unresolved_vertices: errors.len() - errors.partition_point(resolved),
        crowded_vertices: layout.crowded_vertices,
        smallest_distance: Some(layout.smallest_distance).filter(|d| d.is_finite()),
        out_of_range_vertices: layout.out_of_range_vertices,
        overlapping_texels: layout.overlapping_texels,
        unmapped_vertices: used.iter().filter(|(_, line)| shader[*line].uv.is_none()).count(),
        vertices_without_normal: used.iter().filter(|(v, _)| normals[*v as usize] == Vec3::ZERO).count(),
    })
}
