//! Estimation of the noise of a mesh as a field: how much it is at each vertex, and what it is like.

mod forest;
mod levels;
pub(super) mod lines;
mod network;
mod outliers;
mod regions;
mod rounding;
mod samples;
mod statistics;
mod verdict;

pub use samples::{RegionSample, samples};
pub(super) use verdict::Verdict;

use super::connectivity::Connectivity;
use super::noise_level::{self, gaussians, median};
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use levels::{log_mean, shrunken, spread};
use network::{Network, Reading};
use rayon::prelude::*;
use regions::Regions;
use statistics::Statistics;

/// Noise at each vertex of a mesh.
#[derive(Clone)]
pub(super) struct NoiseField {
    /// Standard deviation of the noise along the normal, in lengths of the local edges; 0 where a vertex stays. #V
    pub(super) relative: Vec<f64>,
    /// Length of the local edges, model units. #V
    pub(super) edge: Vec<f64>,
    /// Weight of the data term's tangential part, on top of the weight 1 of all directions; 0 for isotropic noise. #V
    pub(super) stiffness: Vec<f64>,
    /// Number of lazy umbrella steps that make white noise as alike between neighbours as this noise is.
    pub(super) correlation: usize,
    /// Half a step of the grid to which the coordinates were rounded, where rounding is all the noise there is; infinite for other
    /// axes, model units.
    pub(super) half_step: DVec3,
    /// Vertices that are no samples of the surface, and where their neighbours suggest that they belong. (vertex, model units)
    pub(super) outliers: Vec<(Index, DVec3)>,
    /// Fraction of the vertices in regions where nothing can be measured, 0..=1.
    pub(super) unmeasured: f64,
    /// False where the deviation was told, so that all vertices have it.
    pub(super) is_measured: bool,
}

/// Number of lazy umbrella steps that smooth terraces away: six edges.
const LAZY_STEPS_OVER_TERRACES: usize = 64;

/// Deviation below which a region has no noise, local edges; it is what networks and trees were taught.
const NONE: f64 = 0.004;

/// Least deviation by which data are weighed, local edges: that of positions which are as good as exact.
const LEAST: f64 = 0.01;

impl NoiseField {
    /// Noise that is the same at all vertices: a standard deviation of `relative` mean edges.
    pub(super) fn uniform(count: usize, relative: f64, mean_edge: f64, stiffness: f64) -> Self {
        Self {
            relative: vec![relative; count],
            edge: vec![mean_edge; count],
            stiffness: vec![stiffness; count],
            correlation: 0,
            half_step: DVec3::INFINITY,
            outliers: Vec::new(),
            unmeasured: 0.0,
            is_measured: false,
        }
    }

    /// Noise of a height field whose heights were rounded to so coarse a grid that neighbours often are the same: terraces. `fine`
    /// is the deviation of the finest band, model units. `None` where rounding is not all the noise there is.
    pub(super) fn terraces(surface: &Surface, connectivity: &Connectivity, fine: f64) -> Option<Self> {
        let positions = surface.positions();
        let up = surface.face_vectors().iter().sum::<DVec3>().abs();
        let axis = (0..3).max_by(|&a, &b| up[a].total_cmp(&up[b]))?;
        // The other two are the places where heights were taken; these may lie on a grid as well.
        let mut steps = [None; 3];
        steps[axis] = Some(rounding::steps(positions)[axis]?);
        let edge = without_gaps(statistics::local_edges(surface, positions));
        let deviations = rounding::deviations(steps, &connectivity.vertex_normals(positions));
        if fine >= median(deviations.clone()) {
            return None;
        }
        let relative: Vec<f64> = deviations.iter().zip(&edge).map(|(s, h)| s / h).collect();
        // The deviation of a coordinate from what it was before is a sawtooth: neighbours that are t steps apart have deviations
        // with the correlation 1 − 6 t (1 − t). How far they are apart shows where the terraces are smoothed away.
        let mut smoothed = positions.to_vec();
        for _ in 0..LAZY_STEPS_OVER_TERRACES {
            smoothed = connectivity.umbrella.lazy_step(&smoothed);
        }
        let step = steps[axis].unwrap_or(f64::INFINITY);
        let alike = |[v, w]: &[Index; 2]| {
            let t = ((smoothed[*v as usize][axis] - smoothed[*w as usize][axis]).abs() / step).min(1.0);
            1.0 - 6.0 * t * (1.0 - t)
        };
        let edges = surface.topology().edges();
        let correlation = edges.iter().map(alike).sum::<f64>() / edges.len().max(1) as f64;
        let correlation = steps_of_correlation(surface, connectivity, correlation);
        let half_step = half_step(steps, &relative, &edge);
        let stiffness = vec![0.0; edge.len()];
        let uniform = Self::uniform(positions.len(), 0.0, 0.0, 0.0);
        Some(Self { relative, edge, stiffness, correlation, half_step, is_measured: true, ..uniform })
    }

