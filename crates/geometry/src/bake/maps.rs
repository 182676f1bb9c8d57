//! Displacement map and normal map of a bake.

use super::fill::{Filled, Placed, fill};
use super::layout::Plan;
use super::normal_maps::{Frames, NormalMaps};
use super::offsets::Offsets;
use super::pages::{self, Paging, Texels};
use super::{BakeError, Request, VertexDisplacements};
use crate::map::displacement::{Displacement, Encoding, MapKind};
use crate::map::layout_issues::LayoutIssues;
use crate::map::map_size::Spacing;
use crate::map::pages::Pages;
use crate::map::tangents::Tangent;
use crate::map::{Coverage, HeightMap, Size};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use std::cell::OnceCell;

/// Both maps as image files, with the values that they were made from.
pub(super) struct Maps {
    pub(super) offsets: Offsets,
    /// Tangent frame of each vertex; empty unless the map is in tangent space. #V
    pub(super) frames: Vec<Tangent>,
    pub(super) plan: Plan,
    pub(super) encoding: Encoding,
    pub(super) findings: LayoutIssues,
    /// Images of the map: one, or one for each page.
    pub(super) images: Vec<MapImage>,
    /// Division into pages; `None` if there is one image.
    pub(super) paging: Option<Paging>,
    /// Texels in which the shading of the surface has space; `None` if one texel would have to hold several places, and with pages.
    pub(super) coverage: Option<Coverage>,
}

/// Image of a map or of one of its pages, and its normal map.
pub(super) struct MapImage {
    pub(super) size: Size,
    /// Texels of each channel before encoding, model units.
    pub(super) channels: Vec<HeightMap>,
    /// Pairs of a vertex and its private texel, ascending.
    pub(super) private: Vec<[Index; 2]>,
    /// Image file of the displacement map.
    pub(super) displacement: Vec<u8>,
    /// Image file of the normal map and its size; `None` if the layout has no space for one.
    pub(super) normal_map: Option<(Vec<u8>, Size)>,
}

impl Maps {
    /// Bakes both maps. `atlas` is the layout of the mesh, if it has one.
    pub(super) fn bake(
        request: &Request,
        atlas: Option<&Atlas>,
        displacements: &VertexDisplacements,
    ) -> Result<Self, BakeError> {
        let Request { model, settings, progress, .. } = *request;
        let frames = match settings.map {
            MapKind::VectorTangent => {
                progress.stage("tangent frames");
                Some(Frames::new(model, atlas.ok_or(BakeError::NoTangents)?, &displacements.normals))
            }
            MapKind::Scalar | MapKind::VectorObject => None,
        };
        let (of_corners, frames) = frames.map(|f| (f.of_corners, f.of_vertices)).unzip();
        let frames = frames.unwrap_or_default();
        let offsets = Offsets::new(model, settings.map, displacements, &frames);
        if offsets.channels.iter().flatten().any(|h| !(*h as f32).is_finite()) {
            return Err(BakeError::NotFinite);
        }
        let of_corners = of_corners.map_or_else(OnceCell::new, OnceCell::from);
        let normals = NormalMaps { request, atlas, displacements, offsets: &offsets, of_corners };
        let Texels { plan, filled, paging } = match (atlas, Pages::of(model.data(), settings.pages)?) {
            (Some(atlas), Some(pages)) => pages::fill(request, atlas, pages, &offsets.channels, &normals)?,
            _ => fill_one(request, atlas, &offsets.channels, &normals)?,
        };
        progress.stage("encoding");
        let [low, high] = range(filled.iter().flat_map(|filled| &filled.channels));
        let encoding = Encoding::covering(low.into(), high.into(), settings.texel);
        let texels = |filled: &Filled| filled.channels[0].size.texels();
        let findings = match &paging {
            Some(paging) => {
                let of_pages: Vec<_> = filled.iter().map(|filled| (filled.findings.clone(), texels(filled))).collect();
                LayoutIssues::of_pages(&of_pages, paging.unmapped_vertices)
            }
            None => filled[0].findings.clone(),
        };
        let coverage = if paging.is_none() { filled[0].coverage.clone() } else { None };
        let image = |filled: Filled| {
            let Filled { channels, private, normal_map, .. } = filled;
            let displacement = Displacement::encode(&channels, settings.map, encoding).to_bytes()?;
            Ok(MapImage { size: channels[0].size, channels, private, displacement, normal_map })
        };
        let images = filled.into_iter().map(image).collect::<Result<_, BakeError>>()?;
        Ok(Self { offsets, frames, plan, encoding, findings, images, paging, coverage })
    }
}

/// Fills the one image of a map.
fn fill_one(
    request: &Request,
    atlas: Option<&Atlas>,
    channels: &[Vec<f64>],
    normals: &NormalMaps,
) -> Result<Texels, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    progress.stage("spacing");
    let spacing = atlas.map(Spacing::new);
    let is_used = |v| !model.surface().topology().is_isolated(v);
    let vertices = model.surface().positions().len();
    let place = |(atlas, spacing)| Placed { atlas, spacing, is_used: &is_used, vertices };
    let placed = atlas.zip(spacing.as_ref()).map(place);
    let plan = Plan::make(model.surface(), placed.map(Placed::layout), channels, settings, progress)?;
    let (plan, mut filled) = fill(request, plan, placed, channels)?;
    normals.add(&mut filled)?;
    Ok(Texels { plan, filled: vec![filled], paging: None })
}

/// Lowest and highest texel of all channels.
fn range<'a>(channels: impl Iterator<Item = &'a HeightMap>) -> [f32; 2] {
    let ranges = channels.map(HeightMap::range);
    ranges.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], [low, high]| [l.min(low), h.max(high)])
}
