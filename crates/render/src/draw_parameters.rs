//! Numbers that a scene and the settings give together, for the renderers on the GPU and on the CPU alike.

use crate::mesh::Triangle;
use crate::scene::Scene;
use crate::settings::environment::Part;
use crate::settings::{Normals, Range, Settings, Shading};
use planish_geometry::metrics::colormap::Colormap;

/// Width of the lines of an overlay, pixels.
pub(crate) const LINE_WIDTH: f32 = 1.2;

/// The furthest that a vertex moves, model units. With bumps the vertices stay and the slope of the heights is seen.
pub(crate) fn reach(scene: &Scene, settings: &Settings) -> f32 {
    match &scene.displacement {
        Some(binding) if settings.shading != Shading::Bump => binding.reach(&settings.displace),
        _ => 0.0,
    }
}

/// Whether the surface is lit with normals of the displaced positions.
pub(crate) fn derives_normals(scene: &Scene, settings: &Settings) -> bool {
    let others = matches!(settings.shading, Shading::Bump) || normal_map_strength(scene, settings).is_some();
    scene.displacement.is_some() && settings.displace.normals == Normals::Derived && !others
}

/// Whether the mesh is drawn: it may be hidden where a volume is shown.
pub(crate) fn mesh_visibility(scene: &Scene, settings: &Settings) -> Part {
    match &settings.volume {
        Some(volume) if scene.volume().is_some() => volume.mesh,
        _ => Part::Shown,
    }
}

/// Triangles that are drawn and cast shadows.
pub(crate) fn drawn_triangles<'a>(scene: &'a Scene, settings: &Settings) -> &'a [Triangle] {
    match mesh_visibility(scene, settings) {
        Part::Shown => &scene.mesh().triangles,
        Part::Hidden => &[],
    }
}

/// Cells of the noise per world unit.
pub(crate) fn marble_frequency(scene: &Scene, settings: &Settings) -> f32 {
    settings.marble.frequency / scene.bounds().radius.max(f32::MIN_POSITIVE.sqrt())
}

/// Strength of the normal maps, 0..1; `None` where there are none or other normals are asked for.
pub(crate) fn normal_map_strength(scene: &Scene, settings: &Settings) -> Option<f32> {
    if scene.normal_maps.all().is_empty() {
        return None;
    }
    match settings.displace.normals {
        _ if settings.shading == Shading::NormalMap => Some(1.0),
        Normals::Map => Some(settings.displace.lambda.clamp(0.0, 1.0)),
        Normals::Derived | Normals::Base => None,
    }
}

/// Numbers that the ends of the colour map stand for; `None` if there are no numbers to show. With a range of the settings, the numbers
/// of the vertices may be on the device alone.
pub(crate) fn heat_range(scene: &Scene, settings: &Settings) -> Option<Range> {
    let is_known = settings.shading == Shading::Heat || scene.displacement.is_some();
    if let Some(range) = settings.heat.range.filter(|_| is_known) {
        return Some(range);
    }
    let heights;
    let numbers = if settings.shading == Shading::Height {
        heights = scene.displacement.as_ref()?.heights(&settings.displace);
        &heights
    } else {
        scene.mesh().scalars.as_ref()?
    };
    let finite = || numbers.iter().copied().filter(|x| x.is_finite());
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
