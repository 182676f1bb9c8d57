//! Bilateral mesh denoising: a bilateral filter of the heights over each vertex's tangent plane.
//!
//! Shachar Fleishman, Iddo Drori, Daniel Cohen-Or. Bilateral mesh denoising. SIGGRAPH 2003.
//!
//! With hⱼ = n · (pⱼ − p) one iteration moves p along its normal by Σⱼ wⱼ hⱼ / Σⱼ wⱼ over the vertices within 2σ_c,
//! wⱼ = exp(−|pⱼ − p|² / 2σ_c²) exp(−hⱼ² / 2σ_s²). The sigmas are automatic: σ_c is the shortest edge at the vertex, σ_s
//! the standard deviation of the |hⱼ|.

use super::boundary::{BOUNDARY, Boundary};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::near::{self, NearLists, Room};
use super::parameters::Parameter;
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Bilateral`](super::Denoiser::Bilateral).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bilateral {
    /// Number of steps.
    pub iterations: u32,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Bilateral {
    /// Five steps; the boundary moves.
    pub fn paper() -> Self {
        Self { iterations: 5, boundary: Boundary::Free }
    }
}

impl Default for Bilateral {
    /// As in the paper, with a fixed boundary.
    fn default() -> Self {
        Self { boundary: Boundary::Fixed, ..Self::paper() }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] =
    &[Parameter::count("iterations", "/iterations", 100, "number of steps"), BOUNDARY];

impl DenoiseMethod for Bilateral {
    const INFO: MethodInfo = MethodInfo {
        name: "bilateral",
        summary: "Bilateral filter of the vertices along their normals, keeps edges: for light noise",
        reference: Some(Reference { cite: "Fleishman et al. 2003", title: "Bilateral mesh denoising. SIGGRAPH" }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::paper())
    }
}

/// Filters and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(
    surface: &Surface,
    settings: &Bilateral,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let topology = surface.topology();
    let mut current = surface.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        let normals = normals::vertex_normals(&current, FaceWeight::Uniform);
        let near = NearLists::new(topology.rings(), current.positions());
        let step = |room: &mut (Room, Vec<Index>), v: Index| {
            let p = current.positions()[v as usize];
            let stays = settings.boundary == Boundary::Fixed && topology.is_boundary(v);
            if stays { p } else { p + normals[v as usize] * lift(&current, &near, v, normals[v as usize], room) }
        };
        let vertices = (0..topology.vertex_count() as Index).into_par_iter().with_min_len(256);
        let next = vertices.map_init(Default::default, step).collect();
        current = current.at(next);
        progress.done(f64::from(done) / f64::from(settings.iterations));
    }
    Ok(surface.positions().iter().zip(current.positions()).map(|(p, x)| *p - x).collect())
}

/// Largest number of vertices that are averaged around one, unless it has more neighbours. Within twice the shortest edge there are some
/// ten.
const MOST: usize = 256;

/// Displacement of a vertex along its normal in one step, model units. `room` is scratch memory.
fn lift(
    surface: &Surface,
    near: &NearLists,
    vertex: Index,
    normal: DVec3,
    (room, list): &mut (Room, Vec<Index>),
) -> f64 {
    let (positions, rings) = (surface.positions(), surface.topology().rings());
    let p = positions[vertex as usize];
    let squared = |v: Index| positions[v as usize].distance_squared(p);
    let nearest = rings.get(vertex).iter().map(|&v| squared(v)).fold(f64::INFINITY, f64::min);
    // A vertex without neighbours, or at the same position as one, has no height to be filtered.
    if !(nearest > 0.0 && nearest.is_finite()) {
        return 0.0;
    }
    list.clear();
    let inside = |v: Index| squared(v) <= 4.0 * nearest;
    // Its own neighbours are around a vertex on all sides, and some of them would pull it to one.
    let most = MOST.max(rings.get(vertex).len() + 1);
    if !near::flood_fill(vertex, list, most, |v| rings.get(v), inside) {
        near::fill_nearest(vertex, list, most, near, |v| [v], inside, room);
    }
    let height = |v: Index| (positions[v as usize] - p).dot(normal);
    let count = list.len() as f64;
    let mean = list.iter().map(|&v| height(v).abs()).sum::<f64>() / count;
    let variance = list.iter().map(|&v| (height(v).abs() - mean).powi(2)).sum::<f64>() / count;
    if variance <= 0.0 {
        return 0.0;
    }
    let (sum, total) = list.iter().fold((0.0, 0.0), |(sum, total), &v| {
        let h = height(v);
        let w = (-0.5 * (squared(v) / nearest + h * h / variance)).exp();
        (sum + w * h, total + w)
    });
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};
    use crate::progress::Silent;

    #[test]
    fn a_step_goes_along_the_normal() {
        let surface = shapes::dented_sphere(3);
        let normals = normals::vertex_normals(&surface, FaceWeight::Uniform);
        let one = Bilateral { iterations: 1, ..Bilateral::default() };
        let deltas = deltas(&surface, &one, &Silent).unwrap();
        assert!(deltas.iter().any(|delta| delta.length() > 1e-3));
        for (delta, n) in deltas.iter().zip(normals) {
            // One rounding of a number of size one in p − (p + h n).
            assert!(delta.cross(n).length() < 1e-15);
        }
    }

    #[test]
    fn noise_on_a_plane_goes_down() {
        let grid = shapes::grid(20);
        let noise = Noise { sigma: 0.1, direction: Direction::Normal, share: 1.0, seed: 5 };
        let lifted = synthetic_noise::displacements(&grid, &noise);
        let noisy = synthetic_noise::noisy(&grid, &noise);
        let deltas = deltas(&noisy, &Bilateral { boundary: Boundary::Free, ..Bilateral::default() }, &Silent).unwrap();
        let squares = |heights: &dyn Fn(usize) -> f64| (0..deltas.len()).map(|v| heights(v).powi(2)).sum::<f64>();
        let (before, after) = (squares(&|v| lifted[v].z), squares(&|v| lifted[v].z - deltas[v].z));
        // A mean over seven vertices leaves a seventh after one step; weights by height make it less of a mean.
        assert!(after < before / 3.0, "{before:e} {after:e}");
    }

    #[test]
    fn vertices_around_a_crowded_one_do_not_all_look_at_each_other() {
        // Tips of pages that are all within twice the shortest edge of each other. The square of their number would be too many looks.
        let count = 20_000;
        let tip = |k: u32| glam::DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / f64::from(count)).extend(0.5);
        let positions: Vec<DVec3> = [DVec3::ZERO, DVec3::Z * 3.0].into_iter().chain((0..count).map(tip)).collect();
        let pages = (0..count).map(|k| vec![0, 1, 2 + k]).collect();
        let book = Surface::new(crate::mesh::topology::Topology::new(positions.len(), pages), positions);
        let found = deltas(&book, &Bilateral::paper(), &Silent).unwrap();
        assert!(found.iter().all(|delta| delta.length() < 0.1), "{found:?}");
        let near = NearLists::new(book.topology().rings(), book.positions());
        let mut room = (Room::default(), Vec::new());
        lift(&book, &near, 500, DVec3::Z, &mut room);
        // The vertex itself, the nearer end of the edge and the nearest tips.
        assert!(room.1.len() <= near::MOST_IN_LIST + 2 && room.1.contains(&499) && room.1.contains(&501));
    }
}
