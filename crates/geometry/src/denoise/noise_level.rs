//! Estimation of the noise of a mesh, from the mesh alone.
//!
//! The finest band of a mesh, (U U x)ᵢ with the umbrella operator U, is nearly all noise. Its part along the normal is
//! Gaussian with deviation σ |row i of U U| where the noise is white with deviation σ, and the median of its absolute
//! values gives σ even where a part of the surface has creases. Coarser bands, between two smoothings of different strength,
//! hold more than the finest one tells only where the noise of neighbours is correlated or where the surface has detail.

use super::bilaplacian::BoundaryConstraint;
use super::connectivity::Connectivity;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Deviation, mean edges, below which noise is the rounding of the numbers in a file.
pub(super) const ROUNDING_NOISE: f64 = 1e-6;

/// Statistics of the noise of a mesh. Deviations are those of the part along the normal, in mean edge lengths of the
/// smoothed mesh, unless they say otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseLevel {
    /// Deviation from the median of the finest band.
    pub fine: f64,
    /// Deviation from the ninth decile of the finest band: more than `fine` where few vertices are hit, or at creases.
    pub tail: f64,
    /// Deviation from a band of about two edges.
    pub coarse: f64,
    /// Excess sign agreement of the finest band: the fraction of edges whose two ends deviate to the same side, minus the
    /// fraction expected for white noise. Detail of the surface makes it large.
    #[serde(rename = "agreement")]
    pub sign_agreement: f64,
    /// Deviation in each of the two tangential directions, from the median of the finest band: an upper bound of the noise,
    /// since vertices are unevenly spaced without any.
    #[serde(default, rename = "across")]
    pub tangential: f64,
    /// Quantile skewness of the finest band, (q₈₀ + q₂₀ − 2 q₅₀) / (q₈₀ − q₂₀): −1..=1, and 0 for symmetric noise.
    #[serde(rename = "skew")]
    pub skewness: f64,
}

/// The noise of a mesh, and the length of its edges.
pub(super) struct NoiseEstimate {
    pub(super) level: NoiseLevel,
    /// Mean edge length of the smoothed mesh, model units.
    pub(super) mean_edge: f64,
}

impl NoiseEstimate {
    /// Estimates the noise in two passes: the first smooths by a fixed amount, the second by as much as the noise of the
    /// first one calls for.
    pub(super) fn of(
        surface: &Surface,
        connectivity: &Connectivity,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let input = surface.positions();
        let smooth = |mu: f64| -> Result<(f64, Vec<DVec3>), Cancelled> {
            let smoothed = connectivity.umbrella.smoothed(input, mu, &BoundaryConstraint::default(), progress)?;
            let normals = connectivity.vertex_normals(&smoothed);
            Ok((surface.at(smoothed).mean_edge(), normals))
        };
        let finest = FinestBand::of(connectivity);
        let (edge, normals) = smooth(8.0)?;
        let first = deviations(&magnitudes(&finest.normal_parts(connectivity, input, &normals))).0 / edge;
        // Noise of a tenth of an edge goes with μ = 1, and as σ² beyond.
        let smoothing = if first.is_finite() { (100.0 * first * first).max(0.5) } else { 0.5 };
        let (mean_edge, normals) = smooth(smoothing)?;
        let heights = finest.normal_parts(connectivity, input, &normals);
        let (fine, tail) = deviations(&magnitudes(&heights));
        let sign_agreement =
            finest.sign_agreement(surface, &heights) - finest.sign_agreement_of_white_noise(surface, connectivity);
        let coarse = coarse_deviation(connectivity, input, &normals, progress)?;
        let tangential = median(finest.tangential_lengths(connectivity, input, &normals)) / RAYLEIGH_MEDIAN;
        let [fine, tail, coarse, tangential] = [fine, tail, coarse, tangential]
            .map(|x| if mean_edge > 0.0 && x.is_finite() { x / mean_edge } else { 0.0 });
        let skewness = quantile_skewness(heights);
        let level = NoiseLevel { fine, tail, coarse, sign_agreement, tangential, skewness };
        Ok(Self { level, mean_edge })
    }
}

