//! How noisy a mesh is, from the mesh alone.
//!
//! The finest detail that a mesh can hold, (U U x)ᵢ along the normal, is nearly all noise: with white noise of deviation σ
//! it is Gaussian with deviation σ |row i of U U|, and the median of its absolute values tells σ even where a part of the
//! surface has creases. Coarser bands, between two smoothings of different strength, say more than that only where the
//! noise of neighbours is alike or where the surface itself has detail.

use super::map::Net;
use super::umbrella::Freedom;
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::surface::Surface;
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Below this many mean edges there is no noise but the rounding of numbers.
pub(super) const NOTHING: f64 = 1e-6;

/// Deviation of the noise along the normal as bands of the mesh show it, in mean edge lengths of the smoothed mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseLevel {
    /// From the median of the finest band.
    pub fine: f64,
    /// From the ninth decile of the finest band: more than `fine` where few vertices are hit, or at creases.
    pub tail: f64,
    /// From a band of about two edges.
    pub coarse: f64,
    /// By how much more often than in white noise neighbours are off to the same side in the finest band: the share of the
    /// edges with equal signs minus that in noise. Detail of the surface makes it large.
    pub agreement: f64,
    /// Deviation across the normal in each of two directions, from the median of the finest band: vertices lie unevenly, and
    /// noise may push them sideways, by no more than that.
    #[serde(default)]
    pub across: f64,
    /// How lopsided the finest band is: (q₈₀ + q₂₀ − 2 q₅₀) / (q₈₀ − q₂₀) of its quantiles, −1..=1 and 0 for noise.
    pub skew: f64,
}

/// A first look at a mesh.
pub(super) struct Look {
    pub(super) level: NoiseLevel,
    /// Of the smoothed mesh, model units.
    pub(super) mean_edge: f64,
    /// μ of the smoothing.
    pub(super) smoothing: f64,
}

impl Look {
    pub(super) fn at(surface: &Surface, net: &Net, progress: &dyn Progress) -> Result<Self, Cancelled> {
        let free = Freedom::default();
        let input = surface.positions();
        let smooth = |mu: f64| -> Result<(f64, Vec<DVec3>), Cancelled> {
            let smoothed = net.umbrella.smoothed(input, mu, &free, progress)?;
            let normals = net.vertex_normals(&smoothed);
            Ok((surface.at(smoothed).mean_edge(), normals))
        };
        let finest = Finest::of(net);
        let (edge, normals) = smooth(8.0)?;
        let first = deviations(&magnitudes(&finest.along(net, input, &normals))).0 / edge;
        // Noise of a tenth of an edge goes with μ = 1, and as σ² beyond.
        let smoothing = if first.is_finite() { (100.0 * first * first).max(0.5) } else { 0.5 };
        let (mean_edge, normals) = smooth(smoothing)?;
        let heights = finest.along(net, input, &normals);
        let (fine, tail) = deviations(&magnitudes(&heights));
        let agreement = finest.agreement(surface, &heights) - finest.agreement_of_noise(surface, net);
        let coarse = coarse(net, input, &normals, progress)?;
        let across = median(finest.across(net, input, &normals)) / MEDIAN_OF_TWO;
        let [fine, tail, coarse, across] =
            [fine, tail, coarse, across].map(|x| if mean_edge > 0.0 && x.is_finite() { x / mean_edge } else { 0.0 });
        let skew = lopsided(heights);
        Ok(Self { level: NoiseLevel { fine, tail, coarse, agreement, across, skew }, mean_edge, smoothing })
    }
}

impl NoiseLevel {
    /// Share of the finest band that is detail of the surface, in the square, where chance alone makes `chance` of the
    /// agreement.
    fn detail(&self, chance: f64) -> f64 {
        // In clean meshes with detail it is 0.03 to 0.17, and less where detail is finer.
        const OF_DETAIL: f64 = 0.045;
        ((self.agreement - chance) / OF_DETAIL).clamp(0.0, 1.0)
    }

    /// σ for a data term where the noise is of this kind, mean edges.
    pub(super) fn sigma_as(&self, kind: Kind) -> f64 {
        // Creases fill the tail even without noise.
        let white = self.fine.max(self.tail).min(1.6 * self.fine);
        match kind {
            Kind::Correlated if self.is_rough() => 7.5 * self.excess(),
            Kind::Correlated => 1.5 * self.inflation() * white,
            Kind::None => white * (1.0 - self.detail(0.01)).sqrt(),
            Kind::Independent | Kind::Uneven => white,
        }
    }

