//! How far the bands of a region have structure that noise lacks: lines, and places where much goes on beside places where little does.
//!
//! Noise is alike in all directions, and how large it is at a vertex says nothing of the vertices beside. The relief of a surface has ridges
//! and grooves, and flat ground between them. All figures are those of the mesh less those of white noise on it, because a mesh by its
//! triangles alone has directions and clusters as well. What a region shows along its smoothest lines, and where it is calmest, bounds
//! the noise from above.

use super::{Bands, LEAST, log, quantile, sorted};
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::denoise::noise_field::lines::AlongLines;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Bands that are looked at: the finest one, and one of about two edges.
const LOOKED_AT: [usize; 2] = [0, 2];
/// Number of figures of a band.
const FIGURES: usize = 4;
/// Number of all figures of a region: those of the bands and three along lines.
pub(super) const COUNT: usize = LOOKED_AT.len() * FIGURES + 3;
/// Number of neighbours of a vertex that are looked at: a hub says no more than other vertices, and may have half the mesh around it.
const MOST_NEIGHBOURS: usize = 24;
/// Number of samples of white noise that the bands have.
const SAMPLES: usize = 3;

/// What is measured at each vertex.
pub(super) struct Structure {
    /// Coherence of each band beyond that of white noise. #V each
    coherence: [Vec<f64>; LOOKED_AT.len()],
    /// Mean squares of each band around each vertex, and those of the samples of white noise. #V each
    around: [Vec<[f64; 1 + SAMPLES]>; LOOKED_AT.len()],
    /// Roughness along lines, in local edges, and that of white noise with a deviation of one edge.
    along_lines: AlongLines,
}

impl Structure {
    /// Measures a mesh whose vertices, smoothed, are at `positions` and have these normals and lengths of local edges.
    pub(super) fn of(
        surface: &Surface,
        connectivity: &Connectivity,
        bands: &Bands,
        positions: &[DVec3],
        normals: &[DVec3],
        local_edge: &[f64],
    ) -> Self {
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
        let around = |k: usize| {
            let squares = |v: usize| {
                let [x, y, z] = bands.white[k][v].to_array();
                [bands.normal[k][v] / local_edge[v].max(f64::MIN_POSITIVE), x, y, z].map(|x| x * x)
            };
            let mut now: Vec<[f64; 1 + SAMPLES]> = (0..normals.len()).map(squares).collect();
            for _ in 0..2 {
                let mean = |v: usize| {
                    let mut sum = now[v];
                    let mut count = 1.0;
                    for w in near(v as Index) {
                        sum.iter_mut().zip(now[w as usize]).for_each(|(sum, x)| *sum += x);
                        count += 1.0;
                    }
                    sum.map(|sum| sum / count)
                };
                now = (0..now.len()).into_par_iter().with_min_len(256).map(mean).collect();
            }
            now
        };
        let unit = NoiseField { edge: local_edge.to_vec(), ..NoiseField::uniform(normals.len(), 1.0, 1.0, 0.0) };
        let along_lines = AlongLines::of(surface, connectivity, &unit);
        Self { coherence: LOOKED_AT.map(coherence), around: LOOKED_AT.map(around), along_lines }
    }

    /// Figures of a region, of which these are the regular vertices and `fine` the logarithm of what the finest band makes of its
    /// deviation: for each band the coherence, how alike it is at vertices that are two edges apart, how alike its absolute values are
    /// there, and how calm the calmest tenth is; then the correlation along the smoothest lines, the logarithm of the deviation along
    /// them, and that less `fine`.
    pub(super) fn of_region(&self, surface: &Surface, bands: &Bands, regular: &[usize], fine: f64) -> [f64; COUNT] {
        let pairs = pairs_two_apart(surface, regular);
        let mut out = [0.0; COUNT];
        let of_bands = LOOKED_AT.into_iter().zip(&self.coherence).zip(&self.around);
        for (((k, coherence), around), out) in of_bands.zip(out.chunks_exact_mut(FIGURES)) {
            let mean = regular.iter().map(|&v| coherence[v]).sum::<f64>() / regular.len() as f64;
            let own = alike(regular, &pairs, |v| bands.normal[k][v]);
            let white: [_; SAMPLES] = std::array::from_fn(|s| alike(regular, &pairs, |v| bands.white[k][v][s]));
            out[0] = mean;
            for (figure, (out, own)) in out[1..].iter_mut().zip(own).enumerate() {
                *out = own - white.iter().map(|of| of[figure]).sum::<f64>() / SAMPLES as f64;
            }
            let [own, others @ ..]: [f64; 1 + SAMPLES] = std::array::from_fn(|sample| {
                let squares = sorted(regular.iter().map(|&v| around[v][sample]));
                0.5 * (log(quantile(&squares, 0.1)) - log(quantile(&squares, 0.5)))
            });
            out[3] = own - others.iter().sum::<f64>() / SAMPLES as f64;
        }
        let along = self.along_lines.ratio(regular.iter().copied(), LEAST).map_or(fine, log);
        out[COUNT - 3] = self.along_lines.correlation(regular.iter().copied(), LEAST).unwrap_or(0.0);
        out[COUNT - 2] = along;
        out[COUNT - 1] = along - fine;
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

    /// Figures of structure, the mean over all regions.
    fn figures(surface: &Surface) -> [f64; COUNT] {
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
            assert!((found[COUNT - 2].exp() / 0.1 - 1.0).abs() < 0.2, "{found:?}");
            assert!(found[..FIGURES].iter().chain(&found[COUNT - 1..]).all(|x| x.abs() < 0.05), "{found:?}");
            // The sphere bends along all lines.
            assert!(found[COUNT - 3] > -0.05 && found[COUNT - 3] < 0.3, "{found:?}");
        }
    }

    #[test]
    fn pleats_go_in_one_direction() {
        let pleats = figures(&with_heights(|p| if (p.x + p.y).rem_euclid(4.0) < 2.0 { 0.0 } else { 0.3 }));
        assert!(pleats[0] > 0.1, "{pleats:?}");
    }

    #[test]
    fn pleats_along_edges_show_the_noise_alone_there() {
        let pleats = figures(&with_heights(|p| if (p.x - p.y).rem_euclid(4.0) < 2.0 { 0.0 } else { 0.3 }));
        // The noise is a hundredth of an edge.
        assert!(pleats[COUNT - 2] < 0.03f64.ln() && pleats[COUNT - 1] < 0.3f64.ln(), "{pleats:?}");
    }

    #[test]
    fn a_smooth_surface_is_smooth_along_lines() {
        let dome = figures(&with_heights(|p| -0.05 * (p - 30.0).length_squared()));
        let waves = figures(&with_heights(|p| 5.0 * (0.2 * p.x).sin()));
        assert!(dome[COUNT - 3] > 0.5, "{dome:?}");
        // Between the waves there is nothing but the noise.
        assert!(waves[COUNT - 3].abs() < 0.1, "{waves:?}");
    }

    #[test]
    fn studs_stand_in_clusters_on_flat_ground() {
        let studs = figures(&with_heights(|p| {
            let [x, y] = [p.x, p.y].map(|t| t.rem_euclid(12.0) - 6.0);
            0.5 * f64::from(u8::from(x * x + y * y < 9.0))
        }));
        assert!(studs[2] > 0.1 && studs[3] < -0.5, "{studs:?}");
    }
}
