//! Wedges, the vertices of a glTF mesh: a source vertex and texture coordinates that meet at some corner of the surface.

use crate::mesh::jagged::{Index, Ragged};
use crate::source::model::Model;

/// Distinct combinations of source vertex, texture coordinates and page, #W in number, in the order of the source.
pub(super) struct Wedges {
    /// Source vertex of each wedge. #W, ascending
    pub(super) sources: Vec<Index>,
    /// Index of each wedge's texture coordinates; `None` if the corners have none. #W
    pub(super) uvs: Vec<Option<Index>>,
    /// Page of the faces of each wedge. #W
    pub(super) pages: Vec<Index>,
    /// Wedge of each corner of the surface.
    of_corner: Vec<Index>,
}

impl Wedges {
    /// Collects the wedges at the corners of the surface. `page_of` gives the page of a face of the source.
    pub(super) fn new(model: &Model, page_of: &dyn Fn(Index) -> Index) -> Self {
        let corners = model.surface().topology().faces().items().len();
        let named = (0..corners as Index).map(|c| {
            let corner = model.source_corner(c);
            let face = model.source_face(model.surface().topology().face(c));
            (corner.position, ((corner.uv(), page_of(face)), c))
        });
        // Grouped by source vertex, equal pairs are found among a few corners, without sorting all of them.
        let mut by_source = Ragged::group(model.data().positions().len(), named);
        by_source.for_each_mut(<[_]>::sort_unstable);
        let mut wedges = Self { sources: Vec::new(), uvs: Vec::new(), pages: Vec::new(), of_corner: vec![0; corners] };
        for (source, corners) in (0..).zip(by_source.iter()) {
            for same in corners.chunk_by(|a, b| a.0 == b.0) {
                for &(_, corner) in same {
                    wedges.of_corner[corner as usize] = wedges.sources.len() as Index;
                }
                wedges.sources.push(source);
                wedges.uvs.push(same[0].0.0);
                wedges.pages.push(same[0].0.1);
            }
        }
        wedges
    }
    /// Number of wedges.
    pub(super) fn len(&self) -> usize {
        self.sources.len()
    }
    /// True if any corner has texture coordinates.
    pub(super) fn have_uvs(&self) -> bool {
        self.uvs.iter().any(Option::is_some)
    }
    /// Wedges of the surface's triangles, grouped by page and then by the material of their face. Of the #M + 1 lists of a page list 0
    /// has no material, list m + 1 has material m, and within a list triangles keep the order of the faces.
    pub(super) fn triangles(&self, model: &Model) -> Ragged<[Index; 3]> {
        let surface = model.surface();
        let lists = model.data().materials().len() as Index + 1;
        let triangles = surface.triangle_corners().iter().map(|corners| {
            let face = model.source_face(surface.topology().face(corners[0]));
            let list = model.data().face_material(face).map_or(0, |material| material + 1);
            let corners = corners.map(|c| self.of_corner[c as usize]);
            (self.pages[corners[0] as usize] * lists + list, corners)
        });
        let pages = self.pages.iter().max().map_or(1, |page| page + 1);
        Ragged::group(pages as usize * lists as usize, triangles)
    }
}
