//! Both maps and what they were made from.

use super::layout::Plan;
use super::{BakeError, Request, VertexDisplacements};
use crate::map::displacement::{self, Displacement, Encoding, MapKind};
use crate::map::layout_issues::Findings;
use crate::map::map_size::{self, Spacing};
use crate::map::normal_map::{self, TangentFrames};
use crate::map::tangents::{self, Tangent};
use crate::map::{self, Coverage, Exactness, HeightMap, Size, Texels, TextureLayout, per_vertex};
use crate::mesh::atlas::Atlas;
use crate::source::model::Model;
use glam::{DMat3, DVec3, Vec3};

/// What the map has to hold.
pub(super) struct Offsets {
    /// Where each vertex should land at λ = 1. #V×3, model units
    pub(super) places: Vec<DVec3>,
    /// One number for each vertex and channel, model units. #V each
    pub(super) channels: Vec<Vec<f64>>,
}

impl Offsets {
    /// Frames (#V) are needed for tangent space only.
    pub(super) fn new(model: &Model, kind: MapKind, displacements: &VertexDisplacements, frames: &[Tangent]) -> Self {
        let (deltas, normals) = (&displacements.deltas, &displacements.normals);
        let moved = |way: &dyn Fn(usize) -> DVec3| {
            model.surface().positions().iter().enumerate().map(|(v, p)| *p - way(v)).collect()
        };
        match (kind, &displacements.heights) {
            (MapKind::Scalar, Some((heights, _))) => {
                let places = moved(&|v| heights[v] * normals[v].as_dvec3());
                Self { places, channels: vec![heights.clone()] }
            }
            (MapKind::Scalar | MapKind::VectorObject, _) => {
                Self { places: moved(&|v| deltas[v]), channels: split(deltas) }
            }
            (MapKind::VectorTangent, _) => {
                let local = |((delta, n), frame): ((&DVec3, &Vec3), &Tangent)| {
                    let [t, b, n] = frame.frame(*n).map(Vec3::as_dvec3);
                    let local = DMat3::from_cols(t, b, n).inverse() * *delta;
                    if local.is_finite() { local } else { DVec3::ZERO }
                };
                let local: Vec<DVec3> = deltas.iter().zip(normals).zip(frames).map(local).collect();
                let has_frame = |v: usize| if normals[v] == Vec3::ZERO { 0.0 } else { 1.0 };
                Self { places: moved(&|v| deltas[v] * has_frame(v)), channels: split(&local) }
            }
        }
    }
}

fn split(vectors: &[DVec3]) -> Vec<Vec<f64>> {
    (0..3).map(|axis| vectors.iter().map(|v| v[axis]).collect()).collect()
}

pub(super) struct Maps {
    pub(super) offsets: Offsets,
    /// Frames of the vertices; empty unless the map needs them. #V
    pub(super) frames: Vec<Tangent>,
    pub(super) plan: Plan,
    pub(super) size: Size,
    pub(super) encoding: Encoding,
    /// Before encoding.
    pub(super) channels: Vec<HeightMap>,
    pub(super) findings: Findings,
    /// The image files.
    pub(super) displacement: Vec<u8>,
    pub(super) normal_map: Option<(Vec<u8>, Size)>,
}

impl Maps {
    /// Makes both maps. `atlas` is the layout of the mesh, where it has one.
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
        let normal_map = match (atlas, for_normals) {
            (Some(atlas), Some(coverage)) => {
                progress.stage("tangent frames");
                let normals = &displacements.normals;
                let frames = of_corners.unwrap_or_else(|| tangents::tangents(model.surface(), atlas, normals));
                progress.check()?;
                let denoised = apply_offsets(model, &offsets.places, settings.lambda.0);
                let layout = TextureLayout { surface: model.surface(), atlas, coverage: &coverage };
                let frames = TangentFrames { normals, tangents: &frames };
                Some(bake_normal_map(request, layout, frames, denoised)?)
            }
            _ => None,
        };
        let size = channels[0].size;
        Ok(Self { offsets, frames, plan, size, encoding, channels, findings, displacement, normal_map })
    }
}

