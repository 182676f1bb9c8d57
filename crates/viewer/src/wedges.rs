//! The mesh as both renderers draw it: one entry for each place where a vertex, a normal, a texture coordinate and a
//! tangent frame meet, and three of them for each triangle.

use crate::gpu_types::{Surfel, Wedge};
use crate::scene::{Mesh, Scene, Triangle};
use glam::{Vec2, Vec3, Vec4};
use planish_geometry::apply::ShaderVertex;
use planish_geometry::displacement::{MapKind, Place};
use planish_geometry::texture::tangents::Tangent;

/// A vertex does not sample the map.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// A wedge has no texture coordinates: its stretch.
const NO_UVS: Vec2 = Vec2::NEG_ONE;

/// Arrays of the same length #W, and triangles over them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wedges {
    /// For displacing.
    pub(crate) wedges: Vec<Wedge>,
    /// That the mesh is lit with as it is, unit. (The fourth number only keeps the alignment of a GPU's array.)
    pub(crate) normals: Vec<Vec4>,
    /// For shading.
    pub(crate) surfels: Vec<Surfel>,
    /// Wedges of each triangle, in the mesh's order. #T
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Number of vertices of the surface, those without wedges included.
    pub(crate) vertices: usize,
}

/// What tells wedges of one vertex apart.
#[derive(Clone, Copy, PartialEq)]
struct Key {
    normal: u32,
    uv: u32,
    tangent: Tangent,
}

impl Wedges {
    /// Splits the scene's mesh.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mesh = scene.mesh();
        let mut split = Splitter::new(scene);
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let tangents = mesh.tangents.as_ref().map_or([Tangent::default(); 3], |tangents| tangents[t]);
            let corner = |k: usize| {
                let uv = triangle.uvs.map_or(u32::MAX, |uvs| uvs[k]);
                let key = Key { normal: triangle.normals[k], uv, tangent: tangents[k] };
                split.wedge(triangle.positions[k], key)
            };
            let corners = std::array::from_fn(corner);
            split.out.triangles.push(corners);
        }
        let mut out = split.out;
        out.stretch(mesh);
        out
    }

    /// Replaces the numbers of the vertices (#V); what is not a finite number is none.
    pub(crate) fn set_scalars(&mut self, scalars: Option<&[f32]>) {
        for (surfel, wedge) in self.surfels.iter_mut().zip(&self.wedges) {
            let scalar = scalars.map(|s| s[wedge.vertex as usize]).filter(|x| x.is_finite());
            surfel.scalar = scalar.map_or(Vec2::ZERO, |x| Vec2::new(x, 1.0));
        }
    }

    /// For each triangle, bit k is set if the texture is cut along the edge opposite to corner k: the triangle beyond names
    /// other texture coordinates there. #T
    pub(crate) fn cuts(&self) -> Vec<u32> {
        let end = |w: u32| {
            let wedge = &self.wedges[w as usize];
            (wedge.vertex, wedge.uv.to_array().map(f32::to_bits))
        };
        let edges = |t: usize| {
            let [a, b, c] = self.triangles[t];
            [[b, c], [c, a], [a, b]]
        };
        // Sorted by the vertices at its ends, all sides of an edge lie next to each other.
        let mut sides: Vec<([u32; 2], u32, u32)> = (0..self.triangles.len())
            .flat_map(|t| (0u32..).zip(edges(t)).map(move |(k, edge)| (t, k, edge)))
            .map(|(t, k, [p, q])| {
                let (p, q) = (end(p).0, end(q).0);
                ([p.min(q), p.max(q)], t as u32, k)
            })
            .collect();
        sides.sort_unstable();
        let mut cuts = vec![0; self.triangles.len()];
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            let ends = |&(_, t, k): &([u32; 2], u32, u32)| {
                let mut ends = edges(t as usize)[k as usize].map(end);
                ends.sort_unstable();
                ends
            };
            if same.iter().any(|side| ends(side) != ends(&same[0])) {
                for &(_, t, k) in same {
                    cuts[t as usize] |= 1 << k;
                }
            }
        }
        cuts
    }

    /// Lengths of ∂p/∂u and ∂p/∂v: means over the triangles of a wedge, by area.
    fn stretch(&mut self, mesh: &Mesh) {
        let mut sums = vec![Vec3::ZERO; self.wedges.len()];
        for (corners, triangle) in self.triangles.iter().zip(&mesh.triangles) {
            if let Some((lengths, area)) = derivatives(mesh, triangle) {
                for &w in corners {
                    sums[w as usize] += area * lengths.extend(1.0);
                }
            }
        }
        for (surfel, sum) in self.surfels.iter_mut().zip(sums) {
            if surfel.stretch != NO_UVS && sum.z > 0.0 {
                surfel.stretch = sum.truncate() / sum.z;
            }
        }
    }
}

/// Lengths of ∂p/∂u and ∂p/∂v of a triangle, and its area; none where the texture coordinates span nothing.
fn derivatives(mesh: &Mesh, triangle: &Triangle) -> Option<(Vec2, f32)> {
    let [a, b, c] = triangle.positions.map(|v| mesh.positions[v as usize]);
    let [ua, ub, uc] = triangle.uvs?.map(|t| mesh.uvs[t as usize]);
    let ([e, f], [g, h]) = ([b - a, c - a], [ub - ua, uc - ua]);
    let determinant = g.perp_dot(h);
    let lengths = Vec2::new((e * h.y - f * g.y).length(), (f * g.x - e * h.x).length()) / determinant.abs();
    (determinant != 0.0 && lengths.is_finite()).then(|| (lengths, 0.5 * e.cross(f).length()))
}

