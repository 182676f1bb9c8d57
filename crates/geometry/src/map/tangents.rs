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
use rustc_hash::{FxHashMap, FxHasher};
use std::hash::{Hash, Hasher};
use std::sync::OnceLock;

/// Approximate number of triangles of a block, which fit into the cache of a core.
const BLOCK: usize = 16_384;

/// Number of triangles with one corner in common up to which its frame is that of all of them. MikkTSpace takes the square of that number
/// in time and its multiple in stack, so a corner with more gets frames of so many at a time.
const MOST_AT_CORNER: usize = 256;

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
    let around = OnceLock::new();
    let of_block = |block: Index| {
        let own = blocks.get(block);
        let triangles = with_neighbours(surface, own);
        let frames = Frames::new(&triangles, surface, atlas, vertex_normals, centre);
        if !frames.may_crowd() {
            return frames.generate(&triangles, own);
        }
        let of_part = |own: &[Index]| {
            let near = with_few_neighbours(surface, own, around.get_or_init(|| triangles_around(surface)));
            let all = Frames::new(&near, surface, atlas, vertex_normals, centre);
            let kept = all.uncrowded(|t| own.binary_search(&near[t]).is_ok());
            let triangles: Vec<Index> = kept.iter().map(|&t| near[t]).collect();
            Frames::new(&triangles, surface, atlas, vertex_normals, centre).generate(&triangles, own)
        };
        own.chunks(MOST_AT_CORNER / 2).flat_map(of_part).collect()
    };
    let found: Vec<Vec<[Tangent; 3]>> = (0..blocks.len() as Index).into_par_iter().map(of_block).collect();
    let mut tangents = vec![[Tangent::default(); 3]; surface.triangle_corners().len()];
    for (&t, of_triangle) in blocks.items().iter().zip(found.into_iter().flatten()) {
        tangents[t as usize] = of_triangle;
    }
    tangents
}

