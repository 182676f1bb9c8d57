//! Shadows, the ground, and what is around and behind the model.

use crate::colour::Colour;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Shadow maps of all lights that cast a shadow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shadows {
    /// How a shadow's edge looks.
    pub filter: ShadowFilter,
    /// Texels along a side of a map.
    pub map_size: u32,
    /// Most of the bias, max(slope · (1 − n·l), least): against acne on surfaces along the light.
    pub slope_bias: f32,
    /// Least of the bias.
    pub least_bias: f32,
    /// Which faces cast the shadow: without the front ones, the bias cannot part a shadow from its foot.
    pub culling: ShadowCulling,
    /// What light there is beyond the frustum that the map covers.
    pub beyond: Reach,
    /// Shows the map of the first light that has one instead of the picture: depth, linear from near to far.
    pub show_map: bool,
}

impl Default for Shadows {
    fn default() -> Self {
        Self {
            filter: ShadowFilter::Off,
            map_size: 2048,
            slope_bias: 0.05,
            least_bias: 0.005,
            culling: ShadowCulling::None,
            beyond: Reach::Lit,
            show_map: false,
        }
    }
}

/// How a shadow's edge looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ShadowFilter {
    /// There is no shadow.
    #[default]
    Off,
    /// One comparison.
    Hard,
    /// The mean of comparisons around (percentage-closer filtering, Reeves 1987).
    Pcf {
        /// Comparisons along a side: 3, 5 or 7.
        side: u32,
    },
    /// As wide as the distance from what casts it says (percentage-closer soft shadows, Fernando 2005).
    Soft {
        /// Diameter of the light, in radii of the model's bounds.
        light_size: f32,
    },
}

/// Faces that do not cast a shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowCulling {
    /// All faces cast one.
    #[default]
    None,
    /// Those that face the light do not.
    Front,
}

/// What light there is where the shadow map does not reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reach {
    /// All is lit.
    #[default]
    Lit,
    /// What the border of the map says goes on, as samplers that clamp have it.
    Clamped,
}

/// A plane below the model that receives shadows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ground {
    /// Whether there is one.
    pub visible: bool,
    /// Its colour.
    pub colour: Colour,
    /// Half its side, in radii of the model's bounds.
    pub extent: f32,
    /// How far below the lowest point of the model, in radii of its bounds.
    pub gap: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { visible: false, colour: Colour::hex(0xc9c7c2), extent: 4.0, gap: 0.0 }
    }
}

/// What the model is surrounded by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Environment {
    /// Where it comes from.
    pub source: Surroundings,
    /// About the up axis, degrees.
    pub turn: f32,
    /// Strength of its light.
    pub intensity: f32,
    /// Whether it is seen behind the model.
    pub background: bool,
    /// Whether its mean light from each side takes the place of [`Ambient`](crate::lights::Ambient).
    pub ambient: bool,
    /// Share of the light that the surface mirrors, 0..1.
    pub reflection: f32,
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            source: Surroundings::None,
            turn: 0.0,
            intensity: 1.0,
            background: true,
            ambient: true,
            reflection: 0.0,
        }
    }
}

/// Where the environment comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Surroundings {
    /// There is none.
    #[default]
    None,
    /// From files: the scene's.
    Given,
    /// A desert that is computed.
    Desert,
    /// A field of ice that is computed.
    Ice,
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
