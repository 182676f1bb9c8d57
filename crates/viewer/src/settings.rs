//! One value that says everything about a picture: what sliders write, what headless mode loads, and what a reference
//! image is drawn from.

mod check;
mod lines;
mod map;
mod shading;
mod surroundings;

pub use check::SettingsError;
pub use lines::Overlay;
pub use map::{Map, Normals, Relief};
pub use shading::{Checker, Filter, Heat, HeatSource, Material, Pattern, Range, Sampling, Shading};
pub use surroundings::{Background, Environment, Ground, Reach, ShadowCulling, ShadowFilter, Shadows, Surroundings};

use crate::camera::Camera;
use crate::lights::{Ambient, Light};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// All that a picture depends on, beside the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Of the picture. Who draws into a window takes the size of the window instead.
    pub size: Size,
    /// Samples per pixel in each direction, averaged in linear light.
    pub supersampling: u32,
    /// Whether the GPU finds edges at four places in each of these samples (MSAA) and shades at one.
    pub multisampling: Multisampling,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What the displacement map does.
    pub map: Map,
    /// What the surface shows.
    pub shading: Shading,
    /// What the surface is made of.
    pub material: Material,
    /// How pictures on the surface are sampled.
    pub sampling: Sampling,
    /// For [`Shading::Bump`] and [`Shading::Displacement`].
    pub relief: Relief,
    /// At most [`MAX_LIGHTS`](crate::lights::MAX_LIGHTS).
    pub lights: Vec<Light>,
    /// Light from everywhere.
    pub ambient: Ambient,
    /// Shadows of all lights that cast one.
    pub shadows: Shadows,
    /// What the model stands on.
    pub ground: Ground,
    /// What it is surrounded by.
    pub environment: Environment,
    /// Behind all this.
    pub background: Background,
    /// Lines on the surface.
    pub overlay: Overlay,
    /// For [`Shading::Checker`].
    pub checker: Checker,
    /// For [`Shading::Heat`].
    pub heat: Heat,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: Size::default(),
            supersampling: 3,
            multisampling: Multisampling::default(),
            camera: Camera::default(),
            map: Map::default(),
            shading: Shading::default(),
            material: Material::default(),
            sampling: Sampling::default(),
            relief: Relief::default(),
            lights: Light::key_and_fill(),
            ambient: Ambient::default(),
            shadows: Shadows::default(),
            ground: Ground::default(),
            environment: Environment::default(),
            background: Background::default(),
            overlay: Overlay::default(),
            checker: Checker::default(),
            heat: Heat::default(),
        }
    }
}

/// Width and height in pixels, `WxH` in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// Width / height.
    pub fn aspect(self) -> f32 {
        self.width as f32 / self.height as f32
    }
}

impl Default for Size {
    fn default() -> Self {
        Self { width: 1200, height: 900 }
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split_once('x')
            .and_then(|(w, h)| Some(Self { width: w.parse().ok()?, height: h.parse().ok()? }))
            .ok_or_else(|| "expected WIDTHxHEIGHT, for example 1200x900".to_owned())
    }
}

/// Samples at which the GPU finds edges; the software renderer knows supersampling only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Multisampling {
    /// One.
    #[default]
    Off,
    /// Four, or one where the GPU cannot.
    Four,
}

impl Settings {
    /// Reads JSON; what it leaves out keeps its default.
    pub fn from_json(json: &[u8]) -> Result<Self, SettingsError> {
        let settings: Self = serde_json::from_slice(json)?;
        settings.check()?;
        Ok(settings)
    }

    /// Writes all fields as JSON.
    pub fn to_json(&self) -> Result<String, SettingsError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Refuses numbers that no picture can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        check::check(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Projection, UpAxis};

    #[test]
    fn a_file_round_trips() {
        let settings = Settings {
            size: Size { width: 17, height: 5 },
            camera: Camera { yaw: 0.1, up: UpAxis::Z, projection: Projection::Orthographic, ..Camera::default() },
            shading: Shading::Heat,
            heat: Heat { range: Some(Range { low: -0.3, high: 1e-7 }), ..Heat::default() },
            lights: Vec::new(),
            ..Settings::default()
        };
        for settings in [settings, Settings::default()] {
            let json = settings.to_json().unwrap();
            assert_eq!(Settings::from_json(json.as_bytes()).unwrap(), settings);
        }
    }

    #[test]
    fn what_is_left_out_keeps_its_default() {
        let settings = Settings::from_json(br#"{ "camera": { "yaw": 90 } }"#).unwrap();
        let camera = Camera { yaw: 90.0, ..Camera::default() };
        assert_eq!(settings, Settings { camera, ..Settings::default() });
    }

    #[test]
    fn misspelt_and_impossible_settings_are_refused_by_name() {
        for (json, name) in [
            (r#"{ "sizes": 3 }"#, "sizes"),
            (r#"{ "size": { "width": 0, "height": 9 } }"#, "size.width"),
            (r#"{ "supersampling": 99 }"#, "supersampling"),
            (r#"{ "camera": { "projection": { "perspective": { "field_of_view": 180 } } } }"#, "field_of_view"),
            (r#"{ "heat": { "range": { "low": 1, "high": 1 } } }"#, "heat.range"),
            (r#"{ "material": { "colour": "red" } }"#, "red"),
            (r#"{ "map": { "lambda": 1e9 } }"#, "map.lambda"),
            (r#"{ "shadows": { "filter": { "pcf": { "side": 4 } } } }"#, "shadows.filter"),
            (r#"{ "sampling": { "anisotropy": 3 } }"#, "sampling.anisotropy"),
        ] {
            let message = Settings::from_json(json.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(name), "{json}: {message}");
        }
    }

    #[test]
    fn defaults_pass_the_check() {
        Settings::default().check().unwrap();
    }
}