/// Triangles around each vertex. #V lists
fn triangles_around(surface: &Surface) -> Ragged<Index> {
    let all = (0..).zip(surface.triangle_corners());
    let corners = all.flat_map(|(t, corners)| corners.map(|c| (surface.topology().vertex(c), t)));
    Ragged::group(surface.positions().len(), corners)
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

/// Triangles that share a vertex with one of `own`, including `own`, ascending. Vertices with more than [`MOST_AT_CORNER`] of the
/// triangles `around` them (#V lists) do not count.
fn with_few_neighbours(surface: &Surface, own: &[Index], around: &Ragged<Index>) -> Vec<Index> {
    let mut all = own.to_vec();
    for &t in own {
        let lists = surface.triangle_corners()[t as usize].map(|c| around.get(surface.topology().vertex(c)));
        lists.iter().filter(|list| list.len() <= MOST_AT_CORNER).for_each(|list| all.extend_from_slice(list));
    }
    all.sort_unstable();
    all.dedup();
    all
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
    // Each face once: all vertices of a large polygon have the same one.
    let corners = vertices.iter().flat_map(|&v| topology.corners(v));
    let mut faces: Vec<Index> = corners.map(|&c| topology.face(c)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.into_iter().flat_map(of_face).collect()
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

    /// Computes the frames of `triangles`, whose attributes these are, and returns those of `own`, which are among them.
    fn generate(mut self, triangles: &[Index], own: &[Index]) -> Vec<[Tangent; 3]> {
        // The error type has no values.
        let _ = bevy_mikktspace::generate_tangents(&mut self);
        let frames_of = |t: &Index| triangles.binary_search(t).map_or([Tangent::default(); 3], |i| self.tangents[i]);
        own.iter().map(frames_of).collect()
    }

    /// Returns false if surely no more than [`MOST_AT_CORNER`] corners are at one place. Vertices that differ in double precision alone
    /// are at one place for MikkTSpace.
    fn may_crowd(&self) -> bool {
        const SLOTS: usize = 1 << 16;
        let mut counts = vec![0u32; SLOTS];
        let count = |corner: &Corner| {
            let slot = &mut counts[corner.place_hash() as usize % SLOTS];
            *slot += 1;
            *slot as usize > MOST_AT_CORNER
        };
        self.corners.as_flattened().iter().any(count)
    }

    /// Triangles, ascending, without those that make a corner one of more than [`MOST_AT_CORNER`]; all that are `own` are kept.
    fn uncrowded(&self, own: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut counts: FxHashMap<u64, usize> = FxHashMap::default();
        let (mut kept, others): (Vec<usize>, Vec<usize>) = (0..self.corners.len()).partition(|&t| own(t));
        for t in &kept {
            self.corners[*t].iter().for_each(|corner| *counts.entry(corner.place_hash()).or_default() += 1);
        }
        for t in others {
            let places = self.corners[t].map(|corner| corner.place_hash());
            if places.iter().all(|place| counts.get(place).is_none_or(|count| *count < MOST_AT_CORNER)) {
                places.iter().for_each(|place| *counts.entry(*place).or_default() += 1);
                kept.push(t);
            }
        }
        kept.sort_unstable();
        kept
    }
}

impl Corner {
    /// Hash of the position; −0 and 0 are one place.
    fn place_hash(&self) -> u64 {
        let mut hasher = FxHasher::default();
        self.position.map(|x| (x + 0.0).to_bits()).hash(&mut hasher);
        hasher.finish()
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
    use crate::mesh::topology::Topology;

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

    /// A fan of so many triangles around a vertex at the origin, each with a vertex of its own there if `apart` is above 0, which they
    /// are far from each other.
    fn fan(count: u32, apart: f64) -> (Surface, Atlas) {
        let rim = |k: u32| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / f64::from(count));
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        let hubs = if apart > 0.0 { count } else { 1 };
        points.extend((0..hubs).map(|k| DVec3::new(0.0, 0.0, apart * f64::from(k))));
        points.extend((0..count).map(|k| rim(k).extend(0.0)));
        faces.extend((0..count).map(|k| vec![k % hubs, hubs + k, hubs + (k + 1) % count]));
        let surface = Surface::new(Topology::new(points.len(), faces.into_iter().collect()), points);
        let uvs: Vec<DVec2> = surface.positions().iter().map(|p| p.truncate() * 0.4 + 0.5).collect();
        let named = surface.topology().faces().items().iter().map(|&v| Some(v));
        let atlas = Atlas::new(&surface, &uvs, named).unwrap();
        (surface, atlas)
    }

    #[test]
    fn vertices_with_any_number_of_triangles_have_frames() {
        // MikkTSpace itself ends with an overflow of the stack at some ten thousand triangles, also where they have vertices of their
        // own that are one in single precision.
        for (count, apart) in [(20_000, 0.0), (20_000, 1e-60)] {
            let (surface, atlas) = fan(count, apart);
            let frames = tangents(&surface, &atlas, &vec![Vec3::Z; surface.positions().len()]);
            let along_u = |frame: &Tangent| frame.tangent.distance(Vec3::X) < 1e-2 && frame.sign == 1.0;
            assert_eq!(frames.as_flattened().iter().filter(|frame| along_u(frame)).count(), 3 * count as usize);
        }
    }

    #[test]
    fn parts_give_the_bits_of_the_whole_away_from_crowded_corners() {
        let (surface, atlas) = fan(MOST_AT_CORNER as u32 + 44, 0.0);
        let normals = vec![Vec3::Z; surface.positions().len()];
        let all: Vec<Index> = (0..surface.triangle_corners().len() as Index).collect();
        let [low, high] = surface.bounds();
        let whole = Frames::new(&all, &surface, &atlas, &normals, (low + high) / 2.0).generate(&all, &all);
        for (part, whole) in tangents(&surface, &atlas, &normals).iter().zip(&whole) {
            assert_eq!(part[1..], whole[1..]);
            assert!(part[0].tangent.distance(whole[0].tangent) < 0.02, "{part:?} {whole:?}");
        }
    }

    #[test]
    fn parts_of_a_polygon_do_not_take_all_of_it_along() {
        // One polygon with so many corners, which lies around one of them.
        let count = 5000;
        let rim = |k: Index| DVec2::from_angle(f64::from(k) * 6.0 / f64::from(count)).extend(0.0);
        let points: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain((0..count).map(rim)).collect();
        let faces = std::iter::once((0..=count).collect::<Vec<Index>>()).collect();
        let surface = Surface::new(Topology::new(points.len(), faces), points);
        let around = triangles_around(&surface);
        let own: Vec<Index> = (0..100).collect();
        let near = with_few_neighbours(&surface, &own, &around);
        assert!(near.len() < count as usize / 2, "{}", near.len());
        assert!(own.iter().all(|t| near.contains(t)));
    }
}
