//! Lets vertices follow given face normals, and unfolds triangles that noise has turned over.
//!
//! A sweep is a step of [`super::super::vertex_update`]: pᵢ ← pᵢ + 1/|Fᵢ| Σ_f n_f (n_f · (c_f − pᵢ)). Vertices of triangles whose normal
//! is far from the given one also move a part of the way to the centroids of their triangles, within the surface.

use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// Sweeps of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sweeps {
    /// Number of sweeps.
    pub(super) count: u32,
    /// Cosine of the angle to the given normal from which a triangle unfolds.
    pub(super) unfold_below: f64,
    /// Part of the way that the vertices of such a triangle go.
    pub(super) unfold_step: f64,
    /// Whether the vertices around them go with them.
    pub(super) widened: bool,
}

/// Moves `positions` (#V×3) so that the triangles follow `normals` (#T×3, unit or zero); those that are `fixed` stay.
pub(super) fn follow(
    mesh: &TriangleMesh,
    fixed: &[bool],
    normals: &[DVec3],
    sweeps: Sweeps,
    positions: &mut Vec<DVec3>,
    progress: &dyn Progress,
) -> Result<(), Cancelled> {
    let count = positions.len();
    let around = |v: usize| mesh.vertex_faces.get(v as Index);
    let mean_normal = |v: usize| around(v).iter().map(|&f| normals[f as usize]).sum::<DVec3>().normalize_or_zero();
    let vertex_normals: Vec<DVec3> = (0..count).into_par_iter().with_min_len(2048).map(mean_normal).collect();
    let mut centroids = vec![DVec3::ZERO; mesh.face_count()];
    let mut folded = vec![false; mesh.face_count()];
    let mut next = positions.clone();
    for _ in 0..sweeps.count {
        progress.check()?;
        let faces = centroids.par_iter_mut().zip(&mut folded).zip(&mesh.triangles).zip(normals);
        faces.with_min_len(2048).for_each(|(((centroid, folded), t), normal)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            *centroid = (a + b + c) / 3.0;
            let doubled = (b - a).cross(c - a);
            // A face without a normal to follow has no fold either.
            *folded = *normal != DVec3::ZERO && doubled.dot(*normal) < sweeps.unfold_below * doubled.length();
        });
        if sweeps.widened && folded.iter().any(|folded| *folded) {
            folded = widened(mesh, &folded);
        }
        next.par_iter_mut().enumerate().with_min_len(1024).for_each(|(v, out)| {
            let p = positions[v];
            *out = p;
            let faces = around(v);
            if fixed[v] || faces.is_empty() {
                return;
            }
            let part = 1.0 / faces.len() as f64;
            let (mut step, mut spread, mut unfolds) = (DVec3::ZERO, DVec3::ZERO, false);
            for &f in faces {
                let f = f as usize;
                let offset = centroids[f] - p;
                step += normals[f] * normals[f].dot(offset);
                spread += offset;
                unfolds |= folded[f];
            }
            *out += step * part;
            if unfolds {
                let normal = vertex_normals[v];
                // From the centroid of a triangle to that of its other two vertices it is half as far again.
                *out += 1.5 * part * sweeps.unfold_step * (spread - normal * spread.dot(normal));
            }
        });
        std::mem::swap(positions, &mut next);
    }
    Ok(())
}

/// Marks the triangles that share a vertex with a marked one.
fn widened(mesh: &TriangleMesh, marked: &[bool]) -> Vec<bool> {
    let at_vertex = |v: &Index| mesh.vertex_faces.get(*v).iter().any(|&f| marked[f as usize]);
    mesh.triangles.par_iter().with_min_len(2048).map(|t| t.iter().any(at_vertex)).collect()
}
