//! How far the bands of a region have structure that noise lacks: lines, and places where much goes on beside places where little does.
//!
//! Noise is alike in all directions, and how large it is at a vertex says nothing of the vertices beside. The relief of a surface has ridges
//! and grooves, and flat ground between them. All figures are those of the mesh less those of white noise on it, because a mesh by its
//! triangles alone has directions and clusters as well.

use super::{Bands, quantile, sorted};
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Bands that are looked at: the finest one, and one of about two edges.
const LOOKED_AT: [usize; 2] = [0, 2];
/// Number of figures of a band.
const FIGURES: usize = 3;
/// Number of all figures of a region.
pub(super) const COUNT: usize = LOOKED_AT.len() * FIGURES;
/// Number of neighbours of a vertex that are looked at: a hub says no more than other vertices, and may have half the mesh around it.
const MOST_NEIGHBOURS: usize = 24;
/// Number of samples of white noise that the bands have.
const SAMPLES: usize = 3;

/// What is measured at each vertex.
pub(super) struct Structure {
    /// Coherence of each band beyond that of white noise. #V each
    coherence: [Vec<f64>; LOOKED_AT.len()],
}

impl Structure {
    /// Measures the bands of a mesh whose vertices, smoothed, are at `positions` and have these normals.
    pub(super) fn of(surface: &Surface, bands: &Bands, positions: &[DVec3], normals: &[DVec3]) -> Self {
        let near = |v: Index| surface.topology().rings().get(v).iter().take(MOST_NEIGHBOURS).copied();
        let coherence = |k: usize| -> Vec<f64> {
            let (of_mesh, white) = (&bands.normal[k], &bands.white[k]);
            let at = |v: usize| -> f64 {
                let (x, y) = normals[v].any_orthonormal_pair();
                let mut of_values = [Tensor::default(); 1 + SAMPLES];
                for a in std::iter::once(v as Index).chain(near(v as Index)) {
                    for b in near(a) {
                        let (a, b) = (a as usize, b as usize);
                        let along = positions[b] - positions[a];
                        let direction = DVec2::new(along.dot(x), along.dot(y)).normalize_or_zero();
                        let [own, others @ ..] = &mut of_values;
                        own.add(of_mesh[b] - of_mesh[a], direction);
                        let step = (white[b] - white[a]).to_array();
                        others.iter_mut().zip(step).for_each(|(of, step)| of.add(step, direction));
                    }
                }
                let [own, others @ ..] = of_values.map(Tensor::coherence);
                own - others.iter().sum::<f64>() / SAMPLES as f64
            };
            (0..of_mesh.len()).into_par_iter().with_min_len(256).map(at).collect()
        };
        Self { coherence: LOOKED_AT.map(coherence) }
    }

    /// Figures of a region, of which these are the regular vertices: for each band the coherence, how alike it is at vertices that are two
    /// edges apart, and how alike its absolute values are there.
    pub(super) fn of_region(&self, surface: &Surface, bands: &Bands, regular: &[usize]) -> [f64; COUNT] {
        let pairs = pairs_two_apart(surface, regular);
        let mut out = [0.0; COUNT];
        for ((k, coherence), out) in LOOKED_AT.into_iter().zip(&self.coherence).zip(out.chunks_exact_mut(FIGURES)) {
            let mean = regular.iter().map(|&v| coherence[v]).sum::<f64>() / regular.len() as f64;
            let own = alike(regular, &pairs, |v| bands.normal[k][v]);
            let white: [_; SAMPLES] = std::array::from_fn(|s| alike(regular, &pairs, |v| bands.white[k][v][s]));
            out[0] = mean;
            for (figure, (out, own)) in out[1..].iter_mut().zip(own).enumerate() {
                *out = own - white.iter().map(|of| of[figure]).sum::<f64>() / SAMPLES as f64;
            }
        }
        out
    }
}

/// Sum of the squares of steps, and of the squares times their directions as double angles.
#[derive(Clone, Copy, Default)]
struct Tensor {
    sum: f64,
    double_angle: DVec2,
}

impl Tensor {
    fn add(&mut self, step: f64, direction: DVec2) {
        let square = step * step;
        self.sum += square;
        self.double_angle += square * direction.rotate(direction);
    }

    /// 0 where steps are alike in all directions, 1 where all are in one.
    fn coherence(self) -> f64 {
        if self.sum > 0.0 { self.double_angle.length() / self.sum } else { 0.0 }
    }
}