    /// True for noise that is the rounding of all coordinates to one grid: the finest band shows as much as that makes. `fine` is its
    /// deviation, model units.
    pub(super) fn is_rounding(surface: &Surface, connectivity: &Connectivity, fine: f64) -> bool {
        /// Least and largest ratio of the two deviations. Between neighbours that were rounded alike the band sees less, and detail of
        /// the surface adds to it.
        const RATIO: [f64; 2] = [0.4, 2.0];
        let steps = rounding::steps(surface.positions());
        if !rounding::is_one_grid(steps) {
            return false;
        }
        let rounded = median(rounding::deviations(steps, &connectivity.vertex_normals(surface.positions())));
        fine > RATIO[0] * rounded && fine < RATIO[1] * rounded
    }

    /// Estimates the noise of each vertex.
    pub(super) fn measured(
        surface: &Surface,
        connectivity: &Connectivity,
        verdict: Verdict,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let statistics = Statistics::of(surface, connectivity, progress)?;
        let regions = verdict::partition(surface.topology(), 0);
        let of_regions = statistics.of_regions(&regions);
        let readings = readings(&of_regions);
        let noisy = verdict::noisy_regions(verdict, surface.topology(), &statistics, &regions, &of_regions);
        let edges: Vec<f64> =
            regions.vertices.iter().map(|members| log_mean(members, &statistics.local_edge)).collect();
        let tails = log_excess_of_tails(&of_regions, &regions);
        let of_noisy = readings.iter().zip(&noisy).filter(|(_, noisy)| **noisy).filter_map(|(r, _)| r.as_ref());
        let (sum, count) = of_noisy.fold((0.0, 0.0), |(sum, count), r| (sum + r.correlation, count + 1.0));
        let correlation = if count > 0.0 { sum / count } else { 0.0 };
        // The finest band may show little white noise beside much that neighbours share.
        let is_white = matches!(verdict, Verdict::White | Verdict::SurelyWhite) && correlation < SHARED[1];
        // What the finest band says is exact for white noise, and too little for noise that neighbours share.
        let shared = |correlation: f64| match is_white {
            true => 0.0,
            false => ((correlation - SHARED[0]) / (SHARED[1] - SHARED[0])).clamp(0.0, 1.0),
        };
        let log_relative = |region: usize| {
            let (statistics, reading) = (of_regions[region].as_ref()?, readings[region].as_ref()?);
            let tail = tails[regions.component[region] as usize];
            let log = statistics[0] + tail.max(shared(reading.correlation) * reading.log_excess);
            (noisy[region] && log > NONE.ln()).then_some(log)
        };
        let relative: Vec<Option<f64>> = (0..readings.len()).map(log_relative).collect();
        let of_region = shrunken(&relative, &edges, &regions);
        let mut relative = spread(surface, &regions, &of_region, &statistics.local_edge);
        let edge = without_gaps(statistics.local_edge);
        let correlation = if is_white { 0 } else { steps_of_correlation(surface, connectivity, correlation) };
        let stiffness = if correlation == 0 { stiffness(&of_regions, &regions) } else { vec![0.0; edge.len()] };
        let unknown = regions.vertices.iter().zip(&readings).filter(|(_, reading)| reading.is_none());
        let unmeasured = unknown.map(|(members, _)| members.len()).sum::<usize>() as f64 / relative.len().max(1) as f64;
        let steps = rounding::steps(surface.positions());
        let rounded = rounding::deviations(steps, &connectivity.vertex_normals(surface.positions()));
        for ((relative, edge), rounded) in relative.iter_mut().zip(&edge).zip(rounded) {
            // Neighbours that were rounded alike hide it from the finest band.
            *relative = if *relative > 0.0 { relative.max(rounded / edge) } else { 0.0 };
        }
        let half_step = half_step(steps, &relative, &edge);
        let outliers = outliers::outliers(surface, &statistics::local_edges(surface, surface.positions()));
        let mut field =
            Self { relative, edge, stiffness, correlation, half_step, outliers, unmeasured, is_measured: true };
        let typical = field.typical();
        if typical > 0.0 {
            // Nothing holds an outlier but its neighbours.
            field.outliers.iter().for_each(|&(v, _)| field.relative[v as usize] = typical.max(1.0));
        }
        Ok(field)
    }

