//! Roughness along straight lines of edges, which bounds the noise from above.
//!
//! Noise is rough in every direction. A fold, a rib or a pleat is rough across and smooth along, so where the surface is smoothest along
//! some line, it shows hardly more than the noise. A field of noise that would be rougher there than the mesh is has taken such shape for
//! noise. How rough it would be is found by a sample of it, on the same lines.

use super::NoiseField;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_level::median;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use glam::{DVec2, DVec3, DVec4};
use rayon::prelude::*;

/// Largest cosine between two edges of a vertex that go on in one line, in its tangent plane.
const STRAIGHT: f64 = -0.8;
/// Number of vertices to either side of the one whose lines are looked at.
const REACH: usize = 4;
/// Least number of vertices of a line.
const LEAST: usize = 5;
/// Number of times that the lines of a vertex are put together with the parallel ones of its neighbours.
const ROUNDS: usize = 2;
/// Least number of vertices with lines.
const FEW: usize = 50;

/// An edge from a vertex to its neighbour, and the one that goes on to the other side.
#[derive(Clone, Copy)]
struct Side {
    neighbour: Index,
    /// Place, among those of the vertex, of the edge on the other side; `None` if none goes straight on.
    opposite: Option<u32>,
    /// Projected length, model units.
    length: f64,
    /// Unit vector to the neighbour in the tangent plane.
    direction: DVec3,
}

/// Distances of a vertex from a line of edges: that of the mesh, and that of a sample of noise.
type Off = DVec2;

/// Sums along lines: the squares of what is off them, of the mesh and of the sample (x, y), and the products of what is off at one vertex
/// and at the next, of both (z, w).
type Sums = DVec4;

/// Number of edges of a vertex up to which lines may go on through it.
const MOST_EDGES: usize = 256;

/// Lines of edges of a mesh.
struct Lines<'a> {
    surface: &'a Surface,
    normals: Vec<DVec3>,
    sides: Ragged<Side>,
}

