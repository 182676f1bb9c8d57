//! All that can be chosen for a bake.

use super::{Goal, LayoutChoice};
use crate::displacement::{MapKind, TexelFormat};
use crate::model::NormalSource;
use crate::texture::normal_map::Convention;
use crate::texture::{Interpolation, Texels, resolution};
use crate::weld::Welding;

/// All that can be chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Where the vertices shall go.
    pub goal: Goal,
    /// How the model was welded; goes into the manifest.
    pub welding: Welding,
    /// Along which normals to displace; none chooses, see [`Goal::ways`].
    pub normals: Option<NormalSource>,
    /// Strength for the normal map and the clients.
    pub lambda: Lambda,
    /// Heights or vectors.
    pub map: MapKind,
    /// Where texels of a vertex are.
    pub layout: LayoutChoice,
    /// Side of the maps; none chooses it. A map with one texel for each vertex has the side that it needs.
    pub side: Option<u32>,
    /// The largest side that is chosen.
    pub largest_side: LargestSide,
    /// How far a vertex may be off for [`LayoutChoice::Auto`] to keep the texture coordinates of the mesh.
    pub tolerance: Quanta,
    /// How texels between vertices are filled.
    pub interpolation: Interpolation,
    /// What is done to the texels that vertices sample.
    pub texels: Texels,
    /// Of the displacement map.
    pub texel: TexelFormat,
    /// Of the normal map.
    pub convention: Convention,
    /// What carries the map.
    pub carriers: Carriers,
}

/// Files with the mesh and the numbers of its map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Carriers {
    /// OBJ with MTL, and binary glTF.
    #[default]
    ObjAndGlb,
    /// OBJ with MTL.
    Obj,
}

/// Multiples of the step between two heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quanta(pub f64);

impl Default for Quanta {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LargestSide(pub u32);

impl Default for LargestSide {
    fn default() -> Self {
        Self(resolution::LARGEST_SIDE)
    }
}

/// Strength: 0 is the source, 1 is denoised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambda(pub f64);

impl Default for Lambda {
    fn default() -> Self {
        Self(1.0)
    }
}
