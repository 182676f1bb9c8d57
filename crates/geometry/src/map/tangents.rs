//! MikkTSpace tangent frames (Mikkelsen 2008), block by block on all threads.
//!
//! The frame of a corner is a sum over the triangles around its vertex, in their order. A block of triangles together with all
//! its vertex neighbours therefore gives the same bits as the whole mesh. (The exception is a triangle without area in the
//! texture: it takes the orientation of its first neighbour, which may be another one in a block.)
//!
//! ```
//! use glam::{DVec2, Vec3};
//! use planish_geometry::map::tangents;
//! use planish_geometry::mesh::{atlas::{Atlas, AtlasError}, shapes};
//!
//! // A square in the plane z = 0, which is mirrored in the texture: u grows where x falls.
//! let square = shapes::grid(1);
//! let uvs: Vec<DVec2> = square.positions().iter().map(|p| DVec2::new(1.0 - p.x, p.y)).collect();
//! let atlas = Atlas::new(&square, &uvs, square.topology().faces().items().iter().map(|&v| Some(v)))?;
//! let frame = tangents::tangents(&square, &atlas, &[Vec3::Z; 4])[0][0];
//! assert_eq!((frame.tangent, frame.sign), (Vec3::NEG_X, -1.0));
//! assert_eq!(frame.frame(Vec3::Z), [Vec3::NEG_X, Vec3::Y, Vec3::Z]);
//! # Ok::<(), AtlasError>(())
//! ```

use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Approximate number of triangles of a block, which fit into the cache of a core.
const BLOCK: usize = 16_384;

/// Tangent at a corner, and the sign that gives its bitangent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tangent {
    /// Unit tangent, along increasing u.
    pub tangent: Vec3,
    /// Sign of the bitangent sign · n × t, which is along increasing v (up): 1 or −1.
    pub sign: f32,
}

impl Tangent {
    /// Tangent, bitangent and normal of the frame at a unit normal.
    pub fn frame(self, normal: Vec3) -> [Vec3; 3] {
        [self.tangent, normal.cross(self.tangent) * self.sign, normal]
    }
}

/// Tangent frame of each vertex, which no seam cuts. #V
///
/// The tangents (#T×3) of the corners at the dominant uv vertex that have the sign of the first one are summed, and the sum is
/// made perpendicular to the normal (#V×3, unit).
pub fn at_vertices(
    surface: &Surface,
    atlas: &Atlas,
    vertex_normals: &[Vec3],
    tangents: &[[Tangent; 3]],
) -> Vec<Tangent> {
    let mut sums = vec![Tangent { tangent: Vec3::ZERO, sign: 0.0 }; vertex_normals.len()];
    for (corners, frames) in surface.triangle_corners().iter().zip(tangents) {
        for (&corner, frame) in corners.iter().zip(frames) {
            let v = surface.topology().vertex(corner);
            if atlas.corner_uv(corner) != atlas.dominant(v) {
                continue;
            }
            let sum = &mut sums[v as usize];
            if sum.sign == 0.0 {
                sum.sign = frame.sign;
            }
            if sum.sign == frame.sign {
                sum.tangent += frame.tangent;
            }
        }
    }
    let finish = |(sum, n): (Tangent, &Vec3)| {
        let flat = (sum.tangent - *n * n.dot(sum.tangent)).try_normalize();
        // Without a tangent any direction will do, if it is always the same one.
        let tangent = flat.unwrap_or_else(|| if *n == Vec3::ZERO { Vec3::X } else { n.any_orthonormal_vector() });
        Tangent { tangent, sign: if sum.sign == 0.0 { 1.0 } else { sum.sign } }
    };
    sums.into_iter().zip(vertex_normals).map(finish).collect()
}

/// MikkTSpace tangents at the corners of each triangle, for unit normals of the vertices (#V×3). #T×3
pub fn tangents(surface: &Surface, atlas: &Atlas, vertex_normals: &[Vec3]) -> Vec<[Tangent; 3]> {
    in_blocks(surface, atlas, vertex_normals, BLOCK)
}

fn in_blocks(surface: &Surface, atlas: &Atlas, vertex_normals: &[Vec3], size: usize) -> Vec<[Tangent; 3]> {
    let [low, high] = surface.bounds();
    // Far from the origin edges would be lost in single precision.
    let centre = (low + high) / 2.0;
    let blocks = blocks(surface, atlas, size);
    let of_block = |block: Index| {
        let own = blocks.get(block);
        let triangles = with_neighbours(surface, own);
        let mut frames = Frames::new(&triangles, surface, atlas, vertex_normals, centre);
        // The error type has no values.
        let _ = bevy_mikktspace::generate_tangents(&mut frames);
        let frames_of = |t: &Index| triangles.binary_search(t).map_or([Tangent::default(); 3], |i| frames.tangents[i]);
        own.iter().map(frames_of).collect::<Vec<_>>()
    };
    let found: Vec<Vec<[Tangent; 3]>> = (0..blocks.len() as Index).into_par_iter().map(of_block).collect();
    let mut tangents = vec![[Tangent::default(); 3]; surface.triangle_corners().len()];
    for (&t, of_triangle) in blocks.items().iter().zip(found.into_iter().flatten()) {
        tangents[t as usize] = of_triangle;
    }
    tangents
}

