//! The manifest: a JSON file that describes a displacement map and how to use it.
//!
//! File names are relative to the folder of the manifest. Lengths are in model units. Unknown fields are ignored when a
//! manifest is read, so that later versions may add some.

use crate::denoise::limits::Outcome;
use crate::denoise::{Denoiser, Denoising, HeightResidual, NormalField, auto};
use crate::map::displacement::{Encoding, MapKind, TexelFormat};
use crate::map::layout_issues::LayoutIssues;
use crate::map::normal_map::Convention;
use crate::map::{Interpolation, Size, Texels};
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
use crate::named;
#[cfg(doc)]
use crate::source::Source;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;

mod clients;
mod pages;
mod shading;

pub use clients::{Blender, BlenderDirection, CentreMagnitude, Clients, MinMax, Mtl, ThreeJs};
pub use pages::{PageEntry, PagesEntry};
pub use shading::{CurvatureEntry, OcclusionEntry, ShadingMapEntry};

/// Latest version of the format that this crate reads. It also reads the earlier ones, and writes the earliest one that has every
/// field that a reader has to know: 1 without private texels, 2 with them, 3 with pages.
pub const VERSION: u64 = 3;

/// Largest side of a map, texels.
pub const LARGEST_SIDE: u32 = 16384;

/// Largest absolute strength. A value near it is a mistake, and far beyond it single precision would overflow.
const LARGEST_LAMBDA: f64 = 1e6;

/// Description of a baked map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format: 1, or 2 if there are private texels, or 3 if there are pages.
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

/// Method by which a mesh was denoised; in JSON an object with the field `name`. The settings of a method that this version
/// knows must exist and be in their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Map<String, serde_json::Value>")]
pub enum Method {
    /// The mesh was denoised by this method with these settings.
    Denoiser(Denoising),
    /// The mesh was denoised by other means; the result is in this file.
    Target(Target),
    /// The mesh was denoised by a method that this version does not know; its map can be used all the same.
    Other(serde_json::Map<String, serde_json::Value>),
}

impl Method {
    /// Name of the method, or `target`.
    pub fn name(&self) -> &str {
        match self {
            Self::Denoiser(Denoising { denoiser, .. }) => denoiser.name(),
            Self::Target(_) => TARGET,
            Self::Other(method) => method.get("name").and_then(serde_json::Value::as_str).unwrap_or_default(),
        }
    }
}

impl TryFrom<serde_json::Map<String, serde_json::Value>> for Method {
    type Error = serde_json::Error;

    fn try_from(method: serde_json::Map<String, serde_json::Value>) -> Result<Self, Self::Error> {
        let name = method.get("name").and_then(serde_json::Value::as_str).unwrap_or_default();
        if Denoiser::named(name).is_ok() {
            serde_json::from_value(method.into()).map(Self::Denoiser)
        } else if name == TARGET {
            serde_json::from_value(method.into()).map(Self::Target)
        } else {
            Ok(Self::Other(method))
        }
    }
}

/// Name that stands for the name of a method if the mesh was denoised by other means.
const TARGET: &str = "target";

/// A mesh that was denoised by other means.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Target {
    name: TargetName,
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the bytes of the file, hexadecimal.
    pub sha256: String,
}

/// Field that distinguishes a target from a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TargetName {
    Target,
}

impl Target {
    /// Describes a mesh by its file name and the SHA-256 of its bytes.
    pub fn new(file: String, sha256: String) -> Self {
        Self { name: TargetName::Target, file, sha256 }
    }
}

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

fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl UvSource {
    fn is_mesh(&self) -> bool {
        *self == Self::Mesh
    }
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
    fn pairs(&self) -> Vec<[Index; 2]> {
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

/// Accuracy of the written files, which are decoded and applied at λ = 1 in single precision, and compared with p − h·n (or p
/// − δ for vectors) in double precision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
    /// 99th percentile of these distances, model units.
    pub p99_error: f64,
    /// Mean of these distances, model units.
    pub mean_error: f64,
    /// Bound of the distances whatever the rounding of the program that checks them, model units: `max_error` and one unit in
    /// the last place of the largest coordinate.
    pub error_bound: f64,
    /// Step between two heights (quantum), model units.
    pub quantum: f64,
    /// `max_error` in quanta; `None` for a flat map.
    pub max_error_quanta: Option<f64>,
    /// `p99_error` in quanta; `None` for a flat map.
    pub p99_error_quanta: Option<f64>,
    /// `mean_error` in quanta; `None` for a flat map.
    pub mean_error_quanta: Option<f64>,
    /// `max_error` as a fraction of the range of the map, which is its scale; `None` for a flat map.
    pub max_error_range: Option<f64>,
    /// `p99_error` as a fraction of the range; `None` for a flat map.
    pub p99_error_range: Option<f64>,
    /// `mean_error` as a fraction of the range; `None` for a flat map.
    pub mean_error_range: Option<f64>,
    /// Largest distance between two wedges of one vertex after displacement, model units; 0 without cracks.
    pub seam_gap: f64,
    /// Errors of the map alone, without the rounding of positions to single precision.
    pub map_errors: MapErrors,
    /// Largest error of the map at a vertex that counts as resolved, quanta.
    pub tolerance_quanta: f64,
    /// Number of vertices with a larger error of the map, because the layout gives them no texels of their own.
    pub unresolved_vertices: usize,
    /// Errors with weights of 8 bits, as in the samplers of many GPUs.
    pub eight_bit_weights: Filtered,
    /// Errors that 8, 16 and 32 bits would give.
    pub by_bits: Vec<BitsError>,
    /// Number of vertices with private texels, welded ones counted once.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub private_vertices: usize,
    /// Result of clients that sample each wedge at its own texture coordinate; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_uvs: Option<OwnUvs>,
    /// Issues of the UV layout; only with [`Layout::Uv`].
    #[serde(flatten)]
    pub layout: LayoutIssues,
    /// Root mean square over the vertices of |δ − h·n|, the part of the displacement that heights leave out, model units; zero
    /// for vectors.
    pub left_out_rms: f64,
    /// Loss of heights in the angles of the faces; only with [`MapKind::Scalar`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<HeightsLoss>,
    /// Effect of the limits of the method; `None` without limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Outcome>,
    /// Number of vertices without a normal, because those of their faces cancel. A height map does not displace them.
    pub vertices_without_normal: usize,
    /// Advice on how to get a better map; `None` if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suggestion: Option<String>,
}

/// Loss of a height map: the part of the denoised surface that heights along the normals cannot express.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeightsLoss {
    /// Mean angle between the faces of the input and of the denoised surface, degrees.
    #[serde(rename = "turned_deg")]
    pub rotation_deg: f64,
    /// Mean angle between the faces of the denoised surface and of the one that the heights give, degrees.
    pub lost_deg: f64,
    /// Fraction of the vertices whose normal is tilted towards their displacement, so that their faces come out right.
    #[serde(default, rename = "leaning")]
    pub tilted: f64,
}

impl HeightsLoss {
    /// Returns true if a vector map is worth its three channels. Either more than half a degree is lost, which shading shows,
    /// and more than a tenth of the rotation, so that visible noise is left; or so many normals are tilted that they do not
    /// look like normals of the surface any more.
    pub fn is_much(&self) -> bool {
        (self.lost_deg > 0.5 && self.lost_deg > 0.1 * self.rotation_deg) || self.tilted > 0.2
    }
}

impl From<HeightResidual> for HeightsLoss {
    fn from(residual: HeightResidual) -> Self {
        Self { rotation_deg: residual.rotation, lost_deg: residual.angle, tilted: residual.tilted }
    }
}

impl fmt::Display for HeightsLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rotation_deg, lost_deg, tilted } = self;
        write!(f, "heights lose {lost_deg:.2}° of the {rotation_deg:.2}° by which denoising rotates the faces")?;
        if *tilted > 0.0 {
            write!(f, ", with {:.1} % of the normals tilted", 100.0 * tilted)?;
        }
        if self.is_much() {
            write!(f, ": a vector map loses nothing")?;
        }
        Ok(())
    }
}

/// Differences between the height that a vertex samples and its exact one; for a vector, the largest of its components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapErrors {
    /// Largest difference, model units.
    pub max: f64,
    /// 99th percentile of the differences, model units.
    pub p99: f64,
    /// Largest difference, quanta; `None` for a flat map.
    pub max_quanta: Option<f64>,
    /// 99th percentile of the differences, quanta; `None` for a flat map.
    pub p99_quanta: Option<f64>,
}

/// Errors of displaced vertices with weights of another accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
    /// 99th percentile of these distances, model units.
    pub p99_error: f64,
    /// Largest distance between two wedges of one vertex after displacement, model units.
    pub seam_gap: f64,
}

/// Error of a map with a certain number of bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BitsError {
    /// Number of bits of a texel: 8 or 16 (integers), or 32 (floating point).
    pub bits: u32,
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
}

