//! The whole bake: a model becomes the files of a displacement map, each as bytes.
//!
//! [`bake`] denoises, makes the maps and the carrier, reads the bytes back and measures them. Command line and window
//! write these bytes and nothing else.
//!
//! ```
//! use planish_geometry::bake::{self, BakeSettings, BundleNames, SideFiles};
//! use planish_geometry::denoise::{Denoiser, Laplacian};
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::model::Model;
//! use planish_geometry::source::obj::Obj;
//!
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let names = BundleNames { source: "tent.obj".into(), stem: "tent".into(), carrier: "tent".into() };
//! let settings = BakeSettings { target: Denoiser::Laplacian(Laplacian::default()).into(), ..BakeSettings::default() };
//! let bundle = bake::bake(&model, &names, SideFiles::NONE, &settings, &Silent)?;
//! let files: Vec<&str> = bundle.files.iter().map(|file| file.name.as_str()).collect();
//! assert_eq!(files, ["tent.displacement.png", "tent.obj", "tent.mtl", "tent.glb", "tent.planish.json"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod carrier;
mod check;
mod describe;
mod draft;
mod error;
mod fill;
mod glb;
pub mod gltf;
mod layout;
mod layout_choice;
mod maps;
mod normal_maps;
mod offsets;
mod pages;
mod report;
mod settings;
mod shading_maps;
mod sides;
mod target;
#[cfg(feature = "unwrap")]
pub mod unwrap;
#[cfg(feature = "unwrap")]
mod unwrapped;

pub use check::{WrittenFiles, check};
pub use error::BakeError;
pub use layout::Fallback;
pub use layout_choice::LayoutChoice;
pub use settings::{BakeSettings, Carriers, CurvatureMap, Lambda, LargestSide, Quanta};
pub use target::{BakeTarget, VertexDisplacements};

use crate::map::displace::{self, DisplacementDirections};
use crate::map::displacement::{EncodeError, MapKind};
use crate::map::manifest::Manifest;
use crate::map::map_size::MapSizeChoice;
use crate::map::pages::{PageRule, Pages};
use crate::mesh::atlas::{Atlas, AtlasError};
use crate::mesh::jagged::Index;
use crate::progress::Progress;
use crate::source::backs::Backs;
use crate::source::model::Model;
use draft::Draft;
use glam::{DVec3, IVec2};
use gltf::Picture;

/// Files beside a mesh that its materials need.
#[derive(Clone, Copy)]
pub struct SideFiles<'a> {
    /// Contents of the material libraries, in the order in which the mesh names them.
    pub libraries: &'a [Vec<u8>],
    /// Function that turns the path of a texture, as a library writes it, into a path from the folder of the carrier.
    pub relocate: &'a (dyn Fn(&str) -> String + Sync),
    /// Function that gives the bytes of a picture of a material, as glTF takes it, by the paths of its files in the libraries; `None` if
    /// there is none.
    pub texture: &'a (dyn Fn(Picture) -> Option<Vec<u8>> + Sync),
    /// Textures from within the mesh file, which become files beside the carrier, each with another name.
    pub within: &'a [BundleFile],
}

impl SideFiles<'_> {
    /// Side files of a mesh without materials.
    pub const NONE: SideFiles<'static> =
        SideFiles { libraries: &[], relocate: &str::to_owned, texture: &|_| None, within: &[] };
}

/// Names of the files of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleNames {
    /// Path of the mesh as the manifest names it.
    pub source: String,
    /// File name of the maps and the manifest up to their extensions.
    pub stem: String,
    /// File name of the carrier and its materials up to their extensions.
    pub carrier: String,
}

/// A file of a bundle, to be written by the caller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Name without a folder.
    pub name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// The result of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Maps, carrier and materials, and at the end the manifest.
    pub files: Vec<BundleFile>,
    /// Manifest, as in the last file.
    pub manifest: Manifest,
    /// Reason for the size of the maps; `None` if the size was given or follows from the number of vertices.
    pub choice: Option<MapSizeChoice>,
    /// Reason why the texture coordinates of the mesh were not used; `None` if they were used or not asked for.
    pub fallback: Option<Fallback>,
    /// Directions that the map displaces along, for [`model_vertices`](crate::map::displace::model_vertices).
    pub along: DisplacementDirections,
    /// Standard deviation of the noise that the method assumed at each vertex, model units; empty if it measured none. #V
    pub deviations: Vec<f64>,
    /// Number of faces that are the back of another one and share its source vertices or its texels, so that they are displaced along
    /// the normals of the front.
    pub shared_backs: usize,
}

