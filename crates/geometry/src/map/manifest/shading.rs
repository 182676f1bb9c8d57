//! Entries of the maps of precomputed shading.

use super::Layout;
use crate::map::Size;
use serde::{Deserialize, Serialize};

/// A grey picture with 8 bits that belongs to the denoised surface.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadingMapEntry {
    /// Name of the image file.
    pub file: String,
    /// Layout of the picture, which need not be that of the displacement map: the texture coordinates of the carrier, if each texel
    /// holds one place of the surface there, else one texel for each source vertex.
    pub layout: Layout,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl ShadingMapEntry {
    /// Size of the image.
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height }
    }
}

/// Entry of the ambient occlusion map: white where all ambient light arrives, black where none does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OcclusionEntry {
    /// File and layout.
    #[serde(flatten)]
    pub map: ShadingMapEntry,
    /// Number of rays of each texel.
    pub rays: u32,
    /// Distance beyond which nothing blocks the light, model units; `None` has no such bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
}

/// Entry of the curvature map: mean curvature = range · (2 · texel − 1), clamped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvatureEntry {
    /// File and layout.
    #[serde(flatten)]
    pub map: ShadingMapEntry,
    /// Mean curvature at texel 1, one over model units; 0 where the whole surface is flat.
    pub range: f64,
}