impl NoiseLevel {
    /// Fraction of the variance of the finest band that is detail of the surface. `chance` is the sign agreement that white
    /// noise reaches by chance.
    fn detail_fraction(&self, chance: f64) -> f64 {
        // In clean meshes with detail the agreement is 0.03 to 0.17, and less where detail is finer.
        const AGREEMENT_OF_DETAIL: f64 = 0.045;
        ((self.sign_agreement - chance) / AGREEMENT_OF_DETAIL).clamp(0.0, 1.0)
    }

    /// Deviation σ for a data term if the noise is of this kind, mean edges.
    pub(super) fn sigma_as(&self, kind: Kind) -> f64 {
        // Creases fill the tail even without noise.
        let white = self.fine.max(self.tail).min(1.6 * self.fine);
        match kind {
            Kind::Correlated if self.is_rough_at_all_scales() => 7.5 * self.coarse_excess(),
            Kind::Correlated => 1.5 * self.inflation() * white,
            Kind::None => white * (1.0 - self.detail_fraction(0.01)).sqrt(),
            Kind::Independent | Kind::Uneven => white,
        }
    }

    /// Weight of the data term's tangential part, on top of the weight 1 of all directions. For noise that is not white it is
    /// zero: the bands say too little of its tangential part.
    pub(super) fn tangential_stiffness(&self, kind: Kind) -> f64 {
        match kind {
            Kind::None | Kind::Correlated => 0.0,
            Kind::Independent | Kind::Uneven => tangential_stiffness(self.fine, self.tangential),
        }
    }

    /// Classifies the noise by these figures.
    pub fn kind(&self) -> Kind {
        // Noise turns faces by about as many degrees as it has hundredths of an edge. Less is hardly seen and cannot be told
        // from detail, and a barely noisy mesh stays as it is.
        const LEAST: f64 = 0.035;
        const LEAST_ROUGH: f64 = 0.02;
        let is_rough = self.is_rough_at_all_scales();
        let white = self.fine * (1.0 - self.detail_fraction(0.005)).sqrt();
        if white < if is_rough { LEAST_ROUGH } else { LEAST } || self.is_one_sided() {
            Kind::None
        } else if is_rough || self.inflation() > 2.5 {
            Kind::Correlated
        } else if self.tail > 1.3 * self.fine {
            Kind::Uneven
        } else {
            Kind::Independent
        }
    }

    /// True for roughness that has bumps or pits, but not both alike, as no sensor errs.
    fn is_one_sided(&self) -> bool {
        // Where noise lifts only, the skewness is 0.15.
        const LARGEST_SKEWNESS: f64 = 0.125;
        self.skewness.abs() > LARGEST_SKEWNESS
    }

    /// Deviation of the coarse band beyond that of white noise, mean edges.
    fn coarse_excess(&self) -> f64 {
        (self.coarse * self.coarse - 1.21 * self.fine * self.fine).max(0.0).sqrt()
    }

    /// Factor for σ by what the coarse band holds beyond white noise and the detail of common surfaces.
    fn inflation(&self) -> f64 {
        const DETAIL: f64 = 0.07;
        (self.coarse_excess() / DETAIL).powi(2).clamp(1.0, 5.0)
    }

    /// True for noise that is correlated over many edges, as that of photogrammetry. Surface detail raises both the coarse
    /// band and the sign agreement of the fine band; correlated noise raises the coarse band alone.
    fn is_rough_at_all_scales(&self) -> bool {
        // In clean meshes the agreement is 0.007 to 0.017 of (coarse / fine)², and no less with noise added.
        const EXPLAINED: f64 = 0.008;
        const MARGIN: f64 = 0.015;
        let explained = EXPLAINED * (self.coarse_excess() / self.fine).powi(2);
        self.fine > 0.0 && self.sign_agreement < MARGIN && explained > self.sign_agreement.max(0.0) + MARGIN
    }
}

