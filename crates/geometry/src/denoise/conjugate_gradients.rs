//! Symmetric positive definite systems with three right-hand sides, one for each coordinate.
//!
//! Magnus R. Hestenes, Eduard Stiefel. Methods of conjugate gradients for solving linear systems. 1952; preconditioned
//! by the diagonal. The three systems have one matrix and are treated as one, so that each product serves all of them.

use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Solve {
    /// Residual over right-hand side, in the norm of the preconditioner.
    pub(super) tolerance: f64,
    /// Steps at most.
    pub(super) steps: usize,
}

impl Default for Solve {
    fn default() -> Self {
        Self { tolerance: 1e-10, steps: 10_000 }
    }
}

/// Unknowns that a thread treats at a time. Products are summed run by run, so that their order does not depend on the
/// number of threads.
pub(super) const RUN: usize = 1024;

fn total(runs: impl IndexedParallelIterator<Item = f64>) -> f64 {
    runs.collect::<Vec<f64>>().iter().sum()
}

/// Writes A x row by row and gives xᵀ A x.
pub(super) fn by_rows(x: &[DVec3], out: &mut [DVec3], row: impl Fn(usize) -> DVec3 + Sync) -> f64 {
    let runs = out.par_chunks_mut(RUN).enumerate();
    total(runs.map(|(run, out)| {
        (run * RUN..).zip(out).fold(0.0, |sum, (i, out)| {
            *out = row(i);
            sum + x[i].dot(*out)
        })
    }))
}

/// x of A x = b, from a first guess; `system` writes A x into its second argument and gives xᵀ A x.
pub(super) fn solve(
    mut system: impl FnMut(&[DVec3], &mut [DVec3]) -> f64,
    diagonal: &[f64],
    right: &[DVec3],
    guess: Vec<DVec3>,
    limits: Solve,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let mut x = guess;
    let mut product = vec![DVec3::ZERO; right.len()];
    system(&x, &mut product);
    let sides = |_: &[DVec3], i: usize| [right[i], product[i]];
    Solver::new(diagonal).solve(system, &mut x, sides, limits, progress)?;
    Ok(x)
}

/// Room for systems of one diagonal that are solved one after the other.
pub(super) struct Solver {
    /// Of the diagonal.
    inverse: Vec<f64>,
    residual: Vec<DVec3>,
    direction: Vec<DVec3>,
    product: Vec<DVec3>,
}

impl Solver {
    pub(super) fn new(diagonal: &[f64]) -> Self {
        let room = || vec![DVec3::ZERO; diagonal.len()];
        Self {
            inverse: diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 1.0 }).collect(),
            residual: room(),
            direction: room(),
            product: room(),
        }
    }

    /// Moves `x` to the solution; `sides` are row i of b and of A x, and `system` is as for [`solve`].
    pub(super) fn solve(
        &mut self,
        mut system: impl FnMut(&[DVec3], &mut [DVec3]) -> f64,
        x: &mut [DVec3],
        sides: impl Fn(&[DVec3], usize) -> [DVec3; 2] + Sync,
        limits: Solve,
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        let Self { inverse, residual, direction, product } = self;
        let runs = residual.par_chunks_mut(RUN).zip(direction.par_chunks_mut(RUN)).enumerate();
        let energies = runs.map(|(run, (residual, direction))| {
            let mut sums = [0.0; 2];
            for (i, (residual, direction)) in (run * RUN..).zip(residual.iter_mut().zip(direction)) {
                let [right, product] = sides(x, i);
                *residual = right - product;
                *direction = DVec3::ZERO;
                sums[0] += inverse[i] * residual.length_squared();
                sums[1] += inverse[i] * right.length_squared();
            }
            sums
        });
        let energies: Vec<[f64; 2]> = energies.collect();
        let [mut left, whole] = energies.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let enough = limits.tolerance * limits.tolerance * whole;
        let mut turn = 0.0;
        for _ in 0..limits.steps {
            if left <= enough {
                break;
            }
            progress.check()?;
            let slots = direction.par_iter_mut().zip(&*residual).zip(&*inverse).with_min_len(RUN);
            slots.for_each(|((d, r), w)| *d = *r * *w + turn * *d);
            let curvature = system(direction, product);
            // Rounding is all that is left, or the numbers are beyond what can be summed.
            if curvature <= 0.0 || !(left / curvature).is_finite() {
                break;
            }
            let step = left / curvature;
            let before = left;
            // Vectors are longer than caches: one walk does all that can be done with them.
            let moved = x.par_chunks_mut(RUN).zip(residual.par_chunks_mut(RUN));
            let along = direction.par_chunks(RUN).zip(product.par_chunks(RUN)).zip(inverse.par_chunks(RUN));
            left = total(moved.zip(along).map(|((x, residual), ((direction, product), inverse))| {
                let mut sum = 0.0;
                for i in 0..x.len() {
                    x[i] += step * direction[i];
                    residual[i] -= step * product[i];
                    sum += inverse[i] * residual[i].length_squared();
                }
                sum
            }));
            turn = left / before;
        }
        Ok(())
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
            |x: &[DVec3], out: &mut [DVec3]| by_rows(x, out, |i| 2.0 * x[i] - at(x, i.wrapping_sub(1)) - at(x, i + 1));
        let mut right = vec![DVec3::ZERO; count];
        right[count - 1] = DVec3::ONE;
        let guess = vec![DVec3::ZERO; count];
        let x = solve(system, &[2.0; 50], &right, guess, Solve::default(), &Silent).unwrap();
        for (i, x) in x.iter().enumerate() {
            let expected = (i + 1) as f64 / (count + 1) as f64;
            // The condition number is about 1000, and the residual 1e-10.
            assert!((*x - expected).abs().max_element() < 1e-7, "{i}: {x}");
        }
    }
}
