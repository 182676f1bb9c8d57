//! Why a bake fails.

#[cfg(doc)]
use super::LayoutChoice;
use crate::bake::gltf::GltfError;
use crate::denoise::limits::LimitsError;
#[cfg(doc)]
use crate::map::displacement::MapKind;
use crate::map::displacement::{DecodeError, EncodeError};
use crate::mesh::atlas::AtlasError;
use crate::progress::Cancelled;
use crate::source::model::NoFileNormals;
#[cfg(doc)]
use crate::source::model::NormalSource;
use crate::source::obj::ObjError;

/// Why there is no bundle.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// No layout.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// [`MapKind::VectorTangent`] without texture coordinates.
    #[error("tangent space needs texture coordinates, and the mesh has none")]
    NoTangents,
    /// [`NormalSource::File`] without normals in the file.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// Limits that do not fit the mesh.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// An image could not be made.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// What was written did not read back: the fault is here.
    #[error("the map does not read back: {0}")]
    Decode(#[from] DecodeError),
    /// The same for the carrier.
    #[error("the carrier does not read back: {0}")]
    Carrier(#[from] ObjError),
    /// The mesh does not fit into glTF.
    #[error(transparent)]
    Gltf(#[from] GltfError),
    /// The heights left what single precision can hold.
    #[error("denoising gave heights that are not finite numbers in single precision")]
    NotFinite,
    /// [`LayoutChoice::Unwrap`] without the feature for it.
    #[error("planish was built without the feature `unwrap`")]
    CannotUnwrap,
    /// No atlas could be made.
    #[cfg(feature = "unwrap")]
    #[error("cannot be unwrapped: {0}")]
    Unwrap(crate::bake::unwrap::UnwrapError),
    /// The charts of an atlas are too many for a map, with the gutters between them.
    #[error("the charts of the new atlas do not fit into {side} × {side} texels")]
    NoRoom {
        /// Side of the largest map that was tried.
        side: u32,
    },
    /// A carrier whose faces are not those of the mesh.
    #[error("the carrier has no texture coordinates for the faces of the mesh")]
    OtherFaces,
    /// As asked.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
