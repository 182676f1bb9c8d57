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
pub(crate) struct WorldLight {
    /// Direction to the light (w = 0), or its position (w = 1).
    pub(crate) position: Vec4,
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
pub(crate) fn world_lights(scene: &Scene, settings: &Settings, view: &View) -> Vec<WorldLight> {
    let sun = sample::sun(scene.environment.as_ref(), settings);
    let world_light = |light: &Light| match sun {
        Some((to_sun, radiance)) if light.anchor == Anchor::Sun => {
            light.world_light_towards(to_sun, light.intensity * light.colour.linear() * radiance, scene.bounds())
        }
        _ => light.world_light(view, scene.bounds()),
    };
    settings.lights.iter().map(world_light).collect()
}

impl Light {
    /// This light before a camera.
    pub(crate) fn world_light(&self, view: &View, bounds: Sphere) -> WorldLight {
        self.world_light_towards(self.direction_in_world(view), self.intensity * self.colour.linear(), bounds)
    }

    /// `radiance`: of a white surface in the middle of the model that faces the light.
    fn world_light_towards(&self, direction: Vec3, radiance: Vec3, bounds: Sphere) -> WorldLight {
        let away = |distance: f32| {
            let offset = distance * bounds.radius;
            ((bounds.centre + offset * direction).extend(1.0), radiance * offset * offset)
        };
        let everywhere = WorldLight {
            position: direction.extend(0.0),
            radiance,
            axis: -direction,
            cos_outer: -1.0,
            cos_inner: -1.0,
        };
        match self.kind {
            LightKind::Directional => everywhere,
            LightKind::Point { distance } => {
                let (position, radiance) = away(distance);
                WorldLight { position, radiance, ..everywhere }
            }
            LightKind::Spot { distance, angle } => {
                let (position, radiance) = away(distance);
                let half = 0.5 * angle.to_radians();
                WorldLight { position, radiance, cos_outer: half.cos(), cos_inner: (0.9 * half).cos(), ..everywhere }
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

impl WorldLight {
    /// Unit vector to the light from a position, and the light that arrives there on a surface that faces it.
    pub(crate) fn incoming(&self, position: Vec3) -> (Vec3, Vec3) {
        let offset = self.position.truncate() - self.position.w * position;
        let direction = offset.normalize_or_zero();
        // The intensity of a lamp that is somewhere falls with the square of the distance.
        let reach = if self.position.w > 0.0 { 1.0 / offset.length_squared() } else { 1.0 };
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
