//! Baking into new texture coordinates, which are made for the map.

use super::{BakeError, BakeSettings, Bundle, LayoutChoice, Request, VertexDisplacements};
use crate::bake::unwrap::{Charts, UnwrapError, Unwrapped};
use crate::map::map_size::{self, MapSizeChoice, MapSizeReason, Spacing};
use crate::source::model::Model;

impl From<UnwrapError> for BakeError {
    fn from(error: UnwrapError) -> Self {
        match error {
            UnwrapError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Unwrap(error),
        }
    }
}

/// Cuts charts, then packs and bakes them at growing sizes until each vertex gets its height.
pub(super) fn bake(request: &Request, displacements: &VertexDisplacements) -> Result<Bundle, BakeError> {
    let Request { model, settings, progress, backs, .. } = *request;
    let charts = Charts::cut(model, &model.surface().moved_by(&displacements.deltas), progress)?;
    let sides = settings.side.map_or_else(|| map_size::sides(settings.largest_side.0), |side| vec![side]);
    let largest = sides.last().copied().unwrap_or(1);
    let mut best = None;
    for side in sides {
        let Some(Unwrapped { uvs, corners }) = charts.pack(side, progress)? else { continue };
        let laid_out = Model::new(model.source().with_uvs(&uvs, &corners)?, settings.welding);
        let laid_out = laid_out.with_backs(backs.vertices().to_vec()).map_or(laid_out, |both| both.model);
        let spaced = Spacing::new(&laid_out.atlas()?).choose(&[side]);
        if spaced.reason == MapSizeReason::Crowded && side != largest {
            continue;
        }
        let at_side = BakeSettings { layout: LayoutChoice::Uv, side: Some(side), ..settings.clone() };
        let laid_out = Request { model: &laid_out, settings: &at_side, ..*request };
        let bundle = super::bake_layout(&laid_out, displacements, Some(model))?;
        let unresolved = bundle.manifest.report.unresolved_vertices;
        let reason = match spaced.reason {
            _ if unresolved == 0 => MapSizeReason::Exact,
            MapSizeReason::Crowded => MapSizeReason::Crowded,
            _ => MapSizeReason::AlmostExact,
        };
        let left = if reason == MapSizeReason::Crowded { spaced.left } else { unresolved };
        let choice = settings.side.is_none().then_some(MapSizeChoice { left, reason, largest, ..spaced });
        best = Some(Bundle { choice, ..bundle });
        if unresolved == 0 {
            break;
        }
    }
    best.ok_or(BakeError::ChartsDoNotFit { side: largest })
}
