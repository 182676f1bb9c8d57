//! Faces that are the backs of others: leaves and sheets whose two sides are both in the file.
//!
//! Welding makes one vertex of the source vertices at a place, and the surface has one of the two faces, so that denoising keeps the
//! sides together. A map can serve both, if the back has source vertices of its own: these are displaced along the opposite normals by
//! the opposite heights.
//!
//! ```
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{backs::Backs, model::Model, obj::{Obj, ObjError}};
//!
//! // A triangle whose back has `v` lines of its own.
//! let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 6 5 4\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let backs = Backs::of(&model);
//! assert_eq!((backs.pairs(), backs.vertices()), (&[[1, 0]][..], &[3, 4, 5][..]));
//! let both = backs.both_sides(&model);
//! assert_eq!((model.surface().topology().faces().len(), both.model.surface().topology().faces().len()), (1, 2));
//! # Ok::<(), ObjError>(())
//! ```

use crate::mesh::jagged::{Index, Ragged};
use crate::source::Corner;
use crate::source::model::Model;
use rustc_hash::FxHashMap;

/// Faces of a mesh that are the backs of others, and those source vertices that only they name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Backs {
    pairs: Vec<[Index; 2]>,
    vertices: Vec<Index>,
}

/// A model in which the backs that have source vertices of their own have vertices and faces of their own.
#[derive(Clone, Debug)]
pub struct BothSides {
    /// The model, whose surface has both sides.
    pub model: Model,
    /// Vertex of the model with one side for each vertex. #V
    front: Vec<Index>,
    /// True for vertices of backs. #V
    is_back: Vec<bool>,
}

impl Backs {
    /// Finds the faces that a surface lacks because they have the vertices of one that it has, in the opposite order.
    pub fn of(model: &Model) -> Self {
        let duplicates = model.duplicate_faces();
        if duplicates.is_empty() {
            return Self::default();
        }
        let surface = (0..).zip(model.surface().topology().faces().iter());
        let fronts: FxHashMap<Vec<Index>, Index> =
            surface.map(|(f, face)| (cycle(face.to_vec()), model.source_face(f))).collect();
        let pair = |&face: &Index| {
            let mut turned = vertices_of(model, face);
            turned.reverse();
            Some([face, *fronts.get(&cycle(turned))?])
        };
        let mut backs = Self { pairs: duplicates.iter().filter_map(pair).collect(), vertices: Vec::new() };
        backs.vertices = backs.own_vertices(model);
        backs
    }

    /// Returns these backs with another list of source vertices, ascending: a back that names no others has a side of its own.
    #[must_use]
    pub fn with_vertices(self, vertices: Vec<Index>) -> Self {
        Self { vertices, ..self }
    }

    /// Pairs of a back and its front, by their indices in the source, ascending.
    pub fn pairs(&self) -> &[[Index; 2]] {
        &self.pairs
    }
    /// Source vertices of the backs that have a side of their own, ascending. No other face names them, except backs that share some of
    /// their source vertices with fronts.
    pub fn vertices(&self) -> &[Index] {
        &self.vertices
    }
    /// Returns whether a back has source vertices of its own at all corners.
    pub fn has_own_side(&self, model: &Model, back: Index) -> bool {
        let corners = model.data().faces().get(back);
        corners.iter().all(|corner| self.vertices.binary_search(&corner.position).is_ok())
    }

    /// Source vertices that backs alone name, of the backs that have no others.
    fn own_vertices(&self, model: &Model) -> Vec<Index> {
        let faces = model.data().faces();
        let is_back = |face: Index| self.pairs.binary_search_by_key(&face, |pair| pair[0]).is_ok();
        let mut is_shared = vec![false; model.data().positions().len()];
        let surface = 0..model.surface().topology().faces().len() as Index;
        let others = model.duplicate_faces().iter().copied().filter(|face| !is_back(*face));
        for face in surface.map(|f| model.source_face(f)).chain(others) {
            faces.get(face).iter().for_each(|corner| is_shared[corner.position as usize] = true);
        }
        let corners = self.pairs.iter().map(|pair| faces.get(pair[0]));
        let own = corners.filter(|corners| corners.iter().all(|corner| !is_shared[corner.position as usize]));
        let mut own: Vec<Index> = own.flatten().map(|corner| corner.position).collect();
        own.sort_unstable();
        own.dedup();
        own
    }

