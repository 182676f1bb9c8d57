//! Lights: directional, spot and point lights, about the model's middle.

use crate::camera::View;
use crate::colour::Colour;
use crate::scene::Sphere;
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// How many lights there may be.
pub const MAX_LIGHTS: usize = 4;

/// A light; from the model's middle it is seen at an azimuth and an elevation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// How its rays run.
    #[serde(default)]
    pub kind: LightKind,
    /// What its angles are measured from.
    #[serde(default)]
    pub frame: LightFrame,
    /// To the right, degrees.
    pub azimuth: f32,
    /// Above the horizon, degrees.
    pub elevation: f32,
    /// Its colour.
    pub colour: Colour,
    /// Its strength: at 1, a white surface in the middle of the model that faces the light is white.
    pub intensity: f32,
    /// Whether it casts a shadow, if [`Shadows`](crate::settings::Shadows) are on.
    #[serde(default = "casts_shadow")]
    pub shadow: bool,
}

fn casts_shadow() -> bool {
    true
}

/// How the rays of a light run. Distances from the model's middle are in radii of its bounds; light gets weaker with the
/// square of the distance, and has its nominal strength in that middle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LightKind {
    /// In parallel.
    #[default]
    Directional,
    /// From a point, in a cone about the way to the model's middle.
    Spot {
        /// Of the point.
        distance: f32,
        /// Opening angle of the cone, degrees.
        angle: f32,
        /// Share of the angle over which the edge fades, 0..1.
        softness: f32,
    },
    /// From a point, everywhere.
    Point {
        /// Of the point.
        distance: f32,
    },
}

/// What the angles of a light are measured from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightFrame {
    /// The camera: the light goes with it, and the model is well lit from every side.
    #[default]
    Camera,
    /// The model's front and its up axis: the light stays when the camera turns.
    Model,
}

/// A light in world space, as both renderers shade with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlacedLight {
    /// Homogeneous: a unit vector towards the light (w = 0), or where it is (w = 1).
    pub(crate) place: Vec4,
    /// Linear RGB, at the distance `nominal`.
    pub(crate) radiance: Vec3,
    /// Distance at which it has its nominal strength.
    pub(crate) nominal: f32,
    /// Unit, along the middle of its rays.
    pub(crate) axis: Vec3,
    /// Cosines of the angles off the axis at which light begins to fade and has faded; below −1 it never does.
    pub(crate) cone: [f32; 2],
}

impl Light {
    /// A directional light that goes with the camera.
    pub fn directional(azimuth: f32, elevation: f32, colour: Colour, intensity: f32) -> Self {
        let (kind, frame) = (LightKind::Directional, LightFrame::Camera);
        Self { kind, frame, azimuth, elevation, colour, intensity, shadow: true }
    }

    /// Puts the light into the world.
    pub(crate) fn place(&self, view: &View, bounds: Sphere) -> PlacedLight {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let flat = elevation.cos();
        let world_from_frame = match self.frame {
            LightFrame::Camera => view.world_from_view,
            LightFrame::Model => view.world_from_model,
        };
        let towards =
            world_from_frame * Vec3::new(azimuth.sin() * flat, elevation.sin(), azimuth.cos() * flat);
        let at = |distance: f32| (bounds.centre + distance * bounds.radius * towards).extend(1.0);
        let radiance = self.intensity * self.colour.linear();
        let everywhere = [-2.0, -3.0];
        let (place, nominal, cone) = match self.kind {
            LightKind::Directional => (towards.extend(0.0), 1.0, everywhere),
            LightKind::Point { distance } => (at(distance), distance * bounds.radius, everywhere),
            LightKind::Spot { distance, angle, softness } => {
                let half = 0.5 * angle.to_radians();
                // An edge of some width keeps the quotient finite.
                let inner = (half * (1.0 - softness)).cos().max(half.cos() + 1e-4);
                (at(distance), distance * bounds.radius, [inner, half.cos()])
            }
        };
        PlacedLight { place, radiance, nominal, axis: -towards, cone }
    }

    /// A warm key light over the viewer's left shoulder and a cool fill light from the right.
    pub(crate) fn key_and_fill() -> Vec<Self> {
        vec![
            Self::directional(-50.0, 45.0, Colour::hex(0xfff3e4), 0.95),
            Self::directional(58.0, 12.0, Colour::hex(0xd6e2fa), 0.28),
        ]
    }
}

impl PlacedLight {
    /// Unit vector from a point (world space) to the light, and the light that arrives there.
    pub(crate) fn at(&self, position: Vec3) -> (Vec3, Vec3) {
        if self.place.w == 0.0 {
            return (self.place.truncate(), self.radiance);
        }
        let way = self.place.truncate() - position;
        let towards = way.normalize_or_zero();
        let fading = (self.nominal * self.nominal) / way.length_squared().max(f32::MIN_POSITIVE);
        let [inner, outer] = self.cone;
        let t = ((-towards.dot(self.axis) - outer) / (inner - outer)).clamp(0.0, 1.0);
        let inside = t * t * (3.0 - 2.0 * t);
        (towards, fading * inside * self.radiance)
    }
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
