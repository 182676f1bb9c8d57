//! Symmetric matrices as two vectors of three numbers.

use crate::denoise::conjugate_gradients::Unknown;
use glam::{Vec3A, Vec3Swizzles};
use std::ops::{Add, Mul, Sub};

/// A symmetric 3×3 matrix. The Euclidean norm of its six numbers is the Frobenius norm of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Symmetric {
    /// xx, yy, zz.
    pub(super) diagonal: Vec3A,
    /// √2 yz, √2 xz, √2 xy.
    pub(super) off_diagonal: Vec3A,
}

/// Factor from a stored off-diagonal number to the entry of the matrix.
const HALF_ROOT: f32 = std::f32::consts::FRAC_1_SQRT_2;

impl Symmetric {
    /// Product of the matrix and a vector.
    #[inline(always)]
    pub(super) fn times(self, d: Vec3A) -> Vec3A {
        let (e, off) = (d * HALF_ROOT, self.off_diagonal);
        self.diagonal * d + off.zxy() * e.yzx() + off.yzx() * e.zxy()
    }

    /// The symmetric part of the outer product of two vectors, ½ (a bᵀ + b aᵀ).
    #[inline(always)]
    pub(super) fn outer(a: Vec3A, b: Vec3A) -> Self {
        let e = b * HALF_ROOT;
        Self { diagonal: a * b, off_diagonal: a.yzx() * e.zxy() + a.zxy() * e.yzx() }
    }

    /// Inner product of the six numbers, which is that of the matrices.
    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> f32 {
        self.diagonal.dot(other.diagonal) + self.off_diagonal.dot(other.off_diagonal)
    }
}

impl Add for Symmetric {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { diagonal: self.diagonal + other.diagonal, off_diagonal: self.off_diagonal + other.off_diagonal }
    }
}

impl Sub for Symmetric {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { diagonal: self.diagonal - other.diagonal, off_diagonal: self.off_diagonal - other.off_diagonal }
    }
}

impl Mul<f32> for Symmetric {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self { diagonal: self.diagonal * factor, off_diagonal: self.off_diagonal * factor }
    }
}

impl Unknown for Symmetric {
    type Scalar = f32;
    const ZERO: Self = Self { diagonal: Vec3A::ZERO, off_diagonal: Vec3A::ZERO };

    #[inline(always)]
    fn scalar(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn weighted_norm2(self, weight: f32) -> f64 {
        f64::from(weight * self.dot(self))
    }
}
