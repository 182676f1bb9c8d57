//! A file understood: its welded surface, its normals, its layout, and what is wrong with it.

use crate::atlas::{Atlas, AtlasError};
#[cfg(doc)]
use crate::denoise::Along;
use crate::named;
use crate::normals::{self, FaceWeight};
use crate::obj::Obj;
use crate::ragged::{Index, Ragged};
use crate::surface::Surface;
use crate::topology::{self, EdgeKind, TidyFaces, Topology};
use crate::weld::{Weld, Welding};
use glam::{DVec3, Vec3};
use serde::Serialize;

named! {
    /// Where the normals that a map displaces along come from.
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
        /// Angle-weighted normals of the denoised surface.
        Denoised = "denoised",
        /// Angle-weighted normals of the denoised surface, tilted towards the displacement where its faces need it; for heights.
        Leaning = "leaning",
    }
}

/// The file has no usable `vn` line that a face names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the file has no normals (no face names a `vn`)")]
pub struct NoFileNormals;

/// A file and the surface in it.
#[derive(Clone, Debug)]
pub struct Model {
    obj: Obj,
    weld: Weld,
    surface: Surface,
    tidy: TidyFaces,
}

/// What a user should know about a surface; all of it is handled, none of it refused.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Defects {
    /// Vertices that no face uses.
    pub isolated_vertices: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with three faces or more.
    pub non_manifold_edges: usize,
    /// Vertices whose faces are not one fan.
    pub non_manifold_vertices: usize,
    /// Edges whose two faces disagree about which side is outside.
    pub misoriented_edges: usize,
    /// Faces with fewer than three different vertices; left out of the surface.
    pub degenerate_faces: usize,
    /// Faces that repeat an earlier one; left out of the surface.
    pub duplicate_faces: usize,
    /// Faces without area, kept.
    pub zero_area_faces: usize,
    /// Line of the first degenerate face.
    pub first_degenerate_line: Option<u32>,
    /// Line of the first duplicate face.
    pub first_duplicate_line: Option<u32>,
}

impl Model {
    /// Welds a file and builds its surface.
    pub fn new(obj: Obj, welding: Welding) -> Self {
        let weld = Weld::new(obj.positions(), welding);
        let vertex = |corner: &crate::obj::Corner| weld.vertex_of()[corner.position as usize];
        let mut faces = Ragged::default();
        for face in obj.faces().iter() {
            faces.push(face.iter().map(vertex));
        }
        let count = weld.first().len();
        let mut tidy = topology::tidy(count, &faces);
        let topology = Topology::new(count, std::mem::take(&mut tidy.faces));
        let positions = weld.first().iter().map(|&v| obj.positions()[v as usize]).collect();
        Self { surface: Surface::new(topology, positions), obj, weld, tidy }
    }
    /// The file.
    pub fn obj(&self) -> &Obj {
        &self.obj
    }
    /// Vertices behind the `v` lines.
    pub fn weld(&self) -> &Weld {
        &self.weld
    }
    /// The welded surface without degenerate and duplicate faces.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }
    /// Face of the file behind a face of the surface.
    pub fn source_face(&self, face: Index) -> Index {
        self.tidy.source_faces[face as usize]
    }
    /// Corner of the file behind a corner of the surface.
    pub fn source_corner(&self, corner: Index) -> crate::obj::Corner {
        self.obj.faces().items()[self.tidy.source_corners[corner as usize] as usize]
    }
    /// The same corner as its place among all corners of the file.
    #[cfg(feature = "unwrap")]
    pub(crate) fn source_corner_index(&self, corner: Index) -> Index {
        self.tidy.source_corners[corner as usize]
    }
    /// The UV layout.
    pub fn atlas(&self) -> Result<Atlas, AtlasError> {
        let corners = 0..self.surface.topology().faces().items().len() as Index;
        Atlas::new(&self.surface, self.obj.uvs(), corners.map(|c| self.source_corner(c).uv()))
    }
    /// Normals of the vertices in single precision, as baker, carrier and shader use them. #V×3
    pub fn displacement_normals(&self, source: NormalSource, deltas: &[DVec3]) -> Result<Vec<Vec3>, NoFileNormals> {
        Ok(self.vertex_normals(source, deltas)?.into_iter().map(DVec3::as_vec3).collect())
    }
    /// Unit normal of each vertex; zero where there is none. δ (#V×3, model units) says where the denoised surface is. Normals
    /// that lean do so for heights, which are fitted along with them; here they are as before. #V×3
    pub fn vertex_normals(&self, source: NormalSource, deltas: &[DVec3]) -> Result<Vec<DVec3>, NoFileNormals> {
        let weight = match source {
            NormalSource::File => return self.file_normals(),
            NormalSource::Uniform => FaceWeight::Uniform,
            NormalSource::Area => FaceWeight::Area,
            NormalSource::Angle => FaceWeight::Angle,
            NormalSource::Denoised | NormalSource::Leaning => {
                let places = self.surface.positions().iter().zip(deltas).map(|(p, delta)| *p - *delta).collect();
                return Ok(normals::vertex_normals(&self.surface.at(places), FaceWeight::Angle));
            }
        };
        Ok(normals::vertex_normals(&self.surface, weight))
    }

    fn file_normals(&self) -> Result<Vec<DVec3>, NoFileNormals> {
        let named = |c: &Index| {
            let n = self.source_corner(*c).normal().map(|n| self.obj.normals()[n as usize]);
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

    /// New values for the `vn` lines (#vn) that fit another place of the vertices (#V×3): each becomes the
    /// angle-weighted mean over the faces whose corners name it, so hard edges and shared normals stay what they are.
    /// A line that no face names keeps its value.
    pub fn updated_file_normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let moved = self.surface.at(positions.to_vec());
        let faces = normals::face_normals(&moved);
        let mut sums = vec![DVec3::ZERO; self.obj.normals().len()];
        for corner in 0..moved.topology().faces().items().len() as Index {
            if let Some(n) = self.source_corner(corner).normal() {
                let face = faces[moved.topology().face(corner) as usize];
                sums[n as usize] += face * normals::corner_angle(&moved, corner);
            }
        }
        let kept = self.obj.normals();
        sums.iter().zip(kept).map(|(sum, kept)| sum.try_normalize().unwrap_or(*kept)).collect()
    }

    /// Counts what is odd about the surface.
    pub fn defects(&self) -> Defects {
        let topology = self.surface.topology();
        let edges = |kind| (0..topology.edges().len() as Index).filter(|&e| topology.edge_kind(e) == kind).count();
        let line = |faces: &[Index]| faces.first().map(|&f| self.obj.face_line(f));
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
