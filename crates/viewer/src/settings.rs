//! One value that says everything about a picture: what headless mode loads, and what a reference
//! image is drawn from.

use crate::camera::{Camera, Projection};
use crate::colour::Colour;
use crate::environment::Surroundings;
use crate::ground::Ground;
use crate::lights::{Ambient, Light, LightKind, MAX_LIGHTS};
use crate::shadow::Shadow;
use clap::ValueEnum;
use planish_geometry::colormap::Colormap;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use thiserror::Error;

/// A closed set of choices, each with a number for the shaders.
macro_rules! named {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$attribute:meta])* $variant:ident,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name {
            $($(#[$attribute])* $variant,)+
        }

        impl $name {
            /// All there are; the place of each in the list is its number in the shaders.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];
        }
    };
}
pub(crate) use named;

/// All that a picture depends on, beside the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Of the picture.
    pub size: Size,
    /// Samples per pixel in each direction, averaged in linear light; on a GPU on top of its own four.
    pub supersampling: u32,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// How far the map moves the vertices.
    pub displace: Displace,
    /// What the surface shows.
    pub shading: Shading,
    /// What is drawn on top of it.
    pub overlay: Overlay,
    /// How textures are read between their texels.
    pub sampling: Sampling,
    /// What the surface is made of.
    pub material: Material,
    /// At most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// How they cast shadows.
    pub shadow: Shadow,
    /// Under the model.
    pub ground: Ground,
    /// Light from everywhere.
    pub ambient: Ambient,
    /// Behind the model.
    pub background: Background,
    /// Instead of both: a landscape all around.
    pub environment: Option<Surroundings>,
    /// For [`Shading::Checker`].
    pub checker: Checker,
    /// For [`Shading::Marble`].
    pub marble: Marble,
    /// For [`Shading::Height`] and [`Shading::Heat`].
    pub heat: Heat,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: Size::default(),
            supersampling: 3,
            camera: Camera::default(),
            displace: Displace::default(),
            shading: Shading::default(),
            overlay: Overlay::default(),
            sampling: Sampling::default(),
            material: Material::default(),
            lights: Light::key_and_fill(),
            shadow: Shadow::default(),
            ground: Ground::default(),
            ambient: Ambient::default(),
            background: Background::default(),
            environment: None,
            checker: Checker::default(),
            marble: Marble::default(),
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

/// How far the map of the scene moves the vertices: p' = p − λ · (bias + scale · texel) · n.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Displace {
    /// Strength: 0 leaves the mesh as it is, at 1 it is denoised.
    pub lambda: f32,
    /// Height at texel 0 in model units, instead of the map's own.
    pub bias: Option<f32>,
    /// Height from texel 0 to texel 1 in model units, instead of the map's own.
    pub scale: Option<f32>,
    /// Which normals light the displaced surface.
    pub normals: Normals,
}

impl Default for Displace {
    fn default() -> Self {
        Self { lambda: 1.0, bias: None, scale: None, normals: Normals::default() }
    }
}

named! {
/// Which normals light a displaced surface. A scene without a map is lit with those of its file.
pub enum Normals {
    /// Those of the displaced positions.
    #[default]
    Derived,
    /// Those of the mesh before it was displaced.
    Base,
    /// The baked normal map, as much of it as λ says.
    Map,
}
}

named! {
/// What the surface shows.
pub enum Shading {
    /// Lit with the normal of each triangle: shows the noise as it is.
    Flat,
    /// Lit at the vertices, and colours blended in between (Gouraud 1971).
    Gouraud,
    /// Lit at each pixel with blended vertex normals (Blinn-Phong).
    #[default]
    Phong,
    /// The same with the texture of the material.
    Texture,
    /// The same with normals tilted by the slope of the height map (Blinn 1978); without a map like Phong.
    Bump,
    /// The same with the normals of the normal map; without one like Phong.
    NormalMap,
    /// Matte clay under a studio's light, whatever the lights: for judging noise.
    Clay,
    /// Normals as colours: n in model space is (2·rgb − 1) of the stored values.
    Normals,
    /// A chequered texture: shows how the texture coordinates stretch.
    Checker,
    /// The same with veins of noise in three dimensions: a texture that needs no texture coordinates (Perlin 1985).
    Marble,
    /// The heights of the map, or the lengths of its vectors.
    Height,
    /// A number per vertex through a colour map: how far off each is, say.
    Heat,
}
}

named! {
/// What is drawn on top of the surface.
pub enum Overlay {
    /// Nothing.
    #[default]
    None,
    /// The edges of the mesh.
    Wireframe,
    /// The edges at which the texture is cut.
    Seams,
}
}

