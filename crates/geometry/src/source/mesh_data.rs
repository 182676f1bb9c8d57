//! Mesh data as every reader returns it: numbers and indices, whatever their format.

use crate::mesh::jagged::{Index, Ragged};
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;

/// Indices that one corner of a face names, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index of the source vertex.
    pub position: Index,
    uv: Index,
    normal: Index,
}

impl Corner {
    const ABSENT: Index = Index::MAX;

    /// Builds a corner from the index of its source vertex and, if it has them, of its texture coordinate and normal.
    pub fn new(position: Index, uv: Option<Index>, normal: Option<Index>) -> Self {
        Self { position, uv: uv.unwrap_or(Self::ABSENT), normal: normal.unwrap_or(Self::ABSENT) }
    }
    /// Index of the texture coordinate; `None` if the corner names none.
    pub fn uv(self) -> Option<Index> {
        (self.uv != Self::ABSENT).then_some(self.uv)
    }
    /// Index of the normal; `None` if the corner names none.
    pub fn normal(self) -> Option<Index> {
        (self.normal != Self::ABSENT).then_some(self.normal)
    }
}

/// Consecutive faces of one material, which end where the next run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaterialRun {
    /// Index of the first face.
    pub(crate) first_face: Index,
    /// Index of the material in [`MeshData::materials`]; `None` for faces without a material.
    pub(crate) material: Option<Index>,
}

/// Positions, faces, and the attributes that corners and faces name.
///
/// A source vertex is one position as the source lists it; welding ([`weld`](crate::mesh::weld)) merges them into vertices.
///
/// Invariant: positions are finite (see [`Self::unplaced`]), faces have at least three corners, indices are in range, and there are fewer than
/// 2³² − 1 elements of each kind. Readers guarantee it; arrays come through the checks of
/// [`Arrays`](crate::source::Arrays).
#[derive(Clone, Debug, Default)]
pub struct MeshData {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) colours: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<DVec2>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) faces: Ragged<Corner>,
    pub(crate) face_lines: Vec<u32>,
    pub(crate) materials: Vec<Vec<u8>>,
    pub(crate) material_runs: Vec<MaterialRun>,
    pub(crate) unplaced: Vec<Index>,
}

impl MeshData {
    /// Positions of the source vertices. #v×3, model units
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Colours of the source vertices: red, green and blue, 0..=1, encoded as sRGB; empty unless each has one. #v×3
    pub fn colours(&self) -> &[[f32; 3]] {
        &self.colours
    }
    /// Texture coordinates, v up; those of a file may be NaN, but no corner names such. #vt×2
    pub fn uvs(&self) -> &[DVec2] {
        &self.uvs
    }
    /// Normals as in the source, of any length; those of a file may be NaN. #vn×3
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }
    /// Corners of each face, counter-clockwise seen from outside. #f
    pub fn faces(&self) -> &Ragged<Corner> {
        &self.faces
    }
    /// Line of a face in its file, counted from 1; `None` if the source has no lines.
    pub fn face_line(&self, face: Index) -> Option<u32> {
        self.face_lines.get(face as usize).copied()
    }
    /// Names of the materials in the order of first use; bytes, because OBJ names no encoding.
    pub fn materials(&self) -> &[Vec<u8>] {
        &self.materials
    }
    /// Index of the material of a face in [`Self::materials`]; `None` if the face has no material.
    pub fn face_material(&self, face: Index) -> Option<Index> {
        let count = self.material_runs.partition_point(|run| run.first_face <= face);
        self.material_runs[count.checked_sub(1)?].material
    }
    /// Returns true if some face has no material.
    pub fn has_faces_without_material(&self) -> bool {
        let count = self.faces.len() as Index;
        let first = self.material_runs.first().map_or(count, |run| run.first_face);
        first > 0 || self.material_runs.iter().any(|run| run.material.is_none() && run.first_face < count)
    }

    /// Source vertices whose position in the file is not finite, in ascending order. No face uses them. They lie at the position of
    /// a vertex that a face uses, and writers leave them as they are.
    pub fn unplaced(&self) -> &[Index] {
        &self.unplaced
    }
    /// Moves source vertices that are not finite to the first corner of the first face. Fails with a vertex that a face uses.
    pub(crate) fn place_unused(&mut self) -> Result<(), Index> {
        if self.positions.par_iter().all(|p| p.is_finite()) {
            return Ok(());
        }
        let absent = |v: &Index| !self.positions[*v as usize].is_finite();
        let unplaced: Vec<Index> = (0..self.positions.len() as Index).filter(absent).collect();
        if let Some(corner) = self.faces.items().iter().find(|corner| absent(&corner.position)) {
            return Err(corner.position);
        }
        let place = self.faces.items().first().map_or(DVec3::ZERO, |corner| self.positions[corner.position as usize]);
        unplaced.iter().for_each(|&v| self.positions[v as usize] = place);
        self.unplaced = unplaced;
        Ok(())
    }
    /// Takes texture coordinates and normals from the corners that name none that exists, or texture coordinates that are not
    /// finite. Returns the face of each corner that lost something, in ascending order.
    pub(crate) fn drop_broken_attributes(&mut self) -> Vec<Index> {
        let (uvs, normals) = (&self.uvs, self.normals.len());
        let is_good_uv = |uv: &Index| uvs.get(*uv as usize).is_some_and(|uv| uv.is_finite());
        let is_good =
            |c: &Corner| c.uv().is_none_or(|uv| is_good_uv(&uv)) && c.normal().is_none_or(|n| (n as usize) < normals);
        if self.faces.items().par_iter().all(is_good) {
            return Vec::new();
        }
        let faces = (0..).zip(self.faces.iter());
        let broken: Vec<Index> =
            faces.flat_map(|(f, face)| face.iter().filter(|c| !is_good(c)).map(move |_| f)).collect();
        for c in self.faces.items_mut() {
            let normal = c.normal().filter(|n| (*n as usize) < normals);
            *c = Corner::new(c.position, c.uv().filter(&is_good_uv), normal);
        }
        broken
    }
    /// Returns whether writers should give a source vertex another position: it differs, be it in the sign
    /// of a zero, and the vertex has one.
    pub(crate) fn moves(&self, vertex: Index, to: DVec3) -> bool {
        let bits = |p: DVec3| p.to_array().map(f64::to_bits);
        bits(self.positions[vertex as usize]) != bits(to) && self.unplaced.binary_search(&vertex).is_err()
    }

    /// Returns the mesh with other texture coordinates (#vt×2, v up); `corners` has the index of one for each corner (#c).
    ///
    /// # Panics
    /// If there is not one index for each corner, or one is out of range.
    #[must_use]
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Self {
        assert_eq!(corners.len(), self.faces.items().len(), "one texture coordinate for each corner");
        assert!(corners.iter().all(|&uv| (uv as usize) < uvs.len()), "indices of texture coordinates are in range");
        let mut named = corners.iter();
        let mut faces = Ragged::default();
        for face in self.faces.iter() {
            faces.push(face.iter().zip(&mut named).map(|(c, &uv)| Corner::new(c.position, Some(uv), c.normal())));
        }
        Self { uvs: uvs.iter().map(|uv| uv.as_dvec2()).collect(), faces, ..self.clone() }
    }
}
