//! Vertices that stand for "no data": depths and heights of −9999, say, that came along as positions.
//!
//! They lie tens of edges away from all that is around them. The cliffs to them are no part of the surface, so it is denoised
//! without their faces, and the vertices stay where they are.

use super::noise_level::median;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rayon::prelude::*;

/// Whether each vertex stands for "no data" (#V); `None` where none does.
pub(super) fn marks(surface: &Surface) -> Option<Vec<bool>> {
    if has_even_edges(surface) {
        return None;
    }
    let vertices = (0..surface.positions().len() as Index).into_par_iter();
    let shortest: Vec<Shortest> = vertices.clone().map(|v| Shortest::at(surface, v)).collect();
    let marks: Vec<bool> = vertices.map(|v| is_mark(surface, &shortest, v)).collect();
    marks.contains(&true).then_some(marks)
}

/// Least distance of a mark, edges. No surface that is sampled well, and no spike of a scanner, reaches so far.
const LEAST: f64 = 50.0;

/// Returns true if no edge is so much longer than another one that a vertex could be a mark, as in most meshes.
fn has_even_edges(surface: &Surface) -> bool {
    let (rings, positions) = (surface.topology().rings(), surface.positions());
    let vertices = (0..positions.len() as Index).into_par_iter();
    let squares = |v: Index| {
        let p = positions[v as usize];
        let lengths = rings.get(v).iter().map(|&n| p.distance_squared(positions[n as usize]));
        lengths.fold([f64::INFINITY, 0.0], |[low, high], x| [x.min(low), x.max(high)])
    };
    let joined = |[low, high]: [f64; 2], [l, h]: [f64; 2]| [f64::min(low, l), f64::max(high, h)];
    let [shortest, longest] = vertices.map(squares).reduce(|| [f64::INFINITY, 0.0], joined);
    // A vertex is at most two edges away from the middle of its two rings; a bit less for rounding.
    let ratio: f64 = 0.49 * LEAST;
    longest <= ratio * ratio * shortest
}

/// Shortest edges at a vertex, which are looked at once, because each of its neighbours asks for them.
struct Shortest {
    /// Other end of the shortest edge.
    end: Index,
    /// Lengths of the shortest edge and of the next one, model units; infinite if there is none.
    lengths: [f64; 2],
}

impl Shortest {
    fn at(surface: &Surface, v: Index) -> Self {
        let p = surface.positions()[v as usize];
        let mut found = Self { end: Index::MAX, lengths: [f64::INFINITY; 2] };
        for &w in surface.topology().rings().get(v) {
            let length = p.distance(surface.positions()[w as usize]);
            if length < found.lengths[0] {
                found = Self { end: w, lengths: [length, found.lengths[0]] };
            } else if length < found.lengths[1] {
                found.lengths[1] = length;
            }
        }
        found
    }

    /// Length of the shortest edge that does not end at `v`.
    fn beyond(&self, v: Index) -> f64 {
        self.lengths[usize::from(self.end == v)]
    }
}

/// True for a vertex that is far from the middle of its two rings, in lengths of the edges that do not end at it. Medians stand
/// that some of the others are marks, too.
fn is_mark(surface: &Surface, shortest: &[Shortest], v: Index) -> bool {
    /// Least number of vertices that a median can be taken of.
    const FEWEST: usize = 6;
    /// Most neighbours of a neighbour that are looked at; of more, some that stand in its ring at equal steps.
    const MOST: usize = 256;
    let rings = surface.topology().rings();
    let at = |v: Index| surface.positions()[v as usize];
    let ring = rings.get(v);
    let some = |w: Index| {
        let ring = rings.get(w);
        ring.iter().step_by(ring.len().div_ceil(MOST).max(1))
    };
    let lengths_beyond = |w: Index| some(w).filter(move |x| **x != v).map(move |&x| at(w).distance(at(x)));
    // Nearly all vertices are near a neighbour, and need no closer look.
    let typical = median(ring.iter().map(|&w| at(v).distance(at(w))).collect());
    let is_far_for = |w: &&Index| LEAST / 2.0 * shortest[**w as usize].beyond(v) < typical;
    if typical == 0.0 || 2 * ring.iter().filter(is_far_for).count() < ring.len() {
        return false;
    }
    let mut around: Vec<Index> = ring.iter().flat_map(|&w| some(w)).chain(ring).copied().collect();
    around.sort_unstable();
    around.dedup();
    around.retain(|&w| w != v);
    let edge = median(ring.iter().flat_map(|&w| lengths_beyond(w)).collect());
    let middle = DVec3::from_array([0, 1, 2].map(|axis| median(around.iter().map(|&w| at(w)[axis]).collect())));
    around.len() >= FEWEST && edge > 0.0 && at(v).distance(middle) > LEAST * edge
}