/// MikkTSpace frames, of corners and of vertices.
pub(super) struct Frames {
    /// Frames at the corners of each triangle. #T×3
    of_corners: Vec<[Tangent; 3]>,
    /// Frame of each vertex, at its dominant texture coordinates. #V
    pub(super) of_vertices: Vec<Tangent>,
}

impl Frames {
    /// Frames with normals (#V×3) of the vertices.
    pub(super) fn new(model: &Model, atlas: &Atlas, normals: &[Vec3]) -> Self {
        let of_corners = tangents::tangents(model.surface(), atlas, normals);
        let of_vertices = tangents::at_vertices(model.surface(), atlas, normals, &of_corners);
        Self { of_corners, of_vertices }
    }
}

/// Texels of a displacement map.
struct Filled {
    channels: Vec<HeightMap>,
    findings: Findings,
    /// Texels that a normal map can have; none where it would have to hold several normals in one.
    for_normals: Option<Coverage>,
}

/// Channels (#V each, model units) on the texels of the layout.
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
        let mut map = map::bake(layout, channel, settings.interpolation, progress)?;
        if settings.texels == Texels::Fitted {
            map::fit(&mut map, atlas, channel, exactness, progress)?;
        }
        filled.push(map);
    }
    let findings = Findings::of(surface, atlas, spacing, &coverage);
    // Heights have room where vertices are one texel apart; shading wants two.
    let spaced = spacing.choose(&map_size::sides(settings.largest_side.0)).side;
    if settings.side.is_none() && spaced > side {
        coverage = Coverage::new(surface, atlas, Size::square(spaced), progress)?;
    }
    Ok(Filled { channels: filled, findings, for_normals: Some(coverage) })
}

/// Channels (#V each, model units) with a texel for each source vertex.
fn at_texels(request: &Request, atlas: Option<&Atlas>, channels: &[Vec<f64>]) -> Result<Filled, BakeError> {
    let Request { model, progress, .. } = *request;
    progress.stage("one texel a vertex");
    let vertex_of = model.weld().vertex_of();
    let channels = channels.iter().map(|channel| per_vertex::bake(channel, vertex_of)).collect();
    let coverage = share(model, per_vertex::size(vertex_of.len()));
    let for_normals = atlas.map(|atlas| room_for_normals(request, atlas)).transpose()?.flatten();
    Ok(Filled { channels, findings: Findings { coverage, ..Findings::default() }, for_normals })
}

/// Share of the texels that belong to a source vertex where each has one.
pub(super) fn share(model: &Model, size: Size) -> f64 {
    model.data().positions().len() as f64 / size.texels() as f64
}

/// Image file of the normal map in a layout, and its size; `denoised` are the positions of the denoised surface. #V×3
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

fn range(channels: &[HeightMap]) -> [f32; 2] {
    let ranges = channels.iter().map(HeightMap::range);
    ranges.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], [low, high]| [l.min(low), h.max(high)])
}

/// Largest share of overlapping texels at which a normal map is still baked into a layout that does not hold the heights.
const OVERLAP: f64 = 0.01;

/// The texels of a normal map in a layout that does not hold the heights; none where charts overlap or leave the
/// map, for then one texel would have to hold several normals.
fn room_for_normals(request: &Request, atlas: &Atlas) -> Result<Option<Coverage>, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    if crate::map::layout_issues::out_of_range(atlas) > 0 {
        return Ok(None);
    }
    // Four texels a vertex each way, if the layout were full.
    let vertices = model.surface().positions().len() as f64;
    let side = ((4.0 * vertices.sqrt()) as u32)
        .next_power_of_two()
        .clamp(256.min(settings.largest_side.0), settings.largest_side.0);
    let size = Size::square(settings.side.unwrap_or(side));
    let coverage = Coverage::new(model.surface(), atlas, size, progress)?;
    let allowed = OVERLAP * coverage.share() * size.texels() as f64;
    Ok((coverage.overlaps() as f64 <= allowed).then_some(coverage))
}

/// p − λ · δ for each vertex, given where they go at λ = 1 (#V×3). #V×3, model units.
fn apply_offsets(model: &Model, places: &[DVec3], lambda: f64) -> Vec<DVec3> {
    model.surface().positions().iter().zip(places).map(|(p, q)| *p - lambda * (*p - *q)).collect()
}
