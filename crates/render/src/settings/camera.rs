//! Settings of the camera.
//!
//! ```
//! use planish_render::settings::camera::{Camera, Projection, UpAxis};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! // A scan from above, to scale.
//! let camera = Camera { pitch: 90.0, projection: Projection::Orthographic, up: UpAxis::Z, ..Camera::default() };
//! camera.check()?;
//! let json = br#"{ "camera": { "pitch": 90, "projection": "orthographic", "up": "z" } }"#;
//! assert_eq!(Settings::from_json(json)?.camera, camera);
//! assert!(Camera { distance: 0.0, ..camera }.check().is_err());
//! # Ok::<(), SettingsError>(())
//! ```

use super::rules::{SettingsError, require};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A camera that orbits around the middle of the model.
///
/// At yaw 0 and pitch 0 the eye looks at the front of the model: from +z if y is up, from −y if z is up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Angle about the up axis, degrees: positive to the model's left, which is our right.
    pub yaw: f32,
    /// Angle above the horizon, degrees.
    pub pitch: f32,
    /// Distance of the eye; at 1 the bounding sphere just fits the picture.
    pub distance: f32,
    /// Point that the eye looks at, from the middle of the model in radii of its bounding sphere.
    pub target: Vec3,
    /// Projection of the view onto the picture.
    pub projection: Projection,
    /// Axis of the model that points up.
    pub up: UpAxis,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            yaw: 30.0,
            pitch: 15.0,
            distance: 1.0,
            target: Vec3::ZERO,
            projection: Projection::default(),
            up: UpAxis::Y,
        }
    }
}

/// Projection of a view onto a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Projection {
    /// Rays meet in the eye.
    Perspective {
        /// Opening angle across the shorter side of the picture, degrees.
        field_of_view: f32,
    },
    /// Rays are parallel, so that lengths can be read off.
    Orthographic,
}

impl Default for Projection {
    fn default() -> Self {
        Self::Perspective { field_of_view: 28.0 }
    }
}

/// Axis of a model that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpAxis {
    /// The y axis points up, as in most OBJ files.
    #[default]
    Y,
    /// The z axis points up, as in CAD and most scanners.
    Z,
}

impl Camera {
    /// Refuses numbers that no picture can be taken with.
    pub fn check(&self) -> Result<(), SettingsError> {
        let field_of_view = match self.projection {
            Projection::Perspective { field_of_view } => field_of_view,
            Projection::Orthographic => 90.0,
        };
        require(&[
            (self.yaw.is_finite() && self.pitch.is_finite(), "camera.yaw and camera.pitch", "finite"),
            ((0.01..=1e3).contains(&self.distance), "camera.distance", "0.01..1000"),
            (self.target.abs().max_element() <= 1e3, "camera.target", "at most 1000 radii away"),
            ((1.0..=150.0).contains(&field_of_view), "field_of_view", "1..150 degrees"),
        ])
    }
}
