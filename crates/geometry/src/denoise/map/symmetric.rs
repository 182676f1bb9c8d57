//! Symmetric matrices as vectors of six numbers.

use crate::denoise::conjugate_gradients::Unknown;
use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// A symmetric 3×3 matrix as (xx, yy, zz, √2 yz, √2 xz, √2 xy): the Euclidean norm of these six numbers is the Frobenius
/// norm of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric(pub(super) [f64; 6]);

/// Factor from a stored off-diagonal number to the entry of the matrix.
pub(super) const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Symmetric {
    /// Product of the matrix and a vector.
    pub(super) fn times(&self, d: DVec3) -> DVec3 {
        let [xx, yy, zz, yz, xz, xy] = self.0;
        let e = d * HALF_ROOT;
        DVec3::new(xx * d.x + xy * e.y + xz * e.z, xy * e.x + yy * d.y + yz * e.z, xz * e.x + yz * e.y + zz * d.z)
    }
}

impl Add for Symmetric {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Symmetric {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul<f64> for Symmetric {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl Unknown for Symmetric {
    const ZERO: Self = Self([0.0; 6]);

    fn norm2(self) -> f64 {
        self.0.iter().map(|x| x * x).sum()
    }
}
