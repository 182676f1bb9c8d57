//! Both sides of leaves and sheets: where backs get heights of their own.

use super::layout::MOST_LAYERS;
use super::{BakeError, LayoutChoice, Request, VertexDisplacements};
use crate::map::pages::Pages;
use crate::map::{Coverage, Size};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::progress::Progress;
use crate::source::backs::{Backs, BothSides};
use crate::source::model::Model;

/// Side of the raster on which texels of both sides are told apart.
const RASTER: u32 = 512;

/// Largest fraction of the covered texels that both sides may share, which rounding along the outlines of charts explains.
const SHARED: f64 = 0.01;

/// Returns the backs of the mesh, and the model in which they have sides of their own; `None` if none has source vertices of its own,
/// or if they lie where other faces lie in the texture, as one texel cannot hold a height and its opposite.
pub(super) fn of_request(request: &Request) -> Result<(Backs, Option<BothSides>), BakeError> {
    let Request { model, settings, progress, .. } = *request;
    let backs = Backs::of(model);
    if backs.vertices().is_empty() {
        return Ok((backs, None));
    }
    let both = backs.both_sides(model);
    if settings.layout == LayoutChoice::Unwrap {
        // Each side gets charts of its own.
        return Ok((backs, Some(both)));
    }
    let have_texels = match (request.atlas()?, Pages::of(model.data(), settings.pages)?) {
        (None, _) => true,
        (Some(one), None) => has_texels(model, &one, &both.model, &both.model.atlas_in(request.tile()?)?, progress)?,
        (Some(_), Some(pages)) => {
            let mut all = true;
            for page in 0..pages.parts().len() as Index {
                // A page may have backs only.
                let Ok(one) = pages.atlas(model, page) else { continue };
                all &= has_texels(model, &one, &both.model, &pages.atlas(&both.model, page)?, progress)?;
            }
            all
        }
    };
    if have_texels { Ok((backs, Some(both))) } else { Ok((backs.with_vertices(Vec::new()), None)) }
}

/// Returns whether the layout of both sides has hardly more overlaps than that of one side.
fn has_texels(
    one_side: &Model,
    one: &Atlas,
    both_sides: &Model,
    both: &Atlas,
    progress: &dyn Progress,
) -> Result<bool, BakeError> {
    let layers = |model: &Model, atlas| Coverage::layers(model.surface(), atlas);
    if layers(one_side, one) > MOST_LAYERS {
        // Nothing can be spoilt: such texture coordinates are not used.
        return Ok(true);
    }
    if layers(both_sides, both) > MOST_LAYERS {
        return Ok(false);
    }
    let size = Size::square(RASTER);
    let covered = |model: &Model, atlas| Coverage::new(model.surface(), atlas, size, progress);
    let (one, both) = (covered(one_side, one)?, covered(both_sides, both)?);
    let added = both.overlaps().saturating_sub(one.overlaps());
    Ok(added as f64 <= SHARED * both.covered_fraction() * size.texels() as f64)
}

impl VertexDisplacements {
    /// Displacements of the vertices of both sides.
    pub(super) fn on_both(self, sides: &BothSides) -> Self {
        let heights = self.heights.map(|(heights, residual)| (sides.turned(&heights), residual));
        Self { deltas: sides.same(&self.deltas), normals: sides.turned(&self.normals), heights, ..self }
    }
}
