//! One value that says everything about a picture: what headless mode loads, and what a reference
//! image is drawn from.

use crate::camera::{Camera, Projection};
use crate::colour::Colour;
use crate::lights::{Ambient, Light, MAX_LIGHTS};
use clap::ValueEnum;
use planish_geometry::colormap::Colormap;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use thiserror::Error;

/// All that a picture depends on, beside the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Of the picture.
    pub size: Size,
    /// Samples per pixel in each direction, averaged in linear light.
    pub supersampling: u32,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What the surface shows.
    pub shading: Shading,
    /// What the surface is made of.
    pub material: Material,
    /// At most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// Light from everywhere.
    pub ambient: Ambient,
    /// Behind the model.
    pub background: Background,
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
            camera: Camera::default(),
            shading: Shading::default(),
            material: Material::default(),
            lights: Light::key_and_fill(),
            ambient: Ambient::default(),
            background: Background::default(),
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

/// What the surface shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// Lit with the normal of each triangle: shows the noise as it is.
    Flat,
    /// Lit with vertex normals.
    #[default]
    Smooth,
    /// Vertex normals as colours: n in model space is (2·rgb − 1) of the stored values.
    Normals,
    /// A chequered texture: shows how the texture coordinates stretch.
    Checker,
    /// A number per vertex through a colour map.
    Heat,
}

/// What the surface is made of (Blinn-Phong).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Where the scene has no texture.
    pub colour: Colour,
    /// Strength of the highlight.
    pub specular: f32,
    /// Sharpness of the highlight.
    pub exponent: f32,
}

impl Default for Material {
    /// Unglazed clay.
    fn default() -> Self {
        Self { colour: Colour::hex(0xe2c4ae), specular: 0.12, exponent: 28.0 }
    }
}

/// A vertical gradient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Background {
    /// In the first row.
    pub top: Colour,
    /// In the last row.
    pub bottom: Colour,
}

impl Default for Background {
    fn default() -> Self {
        Self { top: Colour::hex(0xf6f6f5), bottom: Colour::hex(0xd2d5d9) }
    }
}

/// A chequered texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Checker {
    /// Squares along the unit square's side.
    pub squares: f32,
    /// Of the square at the origin.
    pub light: Colour,
    /// Of its neighbours.
    pub dark: Colour,
}

impl Default for Checker {
    fn default() -> Self {
        Self { squares: 32.0, light: Colour::hex(0xf2efe9), dark: Colour::hex(0x5b7f95) }
    }
}

/// How a number becomes a colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Heat {
    /// Which colours.
    pub map: Colormap,
    /// Which numbers; by default all that the scene has, with zero in the middle of a diverging map.
    pub range: Option<Range>,
    /// How much the lights show the shape, 0..1; at 0 colours are exactly those of the bar.
    pub relief: f32,
}

impl Default for Heat {
    fn default() -> Self {
        Self { map: Colormap::Diverging, range: None, relief: 0.5 }
    }
}

/// The numbers at the ends of a colour map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// At the first colour.
    pub low: f32,
    /// At the last colour.
    pub high: f32,
}

/// Why a text is not the settings of a picture.
#[derive(Debug, Error)]
pub enum SettingsError {
    /// Not JSON, an unknown field or a value of the wrong kind.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// A number out of its range.
    #[error("{name} must be {expected}")]
    OutOfRange {
        /// The field.
        name: &'static str,
        /// What it may be.
        expected: &'static str,
    },
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
        let Camera { yaw, pitch, distance, projection, .. } = self.camera;
        let field_of_view = match projection {
            Projection::Perspective { field_of_view } => field_of_view,
            Projection::Orthographic => 90.0,
        };
        let Material { specular, exponent, .. } = self.material;
        let amount = |x: f32| (0.0..=1e3).contains(&x);
        let light = |l: &Light| l.azimuth.is_finite() && l.elevation.is_finite() && amount(l.intensity);
        let ordered = |r: Range| r.low < r.high && (r.high - r.low).is_finite();
        let pixels = 1..=16_384;
        let rules = [
            (pixels.contains(&self.size.width), "size.width", "1..16384"),
            (pixels.contains(&self.size.height), "size.height", "1..16384"),
            ((1..=8).contains(&self.supersampling), "supersampling", "1..8"),
            (yaw.is_finite() && pitch.is_finite(), "camera.yaw and camera.pitch", "finite"),
            ((0.01..=1e3).contains(&distance), "camera.distance", "0.01..1000"),
            ((1.0..=150.0).contains(&field_of_view), "field_of_view", "1..150 degrees"),
            (amount(specular), "material.specular", "0..1000"),
            ((1.0..=1e4).contains(&exponent), "material.exponent", "1..10000"),
            (self.lights.len() <= MAX_LIGHTS, "lights", "at most four"),
            (self.lights.iter().all(light), "each light", "finite, its intensity 0..1000"),
            (amount(self.ambient.intensity), "ambient.intensity", "0..1000"),
            ((0.0..=1e5).contains(&self.checker.squares), "checker.squares", "0..100000"),
            (self.heat.range.is_none_or(ordered), "heat.range", "finite and ascending"),
            ((0.0..=1.0).contains(&self.heat.relief), "heat.relief", "0..1"),
        ];
        match rules.into_iter().find(|(holds, ..)| !holds) {
            Some((_, name, expected)) => Err(SettingsError::OutOfRange { name, expected }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::UpAxis;

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