    /// Fraction of the vertices that are noisy, 0..=1.
    pub(super) fn noisy_fraction(&self) -> f64 {
        self.relative.iter().filter(|s| **s > 0.0).count() as f64 / self.relative.len().max(1) as f64
    }

    /// Standard deviation by which the data of each vertex are weighed, model units. #V
    pub(super) fn sigma(&self) -> impl Iterator<Item = f64> + '_ {
        self.relative.iter().zip(&self.edge).map(|(relative, edge)| relative.max(LEAST) * edge)
    }

    /// Mean of the lengths of the local edges, model units.
    pub(super) fn mean_edge(&self) -> f64 {
        mean(&self.edge)
    }

    /// Length of the edges around a triangle, model units.
    pub(super) fn edge_of(&self, triangle: &[Index; 3]) -> f64 {
        triangle.iter().map(|&v| self.edge[v as usize]).sum::<f64>() / 3.0
    }

    /// Median of the deviations of the vertices that move, local edges; 0 if none does.
    pub(super) fn typical(&self) -> f64 {
        median(self.relative.iter().copied().filter(|s| *s > 0.0).collect())
    }

    /// Median of the deviations across the normals of the vertices that move, local edges; 0 if none does.
    pub(super) fn typical_across(&self) -> f64 {
        let moving = self.relative.iter().zip(&self.stiffness).filter(|(s, _)| **s > 0.0);
        median(moving.map(|(s, stiffness)| s / (1.0 + stiffness).sqrt()).collect())
    }

    /// Noise that is `factor` times as large. Without any, outliers are left alone, too.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        if factor == 0.0 {
            self.outliers.clear();
        }
        self.relative.iter_mut().for_each(|relative| *relative *= factor);
        self
    }

    /// Shortens offsets (#V×3, model units) that are longer than noise can be; returns the number of them.
    pub(super) fn bound(&self, offsets: &mut [DVec3]) -> usize {
        /// One vertex in two millions is farther off than this many standard deviations.
        const LARGEST: f64 = 5.0;
        let mut shortened = 0;
        for ((offset, relative), edge) in offsets.iter_mut().zip(&self.relative).zip(&self.edge) {
            let bounded = offset.clamp_length_max(LARGEST * relative * edge).clamp(-self.half_step, self.half_step);
            shortened += usize::from(bounded != *offset);
            *offset = bounded;
        }
        shortened
    }

    /// Noise of a part of the surface, whose vertices have these indices in the whole.
    pub(super) fn of_part(&self, vertices: &[Index]) -> Self {
        let pick = |all: &[f64]| vertices.iter().map(|&v| all[v as usize]).collect();
        Self {
            relative: pick(&self.relative),
            edge: pick(&self.edge),
            stiffness: pick(&self.stiffness),
            correlation: self.correlation,
            half_step: self.half_step,
            outliers: Vec::new(),
            unmeasured: self.unmeasured,
            is_measured: self.is_measured,
        }
    }

    /// Strength μ of smoothing at each vertex, from its deviation in local edges. #V
    pub(super) fn strengths(&self, of: impl Fn(f64) -> f64) -> Vec<f64> {
        self.relative.iter().map(|&s| if s > 0.0 { of(s) } else { 0.0 }).collect()
    }

    /// A sample of the noise: signed lengths along the normals, model units. #V
    pub(super) fn sample(&self, connectivity: &Connectivity, seed: u64) -> Vec<f64> {
        let mut sample = gaussians(self.relative.len(), seed);
        for _ in 0..self.correlation {
            sample = connectivity.umbrella.lazy_step(&sample);
        }
        let squares: f64 = sample.iter().map(|g| g.length_squared()).sum();
        let unit = (squares / (3.0 * sample.len() as f64)).sqrt();
        sample.iter().zip(&self.relative).zip(&self.edge).map(|((g, s), edge)| g.x / unit * s * edge).collect()
    }
}

