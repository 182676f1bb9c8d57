//! Settings of the shadows.
//!
//! ```
//! use planish_render::settings::shadow::{Filter, Shadow};
//! use planish_render::settings::{Settings, SettingsError};
//!
//! let soft = Shadow { filter: Filter::Pcss, light_angle: 10.0, ..Shadow::default() };
//! soft.check()?;
//! assert_eq!(Settings::from_json(br#"{ "shadow": { "filter": "pcss", "light_angle": 10 } }"#)?.shadow, soft);
//! assert_eq!(Shadow { kernel: 4, ..soft }.check().unwrap_err().to_string(), "shadow.kernel must be 3, 5 or 7");
//! # Ok::<(), SettingsError>(())
//! ```

use super::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};

/// Shadows that all lights cast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shadow {
    /// Filter of the lookups in shadow maps.
    pub filter: Filter,
    /// Number of texels along a side of a map.
    pub size: u32,
    /// Texels along a side of the square whose mean is taken by [`Filter::Pcf`]: 3, 5 or 7.
    pub kernel: u32,
    /// Slope-dependent bias, in radii of the model's bounding sphere. A place is looked up max(slope_bias · (1 − n·l),
    /// least_bias) nearer to the light than it is: too little shows as acne, too much detaches shadows from their casters.
    pub slope_bias: f32,
    /// Least bias, see [`Self::slope_bias`].
    pub least_bias: f32,
    /// Angle that lights subtend from the middle of the model, degrees, for [`Filter::Pcss`].
    pub light_angle: f32,
    /// Projection of a light's view onto its map.
    pub projection: LightProjection,
    /// Half the width of the map of a light far away, in radii of the model's bounding sphere.
    pub extent: f32,
    /// Triangles that are drawn into the maps.
    pub casters: Casters,
    /// Light at places that no map covers.
    pub outside: Outside,
    /// Number of a map to show in place of the picture, its depth from black (near) to white (far); a point light has
    /// six maps.
    pub show_map: Option<u32>,
}

impl Default for Shadow {
    fn default() -> Self {
        Self {
            filter: Filter::default(),
            size: 2048,
            kernel: 3,
            slope_bias: 0.05,
            least_bias: 0.005,
            light_angle: 6.0,
            projection: LightProjection::default(),
            extent: 1.0,
            casters: Casters::default(),
            outside: Outside::default(),
            show_map: None,
        }
    }
}

named! {
/// Filter of the lookups in shadow maps.
pub enum Filter {
    /// There are no shadows.
    #[default]
    None = "none",
    /// One texel: jagged edges.
    Hard = "hard",
    /// The mean of a square of answers, each blended between four texels (percentage-closer filtering, Reeves, Salesin,
    /// Cook, SIGGRAPH 1987).
    Pcf = "pcf",
    /// The further the caster, the wider the penumbra (percentage-closer soft shadows, Fernando, SIGGRAPH sketches 2005).
    Pcss = "pcss",
}
}

named! {
/// Projection of a light's view onto its shadow map. A point light always sees six squares in perspective.
pub enum LightProjection {
    /// Parallel rays for a light far away, perspective for a spot.
    #[default]
    Fitting = "fitting",
    /// Parallel rays for every light.
    Orthographic = "orthographic",
    /// Perspective for every light; one far away is taken to be four radii from the middle of the model.
    Perspective = "perspective",
}
}

named! {
/// Triangles that are drawn into shadow maps.
pub enum Casters {
    /// Both sides of every triangle cast shadows.
    #[default]
    All = "all",
    /// Triangles that face away from the light cast shadows: closed surfaces need hardly any bias then, and shadows stay
    /// with their casters.
    BackFaces = "back-faces",
}
}

named! {
/// Light at places that no shadow map covers.
pub enum Outside {
    /// Such places are lit, and so are those that lie further away than a map reaches.
    #[default]
    Lit = "lit",
    /// Such places get what the map has if it is repeated like a texture. This is wrong, and here to be seen.
    Repeated = "repeated",
}
}

impl Shadow {
    /// Refuses numbers that no shadow can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        let bias = |x: f32| (0.0..=10.0).contains(&x);
        require(&[
            ((16..=8192).contains(&self.size), "shadow.size", "16..8192"),
            (matches!(self.kernel, 3 | 5 | 7), "shadow.kernel", "3, 5 or 7"),
            (bias(self.slope_bias) && bias(self.least_bias), "shadow.slope_bias and shadow.least_bias", "0..10"),
            ((0.0..=60.0).contains(&self.light_angle), "shadow.light_angle", "0..60 degrees"),
            ((0.1..=100.0).contains(&self.extent), "shadow.extent", "0.1..100"),
        ])
    }
}
