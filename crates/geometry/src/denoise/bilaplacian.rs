//! The uniform umbrella operator, and one long step of bi-Laplacian smoothing with it.
//!
//! Leif Kobbelt, Swen Campagna, Jens Vorsatz, Hans-Peter Seidel. Interactive multi-resolution modeling on arbitrary
//! meshes. SIGGRAPH 1998: (U x)ᵢ = xᵢ − mean of the neighbours.
//!
//! At a boundary vertex only its two boundary neighbours count, with weight ½; if it has more or fewer than two, its row
//! is zero, and the data alone hold it. Non-manifold edges, and edges whose faces disagree about the orientation, count as
//! boundary here.

use super::boundary::Boundary;
use super::conjugate_gradients::{CHUNK, ConjugateGradients, Stop, multiply};
use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::mesh::topology::EdgeKind;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// The umbrella operator U and its transpose.
pub(super) struct Umbrella {
    rows: Csr,
    columns: Csr,
    /// True for each vertex on an edge that does not have exactly two faces of the same orientation. #V
    pub(super) irregular: Vec<bool>,
}

impl Umbrella {
    pub(super) fn of(surface: &Surface) -> Self {
        let topology = surface.topology();
        let count = topology.vertex_count();
        let mut irregular = vec![false; count];
        for (e, edge) in (0..).zip(topology.edges()) {
            if topology.edge_kind(e) != EdgeKind::Interior {
                edge.iter().for_each(|&v| irregular[v as usize] = true);
            }
        }
        let mut entries = Vec::with_capacity(8 * count);
        for v in 0..count as Index {
            let ring = topology.rings().get(v);
            let along_boundary = || ring.iter().filter(|w| irregular[**w as usize]);
            if !irregular[v as usize] {
                let weight = -1.0 / ring.len() as f64;
                entries.extend(ring.iter().map(|&w| (v, w, weight)));
                entries.extend((!ring.is_empty()).then_some((v, v, 1.0)));
            } else if along_boundary().count() == 2 {
                entries.extend(along_boundary().map(|&w| (v, w, -0.25)));
                entries.push((v, v, 0.5));
            }
        }
        let rows = Csr::from_triplets(count, entries.iter().copied());
        let columns = Csr::from_triplets(count, entries.iter().map(|&(v, w, x)| (w, v, x)));
        Self { rows, columns, irregular }
    }

    /// U and its transpose in single precision.
    pub(super) fn in_single_precision(&self) -> [Csr<f32>; 2] {
        [&self.rows, &self.columns].map(Csr::in_single_precision)
    }

    /// Entries (column, value) of row v of U.
    pub(super) fn row(&self, v: Index) -> &[(Index, f64)] {
        self.rows.row(v)
    }

    /// Row v of the product U x.
    pub(super) fn at(&self, x: &[DVec3], v: usize) -> DVec3 {
        self.rows.row_times(v, x)
    }

    /// Row v of the product Uᵀ y.
    pub(super) fn transposed_at(&self, y: &[DVec3], v: usize) -> DVec3 {
        self.columns.row_times(v, y)
    }

    /// Solves (1 + μ UᵀU) x = x⁰ for positions `x` = x⁰ (#V×3, model units); vertices that the constraint fixes stay.
    pub(super) fn smoothed(
        &self,
        x: &[DVec3],
        mu: f64,
        constraint: &BoundaryConstraint,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let mut umbrellas = vec![DVec3::ZERO; x.len()];
        let mut product = |x: &[DVec3], out: &mut [DVec3], identity: f64| {
            let slots = umbrellas.par_iter_mut().enumerate().with_min_len(CHUNK);
            slots.for_each(|(v, umbrella)| *umbrella = mu * self.at(x, v));
            multiply(x, out, |v| constraint.projected(v, identity * x[v] + self.transposed_at(&umbrellas, v)))
        };
        // Offsets from the input are solved for, since they do not depend on where the origin is.
        let mut right = vec![DVec3::ZERO; x.len()];
        product(x, &mut right, 0.0);
        right.iter_mut().for_each(|r| *r = -*r);
        let stop = Stop { tolerance: 1e-4, max_steps: 100 };
        let guess = vec![DVec3::ZERO; x.len()];
        let ones = vec![1.0; x.len()];
        let mut solver = ConjugateGradients::new(&ones);
        let offsets = solver.solve_from(|w, out| product(w, out, 1.0), guess, &right, stop, progress)?;
        Ok(x.iter().zip(offsets).map(|(x, offset)| *x + offset).collect())
    }
}

impl Umbrella {
    /// One lazy umbrella step: each vector of `x` (#V×3) moves half way to the mean of its neighbours.
    pub(super) fn lazy_step(&self, x: &[DVec3]) -> Vec<DVec3> {
        (0..x.len()).into_par_iter().with_min_len(CHUNK).map(|v| x[v] - 0.5 * self.at(x, v)).collect()
    }

