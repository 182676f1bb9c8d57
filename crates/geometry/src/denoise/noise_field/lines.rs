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
use glam::DVec3;
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
}

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
            let directions: Vec<DVec3> = if n.is_normalized() { ring.iter().map(flat).collect() } else { Vec::new() };
            let side = |(k, d): (usize, &DVec3)| {
                let cosine = |e: &DVec3| d.dot(*e) / (d.length() * e.length());
                let others = (0u32..).zip(&directions).map(|(j, e)| (j, cosine(e))).filter(|(_, c)| c.is_finite());
                let best = others.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, c)| *c < STRAIGHT);
                let opposite = best.map(|(j, _)| j).filter(|_| !topology.is_boundary(v));
                Side { neighbour: ring[k], opposite, length: d.length() }
            };
            directions.iter().enumerate().map(side).collect()
        };
        let all: Vec<Vec<Side>> = (0..positions.len() as Index).into_par_iter().map(sides).collect();
        Self { surface, normals, sides: all.into_iter().collect() }
    }

    /// How far each vertex is off the line through its neighbours on either side of an edge, squared, where one of white noise with a
    /// deviation of 1 is 1 in the mean. One list for each vertex, with an entry for each of its edges; NaN where no edge goes on.
    /// `lift` gives how far a vertex is lifted, as a vector.
    fn squares(&self, noise: &NoiseField, lift: impl Fn(Index) -> DVec3 + Sync) -> Ragged<f64> {
        self.by_edge(|v, k| {
            let sigma = noise.relative[v as usize] * noise.edge[v as usize];
            let sides = self.sides.get(v);
            let side = sides[k];
            let Some(other) = side.opposite.map(|j| sides[j as usize]) else { return f64::NAN };
            let share = other.length / (side.length + other.length);
            let here = lift(v) - share * lift(side.neighbour) - (1.0 - share) * lift(other.neighbour);
            let square = here.dot(self.normals[v as usize]).powi(2);
            square / (1.0 + share * share + (1.0 - share).powi(2)) / (sigma * sigma)
        })
    }

    /// Mean of the squares along the line of each edge; NaN where it is too short. Entries as in `squares`.
    fn along_lines(&self, squares: &Ragged<f64>) -> Ragged<f64> {
        let of_line = |v: Index, k: usize| -> f64 {
            let Some(opposite) = self.sides.get(v)[k].opposite else { return f64::NAN };
            let (mut sum, mut count) = (squares.get(v)[k], 1usize);
            for start in [k, opposite as usize] {
                let (mut at, mut to) = (v, start);
                for _ in 0..REACH {
                    let next = self.sides.get(at)[to].neighbour;
                    let Some(back) = self.sides.get(next).iter().position(|side| side.neighbour == at) else { break };
                    let Some(on) = self.sides.get(next)[back].opposite else { break };
                    sum += squares.get(next)[back];
                    count += 1;
                    (at, to) = (next, on as usize);
                }
            }
            if count >= LEAST { sum / count as f64 } else { f64::NAN }
        };
        self.by_edge(of_line)
    }

    /// Mean of the values of each edge and of those edges of the neighbours that are most parallel to it.
    fn over_bundles(&self, values: &Ragged<f64>) -> Ragged<f64> {
        let direction = |v: Index, k: usize| {
            let towards = self.position(self.sides.get(v)[k].neighbour) - self.position(v);
            towards.reject_from(self.normals[v as usize]).normalize_or_zero()
        };
        self.by_edge(|v, k| {
            let own = direction(v, k);
            let parallel = |side: &Side| {
                let w = side.neighbour;
                let cosines = (0..self.sides.get(w).len()).map(|j| (j, direction(w, j).dot(own).abs()));
                cosines
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .filter(|(_, c)| *c > -STRAIGHT)
                    .map(|(j, _)| values.get(w)[j])
            };
            let near =
                self.sides.get(v).iter().filter_map(parallel).chain([values.get(v)[k]]).filter(|x| x.is_finite());
            let (sum, count) = near.fold((0.0, 0usize), |(sum, count), x| (sum + x, count + 1));
            sum / count as f64
        })
    }

    /// A value for each edge of each vertex.
    fn by_edge(&self, of: impl Fn(Index, usize) -> f64 + Sync) -> Ragged<f64> {
        let of_vertex = |v: Index| (0..self.sides.get(v).len()).map(|k| of(v, k)).collect::<Vec<f64>>();
        let all: Vec<Vec<f64>> = (0..self.normals.len() as Index).into_par_iter().map(of_vertex).collect();
        all.into_iter().collect()
    }

    /// Median over the noisy vertices of the root of the mean square along those lines where it is least. `None` if hardly any
    /// vertex has lines.
    fn least(&self, noise: &NoiseField, squares: &Ragged<f64>) -> Option<f64> {
        let mut values = self.along_lines(squares);
        for _ in 0..ROUNDS {
            values = self.over_bundles(&values);
        }
        let noisy = (0..).zip(&noise.relative).filter(|(_, sigma)| **sigma > 0.0);
        let of_vertex = |(v, _): (Index, &f64)| {
            let lines = values.get(v).iter().filter(|x| x.is_finite());
            let (least, count) = lines.fold((f64::INFINITY, 0), |(least, count), x| (x.min(least), count + 1));
            (count > 2).then(|| least.sqrt())
        };
        let found: Vec<f64> = noisy.filter_map(of_vertex).collect();
        (found.len() >= FEW).then(|| median(found))
    }

    /// Positions as what is lifted.
    fn position(&self, v: Index) -> DVec3 {
        self.surface.positions()[v as usize]
    }
}

/// Root mean square by which the noisy vertices are off the lines of edges through them, along the direction in which a place is
/// smoothest, over that of a sample of the noise: 1 or more unless the noise is less than `noise` says. `None` if there is no noise, or
/// there are too few lines.
pub(in crate::denoise) fn roughness(surface: &Surface, connectivity: &Connectivity, noise: &NoiseField) -> Option<f64> {
    let lines = Lines::of(surface, connectivity);
    let shown = lines.least(noise, &lines.squares(noise, |v| lines.position(v)))?;
    let sample = noise.sample(connectivity, 11);
    let lift = |v: Index| sample[v as usize] * lines.normals[v as usize];
    let expected = lines.least(noise, &lines.squares(noise, lift))?;
    (expected > 0.0).then(|| shown / expected)
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