impl<'a> Lines<'a> {
    fn of(surface: &'a Surface, connectivity: &Connectivity) -> Self {
        let positions = surface.positions();
        let normals = connectivity.vertex_normals(positions);
        let topology = surface.topology();
        let sides = |v: Index| -> Vec<Side> {
            let (p, n) = (positions[v as usize], normals[v as usize]);
            let ring = topology.rings().get(v);
            let flat = |w: &Index| (positions[*w as usize] - p).reject_from_normalized(n);
            let flat: Vec<DVec3> = if n.is_normalized() { ring.iter().map(flat).collect() } else { Vec::new() };
            let directions: Vec<DVec3> = flat.iter().map(|d| d.normalize_or_zero()).collect();
            // No line goes on through the middle of a fan, where all edges would be compared with all.
            let goes_on = !topology.is_boundary(v) && ring.len() <= MOST_EDGES;
            let candidates = if goes_on { &directions[..] } else { &[] };
            let side = |(k, d): (usize, &DVec3)| {
                let others = (0u32..).zip(candidates).map(|(j, e)| (j, d.dot(*e)));
                let best = others.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, c)| *c < STRAIGHT);
                let opposite = best.map(|(j, _)| j);
                Side { neighbour: ring[k], opposite, length: flat[k].length(), direction: *d }
            };
            directions.iter().enumerate().map(side).collect()
        };
        let all: Vec<Vec<Side>> = (0..positions.len() as Index).into_par_iter().map(sides).collect();
        Self { surface, normals, sides: all.into_iter().collect() }
    }

    /// How far each vertex, and each length of the sample along the normals, is off the line through its neighbours on either side of an
    /// edge, where white noise with the deviation of `noise` has a mean square of 1. One list for each vertex, with an entry for each of
    /// its edges; NaN where no edge goes on.
    fn off(&self, noise: &NoiseField, sample: &[f64]) -> Ragged<Off> {
        let positions = self.surface.positions();
        self.by_edge(|v, k| {
            let sigma = noise.relative[v as usize] * noise.edge[v as usize];
            let sides = self.sides.get(v);
            let side = sides[k];
            let Some(other) = side.opposite.map(|j| sides[j as usize]) else { return Off::NAN };
            let share = other.length / (side.length + other.length);
            let [here, a, b] = [v, side.neighbour, other.neighbour].map(|v| v as usize);
            let off = positions[here] - share * positions[a] - (1.0 - share) * positions[b];
            let lift = |v: usize| sample[v] * self.normals[v];
            let sampled = lift(here) - share * lift(a) - (1.0 - share) * lift(b);
            let off = Off::new(off.dot(self.normals[here]), sampled.dot(self.normals[here]));
            off / ((1.0 + share * share + (1.0 - share).powi(2)).sqrt() * sigma)
        })
    }

    /// Means of squares and products along the line of each edge; NaN where it is too short. Entries as in `off`.
    fn along_lines(&self, off: &Ragged<Off>) -> Ragged<Sums> {
        let of_line = |v: Index, k: usize| -> Sums {
            let Some(opposite) = self.sides.get(v)[k].opposite else { return Sums::NAN };
            let own = off.get(v)[k];
            let (mut squares, mut products, mut count) = (own * own, Off::ZERO, 1usize);
            for start in [k, opposite as usize] {
                let (mut at, mut to, mut last) = (v, start, own);
                for _ in 0..REACH {
                    let next = self.sides.get(at)[to].neighbour;
                    let Some(back) = self.sides.get(next).iter().position(|side| side.neighbour == at) else { break };
                    let Some(on) = self.sides.get(next)[back].opposite else { break };
                    let here = off.get(next)[back];
                    squares += here * here;
                    products += last * here;
                    count += 1;
                    (at, to, last) = (next, on as usize, here);
                }
            }
            if count < LEAST {
                return Sums::NAN;
            }
            let (squares, products) = (squares / count as f64, products / (count - 1) as f64);
            Sums::new(squares.x, squares.y, products.x, products.y)
        };
        self.by_edge(of_line)
    }

    /// Means of the values of each edge and of those edges of the neighbours that are most parallel to it.
    fn over_bundles(&self, values: &Ragged<Sums>) -> Ragged<Sums> {
        self.by_edge(|v, k| {
            let own = self.sides.get(v)[k].direction;
            let parallel = |side: &Side| {
                let w = side.neighbour;
                let cosines = self.sides.get(w).iter().map(|of| of.direction.dot(own).abs()).enumerate();
                cosines
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .filter(|(_, c)| *c > -STRAIGHT)
                    .map(|(j, _)| values.get(w)[j])
            };
            let near =
                self.sides.get(v).iter().filter_map(parallel).chain([values.get(v)[k]]).filter(|x| x.is_finite());
            let (sum, count) = near.fold((Sums::ZERO, 0usize), |(sum, count), x| (sum + x, count + 1));
            sum / count as f64
        })
    }

    /// A value for each edge of each vertex.
    fn by_edge<T: Send>(&self, of: impl Fn(Index, usize) -> T + Sync) -> Ragged<T> {
        let of_vertex = |v: Index| (0..self.sides.get(v).len()).map(|k| of(v, k)).collect::<Vec<T>>();
        let all: Vec<Vec<T>> = (0..self.normals.len() as Index).into_par_iter().map(of_vertex).collect();
        all.into_iter().collect()
    }
}

/// Roughness at a vertex along the direction in which its place is smoothest.
#[derive(Clone, Copy)]
struct Along {
    /// Root mean square of what is off the lines over the deviation of a noise.
    off: f64,
    /// Correlation of what is off at one vertex and at the next: −2/3 for white noise on even lines, and up to 1 for a smooth surface.
    correlation: f64,
}

/// Roughness of a mesh, and of a sample of a noise on it, along the direction in which each place is smoothest.
pub(super) struct AlongLines {
    /// Those of the mesh and those of the sample; `None` for a vertex with hardly any lines. #V
    of_vertex: Vec<Option<[Along; 2]>>,
}

