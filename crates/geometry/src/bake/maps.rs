//! Displacement map and normal map of a bake.

use super::layout::{self, Places, Plan};
use super::pages::{self, Paging};
use super::{BakeError, Request, VertexDisplacements};
use crate::map::displacement::{self, Displacement, Encoding, MapKind};
use crate::map::layout_issues::LayoutIssues;
use crate::map::map_size::{self, MapSizeChoice, MapSizeReason, Spacing};
use crate::map::normal_map::{self, SharedTexels, TangentFrames};
use crate::map::pages::Pages;
use crate::map::private_texels::{self, Room};
use crate::map::tangents::{self, Tangent};
use crate::map::{self, Coverage, HeightMap, Size, TextureLayout, per_vertex};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::source::model::Model;
use glam::{DMat3, DVec3, Vec3};
use std::cell::OnceCell;

/// Displacements that a map has to hold, as positions and as the numbers of its channels.
pub(super) struct Offsets {
    /// Position of each vertex at λ = 1. #V×3, model units
    pub(super) positions: Vec<DVec3>,
    /// Channels with one number for each vertex. #V each, model units
    pub(super) channels: Vec<Vec<f64>>,
}

impl Offsets {
    /// Splits displacements into the channels of a map. `frames` (#V) are used in tangent space only.
    pub(super) fn new(model: &Model, kind: MapKind, displacements: &VertexDisplacements, frames: &[Tangent]) -> Self {
        let (deltas, normals) = (&displacements.deltas, &displacements.normals);
        let displaced = |offset: &dyn Fn(usize) -> DVec3| {
            model.surface().positions().iter().enumerate().map(|(v, p)| *p - offset(v)).collect()
        };
        match (kind, &displacements.heights) {
            (MapKind::Scalar, Some((heights, _))) => {
                let positions = displaced(&|v| heights[v] * normals[v].as_dvec3());
                Self { positions, channels: vec![heights.clone()] }
            }
            (MapKind::Scalar | MapKind::VectorObject, _) => {
                Self { positions: displaced(&|v| deltas[v]), channels: split(deltas) }
            }
            (MapKind::VectorTangent, _) => {
                let local = |((delta, n), frame): ((&DVec3, &Vec3), &Tangent)| {
                    let [t, b, n] = frame.frame(*n).map(Vec3::as_dvec3);
                    let local = DMat3::from_cols(t, b, n).inverse() * *delta;
                    if local.is_finite() { local } else { DVec3::ZERO }
                };
                let local: Vec<DVec3> = deltas.iter().zip(normals).zip(frames).map(local).collect();
                let has_frame = |v: usize| if normals[v] == Vec3::ZERO { 0.0 } else { 1.0 };
                Self { positions: displaced(&|v| deltas[v] * has_frame(v)), channels: split(&local) }
            }
        }
    }
}

fn split(vectors: &[DVec3]) -> Vec<Vec<f64>> {
    (0..3).map(|axis| vectors.iter().map(|v| v[axis]).collect()).collect()
}

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

/// Texels of a map before encoding.
pub(super) struct Texels {
    pub(super) plan: Plan,
    /// Texels of the map, or of each page.
    pub(super) filled: Vec<Filled>,
    pub(super) paging: Option<Paging>,
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

/// Mesh, displacements and frames from which the normal maps of a bake are made.
pub(super) struct NormalMaps<'a> {
    request: &'a Request<'a>,
    atlas: Option<&'a Atlas>,
    displacements: &'a VertexDisplacements,
    offsets: &'a Offsets,
    /// Frames at the corners of each triangle, once they are needed. #T×3
    of_corners: OnceCell<Vec<[Tangent; 3]>>,
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
    of_corners: Vec<[Tangent; 3]>,
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

/// Texels of an image of a displacement map, before encoding, and its normal map.
pub(super) struct Filled {
    pub(super) channels: Vec<HeightMap>,
    /// Pairs of a vertex and its private texel, ascending.
    pub(super) private: Vec<[Index; 2]>,
    pub(super) findings: LayoutIssues,
    /// Texels of the normal map until it is baked; `None` if one texel would have to hold several normals.
    for_normals: Option<(Coverage, SharedTexels)>,
    /// Texels of the normal map when it is baked.
    pub(super) coverage: Option<Coverage>,
    normal_map: Option<(Vec<u8>, Size)>,
}

impl Filled {
    fn new(
        channels: Vec<HeightMap>,
        private: Vec<[Index; 2]>,
        findings: LayoutIssues,
        for_normals: Option<(Coverage, SharedTexels)>,
    ) -> Self {
        Self { channels, private, findings, for_normals, coverage: None, normal_map: None }
    }
}

/// Layout of the vertices of a map, or of one of its pages.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) atlas: &'a Atlas,
    pub(super) spacing: &'a Spacing,
    /// True for vertices that the image has to serve.
    pub(super) is_used: &'a dyn Fn(Index) -> bool,
    /// Number of vertices.
    pub(super) vertices: usize,
}