    /// How many times more the data hold vertices across the normals than along them, minus one. What the bands say of noise
    /// that is not white is too uncertain for that.
    pub(super) fn held(&self, kind: Kind) -> f64 {
        match kind {
            Kind::None | Kind::Correlated => 0.0,
            Kind::Independent | Kind::Uneven => held(self.fine, self.across),
        }
    }

    /// What these figures say.
    pub fn kind(&self) -> Kind {
        // Noise turns faces by about as many degrees as it has hundredths of an edge. What is less is hardly seen and
        // cannot be told from detail, and a barely noisy mesh stays as it is.
        const LEAST: f64 = 0.035;
        const LEAST_ROUGH: f64 = 0.02;
        // Sensors err to both sides alike. Roughness has pits or bumps: where noise lifts only, it is 0.15.
        const LOPSIDED: f64 = 0.125;
        let white = self.fine * (1.0 - self.detail(0.005)).sqrt();
        if white < if self.is_rough() { LEAST_ROUGH } else { LEAST } || self.skew.abs() > LOPSIDED {
            Kind::None
        } else if self.is_rough() || self.inflation() > 2.5 {
            Kind::Correlated
        } else if self.tail > 1.3 * self.fine {
            Kind::Uneven
        } else {
            Kind::Independent
        }
    }

    /// What the coarse band holds beyond white noise, mean edges.
    fn excess(&self) -> f64 {
        (self.coarse * self.coarse - 1.21 * self.fine * self.fine).max(0.0).sqrt()
    }

    /// The same beyond the detail of common surfaces too, as a factor for σ.
    fn inflation(&self) -> f64 {
        const DETAIL: f64 = 0.07;
        (self.excess() / DETAIL).powi(2).clamp(1.0, 5.0)
    }

    /// Whether the coarse band has more than the surface explains. Detail that is seen there is seen in the finest band as
    /// well, where it makes neighbours agree: in clean meshes the agreement is 0.007 to 0.017 of (coarse / fine)², with
    /// noise added no less. Photogrammetry is as rough over many edges as over one, without any agreement.
    fn is_rough(&self) -> bool {
        const EXPLAINED: f64 = 0.008;
        const MARGIN: f64 = 0.015;
        let explained = EXPLAINED * (self.excess() / self.fine).powi(2);
        self.fine > 0.0 && self.agreement < MARGIN && explained > self.agreement.max(0.0) + MARGIN
    }
}

/// The same for noise of these deviations along the normals and across them.
pub(super) fn held(along: f64, across: f64) -> f64 {
    // Normals are estimates: what lies across them has a part along the true ones.
    const MOST: f64 = 15.0;
    if across > 0.0 { ((along / across).powi(2) - 1.0).clamp(0.0, MOST) } else { MOST }
}

/// What noise looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// None that could be told from the surface.
    None,
    /// White: each vertex is off by its own amount.
    Independent,
    /// The same, much more at some vertices than at others.
    Uneven,
    /// Neighbours are off to the same side.
    Correlated,
}

/// Vertices with a closed ring of vertices with closed rings, and |row of U U|.
struct Finest {
    vertices: Vec<(Index, f64)>,
}

impl Finest {
    fn of(net: &Net) -> Self {
        let rim = &net.umbrella.rim;
        let gain = |v: Index| {
            let row = net.umbrella.row(v);
            if row.len() < 4 || row.iter().any(|&(w, _)| rim[w as usize]) {
                return None;
            }
            let mut entries: Vec<(Index, f64)> =
                row.iter().flat_map(|&(w, x)| net.umbrella.row(w).iter().map(move |&(u, y)| (u, x * y))).collect();
            entries.sort_by_key(|entry| entry.0);
            let same = entries.chunk_by(|a, b| a.0 == b.0);
            let squared: f64 = same.map(|e| e.iter().map(|e| e.1).sum::<f64>().powi(2)).sum();
            Some((v, squared.sqrt()))
        };
        let vertices = (0..rim.len() as Index).into_par_iter().filter_map(gain).collect();
        Self { vertices }
    }

    /// n · U U x over its gain, model units.
    fn along(&self, net: &Net, x: &[DVec3], normals: &[DVec3]) -> Vec<f64> {
        let once: Vec<DVec3> = (0..x.len()).into_par_iter().map(|v| net.umbrella.at(x, v)).collect();
        let one = |&(v, gain): &(Index, f64)| {
            let v = v as usize;
            normals[v].dot(net.umbrella.at(&once, v)) / gain
        };
        self.vertices.par_iter().map(one).collect()
    }

