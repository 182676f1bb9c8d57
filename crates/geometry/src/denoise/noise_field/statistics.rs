//! Statistics of the regions of a mesh from which its noise is estimated.
//!
//! Bands of the positions are differences between smoothings of increasing strength, seen along the normals of a smoothed
//! mesh. White noise of a standard deviation fills all bands alike once they are divided by their response to white noise.
//! Noise that is correlated fills the coarse ones more, a smooth surface the coarse ones only, and detail fills them
//! unevenly.

mod structure;

use super::regions::Regions;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_level::gaussians;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use structure::Structure;

/// Numbers of lazy umbrella steps between which the bands lie.
const STEPS: [usize; 7] = [0, 1, 2, 4, 8, 16, 32];
/// Number of bands: the finest one, U U x with the umbrella operator U, and those between the smoothings.
const BANDS: usize = STEPS.len();
/// Number of values from which quantiles mean something.
const LEAST: usize = 12;
/// Number of bands whose quantiles are statistics as well.
const SHAPED: usize = 4;
/// Number of bands whose correlation between neighbours is a statistic.
const CORRELATED: usize = 3;
/// Number of statistics of a region by itself.
pub(super) const OWN: usize = STRUCTURE + structure::COUNT;
/// Index of the figures of structure.
const STRUCTURE: usize = BANDS + 2 * SHAPED + CORRELATED + 9;
/// Index of the logarithm of the ninth decile of the finest band over its median.
pub(super) const TAIL: usize = BANDS;
/// Logarithm of the ninth decile over the median of the absolute values of a Gaussian: ln(Φ⁻¹(0.95) / Φ⁻¹(0.75)).
pub(super) const TAIL_OF_GAUSSIAN: f64 = 0.8915;
/// Index of the logarithm of what the finest band is across the normals over what it is along them.
pub(super) const ACROSS: usize = BANDS + 2 * SHAPED + CORRELATED;
/// Index of the skewness of the finest band by quantiles, −1..=1.
pub(super) const SKEWNESS: usize = ACROSS + 6;
/// Number of statistics of the component that a region is a part of.
const CONTEXT: usize = 7 + 4 + 3 + 5 + 1 + structure::COUNT;
/// Number of all statistics of a region.
pub(super) const COUNT: usize = OWN + CONTEXT;

/// What is measured at each vertex, from which follow the statistics of regions.
pub(super) struct Statistics<'a> {
    surface: &'a Surface,
    connectivity: &'a Connectivity,
    bands: Bands,
    structure: Structure,
    /// Angles between the faces of the edges, as [`edge_angles`] gives them.
    angles: Ragged<f64>,
    /// Length of the edges around each vertex, model units. #V
    pub(super) local_edge: Vec<f64>,
}

/// The bands of a mesh and of white noise on it.
struct Bands {
    /// Values of each band along the normals, model units. BANDS×#V
    normal: Vec<Vec<f64>>,
    /// Lengths of the finest band across the normals. #V
    tangential: Vec<f64>,
    /// Bands of three samples of white noise of deviation 1. BANDS×#V×3
    white: Vec<Vec<DVec3>>,
}

impl<'a> Statistics<'a> {
    pub(super) fn of(
        surface: &'a Surface,
        connectivity: &'a Connectivity,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let input = surface.positions();
        progress.check()?;
        let smoothed = smoothings(connectivity, input);
        let local_edge = local_edges(surface, &smoothed[4]);
        let normals = connectivity.vertex_normals(&smoothed[4]);
        progress.check()?;
        let bands = Bands::of(connectivity, input, &smoothed, &normals);
        progress.check()?;
        let structure = Structure::of(surface, connectivity, &bands, &smoothed[4], &normals, &local_edge);
        let angles = edge_angles(surface, connectivity);
        Ok(Self { surface, connectivity, bands, structure, angles, local_edge })
    }

    /// Statistics of each region; `None` where the mesh has too few regular vertices to measure anything.
    pub(super) fn of_regions(&self, regions: &Regions) -> Vec<Option<[f64; COUNT]>> {
        let own = |region: usize| self.own(regions, region);
        let own: Vec<Option<[f64; OWN]>> = (0..regions.vertices.len()).into_par_iter().map(own).collect();
        with_context(&own, regions)
    }

