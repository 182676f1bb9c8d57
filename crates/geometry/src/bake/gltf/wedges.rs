//! Wedges, the vertices of a glTF mesh: a source vertex and texture coordinates that meet at some corner of a face.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::polygon;
use crate::source::Corner;
use crate::source::backs::Backs;
use crate::source::model::Model;
use glam::DVec3;

/// Visible sides of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// Both sides.
    Both,
    /// One side, because the other side is that of another face at the same place.
    One,
    /// One side of a back that is displaced along the normals of its front, whose opposites it has for its light.
    OneTurned,
}

/// Number of kinds of [`Sides`].
const KINDS: Index = 3;

/// Triangles of a primitive: those of a page with one material and some visible sides.
pub(super) struct Group<'a> {
    pub(super) page: Index,
    /// Material of the source; `None` without one.
    pub(super) material: Option<Index>,
    pub(super) sides: Sides,
    /// Wedges of the triangles.
    pub(super) triangles: &'a [[Index; 3]],
}

/// Distinct combinations of source vertex, texture coordinates and page, #W in number, in the order of the source.
pub(super) struct Wedges {
    /// Source vertex of each wedge. #W, ascending
    pub(super) sources: Vec<Index>,
    /// Index of each wedge's texture coordinates; `None` if the corners have none. #W
    pub(super) uvs: Vec<Option<Index>>,
    /// Page of the faces of each wedge. #W
    pub(super) pages: Vec<Index>,
    /// True for wedges of backs that are displaced along the normals of their fronts, and have the opposite ones. #W
    pub(super) is_turned: Vec<bool>,
    /// Wedges of the triangles, grouped by page, material and visible sides.
    triangles: Ragged<[Index; 3]>,
    /// Number of lists of a page, one for each material and one without.
    lists: Index,
}

/// A back that the surface lacks, because it shares source vertices or texels with its front.
struct SharedBack {
    face: Index,
    /// Face of the source in front.
    front: Index,
    /// Corners with the source vertices along whose normals they are displaced.
    corners: Vec<Corner>,
    /// Corners of the triangles.
    triangles: Vec<[usize; 3]>,
}

impl Wedges {
    /// Collects the wedges at the corners of the surface, and of the backs that it lacks. `page_of` gives the page of a face of the source.
    pub(super) fn new(model: &Model, backs: &Backs, page_of: &dyn Fn(Index) -> Index) -> Self {
        let surface = model.surface();
        let corners = surface.topology().faces().items().len();
        let shared: Vec<SharedBack> =
            backs.pairs().iter().filter_map(|pair| shared_back(model, backs, *pair)).collect();
        let face_of = |c: Index| model.source_face(surface.topology().face(c));
        let of_surface = (0..corners as Index).map(|c| (model.source_corner(c), page_of(face_of(c)), false));
        let of_backs = shared.iter().flat_map(|b| b.corners.iter().map(|corner| (*corner, page_of(b.front), true)));
        let all: Vec<_> = of_surface.chain(of_backs).collect();
        let named = (0..)
            .zip(&all)
            .map(|(c, (corner, page, is_turned))| (corner.position, ((corner.uv(), *page, *is_turned), c)));
        // Grouped by source vertex, equal pairs are found among a few corners, without sorting all of them.
        let mut by_source = Ragged::group(model.data().positions().len(), named);
        by_source.for_each_mut(<[_]>::sort_unstable);
        let mut wedges = Self {
            sources: Vec::new(),
            uvs: Vec::new(),
            pages: Vec::new(),
            is_turned: Vec::new(),
            triangles: Ragged::default(),
            lists: model.data().materials().len() as Index + 1,
        };
        let mut of_corner = vec![0; all.len()];
        for (source, corners) in (0..).zip(by_source.iter()) {
            for same in corners.chunk_by(|a, b| a.0 == b.0) {
                for &(_, corner) in same {
                    of_corner[corner as usize] = wedges.sources.len() as Index;
                }
                let (uv, page, is_turned) = same[0].0;
                wedges.sources.push(source);
                wedges.uvs.push(uv);
                wedges.pages.push(page);
                wedges.is_turned.push(is_turned);
            }
        }
        wedges.triangles = wedges.grouped(model, backs, &shared, &of_corner);
        wedges
    }

