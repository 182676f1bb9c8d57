//! Vertex update by least squares: the vertices that fit given face normals best.
//!
//! Minimises Σ_f Σ_{(i,j) ∈ f} (n_f · (xᵢ − xⱼ))² / 3 + w Σᵢ |xᵢ − aᵢ|² over the edges of each face, with anchors aᵢ. The
//! first sum is Σ_f Σ_{i∈f} (n_f · (c_f − xᵢ))², on which Sun et al. 2007 take steps of descent. If vertices may move along
//! one direction each, xᵢ = pᵢ − hᵢ dᵢ, the same system is solved in the space that the directions d span.

use crate::denoise::conjugate_gradients::{ConjugateGradients, Stop, multiply};
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// How often the step of a vertex is halved, to undo flips, before the vertex stays. One step goes all the way to the
/// solution, so that undoing it as a whole would leave spikes.
pub(in crate::denoise) const MAX_HALVINGS: u8 = 4;

/// Stopping criterion: about a millionth of the motion of a vertex remains at most.
const STOP: Stop = Stop { tolerance: 1e-8, max_steps: 1000 };

/// The least-squares problem.
pub(in crate::denoise) struct System<'a> {
    pub(in crate::denoise) mesh: &'a TriangleMesh,
    /// Face normals to be fitted. #T×3, unit or zero
    pub(in crate::denoise) normals: &'a [DVec3],
    /// True for vertices that stay. #V
    pub(in crate::denoise) fixed: &'a [bool],
    /// Direction of motion of each vertex (#V×3, unit or zero); `None` if vertices may move anywhere.
    pub(in crate::denoise) directions: Option<&'a [DVec3]>,
    /// Weight w of the anchors: 1 pulls as hard as one of the faces around a vertex.
    pub(in crate::denoise) closeness: f64,
}

impl System<'_> {
    /// Solves for the positions, from `start` on, with weight on the distance from `anchors`. #V×3, model units
    pub(in crate::denoise) fn solve(
        &self,
        start: &[DVec3],
        anchors: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let w = self.closeness;
        let mut means = vec![0.0; self.mesh.face_count()];
        let indices = || (0..start.len()).into_par_iter().with_min_len(1024);
        let right: Vec<DVec3> = indices().map(|v| self.allowed(v, self.pull(v, start, anchors[v]))).collect();
        let diagonal: Vec<f64> = indices().map(|v| self.stiffness(v)).collect();
        let operator = |x: &[DVec3], out: &mut [DVec3]| {
            self.update_means(x, &mut means);
            multiply(x, out, |v| {
                let sum = self.faces_around(v).fold(w * x[v], |sum, f| {
                    let n = self.normals[f];
                    sum + n * (n.dot(x[v]) - means[f])
                });
                self.allowed(v, sum)
            })
        };
        let guess = vec![DVec3::ZERO; start.len()];
        let offsets = ConjugateGradients::new(&diagonal).solve_from(operator, guess, &right, STOP, progress)?;
        Ok(start.iter().zip(offsets).map(|(p, offset)| *p + offset).collect())
    }

    fn faces_around(&self, v: usize) -> impl Iterator<Item = usize> + '_ {
        self.mesh.vertex_faces.get(v as Index).iter().map(|&f| f as usize)
    }

    /// Part of an offset that a vertex may take: zero, all of it, or its projection on the direction of motion.
    fn allowed(&self, v: usize, offset: DVec3) -> DVec3 {
        match self.directions {
            _ if self.fixed[v] => DVec3::ZERO,
            None => offset,
            Some(directions) => directions[v] * directions[v].dot(offset),
        }
    }

    /// Mean of n_f · x over the three corners of each face. #T
    fn update_means(&self, x: &[DVec3], means: &mut [f64]) {
        means.par_iter_mut().enumerate().with_min_len(2048).for_each(|(f, mean)| {
            let [a, b, c] = self.mesh.triangles[f].map(|v| x[v as usize]);
            *mean = self.normals[f].dot(a + b + c) / 3.0;
        });
    }

    /// Force on a vertex at the start: minus half the gradient of the functional, in differences of positions, so that it
    /// does not depend on where the origin is.
    fn pull(&self, v: usize, start: &[DVec3], anchor: DVec3) -> DVec3 {
        let p = start[v];
        self.faces_around(v).fold(self.closeness * (anchor - p), |sum, f| {
            let n = self.normals[f];
            let [a, b, c] = self.mesh.triangles[f].map(|v| start[v as usize] - p);
            sum + n * (n.dot(a + b + c) / 3.0)
        })
    }

    /// Diagonal of the matrix; for free vertices the mean over the three coordinates.
    fn stiffness(&self, v: usize) -> f64 {
        let faces = self.faces_around(v);
        let sum_of_squares = match self.directions {
            None => faces.map(|f| self.normals[f].length_squared()).sum::<f64>() * 2.0 / 9.0,
            Some(directions) => faces.map(|f| self.normals[f].dot(directions[v]).powi(2)).sum::<f64>() * 2.0 / 3.0,
        };
        self.closeness + sum_of_squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::face_geometry::FaceGeometry;
    use crate::mesh::shapes;

    #[test]
    fn the_preconditioner_is_the_diagonal_of_the_matrix() {
        let surface = shapes::dented_sphere(1);
        let (mesh, p) = (TriangleMesh::of(&surface), surface.positions());
        let normals = FaceGeometry::of(&mesh, p).normals;
        let directions: Vec<DVec3> = p.iter().map(|p| (*p + 0.3 * DVec3::X).normalize()).collect();
        for directions in [None, Some(&directions[..])] {
            let fixed = vec![false; p.len()];
            let system = System { mesh: &mesh, normals: &normals, fixed: &fixed, directions, closeness: 0.7 };
            for v in 0..p.len() {
                // The force is linear in the positions, and falls by the diagonal entry for each unit of motion.
                let entry = |axis: DVec3| {
                    let mut moved = p.to_vec();
                    moved[v] += axis;
                    (system.pull(v, p, p[v]) - system.pull(v, &moved, p[v])).dot(axis)
                };
                let expected = match directions {
                    None => DVec3::AXES.map(entry).iter().sum::<f64>() / 3.0,
                    Some(directions) => entry(directions[v]),
                };
                assert!((system.stiffness(v) - expected).abs() < 1e-12, "{v}: {expected}");
            }
        }
    }
}