/// Displacement by clients that sample each wedge at its own texture coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnUvs {
    /// Number of vertices with several wedges.
    pub seam_vertices: usize,
    /// Number of vertices with several wedges that are all displaced to the same position, bit for bit.
    pub bit_equal_seam_vertices: usize,
    /// Largest distance between two wedges of one vertex after displacement, model units.
    pub seam_gap: f64,
    /// Errors of the wedges; only with private texels, of which these clients know nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<OwnUvErrors>,
}

/// Distances of wedges, displaced at their own texture coordinates, from the exact positions of their vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnUvErrors {
    /// Largest distance, model units.
    pub max: f64,
    /// Mean of the distances, model units.
    pub mean: f64,
    /// Number of vertices with a wedge that is farther off than the tolerance.
    pub vertices: usize,
}

/// Reasons why bytes are not a manifest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ManifestError {
    /// The bytes are no JSON, or fields are missing or have the wrong type; the text names line and column.
    #[error("not a planish manifest: {0}")]
    Json(String),
    /// The manifest has another version of the format.
    #[error("the manifest has version {0}, but this planish reads versions 1 to {VERSION}")]
    Version(String),
    /// A field has a value that is not allowed.
    #[error("field `{field}`: {problem}")]
    Value {
        /// Path of the field.
        field: &'static str,
        /// Text on what is wrong with the value.
        problem: String,
    },
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

    /// Reads and checks a manifest.
    pub fn from_json(bytes: &[u8]) -> Result<Self, ManifestError> {
        let json = |e: serde_json::Error| ManifestError::Json(e.to_string());
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(json)?;
        match value.get("planish") {
            None => return Err(ManifestError::Json("there is no field `planish` with the version".to_owned())),
            Some(version) if !version.as_u64().is_some_and(|version| (1..=VERSION).contains(&version)) => {
                return Err(ManifestError::Version(version.to_string()));
            }
            Some(_) => {}
        }
        if let Some(method) = value.get("method") {
            let fault = |e: serde_json::Error| ManifestError::Value { field: "method", problem: e.to_string() };
            Method::deserialize(method).map_err(fault)?;
        }
        let manifest: Self = serde_json::from_slice(bytes).map_err(json)?;
        manifest.check()?;
        Ok(manifest)
    }

    fn check(&self) -> Result<(), ManifestError> {
        let ensure = |is_valid: bool, field, problem: String| {
            if is_valid { Ok(()) } else { Err(ManifestError::Value { field, problem }) }
        };
        let map = &self.displacement;
        for (side, field) in [(map.width, "displacement.width"), (map.height, "displacement.height")] {
            ensure((1..=LARGEST_SIDE).contains(&side), field, format!("{side} is not in 1..={LARGEST_SIDE}"))?;
        }
        let is_single = |x: f64| x.is_finite() && (x as f32).is_finite();
        ensure(is_single(map.bias), "displacement.bias", format!("{} is too large", map.bias))?;
        ensure(
            is_single(map.scale) && map.scale >= 0.0,
            "displacement.scale",
            format!("{} is not a scale", map.scale),
        )?;
        let is_strength = map.lambda.abs() <= LARGEST_LAMBDA;
        ensure(is_strength, "displacement.lambda", format!("{} is not a strength", map.lambda))?;
        let is_near = map.origin.to_array().into_iter().all(is_single);
        ensure(is_near, "displacement.origin", format!("{} is too large", map.origin))?;
        if let Some(pages) = &self.pages {
            pages.check(self).map_err(|problem| ManifestError::Value { field: "pages", problem })?;
        }
        let has_sample_positions = map.layout == Layout::Vertex || self.dominant_uv.is_some() || self.pages.is_some();
        ensure(has_sample_positions, "dominant_uv", "is missing, and the layout `uv` needs it".to_owned())?;
        let has_texels = map.layout == Layout::Uv || map.size().texels() >= self.source.vertices;
        let texels = map.size().texels();
        let problem = format!("{texels} texels are too few for {} vertices", self.source.vertices);
        ensure(has_texels, "displacement.width", problem)?;
        for (field, map) in self.shading_maps() {
            let problem = format!("{} × {} is no size for {} vertices", map.width, map.height, self.source.vertices);
            let sides = [map.width, map.height].iter().all(|side| (1..=LARGEST_SIDE).contains(side));
            let has_texels = map.layout == Layout::Uv || map.size().texels() >= self.source.vertices;
            ensure(sides && has_texels, field, problem)?;
        }
        let range = self.curvature.as_ref().map_or(0.0, |entry| entry.range);
        ensure(range.is_finite() && range >= 0.0, "curvature.range", format!("{range} is not a range"))?;
        let distance = self.occlusion.as_ref().and_then(|entry| entry.distance).unwrap_or(1.0);
        ensure(distance.is_finite() && distance > 0.0, "occlusion.distance", format!("{distance} is not above 0"))?;
        if !self.files.is_empty() {
            let listed = |name: &&str| self.files.iter().any(|entry| entry.file == **name);
            let absent = self.described().into_iter().find(|name| !listed(name));
            ensure(absent.is_none(), "files", format!("lacks {:?}", absent.unwrap_or_default()))?;
        }
        let pairs = self.dominant_uv.as_ref().map_or(&[][..], |uv| &uv.seam_vertices);
        let counted_from_one = pairs.iter().flatten().all(|&i| i > 0);
        ensure(counted_from_one, "dominant_uv.seam_vertices", "index 0: indices count from 1".to_owned())?;
        let in_mesh = |pair: &[Index; 2]| pair[0] as usize <= self.source.vertices;
        let stray = pairs.iter().find(|pair| !in_mesh(pair));
        ensure(stray.is_none(), "dominant_uv.seam_vertices", format!("{stray:?} names no vertex"))?;
        let has_uvs = map.layout == Layout::Uv || self.private_texels.is_empty();
        ensure(has_uvs, "private_texels", "does not go with the layout `vertex`".to_owned())?;
        let exists = |texel: &&PrivateTexel| {
            (1..=self.source.vertices).contains(&(texel.vertex as usize))
                && texel.column < map.width
                && texel.row < map.height
        };
        let stray = self.private_texels.iter().find(|texel| !exists(texel)).map(|texel| <[Index; 3]>::from(*texel));
        ensure(
            stray.is_none(),
            "private_texels",
            format!("{:?} names no vertex or no texel", stray.unwrap_or_default()),
        )
    }

    /// Writes the JSON text: indented, but with each list of indices in one line.
    pub fn to_json(&self) -> String {
        // Strings, numbers and lists cannot fail to become JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        let lists = [("/dominant_uv/seam_vertices", "seam_vertices"), ("/private_texels", "private_texels")];
        let mut lists = lists.map(|(pointer, name)| (pointer.to_owned(), name)).to_vec();
        for page in 0..self.page_entries().len() {
            lists.extend(["seam_vertices", "private_texels"].map(|name| (format!("/pages/maps/{page}/{name}"), name)));
        }
        // In the order in which they stand in the text.
        let take = |(pointer, name): (String, _)| (name, value.pointer_mut(&pointer).map(std::mem::take));
        let lists: Vec<(&str, Option<serde_json::Value>)> = lists.into_iter().map(take).collect();
        let mut text = serde_json::to_string_pretty(&value).unwrap_or_default();
        for (name, list) in lists {
            if let Some(list) = list {
                text = text.replacen(&format!("\"{name}\": null"), &format!("\"{name}\": {list}"), 1);
            }
        }
        text + "\n"
    }
}