/// Weight k of the data term's tangential part, on top of the weight 1 of all directions, for noise with these deviations
/// along the normals and in tangential directions: (1 + k) is the ratio of the variances.
pub(super) fn tangential_stiffness(normal: f64, tangential: f64) -> f64 {
    // Normals are estimates: what seems tangential has a part along the true ones.
    const LARGEST: f64 = 15.0;
    if tangential > 0.0 { ((normal / tangential).powi(2) - 1.0).clamp(0.0, LARGEST) } else { LARGEST }
}

named! {
    /// Kind of noise.
    pub enum Kind {
        /// No noise that could be told from the surface: the mesh stays as it is.
        None = "none",
        /// Each vertex is off by its own amount (white noise).
        Independent = "independent",
        /// Each vertex is off by its own amount, some vertices by much more than others.
        Uneven = "uneven",
        /// Neighbouring vertices are off to the same side, as depth cameras err.
        Correlated = "correlated",
    }
}

/// Number of neighbours up to which a vertex counts with all of them in the gain of another one.
const MOST_IN_ROW: usize = 256;

/// The finest band of a mesh: vertices with a closed ring of vertices with closed rings.
struct FinestBand {
    /// Each vertex, and its gain |row of U U|: the deviation there of the band of white noise of deviation 1.
    vertices: Vec<(Index, f64)>,
}

impl FinestBand {
    fn of(connectivity: &Connectivity) -> Self {
        let umbrella = &connectivity.umbrella;
        let irregular = &umbrella.irregular;
        let gain = |v: Index| {
            let row = umbrella.row(v);
            if row.len() < 4 || row.iter().any(|&(w, _)| irregular[w as usize]) {
                return None;
            }
            // A long row has a tiny part of each of its neighbours, and would be looked at by each of them.
            let of_row = |w: Index| {
                let row = umbrella.row(w);
                row.iter().filter(move |(u, _)| row.len() <= MOST_IN_ROW || *u == w)
            };
            let mut entries: Vec<(Index, f64)> =
                row.iter().flat_map(|&(w, x)| of_row(w).map(move |&(u, y)| (u, x * y))).collect();
            entries.sort_by_key(|entry| entry.0);
            let same_column = entries.chunk_by(|a, b| a.0 == b.0);
            let squared: f64 = same_column.map(|e| e.iter().map(|e| e.1).sum::<f64>().powi(2)).sum();
            Some((v, squared.sqrt()))
        };
        let vertices = (0..irregular.len() as Index).into_par_iter().filter_map(gain).collect();
        Self { vertices }
    }

    /// Values of `measure(v, U U x)` over the gain, one for each vertex of the band.
    fn values(
        &self,
        connectivity: &Connectivity,
        x: &[DVec3],
        measure: impl Fn(usize, DVec3) -> f64 + Sync,
    ) -> Vec<f64> {
        let umbrella = &connectivity.umbrella;
        let once: Vec<DVec3> = (0..x.len()).into_par_iter().map(|v| umbrella.at(x, v)).collect();
        let value = |&(v, gain): &(Index, f64)| measure(v as usize, umbrella.at(&once, v as usize)) / gain;
        self.vertices.par_iter().map(value).collect()
    }

    /// Signed parts of the band along the normals (#V×3), over the gain, model units.
    fn normal_parts(&self, connectivity: &Connectivity, x: &[DVec3], normals: &[DVec3]) -> Vec<f64> {
        self.values(connectivity, x, |v, band| normals[v].dot(band))
    }

    /// Lengths of the band's tangential parts, over the gain, model units.
    fn tangential_lengths(&self, connectivity: &Connectivity, x: &[DVec3], normals: &[DVec3]) -> Vec<f64> {
        self.values(connectivity, x, |v, band| band.reject_from_normalized(normals[v]).length())
    }

    /// Fraction of the edges whose ends have heights of the same sign; 0 without any edge.
    fn sign_agreement(&self, surface: &Surface, heights: &[f64]) -> f64 {
        let mut of_vertex = vec![0.0; surface.positions().len()];
        self.vertices.iter().zip(heights).for_each(|(&(v, _), h)| of_vertex[v as usize] = *h);
        let products = surface.topology().edges().iter().map(|e| of_vertex[e[0] as usize] * of_vertex[e[1] as usize]);
        let (same, all) = products
            .filter(|p| *p != 0.0)
            .fold((0.0, 0.0), |(same, all), p| (same + f64::from(u8::from(p > 0.0)), all + 1.0));
        if all > 0.0 { same / all } else { 0.0 }
    }

