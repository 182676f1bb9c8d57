//! Texels of one image of a map: at the texture coordinates of the mesh, with private texels, or one for each vertex.

use super::layout::{self, Places, Plan};
use super::{BakeError, Request};
use crate::map::layout_issues::{self, LayoutIssues};
use crate::map::map_size::{self, MapSizeChoice, MapSizeReason, Spacing};
use crate::map::normal_map::SharedTexels;
use crate::map::private_texels::{self, Room};
use crate::map::{self, Coverage, HeightMap, Size, TextureLayout, per_vertex};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::source::model::Model;

/// Texels of an image of a displacement map, before encoding, and its normal map.
pub(super) struct Filled {
    pub(super) channels: Vec<HeightMap>,
    /// Pairs of a vertex and its private texel, ascending.
    pub(super) private: Vec<[Index; 2]>,
    pub(super) findings: LayoutIssues,
    /// Texels of the normal map until it is baked; `None` if one texel would have to hold several normals.
    pub(super) for_normals: Option<(Coverage, SharedTexels)>,
    /// Texels of the normal map when it is baked.
    pub(super) coverage: Option<Coverage>,
    /// Image file of the normal map and its size, when it is baked.
    pub(super) normal_map: Option<(Vec<u8>, Size)>,
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
    let coverage = texel_usage(model, per_vertex::size(vertex_of.len()).texels());
    let vertices = model.surface().positions().len();
    let for_normals = atlas.map(|atlas| normal_map_coverage(request, (atlas, vertices), 0)).transpose()?.flatten();
    let findings = LayoutIssues { coverage, ..LayoutIssues::default() };
    Ok(Filled::new(channels, Vec::new(), findings, for_normals))
}

/// Fraction of so many texels that are used if each source vertex has one.
pub(super) fn texel_usage(model: &Model, texels: usize) -> f64 {
    model.data().positions().len() as f64 / texels as f64
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
    if layout_issues::out_of_range(atlas) > 0 {
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
