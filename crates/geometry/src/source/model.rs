//! A mesh with everything that follows from it: its welded surface, normals, UV layout and defects.
//!
//! ```
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::{Obj, ObjError}};
//!
//! // A square whose triangles have three `v` lines each; the last face has no area.
//! let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 4 5 6\nf 2 5 6\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! assert_eq!(model.surface().positions().len(), 4);
//! let defects = model.defects();
//! assert_eq!((defects.boundary_edges, defects.degenerate_faces, defects.first_degenerate_line), (4, 1, Some(9)));
//! # Ok::<(), ObjError>(())
//! ```

use crate::mesh::atlas::{self, Atlas, AtlasError};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::mesh::topology::{self, EdgeKind, TidyFaces};
use crate::mesh::weld::{Weld, Welding};
use crate::named;
use crate::source::{Corner, MeshData, Source};
use glam::{DVec2, DVec3, IVec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

named! {
    /// Source of the vertex normals of a mesh.
    #[derive(Default)]
    pub enum NormalSource {
        /// Normals of the file, averaged at each vertex; angle-weighted where a vertex has none.
        File = "file",
        /// Mean of the normals of the faces.
        Uniform = "uniform",
        /// Mean of the normals of the faces, weighted by area.
        Area = "area",
        /// Mean of the normals of the faces, weighted by angle, as Blender's.
        #[default]
        Angle = "angle",
    }
}

/// The source has no normals: no face names one that is finite and not zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the file has no normals (no face names a `vn`)")]
pub struct NoFileNormals;

/// Welded surface of positions and faces, without the mesh that they came from: all that denoising needs.
#[derive(Clone, Debug)]
pub struct WeldedSurface {
    /// Vertex that each position became.
    pub weld: Weld,
    /// Surface of the vertices, without degenerate and duplicate faces.
    pub surface: Surface,
    tidy: TidyFaces,
}

impl WeldedSurface {
    /// Welds positions (#v×3, model units) and connects faces, each of which lists the indices of its positions counter-clockwise
    /// seen from outside.
    ///
    /// # Panics
    /// If a face names a position that does not exist.
    pub fn new<F>(positions: &[DVec3], faces: impl IntoIterator<Item = F>, welding: Welding) -> Self
    where
        F: IntoIterator<Item = Index>,
    {
        let weld = Weld::new(positions, welding);
        let mut welded = Ragged::default();
        for face in faces {
            welded.push(face.into_iter().map(|v| weld.vertex_of()[v as usize]));
        }
        Self::connected(positions, weld, welded)
    }

    /// Connects faces of welded vertices.
    fn connected(positions: &[DVec3], weld: Weld, faces: Ragged<Index>) -> Self {
        let positions = weld.first().par_iter().map(|&v| positions[v as usize]).collect();
        Self::of_vertices(positions, weld, faces)
    }

    /// Connects faces of vertices with these positions (#V×3, model units).
    fn of_vertices(positions: Vec<DVec3>, weld: Weld, faces: Ragged<Index>) -> Self {
        let mut tidy = topology::tidy(positions.len(), faces);
        let topology = tidy.connect(positions.len());
        Self { surface: Surface::new(topology, positions), weld, tidy }
    }
}

/// A mesh as it was given, and its welded surface.
#[derive(Clone, Debug)]
pub struct Model {
    source: Source,
    weld: Weld,
    surface: Surface,
    tidy: TidyFaces,
}

/// Defects of a surface that a user should know about. None of them is an error: all are handled.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Defects {
    /// Number of vertices that no face uses.
    pub isolated_vertices: usize,
    /// Number of edges with one face.
    pub boundary_edges: usize,
    /// Number of edges with three or more faces.
    pub non_manifold_edges: usize,
    /// Number of vertices whose faces do not form one fan.
    pub non_manifold_vertices: usize,
    /// Number of edges whose two faces have inconsistent orientation: one of them is flipped.
    pub misoriented_edges: usize,
    /// Number of faces with fewer than three different vertices, which are left out of the surface.
    pub degenerate_faces: usize,
    /// Number of faces with the same vertices as an earlier one, which are left out of the surface.
    pub duplicate_faces: usize,
    /// Number of faces without area, which are kept.
    pub zero_area_faces: usize,
    /// Line of the first degenerate face in its file, counted from 1; `None` without such a face or without lines.
    pub first_degenerate_line: Option<u32>,
    /// Line of the first duplicate face in its file, counted from 1; `None` without such a face or without lines.
    pub first_duplicate_line: Option<u32>,
}

