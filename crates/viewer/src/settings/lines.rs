//! Lines on the surface.

use crate::colour::Colour;
use serde::{Deserialize, Serialize};

/// Lines over whatever the surface shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Overlay {
    /// All edges of all triangles, in this colour.
    pub wireframe: Option<Colour>,
    /// Edges along which the texture coordinates are cut, in this colour.
    pub seams: Option<Colour>,
    /// Of the lines, pixels.
    pub width: f32,
}

impl Default for Overlay {
    fn default() -> Self {
        Self { wireframe: None, seams: None, width: 1.25 }
    }
}

impl Overlay {
    /// A thin dark blue.
    pub const WIREFRAME: Colour = Colour::hex(0x1d2b3a);
    /// A red that no material has.
    pub const SEAMS: Colour = Colour::hex(0xd6204e);
}
