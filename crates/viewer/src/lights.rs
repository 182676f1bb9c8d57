//! Lights that stay with the camera, so that a model is well lit from every side.

use crate::camera::View;
use crate::colour::Colour;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// How many directional lights there may be.
pub const MAX_LIGHTS: usize = 4;

/// Light from infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Right of the eye, degrees.
    pub azimuth: f32,
    /// Above the eye, degrees.
    pub elevation: f32,
    /// Its colour.
    pub colour: Colour,
    /// Its strength: at 1, a white surface that faces the light is white.
    pub intensity: f32,
}

impl Light {
    /// Unit vector towards the light, world space.
    pub(crate) fn direction_in_world(&self, view: &View) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let flat = elevation.cos();
        view.world_from_view * Vec3::new(azimuth.sin() * flat, elevation.sin(), azimuth.cos() * flat)
    }

    /// Linear RGB.
    pub(crate) fn radiance(&self) -> Vec3 {
        self.intensity * self.colour.linear()
    }

    /// A warm key light over the viewer's left shoulder and a cool fill light from the right.
    pub(crate) fn key_and_fill() -> Vec<Self> {
        vec![
            Self { azimuth: -50.0, elevation: 45.0, colour: Colour::hex(0xfff3e4), intensity: 0.95 },
            Self { azimuth: 58.0, elevation: 12.0, colour: Colour::hex(0xd6e2fa), intensity: 0.28 },
        ]
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
