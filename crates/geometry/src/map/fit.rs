//! Fitting of texels, so that sampling returns the heights of the vertices.
//!
//! Bilinear sampling blends four texels, and noise differs from vertex to vertex, so a map that is merely interpolated mixes
//! the height of each vertex with those of its neighbours. Here the texels T around the samples are moved as little as
//! possible until sampling returns the heights: min ‖A T − h‖, and of all such T the one nearest to the interpolated T₀,
//! within bounds. Conjugate gradients on the normal equations, started at T₀, give just that (CGLS: Paige & Saunders. LSQR.
//! 1982); texels that leave the bounds are set to them and the others are solved again. Samples that share no texel are
//! independent, so each connected group is solved by itself.
//!
//! ```
//! use glam::Vec2;
//! use planish_geometry::map::fit::{self, Rank, Sample, UnmetSamples};
//! use planish_geometry::map::{Exactness, Size};
//! use planish_geometry::progress::{Cancelled, Silent};
//!
//! // Half-way between the centres of two texels the map shall give 3, and it gives 0.
//! let mut texels = [0.0, 0.0, 4.0, 4.0];
//! let samples = [(0.5, 0.75, 3.0), (0.25, 0.25, 4.0)];
//! let samples = samples.map(|(u, v, height)| Sample { uv: Vec2::new(u, v), height, rank: Rank::Dominant, on_seam: false });
//! let exactness = Exactness { quantum: 1e-6, tolerance: 1.0 };
//! let unmet = fit::fit(&mut texels, Size::square(2), &samples, exactness, &Silent)?;
//! assert_eq!(unmet, UnmetSamples::default());
//! assert!(((texels[0] + texels[1]) / 2.0 - 3.0).abs() < 1e-5, "{texels:?}");
//! # Ok::<(), Cancelled>(())
//! ```

use super::Exactness;
use super::sampling::{Footprint, Size};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::union_find::UnionFind;
use crate::progress::{Cancelled, Parts, Progress};
use glam::Vec2;
use rayon::prelude::*;

/// A texture coordinate at which the map shall give a height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Texture coordinate in single precision, as the shader has it.
    pub uv: Vec2,
    /// Height that sampling shall return, model units.
    pub height: f64,
    /// Importance of the sample where samples contradict each other.
    pub rank: Rank,
    /// True on a seam, where other wedges must sample exactly the same height. If no other sample needs the texels of this
    /// one, all get its height, so that rounding of the weights makes no difference.
    pub on_seam: bool,
}

/// Importance of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The vertex is displaced by this sample.
    Dominant,
    /// The sample belongs to another wedge of the vertex; it is left out where it contradicts its neighbours.
    Secondary,
}

/// Distance by which texels may leave the range of the heights, as a fraction of that range. More of it would meet no more
/// samples that matter, and cost precision everywhere.
const HEADROOM: f64 = 0.25;

/// Largest number of steps of the conjugate gradients. Only crowded layouts need that many;
/// three times the rounds changed the errors of those that were tried by less than a hundredth.
const STEPS: usize = 150;
/// Largest number of rounds in which texels outside the bounds are set to them.
const ROUNDS: usize = 4;

/// Numbers of samples whose error is larger than allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnmetSamples {
    /// Number of unmet samples that displace vertices.
    pub dominant: usize,
    /// Number of unmet samples of the other wedges of vertices.
    pub secondary: usize,
}

/// Fits texels (model units, row by row from the top) to the samples as far as possible.
pub fn fit(
    texels: &mut [f32],
    size: Size,
    samples: &[Sample],
    exactness: Exactness,
    progress: &dyn Progress,
) -> Result<UnmetSamples, Cancelled> {
    let unmet = unmet(texels, size, samples, exactness, progress)?;
    let count = |rank| unmet.iter().filter(|&&(i, _)| samples[i].rank == rank).count();
    Ok(UnmetSamples { dominant: count(Rank::Dominant), secondary: count(Rank::Secondary) })
}

