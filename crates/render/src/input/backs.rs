//! Backs of leaves and sheets, which the surface of a model lacks because welding makes one surface of both sides.

use crate::mesh::Facing;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::source::backs::{Backs, BothSides};
use planish_geometry::source::model::Model;

/// Backs that have source vertices of their own.
pub(super) struct OwnBacks {
    both: BothSides,
    /// Sides of the faces of the source that are drawn. #f
    facing: Vec<Facing>,
    /// Triangles of the backs in the surface that has both sides, ascending.
    triangles: Vec<usize>,
}

impl OwnBacks {
    /// Finds the backs of a model; `None` if it has none.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let backs = Backs::of(model);
        if backs.vertices().is_empty() {
            return None;
        }
        let mut facing = vec![Facing::Both; model.data().faces().len()];
        for &[back, front] in backs.pairs().iter().filter(|pair| backs.has_own_side(model, pair[0])) {
            (facing[back as usize], facing[front as usize]) = (Facing::Back, Facing::Front);
        }
        let both = backs.both_sides(model);
        let surface = both.model.surface();
        let face = |corners: &[u32; 3]| both.model.source_face(surface.topology().face(corners[0]));
        let all = surface.triangle_corners().iter().enumerate();
        let triangles = all.filter(|(_, corners)| facing[face(corners) as usize] == Facing::Back).map(|(t, _)| t);
        let triangles = triangles.collect();
        Some(Self { both, facing, triangles })
    }

    /// The model whose surface has both sides.
    pub(super) fn model(&self) -> &Model {
        &self.both.model
    }

    /// Triangles of the backs in the surface of [`Self::model`], ascending.
    pub(super) fn triangles(&self) -> &[usize] {
        &self.triangles
    }

    /// Sides that are drawn of the face at a corner of the surface that has fronts only, which is that of `model`.
    pub(super) fn facing(&self, model: &Model, corner: Index) -> Facing {
        self.facing[model.source_face(model.surface().topology().face(corner)) as usize]
    }

    /// Normals of the vertices of [`Self::model`] for those of the model with fronts only (#V×3).
    pub(super) fn turned(&self, normals: &[DVec3]) -> Vec<DVec3> {
        self.both.turned(normals)
    }
}
