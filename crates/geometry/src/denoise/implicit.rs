//! Implicit fairing: diffusion by long, stable steps.
//!
//! Mathieu Desbrun, Mark Meyer, Peter Schröder, Alan H. Barr. Implicit fairing of irregular meshes using diffusion and
//! curvature flow. SIGGRAPH 1999: backward Euler, (1 − t L) x = p (eq. 9), which is stable for every t.
//!
//! L is made symmetric by a mass matrix: (M − t S) x = M p. With uniform weights M is the number of neighbours and S their
//! adjacency matrix minus M, so that L x is the offset to the mean of the neighbours. With cotangents M is a third of the
//! area around a vertex in units of its mean, which makes the step one of mean curvature flow. The unknown is x − p, so the
//! origin does not matter.

#[cfg_attr(any(target_family = "wasm", not(feature = "direct-solver")), path = "implicit/no_cholesky.rs")]
mod cholesky;

use super::EdgeWeights;
use super::boundary::{BOUNDARY, Boundary};
use super::conjugate_gradients::{ConjugateGradients, Stop, multiply};
use super::laplacian::WEIGHTS;
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::{HUGE, Parameter};
use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use crate::mesh::laplacian;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
use cholesky::Factor;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Implicit`](super::Denoiser::Implicit).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Implicit {
    /// Number of steps.
    pub iterations: u32,
    /// t, how long a step is. A step of the plain Laplacian is as long as its share of the way.
    pub time: f64,
    /// Weights of the neighbours, those of the input in each step.
    pub weights: EdgeWeights,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
    /// How the system is solved.
    pub solver: Solver,
}

named! {
    /// How a linear system is solved.
    #[derive(Default)]
    pub enum Solver {
        /// Conjugate gradients: for meshes of every size.
        #[default]
        Iterative = "iterative",
        /// Sparse Cholesky factorisation: exact to the last digit, for up to about 100,000 vertices.
        Direct = "direct",
    }
}

impl Default for Implicit {
    /// Five steps that are half as long as one to the mean of the neighbours: nearer to the true normals than one long
    /// step that moves vertices as far.
    fn default() -> Self {
        let (weights, boundary, solver) = <_>::default();
        Self { iterations: 5, time: 0.5, weights, boundary, solver }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of steps"),
    Parameter::number("time", "/time", [0.0, HUGE], "length of a step")
        .slider(10.0)
        .unit("whole steps of the method laplacian"),
    Parameter::word::<Solver>("solver", "/solver", "how the linear system of a step is solved"),
    WEIGHTS,
    BOUNDARY,
];

impl DenoiseMethod for Implicit {
    const INFO: MethodInfo = MethodInfo {
        name: "implicit",
        summary: "Long, stable smoothing steps, each the solution of a linear system: for strong smoothing",
        reference: Some(Reference {
            cite: "Desbrun et al. 1999",
            title: "Implicit fairing of irregular meshes using diffusion and curvature flow. SIGGRAPH",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }
}

/// Smooths and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &Implicit, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let system = System::new(surface, settings);
    let factor = match settings.solver {
        Solver::Direct => Factor::of(&system.matrix),
        Solver::Iterative => None,
    };
    let mut positions = surface.positions().to_vec();
    for done in 1..=settings.iterations {
        progress.check()?;
        let right = system.right(&positions);
        let step = match &factor {
            Some(factor) => factor.backsolve(&right),
            None => system.iterate(&right, progress)?,
        };
        positions.par_iter_mut().zip(step).for_each(|(x, step)| *x += step);
        progress.done(f64::from(done) / f64::from(settings.iterations));
    }
    Ok(surface.positions().iter().zip(positions).map(|(p, x)| *p - x).collect())
}

/// The linear system of one step: M − t S on the vertices that move, and 1 on the diagonal of the others.
struct System {
    matrix: Csr,
    /// Matrix t S, whose rows are empty for vertices that stay.
    scaled_stiffness: Csr,
}

impl System {
    fn new(surface: &Surface, settings: &Implicit) -> Self {
        let topology = surface.topology();
        let (stiffness, mass) = match settings.weights {
            EdgeWeights::Uniform => {
                let edges = topology.edges().iter();
                let entries = edges.flat_map(|&[a, b]| [(a, b, 1.0), (b, a, 1.0), (a, a, -1.0), (b, b, -1.0)]);
                let valence = |v: Index| topology.rings().get(v).len() as f64;
                let mass: Vec<f64> = (0..topology.vertex_count() as Index).map(valence).collect();
                (Csr::from_triplets(topology.vertex_count(), entries), mass)
            }
            EdgeWeights::Cotangent => {
                let mass = laplacian::mass(surface);
                let mean = mass.iter().sum::<f64>() / mass.iter().filter(|m| **m > 0.0).count().max(1) as f64;
                (laplacian::cotangent(surface), mass.iter().map(|m| m / mean).collect())
            }
        };
        let stays =
            |v: Index| mass[v as usize] <= 0.0 || settings.boundary == Boundary::Fixed && topology.is_boundary(v);
        let moving = |v: Index| (0..).zip(stiffness.row(v)).filter(move |_| !stays(v)).map(|e| *e.1);
        let vertices = 0..topology.vertex_count() as Index;
        let scaled_stiffness = vertices.clone().flat_map(|v| moving(v).map(move |(j, w)| (v, j, settings.time * w)));
        let system = scaled_stiffness.clone().filter(|e| !stays(e.1)).map(|(v, j, w)| (v, j, -w));
        let masses = vertices.map(|v| (v, v, if stays(v) { 1.0 } else { mass[v as usize] }));
        Self {
            matrix: Csr::from_triplets(mass.len(), system.chain(masses)),
            scaled_stiffness: Csr::from_triplets(mass.len(), scaled_stiffness),
        }
    }

    /// Right-hand side t S x. #V×3
    fn right(&self, positions: &[DVec3]) -> Vec<DVec3> {
        // Differences, since far from the origin the sum of positions would round them away.
        let of_row = |v: usize| {
            let towards = |&(j, w): &(Index, f64)| (positions[j as usize] - positions[v]) * w;
            self.scaled_stiffness.row(v as Index).iter().map(towards).sum()
        };
        (0..positions.len()).into_par_iter().map(of_row).collect()
    }

    fn iterate(&self, right: &[DVec3], progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        let own = |(v, row): (Index, &[(Index, f64)])| row.iter().find(|e| e.0 == v).map_or(1.0, |e| e.1);
        let diagonal: Vec<f64> = (0..).zip(self.matrix.rows()).map(own).collect();
        let product = |x: &[DVec3], out: &mut [DVec3]| multiply(x, out, |v| self.matrix.row_times(v, x));
        let guess = vec![DVec3::ZERO; right.len()];
        let stop = Stop { tolerance: 1e-12, ..Stop::default() };
        ConjugateGradients::new(&diagonal).solve_from(product, guess, right, stop, progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn both_solvers_find_the_same_surface() {
        for surface in [shapes::dented_sphere(3), shapes::grid(9)] {
            for weights in [EdgeWeights::Uniform, EdgeWeights::Cotangent] {
                let [a, b] = [Solver::Direct, Solver::Iterative].map(|solver| {
                    let settings = Implicit { iterations: 2, time: 30.0, weights, solver, ..Implicit::default() };
                    deltas(&surface, &settings, &Silent).unwrap()
                });
                for (a, b) in a.iter().zip(b) {
                    // Residual 1e-12, condition number below 1 + 2 · 30.
                    assert!(a.distance(b) < 1e-10, "{weights:?}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn a_step_solves_its_equation() {
        // x − t (mean of the neighbours − x) is the input again.
        let surface = shapes::dented_sphere(2);
        let settings = Implicit { iterations: 1, time: 3.0, ..Implicit::default() };
        let deltas = deltas(&surface, &settings, &Silent).unwrap();
        let x = surface.moved_by(&deltas);
        for ((x, to_mean), p) in x.iter().zip(laplacian::uniform(surface.topology(), &x)).zip(surface.positions()) {
            assert!((*x - 3.0 * to_mean).distance(*p) < 1e-10);
        }
    }

    #[test]
    fn an_endless_step_with_a_fixed_boundary_ends_in_a_flat_sheet() {
        let grid = shapes::grid(8);
        let bumpy = grid.positions().iter().map(|p| *p + DVec3::Z * (p.x * (1.0 - p.x) * p.y * (1.0 - p.y)));
        let surface = grid.at(bumpy.collect());
        let settings = Implicit { iterations: 1, time: 1e9, solver: Solver::Direct, ..Implicit::default() };
        for (p, delta) in surface.positions().iter().zip(deltas(&surface, &settings, &Silent).unwrap()) {
            // The boundary is at z = 0; what is left is one part in 1e9 over the smallest eigenvalue, 0.1.
            assert!((p.z - delta.z).abs() < 1e-8);
        }
    }
}
