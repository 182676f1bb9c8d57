//! Settings of the displacement.

use super::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};

/// Displacement of the vertices by the map of the scene: p' = p − λ · (bias + scale · texel) · n.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Displace {
    /// Strength λ: 0 leaves the mesh as it is, at 1 it is denoised.
    pub lambda: f32,
    /// Height at texel 0 in model units; `None` takes the map's own.
    pub bias: Option<f32>,
    /// Height from texel 0 to texel 1 in model units; `None` takes the map's own.
    pub scale: Option<f32>,
    /// Normals that light the displaced surface.
    pub normals: Normals,
}

impl Default for Displace {
    fn default() -> Self {
        Self { lambda: 1.0, bias: None, scale: None, normals: Normals::default() }
    }
}

named! {
/// Normals that light a displaced surface. A scene without a map is lit with the normals of its file.
pub enum Normals {
    /// Normals of the displaced positions.
    #[default]
    Derived = "derived",
    /// Normals of the mesh before it was displaced.
    Base = "base",
    /// The baked normal map, as much of it as λ says.
    Map = "map",
}
}

impl Displace {
    /// Refuses numbers that no vertex can be displaced by.
    pub fn check(&self) -> Result<(), SettingsError> {
        let given = |x: Option<f32>| x.is_none_or(f32::is_finite);
        require(&[
            (self.lambda.abs() <= 1e6, "displace.lambda", "a strength"),
            (given(self.bias) && given(self.scale), "displace.bias and displace.scale", "finite"),
        ])
    }
}
