//! The UV layout of a surface: its faces laid out in texture space.
//!
//! ```
//! use glam::DVec2;
//! use planish_geometry::mesh::{atlas::{Atlas, AtlasError}, shapes};
//!
//! // A square of two triangles, each of which names three uv vertices of its own.
//! let square = shapes::grid(1);
//! let uvs = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.5, 0.5], [0.9, 0.9], [0.5, 0.9]].map(DVec2::from_array);
//! let atlas = Atlas::new(&square, &uvs, (0..6).map(Some))?;
//! let found = atlas.charts(&square);
//! assert_eq!((found.charts, found.seam_edges, found.seam_vertices), (2, 1, 2));
//! assert_eq!(atlas.wedges().get(0), [0, 3]);
//! # Ok::<(), AtlasError>(())
//! ```

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::EdgeKind;
use crate::mesh::union_find::UnionFind;
use glam::{DVec2, IVec2, Vec2};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Reasons why a mesh has no layout.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AtlasError {
    /// No corner names a uv vertex.
    #[error("the mesh has no texture coordinates (no face names a `vt`)")]
    NoUvs,
    /// A face uses a uv vertex that is not finite in single precision, in which maps are sampled.
    #[error("texture coordinate {uv} is not finite in single precision")]
    NonFinite {
        /// Index of the texture coordinates, from 0.
        uv: Index,
    },
}

/// UV layout of a surface: the uv vertex that each corner names, the wedges, and the dominant uv vertex of each vertex.
///
/// Equal texture coordinates are one uv vertex, which has the lowest of their indices in the source.
#[derive(Clone, Debug)]
pub struct Atlas {
    uvs: Vec<DVec2>,
    corner_uvs: Vec<Index>,
    wedges: Ragged<Index>,
    dominant: Vec<Index>,
}

/// Counts that describe a layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Charts {
    /// Number of connected pieces of the layout, where faces are connected by edges that are no seam.
    pub charts: usize,
    /// Number of edges whose two faces name different uv vertices.
    pub seam_edges: usize,
    /// Number of vertices with more than one wedge.
    pub seam_vertices: usize,
    /// Number of faces without texture coordinates at one corner or more.
    pub unmapped_faces: usize,
}

impl Atlas {
    const ABSENT: Index = Index::MAX;

    /// Builds the layout of a surface. `uvs` are the texture coordinates of the source (#vt×2, v up); `corner_uvs` names one
    /// of them for each corner of the topology, or none.
    ///
    /// # Panics
    /// If there is not one entry for each corner, or an index is out of range.
    pub fn new(
        surface: &Surface,
        uvs: &[DVec2],
        corner_uvs: impl Iterator<Item = Option<Index>>,
    ) -> Result<Self, AtlasError> {
        let canonical = first_of_equals(uvs);
        let corner_uvs: Vec<Index> =
            corner_uvs.map(|uv| uv.map_or(Self::ABSENT, |uv| canonical[uv as usize])).collect();
        assert_eq!(corner_uvs.len(), surface.topology().faces().items().len(), "one uv vertex for each corner");
        let mut used = corner_uvs.iter().copied().filter(|&uv| uv != Self::ABSENT).peekable();
        if used.peek().is_none() {
            return Err(AtlasError::NoUvs);
        }
        if let Some(uv) = used.find(|&uv| !uvs[uv as usize].as_vec2().is_finite()) {
            return Err(AtlasError::NonFinite { uv });
        }
        let mut atlas = Self { uvs: uvs.to_vec(), corner_uvs, wedges: Ragged::default(), dominant: Vec::new() };
        atlas.find_wedges(surface);
        Ok(atlas)
    }

