//! Symmetric matrices as vectors of six numbers.

use glam::DVec3;

/// A symmetric matrix as (xx, yy, zz, √2 yz, √2 xz, √2 xy): the norm of these is that of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric(pub(super) [f64; 6]);

pub(super) const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Symmetric {
    pub(super) fn times(&self, d: DVec3) -> DVec3 {
        let [xx, yy, zz, yz, xz, xy] = self.0;
        let e = d * HALF_ROOT;
        DVec3::new(xx * d.x + xy * e.y + xz * e.z, xy * e.x + yy * d.y + yz * e.z, xz * e.x + yz * e.y + zz * d.z)
    }
    pub(super) fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    pub(super) fn minus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    fn dot(&self, other: &Self) -> f64 {
        let products = self.zip(other, |a, b| a * b).0;
        products.iter().sum()
    }
    pub(super) fn squared(&self) -> f64 {
        self.dot(self)
    }
}
