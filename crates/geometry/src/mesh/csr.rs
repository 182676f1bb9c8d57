//! Sparse matrices in compressed row storage (CSR).
//!
//! ```
//! use planish_geometry::mesh::csr::Csr;
//!
//! let matrix = Csr::from_triplets(2, [(0, 1, 2.0), (1, 0, 3.0), (0, 1, 1.0)].into_iter());
//! assert_eq!(matrix.row(0), [(1, 3.0)]);
//! assert_eq!(matrix.times(&[5.0, 10.0]), [30.0, 15.0]);
//! ```

use crate::mesh::jagged::{Index, Ragged};
use rayon::prelude::*;
use std::ops::{Add, Mul};

/// Sparse matrix: each row is a list of entries (column, value) with ascending columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<W = f64> {
    rows: Ragged<(Index, W)>,
}

impl Csr {
    /// Builds a matrix from entries (row, column, value). Entries with the same row and column are summed in their order.
    pub fn from_triplets<I>(rows: usize, triplets: I) -> Self
    where
        I: Iterator<Item = (Index, Index, f64)> + Clone,
    {
        let mut grouped = Ragged::group(rows, triplets.map(|(row, column, x)| (row, (column, x))));
        grouped.for_each_mut(|row| row.sort_by_key(|entry| entry.0));
        let mut merged = Ragged::default();
        for row in grouped.iter() {
            let same_column = row.chunk_by(|a, b| a.0 == b.0);
            merged.push(same_column.map(|e| (e[0].0, e.iter().map(|e| e.1).sum())));
        }
        Self { rows: merged }
    }
    /// The matrix in single precision.
    pub(crate) fn in_single_precision(&self) -> Csr<f32> {
        let row = |row: &[(Index, f64)]| row.iter().map(|&(column, x)| (column, x as f32)).collect::<Vec<_>>();
        Csr { rows: self.rows.iter().map(row).collect() }
    }
    /// Entries (column, value) of row `i`.
    pub fn row(&self, i: Index) -> &[(Index, f64)] {
        self.rows.get(i)
    }
    /// Iterates over the rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[(Index, f64)]> {
        self.rows.iter()
    }
    /// Matrix with the same structure and other values.
    pub fn map_rows(&self, row: impl Fn(&[(Index, f64)]) -> Vec<(Index, f64)>) -> Self {
        Self { rows: self.rows.iter().map(row).collect() }
    }
    /// Product of the matrix and a vector, whose entries are numbers or vectors of three.
    pub fn times<T>(&self, x: &[T]) -> Vec<T>
    where
        T: Copy + Default + Send + Sync + Add<Output = T> + Mul<f64, Output = T>,
    {
        (0..self.rows.len()).into_par_iter().with_min_len(1024).map(|i| self.row_times(i, x)).collect()
    }
}

impl<W: Copy> Csr<W> {
    /// Product of row `i` and a vector.
    #[inline]
    pub fn row_times<T>(&self, i: usize, x: &[T]) -> T
    where
        T: Copy + Default + Add<Output = T> + Mul<W, Output = T>,
    {
        self.rows.get(i as Index).iter().fold(T::default(), |sum, &(j, w)| sum + x[j as usize] * w)
    }
}
