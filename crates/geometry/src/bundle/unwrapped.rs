//! Baking into texture coordinates that are made for the purpose.

use super::{BakeError, Belongings, Bundle, LayoutChoice, Names, Settings, Ways};
use crate::model::Model;
use crate::obj::Obj;
use crate::progress::Progress;
use crate::texture::resolution::{self, Choice, Reason, Spacing};
use crate::unwrap::{Charts, UnwrapError};

impl From<UnwrapError> for BakeError {
    fn from(error: UnwrapError) -> Self {
        match error {
            UnwrapError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Unwrap(error),
        }
    }
}

/// Cuts charts, and packs and bakes them at growing sizes until each vertex gets its height.
pub(super) fn bake(
    model: &Model,
    ways: &Ways,
    names: &Names,
    beside: Belongings,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    let charts = Charts::cut(model, &model.surface().moved_by(&ways.deltas), progress)?;
    let sides = settings.side.map_or_else(|| resolution::sides(settings.largest_side.0), |side| vec![side]);
    let largest = sides.last().copied().unwrap_or(1);
    let mut best = None;
    for side in sides {
        let Some(unwrapped) = charts.pack(side, progress)? else { continue };
        let text = model.obj().with_uvs(&unwrapped.uvs, &unwrapped.corners);
        let laid_out = Model::new(Obj::parse(text).map_err(BakeError::Carrier)?, settings.welding);
        let spaced = Spacing::new(&laid_out.atlas()?).choose(&[side]);
        if spaced.reason == Reason::Crowded && side != largest {
            continue;
        }
        let at_side = Settings { layout: LayoutChoice::Uv, side: Some(side), ..settings.clone() };
        let bundle = super::bake_model(&laid_out, Some(model), ways, names, beside, &at_side, progress)?;
        let left = bundle.manifest.report.unresolved_vertices;
        let reason = match spaced.reason {
            _ if left == 0 => Reason::Exact,
            Reason::Crowded => Reason::Crowded,
            _ => Reason::AlmostExact,
        };
        let left = if reason == Reason::Crowded { spaced.left } else { left };
        let choice = settings.side.is_none().then_some(Choice { left, reason, largest, ..spaced });
        best = Some(Bundle { choice, ..bundle });
        if left == 0 {
            break;
        }
    }
    best.ok_or(BakeError::NoRoom { side: largest })
}