impl<'a> Placed<'a> {
    pub(super) fn layout(self) -> (&'a Atlas, &'a Spacing) {
        (self.atlas, self.spacing)
    }
}

/// Bakes channels (#V each, model units) as planned, or with one texel for each vertex where the plan has no room. Returns the
/// plan that was followed.
pub(super) fn fill(
    request: &Request,
    plan: Plan,
    placed: Option<Placed>,
    channels: &[Vec<f64>],
) -> Result<(Plan, Filled), BakeError> {
    let Request { model, progress, .. } = *request;
    let plan = match (plan, placed) {
        (Plan::Uv { sides, choice, places: Places::Own }, Some(placed)) => {
            let filled = at_uvs(request, placed.layout(), channels, sides[0])?;
            return Ok((Plan::Uv { sides, choice, places: Places::Own }, filled));
        }
        (Plan::Uv { sides, choice, places }, Some(placed)) => {
            if let Some((side, filled)) = with_private_texels(request, placed, channels, &sides)? {
                let left = filled.private.len();
                let reason = |choice| MapSizeChoice { side, left, reason: MapSizeReason::PrivateTexels, ..choice };
                let choice = if left > 0 { choice.map(reason) } else { choice };
                return Ok((Plan::Uv { sides: vec![side], choice, places }, filled));
            }
            Plan::Uv { sides, choice, places }.without_room(model.surface(), placed.layout(), progress)?
        }
        (plan, _) => plan,
    };
    Ok((plan, at_texels(request, placed.map(|placed| placed.atlas), channels)?))
}

/// Interpolates channels (#V each, model units) over the texels of the charts.
fn interpolated(request: &Request, layout: TextureLayout, channels: &[Vec<f64>]) -> Result<Vec<HeightMap>, BakeError> {
    let Request { settings, progress, .. } = *request;
    let map = |channel: &Vec<f64>| map::interpolate_heights(layout, channel, settings.interpolation, progress);
    Ok(channels.iter().map(map).collect::<Result<_, _>>()?)
}

/// Bakes channels (#V each, model units) into the texture coordinates of the mesh, at a side in texels.
fn at_uvs(
    request: &Request,
    (atlas, spacing): (&Atlas, &Spacing),
    channels: &[Vec<f64>],
    side: u32,
) -> Result<Filled, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    let surface = model.surface();
    let coverage = Coverage::new(surface, atlas, Size::square(side), progress)?;
    let mut maps = interpolated(request, TextureLayout { surface, atlas, coverage: &coverage }, channels)?;
    if settings.texels == map::Texels::Fitted {
        for (map, channel) in maps.iter_mut().zip(channels) {
            map::fit(map, atlas, channel, layout::exactness(settings), progress)?;
        }
    }
    let findings = LayoutIssues::of(surface, atlas, spacing, &coverage);
    let for_normals = Some((spaced(request, (atlas, spacing), coverage)?, SharedTexels::First));
    Ok(Filled::new(maps, Vec::new(), findings, for_normals))
}

/// Bakes channels (#V each, model units) into the texture coordinates of the mesh, with private texels for the vertices that
/// would miss their values. Uses the first side with room for them, and returns it; `None` if there is none.
fn with_private_texels(
    request: &Request,
    placed: Placed,
    channels: &[Vec<f64>],
    sides: &[u32],
) -> Result<Option<(u32, Filled)>, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    let surface = model.surface();
    let Placed { atlas, spacing, is_used, vertices } = placed;
    for (room, &side) in
        [Room::OutsideCharts, Room::Anywhere].iter().flat_map(|room| sides.iter().map(move |s| (*room, s)))
    {
        let coverage = Coverage::new(surface, atlas, Size::square(side), progress)?;
        let places = private_texels::Layout { atlas, coverage: &coverage, is_used, room };
        if room == Room::OutsideCharts && !private_texels::may_have_room(places) {
            continue;
        }
        let mut maps = interpolated(request, TextureLayout { surface, atlas, coverage: &coverage }, channels)?;
        let exactness = layout::exactness(settings);
        let fitted = private_texels::fit_with_private_texels(&mut maps, places, channels, exactness, progress)?;
        let Some(private) = fitted else { continue };
        let findings = LayoutIssues::of(surface, atlas, spacing, &coverage);
        let for_normals = if private.is_empty() {
            Some((spaced(request, (atlas, spacing), coverage)?, SharedTexels::First))
        } else {
            normal_map_coverage(request, (atlas, vertices), side)?
        };
        return Ok(Some((side, Filled::new(maps, private, findings, for_normals))));
    }
    Ok(None)
}

