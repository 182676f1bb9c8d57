//! Laplacian smoothing: steps towards the mean of the neighbours.
//!
//! David A. Field. Laplacian smoothing and Delaunay triangulations. 1988; with cotangent weights Desbrun, Meyer,
//! Schröder, Barr. Implicit fairing of irregular meshes using diffusion and curvature flow. SIGGRAPH 1999.
//!
//! One iteration is xᵢ ← xᵢ + s (Σⱼ wᵢⱼ xⱼ / Σⱼ wᵢⱼ − xᵢ) at all vertices at once. With s = 1 and one iteration δᵢ is
//! pᵢ minus the mean of its neighbours. Noise at the scale of an edge goes in a few steps; more of them shrink.

use super::boundary::{BOUNDARY, Boundary};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::Parameter;
use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use crate::mesh::laplacian;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Laplacian`](super::Denoiser::Laplacian).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Laplacian {
    /// Number of steps.
    pub iterations: u32,
    /// s, the share of the way that one step goes; stable in 0..=1.
    pub step: f64,
    /// wᵢⱼ.
    pub weights: EdgeWeights,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Default for Laplacian {
    /// Three half steps: on most meshes the best of the fixed numbers of steps, for noise of a fifth of an edge.
    fn default() -> Self {
        Self { iterations: 3, step: 0.5, weights: EdgeWeights::Uniform, boundary: Boundary::Fixed }
    }
}

named! {
    /// Weight of a neighbour in a mean of neighbours.
    ///
    /// Negative cotangents count as zero, so that each mean stays inside the ring of neighbours.
    #[derive(Default)]
    pub enum EdgeWeights {
        /// The same for all neighbours; vertices also slide along the surface, and triangles become regular.
        #[default]
        Uniform = "uniform",
        /// Cotangents of the angles opposite to the edge, of the input mesh; triangles keep their shape.
        Cotangent = "cotangent",
    }
}

/// Parameter of all methods with a choice of weights.
pub(super) const WEIGHTS: Parameter =
    Parameter::word::<EdgeWeights>("weights", "/weights", "how much each neighbour counts");

/// Parameter of all methods with a share of the way to the mean of the neighbours.
pub(super) const STEP: Parameter =
    Parameter::number("step", "/step", [0.0, 1.0], "share of the way to the mean of the neighbours that a step goes");

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] =
    &[Parameter::count("iterations", "/iterations", 100, "number of steps"), STEP, WEIGHTS, BOUNDARY];

impl DenoiseMethod for Laplacian {
    const INFO: MethodInfo = MethodInfo {
        name: "laplacian",
        summary: "Steps towards the mean of the neighbours: for light noise on organic shapes",
        reference: Some(Reference {
            cite: "Field 1988",
            title: "Laplacian smoothing and Delaunay triangulations. Communications in Applied Numerical Methods 4 (6)",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }
}

/// Smooths and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(
    surface: &Surface,
    settings: &Laplacian,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let steps = (0..settings.iterations).map(|_| settings.step);
    Smoother::new(surface, settings.weights, settings.boundary).deltas(steps, settings.iterations as usize, progress)
}

/// Explicit Laplacian steps on one surface: towards the means of the neighbours, or away from them.
pub(super) struct Smoother<'a> {
    surface: &'a Surface,
    /// Cotangent weights; `None` for uniform weights.
    cotangents: Option<Csr>,
    boundary: Boundary,
}

impl<'a> Smoother<'a> {
    pub(super) fn new(surface: &'a Surface, weights: EdgeWeights, boundary: Boundary) -> Self {
        let cotangents = match weights {
            EdgeWeights::Uniform => None,
            EdgeWeights::Cotangent => Some(laplacian::cotangent(surface)),
        };
        Self { surface, cotangents, boundary }
    }

    /// Takes `count` steps of the given sizes and returns δ = p − p*, zero where a vertex stays. #V×3, model units
    pub(super) fn deltas(
        &self,
        steps: impl Iterator<Item = f64>,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let topology = self.surface.topology();
        let fixed = |v: usize| self.boundary == Boundary::Fixed && topology.is_boundary(v as Index);
        let mut positions = self.surface.positions().to_vec();
        let mut next = positions.clone();
        for (done, step) in (1..).zip(steps) {
            progress.check()?;
            let old = &positions;
            next.par_iter_mut().zip(old).enumerate().for_each(|(v, (next, x))| {
                *next = if fixed(v) { *x } else { *x + step * self.towards_mean(old, v) };
            });
            std::mem::swap(&mut positions, &mut next);
            progress.done(f64::from(done) / count as f64);
        }
        positions.par_iter_mut().zip(self.surface.positions()).for_each(|(x, p)| *x = *p - *x);
        Ok(positions)
    }

    /// Offset of a vertex to the weighted mean of its neighbours, model units.
    fn towards_mean(&self, positions: &[DVec3], v: usize) -> DVec3 {
        let Some(matrix) = &self.cotangents else {
            return laplacian::uniform_at(self.surface.topology(), positions, v as Index);
        };
        let p = positions[v];
        let row = matrix.row(v as Index).iter().filter(|&&(j, w)| j as usize != v && w > 0.0);
        let (sum, total) =
            row.fold((DVec3::ZERO, 0.0), |(sum, total), &(j, w)| (sum + (positions[j as usize] - p) * w, total + w));
        if total > 0.0 { sum / total } else { DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn one_full_step_ends_at_the_mean_of_the_neighbours() {
        let surface = shapes::dented_sphere(2);
        let one = Laplacian { iterations: 1, step: 1.0, ..Laplacian::default() };
        for (v, delta) in (0..).zip(deltas(&surface, &one, &Silent).unwrap()) {
            let ring = surface.topology().rings().get(v);
            let mean = ring.iter().map(|&n| surface.positions()[n as usize]).sum::<DVec3>() / ring.len() as f64;
            let p = surface.positions()[v as usize];
            // p − (p + (mean − p)): two roundings of numbers of size one.
            assert!(delta.distance(p - mean) < 1e-15);
        }
    }

    #[test]
    fn one_full_step_with_cotangent_weights_ends_at_the_mean_by_those_weights() {
        let surface = shapes::dented_sphere(2);
        let p = surface.positions();
        let triangles: Vec<_> = surface.triangles().collect();
        let settings = Laplacian { iterations: 1, step: 1.0, weights: EdgeWeights::Cotangent, ..Laplacian::default() };
        for (v, delta) in (0..).zip(deltas(&surface, &settings, &Silent).unwrap()) {
            let weight = |w: Index| -> f64 {
                let opposite = triangles.iter().filter(|t| t.contains(&v) && t.contains(&w)).map(|t| {
                    let o = t.iter().find(|&&o| o != v && o != w).unwrap();
                    let [a, b] = [v, w].map(|end| p[end as usize] - p[*o as usize]);
                    1.0 / a.angle_between(b).tan()
                });
                opposite.sum()
            };
            let ring = surface.topology().rings().get(v).iter().map(|&w| (p[w as usize], weight(w)));
            // Obtuse triangles give weights that would push.
            let pulling: Vec<(DVec3, f64)> = ring.filter(|(_, weight)| *weight > 0.0).collect();
            let total: f64 = pulling.iter().map(|(_, weight)| weight).sum();
            let mean = pulling.iter().map(|(x, weight)| *x * *weight).sum::<DVec3>() / total;
            assert!(delta.distance(p[v as usize] - mean) < 1e-13, "{v}: {delta}");
        }
    }

    #[test]
    fn a_regular_sphere_shrinks_by_the_eigenvalue_of_its_coordinates() {
        // Coordinates are eigenfunctions of the Laplacian: all vertices move inwards, and by much the same.
        let sphere = shapes::sphere(3);
        let settings = Laplacian { iterations: 1, step: 1.0, ..Laplacian::default() };
        let inwards: Vec<f64> = deltas(&sphere, &settings, &Silent)
            .unwrap()
            .iter()
            .zip(sphere.positions())
            .map(|(d, p)| d.dot(*p))
            .collect();
        let (low, high) = inwards.iter().fold((f64::MAX, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
        assert!(low > 0.0 && high < 2.0 * low, "{low} {high}");
    }
}
