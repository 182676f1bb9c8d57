//! The vertices that fit given face normals best.
//!
//! Minimises Σ_f Σ_{(i,j) ∈ f} (n_f · (xᵢ − xⱼ))² / 3 + w Σᵢ |xᵢ − aᵢ|² over the edges of each face; the first sum is
//! Σ_f Σ_{i∈f} (n_f · (c_f − xᵢ))², whose descent Sun et al. 2007 take steps of. With one unknown for each vertex,
//! xᵢ = pᵢ − hᵢ dᵢ, the same system is solved in the space that the directions d span.

use crate::denoise::conjugate_gradients::{Stop, multiply, solve};
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use glam::DVec3;
use rayon::prelude::*;

/// How often the way of a vertex is halved before it stays where it was. One step goes all the way, so that putting it
/// back whole would leave spikes.
pub(in crate::denoise) const HALVINGS: u8 = 4;

/// Vertices move by much less than that of what is left when this is reached.
const ENOUGH: Stop = Stop { tolerance: 1e-8, max_steps: 1000 };

/// What is fitted.
pub(in crate::denoise) struct System<'a> {
    pub(in crate::denoise) mesh: &'a TriangleMesh,
    /// #T×3, unit or zero.
    pub(in crate::denoise) normals: &'a [DVec3],
    /// Vertices that stay. #V
    pub(in crate::denoise) fixed: &'a [bool],
    /// Directions of motion (#V×3, unit or zero); none where it is free.
    pub(in crate::denoise) along: Option<&'a [DVec3]>,
    /// w: 1 pulls as hard as one of the faces around.
    pub(in crate::denoise) closeness: f64,
}

impl System<'_> {
    /// The best places that can be reached from `start`, held near to `anchors`. #V×3, model units
    pub(in crate::denoise) fn solve(
        &self,
        start: &[DVec3],
        anchors: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let w = self.closeness;
        let around = |v: usize| self.mesh.vertex_faces.get(v as Index).iter().map(|&f| f as usize);
        let mut means = vec![0.0; self.mesh.face_count()];
        // n_f · mean of the three corners.
        let measure = |x: &[DVec3], means: &mut Vec<f64>| {
            means.par_iter_mut().enumerate().with_min_len(2048).for_each(|(f, mean)| {
                let [a, b, c] = self.mesh.triangles[f].map(|v| x[v as usize]);
                *mean = self.normals[f].dot(a + b + c) / 3.0;
            });
        };
        let allowed = |v: usize, way: DVec3| match self.along {
            _ if self.fixed[v] => DVec3::ZERO,
            None => way,
            Some(along) => along[v] * along[v].dot(way),
        };
        let indices = || (0..start.len()).into_par_iter().with_min_len(1024);
        let pull = |v: usize| {
            let at = start[v];
            around(v).fold(w * (anchors[v] - at), |sum, f| {
                let n = self.normals[f];
                let [a, b, c] = self.mesh.triangles[f].map(|v| start[v as usize] - at);
                sum + n * (n.dot(a + b + c) / 3.0)
            })
        };
        let right: Vec<DVec3> = indices().map(|v| allowed(v, pull(v))).collect();
        let stiffness = |v: usize| match self.along {
            None => w + around(v).map(|f| self.normals[f].length_squared()).sum::<f64>() * 2.0 / 9.0,
            Some(along) => w + around(v).map(|f| self.normals[f].dot(along[v]).powi(2)).sum::<f64>() * 2.0 / 3.0,
        };
        let diagonal: Vec<f64> = indices().map(stiffness).collect();
        let system = |x: &[DVec3], out: &mut [DVec3]| {
            measure(x, &mut means);
            multiply(x, out, |v| {
                let sum = around(v).fold(w * x[v], |sum, f| {
                    let n = self.normals[f];
                    sum + n * (n.dot(x[v]) - means[f])
                });
                allowed(v, sum)
            })
        };
        let ways = solve(system, &diagonal, &right, vec![DVec3::ZERO; start.len()], ENOUGH, progress)?;
        Ok(start.iter().zip(ways).map(|(p, way)| *p + way).collect())
    }
}
