//! Triangles of a surface and who is next to whom, as filters of face normals need it.

use super::near::{self, Found, NearLists, Room};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::{EdgeKind, Topology};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BinaryHeap;

/// Connectivity of the triangles of a surface; polygons are cut into triangles.
///
/// Neighbours over an edge are those over interior edges alone: edges with exactly two triangles of the same orientation.
pub(super) struct TriangleMesh {
    /// Vertices of each triangle, which are three different ones. #T×3
    pub(super) triangles: Vec<[Index; 3]>,
    /// Triangles at each vertex, ascending. #V lists
    pub(super) vertex_faces: Ragged<Index>,
    /// The two triangles at each interior edge. #E×2
    pub(super) edge_faces: Vec<[Index; 2]>,
    /// The two vertices of each interior edge, in the direction of its first triangle. #E×2
    pub(super) edge_vertices: Vec<[Index; 2]>,
}

/// Number of faces that a thread treats at a time when it builds lists.
const CHUNK: usize = 2048;

impl TriangleMesh {
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
        let vertex_faces = Ragged::group(count, vertices);
        let interior = (0..topology.edges().len() as Index).filter(|&e| topology.edge_kind(e) == EdgeKind::Interior);
        let (edge_faces, edge_vertices) = interior
            .map(|e| {
                let corners = topology.edge_corners().get(e);
                let [c, d] = [corners[0], corners[1]];
                ([topology.face(c), topology.face(d)], [topology.vertex(c), topology.vertex(d)])
            })
            .unzip();
        Self { triangles, vertex_faces, edge_faces, edge_vertices }
    }

    /// Number of triangles.
    pub(super) fn face_count(&self) -> usize {
        self.triangles.len()
    }

    /// Triangles that share an interior edge with each triangle. #T lists
    pub(super) fn edge_neighbours(&self) -> Ragged<Index> {
        Ragged::group(self.face_count(), self.edge_faces.iter().flat_map(|&[f, g]| [(f, g), (g, f)]))
    }

    /// Triangles that share a vertex with each triangle, ascending and without the triangle itself. Of a vertex with more than
    /// [`near::MOST_IN_LIST`] triangles a triangle has those alone whose `centroids` (#T×3) are nearest to its own. #T lists
    pub(super) fn vertex_neighbours(&self, centroids: &[DVec3]) -> Ragged<Index> {
        let near = NearLists::new(&self.vertex_faces, centroids);
        build_lists_with(self.face_count(), BinaryHeap::new, |heap: &mut BinaryHeap<Found>, f, list| {
            for v in self.triangles[f as usize] {
                near.visit(v, centroids[f as usize], heap, |g| list.extend((g != f).then_some(g)));
            }
            list.sort_unstable();
            list.dedup();
        })
    }

    /// Triangles whose `centroids` (#T×3) are within `radius` of that of each triangle and that are connected to it by such
    /// triangles, over shared vertices; without the triangle itself. If there are more than `most`, the nearest ones. #T lists
    pub(super) fn neighbours_within(&self, radius: f64, most: usize, centroids: &[DVec3]) -> Ragged<Index> {
        let neighbours = self.vertex_neighbours(centroids);
        let near = NearLists::new(&self.vertex_faces, centroids);
        let close = |f: Index, g: Index| centroids[f as usize].distance(centroids[g as usize]) <= radius;
        build_lists_with(self.face_count(), Room::default, |room, f, list| {
            // The triangle itself comes on top.
            let most = most + 1;
            if near::flood_fill(f, list, most, |g| neighbours.get(g), |g| close(f, g)) {
                list.swap_remove(0);
            } else {
                let vertices = |g: Index| self.triangles[g as usize];
                near::fill_nearest(f, list, most, &near, vertices, |g| close(f, g), room);
                list.remove(0);
            }
        })
    }
}

/// Builds `count` lists on several threads; `fill` appends the items of list i to an empty vector.
pub(super) fn build_lists(count: usize, fill: impl Fn(Index, &mut Vec<Index>) + Sync) -> Ragged<Index> {
    build_lists_with(count, || (), |(), i, list| fill(i, list))
}

