//! Sparse Cholesky factorisation of symmetric positive definite matrices, by `faer`.

use crate::mesh::csr::Csr;
use crate::mesh::jagged::Index;
use faer::Side;
use faer::linalg::solvers::Solve as _;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use glam::DVec3;

/// Cholesky factors of a matrix.
pub(super) struct Factor(Llt<usize, f64>);

impl Factor {
    /// Factors a matrix; `None` if rounding has made it indefinite, in which case conjugate gradients are used.
    pub(super) fn of(matrix: &Csr) -> Option<Self> {
        let entry = |i: Index, &(j, w): &(Index, f64)| Triplet::new(i as usize, j as usize, w);
        let rows = (0..).zip(matrix.rows());
        let lower: Vec<_> =
            rows.flat_map(|(i, row)| row.iter().filter(move |e| e.0 <= i).map(move |e| entry(i, e))).collect();
        let count = matrix.rows().len();
        SparseColMat::try_new_from_triplets(count, count, &lower).ok()?.sp_cholesky(Side::Lower).ok().map(Self)
    }

    /// Solves the system for a right-hand side. #V×3
    pub(super) fn backsolve(&self, right: &[DVec3]) -> Vec<DVec3> {
        let columns = faer::Mat::from_fn(right.len(), 3, |v, k| right[v][k]);
        let x = self.0.solve(columns);
        (0..right.len()).map(|v| DVec3::new(x[(v, 0)], x[(v, 1)], x[(v, 2)])).collect()
    }
}