/// Groups triangles by a grid over the texture, where neighbours are close together whatever their order in the file.
fn blocks(surface: &Surface, atlas: &Atlas, size: usize) -> Ragged<Index> {
    let triangles = surface.triangle_corners();
    let side = (triangles.len() as f64 / size as f64).sqrt().ceil().max(1.0);
    let cell = |t: &[Index; 3]| {
        let uv = atlas.at_corner(t[0]).unwrap_or_default();
        // Texture coordinates outside the unit square belong to the cells at its border.
        let at = (uv * side).clamp(DVec2::ZERO, DVec2::splat(side - 1.0));
        at.y as Index * side as Index + at.x as Index
    };
    Ragged::group((side * side) as usize, triangles.iter().zip(0..).map(|(t, i)| (cell(t), i)))
}

/// Triangles that share a vertex with one of `own`, including `own`, ascending.
fn with_neighbours(surface: &Surface, own: &[Index]) -> Vec<Index> {
    let topology = surface.topology();
    let mut vertices: Vec<Index> =
        own.iter().flat_map(|&t| surface.triangle_corners()[t as usize].map(|c| topology.vertex(c))).collect();
    vertices.sort_unstable();
    vertices.dedup();
    // A face with n corners has n − 2 triangles, one after the other.
    let of_face = |face: Index| {
        let corners = topology.faces().range(face);
        (corners.start - 2 * face as usize) as Index..(corners.end - 2 * (face as usize + 1)) as Index
    };
    let mut all: Vec<Index> =
        vertices.iter().flat_map(|&v| topology.corners(v)).flat_map(|&c| of_face(topology.face(c))).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Attributes of the triangles in the form in which MikkTSpace reads them, which it does many times, and their tangents.
struct Frames {
    corners: Vec<[Corner; 3]>,
    tangents: Vec<[Tangent; 3]>,
}

#[derive(Clone, Copy)]
struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

impl Frames {
    fn new(triangles: &[Index], surface: &Surface, atlas: &Atlas, vertex_normals: &[Vec3], centre: DVec3) -> Self {
        let corner = |c: Index| Corner {
            position: (surface.at_corner(c) - centre).as_vec3().to_array(),
            normal: vertex_normals[surface.topology().vertex(c) as usize].to_array(),
            uv: atlas.at_corner(c).unwrap_or_default().as_vec2().to_array(),
        };
        let corners = triangles.iter().map(|&t| surface.triangle_corners()[t as usize].map(corner)).collect();
        Self { corners, tangents: vec![[Tangent::default(); 3]; triangles.len()] }
    }
}

impl Geometry for Frames {
    fn num_faces(&self) -> usize {
        self.corners.len()
    }
    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }
    fn position(&self, face: usize, k: usize) -> [f32; 3] {
        self.corners[face][k].position
    }
    fn normal(&self, face: usize, k: usize) -> [f32; 3] {
        self.corners[face][k].normal
    }
    fn tex_coord(&self, face: usize, k: usize) -> [f32; 2] {
        self.corners[face][k].uv
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, k: usize) {
        let [x, y, z, sign] = space.unwrap_or_default().tangent_encoded();
        self.tangents[face][k] = Tangent { tangent: Vec3::new(x, y, z), sign };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::normals::{FaceWeight, vertex_normals};
    use crate::mesh::polygon;
    use crate::mesh::shapes;

    #[test]
    fn blocks_give_the_bits_of_the_whole() {
        // A bumpy sphere under a cylindrical projection that is mirrored on one half, so that signs differ, with
        // three seams.
        let sphere = shapes::dented_sphere(3);
        let normals: Vec<Vec3> = vertex_normals(&sphere, FaceWeight::Angle).iter().map(|n| n.as_vec3()).collect();
        let corners = 0..sphere.topology().faces().items().len() as Index;
        let uv = |c: Index| {
            let p = sphere.at_corner(c);
            let [a, b, d] = [0, 1, 2].map(|k| sphere.at_corner(c / 3 * 3 + k));
            let third = (polygon::newell([a, b, d].into_iter()).x * 1e3).round().rem_euclid(3.0);
            DVec2::new(p.x.abs() * 0.3 + 0.33 * third, p.y * 0.4 + 0.5)
        };
        let uvs: Vec<_> = corners.clone().map(uv).collect();
        let atlas = Atlas::new(&sphere, &uvs, corners.map(Some)).unwrap();
        let whole = in_blocks(&sphere, &atlas, &normals, usize::MAX);
        let signs = |sign: f32| whole.iter().filter(|t| t[0].sign == sign).count();
        assert!(signs(1.0) > 300 && signs(-1.0) > 300);
        for size in [10, 100] {
            assert!(in_blocks(&sphere, &atlas, &normals, size) == whole, "{size}");
        }
    }

    #[test]
    fn polygons_have_all_their_triangles() {
        let cube = shapes::cube();
        assert_eq!(
            with_neighbours(&cube, &[0]),
            (0..12).filter(|t| ![2, 3].contains(t)).collect::<Vec<_>>().as_slice()
        );
    }
}
