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
    unresolved_vertices: usize,
    smallest_distance: f64,
    out_of_range_vertices: usize,
    overlapping_texels: usize,
}

impl LayoutFindings {
    pub(super) fn of(atlas: &Atlas, spacing: &Spacing, coverage: &Coverage) -> Self {
        let side = coverage.size().width;
        Self {
            coverage: coverage.share(),
            unresolved_vertices: spacing.crowded(side),
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

    let weld = model.weld();
    let topology = model.surface().topology();
    let used: Vec<Index> = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_isolated(v)).collect();
    let error = |v: Index| {
        let line = weld.first()[v as usize] as usize;
        (displaced[line].as_dvec3() + entry.origin).distance(expected[v as usize])
    };
    let mut errors: Vec<f64> = used.iter().map(|&v| error(v)).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let max_error = errors.last().copied().unwrap_or(0.0);
    let (p99_error, mean_error) = (percentile(&errors, 0.99), errors.iter().sum::<f64>() / errors.len().max(1) as f64);

    // Over the `v` lines of each vertex; wedges of one line differ in nothing that the shader uses.
    let gap = |(line, &v): (usize, &Index)| displaced[line].distance(displaced[weld.first()[v as usize] as usize]);
    let seam_gap = weld.vertex_of().iter().enumerate().map(gap).fold(0.0, f32::max);
    let largest = displaced.iter().fold(0.0, |m: f32, p| m.max(p.abs().max_element()));
    let quantum = entry.encoding().quantum();
    let in_quanta = |error: f64| (quantum > 0.0).then(|| error / quantum);
    Ok(Report {
        max_error,
        p99_error,
        mean_error,
        error_bound: max_error + f64::from(largest.next_up() - largest),
        quantum,
        max_error_quanta: in_quanta(max_error),
        p99_error_quanta: in_quanta(p99_error),
        mean_error_quanta: in_quanta(mean_error),
        seam_gap: seam_gap.into(),
        coverage: layout.coverage,
        unresolved_vertices: layout.unresolved_vertices,
        smallest_distance: Some(layout.smallest_distance).filter(|d| d.is_finite()),
        out_of_range_vertices: layout.out_of_range_vertices,
        overlapping_texels: layout.overlapping_texels,
        unmapped_vertices: used.iter().filter(|&&v| shader[weld.first()[v as usize] as usize].uv.is_none()).count(),
        vertices_without_normal: used.iter().filter(|&&v| normals[v as usize] == Vec3::ZERO).count(),
    })
}