/// Texels of a normal map for a layout that is rasterised at the side of the displacement map. Heights need vertices one texel
/// apart, smooth shading needs two.
fn spaced(request: &Request, (atlas, spacing): (&Atlas, &Spacing), coverage: Coverage) -> Result<Coverage, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    let spaced = spacing.choose(&map_size::sides(settings.largest_side.0)).side;
    if settings.side.is_none() && spaced > coverage.size().width {
        return Ok(Coverage::new(model.surface(), atlas, Size::square(spaced), progress)?);
    }
    Ok(coverage)
}

/// Bakes channels (#V each, model units) with one texel for each source vertex.
pub(super) fn at_texels(request: &Request, atlas: Option<&Atlas>, channels: &[Vec<f64>]) -> Result<Filled, BakeError> {
    let Request { model, progress, .. } = *request;
    progress.stage("one texel a vertex");
    let vertex_of = model.weld().vertex_of();
    let channels = channels.iter().map(|channel| per_vertex::bake(channel, vertex_of)).collect();
    let coverage = texel_usage(model, per_vertex::size(vertex_of.len()));
    let vertices = model.surface().positions().len();
    let for_normals = atlas.map(|atlas| normal_map_coverage(request, (atlas, vertices), 0)).transpose()?.flatten();
    let findings = LayoutIssues { coverage, ..LayoutIssues::default() };
    Ok(Filled::new(channels, Vec::new(), findings, for_normals))
}

/// Fraction of the texels that are used if each source vertex has one.
pub(super) fn texel_usage(model: &Model, size: Size) -> f64 {
    model.data().positions().len() as f64 / size.texels() as f64
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

/// Lowest and highest texel of all channels.
fn range<'a>(channels: impl Iterator<Item = &'a HeightMap>) -> [f32; 2] {
    let ranges = channels.map(HeightMap::range);
    ranges.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], [low, high]| [l.min(low), h.max(high)])
}

/// Largest fraction of overlapping texels that rounding along the outlines of charts explains.
const MAX_OVERLAP: f64 = 0.01;

/// Texels of a normal map for a layout that cannot hold the heights of all vertices; `side` is the least side, texels.
///
/// The result is `None` if charts leave the unit square, since one texel would then have to hold several normals, and if more
/// than half of the texels of the charts are shared.
fn normal_map_coverage(
    request: &Request,
    (atlas, vertices): (&Atlas, usize),
    side: u32,
) -> Result<Option<(Coverage, SharedTexels)>, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    if crate::map::layout_issues::out_of_range(atlas) > 0 {
        return Ok(None);
    }
    // Rasterising would only say the same, after a long time.
    if Coverage::layers(model.surface(), atlas) > MOST_LAYERS_OF_NORMALS {
        return Ok(None);
    }
    // In a full layout each vertex gets a block of 4 × 4 texels.
    let side = ((4.0 * (vertices as f64).sqrt()) as u32)
        .next_power_of_two()
        .max(side)
        .clamp(256.min(settings.largest_side.0), settings.largest_side.0);
    let size = Size::square(settings.side.unwrap_or(side));
    let coverage = Coverage::new(model.surface(), atlas, size, progress)?;
    let covered = coverage.covered_fraction() * size.texels() as f64;
    if coverage.overlaps() as f64 <= MAX_OVERLAP * covered {
        return Ok(Some((coverage, SharedTexels::First)));
    }
    Ok((coverage.shared() as f64 <= covered / 2.0).then_some((coverage, SharedTexels::Flat)))
}

/// Number of layers of charts above which hardly a texel belongs to one triangle alone.
const MOST_LAYERS_OF_NORMALS: f64 = 8.0;

/// Positions p − λ · δ, given the positions at λ = 1 (#V×3). #V×3, model units
pub(super) fn apply_offsets(model: &Model, denoised: &[DVec3], lambda: f64) -> Vec<DVec3> {
    model.surface().positions().iter().zip(denoised).map(|(p, q)| *p - lambda * (*p - *q)).collect()
}
