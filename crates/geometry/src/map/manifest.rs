//! The manifest: a JSON file that describes a displacement map and how to use it.
//!
//! File names are relative to the folder of the manifest. Lengths are in model units. Unknown fields are ignored when a
//! manifest is read, so that later versions may add some.
//!
//! ```
//! use planish_geometry::bake::{self, BakeSettings, BundleNames, SideFiles};
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::map::manifest::Manifest;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let names = BundleNames { source: "tent.obj".into(), stem: "tent".into(), carrier: "tent".into() };
//! let settings = BakeSettings { target: Denoiser::named("laplacian").unwrap().into(), ..BakeSettings::default() };
//! let manifest = bake::bake(&model, &names, SideFiles::NONE, &settings, &Silent)?.manifest;
//!
//! let json = manifest.to_json();
//! assert_eq!(Manifest::from_json(json.as_bytes())?, manifest);
//! // A file that names something impossible is refused, with the field.
//! let far = json.replace("\"lambda\": 1.0", "\"lambda\": 1e9");
//! let error = Manifest::from_json(far.as_bytes()).unwrap_err();
//! assert!(error.to_string().starts_with("field `displacement.lambda`: "), "{error}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::denoise::limits::Mask;
use crate::denoise::{NormalField, auto};
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
#[cfg(doc)]
use crate::source::Source;
use serde::{Deserialize, Serialize};

mod clients;
mod json;
mod map_entry;
mod method;
mod pages;
mod report;
mod shading;

pub use clients::{Blender, BlenderDirection, CentreMagnitude, Clients, MinMax, Mtl, ThreeJs};
pub use json::{ManifestError, named_files};
pub use map_entry::{DominantUv, Layout, MapEntry, NormalMapEntry, PrivateTexel, UvSource};
pub use method::{Method, Target};
pub use pages::{PageEntry, PagesEntry};
pub use report::{BitsError, Filtered, HeightsLoss, MapErrors, OwnUvErrors, OwnUvs, Report};
pub use shading::{CurvatureEntry, OcclusionEntry, ShadingMapEntry};

/// Latest version of the format that this crate reads. It also reads the earlier ones, and writes the earliest one that has every
/// field that a reader has to know: 1 without private texels, 2 with them, 3 with pages, 4 with texture coordinates in another tile than
/// [0, 1]², 5 with backs, 6 with pages of a mesh that was cut.
pub const VERSION: u64 = 6;

/// Largest side of a map, texels.
pub const LARGEST_SIDE: u32 = 16384;

/// Description of a baked map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format: 1, or 2 if there are private texels, or 3 if there are pages, or 4 if the map has a tile, or 5 if there are
    /// backs, or 6 if the mesh was cut into parts.
    pub planish: u64,
    /// Name and size of the mesh that was baked.
    pub source: SourceEntry,
    /// Method by which the mesh was denoised.
    pub method: Method,
    /// Measurements and choice of the method `auto`; `None` with other methods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<auto::DenoiseChoice>,
    /// Rule by which source vertices became one vertex.
    pub welding: Welding,
    /// Source of the normals along which the map displaces.
    pub normals: NormalField,
    /// Displacement map.
    pub displacement: MapEntry,
    /// Texture coordinates at which vertices on seams sample; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dominant_uv: Option<DominantUv>,
    /// Vertices that read texels of their own instead of sampling at texture coordinates, and those texels; only with
    /// [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub private_texels: Vec<PrivateTexel>,
    /// Source vertices of the backs of other faces: the map displaces them along the opposite of the normal that their vertex has in
    /// front, by heights with the opposite sign.
    #[serde(default, skip_serializing_if = "Mask::is_empty")]
    pub backs: Mask,
    /// Images of the parts of the mesh; `None` if there is one image. With pages, the places of seam vertices, the private texels
    /// and the normal maps are those of each page.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pages: Option<PagesEntry>,
    /// Normal map of the denoised surface; `None` if the texture coordinates do not allow one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMapEntry>,
    /// Ambient occlusion map of the denoised surface; `None` if none was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occlusion: Option<OcclusionEntry>,
    /// Curvature map of the denoised surface; `None` if none was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curvature: Option<CurvatureEntry>,
    /// Mesh that carries the map.
    pub carrier: Carrier,
    /// Files of the bundle besides the manifest, so that a file of another bake is noticed; empty in manifests of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileEntry>,
    /// Measured accuracy of the map.
    pub report: Report,
    /// Settings for programs that add displacements, with the signs that they need.
    pub clients: Clients,
}

