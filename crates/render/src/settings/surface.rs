//! Settings of what the surface shows.

use super::rules::{SettingsError, named, require};
use crate::colour::Colour;
use planish_geometry::metrics::colormap::Colormap;
use serde::{Deserialize, Serialize};

named! {
/// Shading of the surface.
pub enum Shading {
    /// Lit with the normal of each triangle: shows the noise as it is.
    Flat = "flat",
    /// Lit at the vertices, and colours blended in between (Gouraud 1971).
    Gouraud = "gouraud",
    /// Lit at each pixel with blended vertex normals (Blinn-Phong).
    #[default]
    Phong = "phong",
    /// Phong with the texture of the material.
    Texture = "texture",
    /// Phong with normals tilted by the slope of the height map (Blinn 1978); plain Phong without a map.
    Bump = "bump",
    /// Phong with the normals of the normal map; plain Phong without one.
    NormalMap = "normal-map",
    /// Matte clay under a studio's light, whatever the lights: for judging noise.
    Clay = "clay",
    /// Normals as colours: n in model space is (2·rgb − 1) of the stored values.
    Normals = "normals",
    /// Phong with a chequered texture: shows how the texture coordinates stretch.
    Checker = "checker",
    /// Phong with veins of noise in three dimensions: a texture that needs no texture coordinates (Perlin 1985).
    Marble = "marble",
    /// Phong with the colours of a volume where the surface lies after its displacement, as if it were cut from the volume: a
    /// solid texture. The material's colour without a volume.
    Solid = "solid",
    /// The heights of the map, or the lengths of its vectors.
    Height = "height",
    /// A number per vertex through a colour map: its error, say.
    Heat = "heat",
}
}

named! {
/// Lines on top of the surface.
pub enum Overlay {
    /// There are no lines.
    #[default]
    None = "none",
    /// The edges of the mesh.
    Wireframe = "wireframe",
    /// The edges at which the texture is cut.
    Seams = "seams",
}
}

named! {
/// Interpolation of textures between their texels.
pub enum Sampling {
    /// The nearest texel.
    Nearest = "nearest",
    /// Between the four nearest texels.
    Bilinear = "bilinear",
    /// A cubic B-spline over sixteen texels, which is smooth and blurs a little.
    Bicubic = "bicubic",
    /// Between the eight nearest texels of two levels of detail.
    #[default]
    Trilinear = "trilinear",
    /// Trilinear, with up to sixteen samples along the direction in which the texture is squeezed.
    Anisotropic = "anisotropic",
}
}

/// Material of the surface (Blinn-Phong).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Colour where the scene has no texture.
    pub colour: Colour,
    /// Strength of the highlight.
    pub specular: f32,
    /// Sharpness of the highlight.
    pub exponent: f32,
}

impl Default for Material {
    /// Material of unglazed clay.
    fn default() -> Self {
        Self { colour: Colour::hex(0xe2c4ae), specular: 0.12, exponent: 28.0 }
    }
}

impl Material {
    /// Refuses numbers that no highlight can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[
            ((0.0..=1e3).contains(&self.specular), "material.specular", "0..1000"),
            ((1.0..=1e4).contains(&self.exponent), "material.exponent", "1..10000"),
        ])
    }
}

/// Chequered texture over the unit square of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Checker {
    /// Squares along a side of the unit square.
    pub squares: f32,
    /// Colour of the square at the origin.
    pub light: Colour,
    /// Colour of its neighbours.
    pub dark: Colour,
}

impl Default for Checker {
    fn default() -> Self {
        Self { squares: 32.0, light: Colour::hex(0xf2efe9), dark: Colour::hex(0x5b7f95) }
    }
}

impl Checker {
    /// Refuses a number of squares that cannot be drawn.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[((0.0..=1e5).contains(&self.squares), "checker.squares", "0..100000")])
    }
}

/// Veins in a stone of the material's colour.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Marble {
    /// Cells of the noise along a radius of the model's bounding sphere.
    pub frequency: f32,
    /// Colour of the veins.
    pub colour: Colour,
}

impl Default for Marble {
    fn default() -> Self {
        Self { frequency: 2.5, colour: Colour::hex(0x4a4038) }
    }
}

impl Marble {
    /// Refuses a frequency that cannot be drawn.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[((0.0..=1e5).contains(&self.frequency), "marble.frequency", "0..100000")])
    }
}

/// Mapping from numbers to colours.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Heat {
    /// Colours of the map.
    pub map: Colormap,
    /// Numbers that the colours stand for; `None` takes all that the scene has, with zero in the middle of a diverging map.
    pub range: Option<Range>,
    /// Visibility of the shape through the lights, 0..1; at 0 colours are exactly those of the bar.
    pub relief: f32,
}

impl Default for Heat {
    fn default() -> Self {
        Self { map: Colormap::Diverging, range: None, relief: 0.5 }
    }
}

impl Heat {
    /// Refuses a range that is empty or infinite, and a relief out of its range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let ordered = |r: Range| r.low < r.high && (r.high - r.low).is_finite();
        require(&[
            (self.range.is_none_or(ordered), "heat.range", "finite and ascending"),
            ((0.0..=1.0).contains(&self.relief), "heat.relief", "0..1"),
        ])
    }
}

/// Numbers at the ends of a colour map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// Number at the first colour.
    pub low: f32,
    /// Number at the last colour.
    pub high: f32,
}