    /// Statistics of a region by itself; `None` where too few of its vertices have a band.
    fn own(&self, regions: &Regions, region: usize) -> Option<[f64; OWN]> {
        let Self { surface, connectivity, bands, structure, angles, local_edge } = self;
        let umbrella = &connectivity.umbrella;
        let members = regions.vertices.get(region as Index);
        let regular: Vec<usize> = members
            .iter()
            .map(|&v| v as usize)
            .filter(|&v| !umbrella.irregular[v] && umbrella.row(v as Index).len() > 3 && local_edge[v] > 0.0)
            .collect();
        if regular.len() < LEAST {
            return None;
        }
        let edge = (regular.iter().map(|&v| local_edge[v].ln()).sum::<f64>() / regular.len() as f64).exp();
        let mut out = Vec::with_capacity(OWN);
        let mut quantiles = Vec::new();
        let response = |k: usize| {
            let white: f64 = regular.iter().map(|&v| bands.white[k][v].length_squared()).sum();
            (white / (3.0 * regular.len() as f64)).sqrt()
        };
        let unit: [f64; BANDS] = std::array::from_fn(response);
        for (k, (unit, band)) in unit.iter().zip(&bands.normal).enumerate() {
            let values = sorted(regular.iter().map(|&v| band[v].abs() / local_edge[v]));
            let median = quantile(&values, 0.5);
            out.push(log(median / (0.6745 * unit)));
            if k < SHAPED {
                quantiles.push(log(quantile(&values, 0.9) / median.max(1e-12)));
                quantiles.push(log(quantile(&values, 0.25) / median.max(1e-12)));
            }
        }
        out.extend(quantiles);
        let neighbours = || {
            let rings = surface.topology().rings();
            regular.iter().flat_map(move |&v| rings.get(v as Index).iter().map(move |&w| (v, w as usize)))
        };
        for k in 0..CORRELATED {
            let of_mesh = &bands.normal[k];
            let typical = quantile(&sorted(regular.iter().map(|&v| of_mesh[v].abs())), 0.5).max(1e-300) / 0.6745;
            let clipped = |v: usize| (of_mesh[v] / typical).clamp(-3.0, 3.0);
            let (mut product, mut square, mut count) = (0.0, 0.0, 0.0);
            let (mut of_white, mut of_white_square) = (0.0, 0.0);
            for (v, w) in neighbours() {
                product += clipped(v) * clipped(w);
                square += clipped(v).powi(2);
                of_white += bands.white[k][v].dot(bands.white[k][w]);
                of_white_square += bands.white[k][v].length_squared();
                count += 1.0;
            }
            let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
            out.push(if count > 0.0 { ratio(product, square) - ratio(of_white, of_white_square) } else { 0.0 });
        }
        let across = quantile(&sorted(regular.iter().map(|&v| bands.tangential[v] / local_edge[v])), 0.5);
        out.push(log(across / (1.1774 * unit[0])) - out[0]);
        let of_region = sorted(members.iter().flat_map(|&v| angles.get(v).iter().copied()));
        out.push(log(quantile(&of_region, 0.5)));
        out.push(log(quantile(&of_region, 0.9) / quantile(&of_region, 0.5).max(1e-6)));
        let lengths: Vec<f64> = neighbours()
            .map(|(v, w)| surface.positions()[v].distance(surface.positions()[w]) / edge)
            .map(|l| if l.is_finite() { l.min(100.0) } else { 100.0 })
            .collect();
        out.push(log(variation(&lengths)));
        let valences: Vec<f64> =
            regular.iter().map(|&v| surface.topology().rings().get(v as Index).len() as f64).collect();
        out.push(variation(&valences));
        out.push(1.0 - regular.len() as f64 / members.len() as f64);
        let finest = sorted(regular.iter().map(|&v| bands.normal[0][v]));
        let [low, middle, high] = [0.2, 0.5, 0.8].map(|q| quantile(&finest, q));
        out.push(if high > low { (high + low - 2.0 * middle) / (high - low) } else { 0.0 });
        out.push((regular.len() as f64).ln());
        let edges: Vec<f64> = regular.iter().map(|&v| local_edge[v] / edge).collect();
        out.push(variation(&edges));
        let fine = out[0];
        out.extend(structure.of_region(surface, bands, &regular, fine));
        out.try_into().ok()
    }
}

impl Bands {
    fn of(connectivity: &Connectivity, input: &[DVec3], smoothed: &[Vec<DVec3>], normals: &[DVec3]) -> Self {
        let of_mesh = bands(connectivity, input, smoothed);
        let noise = gaussians(input.len(), 11);
        let white = bands(connectivity, &noise, &smoothings(connectivity, &noise));
        let tangential = of_mesh[0].iter().zip(normals).map(|(b, n)| b.reject_from_normalized(*n).length()).collect();
        let along = |band: &Vec<DVec3>| band.iter().zip(normals).map(|(b, n)| b.dot(*n)).collect();
        Self { normal: of_mesh.iter().map(along).collect(), tangential, white }
    }
}

/// Smoothings of x by the numbers of [`STEPS`]. #V×3 each
fn smoothings(connectivity: &Connectivity, x: &[DVec3]) -> Vec<Vec<DVec3>> {
    let mut all = Vec::with_capacity(STEPS.len());
    let mut now = x.to_vec();
    let mut steps = 0;
    for target in STEPS {
        while steps < target {
            now = connectivity.umbrella.lazy_step(&now);
            steps += 1;
        }
        all.push(now.clone());
    }
    all
}