/// Name and size of the mesh that was baked.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceEntry {
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the bytes of the mesh ([`Source::bytes`]), hexadecimal.
    pub sha256: String,
    /// Number of source vertices, which are the `v` lines of an OBJ.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
}

/// Files of the carrier, which is the source with one normal for each vertex, along which the map displaces.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Carrier {
    /// Name of the OBJ file.
    pub obj: String,
    /// Name of its material library, which has a `disp` statement if the map uses the texture coordinates of the carrier, and
    /// a `norm` statement if there is a normal map.
    pub mtl: String,
    /// Name of the binary glTF file, which has the carrier, its sample positions as a second set of texture coordinates, the
    /// map, and the denoised surface as a morph target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub glb: Option<String>,
    /// SHA-256 of the bytes of the OBJ file, hexadecimal.
    pub sha256: String,
}

/// A file of the bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the bytes of the file, hexadecimal.
    pub sha256: String,
}

impl Manifest {
    /// Ascending pairs of the indices of a source vertex and of the texture coordinate at which it samples, counted from 0,
    /// for the vertices that [`DominantUv`] lists.
    pub fn dominant_pairs(&self) -> Vec<[Index; 2]> {
        self.dominant_uv.as_ref().map(DominantUv::pairs).unwrap_or_default()
    }

    /// Ascending pairs of the indices of a source vertex and of its private texel, counted from 0, texels row by row from the top.
    pub fn private_pairs(&self) -> Vec<[Index; 2]> {
        let index = |texel: &PrivateTexel| texel.row * self.displacement.width + texel.column;
        self.private_texels.iter().map(|texel| [texel.vertex - 1, index(texel)]).collect()
    }

    /// Pages of the map; empty if there is one image.
    pub fn page_entries(&self) -> &[PageEntry] {
        self.pages.as_ref().map_or(&[], |pages| &pages.maps)
    }

    /// Names of the files of the bundle besides the manifest: maps, carrier and whatever else is listed, without the mesh that was
    /// baked.
    pub fn file_names(&self) -> Vec<&str> {
        let mut names = self.described();
        let others = self.files.iter().map(|entry| entry.file.as_str()).filter(|name| !names.contains(name));
        let others: Vec<&str> = others.collect();
        names.extend(others);
        names
    }

    /// Names of the files that the manifest describes: maps and carrier.
    fn described(&self) -> Vec<&str> {
        let normal_map = self.normal_map.as_ref().map(|map| map.file.as_str());
        let shading = self.shading_maps().map(|(_, map)| map.file.as_str());
        let carrier = [Some(self.carrier.obj.as_str()), Some(self.carrier.mtl.as_str()), self.carrier.glb.as_deref()];
        let pages = self.page_entries().iter().flat_map(PageEntry::files);
        // The first page is the map of the entry.
        let pages = pages.filter(|file| *file != self.displacement.file);
        [Some(self.displacement.file.as_str()), normal_map]
            .into_iter()
            .flatten()
            .chain(pages)
            .chain(shading)
            .chain(carrier.into_iter().flatten())
            .collect()
    }

    /// Maps of shading, with the names of their fields.
    fn shading_maps(&self) -> impl Iterator<Item = (&'static str, &ShadingMapEntry)> {
        let occlusion = self.occlusion.as_ref().map(|entry| ("occlusion", &entry.map));
        occlusion.into_iter().chain(self.curvature.as_ref().map(|entry| ("curvature", &entry.map)))
    }

    /// SHA-256 of a file of the bundle, hexadecimal; `None` if the manifest does not say, as those of earlier versions.
    pub fn sha256_of(&self, file: &str) -> Option<&str> {
        let listed = self.files.iter().find(|entry| entry.file == file).map(|entry| entry.sha256.as_str());
        listed.or_else(|| (file == self.carrier.obj).then_some(self.carrier.sha256.as_str()))
    }
}

/// SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest as _;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