    /// Sign agreement of the band of white noise on this mesh. It is below one half, since the umbrella makes neighbours
    /// deviate to opposite sides.
    fn sign_agreement_of_white_noise(&self, surface: &Surface, connectivity: &Connectivity) -> f64 {
        let count = surface.positions().len();
        let heights = self.normal_parts(connectivity, &gaussians(count, 5), &vec![DVec3::X; count]);
        self.sign_agreement(surface, &heights)
    }
}

fn magnitudes(heights: &[f64]) -> Vec<f64> {
    heights.iter().map(|h| h.abs()).collect()
}

/// Deviation of a Gaussian from the median and from the ninth decile of its absolute values; 0 without any values.
fn deviations(absolute: &[f64]) -> (f64, f64) {
    let mut sorted = absolute.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |quantile: f64| sorted.get((quantile * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
    // 1 / Φ⁻¹(0.75), and Φ⁻¹(0.95), with Φ the standard normal distribution.
    (1.4826 * at(0.5), at(0.9) / 1.6449)
}

/// Median length of a vector of two standard Gaussians (a Rayleigh distribution): √(2 ln 2).
const RAYLEIGH_MEDIAN: f64 = 1.1774;

/// Median of the values; 0 without any.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Skewness by quantiles, (q₈₀ + q₂₀ − 2 q₅₀) / (q₈₀ − q₂₀); 0 for too few values to tell. Creases lie outside these
/// quantiles.
fn quantile_skewness(mut heights: Vec<f64>) -> f64 {
    // With as many Gaussian values the quotient is below 0.12 but for one time in a thousand.
    const LEAST_COUNT: usize = 2000;
    if heights.len() < LEAST_COUNT {
        return 0.0;
    }
    heights.sort_unstable_by(f64::total_cmp);
    let [low, middle, high] = [2, 5, 8].map(|tenths| heights[tenths * heights.len() / 10]);
    if high > low { (high + low - 2.0 * middle) / (high - low) } else { 0.0 }
}

/// Deviation of the band between smoothings with μ = ½ and 4 along the normals, over that of white noise of deviation 1.
fn coarse_deviation(
    connectivity: &Connectivity,
    x: &[DVec3],
    normals: &[DVec3],
    progress: &dyn Progress,
) -> Result<f64, Cancelled> {
    let umbrella = &connectivity.umbrella;
    let free = BoundaryConstraint::default();
    let band = |x: &[DVec3]| -> Result<Vec<DVec3>, Cancelled> {
        let fine = umbrella.smoothed(x, 0.5, &free, progress)?;
        let wide = umbrella.smoothed(x, 4.0, &free, progress)?;
        Ok(fine.iter().zip(wide).map(|(a, b)| *a - b).collect())
    };
    let regular: Vec<usize> =
        (0..x.len()).filter(|&v| !umbrella.irregular[v] && umbrella.row(v as Index).len() > 1).collect();
    let of_mesh = band(x)?;
    // The three coordinates are three samples of white noise.
    let of_noise = band(&gaussians(x.len(), 3))?;
    let heights: Vec<f64> = regular.iter().map(|&v| normals[v].dot(of_mesh[v]).abs()).collect();
    let expected: Vec<f64> = regular.iter().flat_map(|&v| of_noise[v].abs().to_array()).collect();
    let unit = deviations(&expected).0;
    Ok(if unit > 0.0 { deviations(&heights).0 / unit } else { 0.0 })
}

/// Independent vectors of three standard Gaussians; the same seed gives the same ones. #V×3
pub(super) fn gaussians(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || -> f64 { StandardNormal.sample(&mut random) };
    (0..count).map(|_| DVec3::new(one(), one(), one())).collect()
}

#[cfg(test)]
pub(super) mod tests;
