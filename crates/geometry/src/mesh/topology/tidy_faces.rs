//! Faces that are fit for a topology, made of any faces.

use super::corner_faces::CornerFaces;
use super::{CHUNK, Topology};
use crate::mesh::jagged::{Index, Ragged};
use rayon::prelude::*;

/// Faces that satisfy the invariant of [`Topology`], and the faces of the input that had to be left out.
#[derive(Clone, Debug, Default)]
pub struct TidyFaces {
    /// Vertices of each face. #F lists
    pub faces: Ragged<Index>,
    /// Faces of the input with fewer than three different vertices in a row, which were left out.
    pub degenerate: Vec<Index>,
    /// Faces of the input with the same vertices as an earlier one, which were left out: a second layer would count twice in
    /// a normal, or cancel it if it is flipped.
    pub duplicate: Vec<Index>,
    /// Face and corners of the input for each face and each corner; `None` if all are as in the input.
    source: Option<(Vec<Index>, Vec<Index>)>,
    /// Corners of each vertex, if they have not changed.
    vertex_corners: Option<Ragged<Index>>,
}

impl TidyFaces {
    /// Face of the input for a face.
    pub fn source_face(&self, face: Index) -> Index {
        self.source.as_ref().map_or(face, |(faces, _)| faces[face as usize])
    }
    /// Corner of the input for a corner of [`Self::faces`].
    pub fn source_corner(&self, corner: Index) -> Index {
        self.source.as_ref().map_or(corner, |(_, corners)| corners[corner as usize])
    }
    /// Builds the connectivity of the faces over `vertex_count` vertices, as many as they were made tidy with. It takes the faces away.
    pub fn connect(&mut self, vertex_count: usize) -> Topology {
        let faces = std::mem::take(&mut self.faces);
        match self.vertex_corners.take() {
            Some(corners) => Topology::with_corners(vertex_count, faces, corners),
            None => Topology::new(vertex_count, faces),
        }
    }
}

/// Drops repeated corners, collapsed faces, and second layers of faces.
///
/// # Panics
/// If a face names a vertex that does not exist.
pub fn tidy(vertex_count: usize, input: Ragged<Index>) -> TidyFaces {
    let vertex_corners = Ragged::by_key(vertex_count, input.items());
    let duplicate = duplicates(&vertex_corners, &input);
    let all = (0..input.len() as Index).into_par_iter();
    let is_clean = |face: &[Index]| kept(face).count() == face.len() && has_three_vertices(face);
    if duplicate.is_empty() && all.all(|f| is_clean(input.get(f))) {
        return TidyFaces { faces: input, vertex_corners: Some(vertex_corners), ..TidyFaces::default() };
    }
    let mut out = TidyFaces::default();
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for f in 0..input.len() as Index {
        let first = input.range(f).start as Index;
        let face = input.get(f);
        if kept(face).count() < 3 || !has_three_vertices(face) {
            out.degenerate.push(f);
        } else if duplicate.binary_search(&f).is_ok() {
            out.duplicate.push(f);
        } else {
            out.faces.push(kept(face).map(|k| face[k]));
            corners.extend(kept(face).map(|k| first + k as Index));
            faces.push(f);
        }
    }
    out.source = Some((faces, corners));
    out
}

/// Returns false for a face that goes to and fro between two vertices.
fn has_three_vertices(face: &[Index]) -> bool {
    let second = face.iter().find(|&&v| v != face[0]);
    second.is_some_and(|&second| face.iter().any(|&v| v != face[0] && v != second))
}

/// Corners of a face that do not repeat the previous one.
pub(super) fn kept(face: &[Index]) -> impl Iterator<Item = usize> {
    (0..face.len()).filter(|&k| face[k] != face[if k == 0 { face.len() } else { k } - 1])
}

/// Faces whose vertices are those of an earlier face, ascending; `vertex_corners` are the corners of each vertex.
fn duplicates(vertex_corners: &Ragged<Index>, faces: &Ragged<Index>) -> Vec<Index> {
    let corner_faces = CornerFaces::of(faces);
    // A sum over the vertices tells almost all faces apart without sorting any. Their bits are mixed (Stafford's variant 13 of the
    // finaliser of MurmurHash3), because the sums of the numbers themselves are equal for as many faces as one likes.
    let mixed = |&v: &Index| {
        let mut x = u64::from(v).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    };
    let vertices = |f: Index| kept(faces.get(f)).map(move |k| &faces.get(f)[k]);
    let sum = |f: Index| vertices(f).map(mixed).fold(0u64, u64::wrapping_add);
    let sorted = |f: Index| {
        let mut sorted: Vec<_> = vertices(f).collect();
        sorted.sort_unstable();
        sorted
    };
    // Faces with the same vertices meet at the lowest of them.
    let at_lowest = |v: Index, keyed: &mut Vec<(u64, Index)>| {
        keyed.clear();
        let around = vertex_corners.get(v).iter().map(|&c| corner_faces.get(c));
        keyed.extend(around.filter(|&f| faces.get(f).iter().all(|&other| other >= v)).map(|f| (sum(f), f)));
        keyed.sort_unstable();
        // A face may pass a vertex twice.
        keyed.dedup();
        let mut found = Vec::new();
        for alike in keyed.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            let is_known = |k: usize, f| alike[..k].iter().any(|e| sorted(e.1) == sorted(f));
            found.extend(alike.iter().enumerate().filter(|(k, (_, f))| is_known(*k, *f)).map(|(_, (_, f))| *f));
        }
        found
    };
    let all = (0..vertex_corners.len() as Index).into_par_iter().with_min_len(CHUNK);
    let mut duplicates: Vec<Index> = all.map_init(Vec::new, |keyed, v| at_lowest(v, keyed)).flatten_iter().collect();
    duplicates.par_sort_unstable();
    duplicates
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tidying_keeps_what_can_be_kept() {
        let input: Ragged<Index> =
            [vec![0, 1, 2, 2], vec![3, 3, 4], vec![2, 0, 1], vec![0, 2, 1], vec![1, 3, 2], vec![0, 1, 0, 1]]
                .into_iter()
                .collect();
        let tidy = tidy(5, input);
        assert_eq!(tidy.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[1, 3, 2]]);
        assert_eq!(tidy.degenerate, [1, 5]);
        assert_eq!(tidy.duplicate, [2, 3]);
        assert_eq!([0, 1].map(|f| tidy.source_face(f)), [0, 4]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|c| tidy.source_corner(c)), [0, 1, 2, 13, 14, 15]);
    }

    #[test]
    fn faces_whose_vertices_have_the_same_sum_are_told_apart() {
        // To compare each with all before it would take half a billion comparisons.
        let count = 60_000;
        let faces: Ragged<Index> = (1..count / 2).map(|k| vec![0, k, count - k]).collect();
        let tidy = tidy(count as usize, faces);
        assert_eq!((tidy.faces.len(), tidy.duplicate.len()), (count as usize / 2 - 1, 0));
    }
}