impl AlongLines {
    pub(super) fn of(surface: &Surface, connectivity: &Connectivity, noise: &NoiseField) -> Self {
        let lines = Lines::of(surface, connectivity);
        let off = lines.off(noise, &noise.sample(connectivity, 11));
        let mut values = lines.along_lines(&off);
        for _ in 0..ROUNDS {
            values = lines.over_bundles(&values);
        }
        let least = |v: Index| {
            let (mut count, mut least) = (0, [(f64::INFINITY, 0.0); 2]);
            for sums in values.get(v).iter().filter(|sums| sums.is_finite()) {
                count += 1;
                for (least, of) in least.iter_mut().zip([(sums.x, sums.z), (sums.y, sums.w)]) {
                    if of.0 < least.0 {
                        *least = of;
                    }
                }
            }
            let along = |(square, product): (f64, f64)| Along {
                off: square.sqrt(),
                correlation: if square > 0.0 { (product / square).clamp(-1.0, 1.0) } else { 0.0 },
            };
            (count > 2).then(|| least.map(along))
        };
        Self { of_vertex: (0..lines.normals.len() as Index).into_par_iter().map(least).collect() }
    }

    /// Median of how far these vertices are off over that of the sample: 1 or more unless the noise is less than was said. `None` where
    /// fewer than `few` of the vertices have lines.
    pub(super) fn ratio(&self, vertices: impl Iterator<Item = usize>, few: usize) -> Option<f64> {
        let [shown, expected] = self.medians(vertices, few, |along| along.off)?;
        (expected > 0.0).then(|| shown / expected)
    }

    /// Median of the correlations at these vertices less that of the sample; `None` as for `ratio`.
    pub(super) fn correlation(&self, vertices: impl Iterator<Item = usize>, few: usize) -> Option<f64> {
        let [shown, expected] = self.medians(vertices, few, |along| along.correlation)?;
        Some(shown - expected)
    }

    /// Medians over these vertices of the mesh and of the sample.
    fn medians(
        &self,
        vertices: impl Iterator<Item = usize>,
        few: usize,
        of: impl Fn(Along) -> f64,
    ) -> Option<[f64; 2]> {
        let both = vertices.filter_map(|v| self.of_vertex[v]).map(|[shown, expected]| (of(shown), of(expected)));
        let (shown, expected): (Vec<f64>, Vec<f64>) = both.unzip();
        (shown.len() >= few).then(|| [median(shown), median(expected)])
    }
}

/// Root mean square by which the noisy vertices are off the lines of edges through them, along the direction in which a place is
/// smoothest, over that of a sample of the noise: 1 or more unless the noise is less than `noise` says. `None` if there is no noise, or
/// there are too few lines.
pub(in crate::denoise) fn roughness(surface: &Surface, connectivity: &Connectivity, noise: &NoiseField) -> Option<f64> {
    let noisy = (0..noise.relative.len()).filter(|&v| noise.relative[v] > 0.0);
    AlongLines::of(surface, connectivity, noise).ratio(noisy, FEW)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::tests::{displaced, white_noise};
    use crate::mesh::shapes;

    fn found(clean: &Surface, sigma: f64, told: f64) -> f64 {
        let noisy = displaced(clean, &white_noise(clean, sigma, 5));
        let connectivity = Connectivity::of(&noisy);
        let noise = NoiseField::uniform(noisy.positions().len(), told, clean.mean_edge(), 0.0);
        roughness(&noisy, &connectivity, &noise).unwrap()
    }

    #[test]
    fn white_noise_is_as_rough_along_lines_as_a_sample_of_it() {
        for clean in [shapes::bumpy_sheet(40), shapes::sphere(4)] {
            for sigma in [0.1, 0.2] {
                let ratio = found(&clean, sigma, sigma);
                assert!((ratio - 1.0).abs() < 0.15, "{ratio} at {sigma}");
                let ratio = found(&clean, sigma, 4.0 * sigma);
                assert!((ratio - 0.25).abs() < 0.05, "{ratio} at {sigma} for four times as much");
            }
        }
    }

    #[test]
    fn pleats_count_by_their_smooth_direction() {
        let sheet = shapes::grid(40);
        let pleat = |x: f64| 0.2 * (6.0 * x - (6.0 * x).round()).abs();
        let pleated = sheet.at(sheet.positions().iter().map(|p| DVec3::new(p.x, p.y, pleat(p.x))).collect());
        let ratio = found(&pleated, 0.1, 2.0);
        assert!(ratio > 0.02 && ratio < 0.1, "{ratio} where 0.05 is right");
    }
}
