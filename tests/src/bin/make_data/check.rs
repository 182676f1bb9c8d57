//! What both meshes promise their readers, asserted before anything is written; and their
//! statistics.

use crate::chart::{Chart, signed_area};
use crate::mesh::{Mesh, directed_edges, faces_across};
use crate::model::Model;
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet};

/// Texels along the side of the rasters that look for overlaps and gaps.
const RASTER: usize = 2048;
/// Texels that stay empty between two charts: 1/128 of the side.
const GAP: usize = RASTER / 128;

/// Asserts that the model is sound; returns a line of statistics.
pub(crate) fn check(model: &Model) -> String {
    let mesh = model.mesh();
    assert_closed_manifold(&mesh);
    assert!(is_connected(&mesh), "the mesh is in several pieces");
    assert!(volume(&mesh) > 0.0, "the mesh is inside out");
    assert_sound_atlas(&model.charts);
    let edges: Vec<f64> = mesh
        .triangles
        .iter()
        .flat_map(|&t| directed_edges(t))
        .filter(|[a, b]| a < b)
        .map(|[a, b]| mesh.positions[a].distance(mesh.positions[b]))
        .collect();
    let mean = edges.iter().sum::<f64>() / edges.len() as f64;
    let variance = edges.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / edges.len() as f64;
    format!(
        "{}: V {} F {} vt {} charts {} mean edge {:.4} cv {:.3} smallest angle {:.1}° atlas use {:.1} %",
        model.name,
        mesh.positions.len(),
        mesh.triangles.len(),
        model.charts.iter().map(|chart| chart.uvs.len()).sum::<usize>(),
        model.charts.len(),
        mean,
        variance.sqrt() / mean,
        smallest_angle(&mesh).to_degrees(),
        100.0 * model.charts.iter().map(Chart::area).sum::<f64>(),
    )
}

fn assert_closed_manifold(mesh: &Mesh) {
    let mut edges = BTreeSet::new();
    let mut rings = vec![BTreeMap::new(); mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for edge in directed_edges([a, b, c]) {
            assert!(edges.insert(edge), "edge {edge:?} twice in one direction: not orientable");
        }
        for [v, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
            rings[v].insert(next, last);
        }
    }
    for &[a, b] in &edges {
        assert!(edges.contains(&[b, a]), "edge {a} {b} has one triangle: not closed");
    }
    for (v, ring) in rings.iter().enumerate() {
        let start = ring.first_key_value().map(|(first, _)| *first);
        assert!(start.is_some(), "vertex {v} is in no triangle");
        let mut at = start;
        for step in 1..=ring.len() {
            at = at.and_then(|w| ring.get(&w).copied());
            let closes = at == start;
            assert!(closes == (step == ring.len()), "vertex {v} is where two sheets touch");
        }
    }
}

fn is_connected(mesh: &Mesh) -> bool {
    let across = faces_across(&mesh.triangles);
    let mut is_seen = vec![false; across.len()];
    let mut waiting = vec![0];
    while let Some(face) = waiting.pop() {
        if !std::mem::replace(&mut is_seen[face], true) {
            waiting.extend(across[face]);
        }
    }
    is_seen.iter().all(|&seen| seen)
}

fn volume(mesh: &Mesh) -> f64 {
    let corners = mesh.triangles.iter().map(|&t| mesh.corners(t));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn smallest_angle(mesh: &Mesh) -> f64 {
    let angles = mesh.triangles.iter().flat_map(|&t| {
        let [a, b, c] = mesh.corners(t);
        [(a, b, c), (b, c, a), (c, a, b)].map(|(p, q, r)| (q - p).angle_between(r - p))
    });
    angles.fold(f64::INFINITY, f64::min)
}

fn assert_sound_atlas(charts: &[Chart]) {
    let mut owners: Vec<Option<usize>> = vec![None; RASTER * RASTER];
    for (k, chart) in charts.iter().enumerate() {
        let margin = 1.0 / 128.0;
        let is_inside = |uv: &DVec2| uv.min_element() >= margin && uv.max_element() <= 1.0 - margin;
        assert!(chart.uvs.iter().all(is_inside), "chart {k} leaves the unit square");
        for &triangle in &chart.triangles {
            let corners = chart.corners(triangle);
            assert!(signed_area(corners) > 0.0, "chart {k} has a flipped triangle");
            for_each_texel(corners, |texel| {
                let before = owners[texel].replace(k);
                assert!(before.is_none(), "charts {before:?} and {k} overlap at texel {texel}");
            });
        }
    }
    widened(&widened(&owners, 1), RASTER);
}

/// Each chart's texels with those up to almost half a gap away in steps of `stride`, either way:
/// widened along rows and columns, charts that keep the gap do not meet yet.
fn widened(owners: &[Option<usize>], stride: usize) -> Vec<Option<usize>> {
    let reach = GAP / 2 - 1;
    let mut wide = vec![None; owners.len()];
    for (texel, owner) in owners.iter().enumerate() {
        let Some(k) = owner else { continue };
        for target in (texel - reach * stride..=texel + reach * stride).step_by(stride) {
            let before = wide[target].replace(*k);
            assert!(before.is_none_or(|b| b == *k), "charts {before:?} and {k} are too near");
        }
    }
    wide
}

/// Texels whose centres are strictly inside a counter-clockwise triangle.
fn for_each_texel(corners: [DVec2; 3], mut visit: impl FnMut(usize)) {
    let [a, b, c] = corners.map(|p| p * RASTER as f64);
    let low = a.min(b).min(c).as_usizevec2();
    let high = a.max(b).max(c).as_usizevec2();
    for y in low.y..=high.y {
        for x in low.x..=high.x {
            let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let is_left = |from: DVec2, to: DVec2| (to - from).perp_dot(p - from) > 0.0;
            if is_left(a, b) && is_left(b, c) && is_left(c, a) {
                visit(y * RASTER + x);
            }
        }
    }
}