/// Fits texels as [`fit`] does, and returns the unmet samples: the index of each, ascending, with its error in model units.
pub(super) fn unmet(
    texels: &mut [f32],
    size: Size,
    samples: &[Sample],
    exactness: Exactness,
    progress: &dyn Progress,
) -> Result<Vec<(usize, f64)>, Cancelled> {
    progress.stage("fitting");
    let range = samples.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], s| [l.min(s.height), h.max(s.height)]);
    let span = range[1] - range[0];
    if samples.is_empty() || span <= 0.0 {
        return Ok(Vec::new());
    }
    let bounds = [range[0] - HEADROOM * span, range[1] + HEADROOM * span];
    let footprints: Vec<Footprint> = samples.iter().map(|s| Footprint::new(s.uv, size)).collect();
    let groups = groups(&footprints);
    let members: Vec<&[Index]> = groups.iter().collect();
    // Groups are small and many: a part is a run of them.
    let runs: Vec<&[&[Index]]> = members.chunks(256).collect();
    let parts = Parts::new(progress, runs.len());
    let of_run = |run: &&[&[Index]]| {
        parts.run(|| {
            let solve = |group: &&[Index]| {
                Group::new(group, samples, &footprints, texels, bounds).solve(exactness.residual() * span, progress)
            };
            run.iter().flat_map(solve).collect::<Vec<_>>()
        })
    };
    let solved = runs.par_iter().map(of_run).collect::<Result<Vec<_>, _>>()?;
    progress.check()?;
    for (texel, height) in solved.into_iter().flatten() {
        texels[texel] = height as f32;
    }
    // Texels are rounded to single precision.
    let rounding = f64::from(f32::EPSILON) * bounds[0].abs().max(bounds[1].abs());
    let allowed = exactness.allowed() * span + rounding;
    let error = |(sample, footprint): (&Sample, &Footprint)| {
        let sampled: f64 = footprint.weights().map(|(texel, w)| w * f64::from(texels[texel])).sum();
        (sampled - sample.height).abs()
    };
    let errors = samples.iter().zip(&footprints).map(error).enumerate();
    Ok(errors.filter(|(_, error)| *error > allowed).collect())
}

/// Connected groups of samples, which share texels directly or through others. Groups and their members are in the order of
/// the samples.
fn groups(footprints: &[Footprint]) -> Ragged<Index> {
    let mut uses: Vec<(usize, Index)> =
        footprints.iter().zip(0..).flat_map(|(f, i)| f.weights().map(move |(texel, _)| (texel, i))).collect();
    uses.par_sort_unstable();
    let mut sets = UnionFind::new(footprints.len());
    for pair in uses.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let mut number = vec![Index::MAX; footprints.len()];
    let mut count = 0;
    let of_sample = sets.into_lowest().into_iter().map(|lowest| {
        let number = &mut number[lowest as usize];
        if *number == Index::MAX {
            *number = count;
            count += 1;
        }
        *number
    });
    let of_sample: Vec<Index> = of_sample.collect();
    Ragged::group(count as usize, of_sample.into_iter().zip(0..))
}

/// A connected group of samples, with its texels renumbered.
struct Group {
    /// Index in the image of each texel, ascending.
    indices: Vec<usize>,
    start: Vec<f64>,
    equations: Vec<Equation>,
    bounds: [f64; 2],
}

/// The linear equation aᵢ·T = hᵢ of one sample.
#[derive(Clone, Debug)]
struct Equation {
    terms: Vec<(usize, f64)>,
    height: f64,
    rank: Rank,
    on_seam: bool,
}

impl Equation {
    fn at(&self, texels: &[f64]) -> f64 {
        self.terms.iter().map(|&(t, w)| w * texels[t]).sum()
    }
}

impl Group {
    fn new(members: &[Index], samples: &[Sample], footprints: &[Footprint], texels: &[f32], bounds: [f64; 2]) -> Self {
        let weights = |i: &Index| footprints[*i as usize].weights();
        let mut indices: Vec<usize> = members.iter().flat_map(weights).map(|(texel, _)| texel).collect();
        indices.sort_unstable();
        indices.dedup();
        let equation = |i: &Index| {
            let Sample { height, rank, on_seam, .. } = samples[*i as usize];
            let local = |(texel, w): (usize, f64)| (indices.partition_point(|&p| p < texel), w);
            Equation { terms: weights(i).map(local).collect(), height, rank, on_seam }
        };
        let equations = members.iter().map(equation).collect();
        let start = indices.iter().map(|&p| f64::from(texels[p])).collect();
        Self { indices, start, equations, bounds }
    }