/// Builds lists as [`build_lists`] does, with scratch memory that `room` makes for each thread's work.
fn build_lists_with<R>(
    count: usize,
    room: impl Fn() -> R + Sync,
    fill: impl Fn(&mut R, Index, &mut Vec<Index>) + Sync,
) -> Ragged<Index> {
    let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
    let chunk = |&start: &usize| {
        let (mut room, mut list) = (room(), Vec::new());
        let mut out = Ragged::default();
        for f in start..(start + CHUNK).min(count) {
            list.clear();
            fill(&mut room, f as Index, &mut list);
            out.push(list.iter().copied());
        }
        out
    };
    let chunks: Vec<Ragged<Index>> = starts.par_iter().map(chunk).collect();
    let mut all = Ragged::default();
    chunks.iter().for_each(|chunk| all.append(chunk));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::face_geometry::FaceGeometry;
    use crate::mesh::shapes;
    use glam::DVec2;

    #[test]
    fn polygons_count_as_their_triangles() {
        let mesh = TriangleMesh::of(&shapes::cube());
        // Two triangles a side; each edge of the cube and each diagonal has two.
        assert_eq!((mesh.face_count(), mesh.edge_faces.len()), (12, 18));
        assert!(mesh.edge_neighbours().iter().all(|near| near.len() == 3));
    }

    #[test]
    fn neighbourhoods_grow_with_the_radius_and_never_hold_the_face_itself() {
        let sphere = shapes::dented_sphere(3);
        let mesh = TriangleMesh::of(&sphere);
        let geometry = FaceGeometry::of(&mesh, sphere.positions());
        let unit = geometry.mean_centroid_distance(&mesh);
        let [near, far] = [1.5, 6.0].map(|radius| mesh.neighbours_within(radius * unit, 1000, &geometry.centroids));
        for f in 0..mesh.face_count() as Index {
            assert!(!far.get(f).contains(&f) && near.get(f).iter().all(|g| far.get(f).contains(g)));
            let mut sorted = far.get(f).to_vec();
            sorted.sort_unstable();
            sorted.dedup();
            // Large neighbourhoods are longer than the lists that are searched linearly.
            assert!(sorted.len() == far.get(f).len() && sorted.len() > 48);
        }
    }

    /// Triangles between an edge, or a vertex, and points on a circle around it.
    fn crowd(count: u32, at_edge: bool) -> Surface {
        let rim = |k: u32| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / f64::from(count)).extend(0.5);
        let positions = [DVec3::ZERO, DVec3::Z].into_iter().chain((0..count).map(rim)).collect();
        let face = |k: u32| if at_edge { vec![0, 1, 2 + k] } else { vec![0, 2 + k, 2 + (k + 1) % count] };
        Surface::new(Topology::new(count as usize + 2, (0..count).map(face).collect()), positions)
    }

    #[test]
    fn triangles_of_a_crowded_vertex_or_edge_have_the_nearest_ones_as_neighbours() {
        let count = 20_000;
        for at_edge in [false, true] {
            let surface = crowd(count, at_edge);
            let mesh = TriangleMesh::of(&surface);
            let centroids = FaceGeometry::of(&mesh, surface.positions()).centroids;
            // All of them would be 400 million.
            for (f, list) in (0..).zip(mesh.vertex_neighbours(&centroids).iter()) {
                assert!((near::MOST_IN_LIST - 1..near::MOST_IN_LIST + 2).contains(&list.len()), "{}", list.len());
                // A triangle has as many neighbours on one side as on the other, up to the choice between equally near ones.
                for step in 1..near::MOST_IN_LIST as Index / 2 - 1 {
                    let [before, after] = [count - step, step].map(|step| (f + step) % count);
                    assert!(list.contains(&before) && list.contains(&after), "{at_edge} {f} {step}");
                }
            }
            let most = 20;
            for (f, list) in (0..).zip(mesh.neighbours_within(0.1, most, &centroids).iter()) {
                assert!(list.len() == most && !list.contains(&f), "{f} {list:?}");
                assert!(list.iter().all(|g| (g + count - f + 11) % count < 23), "{f} {list:?}");
            }
        }
    }

    #[test]
    fn of_more_triangles_within_a_radius_than_are_wanted_the_nearest_ones_are_taken() {
        // A strip of slivers, with hundreds of triangles nearer than those of a quad are to each other.
        let quads = 2000;
        let point = |k: u32| DVec3::new(f64::from(k / 2) * 1e-3, f64::from(k % 2), 1e-4 * f64::from(k * k % 7));
        let faces = (0..quads).map(|k| 2 * k).flat_map(|k| [vec![k, k + 2, k + 3], vec![k, k + 3, k + 1]]);
        let topology = Topology::new(2 * quads as usize + 2, faces.collect());
        let surface = Surface::new(topology, (0..2 * quads + 2).map(point).collect());
        let mesh = TriangleMesh::of(&surface);
        let centroids = FaceGeometry::of(&mesh, surface.positions()).centroids;
        let (radius, most) = (0.6, 100);
        let lists = mesh.neighbours_within(radius, most, &centroids);
        for f in (0..mesh.face_count() as Index).step_by(97) {
            let distance = |g: &Index| centroids[*g as usize].distance_squared(centroids[f as usize]);
            let mut all: Vec<Index> = (0..mesh.face_count() as Index).filter(|g| *g != f).collect();
            all.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            let distances = |list: &[Index]| list.iter().map(distance).collect::<Vec<_>>();
            assert_eq!(distances(lists.get(f)), distances(&all[..most]), "{f}");
            assert!(distance(&all[most]) < radius * radius);
        }
    }
}