    /// Finds the uv vertices of each vertex, and the dominant one among them.
    fn find_wedges(&mut self, surface: &Surface) {
        let topology = surface.topology();
        let faces = (0..topology.faces().len() as Index).into_par_iter();
        let areas: Vec<f64> = faces.map(|f| self.face_area(surface, f).map_or(0.0, f64::abs)).collect();
        let wedges_of = |v: Index, named: &mut Vec<(Index, Index)>, wedges: &mut Ragged<Index>| {
            let corners = topology.corners(v).iter().map(|&c| (self.corner_uvs[c as usize], c));
            named.clear();
            named.extend(corners.filter(|(uv, _)| *uv != Self::ABSENT));
            named.sort_unstable();
            let mut best = (false, f64::NEG_INFINITY, Self::ABSENT);
            for same in named.chunk_by(|a, b| a.0 == b.0) {
                let uv = same[0].0;
                let area: f64 = same.iter().map(|&(_, c)| areas[topology.face(c) as usize]).sum();
                let inside = in_unit_square(self.uvs[uv as usize]);
                // Strictly better only: among equals the lowest index, which comes first, wins.
                if (inside && !best.0) || (inside == best.0 && area > best.1) {
                    best = (inside, area, uv);
                }
                wedges.extend_open(uv);
            }
            wedges.close();
            best.2
        };
        let vertices: Vec<Index> = (0..topology.vertex_count() as Index).collect();
        let chunks = vertices.par_chunks(8192).map(|chunk| {
            let (mut named, mut wedges) = (Vec::new(), Ragged::default());
            let dominant: Vec<Index> = chunk.iter().map(|&v| wedges_of(v, &mut named, &mut wedges)).collect();
            (wedges, dominant)
        });
        let (mut all, mut dominant) = (Ragged::default(), Vec::with_capacity(vertices.len()));
        for (wedges, of_chunk) in chunks.collect::<Vec<_>>() {
            all.append(&wedges);
            dominant.extend(of_chunk);
        }
        (self.wedges, self.dominant) = (all, dominant);
    }

    /// Name of the rule behind [`Self::dominant`], as it is written to manifests.
    pub const DOMINANT_RULE: &str = "inside-unit-square, largest-uv-area, lowest-vt-index";

    /// Returns the one uv vertex at which all wedges of a vertex sample, so that they all get the same height.
    ///
    /// Uv vertices inside the unit square win over others; among equals the one whose faces have the largest total area in
    /// the texture wins, because there the map is finest; then the lowest index. `None` if no face of the vertex has
    /// texture coordinates.
    pub fn dominant(&self, vertex: Index) -> Option<Index> {
        let uv = self.dominant[vertex as usize];
        (uv != Self::ABSENT).then_some(uv)
    }
    /// Texture coordinates of the uv vertices by their index in the source, v up. #vt×2
    pub fn uvs(&self) -> &[DVec2] {
        &self.uvs
    }
    /// Uv vertex that a corner names; `None` if it names none.
    pub fn corner_uv(&self, corner: Index) -> Option<Index> {
        let uv = self.corner_uvs[corner as usize];
        (uv != Self::ABSENT).then_some(uv)
    }
    /// Texture coordinates at a corner; `None` if it has none.
    pub fn at_corner(&self, corner: Index) -> Option<DVec2> {
        self.corner_uv(corner).map(|uv| self.uvs[uv as usize])
    }
    /// Wedges of each vertex: the uv vertices that its corners name, ascending. #V lists
    pub fn wedges(&self) -> &Ragged<Index> {
        &self.wedges
    }
    /// Signed area of a face in the texture, positive if counter-clockwise; `None` if a corner has no texture coordinates.
    pub(crate) fn face_area(&self, surface: &Surface, face: Index) -> Option<f64> {
        let corners = surface.topology().faces().range(face);
        let origin = self.at_corner(corners.start as Index)?;
        let mut doubled = 0.0;
        let mut previous = DVec2::ZERO;
        for c in corners {
            let uv = self.at_corner(c as Index)? - origin;
            doubled += previous.perp_dot(uv);
            previous = uv;
        }
        Some(doubled / 2.0)
    }
    /// Uv vertices of an edge as the face of one of its corners names them, in the order of the edge's end points.
    fn side(&self, surface: &Surface, corner: Index) -> [Option<Index>; 2] {
        let topology = surface.topology();
        let next = topology.next(corner);
        let side = [self.corner_uv(corner), self.corner_uv(next)];
        if topology.vertex(corner) < topology.vertex(next) { side } else { [side[1], side[0]] }
    }
    /// Returns true if the layout is cut along an edge: at a seam, at the boundary, and at non-manifold edges.
    pub fn is_cut(&self, surface: &Surface, edge: Index) -> bool {
        let corners = surface.topology().edge_corners().get(edge);
        let sides = corners.iter().map(|&c| self.side(surface, c));
        surface.topology().edge_kind(edge) != EdgeKind::Interior
            || sides.clone().any(|s| s != self.side(surface, corners[0]))
    }
    /// Uv vertices on the outlines of the charts, ascending.
    pub fn outline(&self, surface: &Surface) -> Vec<Index> {
        let edges = (0..surface.topology().edges().len() as Index).filter(|&e| self.is_cut(surface, e));
        let corners = edges.flat_map(|e| surface.topology().edge_corners().get(e));
        let mut outline: Vec<Index> = corners.flat_map(|&c| self.side(surface, c)).flatten().collect();
        outline.sort_unstable();
        outline.dedup();
        outline
    }
    /// Number of faces that are mirrored in the texture, where they have a negative area.
    pub fn mirrored_faces(&self, surface: &Surface) -> usize {
        let faces = (0..surface.topology().faces().len() as Index).into_par_iter();
        faces.filter(|&f| self.face_area(surface, f).is_some_and(|area| area < 0.0)).count()
    }
    /// Counts charts, seams, and faces without texture coordinates.
    pub fn charts(&self, surface: &Surface) -> Charts {
        let topology = surface.topology();
        let mut charts = UnionFind::new(topology.faces().len());
        let mut seam_edges = 0;
        for e in 0..topology.edges().len() as Index {
            let corners = topology.edge_corners().get(e);
            if self.is_cut(surface, e) {
                seam_edges += usize::from(topology.edge_kind(e) == EdgeKind::Interior);
            } else {
                charts.join(topology.face(corners[0]), topology.face(corners[1]));
            }
        }
        let areas: Vec<Option<f64>> =
            (0..topology.faces().len() as Index).map(|f| self.face_area(surface, f)).collect();
        let chart = charts.into_lowest();
        let is_first = |f: usize| chart[f] as usize == f && areas[f].is_some();
        Charts {
            charts: (0..chart.len()).filter(|&f| is_first(f)).count(),
            seam_edges,
            seam_vertices: self.wedges.iter().filter(|wedges| wedges.len() > 1).count(),
            unmapped_faces: areas.iter().filter(|area| area.is_none()).count(),
        }
    }
}

