//! Entries of the displacement map, of what its texels mean, and of the normal map.

use crate::map::displacement::{Encoding, MapKind, TexelFormat};
use crate::map::normal_map::Convention;
use crate::map::{Interpolation, Size, Texels};
use crate::mesh::jagged::Index;
use crate::named;
use glam::{DVec3, IVec2};
use serde::{Deserialize, Serialize};

named! {
    /// Layout of a map: the rule by which a vertex has its texels.
    #[derive(Default)]
    pub enum Layout {
        /// A vertex samples the map at its texture coordinates.
        #[default]
        Uv = "uv",
        /// The i-th source vertex reads texel (i mod width, i div width), row 0 on top.
        Vertex = "vertex",
    }
}

named! {
    /// Origin of the texture coordinates of a map.
    #[derive(Default)]
    pub enum UvSource {
        /// The map uses the texture coordinates of the mesh.
        #[default]
        Mesh = "mesh",
        /// The map uses new texture coordinates that the bake made; only the carrier has them.
        Unwrapped = "unwrapped",
    }
}

impl UvSource {
    fn is_mesh(&self) -> bool {
        *self == Self::Mesh
    }
}

fn is_zero(tile: &IVec2) -> bool {
    *tile == IVec2::ZERO
}

/// The displacement map: p' = p − λ · (bias + scale · texel) · n.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapEntry {
    /// Name of the image file; with pages of the first of them, as width and height are.
    pub file: String,
    /// Kind of the map: heights or vectors.
    pub map: MapKind,
    /// Layout of the map: the rule by which a vertex has its texels.
    pub layout: Layout,
    /// Interpolation of the texels between vertices; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// Treatment of the texels that vertices sample; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texels: Option<Texels>,
    /// Origin of the texture coordinates of the map.
    #[serde(default, skip_serializing_if = "UvSource::is_mesh")]
    pub uvs: UvSource,
    /// Lower left corner of the tile in which the texture coordinates of the mesh lie. It is subtracted from them before any map is
    /// sampled at them.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tile: IVec2,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// File format and number of bits of a texel.
    #[serde(flatten)]
    pub texel: TexelFormat,
    /// Height at texel 0, model units; exact in single precision.
    pub bias: f64,
    /// Height at texel 1 minus bias, model units; exact in single precision.
    pub scale: f64,
    /// Strength λ that the bake was given: 0 is the source, 1 the denoised surface.
    pub lambda: f64,
    /// Point that is subtracted from positions before they become single precision, model units; zero for meshes near it.
    pub origin: DVec3,
}

impl MapEntry {
    /// Size of the image.
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height }
    }
    /// Format, bias and scale of the map.
    pub fn encoding(&self) -> Encoding {
        Encoding { texel: self.texel, bias: self.bias as f32, scale: self.scale as f32 }
    }
}

/// Texture coordinates at which vertices on seams sample. All wedges of a vertex sample at the same one, so that they are
/// displaced to the same position.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DominantUv {
    /// Rule by which the texture coordinate was chosen: criteria, the most important first.
    pub rule: String,
    /// Ascending pairs `[v, vt]`, both counted from 1 as in OBJ: `v` samples at `vt`. Vertices that are not listed have only
    /// one texture coordinate.
    pub seam_vertices: Vec<[Index; 2]>,
}

impl DominantUv {
    /// Pairs of [`Self::seam_vertices`], counted from 0.
    pub(super) fn pairs(&self) -> Vec<[Index; 2]> {
        self.seam_vertices.iter().map(|pair| pair.map(|i| i - 1)).collect()
    }
}

/// A source vertex and the texel that it reads; in JSON a list `[v, column, row]`. Of several source vertices that were welded each
/// is listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "[Index; 3]", into = "[Index; 3]")]
pub struct PrivateTexel {
    /// Number of the source vertex, counted from 1 as in OBJ.
    pub vertex: Index,
    /// Column of the texel, counted from 0 at the left.
    pub column: u32,
    /// Row of the texel, counted from 0 at the top.
    pub row: u32,
}

impl From<[Index; 3]> for PrivateTexel {
    fn from([vertex, column, row]: [Index; 3]) -> Self {
        Self { vertex, column, row }
    }
}

impl From<PrivateTexel> for [Index; 3] {
    fn from(PrivateTexel { vertex, column, row }: PrivateTexel) -> Self {
        [vertex, column, row]
    }
}

/// Entry of the normal map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NormalMapEntry {
    /// Name of the image file: 8-bit RGB, in the texture coordinates of the carrier.
    pub file: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Direction of the green channel.
    pub convention: Convention,
}