    /// Groups the triangles; within a group those of the surface keep its order, and those of backs follow. `of_corner` are the wedges of the
    /// corners of the surface and then of the backs.
    fn grouped(&self, model: &Model, backs: &Backs, shared: &[SharedBack], of_corner: &[Index]) -> Ragged<[Index; 3]> {
        let surface = model.surface();
        let mut has_other_side = vec![false; model.data().faces().len()];
        backs.pairs().as_flattened().iter().for_each(|face| has_other_side[*face as usize] = true);
        let list = |face: Index, wedges: [Index; 3], sides: Sides| {
            let material = model.data().face_material(face).map_or(0, |material| material + 1);
            let page = self.pages[wedges[0] as usize];
            ((page * self.lists + material) * KINDS + sides as Index, wedges)
        };
        let of_surface = surface.triangle_corners().iter().map(|corners| {
            let face = model.source_face(surface.topology().face(corners[0]));
            let sides = if has_other_side[face as usize] { Sides::One } else { Sides::Both };
            list(face, corners.map(|c| of_corner[c as usize]), sides)
        });
        let mut first = surface.topology().faces().items().len();
        let mut of_backs = Vec::new();
        for back in shared {
            let wedges = |t: &[usize; 3]| t.map(|k| of_corner[first + k]);
            of_backs.extend(back.triangles.iter().map(|t| list(back.face, wedges(t), Sides::OneTurned)));
            first += back.corners.len();
        }
        let pages = self.pages.iter().max().map_or(1, |page| page + 1);
        let groups = (pages * self.lists * KINDS) as usize;
        Ragged::group(groups, of_surface.chain(of_backs).collect::<Vec<_>>().into_iter())
    }

    /// Number of wedges.
    pub(super) fn len(&self) -> usize {
        self.sources.len()
    }
    /// True if any corner has texture coordinates.
    pub(super) fn have_uvs(&self) -> bool {
        self.uvs.iter().any(Option::is_some)
    }
    /// Number of triangles.
    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.items().len()
    }
    /// Groups of triangles that are not empty, by page, then material, those without one first, then visible sides.
    pub(super) fn groups(&self) -> impl Iterator<Item = Group<'_>> {
        let group = |(key, triangles): (Index, _)| {
            let (list, sides) = (key / KINDS, [Sides::Both, Sides::One, Sides::OneTurned][(key % KINDS) as usize]);
            Group { page: list / self.lists, material: Index::checked_sub(list % self.lists, 1), sides, triangles }
        };
        (0..).zip(self.triangles.iter()).filter(|(_, triangles)| !triangles.is_empty()).map(group)
    }
}

/// A back with the source vertices of its own or of its front; `None` if it has a side of its own, as the surface has it then.
fn shared_back(model: &Model, backs: &Backs, [face, front]: [Index; 2]) -> Option<SharedBack> {
    if backs.has_own_side(model, face) {
        return None;
    }
    let data = model.data();
    let vertex = |corner: &Corner| model.weld().vertex_of()[corner.position as usize];
    let position = |corner: &Corner| model.surface().positions()[vertex(corner) as usize];
    let mut corners: Vec<Corner> = data.faces().get(face).to_vec();
    corners.dedup_by_key(|corner| position(corner).to_array());
    while corners.len() > 1 && corners.first().map(position) == corners.last().map(position) {
        corners.pop();
    }
    let points: Vec<DVec3> = corners.iter().map(position).collect();
    if points.len() < 3 {
        return None;
    }
    for (corner, point) in corners.iter_mut().zip(&points) {
        let same_place = data.faces().get(front).iter().find(|corner| position(corner) == *point)?;
        if vertex(corner) != vertex(same_place) {
            corner.position = same_place.position;
        }
    }
    let mut triangles = Vec::new();
    polygon::triangulate(&points, |t| triangles.push(t));
    Some(SharedBack { face, front, corners, triangles })
}
