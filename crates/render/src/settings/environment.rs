//! Settings of the environment.
//!
//! ```
//! use planish_render::settings::environment::{Part, Scene, Source, Surroundings};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! // A shiny surface in the ice, whose landscape itself is not drawn.
//! let json = br#"{ "environment": { "source": { "scene": "ice" }, "background": "hidden", "reflectance": 0.5 } }"#;
//! let ice = Settings::from_json(json)?.environment.unwrap();
//! assert_eq!((ice.source, ice.background, ice.ambient), (Source::Scene(Scene::Ice), Part::Hidden, Part::Shown));
//! assert!(Surroundings { reflectance: 2.0, ..Surroundings::default() }.check().is_err());
//! # Ok::<(), SettingsError>(())
//! ```

use super::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// An environment, and the parts of it that are drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Surroundings {
    /// Origin of the light.
    pub source: Source,
    /// Number of texels along a side of the cube map.
    pub resolution: u32,
    /// Rotation to the right about the up axis, degrees; at 0 the middle lies ahead of the eye at yaw 0.
    pub rotation: f32,
    /// Factor of the light.
    pub intensity: f32,
    /// Visibility behind the model; where it is hidden, [`Settings::background`](super::Settings::background) shows.
    pub background: Part,
    /// Blur of the background, 0..1.
    pub blur: f32,
    /// Visibility of the diffuse light; where it is hidden, [`Settings::ambient`](super::Settings::ambient) shines.
    pub ambient: Part,
    /// Reflectance of the surface seen along its normal, 0..1; it is higher at grazing angles (Schlick 1994).
    pub reflectance: f32,
    /// Blur of mirror images, 0..1.
    pub roughness: f32,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            source: Source::Scene(Scene::Desert),
            resolution: 512,
            rotation: 0.0,
            intensity: 1.0,
            background: Part::default(),
            blur: 0.0,
            ambient: Part::default(),
            reflectance: 0.0,
            roughness: 0.3,
        }
    }
}

/// Origin of an environment; relative paths are from the working directory. This crate draws scenes; reading pictures is
/// the caller's work.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A generated landscape.
    Scene(Scene),
    /// One picture by longitude and latitude, twice as wide as high.
    Equirect(PathBuf),
    /// A folder with six square pictures.
    Cube(PathBuf),
}

/// A generated landscape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scene {
    /// Dunes in the afternoon; the sun is on the left.
    Desert,
    /// Floes on a polar sea; the sun is low, on the right.
    Ice,
}

named! {
/// Visibility of a part of a picture.
pub enum Part {
    /// The part is drawn.
    #[default]
    Shown = "shown",
    /// The part is left out.
    Hidden = "hidden",
}
}

impl Surroundings {
    /// Refuses numbers that no picture can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        let share = |x: f32| (0.0..=1.0).contains(&x);
        require(&[
            ((16..=2048).contains(&self.resolution), "environment.resolution", "16..2048"),
            (self.rotation.is_finite(), "environment.rotation", "finite"),
            ((0.0..=1e3).contains(&self.intensity), "environment.intensity", "0..1000"),
            (share(self.blur), "environment.blur", "0..1"),
            (share(self.reflectance), "environment.reflectance", "0..1"),
            (share(self.roughness), "environment.roughness", "0..1"),
        ])
    }
}
