//! Vertex update: moves vertices so that the faces of a mesh have given normals.
//!
//! Xianfang Sun, Paul L. Rosin, Ralph R. Martin, Frank C. Langbein. Fast and effective feature-preserving mesh
//! denoising. TVCG 13 (5), 2007, section 4: descent on Σ_f Σ_{i∈f} (n_f · (c_f − pᵢ))², c_f the centroid, with a step
//! that cannot overshoot (eq. 12): pᵢ ← pᵢ + 1/|Fᵢ| Σ_{f∈Fᵢ} n_f (n_f · (c_f − pᵢ)).
//!
//! Normals say nothing about the positions, so vertices may drift; a closeness term w |pᵢ − pᵢ⁰|² / 2 holds them near the
//! input. A step that would turn a triangle away from its normal is not taken at the vertices of that triangle.
//!
//! The minimum of that functional can also be found at once, see `vertex_update/least_squares.rs`.

pub(super) mod least_squares;

use super::boundary::{BOUNDARY, Boundary};
use super::motion::{MOTION, Motion};
use super::parameters::{HUGE, Parameter};
use super::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How vertices follow filtered normals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexUpdate {
    /// How the least is looked for.
    #[serde(default)]
    pub scheme: VertexScheme,
    /// Steps of the descent; least squares take as many as they need.
    pub iterations: u32,
    /// w, in units of one face: 1 pulls as hard as one of the faces around. 0 in the papers.
    pub closeness: f64,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
    /// Where vertices may go.
    pub motion: Motion,
    /// Treatment of steps that fold the surface over.
    pub fold_overs: FoldOvers,
}

named! {
    /// How vertices that fit filtered normals are looked for.
    #[derive(Default)]
    pub enum VertexScheme {
        /// A number of steps downhill, as in the papers; stopping early smooths, too.
        #[default]
        Descent = "descent",
        /// The best fit itself, by conjugate gradients.
        LeastSquares = "least-squares",
    }
}

named! {
    /// Treatment of steps that fold the surface over.
    #[derive(Default)]
    pub enum FoldOvers {
        /// Steps that would turn a triangle away from its normal are not taken.
        #[default]
        Prevent = "prevent",
        /// All steps are taken, as in the papers.
        Allow = "allow",
    }
}

impl VertexUpdate {
    /// Settings of the papers: no closeness, and folds are allowed.
    pub fn paper(iterations: u32, boundary: Boundary) -> Self {
        let fold_overs = FoldOvers::Allow;
        let scheme = VertexScheme::Descent;
        Self { scheme, iterations, closeness: 0.0, boundary, motion: Motion::Free, fold_overs }
    }
    /// These settings with vertices that keep near to the input, and no folds. On most meshes that brings the normals nearer
    /// to the true ones too.
    pub fn held(self) -> Self {
        Self { closeness: 0.05, fold_overs: FoldOvers::Prevent, ..self }
    }
}

/// Parameters of all filters of face normals.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::word::<VertexScheme>(
        "vertex-update",
        "/vertex_update/scheme",
        "how vertices follow the filtered normals",
    )
    .label("vertex update"),
    Parameter::count(
        "vertex-iterations",
        "/vertex_update/iterations",
        100,
        "number of steps of the vertices, with the vertex update descent",
    )
    .label("vertex steps"),
    Parameter::number("closeness", "/vertex_update/closeness", [0.0, HUGE], "pull of the vertices to the input")
        .slider(1.0)
        .unit("pulls of one adjacent face"),
    MOTION.at("/vertex_update/motion"),
    Parameter::word::<FoldOvers>(
        "fold-overs",
        "/vertex_update/fold_overs",
        "what happens to steps that fold the surface over",
    ),
    BOUNDARY.at("/vertex_update/boundary"),
];

/// Moves the vertices of one surface so that its faces follow given normals, for one field of normals after the other.
pub(super) struct Updater<'a> {
    mesh: &'a TriangleMesh,
    settings: VertexUpdate,
    input: &'a [DVec3],
    /// True for vertices that stay. #V
    fixed: Vec<bool>,
    positions: Vec<DVec3>,
    next: Vec<DVec3>,
    centroids: Vec<DVec3>,
}

impl<'a> Updater<'a> {
    pub(super) fn new(surface: &'a Surface, mesh: &'a TriangleMesh, settings: VertexUpdate) -> Self {
        let topology = surface.topology();
        let is_fixed_boundary = |v: Index| settings.boundary == Boundary::Fixed && topology.is_boundary(v);
        let fixed = (0..surface.positions().len() as Index).map(is_fixed_boundary).collect();
        Self::holding(fixed, surface.positions(), mesh, settings)
    }

