//! Displacement map and normal map of a bake.

use super::layout::Plan;
use super::{BakeError, Request, VertexDisplacements};
use crate::map::displacement::{self, Displacement, Encoding, MapKind};
use crate::map::layout_issues::LayoutIssues;
use crate::map::map_size::{self, Spacing};
use crate::map::normal_map::{self, TangentFrames};
use crate::map::tangents::{self, Tangent};
use crate::map::{self, Coverage, Exactness, HeightMap, Size, Texels, TextureLayout, per_vertex};
use crate::mesh::atlas::Atlas;
use crate::source::model::Model;
use glam::{DMat3, DVec3, Vec3};

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
    pub(super) size: Size,
    pub(super) encoding: Encoding,
    /// Texels of each channel before encoding, model units.
    pub(super) channels: Vec<HeightMap>,
    pub(super) findings: LayoutIssues,
    /// Image file of the displacement map.
    pub(super) displacement: Vec<u8>,
    /// Image file of the normal map and its size; `None` if the layout has no space for one.
    pub(super) normal_map: Option<(Vec<u8>, Size)>,
    /// Texels in which the shading of the surface has space; `None` if one texel would have to hold several places.
    pub(super) coverage: Option<Coverage>,
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
        progress.stage("spacing");
        let spacing = atlas.map(Spacing::new);
        let layout = atlas.zip(spacing.as_ref());
        let plan = Plan::make(model.surface(), layout, &offsets.channels, settings, progress)?;
        let Filled { channels, findings, for_normals } = match (&plan, layout) {
            (Plan::Uv { side, .. }, Some(layout)) => at_uvs(request, layout, &offsets.channels, *side)?,
            _ => at_texels(request, atlas, &offsets.channels)?,
        };
        progress.stage("encoding");
        let [low, high] = range(&channels);
        let encoding = Encoding::covering(low.into(), high.into(), settings.texel);
        let displacement = Displacement::encode(&channels, settings.map, encoding).to_bytes()?;
        let normal_map = match (atlas, &for_normals) {
            (Some(atlas), Some(coverage)) => {
                progress.stage("tangent frames");
                let normals = &displacements.normals;
                let frames = of_corners.unwrap_or_else(|| tangents::tangents(model.surface(), atlas, normals));
                progress.check()?;
                let denoised = apply_offsets(model, &offsets.positions, settings.lambda.0);
                let layout = TextureLayout { surface: model.surface(), atlas, coverage };
                let frames = TangentFrames { normals, tangents: &frames };
                Some(bake_normal_map(request, layout, frames, denoised)?)
            }
            _ => None,
        };
        let size = channels[0].size;
        let coverage = for_normals;
        Ok(Self { offsets, frames, plan, size, encoding, channels, findings, displacement, normal_map, coverage })
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

/// Texels of a displacement map, before encoding.
struct Filled {
    channels: Vec<HeightMap>,
    findings: LayoutIssues,
    /// Texels of the normal map; `None` if one texel would have to hold several normals.
    for_normals: Option<Coverage>,
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
    let mut coverage = Coverage::new(surface, atlas, Size::square(side), progress)?;
    let quantum = displacement::quantum(settings.texel);
    let exactness = Exactness { quantum, tolerance: settings.tolerance.0 };
    let mut filled = Vec::new();
    for channel in channels {
        let layout = TextureLayout { surface, atlas, coverage: &coverage };
        let mut map = map::interpolate_heights(layout, channel, settings.interpolation, progress)?;
        if settings.texels == Texels::Fitted {
            map::fit(&mut map, atlas, channel, exactness, progress)?;
        }
        filled.push(map);
    }
    let findings = LayoutIssues::of(surface, atlas, spacing, &coverage);
    // Heights need vertices one texel apart, smooth shading needs two.
    let spaced = spacing.choose(&map_size::sides(settings.largest_side.0)).side;
    if settings.side.is_none() && spaced > side {
        coverage = Coverage::new(surface, atlas, Size::square(spaced), progress)?;
    }
    Ok(Filled { channels: filled, findings, for_normals: Some(coverage) })
}

/// Bakes channels (#V each, model units) with one texel for each source vertex.
fn at_texels(request: &Request, atlas: Option<&Atlas>, channels: &[Vec<f64>]) -> Result<Filled, BakeError> {
    let Request { model, progress, .. } = *request;
    progress.stage("one texel a vertex");
    let vertex_of = model.weld().vertex_of();
    let channels = channels.iter().map(|channel| per_vertex::bake(channel, vertex_of)).collect();
    let coverage = texel_usage(model, per_vertex::size(vertex_of.len()));
    let for_normals = atlas.map(|atlas| normal_map_coverage(request, atlas)).transpose()?.flatten();
    Ok(Filled { channels, findings: LayoutIssues { coverage, ..LayoutIssues::default() }, for_normals })
}

/// Fraction of the texels that are used if each source vertex has one.
pub(super) fn texel_usage(model: &Model, size: Size) -> f64 {
    model.data().positions().len() as f64 / size.texels() as f64
}

/// Bakes the normal map of a denoised surface, whose positions are `denoised` (#V×3), and returns its image file and size.
fn bake_normal_map(
    request: &Request,
    layout: TextureLayout,
    frames: TangentFrames,
    denoised: Vec<DVec3>,
) -> Result<(Vec<u8>, Size), BakeError> {
    let Request { settings, progress, .. } = *request;
    let map = normal_map::bake(layout, frames, denoised, settings.convention, progress)?;
    progress.stage("encoding");
    let size = layout.coverage.size();
    Ok((displacement::png(map.texels.as_flattened(), size, image::ExtendedColorType::Rgb8)?, size))
}

/// Lowest and highest texel of all channels.
fn range(channels: &[HeightMap]) -> [f32; 2] {
    let ranges = channels.iter().map(HeightMap::range);
    ranges.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], [low, high]| [l.min(low), h.max(high)])
}

/// Largest fraction of overlapping texels at which a normal map is still baked when heights use the per-vertex layout.
const MAX_OVERLAP: f64 = 0.01;

/// Texels of a normal map in the texture coordinates of a mesh whose heights use the per-vertex layout.
///
/// The result is `None` if charts overlap or leave the unit square, since one texel would then have to hold several normals.
fn normal_map_coverage(request: &Request, atlas: &Atlas) -> Result<Option<Coverage>, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    if crate::map::layout_issues::out_of_range(atlas) > 0 {
        return Ok(None);
    }
    // Rasterising would only say the same, after a long time.
    if Coverage::layers(model.surface(), atlas) > 1.0 + 5.0 * MAX_OVERLAP {
        return Ok(None);
    }
    // In a full layout each vertex gets a block of 4 × 4 texels.
    let vertices = model.surface().positions().len() as f64;
    let side = ((4.0 * vertices.sqrt()) as u32)
        .next_power_of_two()
        .clamp(256.min(settings.largest_side.0), settings.largest_side.0);
    let size = Size::square(settings.side.unwrap_or(side));
    let coverage = Coverage::new(model.surface(), atlas, size, progress)?;
    let allowed = MAX_OVERLAP * coverage.covered_fraction() * size.texels() as f64;
    Ok((coverage.overlaps() as f64 <= allowed).then_some(coverage))
}

/// Positions p − λ · δ, given the positions at λ = 1 (#V×3). #V×3, model units
pub(super) fn apply_offsets(model: &Model, denoised: &[DVec3], lambda: f64) -> Vec<DVec3> {
    model.surface().positions().iter().zip(denoised).map(|(p, q)| *p - lambda * (*p - *q)).collect()
}
