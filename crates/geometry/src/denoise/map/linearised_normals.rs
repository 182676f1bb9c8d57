//! Face normals as a linear function of the vertex positions, in single precision: normals are not linear to more digits.

use crate::denoise::conjugate_gradients::CHUNK;
use crate::denoise::connectivity::Connectivity;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// First-order model of the face normals around given positions: n(x + dx) ≈ n − Σₖ gₖ (n · dxₖ) over the corners k of
/// each triangle.
#[derive(Default)]
pub(in crate::denoise) struct LinearisedNormals {
    /// Unit normal n of each triangle; zero for a triangle without area. #T×3
    pub(in crate::denoise) normals: Vec<Vec3A>,
    /// gₖ = n × eₖ / 2A for each corner, with eₖ the edge opposite to the corner and A the area. #T×3×3
    pub(in crate::denoise) gradients: Vec<[Vec3A; 3]>,
    /// Area of each triangle. #T
    pub(in crate::denoise) areas: Vec<f64>,
}

impl LinearisedNormals {
    /// Linearises at `positions` (#V×3). Longer gradients |gₖ| than `max_gradient` of the triangle, which are those of slivers,
    /// are shortened to it, so that slivers do not outweigh all other triangles.
    pub(in crate::denoise) fn update(
        &mut self,
        connectivity: &Connectivity,
        positions: &[DVec3],
        max_gradient: impl Fn(usize) -> f64 + Sync,
    ) {
        let count = connectivity.mesh.face_count();
        self.normals.resize(count, Vec3A::ZERO);
        self.gradients.resize(count, [Vec3A::ZERO; 3]);
        self.areas.resize(count, 0.0);
        let slots = self.normals.par_iter_mut().zip(&mut self.gradients).zip(&mut self.areas);
        let all = slots.zip(&connectivity.mesh.triangles).enumerate().with_min_len(CHUNK);
        all.for_each(|(f, (((normal, gradients), area), t))| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let doubled = (b - a).cross(c - a);
            let length = doubled.length();
            let n = doubled.normalize_or_zero();
            *normal = n.as_vec3a();
            *area = length / 2.0;
            *gradients = [c - b, a - c, b - a].map(|edge| {
                let g = n.cross(edge) / length;
                if g.is_finite() { g.clamp_length_max(max_gradient(f)).as_vec3a() } else { Vec3A::ZERO }
            });
        });
    }

    /// Directional derivative of each normal (`out`, #T×3) for offsets of the vertices (#V×3).
    pub(in crate::denoise) fn apply_jacobian(&self, connectivity: &Connectivity, offsets: &[Vec3A], out: &mut [Vec3A]) {
        let slots = out.par_iter_mut().zip(&self.normals).zip(&self.gradients).zip(&connectivity.mesh.triangles);
        slots.with_min_len(CHUNK).for_each(|(((out, n), gradients), t)| {
            let tilt = |k: usize| gradients[k] * n.dot(offsets[t[k] as usize]);
            *out = -(tilt(0) + tilt(1) + tilt(2));
        });
    }
}

#[cfg(test)]
mod tests;