    /// An updater of vertices at `input` (#V×3, model units), of which those that are `fixed` (#V) stay; the boundary is not looked at.
    pub(super) fn holding(
        mut fixed: Vec<bool>,
        input: &'a [DVec3],
        mesh: &'a TriangleMesh,
        settings: VertexUpdate,
    ) -> Self {
        (0..).zip(&mut fixed).for_each(|(v, fixed)| *fixed |= mesh.vertex_faces.get(v).is_empty());
        Self {
            mesh,
            settings,
            input,
            fixed,
            positions: input.to_vec(),
            next: input.to_vec(),
            centroids: vec![DVec3::ZERO; mesh.face_count()],
        }
    }

    /// Current positions of the vertices. #V×3, model units
    pub(super) fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Moves the vertices to other positions (#V×3, model units), from which they go on.
    pub(super) fn go_to(&mut self, positions: &[DVec3]) {
        self.positions.copy_from_slice(positions);
    }

    /// Displacements δ = p − p* from the current positions to the input. #V×3, model units
    pub(super) fn deltas(&self) -> Vec<DVec3> {
        self.input.iter().zip(&self.positions).map(|(p, x)| *p - x).collect()
    }

    /// Moves the vertices so that the faces follow `normals` (#T×3, unit or zero).
    pub(super) fn follow(&mut self, normals: &[DVec3], progress: &dyn Progress) -> Result<(), Cancelled> {
        let prevent_flips = self.settings.fold_overs == FoldOvers::Prevent;
        if self.settings.scheme == VertexScheme::LeastSquares {
            let Self { mesh, settings, input, fixed, positions, .. } = self;
            let closeness = settings.closeness;
            let system = least_squares::System { mesh, normals, fixed, directions: None, closeness };
            self.next = system.solve(positions, input, progress)?;
            if prevent_flips {
                undo_flips(mesh, normals, &self.positions, &mut self.next, least_squares::MAX_HALVINGS);
            }
            std::mem::swap(&mut self.positions, &mut self.next);
            return Ok(());
        }
        for _ in 0..self.settings.iterations {
            progress.check()?;
            self.descend(normals);
            if prevent_flips {
                undo_flips(self.mesh, normals, &self.positions, &mut self.next, 0);
            }
            std::mem::swap(&mut self.positions, &mut self.next);
        }
        Ok(())
    }

    /// Takes one step of the descent from `positions` to `next`.
    fn descend(&mut self, normals: &[DVec3]) {
        let Self { mesh, settings, input, fixed, positions, next, centroids } = self;
        let positions: &[DVec3] = positions;
        centroids.par_iter_mut().zip(&mesh.triangles).with_min_len(2048).for_each(|(centroid, t)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            *centroid = (a + b + c) / 3.0;
        });
        let w = settings.closeness;
        next.par_iter_mut().enumerate().with_min_len(1024).for_each(|(v, out)| {
            let p = positions[v];
            if fixed[v] {
                *out = p;
                return;
            }
            let around = mesh.vertex_faces.get(v as Index);
            let sum = around.iter().fold(w * (input[v] - p), |sum, &f| {
                let n = normals[f as usize];
                sum + n * n.dot(centroids[f as usize] - p)
            });
            *out = p + sum / (around.len() as f64 + w);
        });
    }
}

/// Undoes steps that turn triangles away from their given normals: a vertex of such a triangle goes back from `to` towards
/// `from` (#V×3), `halvings` times by half of the step, and then all the way. A triangle whose vertices are all back is as it
/// was, so this ends.
pub(super) fn undo_flips(mesh: &TriangleMesh, normals: &[DVec3], from: &[DVec3], to: &mut [DVec3], halvings: u8) {
    let agrees = |f: Index, points: &[DVec3]| {
        let [a, b, c] = mesh.triangles[f as usize].map(|v| points[v as usize]);
        (b - a).cross(c - a).dot(normals[f as usize]) > 0.0
    };
    let is_flipped = |f: &Index, to: &[DVec3]| !agrees(*f, to) && agrees(*f, from);
    let all = (0..mesh.face_count() as Index).into_par_iter().with_min_len(2048);
    let mut queue: Vec<Index> = all.filter(|f| is_flipped(f, to)).collect();
    let mut halved = vec![0; if halvings == 0 || queue.is_empty() { 0 } else { to.len() }];
    while let Some(f) = queue.pop() {
        if !is_flipped(&f, to) {
            continue;
        }
        for v in mesh.triangles[f as usize] {
            let i = v as usize;
            if to[i] == from[i] {
                continue;
            }
            match halved.get_mut(i) {
                Some(times) if *times < halvings => {
                    *times += 1;
                    to[i] = (from[i] + to[i]) / 2.0;
                }
                _ => to[i] = from[i],
            }
            queue.extend(mesh.vertex_faces.get(v));
        }
    }
}

#[cfg(test)]
mod tests;
