//! Ambient occlusion: how much of the light from all around reaches a surface.
//!
//! S. Zhukov, A. Iones, G. Kronin. An ambient light illumination model. EGWR 1998. The fraction of the hemisphere about the normal
//! from which nothing blocks the light, weighted with the cosine to the normal, by rays along an Owen-scrambled Sobol sequence
//! (B. Burley. Practical hash-based Owen scrambling. JCGT 2020), whose seed is the number of the texel or vertex.
//!
//! ```
//! use planish_geometry::map::occlusion::{self, Occlusion};
//! use planish_geometry::mesh::{orientation, shapes, surface::Surface};
//! use planish_geometry::progress::{Cancelled, Silent};
//!
//! // Nothing is in the way of the light outside a cube. Inside no light gets in.
//! let cube = shapes::cube();
//! assert_eq!(occlusion::at_vertices(&cube, Occlusion::default(), &Silent)?, [1.0; 8]);
//! let inside_out = orientation::with_turned(cube.topology(), &[true; 6]);
//! let room = Surface::new(inside_out, cube.positions().to_vec());
//! assert!(occlusion::at_vertices(&room, Occlusion::default(), &Silent)?.iter().all(|open| *open < 0.01));
//! # Ok::<(), Cancelled>(())
//! ```

use super::{TextureLayout, gutter, per_texel};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::ray_tree::RayTree;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Parts, Progress};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Settings of ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Occlusion {
    /// Number of rays of each texel or vertex, 1..=[`MOST_RAYS`].
    pub rays: u32,
    /// Distance beyond which nothing blocks the light, model units; `None` has no such bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { rays: 128, distance: None }
    }
}

/// Largest number of rays: the length of the Sobol sequence.
pub const MOST_RAYS: u32 = 1 << 16;

/// Angle in degrees between two faces at an edge up to which the surface counts as smooth there, so that its normals are blended.
const SMOOTH: f64 = 30.0;

/// Part of the way from a corner to the middle of its triangle at which the rays of a vertex start, so that they start on that
/// triangle, and not below a neighbour that rises from the edge.
const INSET: f64 = 0.03;

/// Number of vertices that one thread does at a time.
const CHUNK: usize = 256;

/// Number of triangles around a vertex over which the normal at a corner is blended; of more, some at equal steps, for each corner asks.
const MOST_BLENDED: usize = 256;

/// Fraction of the ambient light that reaches each texel of a surface, 0..=1, row by row from the top; texels outside the charts
/// are filled from their surroundings. A texel on a triangle without area gets 1.
pub fn at_texels(layout: TextureLayout, settings: Occlusion, progress: &dyn Progress) -> Result<Vec<f32>, Cancelled> {
    let TextureLayout { surface, coverage, .. } = layout;
    let shade = Shade::new(surface, settings, progress);
    let width = coverage.size().width as usize;
    let mut texels = per_texel(coverage.size(), Vec3::ZERO, progress, || {
        |column, row| match coverage.owner(column, row) {
            Some(owner) => {
                let (triangle, weights) = coverage.weights(owner, column, row);
                let seed = (row * width + column) as u32;
                Vec3::splat(shade.open(&[(triangle, weights)], &[0.0], seed) as f32)
            }
            None => Vec3::ZERO,
        }
    })?;
    gutter::pull_push(&mut texels, coverage);
    Ok(texels.into_iter().map(|t| t.x.clamp(0.0, 1.0)).collect())
}

/// Fraction of the ambient light that reaches each vertex of a surface, 0..=1: the mean over the corners of its triangles, weighted
/// with their angles. A vertex without such corners gets 1. #V
pub fn at_vertices(surface: &Surface, settings: Occlusion, progress: &dyn Progress) -> Result<Vec<f64>, Cancelled> {
    let shade = Shade::new(surface, settings, progress);
    let mut open = vec![1.0; surface.positions().len()];
    let parts = Parts::new(progress, open.len().div_ceil(CHUNK));
    open.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, open)| {
        parts.run(|| (chunk * CHUNK..).zip(open).for_each(|(v, open)| *open = shade.open_at_vertex(v as Index)))
    })?;
    Ok(open)
}

/// A surface with everything that its rays need.
struct Shade<'a> {
    surface: &'a Surface,
    settings: Occlusion,
    rays: RayTree,
    /// Corners of the triangles around each vertex, as numbers 3t + k. #V
    around: Ragged<Index>,
    /// Unit normal of each triangle; zero for one without area. #T×3
    faces: Vec<DVec3>,
    /// Unit normal at the corners of each triangle, blended where the surface is smooth. #T×3
    corners: Vec<[DVec3; 3]>,
}

