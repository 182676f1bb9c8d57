//! Settings of the lights.
//!
//! ```
//! use planish_render::colour::Colour;
//! use planish_render::settings::lights::{Anchor, Light, LightKind};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! // A lamp that stays with the model.
//! let kind = LightKind::Point { distance: 3.0 };
//! let lamp = Light { azimuth: 40.0, elevation: 20.0, colour: Colour::WHITE, intensity: 1.0, kind, anchor: Anchor::Model };
//! let settings = Settings { lights: vec![lamp], ..Settings::default() };
//! settings.check()?;
//! assert_eq!(Settings::from_json(settings.to_json()?.as_bytes())?.lights, [lamp]);
//! assert!(Settings { lights: vec![lamp; 5], ..settings }.check().is_err());
//! # Ok::<(), SettingsError>(())
//! ```

use super::rules::{SettingsError, require};
use crate::colour::Colour;
use serde::{Deserialize, Serialize};

/// Number of lights that a picture may have.
pub const MAX_LIGHTS: usize = 4;

/// A light in some direction from the middle of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Angle to the right of the anchor, degrees.
    pub azimuth: f32,
    /// Angle above the anchor, degrees.
    pub elevation: f32,
    /// Colour of the light.
    pub colour: Colour,
    /// Strength of the light: at 1, a white surface in the middle of the model that faces the light is white.
    pub intensity: f32,
    /// Shape of the light.
    #[serde(default)]
    pub kind: LightKind,
    /// Frame that the angles are relative to.
    #[serde(default)]
    pub anchor: Anchor,
}

/// Shape of a light. Distances are from the middle of the model, in radii of its bounding sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LightKind {
    /// A sun: its rays are parallel.
    #[default]
    Directional,
    /// A cone of light towards the middle of the model.
    Spot {
        /// Distance of the light.
        distance: f32,
        /// Opening angle, degrees; the light fades over the outer tenth.
        angle: f32,
    },
    /// A lamp that shines in all directions.
    Point {
        /// Distance of the light.
        distance: f32,
    },
}

/// Frame that a light moves with when the camera turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Anchor {
    /// The light moves with the camera, so that a model is well lit from every side.
    #[default]
    Camera,
    /// The light stays with the model: angles are from its front and its horizon.
    Model,
    /// The light has the direction and colour of the sun of a generated environment; without one it stays with the model.
    Sun,
}

impl Light {
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

    /// Whether a picture can be lit with these numbers.
    pub(crate) fn is_valid(&self) -> bool {
        let near = |distance: f32| (0.01..=1e3).contains(&distance);
        let kind = match self.kind {
            LightKind::Directional => true,
            LightKind::Point { distance } => near(distance),
            LightKind::Spot { distance, angle } => near(distance) && (1.0..=170.0).contains(&angle),
        };
        self.azimuth.is_finite() && self.elevation.is_finite() && (0.0..=1e3).contains(&self.intensity) && kind
    }
}

/// Light from all directions: a hemisphere about the model's up axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ambient {
    /// Colour from above.
    pub sky: Colour,
    /// Colour from below.
    pub ground: Colour,
    /// Strength of both colours.
    pub intensity: f32,
    /// How much of the map of ambient occlusion shows, where there is one: 0 nothing, 1 all.
    pub occlusion: f32,
}

impl Default for Ambient {
    fn default() -> Self {
        Self { sky: Colour::hex(0xe8eef6), ground: Colour::hex(0xa08676), intensity: 0.24, occlusion: 1.0 }
    }
}

impl Ambient {
    /// Refuses a strength that no picture can be lit with.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[
            ((0.0..=1e3).contains(&self.intensity), "ambient.intensity", "0..1000"),
            ((0.0..=1.0).contains(&self.occlusion), "ambient.occlusion", "0..1"),
        ])
    }
}