named! {
/// How textures are read between their texels.
pub enum Sampling {
    /// The nearest texel.
    Nearest,
    /// Between the four nearest texels.
    Bilinear,
    /// A cubic B-spline over sixteen texels, which is smooth and blurs a little.
    Bicubic,
    /// Between the eight nearest texels of two levels of detail.
    #[default]
    Trilinear,
    /// The same, up to sixteen times along the direction in which the texture is squeezed.
    Anisotropic,
}
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

/// Veins in a stone of the material's colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Marble {
    /// Cells of the noise along a radius of the model's bounding sphere.
    pub frequency: f32,
    /// Of the veins.
    pub colour: Colour,
}

impl Default for Marble {
    fn default() -> Self {
        Self { frequency: 2.5, colour: Colour::hex(0x4a4038) }
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
        let Camera { yaw, pitch, distance, target, projection, .. } = self.camera;
        let field_of_view = match projection {
            Projection::Perspective { field_of_view } => field_of_view,
            Projection::Orthographic => 90.0,
        };
        let Material { specular, exponent, .. } = self.material;
        let amount = |x: f32| (0.0..=1e3).contains(&x);
        let light = |l: &Light| {
            let near = |distance: f32| (0.01..=1e3).contains(&distance);
            let kind = match l.kind {
                LightKind::Directional => true,
                LightKind::Point { distance } => near(distance),
                LightKind::Spot { distance, angle } => near(distance) && (1.0..=170.0).contains(&angle),
            };
            l.azimuth.is_finite() && l.elevation.is_finite() && amount(l.intensity) && kind
        };
        let given = |x: Option<f32>| x.is_none_or(f32::is_finite);
        let ordered = |r: Range| r.low < r.high && (r.high - r.low).is_finite();
        let pixels = 1..=16_384;
        let rules = [
            (pixels.contains(&self.size.width), "size.width", "1..16384"),
            (pixels.contains(&self.size.height), "size.height", "1..16384"),
            ((1..=8).contains(&self.supersampling), "supersampling", "1..8"),
            (yaw.is_finite() && pitch.is_finite(), "camera.yaw and camera.pitch", "finite"),
            ((0.01..=1e3).contains(&distance), "camera.distance", "0.01..1000"),
            (target.abs().max_element() <= 1e3, "camera.target", "at most 1000 radii away"),
            ((1.0..=150.0).contains(&field_of_view), "field_of_view", "1..150 degrees"),
            (self.displace.lambda.abs() <= 1e6, "displace.lambda", "a strength"),
            (given(self.displace.bias) && given(self.displace.scale), "displace.bias and displace.scale", "finite"),
            (amount(specular), "material.specular", "0..1000"),
            ((1.0..=1e4).contains(&exponent), "material.exponent", "1..10000"),
            (self.lights.len() <= MAX_LIGHTS, "lights", "at most four"),
            (
                self.lights.iter().all(light),
                "each light",
                "finite, its intensity 0..1000, its distance 0.01..1000, its angle 1..170",
            ),
            (amount(self.ambient.intensity), "ambient.intensity", "0..1000"),
            ((0.0..=1e5).contains(&self.checker.squares), "checker.squares", "0..100000"),
            ((0.0..=1e5).contains(&self.marble.frequency), "marble.frequency", "0..100000"),
            (self.heat.range.is_none_or(ordered), "heat.range", "finite and ascending"),
            ((0.0..=1.0).contains(&self.heat.relief), "heat.relief", "0..1"),
        ];
        require(&rules)?;
        self.shadow.check()?;
        self.ground.check()?;
        self.environment.as_ref().map_or(Ok(()), Surroundings::check)
    }
}

/// Refuses by name what breaks the first rule that does not hold: (holds, field, what it may be).
pub(crate) fn require(rules: &[(bool, &'static str, &'static str)]) -> Result<(), SettingsError> {
    match rules.iter().find(|(holds, ..)| !holds) {
        Some(&(_, name, expected)) => Err(SettingsError::OutOfRange { name, expected }),
        None => Ok(()),
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
            (r#"{ "shadow": { "kernel": 4 } }"#, "shadow.kernel"),
            (r#"{ "shadow": { "filter": "soft" } }"#, "soft"),
            (r#"{ "ground": { "size": 0 } }"#, "ground.size"),
            (r#"{ "environment": { "roughness": 2 } }"#, "environment.roughness"),
            (r#"{ "environment": { "source": "moon" } }"#, "moon"),
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
