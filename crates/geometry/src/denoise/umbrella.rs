//! The uniform umbrella, and one long step of bi-Laplacian smoothing with it.
//!
//! (U x)ᵢ = xᵢ − mean of the neighbours. On the rim, where the ring is open, the neighbours are the two along the rim and
//! the row counts half; where those are not two, the row is zero and the vertex is held by its data alone.

use super::Boundary;
use super::conjugate_gradients::{CHUNK, Stop, multiply, solve};
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::sparse::Csr;
use crate::surface::Surface;
use crate::topology::EdgeKind;
use glam::DVec3;
use rayon::prelude::*;

/// U and its transpose.
pub(super) struct Umbrella {
    rows: Csr,
    columns: Csr,
    /// Vertices on an edge that has not two faces of the same orientation.
    pub(super) rim: Vec<bool>,
}

impl Umbrella {
    pub(super) fn of(surface: &Surface) -> Self {
        let topology = surface.topology();
        let count = topology.vertex_count();
        let mut rim = vec![false; count];
        for (e, edge) in (0..).zip(topology.edges()) {
            if topology.edge_kind(e) != EdgeKind::Interior {
                edge.iter().for_each(|&v| rim[v as usize] = true);
            }
        }
        let mut entries = Vec::with_capacity(8 * count);
        for v in 0..count as Index {
            let ring = topology.rings().get(v);
            if !rim[v as usize] {
                let share = -1.0 / ring.len() as f64;
                entries.extend(ring.iter().map(|&w| (v, w, share)));
                entries.extend((!ring.is_empty()).then_some((v, v, 1.0)));
            } else if ring.iter().filter(|w| rim[**w as usize]).count() == 2 {
                entries.extend(ring.iter().filter(|w| rim[**w as usize]).map(|&w| (v, w, -0.25)));
                entries.push((v, v, 0.5));
            }
        }
        let rows = Csr::from_triplets(count, entries.iter().copied());
        let columns = Csr::from_triplets(count, entries.iter().map(|&(v, w, x)| (w, v, x)));
        Self { rows, columns, rim }
    }

    /// (column, value) of row v of U.
    pub(super) fn row(&self, v: Index) -> &[(Index, f64)] {
        self.rows.row(v)
    }

    /// (U x)ᵥ
    pub(super) fn at(&self, x: &[DVec3], v: usize) -> DVec3 {
        self.rows.row_times(v, x)
    }

    /// (Uᵀ y)ᵥ
    pub(super) fn transposed_at(&self, y: &[DVec3], v: usize) -> DVec3 {
        self.columns.row_times(v, y)
    }

    /// x of (1 + μ UᵀU) x = x⁰. #V×3, model units.
    pub(super) fn smoothed(
        &self,
        x: &[DVec3],
        mu: f64,
        freedom: &Freedom,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let mut bent = vec![DVec3::ZERO; x.len()];
        let mut product = |x: &[DVec3], out: &mut [DVec3], identity: f64| {
            bent.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, bent)| *bent = mu * self.at(x, v));
            multiply(x, out, |v| freedom.projected(v, identity * x[v] + self.transposed_at(&bent, v)))
        };
        // The solution is found as a way from the input, which does not depend on where the origin is.
        let mut right = vec![DVec3::ZERO; x.len()];
        product(x, &mut right, 0.0);
        right.iter_mut().for_each(|r| *r = -*r);
        let limits = Stop { tolerance: 1e-4, max_steps: 100 };
        let guess = vec![DVec3::ZERO; x.len()];
        let ones = vec![1.0; x.len()];
        let way = solve(|w, out| product(w, out, 1.0), &ones, &right, guess, limits, progress)?;
        Ok(x.iter().zip(way).map(|(x, way)| *x + way).collect())
    }
}

/// Which vertices may go.
#[derive(Clone, Debug, Default)]
pub(super) struct Freedom {
    /// It stays where this is true; empty where none has to.
    fixed: Vec<bool>,
}

impl Freedom {
    pub(super) fn of(surface: &Surface, boundary: Boundary) -> Self {
        let topology = surface.topology();
        let fixed = match boundary {
            Boundary::Free => Vec::new(),
            Boundary::Fixed => (0..topology.vertex_count() as Index).map(|v| topology.is_boundary(v)).collect(),
        };
        Self { fixed }
    }

    /// The same for these vertices alone.
    pub(super) fn of_part(&self, vertices: &[Index]) -> Self {
        if self.fixed.is_empty() {
            return Self::default();
        }
        Self { fixed: vertices.iter().map(|&v| self.fixed[v as usize]).collect() }
    }

    /// The part of a way that vertex v may go.
    pub(super) fn projected(&self, v: usize, way: DVec3) -> DVec3 {
        if self.fixed.get(v).is_some_and(|fixed| *fixed) { DVec3::ZERO } else { way }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::shapes;

    #[test]
    fn a_solution_of_the_smoothing_solves_it() {
        let surface = shapes::dented_sphere(2);
        let umbrella = Umbrella::of(&surface);
        let x = umbrella.smoothed(surface.positions(), 0.5, &Freedom::default(), &Silent).unwrap();
        let bent: Vec<_> = (0..x.len()).map(|v| umbrella.at(&x, v)).collect();
        for (v, (x, p)) in x.iter().zip(surface.positions()).enumerate() {
            let residual = *x + 0.5 * umbrella.transposed_at(&bent, v) - *p;
            // A ten-thousandth of a right-hand side that is below 0.1.
            assert!(residual.length() < 1e-5, "{residual}");
        }
    }

    #[test]
    fn a_straight_rim_is_not_bent() {
        let grid = shapes::grid(4);
        let umbrella = Umbrella::of(&grid);
        let corners = (0..25).filter(|&v| umbrella.rim[v] && umbrella.at(grid.positions(), v).length() > 1e-15);
        assert_eq!(corners.count(), 4);
    }
}
