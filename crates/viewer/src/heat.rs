//! Numbers of the vertices, for heat maps.

use crate::colormap::Colormap;
use crate::scene::{Carried, Scene};
use crate::settings::{HeatSource, Range, Settings};
use planish_geometry::apply::ShaderVertex;
use planish_geometry::displacement::{MapKind, Weights};

/// The numbers (#V) that a source means; none if the scene does not have them.
pub(crate) fn scalars(scene: &Scene, source: HeatSource) -> Option<Vec<f32>> {
    match source {
        HeatSource::Given => scene.mesh().scalars.clone(),
        HeatSource::Height => scene.carried().map(heights),
        HeatSource::Error => scene.carried().and_then(|carried| carried.errors.clone()),
    }
}

/// What the map says at each vertex, model units; no number where a vertex samples nowhere.
fn heights(carried: &Carried) -> Vec<f32> {
    let height = |vertex: &ShaderVertex| {
        let Some(place) = vertex.place else { return f32::NAN };
        match carried.map.kind() {
            MapKind::Scalar => carried.map.height_at(place, Weights::Exact),
            MapKind::VectorObject | MapKind::VectorTangent => carried.map.vector_at(place, Weights::Exact).length(),
        }
    };
    carried.vertices.iter().map(height).collect()
}

/// Which numbers the ends of the colour map stand for; none if there are no numbers.
pub(crate) fn range(scalars: Option<&[f32]>, settings: &Settings) -> Option<Range> {
    let scalars = scalars?;
    if settings.heat.range.is_some() {
        return settings.heat.range;
    }
    let finite = || scalars.iter().copied().filter(|x| x.is_finite());
    let low = finite().reduce(f32::min)?;
    let high = finite().reduce(f32::max)?;
    let range = match settings.heat.map {
        Colormap::Diverging => {
            let most = high.abs().max(low.abs());
            Range { low: -most, high: most }
        }
        Colormap::Sequential => Range { low, high },
    };
    // Numbers that are all the same still need a range with some width.
    let slack = if range.low < range.high { 0.0 } else { range.high.abs().max(1.0) };
    Some(Range { low: range.low - slack, high: range.high + slack })
}