/// Largest number of tiles between a layout and the unit square along an axis with which single precision has digits enough.
pub const FARTHEST_TILE: i32 = 1000;

/// Texture coordinate from the lower left corner of a tile, which is a square of the integer grid, in single precision as shaders
/// compute it.
pub fn in_tile(uv: DVec2, tile: IVec2) -> Vec2 {
    uv.as_vec2() - tile.as_vec2()
}

/// Tile of a layout whose faces have these texture coordinates: the unit square if the middle of any face lies there, and else the one
/// with most middles, if these are more than half. Textures repeat, so a layout in another tile is as good as in the unit square.
pub fn tile_of(faces: impl Iterator<Item = impl IntoIterator<Item = DVec2>>) -> IVec2 {
    let (mut tiles, mut count) = (BTreeMap::<[i32; 2], usize>::new(), 0);
    for face in faces {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = face.into_iter().fold(none, |[low, high], uv| [low.min(uv), high.max(uv)]);
        let middle = (low + high) / 2.0;
        if in_unit_square(middle) {
            return IVec2::ZERO;
        }
        // A face without texture coordinates has no middle.
        count += usize::from(middle.is_finite());
        if middle.abs().max_element() <= FARTHEST_TILE.into() {
            *tiles.entry(middle.floor().as_ivec2().to_array()).or_default() += 1;
        }
    }
    tiles.into_iter().find(|(_, faces)| 2 * faces > count).map_or(IVec2::ZERO, |(tile, _)| tile.into())
}

/// Returns true if a texture coordinate is in [0, 1]².
pub fn in_unit_square(uv: DVec2) -> bool {
    uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all()
}

