//! Lights in world space: far away, or a lamp somewhere near the model.

use crate::bounds::Sphere;
use crate::camera::View;
use crate::environment::sample;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::lights::{Anchor, Light, LightKind};
use glam::{Vec3, Vec4};

/// A light in world space; the twin of `Light` in `shaders/frame.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lamp {
    /// Direction to the light (w = 0), or its position (w = 1).
    pub(crate) place: Vec4,
    /// Radiance of a white surface that faces the light, linear RGB: from afar, or at a distance of one unit.
    pub(crate) radiance: Vec3,
    /// Unit direction in which a spot points.
    pub(crate) axis: Vec3,
    /// Cosine of half the opening angle of a spot; −1 shines in all directions.
    pub(crate) cos_outer: f32,
    /// Cosine of the angle within which a spot has its full strength.
    pub(crate) cos_inner: f32,
}

/// The lights of a picture in world space, in the order of the settings.
pub(crate) fn lamps(scene: &Scene, settings: &Settings, view: &View) -> Vec<Lamp> {
    let sun = sample::sun(scene.environment.as_ref(), settings);
    let lamp = |light: &Light| match sun {
        Some((to_sun, radiance)) if light.anchor == Anchor::Sun => {
            light.lamp_towards(to_sun, light.intensity * light.colour.linear() * radiance, scene.bounds())
        }
        _ => light.lamp(view, scene.bounds()),
    };
    settings.lights.iter().map(lamp).collect()
}

impl Light {
    /// This light before a camera.
    pub(crate) fn lamp(&self, view: &View, bounds: Sphere) -> Lamp {
        self.lamp_towards(self.direction_in_world(view), self.intensity * self.colour.linear(), bounds)
    }

    /// `radiance`: of a white surface in the middle of the model that faces the light.
    fn lamp_towards(&self, direction: Vec3, radiance: Vec3, bounds: Sphere) -> Lamp {
        let away = |distance: f32| {
            let way = distance * bounds.radius;
            ((bounds.centre + way * direction).extend(1.0), radiance * way * way)
        };
        let everywhere =
            Lamp { place: direction.extend(0.0), radiance, axis: -direction, cos_outer: -1.0, cos_inner: -1.0 };
        match self.kind {
            LightKind::Directional => everywhere,
            LightKind::Point { distance } => {
                let (place, radiance) = away(distance);
                Lamp { place, radiance, ..everywhere }
            }
            LightKind::Spot { distance, angle } => {
                let (place, radiance) = away(distance);
                let half = 0.5 * angle.to_radians();
                Lamp { place, radiance, cos_outer: half.cos(), cos_inner: (0.9 * half).cos(), ..everywhere }
            }
        }
    }

    /// Unit vector towards the light, world space.
    fn direction_in_world(&self, view: &View) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let flat = elevation.cos();
        let direction = Vec3::new(azimuth.sin() * flat, elevation.sin(), azimuth.cos() * flat);
        match self.anchor {
            Anchor::Camera => view.world_from_view * direction,
            Anchor::Model | Anchor::Sun => view.world_from_front * direction,
        }
    }
}

impl Lamp {
    /// Unit vector to the light from a position, and the light that arrives there on a surface that faces it.
    pub(crate) fn incoming(&self, position: Vec3) -> (Vec3, Vec3) {
        let way = self.place.truncate() - self.place.w * position;
        let direction = way.normalize_or_zero();
        // The intensity of a lamp that is somewhere falls with the square of the distance.
        let reach = if self.place.w > 0.0 { 1.0 / way.length_squared() } else { 1.0 };
        let cone = if self.cos_outer <= -1.0 {
            1.0
        } else {
            smoothstep(self.cos_outer, self.cos_inner, -direction.dot(self.axis))
        };
        (direction, self.radiance * (reach * cone))
    }
}

/// The function of this name in WGSL: 0 below `low`, 1 above `high`, a cubic polynomial in between.
pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
