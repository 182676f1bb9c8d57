//! Precomputed shading of the denoised surface: ambient occlusion and curvature.

use super::maps::Maps;
use super::offsets::apply_offsets;
use super::settings::CurvatureMap;
use super::{BakeError, Request};
use crate::map::displacement;
use crate::map::manifest::{CurvatureEntry, Layout, OcclusionEntry, ShadingMapEntry};
use crate::map::occlusion::{self, Occlusion};
use crate::map::{TextureLayout, interpolate_greys, per_vertex};
use crate::mesh::atlas::Atlas;
use crate::mesh::curvature::mean_curvature;
use crate::mesh::surface::Surface;
use image::ExtendedColorType;

/// A map of shading as an image file with its entry in the manifest.
pub(super) struct ShadingMap<E> {
    pub(super) entry: E,
    pub(super) image: Vec<u8>,
}

/// Maps of shading that were asked for.
#[derive(Default)]
pub(super) struct ShadingMaps {
    pub(super) occlusion: Option<ShadingMap<OcclusionEntry>>,
    pub(super) curvature: Option<ShadingMap<CurvatureEntry>>,
}

impl ShadingMaps {
    /// Bakes the maps that the settings ask for: into the texture coordinates of the mesh if these have space for shading, else
    /// with one texel for each source vertex.
    pub(super) fn bake(request: &Request, atlas: Option<&Atlas>, maps: &Maps) -> Result<Self, BakeError> {
        let settings = request.settings;
        if settings.occlusion.is_none() && settings.curvature == CurvatureMap::None {
            return Ok(Self::default());
        }
        let denoised = apply_offsets(request.model, &maps.offsets.positions, settings.lambda.0);
        let surface = &request.model.surface().at(denoised);
        let layout = match (atlas, &maps.coverage) {
            (Some(atlas), Some(coverage)) => Some(TextureLayout { surface, atlas, coverage }),
            _ => None,
        };
        let occlusion = settings.occlusion.map(|occlusion| bake_occlusion(request, surface, layout, occlusion));
        let curvature = match settings.curvature {
            CurvatureMap::None => None,
            CurvatureMap::Mean => Some(bake_curvature(request, surface, layout)?),
        };
        Ok(Self { occlusion: occlusion.transpose()?, curvature })
    }
}

fn bake_occlusion(
    request: &Request,
    surface: &Surface,
    layout: Option<TextureLayout>,
    settings: Occlusion,
) -> Result<ShadingMap<OcclusionEntry>, BakeError> {
    let texels = match layout {
        Some(layout) => occlusion::at_texels(layout, settings, request.progress)?,
        None => at_source_vertices(request, &occlusion::at_vertices(surface, settings, request.progress)?),
    };
    let (map, image) = encode(request, "occlusion", layout, &texels)?;
    Ok(ShadingMap { entry: OcclusionEntry { map, rays: settings.rays, distance: settings.distance }, image })
}

fn bake_curvature(
    request: &Request,
    surface: &Surface,
    layout: Option<TextureLayout>,
) -> Result<ShadingMap<CurvatureEntry>, BakeError> {
    request.progress.stage("curvature");
    let curvature = mean_curvature(surface);
    let range = usual(&curvature);
    let greys: Vec<f64> =
        curvature.iter().map(|h| if range > 0.0 { 0.5 + 0.5 * (h / range).clamp(-1.0, 1.0) } else { 0.5 }).collect();
    let texels = match layout {
        Some(layout) => interpolate_greys(layout, &greys, request.progress)?,
        None => at_source_vertices(request, &greys),
    };
    let (map, image) = encode(request, "curvature", layout, &texels)?;
    Ok(ShadingMap { entry: CurvatureEntry { map, range }, image })
}

/// 98th percentile of the sizes of numbers: few vertices, at sharp edges and at flaws, have far larger ones, and would leave all
/// others grey. 0 without any.
fn usual(numbers: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = numbers.iter().map(|h| h.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get((0.98 * sizes.len() as f64) as usize).or(sizes.last()).copied().unwrap_or(0.0)
}

/// Texels with the values (#V) of the source vertices.
fn at_source_vertices(request: &Request, values: &[f64]) -> Vec<f32> {
    per_vertex::bake(values, request.model.weld().vertex_of()).texels
}

/// Encodes texels, 0..=1, as a grey picture with 8 bits. Its name says what it shows.
fn encode(
    request: &Request,
    word: &str,
    layout: Option<TextureLayout>,
    texels: &[f32],
) -> Result<(ShadingMapEntry, Vec<u8>), BakeError> {
    let vertices = request.model.data().positions().len();
    let size = layout.map_or_else(|| per_vertex::size(vertices), |layout| layout.coverage.size());
    let bytes: Vec<u8> = texels.iter().map(|t| (t * 255.0).round() as u8).collect();
    let entry = ShadingMapEntry {
        file: format!("{}.{word}.png", request.names.stem),
        layout: if layout.is_some() { Layout::Uv } else { Layout::Vertex },
        width: size.width,
        height: size.height,
    };
    Ok((entry, displacement::png(&bytes, size, ExtendedColorType::L8)?))
}