/// Index of the first entry with equal coordinates for each entry; −0 equals 0. #vt
fn first_of_equals(uvs: &[DVec2]) -> Vec<Index> {
    let mut seen = FxHashMap::default();
    seen.reserve(uvs.len());
    (0..).zip(uvs).map(|(i, uv)| *seen.entry((*uv + 0.0).to_array().map(f64::to_bits)).or_insert(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A cube with a square chart for each face; that of the first face is the largest.
    fn boxed() -> (Surface, Atlas) {
        let cube = shapes::cube();
        let square = |f: usize, k: usize| {
            let size = if f == 0 { 0.2 } else { 0.1 };
            let corner = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y][k];
            DVec2::new(0.15 * f as f64, 0.3) + size * corner * if f == 0 { 0.7 } else { 1.0 }
        };
        let uvs: Vec<_> = (0..6).flat_map(|f| (0..4).map(move |k| square(f, k))).collect();
        let atlas = Atlas::new(&cube, &uvs, (0..24).map(Some)).unwrap();
        (cube, atlas)
    }

    #[test]
    fn a_cube_in_six_squares() {
        let (cube, atlas) = boxed();
        let charts = atlas.charts(&cube);
        assert_eq!((charts.charts, charts.seam_edges, charts.seam_vertices), (6, 12, 8));
        assert!(atlas.wedges().iter().all(|wedges| wedges.len() == 3));
        assert_eq!(atlas.outline(&cube).len(), 24);
    }

    #[test]
    fn the_dominant_wedge_is_the_one_with_most_texture() {
        let (cube, atlas) = boxed();
        for corner in 0..4 {
            let v = cube.topology().vertex(corner);
            assert_eq!(atlas.dominant(v), atlas.corner_uv(corner));
        }
    }

    #[test]
    fn equal_coordinates_are_one_uv_vertex_and_no_seam() {
        let grid = shapes::grid(3);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uv = |c: Index| grid.at_corner(c).truncate();
        let uvs: Vec<_> = corners.clone().map(uv).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(Some)).unwrap();
        let expected = Charts { charts: 1, ..Charts::default() };
        assert_eq!(atlas.charts(&grid), expected);
    }

    #[test]
    fn the_tile_of_a_layout_is_that_of_most_faces_unless_the_unit_square_has_one() {
        let at =
            |x: f64, y: f64| [DVec2::new(x + 0.1, y + 0.2), DVec2::new(x + 0.9, y + 0.2), DVec2::new(x + 0.4, y + 1.0)];
        let tile = |faces: &[[DVec2; 3]]| tile_of(faces.iter().copied()).to_array();
        assert_eq!(tile(&[]), [0, 0]);
        assert_eq!(tile(&[at(0.0, 0.0)]), [0, 0]);
        assert_eq!(tile(&[at(3.0, -2.0), at(3.0, -2.0), at(7.0, 1.0)]), [3, -2]);
        assert_eq!(tile(&[at(3.0, -2.0), at(3.0, -2.0), at(0.0, 0.0)]), [0, 0]);
        assert_eq!(tile(&[at(3.0, -2.0), at(7.0, 1.0)]), [0, 0], "neither has more than half");
        assert_eq!(tile(&[[DVec2::ONE; 3], at(1.0, 0.0)]), [0, 0], "the border belongs to the unit square");
        assert_eq!(tile(&[at(1e9, 0.0)]), [0, 0], "single precision has no digits left there");
        // The corner is exact in single precision.
        assert_eq!(in_tile(DVec2::new(3.25, -1.0), IVec2::new(3, -2)), Vec2::new(0.25, 1.0));
    }

    #[test]
    fn without_coordinates_there_is_no_atlas() {
        let grid = shapes::grid(1);
        assert_eq!(Atlas::new(&grid, &[], [None; 6].into_iter()).unwrap_err(), AtlasError::NoUvs);
        let broken = Atlas::new(&grid, &[DVec2::NAN], [Some(0); 6].into_iter());
        assert_eq!(broken.unwrap_err(), AtlasError::NonFinite { uv: 0 });
        let huge = Atlas::new(&grid, &[DVec2::ZERO, DVec2::new(1e300, 0.0)], [Some(1); 6].into_iter());
        assert_eq!(huge.unwrap_err(), AtlasError::NonFinite { uv: 1 });
    }
}
