//! The JSON that says what a displacement map is and how to use it.
//!
//! Names are relative to the manifest's folder. Lengths are in model units. Every field below is written; unknown
//! fields are passed over when reading, so that later versions may add some.

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

pub use clients::{Blender, BlenderDirection, CentreMagnitude, Clients, MinMax, Mtl, ThreeJs};

/// Version of the format that this crate reads and writes.
pub const VERSION: u64 = 1;

/// Largest side of a map, texels.
pub const LARGEST_SIDE: u32 = 16384;

/// Largest strength either way; anything near it is a mistake, and beyond single precision would overflow.
const LARGEST_LAMBDA: f64 = 1e6;

/// All about a baked map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the format: 1.
    pub planish: u64,
    /// The mesh that was baked.
    pub source: SourceEntry,
    /// How it was denoised.
    pub method: Method,
    /// What the method `auto` measured and chose; none with other methods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<auto::DenoiseChoice>,
    /// Which source vertices count as one vertex.
    pub welding: Welding,
    /// Where the normals that the map displaces along come from.
    pub normals: NormalField,
    /// The map.
    pub displacement: MapEntry,
    /// Where vertices sample that have several texture coordinates; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dominant_uv: Option<DominantUv>,
    /// The normal map of the denoised surface; none where no layout can hold it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMapEntry>,
    /// The mesh that carries the map.
    pub carrier: Carrier,
    /// How exact the map is.
    pub report: Report,
    /// Settings for programs that add displacements, signs folded in.
    pub clients: Clients,
}

/// The mesh that was baked.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceEntry {
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal; see [`Source::bytes`].
    pub sha256: String,
    /// Number of source vertices: `v` lines of an OBJ.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
}

/// How the mesh was denoised; in JSON an object with the field `name`. Settings of a method that this version knows have to
/// be ones that it has, in their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Map<String, serde_json::Value>")]
pub enum Method {
    /// By this, all settings included.
    Denoiser(Denoising),
    /// By somebody else.
    Target(Target),
    /// By something that this version does not know; the map can be used all the same.
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

/// Name of a mesh that was denoised by other means, in the place of the name of a method.
const TARGET: &str = "target";

/// A mesh that was denoised by other means.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Target {
    name: TargetName,
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// Tells a target from a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TargetName {
    Target,
}

impl Target {
    /// A mesh by its name and the SHA-256 of its bytes.
    pub fn new(file: String, sha256: String) -> Self {
        Self { name: TargetName::Target, file, sha256 }
    }
}

named! {
    /// Where a vertex has its texels.
    #[derive(Default)]
    pub enum Layout {
        /// At its texture coordinates.
        #[default]
        Uv = "uv",
        /// The i-th source vertex in texel (i mod width, i div width), row 0 on top.
        Vertex = "vertex",
    }
}

named! {
    /// Whose texture coordinates a map lies in.
    #[derive(Default)]
    pub enum UvSource {
        /// The texture coordinates of the mesh.
        #[default]
        Mesh = "mesh",
        /// New texture coordinates that the bake made; only the carrier has them.
        Unwrapped = "unwrapped",
    }
}

impl UvSource {
    fn is_mesh(&self) -> bool {
        *self == Self::Mesh
    }
}

/// The displacement map: p' = p − λ · (bias + scale · texel) · n.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapEntry {
    /// The image.
    pub file: String,
    /// Heights or vectors.
    pub map: MapKind,
    /// Where the texels of a vertex are.
    pub layout: Layout,
    /// How texels between vertices were filled; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// What was done to the texels that vertices sample; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texels: Option<Texels>,
    /// Whose texture coordinates these are.
    #[serde(default, skip_serializing_if = "UvSource::is_mesh")]
    pub uvs: UvSource,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Kind of file and bits of a texel.
    #[serde(flatten)]
    pub texel: TexelFormat,
    /// Height at texel 0; exact in single precision.
    pub bias: f64,
    /// Height at texel 1 minus bias; exact in single precision.
    pub scale: f64,
    /// λ that was asked for; 1 is denoised, 0 is the source.
    pub lambda: f64,
    /// Subtract this from positions before going to single precision; zero for meshes near the origin.
    pub origin: DVec3,
}

impl MapEntry {
    /// Of the image.
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height }
    }
    /// Format, bias and scale.
    pub fn encoding(&self) -> Encoding {
        Encoding { texel: self.texel, bias: self.bias as f32, scale: self.scale as f32 }
    }
}

/// All wedges of a vertex sample at one of its texture coordinates, so that they all land on the same place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DominantUv {
    /// How it was chosen: criteria in falling order of rank.
    pub rule: String,
    /// `[v, vt]`, both counted from 1 as OBJ does: `v` samples at `vt`. Ascending; vertices that are not listed have
    /// one texture coordinate only.
    pub seam_vertices: Vec<[Index; 2]>,
}

impl DominantUv {
    /// The same pairs counted from 0.
    fn pairs(&self) -> Vec<[Index; 2]> {
        self.seam_vertices.iter().map(|pair| pair.map(|i| i - 1)).collect()
    }
}

