//! Lights: far away, or a lamp somewhere near the model.

use crate::camera::View;
use crate::colour::Colour;
use crate::environment;
use crate::scene::{Scene, Sphere};
use crate::settings::Settings;
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// How many lights there may be.
pub const MAX_LIGHTS: usize = 4;

/// A light in some direction from the middle of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Right of the eye, degrees.
    pub azimuth: f32,
    /// Above the eye, degrees.
    pub elevation: f32,
    /// Its colour.
    pub colour: Colour,
    /// Its strength: at 1, a white surface in the middle of the model that faces the light is white.
    pub intensity: f32,
    /// What shines.
    #[serde(default)]
    pub kind: LightKind,
    /// What it stays with.
    #[serde(default)]
    pub anchor: Anchor,
}

/// What shines. Distances are from the middle of the model, in radii of its bounding sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LightKind {
    /// The sun: parallel rays.
    #[default]
    Directional,
    /// A cone of light towards the middle of the model.
    Spot {
        /// How far away.
        distance: f32,
        /// Opening angle, degrees; the light fades over the outer tenth.
        angle: f32,
    },
    /// A lamp that shines everywhere.
    Point {
        /// How far away.
        distance: f32,
    },
}

/// What a light stays with when the camera turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// The camera, so that a model is well lit from every side.
    #[default]
    Camera,
    /// The model: angles are from its front and its horizon.
    Model,
    /// The sun of a generated environment, direction and colour; without one, the model.
    Sun,
}

/// A light in world space; the twin of `Light` in `shaders/frame.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lamp {
    /// Towards the light (w = 0), or where it is (w = 1).
    pub(crate) place: Vec4,
    /// Linear RGB, from afar or at a distance of one unit.
    pub(crate) radiance: Vec3,
    /// Unit, where a spot points.
    pub(crate) axis: Vec3,
    /// Cosines of half the angle of a spot and of where it begins to fade; −1 shines everywhere.
    pub(crate) cos_outer: f32,
    pub(crate) cos_inner: f32,
}

/// The lights of a picture.
pub(crate) fn lamps(scene: &Scene, settings: &Settings, view: &View) -> Vec<Lamp> {
    let sun = environment::sun(scene, settings);
    let lamp = |light: &Light| match sun {
        Some((to_sun, radiance)) if light.anchor == Anchor::Sun => {
            light.lamp_towards(to_sun, light.intensity * light.colour.linear() * radiance, scene.bounds())
        }
        _ => light.lamp(view, scene.bounds()),
    };
    settings.lights.iter().map(lamp).collect()
}

impl Light {
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

    /// A warm key light over the viewer's left shoulder and a cool fill light from the right.
    pub(crate) fn key_and_fill() -> Vec<Self> {
        let far = |azimuth, elevation, colour, intensity| Self {
            azimuth,
            elevation,
            colour: Colour::hex(colour),
            intensity,
            kind: LightKind::Directional,
            anchor: Anchor::Camera,
        };
        vec![far(-50.0, 45.0, 0xfff3e4, 0.95), far(58.0, 12.0, 0xd6e2fa, 0.28)]
    }
}

impl Lamp {
    /// Unit vector to the light from a place, and what arrives there.
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

/// As in WGSL.
pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Light from everywhere: a hemisphere about the model's up axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ambient {
    /// From above.
    pub sky: Colour,
    /// From below.
    pub ground: Colour,
    /// Strength of both.
    pub intensity: f32,
}

impl Default for Ambient {
    fn default() -> Self {
        Self { sky: Colour::hex(0xe8eef6), ground: Colour::hex(0xa08676), intensity: 0.24 }
    }
}
