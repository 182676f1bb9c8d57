//! The whole bake: a model becomes the files of a displacement map, each as bytes.
//!
//! Whoever bakes, the command line or a window, writes these bytes and nothing else.

mod carrier;
mod check;
mod describe;
mod draft;
mod error;
pub mod gltf;
mod layout;
mod maps;
mod report;
mod settings;
mod target;
#[cfg(feature = "unwrap")]
pub mod unwrap;
#[cfg(feature = "unwrap")]
mod unwrapped;

pub use check::{WrittenFiles, check};
pub use error::BakeError;
pub use layout::{Fallback, LayoutChoice};
pub use settings::{BakeSettings, Carriers, Lambda, LargestSide, Quanta};
pub use target::{BakeTarget, VertexDisplacements};

use crate::map::displace::Directions;
use crate::map::displacement::MapKind;
use crate::map::manifest::Manifest;
use crate::map::map_size::Choice;
use crate::mesh::atlas::{Atlas, AtlasError};
use crate::progress::Progress;
use crate::source::model::Model;
use draft::Draft;

/// What belongs to a source and lies in other files.
#[derive(Clone, Copy)]
pub struct SideFiles<'a> {
    /// Its material libraries.
    pub libraries: &'a [Vec<u8>],
    /// Turns the name of a texture as it stands in them into one that holds where the carrier will lie.
    pub relocate: &'a (dyn Fn(&str) -> String + Sync),
    /// The bytes of a texture, by its name in the libraries.
    pub texture: &'a (dyn Fn(&str) -> Option<Vec<u8>> + Sync),
}

impl SideFiles<'_> {
    /// Nothing.
    pub const NONE: SideFiles<'static> = SideFiles { libraries: &[], relocate: &str::to_owned, texture: &|_| None };
}

/// What the files are called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleNames {
    /// The source as the manifest shall name it.
    pub source: String,
    /// Beginning of the names of the maps and the manifest.
    pub stem: String,
    /// Beginning of the names of the carrier and its materials.
    pub carrier: String,
}

/// A file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Name without a folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// The result of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Maps, carrier and materials; the manifest comes last.
    pub files: Vec<BundleFile>,
    /// What the last file says.
    pub manifest: Manifest,
    /// Why the size was chosen; none where it was given or follows from the number of vertices.
    pub choice: Option<Choice>,
    /// Why the texture coordinates of the mesh were not used; none where they were, or were not asked for.
    pub fallback: Option<Fallback>,
    /// Directions that the map displaces along, for [`displace::model_vertices`].
    pub along: Directions,
}

/// Whether [`LayoutChoice::Unwrap`] is there: the feature `unwrap`.
pub const CAN_UNWRAP: bool = cfg!(feature = "unwrap");

/// A bake as it was asked for.
#[derive(Clone, Copy)]
struct Request<'a> {
    model: &'a Model,
    names: &'a BundleNames,
    side_files: SideFiles<'a>,
    settings: &'a BakeSettings,
    progress: &'a dyn Progress,
}

impl Request<'_> {
    /// The layout of the model's texture coordinates; none where the bake can do without.
    fn atlas(&self) -> Result<Option<Atlas>, BakeError> {
        match (self.model.atlas(), self.settings.layout) {
            (Ok(atlas), _) => Ok(Some(atlas)),
            (Err(AtlasError::NoUvs), _) if self.settings.map == MapKind::VectorTangent => Err(BakeError::NoTangents),
            (Err(AtlasError::NoUvs), LayoutChoice::Auto | LayoutChoice::Vertex) => Ok(None),
            (Err(e), _) => Err(e.into()),
        }
    }
}

/// Denoises, bakes, writes to memory, reads back and measures.
///
/// `beside` is what the source's materials need.
pub fn bake(
    model: &Model,
    names: &BundleNames,
    side_files: SideFiles,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    let request = Request { model, names, side_files, settings, progress };
    let unwraps = settings.layout == LayoutChoice::Unwrap;
    if unwraps && !CAN_UNWRAP {
        return Err(BakeError::CannotUnwrap);
    }
    if !unwraps {
        // What cannot be baked shall not have to be denoised first.
        request.atlas()?;
    }
    let displacements = settings.target.displacements(model, settings.map, settings.normals, progress)?;
    if displacements.deltas.iter().any(|delta| !delta.as_vec3().is_finite()) {
        return Err(BakeError::NotFinite);
    }
    #[cfg(feature = "unwrap")]
    if unwraps {
        return unwrapped::bake(&request, &displacements);
    }
    bake_layout(&request, &displacements, None)
}

/// Bakes into the layout that the model has. `original` is the model before it was unwrapped, if it was.
fn bake_layout(
    request: &Request,
    displacements: &VertexDisplacements,
    original: Option<&Model>,
) -> Result<Bundle, BakeError> {
    let mut draft = Draft::new(request, displacements, original)?;
    draft.measure(request, displacements)?;
    if let Some(fallback) = draft.fallback(request) {
        let settings = BakeSettings { layout: LayoutChoice::Vertex, ..request.settings.clone() };
        let bundle = bake_layout(&Request { settings: &settings, ..*request }, displacements, None)?;
        return Ok(Bundle { fallback: Some(fallback), ..bundle });
    }
    request.progress.check()?;
    draft.into_bundle(request, displacements)
}

#[cfg(test)]
mod tests;