    /// Solves for the heights of the texels. If the work shall stop, which a large group has to notice itself, the result is
    /// arbitrary.
    fn solve(mut self, tolerance: f64, progress: &dyn Progress) -> Vec<(usize, f64)> {
        if let [Equation { on_seam: true, height, .. }] = self.equations[..] {
            return self.indices.into_iter().map(|index| (index, height)).collect();
        }
        let (mut texels, mut met) = self.nearest_solution(tolerance, progress);
        // The samples of the shader matter most. The other wedges only keep seams closed in simple clients, so those that
        // contradict their neighbours most are dropped first.
        while !met && self.equations.iter().any(|e| e.rank == Rank::Secondary) {
            self.give_up_worst(&texels, tolerance);
            (texels, met) = self.nearest_solution(tolerance, progress);
        }
        self.indices.into_iter().zip(texels).collect()
    }

    /// Drops the equations of other wedges whose error is more than half of the largest one; if none has an error, all of
    /// them, since they then keep the dominant ones from being met.
    fn give_up_worst(&mut self, texels: &[f64], tolerance: f64) {
        let off = |e: &Equation| if e.rank == Rank::Secondary { (e.at(texels) - e.height).abs() } else { 0.0 };
        let worst = self.equations.iter().map(off).fold(0.0, f64::max);
        let kept = |e: &Equation| e.rank == Rank::Dominant || (worst > tolerance && off(e) < worst / 2.0);
        self.equations.retain(kept);
    }

    /// Solves within the bounds and returns true if all equations are met.
    fn nearest_solution(&self, tolerance: f64, progress: &dyn Progress) -> (Vec<f64>, bool) {
        let mut texels = self.start.clone();
        let mut free = vec![true; texels.len()];
        for _ in 0..ROUNDS {
            let met = self.conjugate_gradients(&mut texels, &free, tolerance, progress);
            let mut bounded = false;
            for (texel, free) in texels.iter_mut().zip(&mut free) {
                if *texel < self.bounds[0] || *texel > self.bounds[1] {
                    *texel = texel.clamp(self.bounds[0], self.bounds[1]);
                    *free = false;
                    bounded = true;
                }
            }
            if !bounded {
                return (texels, met);
            }
        }
        (texels, false)
    }