/// The finest band and those between the smoothings. #V×3 each
fn bands(connectivity: &Connectivity, x: &[DVec3], smoothed: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    let umbrella = &connectivity.umbrella;
    let of = |x: &[DVec3]| -> Vec<DVec3> {
        (0..x.len()).into_par_iter().with_min_len(1024).map(|v| umbrella.at(x, v)).collect()
    };
    let between = smoothed.windows(2).map(|s| s[0].iter().zip(&s[1]).map(|(a, b)| *a - *b).collect());
    std::iter::once(of(&of(x))).chain(between).collect()
}

/// Length of the edges around each vertex: their median at `positions` (#V×3, model units), evened out over a few rings so
/// that single triangles do not matter; 0 for vertices without a face. #V
pub(super) fn local_edges(surface: &Surface, positions: &[DVec3]) -> Vec<f64> {
    const ROUNDS: usize = 4;
    let rings = surface.topology().rings();
    let median = |v: usize| {
        let ring = rings.get(v as Index);
        let mut lengths: Vec<f64> = ring.iter().map(|&w| positions[v].distance(positions[w as usize])).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        lengths.get(lengths.len() / 2).copied().unwrap_or(0.0)
    };
    let mut logs: Vec<f64> = (0..positions.len()).into_par_iter().map(|v| median(v).ln()).collect();
    for _ in 0..ROUNDS {
        let even = |v: usize| {
            let around = rings.get(v as Index).iter().map(|&w| logs[w as usize]).filter(|l| l.is_finite());
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), l| (sum + l, count + 1.0));
            if count == 0.0 {
                logs[v]
            } else if logs[v].is_finite() {
                0.5 * (logs[v] + sum / count)
            } else {
                sum / count
            }
        };
        logs = (0..logs.len()).into_par_iter().map(even).collect();
    }
    logs.into_iter().map(f64::exp).collect()
}

/// Angles between the two faces of each edge that has two, by vertex, radians.
fn edge_angles(surface: &Surface, connectivity: &Connectivity) -> Ragged<f64> {
    let positions = surface.positions();
    let mesh = &connectivity.mesh;
    let normal = |t: &[Index; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let normals: Vec<DVec3> = mesh.triangles.iter().map(normal).collect();
    let angle = |faces: &[Index; 2]| {
        let [a, b] = faces.map(|f| normals[f as usize]);
        a.cross(b).length().atan2(a.dot(b))
    };
    let angles: Vec<f64> = mesh.edge_faces.iter().map(angle).collect();
    let ends = mesh.edge_vertices.iter().zip(&angles).flat_map(|(&[v, w], &angle)| [(v, angle), (w, angle)]);
    Ragged::group(positions.len(), ends)
}

/// A value at a fraction of the sorted values; 0 without any.
fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    sorted.get((fraction * sorted.len() as f64) as usize).copied().unwrap_or(0.0)
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// Natural logarithm of a value that is held within what a file in single precision can tell.
fn log(x: f64) -> f64 {
    x.clamp(1e-7, 1e3).ln()
}

/// Standard deviation over the mean; 0 without any values.
fn variation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
    if mean > 0.0 { squares.sqrt() / mean } else { 0.0 }
}

/// Adds to each region what its component is like.
fn with_context(own: &[Option<[f64; OWN]>], regions: &Regions) -> Vec<Option<[f64; COUNT]>> {
    let components = regions.component.iter().max().map_or(0, |c| *c as usize + 1);
    // Grouped once: a mesh whose triangles share no vertices has as many components as triangles.
    let members = Ragged::group(components, regions.component.iter().zip(0..).map(|(&c, region)| (c, region)));
    let context = |component: usize| -> [f64; CONTEXT] {
        let of = |k: usize| {
            let inside = members.get(component as Index).iter().filter_map(|&region: &Index| own[region as usize]);
            sorted(inside.map(|own| own[k]))
        };
        let mean = |k: usize| {
            let values = of(k);
            values.iter().sum::<f64>() / (values.len() as f64).max(1.0)
        };
        let spread = |k: usize, q: f64| {
            let values = of(k);
            quantile(&values, q) - quantile(&values, 0.5)
        };
        let mut out: Vec<f64> = (0..7).map(mean).collect();
        out.extend([spread(0, 0.1), spread(0, 0.9), spread(3, 0.1), spread(3, 0.9)]);
        let first = BANDS + 2 * SHAPED;
        out.extend((first..first + 3).map(mean));
        let first = first + CORRELATED;
        out.extend([first, first + 1, first + 2, first + 4, first + 6].map(mean));
        out.push((of(0).len() as f64).max(1.0).ln());
        out.extend((STRUCTURE..OWN).map(mean));
        out.try_into().expect("the numbers of statistics agree")
    };
    let contexts: Vec<[f64; CONTEXT]> = (0..components).into_par_iter().map(context).collect();
    let join = |(own, component): (&Option<[f64; OWN]>, &Index)| {
        own.map(|own| {
            let mut all = [0.0; COUNT];
            all[..OWN].copy_from_slice(&own);
            all[OWN..].copy_from_slice(&contexts[*component as usize]);
            all
        })
    };
    own.iter().zip(&regions.component).map(join).collect()
}

#[cfg(test)]
mod tests;
