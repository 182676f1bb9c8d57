//! Numbers with which both renderers march through the volume of a scene.

use crate::camera::View;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::volume::{VolumeDisplay, VolumeView};
use crate::volume::Volume;
use glam::{Affine3A, Mat4, Vec3, Vec4};

/// Samples of a ray at most, however short a step the settings ask for.
const MAX_STEPS: f32 = 8192.0;

/// Distance of a slice plane from the ends of the box, texels: at an end, rounding would decide whether a ray meets it.
const SLICE_INSET: f32 = 1e-3;

/// A volume before the eye of a picture. Twin of `Volume` in `shaders/volume.wgsl`.
#[derive(Clone, Debug)]
pub(crate) struct VolumeRays<'a> {
    pub(crate) volume: &'a Volume,
    pub(crate) display: VolumeDisplay,
    pub(crate) texel_from_world: Affine3A,
    /// Corners of the part of the box that is drawn, texel coordinates.
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    /// Distance from one sample to the next, world units.
    pub(crate) step: f32,
    /// Reciprocal of the length in which a ray loses the opacity of a control point, world units.
    pub(crate) density: f32,
    /// Texel coordinates of the slice planes.
    pub(crate) slices: [Option<f32>; 3],
    /// Value at 0 of the transfer function.
    pub(crate) value_low: f32,
    /// Reciprocal of the difference of the values at 1 and at 0.
    pub(crate) value_scale: f32,
    pub(crate) lighting: f32,
    /// The longest diagonal of the box, world units.
    pub(crate) diagonal: f32,
    /// Values of the transfer function, 0..1, with linear RGB and opacity; at least one.
    pub(crate) points: Vec<(f32, Vec4)>,
    /// Columns: from the middle of the picture to its right and upper rim, ahead, and the eye; where rays are parallel, a point that is
    /// seen in the middle of the picture.
    pub(crate) rays: Mat4,
}

impl<'a> VolumeRays<'a> {
    /// The volume of a scene as the settings want it; `None` without one.
    pub(crate) fn new(scene: &'a Scene, settings: &Settings, view: &View) -> Option<Self> {
        let volume = scene.volume()?;
        let usual;
        let wanted = match &settings.volume {
            Some(wanted) => wanted,
            // Solid shading shows the volume of a scene without asking for more.
            None => {
                usual = VolumeView { display: VolumeDisplay::Hidden, ..VolumeView::default() };
                &usual
            }
        };
        let size = Vec3::from(volume.size().map(|n| n as f32));
        let (low, high) = (size * Vec3::from(wanted.low), size * Vec3::from(wanted.high));
        let diagonal = volume.diagonal();
        let range = wanted.range.unwrap_or(volume.range());
        let slice = |axis: usize| {
            let at = wanted.slices[axis]? * size[axis];
            let inset = SLICE_INSET.min(0.5 * (high[axis] - low[axis]));
            (low[axis]..=high[axis]).contains(&at).then(|| at.clamp(low[axis] + inset, high[axis] - inset))
        };
        Some(Self {
            volume,
            display: wanted.display,
            texel_from_world: volume.texel_from_world(),
            low,
            high,
            step: (wanted.step * volume.shortest_side()).max(diagonal / MAX_STEPS),
            density: 100.0 * wanted.density / diagonal,
            slices: [slice(0), slice(1), slice(2)],
            value_low: range.low,
            value_scale: 1.0 / (range.high - range.low),
            lighting: wanted.lighting,
            diagonal,
            points: wanted.transfer.points().iter().map(|p| (p.at, p.colour.linear().extend(p.opacity))).collect(),
            rays: rays(view),
        })
    }
}

/// Rays of the picture, from its projection.
fn rays(view: &View) -> Mat4 {
    let clip_from_world = view.clip_from_world;
    // Clip coordinates across the picture are plane equations; their normals are as long as the picture is narrow.
    let (across, upwards) = (clip_from_world.row(0), clip_from_world.row(1));
    let half = |row: Vec4| row.truncate() / row.truncate().length_squared();
    let point = if view.eye_in_world.w > 0.0 {
        view.eye_in_world.truncate()
    } else {
        -across.w * half(across) - upwards.w * half(upwards)
    };
    let ahead = -view.world_from_view.z_axis;
    Mat4::from_cols(half(across).extend(0.0), half(upwards).extend(0.0), ahead.extend(0.0), point.extend(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Sphere;
    use crate::settings::camera::{Camera, Projection};

    #[test]
    fn rays_meet_what_is_seen_there() {
        let bounds = Sphere { centre: Vec3::new(1.0, -2.0, 0.5), radius: 2.0 };
        for projection in [Projection::Perspective { field_of_view: 50.0 }, Projection::Orthographic] {
            let camera = Camera { yaw: 30.0, pitch: 20.0, projection, ..Camera::default() };
            let view = camera.view(bounds, 1.6);
            let rays = rays(&view);
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (-0.7, 0.4)] {
                let offset = x * rays.x_axis + y * rays.y_axis;
                let (origin, direction) = match projection {
                    Projection::Perspective { .. } => (rays.w_axis, rays.z_axis + offset),
                    Projection::Orthographic => (rays.w_axis + offset, rays.z_axis),
                };
                let point = (origin + 5.0 * direction).truncate();
                let seen = view.clip_from_world.project_point3(point);
                assert!((seen.x - x).abs() < 1e-5 && (seen.y - y).abs() < 1e-5, "{projection:?}: {seen} {x} {y}");
            }
        }
    }
}
