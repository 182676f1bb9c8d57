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

/// Products are summed run by run, so that their order does not depend on the number of threads.
const RUN: usize = 4096;

/// Σᵢ aᵢ · bᵢ
fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    let run = |(a, b): (&[DVec3], &[DVec3])| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    total(a.par_chunks(RUN).zip(b.par_chunks(RUN)).map(run))
}

/// Σᵢ wᵢ |aᵢ|²
fn energy(w: &[f64], a: &[DVec3]) -> f64 {
    let run = |(w, a): (&[f64], &[DVec3])| w.iter().zip(a).map(|(w, a)| w * a.length_squared()).sum::<f64>();
    total(w.par_chunks(RUN).zip(a.par_chunks(RUN)).map(run))
}

fn total(runs: impl IndexedParallelIterator<Item = f64>) -> f64 {
    runs.collect::<Vec<f64>>().iter().sum()
}

/// x of A x = b, from a first guess; `system` writes A x into its second argument.
pub(super) fn solve(
    mut system: impl FnMut(&[DVec3], &mut Vec<DVec3>),
    diagonal: Vec<f64>,
    right: &[DVec3],
    guess: Vec<DVec3>,
    limits: Solve,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let inverse: Vec<f64> = diagonal.into_iter().map(|d| if d > 0.0 { 1.0 / d } else { 1.0 }).collect();
    let mut x = guess;
    let mut product = vec![DVec3::ZERO; right.len()];
    system(&x, &mut product);
    let mut residual: Vec<DVec3> = right.iter().zip(&product).map(|(b, ax)| *b - *ax).collect();
    let mut direction: Vec<DVec3> = residual.iter().zip(&inverse).map(|(r, w)| *r * *w).collect();
    let mut left = energy(&inverse, &residual);
    let enough = limits.tolerance * limits.tolerance * energy(&inverse, right);
    for _ in 0..limits.steps {
        if left <= enough {
            break;
        }
        progress.check()?;
        system(&direction, &mut product);
        let curvature = dot(&direction, &product);
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
        let turn = left / before;
        let slots = direction.par_iter_mut().zip(&residual).zip(&inverse).with_min_len(RUN);
        slots.for_each(|((d, r), w)| *d = *r * *w + turn * *d);
    }
    Ok(x)
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
        let system = |x: &[DVec3], out: &mut Vec<DVec3>| {
            *out = (0..count).map(|i| 2.0 * x[i] - at(x, i.wrapping_sub(1)) - at(x, i + 1)).collect();
        };
        let mut right = vec![DVec3::ZERO; count];
        right[count - 1] = DVec3::ONE;
        let guess = vec![DVec3::ZERO; count];
        let x = solve(system, vec![2.0; count], &right, guess, Solve::default(), &Silent).unwrap();
        for (i, x) in x.iter().enumerate() {
            let expected = (i + 1) as f64 / (count + 1) as f64;
            // The condition number is about 1000, and the residual 1e-10.
            assert!((*x - expected).abs().max_element() < 1e-7, "{i}: {x}");
        }
    }
}