/// Finds the files that a manifest names, even one that this version cannot use: an old one, a newer one, or one that was edited. A
/// file without a known SHA-256 has an empty one. `None` if the bytes are no manifest at all.
pub fn named_files(bytes: &[u8]) -> Option<Vec<FileEntry>> {
    let value: serde_json::Value = serde_json::from_slice(bytes).ok()?;
    value.get("planish")?;
    let text = |pointer: &str| value.pointer(pointer).and_then(serde_json::Value::as_str).map(str::to_owned);
    let mut files: Vec<FileEntry> =
        value.get("files").and_then(|files| Vec::deserialize(files).ok()).unwrap_or_default();
    let pointers = [
        "/displacement/file",
        "/normal_map/file",
        "/occlusion/file",
        "/curvature/file",
        "/carrier/obj",
        "/carrier/mtl",
        "/carrier/glb",
    ];
    let pages = value.pointer("/pages/maps").and_then(serde_json::Value::as_array).map_or(0, Vec::len);
    let of_pages = (0..pages).flat_map(|page| ["file", "normal_map/file"].map(|of| format!("/pages/maps/{page}/{of}")));
    let pointers = pointers.into_iter().map(str::to_owned).chain(of_pages);
    for file in pointers.filter_map(|pointer| text(&pointer)) {
        if files.iter().all(|known| known.file != file) {
            files.push(FileEntry { file, sha256: String::new() });
        }
    }
    Some(files)
}

/// SHA-256 of bytes, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest as _;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