    /// Makes the model with both sides from the one with fronts only, from which these backs are.
    pub fn both_sides(&self, model: &Model) -> BothSides {
        let vertex_of = model.weld().vertex_of();
        let mut is_own = vec![false; vertex_of.len()];
        for v in &self.vertices {
            if let Some(own) = is_own.get_mut(*v as usize) {
                *own = true;
            }
        }
        let weld = model.weld().split(&is_own);
        // Source vertices of fronts by the vertices of the given model, for backs that share some with theirs.
        let mut of_front = vec![Index::MAX; model.weld().first().len()];
        for ((own, v), split) in is_own.iter().zip(vertex_of).zip(weld.vertex_of()) {
            if !own {
                of_front[*v as usize] = *split;
            }
        }
        let mut has_side = vec![false; model.data().faces().len()];
        let own = self.pairs.iter().map(|pair| pair[0]).filter(|back| self.has_own_side(model, *back));
        own.for_each(|back| has_side[back as usize] = true);
        let vertex = |corner: &Corner, has_side: bool| {
            let own = weld.vertex_of()[corner.position as usize];
            let front = of_front[vertex_of[corner.position as usize] as usize];
            // All source vertices of a vertex may be listed, if the list is not that of this mesh.
            if has_side || front == Index::MAX { own } else { front }
        };
        let mut faces = Ragged::default();
        for (face, has_side) in model.data().faces().iter().zip(has_side) {
            faces.push(face.iter().map(|corner| vertex(corner, has_side)));
        }
        let front: Vec<Index> = weld.first().iter().map(|v| vertex_of[*v as usize]).collect();
        let is_back = weld.first().iter().map(|v| is_own[*v as usize]).collect();
        let positions = front.iter().map(|v| model.surface().positions()[*v as usize]).collect();
        BothSides { model: model.welded_as(weld, faces, positions), front, is_back }
    }
}

impl Model {
    /// The model in which backs whose source vertices are all in a list, which ascends, have a side of their own; `None` if the list is
    /// empty.
    pub fn with_backs(&self, vertices: Vec<Index>) -> Option<BothSides> {
        (!vertices.is_empty()).then(|| Backs::of(self).with_vertices(vertices).both_sides(self))
    }
}

impl BothSides {
    /// Values of the vertices for those of the model with fronts only.
    pub fn same<T: Copy>(&self, of_fronts: &[T]) -> Vec<T> {
        self.front.iter().map(|v| of_fronts[*v as usize]).collect()
    }
    /// Values of the vertices for those of the model with fronts only, with the opposite ones on backs.
    pub fn turned<T: Copy + std::ops::Neg<Output = T>>(&self, of_fronts: &[T]) -> Vec<T> {
        let value = |(v, is_back): (&Index, &bool)| {
            let value = of_fronts[*v as usize];
            if *is_back { -value } else { value }
        };
        self.front.iter().zip(&self.is_back).map(value).collect()
    }
}

/// Vertices of a face of the source, without those that repeat the one before.
fn vertices_of(model: &Model, face: Index) -> Vec<Index> {
    let corners = model.data().faces().get(face);
    let mut vertices: Vec<Index> =
        corners.iter().map(|corner| model.weld().vertex_of()[corner.position as usize]).collect();
    vertices.dedup();
    while vertices.len() > 1 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    vertices
}

/// Vertices of a face from the lowest on. A face that passes a vertex twice has one of its cycles.
fn cycle(mut vertices: Vec<Index>) -> Vec<Index> {
    let rotations = (0..vertices.len()).filter(|k| Some(&vertices[*k]) == vertices.iter().min());
    let rotated = rotations.map(|k| [&vertices[k..], &vertices[..k]].concat());
    if let Some(least) = rotated.min() {
        vertices = least;
    }
    vertices
}
