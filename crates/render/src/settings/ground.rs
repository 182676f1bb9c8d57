//! Settings of the ground.
//!
//! ```
//! use planish_render::settings::ground::{Ground, Show};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! let floating = Ground { show: Show::Plane, gap: 0.5, ..Ground::default() };
//! floating.check()?;
//! assert_eq!(Settings::from_json(br#"{ "ground": { "show": "plane", "gap": 0.5 } }"#)?.ground, floating);
//! assert_eq!(Ground { size: 0.0, ..floating }.check().unwrap_err().to_string(), "ground.size must be 0.1..100");
//! # Ok::<(), SettingsError>(())
//! ```

use super::rules::{SettingsError, named, require};
use crate::colour::Colour;
use serde::{Deserialize, Serialize};

/// A level disc under the model, for shadows to fall on. It is not seen from below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ground {
    /// Part of the ground that is drawn.
    pub show: Show,
    /// Colour of the plane.
    pub colour: Colour,
    /// Gap between the ground and the lowest vertex of the mesh, in radii of the model's bounding sphere.
    pub gap: f32,
    /// Radius of the ground, in radii of the bounding sphere; it fades out towards its rim.
    pub size: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { show: Show::default(), colour: Colour::hex(0xc9c5bf), gap: 0.0, size: 4.0 }
    }
}

named! {
/// Part of the ground that is drawn.
pub enum Show {
    /// There is no ground.
    #[default]
    Nothing = "nothing",
    /// A matte plane.
    Plane = "plane",
    /// The shadows alone, over the background.
    Shadows = "shadows",
}
}

impl Ground {
    /// Refuses numbers that no ground can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[
            ((0.0..=10.0).contains(&self.gap), "ground.gap", "0..10"),
            ((0.1..=100.0).contains(&self.size), "ground.size", "0.1..100"),
        ])
    }
}