impl Model {
    /// Welds a mesh and builds its surface.
    pub fn new(source: impl Into<Source>, welding: Welding) -> Self {
        let source = source.into();
        let data = source.data();
        let weld = Weld::new(data.positions(), welding);
        let faces = data.faces().map(|corner| weld.vertex_of()[corner.position as usize]);
        let WeldedSurface { weld, surface, tidy } = WeldedSurface::connected(data.positions(), weld, faces);
        Self { source, weld, surface, tidy }
    }
    /// The mesh welded in another way, with these faces of its vertices and with their positions (#V×3, model units).
    pub(super) fn welded_as(&self, weld: Weld, faces: Ragged<Index>, positions: Vec<DVec3>) -> Self {
        let WeldedSurface { weld, surface, tidy } = WeldedSurface::of_vertices(positions, weld, faces);
        Self { source: self.source.clone(), weld, surface, tidy }
    }
    /// The mesh as it was given.
    pub fn source(&self) -> &Source {
        &self.source
    }
    /// Numbers and indices of the mesh as they were given.
    pub fn data(&self) -> &MeshData {
        self.source.data()
    }
    /// Vertex that each source vertex became.
    pub fn weld(&self) -> &Weld {
        &self.weld
    }
    /// Welded surface, without degenerate and duplicate faces.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }
    /// Index in the source of a face of the surface.
    pub fn source_face(&self, face: Index) -> Index {
        self.tidy.source_face(face)
    }
    /// Faces in the source with the same vertices as an earlier one, ascending; the surface lacks them.
    pub fn duplicate_faces(&self) -> &[Index] {
        &self.tidy.duplicate
    }
    /// Corner in the source of a corner of the surface.
    pub fn source_corner(&self, corner: Index) -> Corner {
        self.data().faces().items()[self.tidy.source_corner(corner) as usize]
    }
    /// Index of [`Self::source_corner`] among all corners of the source.
    #[cfg(feature = "unwrap")]
    pub(crate) fn source_corner_index(&self, corner: Index) -> Index {
        self.tidy.source_corner(corner)
    }
    /// Builds the UV layout of the surface.
    pub fn atlas(&self) -> Result<Atlas, AtlasError> {
        self.atlas_in(IVec2::ZERO)
    }
    /// Builds the UV layout of the surface with texture coordinates from the lower left corner of a tile.
    pub fn atlas_in(&self, tile: IVec2) -> Result<Atlas, AtlasError> {
        let corners = 0..self.surface.topology().faces().items().len() as Index;
        let corner_uvs = corners.map(|c| self.source_corner(c).uv());
        let uvs = self.data().uvs();
        if tile == IVec2::ZERO {
            return Atlas::new(&self.surface, uvs, corner_uvs);
        }
        let in_tile: Vec<DVec2> = uvs.iter().map(|uv| atlas::in_tile(*uv, tile).as_dvec2()).collect();
        Atlas::new(&self.surface, &in_tile, corner_uvs)
    }
    /// Tile of the texture coordinates of the mesh, by its lower left corner; see [`atlas::tile_of`].
    pub fn tile(&self) -> IVec2 {
        let data = self.data();
        let uvs = |face: &[Corner]| -> Vec<DVec2> {
            face.iter().filter_map(|corner| Some(data.uvs()[corner.uv()? as usize])).collect()
        };
        atlas::tile_of(data.faces().iter().map(uvs))
    }
    /// Unit normal of each vertex in single precision, as bake, carrier and shader use it; zero at vertices without one. #V×3
    pub fn displacement_normals(&self, source: NormalSource) -> Result<Vec<Vec3>, NoFileNormals> {
        Ok(self.vertex_normals(source)?.into_iter().map(DVec3::as_vec3).collect())
    }
    /// Unit normal of each vertex; zero at vertices without one. #V×3
    pub fn vertex_normals(&self, source: NormalSource) -> Result<Vec<DVec3>, NoFileNormals> {
        let weight = match source {
            NormalSource::File => return self.file_normals(),
            NormalSource::Uniform => FaceWeight::Uniform,
            NormalSource::Area => FaceWeight::Area,
            NormalSource::Angle => FaceWeight::Angle,
        };
        Ok(normals::vertex_normals(&self.surface, weight))
    }

