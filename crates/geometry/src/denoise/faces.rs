//! Triangles as the filters of face normals see them: who is near whom, and what each looks like.

use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
use crate::topology::{EdgeKind, Topology};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::borrow::Cow;

/// The triangles of a surface; polygons count as theirs.
pub(super) struct Faces {
    /// Three different vertices each.
    pub(super) triangles: Vec<[Index; 3]>,
    /// Triangles at each vertex, ascending.
    pub(super) around: Ragged<Index>,
    /// The two triangles at each edge that has two of the same orientation.
    pub(super) pairs: Vec<[Index; 2]>,
    /// Vertices of that edge, first and second as the first triangle walks along it.
    pub(super) pair_edges: Vec<[Index; 2]>,
}

/// Triangles that are treated at a time when lists are made on several threads.
const RUN: usize = 2048;

impl Faces {
    pub(super) fn of(surface: &Surface) -> Self {
        let count = surface.topology().vertex_count();
        let only_triangles = surface.topology().faces().iter().all(|face| face.len() == 3);
        let topology = if only_triangles {
            Cow::Borrowed(surface.topology())
        } else {
            // A polygon that touches itself may be cut into triangles that name a vertex twice.
            let sound = surface.triangles().filter(|[a, b, c]| a != b && b != c && c != a);
            Cow::Owned(Topology::new(count, sound.map(Vec::from).collect()))
        };
        let triangles: Vec<[Index; 3]> = topology.faces().iter().map(|t| [t[0], t[1], t[2]]).collect();
        let vertices = triangles.iter().zip(0..).flat_map(|(t, f)| t.map(|v| (v, f)));
        let around = Ragged::group(count, vertices);
        let interior = (0..topology.edges().len() as Index).filter(|&e| topology.edge_kind(e) == EdgeKind::Interior);
        let (pairs, pair_edges) = interior
            .map(|e| {
                let corners = topology.edge_corners().get(e);
                let [c, d] = [corners[0], corners[1]];
                ([topology.face(c), topology.face(d)], [topology.vertex(c), topology.vertex(d)])
            })
            .unzip();
        Self { triangles, around, pairs, pair_edges }
    }

    /// Number of triangles.
    pub(super) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Triangles that share an edge with each.
    pub(super) fn by_edge(&self) -> Ragged<Index> {
        Ragged::group(self.len(), self.pairs.iter().flat_map(|&[f, g]| [(f, g), (g, f)]))
    }

    /// Triangles that share a vertex with each, ascending; without itself.
    pub(super) fn by_vertex(&self) -> Ragged<Index> {
        lists(self.len(), |f, list| self.touching(f, list))
    }

    fn touching(&self, face: Index, list: &mut Vec<Index>) {
        let start = list.len();
        let near = self.triangles[face as usize].into_iter().flat_map(|v| self.around.get(v));
        list.extend(near.filter(|&&g| g != face));
        list[start..].sort_unstable();
        let mut kept = start;
        for k in start..list.len() {
            if kept == start || list[kept - 1] != list[k] {
                list[kept] = list[k];
                kept += 1;
            }
        }
        list.truncate(kept);
    }

    /// Triangles that hang together with each over shared vertices, with centroids no farther off than `radius`;
    /// without itself.
    pub(super) fn within(&self, radius: f64, centroids: &[DVec3]) -> Ragged<Index> {
        let neighbours = self.by_vertex();
        let close = |f: Index, g: Index| centroids[f as usize].distance(centroids[g as usize]) <= radius;
        lists(self.len(), |f, list| {
            grow(f, list, |g| neighbours.get(g), |g| close(f, g));
            list.swap_remove(0);
        })
    }

    /// Mean distance between the centroids of triangles that share an edge, model units; the root of the mean area
    /// where that is none.
    pub(super) fn spacing(&self, shapes: &Shapes) -> f64 {
        let distance = |&[f, g]: &[Index; 2]| shapes.centroids[f as usize].distance(shapes.centroids[g as usize]);
        let mean = self.pairs.iter().map(distance).sum::<f64>() / self.pairs.len() as f64;
        if mean > 0.0 {
            return mean;
        }
        let mean_area = shapes.areas.iter().sum::<f64>() / shapes.areas.len() as f64;
        if mean_area > 0.0 { mean_area.sqrt() } else { 1.0 }
    }

    /// Mean absolute angle between triangles that share an edge, radians; 0 without any.
    pub(super) fn mean_bend(&self, shapes: &Shapes) -> f64 {
        let angle = |&[f, g]: &[Index; 2]| {
            let [a, b] = [f, g].map(|f| shapes.normals[f as usize]);
            a.cross(b).length().atan2(a.dot(b))
        };
        self.pairs.iter().map(angle).sum::<f64>() / self.pairs.len().max(1) as f64
    }
}