    /// Minimises Σ |xᵥ − x⁰ᵥ|² / (μᵥ hᵥ²) + Σ |(U x)ᵥ|² / hᵥ², with a strength μ and a length h of the local edges for each
    /// vertex: the smoothing of [`Self::smoothed`] with strengths that vary. Vertices with μ = 0 stay. #V×3, model units
    pub(super) fn smoothed_locally(
        &self,
        x: &[DVec3],
        local: LocalStrength,
        constraint: &BoundaryConstraint,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        // With x = x⁰ + G y and G = h √μ the system is (1 + G Uᵀ h⁻² U G) y = −G Uᵀ h⁻² U x⁰, which is well conditioned.
        let scale: Vec<f64> = local.strength.iter().zip(local.edge).map(|(mu, edge)| mu.sqrt() * edge).collect();
        let weight: Vec<f64> = local.edge.iter().map(|h| if *h > 0.0 { h.powi(-2) } else { 0.0 }).collect();
        let mut scaled = vec![DVec3::ZERO; x.len()];
        let mut umbrellas = vec![DVec3::ZERO; x.len()];
        let mut bend = |x: &[DVec3], out: &mut [DVec3], identity: f64, of: &[DVec3]| {
            let slots = umbrellas.par_iter_mut().enumerate().with_min_len(CHUNK);
            slots.for_each(|(v, umbrella)| *umbrella = weight[v] * self.at(of, v));
            let row = |v: usize| identity * x[v] + scale[v] * self.transposed_at(&umbrellas, v);
            multiply(x, out, |v| constraint.projected(v, row(v)))
        };
        let mut right = vec![DVec3::ZERO; x.len()];
        bend(x, &mut right, 0.0, x);
        right.iter_mut().for_each(|r| *r = -*r);
        let stop = Stop { tolerance: 1e-4, max_steps: 100 };
        let ones = vec![1.0; x.len()];
        let mut solver = ConjugateGradients::new(&ones);
        let product = |y: &[DVec3], out: &mut [DVec3]| {
            scaled.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, s)| *s = scale[v] * y[v]);
            bend(y, out, 1.0, &scaled)
        };
        let guess = vec![DVec3::ZERO; x.len()];
        let y = solver.solve_from(product, guess, &right, stop, progress)?;
        Ok(x.iter().zip(y).zip(&scale).map(|((x, y), s)| *x + *s * y).collect())
    }
}

/// Strength of a smoothing at each vertex.
#[derive(Clone, Copy)]
pub(super) struct LocalStrength<'a> {
    /// Strength μ. #V
    pub(super) strength: &'a [f64],
    /// Length h of the local edges, model units. #V
    pub(super) edge: &'a [f64],
}

/// Constraint that vertices at the boundary stay, as a projection; the default lets all vertices move.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundaryConstraint {
    /// True for vertices that stay. #V, or empty where all vertices may move
    fixed: Vec<bool>,
}

impl BoundaryConstraint {
    pub(super) fn of(surface: &Surface, boundary: Boundary) -> Self {
        let topology = surface.topology();
        let fixed = match boundary {
            Boundary::Free => Vec::new(),
            Boundary::Fixed => (0..topology.vertex_count() as Index).map(|v| topology.is_boundary(v)).collect(),
        };
        Self { fixed }
    }

    /// The constraint that these vertices stay as well. #V
    pub(super) fn and_fixed(mut self, fixed: impl Iterator<Item = bool>) -> Self {
        if self.fixed.is_empty() {
            self.fixed = fixed.collect();
        } else {
            self.fixed.iter_mut().zip(fixed).for_each(|(own, fixed)| *own |= fixed);
        }
        self
    }

    /// Constraint of a part of the surface, whose vertices have these indices in the whole.
    pub(super) fn of_part(&self, vertices: &[Index]) -> Self {
        if self.fixed.is_empty() {
            return Self::default();
        }
        Self { fixed: vertices.iter().map(|&v| self.fixed[v as usize]).collect() }
    }

    /// Whether vertex v stays.
    pub(super) fn holds(&self, v: usize) -> bool {
        self.fixed.get(v).is_some_and(|fixed| *fixed)
    }

    /// Offset that vertex v may take: the given one, or zero where the vertex stays.
    pub(super) fn projected(&self, v: usize, offset: DVec3) -> DVec3 {
        if self.holds(v) { DVec3::ZERO } else { offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn a_solution_of_the_smoothing_solves_it() {
        let surface = shapes::dented_sphere(2);
        let umbrella = Umbrella::of(&surface);
        let x = umbrella.smoothed(surface.positions(), 0.5, &BoundaryConstraint::default(), &Silent).unwrap();
        let umbrellas: Vec<_> = (0..x.len()).map(|v| umbrella.at(&x, v)).collect();
        for (v, (x, p)) in x.iter().zip(surface.positions()).enumerate() {
            let residual = *x + 0.5 * umbrella.transposed_at(&umbrellas, v) - *p;
            // A ten-thousandth of a right-hand side that is below 0.1.
            assert!(residual.length() < 1e-5, "{residual}");
        }
    }

    #[test]
    fn a_straight_boundary_is_not_bent() {
        let grid = shapes::grid(4);
        let umbrella = Umbrella::of(&grid);
        let corners = (0..25).filter(|&v| umbrella.irregular[v] && umbrella.at(grid.positions(), v).length() > 1e-15);
        assert_eq!(corners.count(), 4);
    }

    #[test]
    fn a_part_of_the_surface_has_the_constraint_of_the_whole() {
        let grid = shapes::grid(4);
        for boundary in [Boundary::Fixed, Boundary::Free] {
            let whole = BoundaryConstraint::of(&grid, boundary);
            let vertices: Vec<Index> = (0..25).rev().step_by(3).collect();
            let part = whole.of_part(&vertices);
            assert!((0..).zip(&vertices).all(|(k, &v)| part.holds(k) == whole.holds(v as usize)));
            let held = (0..vertices.len()).filter(|&k| part.holds(k)).count();
            assert!(
                boundary == Boundary::Free && held == 0 || held > 0 && held < vertices.len(),
                "{boundary:?}: {held}"
            );
        }
    }
}