/// True if the feature `unwrap` is on, so that [`LayoutChoice::Unwrap`] can be used.
pub const CAN_UNWRAP: bool = cfg!(feature = "unwrap");

/// Arguments of [`bake`].
#[derive(Clone, Copy)]
struct Request<'a> {
    model: &'a Model,
    names: &'a BundleNames,
    side_files: SideFiles<'a>,
    settings: &'a BakeSettings,
    progress: &'a dyn Progress,
    /// Backs of the mesh; the surface of the model has those with a side of their own.
    backs: &'a Backs,
}

impl Request<'_> {
    /// Tile of the texture coordinates for a map with one image, by its lower left corner.
    fn tile(&self) -> Result<IVec2, BakeError> {
        let pages = Pages::of(self.model.data(), self.settings.pages)?;
        Ok(if pages.is_none() { self.model.tile() } else { IVec2::ZERO })
    }
    /// Layout of the model's texture coordinates; `None` if the model has none and the bake needs none.
    fn atlas(&self) -> Result<Option<Atlas>, BakeError> {
        match (self.model.atlas_in(self.tile()?), self.settings.layout) {
            (Ok(atlas), _) => Ok(Some(atlas)),
            (Err(AtlasError::NoUvs), _) if self.settings.map == MapKind::VectorTangent => Err(BakeError::NoTangents),
            (Err(AtlasError::NoUvs), LayoutChoice::Auto | LayoutChoice::Vertex) => Ok(None),
            (Err(e), _) => Err(e.into()),
        }
    }
}

/// Denoises a model, bakes its displacement map and carrier into memory, reads them back and measures their errors.
///
/// # Errors
/// If the layout that was chosen is impossible for this mesh, if heights or positions do not fit into single precision,
/// or if the caller cancels; see [`BakeError`].
pub fn bake(
    model: &Model,
    names: &BundleNames,
    side_files: SideFiles,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    let none = Backs::default();
    let request = Request { model, names, side_files, settings, progress, backs: &none };
    let unwraps = settings.layout == LayoutChoice::Unwrap;
    if unwraps && !CAN_UNWRAP {
        return Err(BakeError::CannotUnwrap);
    }
    EncodeError::unless_built(settings.texel.file())?;
    if settings.pages != PageRule::None && matches!(settings.layout, LayoutChoice::Vertex | LayoutChoice::Unwrap) {
        return Err(BakeError::PagesWithLayout(settings.layout));
    }
    if !unwraps {
        // A missing layout is reported before the time for denoising is spent.
        request.atlas()?;
    }
    let origin = displace::origin(model.surface().bounds());
    let topology = model.surface().topology();
    let too_far = |(v, p): &(Index, &DVec3)| !topology.is_isolated(*v) && !(**p - origin).as_vec3().is_finite();
    if let Some((v, _)) = (0..).zip(model.surface().positions()).find(too_far) {
        return Err(BakeError::TooFar { source_vertex: model.weld().first()[v as usize] });
    }
    let displacements =
        settings.target.displacements_with(&settings.last_result, model, settings.map, settings.normals, progress)?;
    if displacements.deltas.iter().any(|delta| !delta.as_vec3().is_finite()) {
        return Err(BakeError::NotFinite);
    }
    let (backs, both) = sides::of_request(&request)?;
    let (model, displacements) = match &both {
        Some(both) => (&both.model, displacements.on_both(both)),
        None => (model, displacements),
    };
    let request = Request { model, backs: &backs, ..request };
    #[cfg(feature = "unwrap")]
    if unwraps {
        return unwrapped::bake(&request, &displacements);
    }
    bake_layout(&request, &displacements, None)
}

/// Bakes into the model's existing layout. `original` is the model before unwrapping, if it was unwrapped.
fn bake_layout(
    request: &Request,
    displacements: &VertexDisplacements,
    original: Option<&Model>,
) -> Result<Bundle, BakeError> {
    let mut draft = Draft::new(request, displacements, original)?;
    draft.measure(request, displacements)?;
    if let Some(fallback) = draft.fallback(request) {
        let settings = BakeSettings { layout: LayoutChoice::Vertex, pages: PageRule::None, ..request.settings.clone() };
        let bundle = bake_layout(&Request { settings: &settings, ..*request }, displacements, None)?;
        return Ok(Bundle { fallback: Some(fallback), ..bundle });
    }
    request.progress.check()?;
    draft.into_bundle(request, displacements, original)
}

#[cfg(test)]
mod tests;