    fn file_normals(&self) -> Result<Vec<DVec3>, NoFileNormals> {
        let named = |c: &Index| {
            let n = self.source_corner(*c).normal().map(|n| self.data().normals()[n as usize]);
            n.unwrap_or(DVec3::ZERO).normalize_or_zero()
        };
        let topology = self.surface.topology();
        let vertices = 0..topology.vertex_count() as Index;
        let mean = |v| topology.corners(v).iter().map(named).sum::<DVec3>().normalize_or_zero();
        let mut normals: Vec<DVec3> = vertices.map(mean).collect();
        if normals.iter().all(|n| *n == DVec3::ZERO) {
            return Err(NoFileNormals);
        }
        let computed = normals::vertex_normals(&self.surface, FaceWeight::Angle);
        for (n, computed) in normals.iter_mut().zip(computed) {
            if *n == DVec3::ZERO {
                *n = computed;
            }
        }
        Ok(normals)
    }

    /// Recomputes the normals of the source (#vn×3) for other positions of the vertices (#V×3, model units). Each becomes the
    /// angle-weighted unit mean over the faces whose corners name it, so hard edges stay hard and smooth ones smooth. A
    /// normal that no face names keeps its value.
    pub fn updated_file_normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let moved = self.surface.at(positions.to_vec());
        let faces = normals::face_normals(&moved);
        let mut sums = vec![DVec3::ZERO; self.data().normals().len()];
        for corner in 0..moved.topology().faces().items().len() as Index {
            if let Some(n) = self.source_corner(corner).normal() {
                let face = faces[moved.topology().face(corner) as usize];
                sums[n as usize] += face * normals::corner_angle(&moved, corner);
            }
        }
        let kept = self.data().normals();
        sums.iter().zip(kept).map(|(sum, kept)| sum.try_normalize().unwrap_or(*kept)).collect()
    }

    /// Counts the defects of the surface.
    pub fn defects(&self) -> Defects {
        let topology = self.surface.topology();
        let edges = |kind| (0..topology.edges().len() as Index).filter(|&e| topology.edge_kind(e) == kind).count();
        let line = |faces: &[Index]| faces.first().and_then(|&f| self.data().face_line(f));
        Defects {
            isolated_vertices: (0..topology.vertex_count() as Index).filter(|&v| topology.is_isolated(v)).count(),
            boundary_edges: edges(EdgeKind::Boundary),
            non_manifold_edges: edges(EdgeKind::NonManifold),
            non_manifold_vertices: topology.non_manifold_vertices().len(),
            misoriented_edges: edges(EdgeKind::Misoriented),
            degenerate_faces: self.tidy.degenerate.len(),
            duplicate_faces: self.tidy.duplicate.len(),
            zero_area_faces: self.surface.face_vectors().iter().filter(|n| **n == DVec3::ZERO).count(),
            first_degenerate_line: line(&self.tidy.degenerate),
            first_duplicate_line: line(&self.tidy.duplicate),
        }
    }
}