/// The surface without the faces at these vertices.
pub(super) fn without(surface: &Surface, marks: &[bool]) -> Surface {
    let topology = surface.topology();
    let mut faces = Ragged::default();
    for face in topology.faces().iter().filter(|face| face.iter().all(|&v| !marks[v as usize])) {
        faces.push(face.iter().copied());
    }
    Surface::new(Topology::new(topology.vertex_count(), faces), surface.positions().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::Denoiser;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};
    use crate::progress::Silent;

    #[test]
    fn vertices_without_data_stay_and_all_else_is_denoised_as_without_them() {
        let grid = shapes::grid(24);
        let noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 3 };
        let noisy = synthetic_noise::noisy(&grid, &noise);
        let lost = [100, 101, 330];
        let mut positions = noisy.positions().to_vec();
        lost.iter().for_each(|&v: &usize| positions[v].z = -9999.0);
        let holed = noisy.at(positions);
        let found = marks(&holed).unwrap();
        let all: Vec<usize> = (0..found.len()).filter(|&v| found[v]).collect();
        assert_eq!(all, lost);
        for denoiser in Denoiser::every() {
            let deltas = denoiser.deltas(&holed, &Silent).unwrap();
            assert!(lost.iter().all(|&v| deltas[v] == DVec3::ZERO), "{denoiser:?}");
            assert!(deltas.iter().all(|delta| delta.length() < 0.1), "{denoiser:?}");
        }
    }

    #[test]
    fn a_cone_a_spike_and_the_middle_of_a_fan_are_data() {
        let grid = shapes::grid(12);
        let spike = |height: f64| {
            let lift = |p: &DVec3| {
                let r = p.distance(DVec3::new(0.5, 0.5, 0.0));
                *p + DVec3::Z * if r < 0.01 { height } else { 0.0 }
            };
            grid.at(grid.positions().iter().map(lift).collect())
        };
        assert!(marks(&grid).is_none() && marks(&spike(2.0)).is_none() && marks(&spike(9.0)).is_some());
        let rim =
            (0..400).map(|k| f64::from(k) * std::f64::consts::TAU / 400.0).map(|a| DVec3::new(a.cos(), a.sin(), 0.0));
        let positions: Vec<DVec3> = rim.chain([DVec3::ZERO]).collect();
        let mut faces = Ragged::default();
        (0..400).for_each(|k| {
            faces.push([k, (k + 1) % 400, 400]);
        });
        assert!(marks(&Surface::new(Topology::new(401, faces), positions)).is_none());
    }

    #[test]
    fn neighbours_of_a_crowded_vertex_do_not_look_at_all_its_edges() {
        // With a look at each edge of the middle from each vertex of the rim, or at each page from each page, this would not end.
        let crowd = |count: u32, faces: Ragged<Index>| {
            let rim = (0..count).map(|k| f64::from(k) * std::f64::consts::TAU / f64::from(count));
            let rim = rim.map(|a| DVec3::new(a.cos(), a.sin(), 0.0));
            let positions: Vec<_> = [DVec3::ZERO, DVec3::Z * 1e-3].into_iter().chain(rim).collect();
            Surface::new(Topology::new(positions.len(), faces), positions)
        };
        let fan = (0..200_000).map(|k| vec![0, 2 + k, 2 + (k + 1) % 200_000]).collect();
        assert!(marks(&crowd(200_000, fan)).is_none());
        let pages = (0..10_000).map(|k| vec![0, 1, 2 + k]).collect();
        assert!(marks(&crowd(10_000, pages)).is_none());
    }

    #[test]
    fn the_shortest_edge_beyond_a_vertex_is_that_of_a_search_through_all() {
        let surface = shapes::dented_sphere(2);
        let (rings, points) = (surface.topology().rings(), surface.positions());
        for v in 0..points.len() as Index {
            let shortest = Shortest::at(&surface, v);
            for &w in rings.get(v) {
                let others = rings.get(v).iter().filter(|x| **x != w);
                let lengths = others.map(|&x| points[v as usize].distance(points[x as usize]));
                assert_eq!(shortest.beyond(w), lengths.fold(f64::INFINITY, f64::min));
            }
        }
    }
}