/// The normal map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NormalMapEntry {
    /// The image, 8-bit RGB, in the texture coordinates of the mesh.
    pub file: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Which way green points.
    pub convention: Convention,
}

/// The mesh that carries the map: the source with one normal for each vertex, along which the map displaces.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Carrier {
    /// The mesh.
    pub obj: String,
    /// Its materials, with `disp` where its texture coordinates are those of the map, and `norm`.
    pub mtl: String,
    /// The same mesh in binary glTF, with the places of the map as a second set of texture coordinates, the map, and
    /// the denoised surface as a morph target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub glb: Option<String>,
    /// SHA-256 of the mesh's bytes, hexadecimal.
    pub sha256: String,
}

/// What the written files do, decoded again and applied at λ = 1 in single precision, against p − h·n (or p − δ) in
/// double.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Largest distance of a vertex from where it should be.
    pub max_error: f64,
    /// 99th percentile.
    pub p99_error: f64,
    /// Mean.
    pub mean_error: f64,
    /// No vertex is farther off, whatever the rounding of who checks: `max_error` and one unit in the last place of
    /// the largest coordinate.
    pub error_bound: f64,
    /// Step between two heights.
    pub quantum: f64,
    /// `max_error` in quanta; none for a flat map.
    pub max_error_quanta: Option<f64>,
    /// `p99_error` in quanta.
    pub p99_error_quanta: Option<f64>,
    /// `mean_error` in quanta.
    pub mean_error_quanta: Option<f64>,
    /// `max_error` as a share of the range of the map, scale; none for a flat map.
    pub max_error_range: Option<f64>,
    /// `p99_error` as a share of the range.
    pub p99_error_range: Option<f64>,
    /// `mean_error` as a share of the range.
    pub mean_error_range: Option<f64>,
    /// Largest distance between two wedges of one vertex after displacement.
    pub seam_gap: f64,
    /// What the map alone loses, without the rounding of positions to single precision.
    pub map_errors: MapErrors,
    /// How far off the map may be at a vertex that counts as resolved, quanta.
    pub tolerance_quanta: f64,
    /// Vertices that are off by more than that: the layout gives them no texels of their own.
    pub unresolved_vertices: usize,
    /// The same map with weights of 8 bits, as the samplers of many GPUs have them.
    pub eight_bit_weights: Filtered,
    /// What other numbers of bits would give: 8, 16 and 32.
    pub by_bits: Vec<BitsError>,
    /// What clients do that sample each wedge at its own texture coordinate; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_uvs: Option<OwnUvs>,
    /// What the layout of the texture makes hard; only with [`Layout::Uv`].
    #[serde(flatten)]
    pub layout: LayoutIssues,
    /// Root mean square over the vertices of |δ − h·n|: the part of the way that heights leave out. Zero for vectors.
    pub left_out_rms: f64,
    /// What heights cost in the angles of the faces; only with [`MapKind::Scalar`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<HeightsLoss>,
    /// What limits of the method did; none without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Outcome>,
    /// Vertices of faces whose normals cancel; a map of heights does not displace them.
    pub vertices_without_normal: usize,
    /// What would make the map better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suggestion: Option<String>,
}

/// What a map of heights leaves out of the denoised surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeightsLoss {
    /// Mean angle by which denoising turns the faces, before heights are made of it, degrees.
    pub turned_deg: f64,
    /// Mean angle between the faces of that surface and of the one that the heights give, degrees.
    pub lost_deg: f64,
    /// Share of the vertices whose normal leans to where the vertex goes, because faces would stay turned otherwise.
    #[serde(default)]
    pub leaning: f64,
}

impl HeightsLoss {
    /// Whether a map of vectors is worth three channels: more than half a degree is lost, below which shading shows no
    /// difference, and more than a tenth of the turn, so that a part of the noise is left that can be seen; or so many normals
    /// lean that they are none of the surface any more.
    pub fn is_much(&self) -> bool {
        (self.lost_deg > 0.5 && self.lost_deg > 0.1 * self.turned_deg) || self.leaning > 0.2
    }
}

impl From<HeightResidual> for HeightsLoss {
    fn from(residual: HeightResidual) -> Self {
        Self { turned_deg: residual.rotation, lost_deg: residual.angle, leaning: residual.tilted }
    }
}

impl fmt::Display for HeightsLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { turned_deg, lost_deg, leaning } = self;
        write!(f, "heights lose {lost_deg:.2}° of the {turned_deg:.2}° by which denoising turns the faces")?;
        if *leaning > 0.0 {
            write!(f, ", with {:.1} % of the normals leaning", 100.0 * leaning)?;
        }
        if self.is_much() {
            write!(f, ": a map of vectors loses nothing")?;
        }
        Ok(())
    }
}

