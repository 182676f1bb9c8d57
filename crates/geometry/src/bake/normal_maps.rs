//! Normal maps of the denoised surface, in the layout of the displacement map.

use super::fill::Filled;
use super::offsets::{Offsets, apply_offsets};
use super::{BakeError, Request, VertexDisplacements};
use crate::map::displacement;
use crate::map::normal_map::{self, SharedTexels, TangentFrames};
use crate::map::tangents::{self, Tangent};
use crate::map::{Size, TextureLayout};
use crate::mesh::atlas::Atlas;
use crate::source::model::Model;
use glam::{DVec3, Vec3};
use std::cell::OnceCell;

/// Mesh, displacements and frames from which the normal maps of a bake are made.
pub(super) struct NormalMaps<'a> {
    pub(super) request: &'a Request<'a>,
    pub(super) atlas: Option<&'a Atlas>,
    pub(super) displacements: &'a VertexDisplacements,
    pub(super) offsets: &'a Offsets,
    /// Frames at the corners of each triangle, once they are needed. #T×3
    pub(super) of_corners: OnceCell<Vec<[Tangent; 3]>>,
}

impl NormalMaps<'_> {
    /// Bakes the normal map of texels that have space for one.
    pub(super) fn add(&self, filled: &mut Filled) -> Result<(), BakeError> {
        let Some((atlas, (coverage, shared))) = self.atlas.zip(filled.for_normals.take()) else { return Ok(()) };
        let Request { model, settings, progress, .. } = *self.request;
        progress.stage("tangent frames");
        let normals = &self.displacements.normals;
        let frames = self.of_corners.get_or_init(|| tangents::tangents(model.surface(), atlas, normals));
        progress.check()?;
        let denoised = apply_offsets(model, &self.offsets.positions, settings.lambda.0);
        let layout = TextureLayout { surface: model.surface(), atlas, coverage: &coverage };
        let frames = TangentFrames { normals, tangents: frames };
        filled.normal_map = Some(bake_normal_map(self.request, (layout, shared), frames, denoised)?);
        filled.coverage = Some(coverage);
        Ok(())
    }
}

/// MikkTSpace frames of corners and of vertices.
pub(super) struct Frames {
    /// Frames at the corners of each triangle. #T×3
    pub(super) of_corners: Vec<[Tangent; 3]>,
    /// Frame of each vertex, at its dominant texture coordinates. #V
    pub(super) of_vertices: Vec<Tangent>,
}

impl Frames {
    /// Computes the frames for unit normals of the vertices (#V×3).
    pub(super) fn new(model: &Model, atlas: &Atlas, normals: &[Vec3]) -> Self {
        let of_corners = tangents::tangents(model.surface(), atlas, normals);
        let of_vertices = tangents::at_vertices(model.surface(), atlas, normals, &of_corners);
        Self { of_corners, of_vertices }
    }
}

/// Bakes the normal map of a denoised surface, whose positions are `denoised` (#V×3), and returns its image file and size.
fn bake_normal_map(
    request: &Request,
    (layout, shared): (TextureLayout, SharedTexels),
    frames: TangentFrames,
    denoised: Vec<DVec3>,
) -> Result<(Vec<u8>, Size), BakeError> {
    let Request { settings, progress, .. } = *request;
    let map = normal_map::bake(layout, frames, denoised, (settings.convention, shared), progress)?;
    progress.stage("encoding");
    let size = layout.coverage.size();
    Ok((displacement::png(map.texels.as_flattened(), size, image::ExtendedColorType::Rgb8)?, size))
}