/// Half the steps of rounded coordinates, where the noise is no larger than rounding makes it; infinite for other axes.
fn half_step(steps: [Option<f64>; 3], relative: &[f64], edge: &[f64]) -> DVec3 {
    /// Largest deviation over the step. That of rounding is 0.29.
    const LARGEST: f64 = 0.45;
    let typical = median(relative.iter().zip(edge).map(|(s, h)| s * h).filter(|s| *s > 0.0).collect());
    let half = steps.map(|step| match step {
        Some(step) if typical < LARGEST * step => 0.5 * step,
        _ => f64::INFINITY,
    });
    DVec3::from_array(half)
}

/// Lengths of local edges (#V, model units) with their mean where a vertex has none.
fn without_gaps(mut edge: Vec<f64>) -> Vec<f64> {
    let mean = mean(&edge);
    edge.iter_mut().filter(|edge| edge.is_nan() || **edge <= 0.0).for_each(|edge| *edge = mean);
    edge
}

/// Mean of the positive values; 0 without any.
fn mean(values: &[f64]) -> f64 {
    let (sum, count) = values.iter().filter(|x| **x > 0.0).fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Correlations between neighbours from which noise counts as shared, and as shared wholly: chance alone makes a tenth.
const SHARED: [f64; 2] = [0.1, 0.4];

/// Least distance between the middles of two regions, rings: a hundred vertices, from which a deviation is known to an eighth.
const RINGS: u32 = 6;
/// Least number of vertices of a region that has neighbours.
const LEAST_REGION: usize = 40;

/// What the networks say of each region.
fn readings(statistics: &[Option<[f64; statistics::COUNT]>]) -> Vec<Option<Reading>> {
    let network = Network::built_in();
    statistics.par_iter().map(|s| s.as_ref().map(|s| network.read(s))).collect()
}

/// Logarithm of the deviation over what the median of the finest band says where few vertices are hit, one for each component. The
/// tail of the band shows it; creases fill the tails of single regions even without noise, so the median over the regions counts.
fn log_excess_of_tails(statistics: &[Option<[f64; statistics::COUNT]>], regions: &Regions) -> Vec<f64> {
    /// Largest factor.
    const MOST: f64 = 1.6;
    let medians = medians_by_component(statistics, regions, statistics::TAIL);
    medians
        .into_iter()
        .map(|tail| tail.map_or(0.0, |t| (t - statistics::TAIL_OF_GAUSSIAN).clamp(0.0, MOST.ln())))
        .collect()
}

/// Median of a statistic over the regions of each component; `None` for one without regions that could be measured.
fn medians_by_component(
    statistics: &[Option<[f64; statistics::COUNT]>],
    regions: &Regions,
    index: usize,
) -> Vec<Option<f64>> {
    let components = regions.component.iter().max().map_or(0, |c| *c as usize + 1);
    let mut values = vec![Vec::new(); components];
    for (statistics, component) in statistics.iter().zip(&regions.component) {
        values[*component as usize].extend(statistics.map(|s| s[index]));
    }
    values.into_iter().map(|values| (!values.is_empty()).then(|| median(values))).collect()
}

/// Weight of the data term's tangential part at each vertex, from the median over its component of what the finest band is across
/// and along the normals. #V
fn stiffness(statistics: &[Option<[f64; statistics::COUNT]>], regions: &Regions) -> Vec<f64> {
    let stiffness = |ratio: Option<f64>| ratio.map_or(0.0, |ratio| noise_level::tangential_stiffness(1.0, ratio.exp()));
    let ratios = medians_by_component(statistics, regions, statistics::ACROSS);
    let of_component: Vec<f64> = ratios.into_iter().map(stiffness).collect();
    regions.of_vertex.iter().map(|&r| of_component[regions.component[r as usize] as usize]).collect()
}

/// Number of lazy umbrella steps after which white noise on this mesh has the correlation between neighbours that is given.
fn steps_of_correlation(surface: &Surface, connectivity: &Connectivity, correlation: f64) -> usize {
    const MOST: usize = 24;
    let edges = surface.topology().edges();
    let mut x = gaussians(surface.positions().len(), 13);
    let mut found = (f64::INFINITY, 0);
    for steps in 0..=MOST {
        let (mut product, mut square) = (0.0, 0.0);
        for &[v, w] in edges {
            let [a, b] = [x[v as usize], x[w as usize]];
            product += a.dot(b);
            square += 0.5 * (a.length_squared() + b.length_squared());
        }
        let gap = if square > 0.0 { (product / square - correlation).abs() } else { 0.0 };
        if gap < found.0 {
            found = (gap, steps);
        }
        x = connectivity.umbrella.lazy_step(&x);
    }
    found.1
}

#[cfg(test)]
mod tests;