impl<'a> Shade<'a> {
    fn new(surface: &'a Surface, settings: Occlusion, progress: &dyn Progress) -> Self {
        progress.stage("occlusion");
        let triangles: Vec<[Index; 3]> = surface.triangles().collect();
        let places = triangles.iter().map(|t| t.map(|v| surface.positions()[v as usize]));
        let faces: Vec<DVec3> = places.map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero()).collect();
        let numbered = (0..).zip(triangles.as_flattened()).map(|(corner, &v): (Index, _)| (v, corner));
        let around = Ragged::group(surface.positions().len(), numbered);
        let mut new = Self { surface, settings, rays: RayTree::new(surface), around, faces, corners: Vec::new() };
        let corner_normals = |t: Index| [0, 1, 2].map(|k| new.corner_normal(3 * t + k));
        new.corners = (0..triangles.len() as Index).into_par_iter().map(corner_normals).collect();
        new
    }

    fn places(&self, triangle: Index) -> [DVec3; 3] {
        self.surface.triangle_corners()[triangle as usize].map(|c| self.surface.at_corner(c))
    }

    /// Angle of a triangle at its corner 3t + k.
    fn angle(&self, corner: Index) -> f64 {
        let places = self.places(corner / 3);
        let [p, q, r] = [0, 1, 2].map(|i| places[(corner as usize + i) % 3]);
        (q - p).cross(r - p).length().atan2((q - p).dot(r - p))
    }

    /// Mean normal of the triangles around a corner that are about as steep as its own, weighted with their angles.
    fn corner_normal(&self, corner: Index) -> DVec3 {
        let own = self.faces[corner as usize / 3];
        let vertex = self.surface.topology().vertex(self.surface.triangle_corners().as_flattened()[corner as usize]);
        let least = SMOOTH.to_radians().cos();
        let around = self.around.get(vertex);
        let some = around.iter().step_by(around.len().div_ceil(MOST_BLENDED).max(1));
        let near = some.filter(|&&c| self.faces[c as usize / 3].dot(own) > least);
        near.map(|&c| self.faces[c as usize / 3] * self.angle(c)).sum::<DVec3>().try_normalize().unwrap_or(own)
    }

    /// Fraction of the rays that leave a vertex and meet nothing; its corners share them by their angles.
    fn open_at_vertex(&self, vertex: Index) -> f64 {
        let corners = self.around.get(vertex).iter().filter(|&&c| self.faces[c as usize / 3] != DVec3::ZERO);
        let mut ends = Vec::new();
        let starts: Vec<(Index, DVec3)> = corners
            .map(|&c| {
                ends.push(ends.last().copied().unwrap_or(0.0) + self.angle(c));
                let mut weights = DVec3::splat(INSET / 3.0);
                weights[c as usize % 3] += 1.0 - INSET;
                (c / 3, weights)
            })
            .collect();
        self.open(&starts, &ends, u32::MAX - vertex)
    }

    /// Fraction of the rays that meet nothing. They leave from points, each of which is a triangle with barycentric coordinates
    /// and gets rays up to its end in the ascending list `ends`; a single point gets all.
    fn open(&self, points: &[(Index, DVec3)], ends: &[f64], seed: u32) -> f64 {
        let Some(total) = ends.last() else { return 1.0 };
        let starts: Vec<Start> = points.iter().map(|p| self.start(*p)).collect();
        if starts.iter().all(|start| start.face == DVec3::ZERO) {
            return 1.0;
        }
        let distance = self.settings.distance.unwrap_or(f64::INFINITY);
        let rays = self.settings.rays.clamp(1, MOST_RAYS);
        let escapes = |ray: u32| {
            let [u, v, w, _] = sobol_burley::sample_4d(ray, 0, seed).map(f64::from);
            let of_ray = ends.partition_point(|end| *end < w * total).min(starts.len() - 1);
            let start = &starts[of_ray];
            let (radius, (sine, cosine)) = (u.sqrt(), (TAU * v).sin_cos());
            let local = DVec3::new(radius * cosine, radius * sine, (1.0 - u).max(0.0).sqrt());
            let mut direction = start.axes * local;
            // A blended normal looks a little below the plane of the triangle, where the surface is not.
            let below = direction.dot(start.face);
            if below < 0.0 {
                direction -= 2.0 * below * start.face;
            }
            !self.rays.meets(start.point, start.face, direction, distance)
        };
        (0..rays).filter(|&ray| escapes(ray)).count() as f64 / f64::from(rays)
    }

    fn start(&self, (triangle, weights): (Index, DVec3)) -> Start {
        let blend = |of: [DVec3; 3]| DMat3::from_cols(of[0], of[1], of[2]) * weights;
        let face = self.faces[triangle as usize];
        let normal = blend(self.corners[triangle as usize]).try_normalize().unwrap_or(face);
        let (right, up) = if normal == DVec3::ZERO { (DVec3::X, DVec3::Y) } else { normal.any_orthonormal_pair() };
        Start { point: blend(self.places(triangle)), face, axes: DMat3::from_cols(right, up, normal) }
    }
}

/// Point from which rays leave.
struct Start {
    point: DVec3,
    /// Unit normal of the triangle; zero for one without area.
    face: DVec3,
    /// Two axes and the normal about which rays are spread.
    axes: DMat3,
}

#[cfg(test)]
mod tests;