/// A list for each of `count`, made on several threads.
pub(super) fn lists(count: usize, fill: impl Fn(Index, &mut Vec<Index>) + Sync) -> Ragged<Index> {
    let starts: Vec<usize> = (0..count).step_by(RUN).collect();
    let run = |&start: &usize| {
        let mut list = Vec::new();
        let mut out = Ragged::default();
        for f in start..(start + RUN).min(count) {
            list.clear();
            fill(f as Index, &mut list);
            out.push(list.iter().copied());
        }
        out
    };
    let runs: Vec<Ragged<Index>> = starts.par_iter().map(run).collect();
    let mut all = Ragged::default();
    runs.iter().for_each(|run| all.append(run));
    all
}

/// Fills `list` with `seed` and whatever is reached from it over neighbours that are `inside`; nearest rings first.
pub(super) fn grow<'a>(
    seed: Index,
    list: &mut Vec<Index>,
    neighbours: impl Fn(Index) -> &'a [Index],
    inside: impl Fn(Index) -> bool,
) {
    // Lists are short as a rule, and then looking through them is the fastest; the set is for the others.
    const SHORT: usize = 48;
    let mut seen = FxHashSet::default();
    list.push(seed);
    let mut next = 0;
    while next < list.len() {
        for &candidate in neighbours(list[next]) {
            if !inside(candidate) {
                continue;
            }
            if list.len() == SHORT && seen.is_empty() {
                seen.extend(list.iter().copied());
            }
            let fresh = if seen.is_empty() { !list.contains(&candidate) } else { seen.insert(candidate) };
            if fresh {
                list.push(candidate);
            }
        }
        next += 1;
    }
}

/// Normal, area and centroid of each triangle.
#[derive(Clone, Debug, Default)]
pub(super) struct Shapes {
    /// Unit, or zero for a triangle without area. #T×3
    pub(super) normals: Vec<DVec3>,
    /// Square model units. #T
    pub(super) areas: Vec<f64>,
    /// #T×3, model units.
    pub(super) centroids: Vec<DVec3>,
}

impl Shapes {
    pub(super) fn of(faces: &Faces, positions: &[DVec3]) -> Self {
        let count = faces.len();
        let mut shapes =
            Self { normals: vec![DVec3::ZERO; count], areas: vec![0.0; count], centroids: vec![DVec3::ZERO; count] };
        shapes.measure(faces, positions);
        shapes
    }

    /// Looks at the triangles again, without allocating.
    pub(super) fn measure(&mut self, faces: &Faces, positions: &[DVec3]) {
        let slots = self.normals.par_iter_mut().zip(&mut self.areas).zip(&mut self.centroids);
        slots.zip(&faces.triangles).with_min_len(RUN).for_each(|(((normal, area), centroid), t)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let doubled = (b - a).cross(c - a);
            *normal = doubled.normalize_or_zero();
            *area = doubled.length() / 2.0;
            *centroid = (a + b + c) / 3.0;
        });
    }
}

/// Replaces each normal by the weighted mean of its neighbours', as a unit vector; where that is zero it stays.
/// `weight` is told the face, the place in the list of all neighbours, and the neighbour.
pub(super) fn filter(
    neighbours: &Ragged<Index>,
    normals: &[DVec3],
    filtered: &mut [DVec3],
    weight: impl Fn(usize, usize, usize) -> f64 + Sync,
) {
    filtered.par_iter_mut().enumerate().with_min_len(RUN / 4).for_each(|(f, out)| {
        let places = neighbours.range(f as Index);
        let sum = places.fold(DVec3::ZERO, |sum, place| {
            let g = neighbours.items()[place] as usize;
            sum + normals[g] * weight(f, place, g)
        });
        *out = sum.try_normalize().unwrap_or(normals[f]);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    #[test]
    fn polygons_count_as_their_triangles() {
        let faces = Faces::of(&shapes::cube());
        // Two triangles a side; each edge of the cube and each diagonal has two.
        assert_eq!((faces.len(), faces.pairs.len()), (12, 18));
        assert!(faces.by_edge().iter().all(|near| near.len() == 3));
    }

    #[test]
    fn neighbourhoods_grow_with_the_radius_and_never_hold_the_face_itself() {
        let sphere = shapes::dented_sphere(3);
        let faces = Faces::of(&sphere);
        let shapes = Shapes::of(&faces, sphere.positions());
        let spacing = faces.spacing(&shapes);
        let [near, far] = [1.5, 6.0].map(|radius| faces.within(radius * spacing, &shapes.centroids));
        for f in 0..faces.len() as Index {
            assert!(!far.get(f).contains(&f) && near.get(f).iter().all(|g| far.get(f).contains(g)));
            let mut sorted = far.get(f).to_vec();
            sorted.sort_unstable();
            sorted.dedup();
            // The large ones are beyond the length up to which lists are looked through.
            assert!(sorted.len() == far.get(f).len() && sorted.len() > 48);
        }
    }
}