    /// Runs CGLS on the free texels and returns true if all equations are met.
    fn conjugate_gradients(&self, texels: &mut [f64], free: &[bool], tolerance: f64, progress: &dyn Progress) -> bool {
        let mut residual: Vec<f64> = self.equations.iter().map(|e| e.height - e.at(texels)).collect();
        let met = |residual: &[f64]| residual.iter().all(|r| r.abs() <= tolerance);
        let gradient = |residual: &[f64]| {
            let mut out = vec![0.0; free.len()];
            for (e, r) in self.equations.iter().zip(residual) {
                for &(t, w) in e.terms.iter().filter(|term| free[term.0]) {
                    out[t] += w * r;
                }
            }
            out
        };
        let dot = |a: &[f64]| a.iter().map(|x| x * x).sum::<f64>();
        let mut s = gradient(&residual);
        let mut direction = s.clone();
        let mut gamma = dot(&s);
        for _ in 0..STEPS {
            // The gradient is of the size of the residual as long as there is anything to gain.
            if met(&residual) || gamma.sqrt() <= 1e-3 * tolerance || progress.cancelled() {
                break;
            }
            let image: Vec<f64> = self.equations.iter().map(|e| e.at(&direction)).collect();
            let alpha = gamma / dot(&image);
            for (texel, d) in texels.iter_mut().zip(&direction) {
                *texel += alpha * d;
            }
            for (r, q) in residual.iter_mut().zip(&image) {
                *r -= alpha * q;
            }
            s = gradient(&residual);
            let next = dot(&s);
            for (d, s) in direction.iter_mut().zip(&s) {
                *d = s + next / gamma * *d;
            }
            gamma = next;
        }
        met(&residual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    const SIZE: Size = Size { width: 32, height: 16 };

    fn sampled(texels: &[f32], uv: Vec2) -> f64 {
        Footprint::new(uv, SIZE).weights().map(|(t, w)| w * f64::from(texels[t])).sum()
    }

    fn noise(i: u32) -> f64 {
        f64::from(i.wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65535.0
    }

    fn fitted(samples: &[Sample]) -> Vec<f32> {
        let mut texels = vec![0.5; SIZE.texels()];
        // An eighth of this is what the solver aims at.
        let exactness = Exactness { quantum: 1.6e-5, tolerance: 1.0 };
        fit(&mut texels, SIZE, samples, exactness, &Silent).unwrap();
        texels
    }

    #[test]
    fn samples_two_texels_apart_are_met() {
        // A jittered grid of three by three texels a sample.
        let sample = |i: u32| {
            let jitter = Vec2::new(noise(3 * i) as f32, noise(3 * i + 1) as f32);
            let at = Vec2::new((i % 10) as f32, (i / 10) as f32) * 3.0 + 1.0 + jitter;
            Sample { uv: at / Vec2::new(32.0, 16.0), height: noise(3 * i + 2), rank: Rank::Dominant, on_seam: false }
        };
        let samples: Vec<_> = (0..50).map(sample).collect();
        let texels = fitted(&samples);
        for s in &samples {
            assert!((sampled(&texels, s.uv) - s.height).abs() < 2e-6, "{s:?}");
        }
        assert!(texels.iter().all(|t| (-0.25..=1.25).contains(t)));
    }

    #[test]
    fn samples_that_share_texels_are_met_where_texels_are_enough() {
        let sample = |i: u32, height| Sample {
            uv: Vec2::new(0.31 + 0.02 * i as f32, 0.4),
            height,
            rank: Rank::Dominant,
            on_seam: false,
        };
        let far = Sample { uv: Vec2::new(0.9, 0.9), height: 1.0, rank: Rank::Dominant, on_seam: false };
        let samples = [sample(0, 0.1), sample(1, 0.4), sample(2, 0.9), far];
        let texels = fitted(&samples);
        for s in &samples {
            assert!((sampled(&texels, s.uv) - s.height).abs() < 2e-6, "{s:?}: {}", sampled(&texels, s.uv));
        }
    }

    #[test]
    fn contradictions_end_in_the_middle_and_the_dominant_sample_wins() {
        let uv = Vec2::new(0.4, 0.6);
        let far = Sample { uv: Vec2::new(0.9, 0.1), height: 1.0, rank: Rank::Dominant, on_seam: false };
        let [low, high] = [0.0, 1.0].map(|height| Sample { uv, height, rank: Rank::Dominant, on_seam: false });
        assert!((sampled(&fitted(&[low, high, far]), uv) - 0.5).abs() < 0.02);
        let other = Sample { rank: Rank::Secondary, ..high };
        assert!(sampled(&fitted(&[low, other, far]), uv).abs() < 2e-6);
    }

    #[test]
    fn a_lonely_sample_on_a_seam_gets_a_plateau() {
        let s = |x: f32, height| Sample { uv: Vec2::new(x, 0.41), height, rank: Rank::Dominant, on_seam: true };
        let texels = fitted(&[s(0.23, 0.0), s(0.83, 0.7)]);
        assert_eq!(texels.iter().filter(|t| **t == 0.0).count(), 4);
        assert_eq!(texels.iter().filter(|t| **t == 0.7).count(), 4);
    }

    #[test]
    fn texels_that_no_sample_reads_stay() {
        let s = |x: f32, height| Sample { uv: Vec2::new(x, 0.5), height, rank: Rank::Dominant, on_seam: false };
        let texels = fitted(&[s(0.2, 0.0), s(0.8, 1.0)]);
        assert_eq!(texels.iter().filter(|t| **t != 0.5).count(), 8);
    }
}
