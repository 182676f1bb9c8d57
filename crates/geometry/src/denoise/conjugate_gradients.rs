//! The preconditioned conjugate gradient method for symmetric positive definite systems A x = b.
//!
//! Magnus R. Hestenes, Eduard Stiefel. Methods of conjugate gradients for solving linear systems. Journal of Research of
//! the National Bureau of Standards 49 (6), 1952. The preconditioner M is a diagonal matrix.
//!
//! An unknown may be a vector of three coordinates: three systems with one matrix are then solved as one, so that each
//! product serves all of them. What the solver does with unknowns is the trait [`Vector`].

use crate::progress::{Cancelled, Progress};
use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use std::ops::{Add, Mul};

/// Unknowns that a thread treats at a time. Inner products are summed chunk by chunk in the order of the chunks, so that
/// they do not depend on the number of threads.
pub(super) const CHUNK: usize = 1024;

/// Sum in the order of the chunks, whatever the number of threads.
pub(super) fn sum_in_order(chunks: impl IndexedParallelIterator<Item = f64>) -> f64 {
    chunks.collect::<Vec<f64>>().iter().sum()
}

/// One unknown of a system.
pub(super) trait Unknown: Copy + Send + Sync + Add<Output = Self> + Mul<Self::Scalar, Output = Self> {
    /// Number type of factors: single precision is enough where a system only steers towards the next one.
    type Scalar: Copy + Send + Sync;

    /// Additive identity.
    const ZERO: Self;

    /// A factor of this type.
    fn scalar(x: f64) -> Self::Scalar;

    /// Squared Euclidean norm times a weight.
    fn weighted_norm2(self, weight: Self::Scalar) -> f64;
}

impl Unknown for DVec3 {
    type Scalar = f64;
    const ZERO: Self = Self::ZERO;

    fn scalar(x: f64) -> f64 {
        x
    }

    fn weighted_norm2(self, weight: f64) -> f64 {
        weight * self.length_squared()
    }
}

impl Unknown for Vec3A {
    type Scalar = f32;
    const ZERO: Self = Self::ZERO;

    #[inline(always)]
    fn scalar(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn weighted_norm2(self, weight: f32) -> f64 {
        f64::from(weight * self.length_squared())
    }
}

/// All unknowns of a system, and the operations on them that conjugate gradients need.
pub(super) trait Vector {
    /// M⁻¹, one factor for each unknown.
    type InverseDiagonal;

    /// x ← 0.
    fn set_zero(&mut self);

    /// x ← x + α y.
    fn axpy(&mut self, alpha: f64, y: &Self);

    /// x ← x + α y; returns xᵀ M⁻¹ x of the new x. Vectors are longer than caches, so one pass does both.
    fn axpy_norm2(&mut self, alpha: f64, y: &Self, inverse: &Self::InverseDiagonal) -> f64;

    /// x ← M⁻¹ r + β x.
    fn precondition(&mut self, residual: &Self, beta: f64, inverse: &Self::InverseDiagonal);

    /// xᵀ M⁻¹ x.
    fn weighted_norm2(&self, inverse: &Self::InverseDiagonal) -> f64;
}

impl<U: Unknown> Vector for Vec<U> {
    type InverseDiagonal = Vec<U::Scalar>;

    fn set_zero(&mut self) {
        self.fill(U::ZERO);
    }

    fn axpy(&mut self, alpha: f64, y: &Self) {
        let alpha = U::scalar(alpha);
        self.par_iter_mut().zip(y).with_min_len(CHUNK).for_each(|(x, y)| *x = *x + *y * alpha);
    }

    fn axpy_norm2(&mut self, alpha: f64, y: &Self, inverse: &Self::InverseDiagonal) -> f64 {
        let alpha = U::scalar(alpha);
        let chunks = self.par_chunks_mut(CHUNK).zip(y.par_chunks(CHUNK)).zip(inverse.par_chunks(CHUNK));
        sum_in_order(chunks.map(|((x, y), inverse)| {
            x.iter_mut().zip(y).zip(inverse).fold(0.0, |sum, ((x, y), inverse)| {
                *x = *x + *y * alpha;
                sum + x.weighted_norm2(*inverse)
            })
        }))
    }

    fn precondition(&mut self, residual: &Self, beta: f64, inverse: &Self::InverseDiagonal) {
        let beta = U::scalar(beta);
        let slots = self.par_iter_mut().zip(residual).zip(inverse).with_min_len(CHUNK);
        slots.for_each(|((x, r), inverse)| *x = *r * *inverse + *x * beta);
    }

    fn weighted_norm2(&self, inverse: &Self::InverseDiagonal) -> f64 {
        let chunks = self.par_chunks(CHUNK).zip(inverse.par_chunks(CHUNK));
        sum_in_order(
            chunks.map(|(x, inverse)| {
                x.iter().zip(inverse).fold(0.0, |sum, (x, inverse)| sum + x.weighted_norm2(*inverse))
            }),
        )
    }
}

/// When iterating stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// Norm of the residual over that of the right-hand side, both in the metric M⁻¹, at which a solution is good enough.
    pub(super) tolerance: f64,
    /// Largest number of steps.
    pub(super) max_steps: usize,
}

impl Default for Stop {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_steps: 10_000 }
    }
}

