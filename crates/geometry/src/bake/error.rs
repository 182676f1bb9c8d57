//! Errors of a bake.

use super::LayoutChoice;
use crate::bake::gltf::GltfError;
use crate::denoise::limits::LimitsError;
use crate::map::displace::MeshError;
#[cfg(doc)]
use crate::map::displacement::MapKind;
use crate::map::displacement::{DecodeError, EncodeError};
use crate::map::pages::TooManyPages;
use crate::mesh::atlas::AtlasError;
use crate::mesh::jagged::Index;
use crate::progress::Cancelled;
use crate::source::model::NoFileNormals;
#[cfg(doc)]
use crate::source::model::NormalSource;
use crate::source::obj::ObjError;

/// Reasons why a bake fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The texture coordinates are missing or unusable.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// [`MapKind::VectorTangent`] needs texture coordinates, and the mesh has none.
    #[error("tangent space needs texture coordinates, and the mesh has none")]
    NoTangents,
    /// [`NormalSource::File`] needs normals in the file, and there are none.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// The limits do not fit the mesh.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// An image file could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The encoded map could not be decoded again, which is a fault of this library.
    #[error("the map cannot be read back: {0}")]
    Decode(#[from] DecodeError),
    /// The printed carrier could not be parsed again, which is a fault of this library.
    #[error("the carrier cannot be read back: {0}")]
    Carrier(#[from] ObjError),
    /// The mesh does not fit into glTF.
    #[error(transparent)]
    Gltf(#[from] GltfError),
    /// A displacement is too large for single precision, or not a number.
    #[error("denoising gave heights that are too large for single precision or not finite")]
    NotFinite,
    /// A vertex that a face uses is too far from the others for single precision, in which maps are applied.
    #[error("vertex {source_vertex} is too far away for single precision")]
    TooFar {
        /// Index of the source vertex, from 0.
        source_vertex: Index,
    },
    /// The manifest would hold a number that is not finite, and could not be read again.
    #[error("the errors of the map cannot be measured in double precision: coordinates are too large or too small")]
    NotMeasurable,
    /// [`LayoutChoice::Unwrap`] needs the feature `unwrap`.
    #[error("planish was built without the feature `unwrap`")]
    CannotUnwrap,
    /// The mesh could not be unwrapped.
    #[cfg(feature = "unwrap")]
    #[error("cannot be unwrapped: {0}")]
    Unwrap(crate::bake::unwrap::UnwrapError),
    /// The charts of the new atlas, with the gutters between them, do not fit into the largest map.
    #[error("the charts of the new atlas do not fit into {side} × {side} texels")]
    ChartsDoNotFit {
        /// Side of the largest map that was tried, texels.
        side: u32,
    },
    /// The mesh has other elements than the manifest says.
    #[error(transparent)]
    OtherMesh(#[from] MeshError),
    /// The mesh would need too many pages.
    #[error(transparent)]
    TooManyPages(#[from] TooManyPages),
    /// Pages need the texture coordinates of the mesh.
    #[error("pages do not go with the layout `{}`", .0.name())]
    PagesWithLayout(LayoutChoice),
    /// An image file of a page could not be decoded.
    #[error("page {page}: {error}")]
    DecodePage {
        /// Name of the part that has the page.
        page: String,
        /// Reason.
        error: DecodeError,
    },
    /// The mesh has other parts than the manifest says.
    #[error("the pages of the manifest are not the parts of the mesh")]
    OtherPages,
    /// The carrier has other elements than the manifest says.
    #[error("the carrier {0}")]
    OtherCarrier(MeshError),
    /// The faces of the carrier are not those of the mesh, or have no texture coordinates.
    #[error("the carrier has no texture coordinates for the faces of the mesh")]
    OtherFaces,
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