    /// |U U x| across n over its gain, model units.
    fn across(&self, net: &Net, x: &[DVec3], normals: &[DVec3]) -> Vec<f64> {
        let once: Vec<DVec3> = (0..x.len()).into_par_iter().map(|v| net.umbrella.at(x, v)).collect();
        let one = |&(v, gain): &(Index, f64)| {
            let v = v as usize;
            net.umbrella.at(&once, v).reject_from_normalized(normals[v]).length() / gain
        };
        self.vertices.par_iter().map(one).collect()
    }

    /// Share of the edges whose ends have heights of one sign; 0 without any.
    fn agreement(&self, surface: &Surface, heights: &[f64]) -> f64 {
        let mut of_vertex = vec![0.0; surface.positions().len()];
        self.vertices.iter().zip(heights).for_each(|(&(v, _), h)| of_vertex[v as usize] = *h);
        let products = surface.topology().edges().iter().map(|e| of_vertex[e[0] as usize] * of_vertex[e[1] as usize]);
        let (same, all) = products
            .filter(|p| *p != 0.0)
            .fold((0.0, 0.0), |(same, all), p| (same + f64::from(u8::from(p > 0.0)), all + 1.0));
        if all > 0.0 { same / all } else { 0.0 }
    }

    /// The same where heights are white noise.
    fn agreement_of_noise(&self, surface: &Surface, net: &Net) -> f64 {
        let count = surface.positions().len();
        let heights = self.along(net, &gaussians(count, 5), &vec![DVec3::X; count]);
        self.agreement(surface, &heights)
    }
}

fn magnitudes(heights: &[f64]) -> Vec<f64> {
    heights.iter().map(|h| h.abs()).collect()
}

/// Deviation of a Gaussian from the median and from the ninth decile of its absolute values; 0 without any.
fn deviations(absolute: &[f64]) -> (f64, f64) {
    let mut sorted = absolute.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(0.0);
    (1.4826 * at(0.5), at(0.9) / 1.6449)
}

/// Of the length of two Gaussians of deviation 1: √(2 ln 2).
const MEDIAN_OF_TWO: f64 = 1.1774;

/// 0 without any.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// (q₈₀ + q₂₀ − 2 q₅₀) / (q₈₀ − q₂₀), farther in than where creases are; 0 for too few values to tell.
fn lopsided(mut heights: Vec<f64>) -> f64 {
    // With as many Gaussian values the quotient is below 0.12 but for one time in a thousand.
    const ENOUGH: usize = 2000;
    if heights.len() < ENOUGH {
        return 0.0;
    }
    heights.sort_unstable_by(f64::total_cmp);
    let [low, middle, high] = [2, 5, 8].map(|tenths| heights[tenths * heights.len() / 10]);
    if high > low { (high + low - 2.0 * middle) / (high - low) } else { 0.0 }
}

/// Deviation from the band between smoothings with μ = ½ and 4, against that of white noise of deviation 1.
fn coarse(net: &Net, x: &[DVec3], normals: &[DVec3], progress: &dyn Progress) -> Result<f64, Cancelled> {
    let free = Freedom::default();
    let band = |x: &[DVec3]| -> Result<Vec<DVec3>, Cancelled> {
        let fine = net.umbrella.smoothed(x, 0.5, &free, progress)?;
        let wide = net.umbrella.smoothed(x, 4.0, &free, progress)?;
        Ok(fine.iter().zip(wide).map(|(a, b)| *a - b).collect())
    };
    let inner: Vec<usize> =
        (0..x.len()).filter(|&v| !net.umbrella.rim[v] && net.umbrella.row(v as Index).len() > 1).collect();
    let seen = band(x)?;
    // Three samples of white noise at once.
    let white = band(&gaussians(x.len(), 3))?;
    let heights: Vec<f64> = inner.iter().map(|&v| normals[v].dot(seen[v]).abs()).collect();
    let expected: Vec<f64> = inner.iter().flat_map(|&v| white[v].abs().to_array()).collect();
    let unit = deviations(&expected).0;
    Ok(if unit > 0.0 { deviations(&heights).0 / unit } else { 0.0 })
}

/// Independent standard Gaussians. #V×3
pub(super) fn gaussians(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || -> f64 { StandardNormal.sample(&mut random) };
    (0..count).map(|_| DVec3::new(one(), one(), one())).collect()
}

#[cfg(test)]
pub(super) mod tests;