/// Writes A x row by row and returns xᵀ A x.
pub(super) fn multiply(x: &[DVec3], out: &mut [DVec3], row: impl Fn(usize) -> DVec3 + Sync) -> f64 {
    let chunks = out.par_chunks_mut(CHUNK).enumerate();
    sum_in_order(chunks.map(|(chunk, out)| {
        (chunk * CHUNK..).zip(out).fold(0.0, |sum, (i, out)| {
            *out = row(i);
            sum + x[i].dot(*out)
        })
    }))
}

/// Preconditioner and work vectors, for one solve after the other with the same preconditioner.
pub(super) struct ConjugateGradients<V: Vector> {
    /// M⁻¹.
    pub(super) inverse_diagonal: V::InverseDiagonal,
    /// b − A x.
    pub(super) residual: V,
    search_direction: V,
    product: V,
}

impl<V: Vector + Clone> ConjugateGradients<V> {
    /// Work vectors of the size of `zero`.
    pub(super) fn with(inverse_diagonal: V::InverseDiagonal, zero: V) -> Self {
        Self { inverse_diagonal, residual: zero.clone(), search_direction: zero.clone(), product: zero }
    }

    /// Moves `x`, whose residual is in `self.residual` and has the squared norm `norm2` in the metric M⁻¹, towards the
    /// solution. `reference` is the squared norm that the tolerance is relative to; `operator` writes A x into its second
    /// argument and returns xᵀ A x.
    pub(super) fn iterate(
        &mut self,
        mut operator: impl FnMut(&V, &mut V) -> f64,
        x: &mut V,
        [mut norm2, reference]: [f64; 2],
        stop: Stop,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        let Self { inverse_diagonal, residual, search_direction, product } = self;
        let enough = stop.tolerance * stop.tolerance * reference;
        let mut beta = 0.0;
        search_direction.set_zero();
        for _ in 0..stop.max_steps {
            if norm2 <= enough {
                break;
            }
            progress.check()?;
            search_direction.precondition(residual, beta, inverse_diagonal);
            let curvature = operator(search_direction, product);
            let alpha = norm2 / curvature;
            // Rounding is all that is left, or the numbers are beyond what can be summed.
            if curvature <= 0.0 || !alpha.is_finite() {
                break;
            }
            x.axpy(alpha, search_direction);
            let before = norm2;
            norm2 = residual.axpy_norm2(-alpha, product, inverse_diagonal);
            beta = norm2 / before;
        }
        Ok(())
    }
}

impl ConjugateGradients<Vec<DVec3>> {
    /// Jacobi preconditioner of a matrix with this diagonal; rows without a positive entry are left as they are.
    pub(super) fn new(diagonal: &[f64]) -> Self {
        let inverse = diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 1.0 }).collect();
        Self::with(inverse, vec![DVec3::ZERO; diagonal.len()])
    }

    /// Solves A x = b from a first guess; `operator` writes A x into its second argument and returns xᵀ A x. #rows×3
    pub(super) fn solve_from(
        &mut self,
        mut operator: impl FnMut(&[DVec3], &mut [DVec3]) -> f64,
        guess: Vec<DVec3>,
        right: &[DVec3],
        stop: Stop,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let mut x = guess;
        let mut product = vec![DVec3::ZERO; right.len()];
        operator(&x, &mut product);
        self.solve(operator, &mut x, |_, i| [right[i], product[i]], stop, progress)?;
        Ok(x)
    }

    /// Moves `x` to the solution; `sides` gives row i of b and of A x, and `operator` is as for [`Self::solve_from`].
    pub(super) fn solve(
        &mut self,
        mut operator: impl FnMut(&[DVec3], &mut [DVec3]) -> f64,
        x: &mut Vec<DVec3>,
        sides: impl Fn(&[DVec3], usize) -> [DVec3; 2] + Sync,
        stop: Stop,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        let inverse = &self.inverse_diagonal;
        let chunks = self.residual.par_chunks_mut(CHUNK).enumerate().map(|(chunk, residual)| {
            let mut norms2 = [0.0; 2];
            for (i, residual) in (chunk * CHUNK..).zip(residual) {
                let [right, product] = sides(x, i);
                *residual = right - product;
                norms2[0] += inverse[i] * residual.length_squared();
                norms2[1] += inverse[i] * right.length_squared();
            }
            norms2
        });
        let norms2 = chunks.collect::<Vec<[f64; 2]>>().iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        self.iterate(|x: &Vec<DVec3>, out: &mut Vec<DVec3>| operator(x, out), x, norms2, stop, progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    #[test]
    fn a_chain_of_springs_hangs_straight() {
        // Second differences of a straight line vanish; the ends are pulled to 0 and 1.
        let count = 50;
        let at = |x: &[DVec3], i: usize| if i < count { x[i] } else { DVec3::ZERO };
        let system =
            |x: &[DVec3], out: &mut [DVec3]| multiply(x, out, |i| 2.0 * x[i] - at(x, i.wrapping_sub(1)) - at(x, i + 1));
        let mut right = vec![DVec3::ZERO; count];
        right[count - 1] = DVec3::ONE;
        let guess = vec![DVec3::ZERO; count];
        let x =
            ConjugateGradients::new(&[2.0; 50]).solve_from(system, guess, &right, Stop::default(), &Silent).unwrap();
        for (i, x) in x.iter().enumerate() {
            let expected = (i + 1) as f64 / (count + 1) as f64;
            // The condition number is about 1000, and the residual 1e-10.
            assert!((*x - expected).abs().max_element() < 1e-7, "{i}: {x}");
        }
    }
}
