//! Which face each corner belongs to.

use crate::mesh::jagged::{Index, Ragged};

/// Face of each corner.
#[derive(Clone, Debug)]
pub(super) enum CornerFaces {
    /// All faces are triangles, so a corner says by itself which face it has.
    Triangles,
    Polygons(Vec<Index>),
}

impl CornerFaces {
    pub(super) fn of<T: Sync>(faces: &Ragged<T>) -> Self {
        if faces.items().len() == 3 * faces.len() && faces.iter().all(|face| face.len() == 3) {
            return Self::Triangles;
        }
        let of_face = |f: Index| faces.range(f).map(move |_| f);
        Self::Polygons((0..faces.len() as Index).flat_map(of_face).collect())
    }
    pub(super) fn get(&self, corner: Index) -> Index {
        match self {
            Self::Triangles => corner / 3,
            Self::Polygons(faces) => faces[corner as usize],
        }
    }
}
