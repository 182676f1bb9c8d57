//! What maps do to the surface.

use serde::{Deserialize, Serialize};

/// What the displacement map does: p' = p − λ · (bias + scale · texel) · n.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Map {
    /// λ: 0 draws the noisy surface, 1 the denoised one.
    pub lambda: f32,
    /// What the displaced surface is lit with.
    pub normals: Normals,
}

impl Default for Map {
    fn default() -> Self {
        Self { lambda: 1.0, normals: Normals::default() }
    }
}

/// Normals of the displaced surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Normals {
    /// Those that the mesh has: the noise goes on being lit.
    Base,
    /// The tangent-space normal map, baked or given: base normals where there is none.
    Map,
    /// Angle-weighted over the displaced faces around each vertex: right for every λ.
    #[default]
    Derived,
}

/// A height map as an effect: p' = p + λ · (bias + scale · height) · n, lengths in radii of the model's bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Relief {
    /// Strength of the displacement; [`Shading::Displacement`](super::Shading::Displacement) only.
    pub lambda: f32,
    /// Height at a black texel.
    pub bias: f32,
    /// Height of a white texel above that of a black one.
    pub scale: f32,
    /// How much of the slope of the heights tilts the normals. 0 leaves them alone.
    pub bump: f32,
}

impl Default for Relief {
    fn default() -> Self {
        Self { lambda: 0.1, bias: 0.0, scale: 1.0, bump: 1.0 }
    }
}