/// Pairs of vertices that are two edges apart, of which the first is in the list.
fn pairs_two_apart(surface: &Surface, vertices: &[usize]) -> Vec<[Index; 2]> {
    let rings = surface.topology().rings();
    let mut pairs = Vec::new();
    for v in vertices.iter().map(|&v| v as Index) {
        let near = rings.get(v);
        if near.len() > MOST_NEIGHBOURS {
            continue;
        }
        let far = near.iter().flat_map(|&w| rings.get(w).iter().take(MOST_NEIGHBOURS).copied());
        let mut far: Vec<Index> = far.collect();
        far.sort_unstable();
        far.dedup();
        pairs.extend(far.into_iter().filter(|w| *w != v && !near.contains(w)).map(|w| [v, w]));
    }
    pairs
}

/// Correlation of values between the two ends of pairs, and that of their absolute values; large ones count as three deviations.
fn alike(vertices: &[usize], pairs: &[[Index; 2]], value: impl Fn(usize) -> f64) -> [f64; 2] {
    /// Deviation of a Gaussian over the median of its absolute values.
    const DEVIATION: f64 = 1.4826;
    let typical = DEVIATION * quantile(&sorted(vertices.iter().map(|&v| value(v).abs())), 0.5);
    if typical <= 0.0 {
        return [0.0; 2];
    }
    let clipped = |v: usize| (value(v) / typical).clamp(-3.0, 3.0);
    let mean = vertices.iter().map(|&v| clipped(v).abs()).sum::<f64>() / vertices.len() as f64;
    let size = |v: usize| clipped(v).abs() - mean;
    let mut sums = [[0.0; 2]; 2];
    for [v, w] in pairs.iter().map(|pair| pair.map(|v| v as usize)) {
        for (sums, [a, b]) in sums.iter_mut().zip([[clipped(v), clipped(w)], [size(v), size(w)]]) {
            sums[0] += a * b;
            sums[1] += 0.5 * (a * a + b * b);
        }
    }
    sums.map(|[products, squares]| if squares > 0.0 { products / squares } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::noise_field::statistics::{COUNT as ALL, STRUCTURE, Statistics};
    use crate::denoise::noise_field::verdict;
    use crate::denoise::tests::{displaced, white_noise};
    use crate::mesh::shapes;
    use crate::progress::Silent;

    /// Figures of the finest band, the mean over all regions: coherence, likeness two edges apart, and that of the absolute values.
    fn figures(surface: &Surface) -> [f64; FIGURES] {
        let connectivity = crate::denoise::connectivity::Connectivity::of(surface);
        let statistics = Statistics::of(surface, &connectivity, &Silent).unwrap();
        let regions = statistics.of_regions(&verdict::partition(surface.topology(), 0));
        let all: Vec<[f64; ALL]> = regions.into_iter().flatten().collect();
        assert!(all.len() > 5);
        std::array::from_fn(|k| all.iter().map(|of| of[STRUCTURE + k]).sum::<f64>() / all.len() as f64)
    }

    /// A flat grid with heights at places, both in lengths of an edge, and a little noise.
    fn with_heights(height: impl Fn(DVec2) -> f64) -> Surface {
        const CELLS: u32 = 60;
        let grid = shapes::grid(CELLS);
        let cells = f64::from(CELLS);
        let raised = |p: &DVec3| *p + height(p.truncate() * cells) / cells * DVec3::Z;
        let raised = grid.at(grid.positions().iter().map(raised).collect());
        displaced(&raised, &white_noise(&raised, 0.01, 4))
    }

    #[test]
    fn white_noise_has_no_structure_on_any_triangles() {
        for clean in [shapes::grid(60), shapes::sphere(4)] {
            let found = figures(&displaced(&clean, &white_noise(&clean, 0.1, 4)));
            assert!(found.iter().all(|figure| figure.abs() < 0.05), "{found:?}");
        }
    }

    #[test]
    fn pleats_go_in_one_direction() {
        let pleats = figures(&with_heights(|p| if (p.x + p.y).rem_euclid(4.0) < 2.0 { 0.0 } else { 0.3 }));
        assert!(pleats[0] > 0.1, "{pleats:?}");
    }

    #[test]
    fn studs_stand_in_clusters_on_flat_ground() {
        let studs = figures(&with_heights(|p| {
            let [x, y] = [p.x, p.y].map(|t| t.rem_euclid(12.0) - 6.0);
            0.5 * f64::from(u8::from(x * x + y * y < 9.0))
        }));
        assert!(studs[2] > 0.1, "{studs:?}");
    }
}
