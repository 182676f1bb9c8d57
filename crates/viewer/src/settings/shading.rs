//! What the surface shows.

use crate::colormap::Colormap;
use crate::colour::Colour;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// What the surface shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// Lit with the normal of each triangle: shows the noise as it is.
    Flat,
    /// Lit at the vertices, and the light interpolated (Gouraud 1971).
    Gouraud,
    /// Lit at each pixel with interpolated normals (Blinn 1977), in the colour of the material.
    BlinnPhong,
    /// The same in the colours of the texture, where there is one.
    #[default]
    #[serde(alias = "smooth")]
    #[value(alias = "smooth")]
    Texture,
    /// Normals as colours: n in model space is (2·rgb − 1) of the stored values.
    Normals,
    /// The same as [`Self::Texture`], with normals tilted by the slope of a height map (Blinn 1978).
    Bump,
    /// The same, and the vertices moved along their normals by these heights.
    Displacement,
    /// A lump of clay in the light of a studio, which shows every dent from every side (a matcap).
    Clay,
    /// A chequered texture: shows how the texture coordinates stretch.
    Checker,
    /// A number per vertex through a colour map.
    Heat,
}

impl Shading {
    /// Each of them, for tests and lists to choose from.
    pub const ALL: [Self; 10] = [
        Self::Flat,
        Self::Gouraud,
        Self::BlinnPhong,
        Self::Texture,
        Self::Normals,
        Self::Bump,
        Self::Displacement,
        Self::Clay,
        Self::Checker,
        Self::Heat,
    ];
}

/// What the surface is made of (Blinn-Phong).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Where the scene has no texture.
    pub colour: Colour,
    /// How the colour varies in space.
    pub pattern: Pattern,
    /// Strength of the highlight.
    pub specular: f32,
    /// Sharpness of the highlight.
    pub exponent: f32,
}

impl Default for Material {
    /// Unglazed clay.
    fn default() -> Self {
        Self { colour: Colour::hex(0xe2c4ae), pattern: Pattern::Plain, specular: 0.12, exponent: 28.0 }
    }
}

/// How the material's colour varies in space, without a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Pattern {
    /// Not at all.
    #[default]
    Plain,
    /// Veins of noise in three dimensions (Perlin 1985, 2002): needs no texture coordinates.
    Noise {
        /// Waves across the model.
        frequency: f32,
        /// Of the veins.
        colour: Colour,
    },
}

/// How pictures on the surface are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// Between texels.
    pub filter: Filter,
    /// For [`Filter::Anisotropic`]: samples along the longer side of a pixel's footprint, 2, 4, 8 or 16.
    pub anisotropy: u16,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { filter: Filter::default(), anisotropy: 8 }
    }
}

/// How a texture is read between and beyond its texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// Between the nearest four.
    Bilinear,
    /// Between the nearest sixteen (Catmull-Rom).
    Bicubic,
    /// Between two levels of a mip chain, bilinear in each (Williams 1983).
    #[default]
    Trilinear,
    /// Several of these along the longer side of a pixel's footprint.
    Anisotropic,
}

impl Filter {
    /// Each of them, for tests and lists to choose from.
    pub const ALL: [Self; 5] = [Self::Nearest, Self::Bilinear, Self::Bicubic, Self::Trilinear, Self::Anisotropic];
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
    /// Which numbers.
    pub source: HeatSource,
    /// Which colours.
    pub map: Colormap,
    /// Which numbers the ends stand for; by default all that the scene has, with zero in the middle of a diverging map.
    pub range: Option<Range>,
    /// How much the lights show the shape, 0..1; at 0 colours are exactly those of the bar.
    pub relief: f32,
}

impl Default for Heat {
    fn default() -> Self {
        Self { source: HeatSource::default(), map: Colormap::Diverging, range: None, relief: 0.5 }
    }
}

/// Numbers of the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum HeatSource {
    /// Those given with the mesh.
    Given,
    /// What the map says: how far the noise lifted the vertex, model units. Of vectors, their length.
    #[default]
    Height,
    /// How far the map at λ = 1 leaves the vertex off the place where the denoiser wants it, model units.
    Error,
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