/// Finds or makes wedges, those of a vertex in a chained list: no hashing, and the same order on every run.
struct Splitter<'a> {
    scene: &'a Scene,
    dominant_uvs: Vec<Vec2>,
    out: Wedges,
    keys: Vec<Key>,
    first: Vec<u32>,
    next: Vec<u32>,
}

const END: u32 = u32::MAX;

impl<'a> Splitter<'a> {
    fn new(scene: &'a Scene) -> Self {
        let vertices = scene.mesh().positions.len();
        let out = Wedges { vertices, ..Wedges::default() };
        let first = vec![END; vertices];
        Self { scene, dominant_uvs: dominant_uvs(scene), out, keys: Vec::new(), first, next: Vec::new() }
    }

    fn wedge(&mut self, vertex: u32, key: Key) -> u32 {
        let mut at = self.first[vertex as usize];
        while at != END {
            if self.keys[at as usize] == key {
                return at;
            }
            at = self.next[at as usize];
        }
        let new = self.out.wedges.len() as u32;
        self.next.push(std::mem::replace(&mut self.first[vertex as usize], new));
        self.keys.push(key);
        self.push(vertex, key);
        new
    }

    fn push(&mut self, vertex: u32, key: Key) {
        let mesh = self.scene.mesh();
        let v = vertex as usize;
        let normal = mesh.normals[key.normal as usize];
        let bare = ShaderVertex { position: mesh.positions[v], normal, ..ShaderVertex::default() };
        let carried = self.scene.carried().map_or(bare, |carried| carried.vertices[v]);
        let texel = match carried.place {
            None => NOWHERE,
            Some(Place::Uv(_)) => 0,
            Some(Place::Texel(texel)) => texel,
        };
        let uv = mesh.uvs.get(key.uv as usize).copied();
        self.out.wedges.push(Wedge {
            position: carried.position,
            texel,
            normal: carried.normal,
            vertex,
            dominant_uv: self.dominant_uvs[v],
            uv: uv.unwrap_or_default(),
            axis: carried.tangent.tangent.extend(carried.tangent.sign),
        });
        self.out.normals.push(normal.extend(0.0));
        let stretch = if uv.is_some() { Vec2::ZERO } else { NO_UVS };
        let tangent = key.tangent.tangent.extend(key.tangent.sign);
        self.out.surfels.push(Surfel { tangent, stretch, scalar: Vec2::ZERO });
    }
}

/// One texture coordinate for each vertex, at which all its wedges are displaced: that of the displacement map, or else
/// that of its first corner.
fn dominant_uvs(scene: &Scene) -> Vec<Vec2> {
    let mesh = scene.mesh();
    let mut uvs: Vec<Option<Vec2>> = match scene.carried() {
        None => vec![None; mesh.positions.len()],
        Some(carried) => carried.vertices.iter().map(|v| if let Some(Place::Uv(uv)) = v.place { Some(uv) } else { None }).collect(),
    };
    for triangle in &mesh.triangles {
        for (k, v) in triangle.positions.into_iter().enumerate() {
            let uv = triangle.uvs.map(|uvs| mesh.uvs[uvs[k] as usize]);
            uvs[v as usize] = uvs[v as usize].or(uv);
        }
    }
    uvs.into_iter().map(Option::unwrap_or_default).collect()
}

/// The vertex that a wedge was made from.
pub(crate) fn shader_vertex(wedge: &Wedge, is_per_vertex: bool) -> ShaderVertex {
    let place = match wedge.texel {
        NOWHERE => None,
        texel if is_per_vertex => Some(Place::Texel(texel)),
        _ => Some(Place::Uv(wedge.dominant_uv)),
    };
    let tangent = Tangent { tangent: wedge.axis.truncate(), sign: wedge.axis.w };
    ShaderVertex { position: wedge.position, normal: wedge.normal, tangent, place }
}

/// Whether a map has a texel for each `v` line, and what its texels say, as `Displacement::kind` in WGSL has it.
pub(crate) fn kind(scene: &Scene) -> u32 {
    let Some(carried) = scene.carried() else { return 0 };
    let per_vertex = carried.vertices.iter().any(|v| matches!(v.place, Some(Place::Texel(_))));
    let said = match carried.map.kind() {
        MapKind::Scalar => 0,
        MapKind::VectorObject => 1,
        MapKind::VectorTangent => 2,
    };
    said + if per_vertex { PER_VERTEX } else { 0 }
}

/// Added to a kind where each `v` line has a texel of its own.
pub(crate) const PER_VERTEX: u32 = 4;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles over a square; the second has another normal at one of the two corners that they share.
    fn square() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, 2.0 * Vec3::X, Vec3::new(2.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z, Vec3::X],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            triangles: vec![
                Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: Some([0, 1, 2]) },
                Triangle { positions: [0, 2, 3], normals: [1, 0, 0], uvs: Some([0, 2, 3]) },
            ],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_vertex_is_split_only_where_its_corners_differ() {
        let wedges = Wedges::new(&Scene::new(square()).unwrap());
        assert_eq!(wedges.wedges.len(), 5);
        assert_eq!(wedges.triangles[0][2], wedges.triangles[1][1]);
        assert_ne!(wedges.triangles[0][0], wedges.triangles[1][0]);
        let places = wedges.triangles.iter().flatten().map(|&w| wedges.wedges[w as usize].position);
        let expected = square().triangles.iter().flat_map(|t| t.positions).map(|v| square().positions[v as usize]).collect::<Vec<_>>();
        assert_eq!(places.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn stretch_is_how_much_surface_a_texture_coordinate_spans() {
        let wedges = Wedges::new(&Scene::new(square()).unwrap());
        for surfel in &wedges.surfels {
            assert_eq!(surfel.stretch, Vec2::new(2.0, 1.0));
        }
    }
}
