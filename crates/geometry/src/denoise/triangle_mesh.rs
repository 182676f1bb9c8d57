//! Triangles of a surface and who is next to whom, as filters of face normals need it.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::{EdgeKind, Topology};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::borrow::Cow;

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

    /// Triangles that share a vertex with each triangle, ascending and without the triangle itself. #T lists
    pub(super) fn vertex_neighbours(&self) -> Ragged<Index> {
        build_lists(self.face_count(), |f, list| self.append_vertex_neighbours(f, list))
    }

    fn append_vertex_neighbours(&self, face: Index, list: &mut Vec<Index>) {
        let start = list.len();
        let near = self.triangles[face as usize].into_iter().flat_map(|v| self.vertex_faces.get(v));
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

    /// Triangles whose `centroids` (#T×3) are within `radius` of that of each triangle and that are connected to it by such
    /// triangles, over shared vertices; without the triangle itself. #T lists
    pub(super) fn neighbours_within(&self, radius: f64, centroids: &[DVec3]) -> Ragged<Index> {
        let neighbours = self.vertex_neighbours();
        let close = |f: Index, g: Index| centroids[f as usize].distance(centroids[g as usize]) <= radius;
        build_lists(self.face_count(), |f, list| {
            flood_fill(f, list, |g| neighbours.get(g), |g| close(f, g));
            list.swap_remove(0);
        })
    }
}

/// Builds `count` lists on several threads; `fill` appends the items of list i to an empty vector.
pub(super) fn build_lists(count: usize, fill: impl Fn(Index, &mut Vec<Index>) + Sync) -> Ragged<Index> {
    let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
    let chunk = |&start: &usize| {
        let mut list = Vec::new();
        let mut out = Ragged::default();
        for f in start..(start + CHUNK).min(count) {
            list.clear();
            fill(f as Index, &mut list);
            out.push(list.iter().copied());
        }
        out
    };
    let chunks: Vec<Ragged<Index>> = starts.par_iter().map(chunk).collect();
    let mut all = Ragged::default();
    chunks.iter().for_each(|chunk| all.append(chunk));
    all
}

/// Appends to an empty `list` the `seed` and whatever is reached from it over neighbours that are `inside`, breadth first.
pub(super) fn flood_fill<'a>(
    seed: Index,
    list: &mut Vec<Index>,
    neighbours: impl Fn(Index) -> &'a [Index],
    inside: impl Fn(Index) -> bool,
) {
    // Short lists are the rule, and for them a linear search is the fastest; the set is for the others.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::face_geometry::FaceGeometry;
    use crate::mesh::shapes;

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
        let [near, far] = [1.5, 6.0].map(|radius| mesh.neighbours_within(radius * unit, &geometry.centroids));
        for f in 0..mesh.face_count() as Index {
            assert!(!far.get(f).contains(&f) && near.get(f).iter().all(|g| far.get(f).contains(g)));
            let mut sorted = far.get(f).to_vec();
            sorted.sort_unstable();
            sorted.dedup();
            // Large neighbourhoods are longer than the lists that are searched linearly.
            assert!(sorted.len() == far.get(f).len() && sorted.len() > 48);
        }
    }
}
