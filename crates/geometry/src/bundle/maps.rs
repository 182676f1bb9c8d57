//! Both maps and what they were made from.

use super::layout::Plan;
use super::{BakeError, Settings, Ways};
use crate::atlas::Atlas;
use crate::displacement::{self, Displacement, Encoding, MapKind};
use crate::model::Model;
use crate::progress::Progress;
use crate::texture::findings::Findings;
use crate::texture::resolution::{self, Spacing};
use crate::texture::tangents::{self, Tangent};
use crate::texture::{self, Coverage, Exactness, HeightMap, Size, Texels, normal_map, per_vertex};
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
    pub(super) fn new(model: &Model, kind: MapKind, ways: &Ways, frames: &[Tangent]) -> Self {
        let (deltas, normals) = (&ways.deltas, &ways.normals);
        let moved = |way: &dyn Fn(usize) -> DVec3| {
            model.surface().positions().iter().enumerate().map(|(v, p)| *p - way(v)).collect()
        };
        match (kind, &ways.heights) {
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
    pub(super) fn bake(
        model: &Model,
        atlas: Option<&Atlas>,
        ways: &Ways,
        settings: &Settings,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let (surface, normals) = (model.surface(), &ways.normals);
        let mut corner_frames = None;
        let mut frames = Vec::new();
        if settings.map == MapKind::VectorTangent {
            progress.stage("tangent frames");
            let of_corners = tangents::tangents(surface, atlas.ok_or(BakeError::NoTangents)?, normals);
            frames = tangents::at_vertices(surface, atlas.ok_or(BakeError::NoTangents)?, normals, &of_corners);
            corner_frames = Some(of_corners);
        }
        let offsets = Offsets::new(model, settings.map, ways, &frames);
        if offsets.channels.iter().flatten().any(|h| !(*h as f32).is_finite()) {
            return Err(BakeError::NotFinite);
        }
        progress.stage("spacing");
        let spacing = atlas.map(Spacing::new);
        let layout = atlas.zip(spacing.as_ref());
        let plan = Plan::make(surface, layout, &offsets.channels, settings, progress)?;
        let (channels, coverage, findings) = match (&plan, layout) {
            (Plan::Uv { side, .. }, Some((atlas, spacing))) => {
                let mut coverage = Coverage::new(surface, atlas, Size::square(*side), progress)?;
                let channels = at_uvs(model, atlas, &offsets.channels, &coverage, settings, progress)?;
                let findings = Findings::of(surface, atlas, spacing, &coverage);
                // Heights have room where vertices are one texel apart; shading wants two.
                let spaced = spacing.choose(&resolution::sides(settings.largest_side.0)).side;
                if settings.side.is_none() && spaced > *side {
                    coverage = Coverage::new(surface, atlas, Size::square(spaced), progress)?;
                }
                (channels, Some(coverage), findings)
            }
            _ => {
                progress.stage("one texel a vertex");
                let vertex_of = model.weld().vertex_of();
                let channels: Vec<HeightMap> =
                    offsets.channels.iter().map(|channel| per_vertex::bake(channel, vertex_of)).collect();
                let size = per_vertex::size(vertex_of.len());
                let coverage = share(model, size);
                let room = layout.map(|(atlas, _)| room_for_normals(model, atlas, settings, progress)).transpose()?;
                (channels, room.flatten(), Findings { coverage, ..Findings::default() })
            }
        };
        progress.stage("encoding");
        let [low, high] = range(&channels);
        let encoding = Encoding::covering(low.into(), high.into(), settings.texel);
        let displacement = Displacement::encode(&channels, settings.map, encoding).to_bytes()?;
        let normal_map = match (atlas, coverage) {
            (Some(atlas), Some(coverage)) => {
                progress.stage("tangent frames");
                let of_corners = corner_frames.unwrap_or_else(|| tangents::tangents(surface, atlas, normals));
                progress.check()?;
                let shaded = apply_offsets(model, &offsets.places, settings.lambda.0);
                let map =
                    normal_map::bake(surface, normals, &of_corners, shaded, &coverage, settings.convention, progress)?;
                progress.stage("encoding");
                let colour = image::ExtendedColorType::Rgb8;
                let size = coverage.size();
                Some((displacement::png(map.texels.as_flattened(), size, colour)?, size))
            }
            _ => None,
        };
        let size = channels[0].size;
        Ok(Self { offsets, frames, plan, size, encoding, channels, findings, displacement, normal_map })
    }
}

/// Share of the texels that belong to a vertex where each has one.
pub(super) fn share(model: &Model, size: Size) -> f64 {
    model.obj().positions().len() as f64 / size.texels() as f64
}

/// Each channel on the texels of the layout.
fn at_uvs(
    model: &Model,
    atlas: &Atlas,
    channels: &[Vec<f64>],
    coverage: &Coverage,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Vec<HeightMap>, BakeError> {
    let quantum = displacement::quantum(settings.texel);
    let exactness = Exactness { quantum, tolerance: settings.tolerance.0 };
    let mut out = Vec::new();
    for channel in channels {
        let mut map = texture::bake(model.surface(), atlas, channel, coverage, settings.interpolation, progress)?;
        if settings.texels == Texels::Fitted {
            texture::fit(&mut map, atlas, channel, exactness, progress)?;
        }
        out.push(map);
    }
    Ok(out)
}

fn range(channels: &[HeightMap]) -> [f32; 2] {
    let ranges = channels.iter().map(HeightMap::range);
    ranges.fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], [low, high]| [l.min(low), h.max(high)])
}

/// Share of the texels that may belong to two faces in a layout that gets a normal map although the heights lie elsewhere.
const OVERLAP: f64 = 0.01;

/// The texels of a normal map in a layout that does not hold the heights; none where charts overlap or leave the
/// map, for then one texel would have to hold several normals.
fn room_for_normals(
    model: &Model,
    atlas: &Atlas,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Option<Coverage>, BakeError> {
    if crate::texture::findings::out_of_range(atlas) > 0 {
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