/// Differences between the height that a vertex samples and its own; of vectors the largest of the three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapErrors {
    /// Largest, model units.
    pub max: f64,
    /// 99th percentile, model units.
    pub p99: f64,
    /// Largest, quanta; none for a flat map.
    pub max_quanta: Option<f64>,
    /// 99th percentile, quanta.
    pub p99_quanta: Option<f64>,
}

/// Errors with other weights, model units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    /// Largest.
    pub max_error: f64,
    /// 99th percentile.
    pub p99_error: f64,
    /// Between two wedges of one vertex.
    pub seam_gap: f64,
}

/// The error that a number of bits gives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BitsError {
    /// 8 or 16 for integers, 32 for floating point.
    pub bits: u32,
    /// Largest distance of a vertex from where it should be, model units.
    pub max_error: f64,
}

/// Wedges that sample at their own texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnUvs {
    /// Vertices with several wedges.
    pub seam_vertices: usize,
    /// Those of them whose wedges all land on the same place, bit for bit.
    pub bit_equal_seam_vertices: usize,
    /// Largest distance between two wedges of one vertex after displacement, model units.
    pub seam_gap: f64,
}

/// Why bytes are not a manifest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ManifestError {
    /// Not JSON, or fields are missing or of the wrong type; the words name line and column.
    #[error("not a planish manifest: {0}")]
    Json(String),
    /// Another version of the format.
    #[error("the manifest has version {0}, but this planish reads version {VERSION}")]
    Version(String),
    /// A value that makes no sense.
    #[error("field `{field}`: {problem}")]
    Value {
        /// Path of the field.
        field: &'static str,
        /// What is wrong.
        problem: String,
    },
}

impl Manifest {
    /// Pairs of source vertex and texture coordinates, counted from 0: source vertices that sample elsewhere than where
    /// their first corner says.
    pub fn dominant_pairs(&self) -> Vec<[Index; 2]> {
        self.dominant_uv.as_ref().map(DominantUv::pairs).unwrap_or_default()
    }

    /// Reads and checks a manifest.
    pub fn from_json(bytes: &[u8]) -> Result<Self, ManifestError> {
        let json = |e: serde_json::Error| ManifestError::Json(e.to_string());
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(json)?;
        match value.get("planish") {
            None => return Err(ManifestError::Json("there is no field `planish` with the version".to_owned())),
            Some(version) if version.as_u64() != Some(VERSION) => {
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
        let ensure = |fine: bool, field, problem: String| {
            if fine { Ok(()) } else { Err(ManifestError::Value { field, problem }) }
        };
        let map = &self.displacement;
        for (side, field) in [(map.width, "displacement.width"), (map.height, "displacement.height")] {
            ensure((1..=LARGEST_SIDE).contains(&side), field, format!("{side} is not in 1..={LARGEST_SIDE}"))?;
        }
        let single = |x: f64| x.is_finite() && (x as f32).is_finite();
        ensure(single(map.bias), "displacement.bias", format!("{} is too large", map.bias))?;
        ensure(single(map.scale) && map.scale >= 0.0, "displacement.scale", format!("{} is not a scale", map.scale))?;
        let strength = map.lambda.abs() <= LARGEST_LAMBDA;
        ensure(strength, "displacement.lambda", format!("{} is not a strength", map.lambda))?;
        let near = map.origin.to_array().into_iter().all(single);
        ensure(near, "displacement.origin", format!("{} is too large", map.origin))?;
        let has_places = map.layout == Layout::Vertex || self.dominant_uv.is_some();
        ensure(has_places, "dominant_uv", "is missing, and the layout `uv` needs it".to_owned())?;
        let enough = map.layout == Layout::Uv || map.size().texels() >= self.source.vertices;
        let texels = map.size().texels();
        let problem = format!("{texels} texels are too few for {} vertices", self.source.vertices);
        ensure(enough, "displacement.width", problem)?;
        let pairs = self.dominant_uv.as_ref().map_or(&[][..], |uv| &uv.seam_vertices);
        let counted_from_one = pairs.iter().flatten().all(|&i| i > 0);
        ensure(counted_from_one, "dominant_uv.seam_vertices", "index 0: they count from 1".to_owned())?;
        let in_mesh = |pair: &[Index; 2]| pair[0] as usize <= self.source.vertices;
        let stray = pairs.iter().find(|pair| !in_mesh(pair));
        ensure(stray.is_none(), "dominant_uv.seam_vertices", format!("{stray:?} names no vertex"))
    }

    /// The JSON text: indented, but the pairs of indices on one line.
    pub fn to_json(&self) -> String {
        // Strings, numbers and lists cannot fail to become JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        let Some(pairs) = value.pointer_mut("/dominant_uv/seam_vertices").map(std::mem::take) else {
            return serde_json::to_string_pretty(&value).unwrap_or_default() + "\n";
        };
        let text = serde_json::to_string_pretty(&value).unwrap_or_default();
        text.replace("\"seam_vertices\": null", &format!("\"seam_vertices\": {pairs}")) + "\n"
    }
}

/// SHA-256, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest as _;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
