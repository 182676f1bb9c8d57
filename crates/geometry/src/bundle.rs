//! The whole bake: a model becomes the files of a displacement map, each as bytes.
//!
//! Whoever bakes, the command line or a window, writes these bytes and nothing else.

mod report;

use crate::apply;
use crate::atlas::{Atlas, AtlasError};
use crate::denoise::Denoiser;
use crate::displacement::{self, Bits, DecodeError, Displacement, Encoding};
use crate::manifest::{
    self, Carrier, Clients, DominantUv, Layout, Manifest, MapEntry, Method, NormalMapEntry, Report, Source, Target,
};
use crate::materials::{self, MapStatements};
use crate::model::{Model, NoFileNormals, NormalSource};
use crate::normals;
use crate::obj::{Obj, ObjError};
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::surface::Surface;
use crate::texture::normal_map::{self, Convention};
use crate::texture::resolution::{Choice, Spacing};
use crate::texture::tangents;
use crate::texture::{self, Coverage, Interpolation, Size, Texels};
use crate::weld::Welding;
use glam::{DVec3, Vec3};

/// All that can be chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Where the vertices shall go.
    pub goal: Goal,
    /// How the model was welded; goes into the manifest.
    pub welding: Welding,
    /// Along which normals to displace.
    pub normals: NormalSource,
    /// Strength for the normal map and the clients.
    pub lambda: Lambda,
    /// Side of the maps; none chooses it.
    pub side: Option<u32>,
    /// How texels between vertices are filled.
    pub interpolation: Interpolation,
    /// What is done to the texels that vertices sample.
    pub texels: Texels,
    /// Of a texel.
    pub bits: Bits,
    /// Of the normal map.
    pub convention: Convention,
}

/// Where the vertices shall go.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// Where a method takes them.
    Denoiser(Denoiser),
    /// To these places: the heights of any denoised mesh.
    Target {
        /// Of the vertices. #V×3, model units
        positions: Vec<DVec3>,
        /// Where they are from.
        target: Target,
    },
}

impl Default for Goal {
    fn default() -> Self {
        Self::Denoiser(Denoiser::default())
    }
}

impl Goal {
    /// δ = p − p*. #V×3, model units
    ///
    /// # Panics
    /// If a target has not one position for each vertex.
    pub fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        match self {
            Self::Denoiser(denoiser) => denoiser.deltas(surface, progress),
            Self::Target { positions, .. } => {
                assert_eq!(positions.len(), surface.positions().len(), "one target for each vertex");
                Ok(surface.positions().iter().zip(positions).map(|(p, q)| *p - *q).collect())
            }
        }
    }
    fn method(&self) -> Method {
        match self {
            Self::Denoiser(denoiser) => Method::Denoiser(denoiser.clone()),
            Self::Target { target, .. } => Method::Target(target.clone()),
        }
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

/// What the files are called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// The source as the manifest shall name it.
    pub source: String,
    /// Beginning of the names of the maps and the manifest.
    pub stem: String,
    /// Beginning of the names of the carrier and its materials.
    pub carrier: String,
}

/// A file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Name without a folder.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// The result of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Maps, carrier and materials; the manifest comes last.
    pub files: Vec<File>,
    /// What the last file says.
    pub manifest: Manifest,
    /// Why the size was chosen; none where it was given.
    pub choice: Option<Choice>,
}

/// Why there is no bundle.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// No layout.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// [`NormalSource::File`] without normals in the file.
    #[error(transparent)]
    Normals(#[from] NoFileNormals),
    /// An image could not be made.
    #[error("the image cannot be encoded: {0}")]
    Encode(#[from] image::ImageError),
    /// What was written did not read back: the fault is here.
    #[error("the map does not read back: {0}")]
    Decode(#[from] DecodeError),
    /// The same for the carrier.
    #[error("the carrier does not read back: {0}")]
    Carrier(#[from] ObjError),
    /// The heights left what single precision can hold.
    #[error("denoising gave heights that are not finite numbers in single precision")]
    NotFinite,
    /// As asked.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Normals of the vertices (#V×3) in single precision, as baker, carrier and shader use them.
pub fn displacement_normals(model: &Model, source: NormalSource) -> Result<Vec<Vec3>, NoFileNormals> {
    Ok(model.vertex_normals(source)?.into_iter().map(glam::DVec3::as_vec3).collect())
}

/// Denoises, bakes, writes to memory, reads back and measures.
///
/// `libraries` are the material libraries of the source, `relocate` turns the name of a texture as it stands there into
/// one that holds where the carrier will lie.
pub fn bake(
    model: &Model,
    names: &Names,
    libraries: &[Vec<u8>],
    relocate: impl Fn(&str) -> String,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    progress.stage("layout");
    let surface = model.surface();
    let atlas = model.atlas()?;
    let normals = displacement_normals(model, settings.normals)?;
    let library_file = format!("{}.mtl", names.carrier);
    // Writing and reading a text file keeps one thread as busy as the maps keep the others.
    let ((source_sha256, carrier), maps) = rayon::join(
        || (manifest::sha256(model.obj().bytes()), CarrierFile::make(model, &normals, &library_file)),
        || Maps::bake(model, &atlas, &normals, settings, progress),
    );
    let (carrier, maps) = (carrier?, maps?);
    progress.check()?;

    let map_file = format!("{}.displacement.{}", names.stem, settings.bits.extension());
    let normal_file = format!("{}.normal.png", names.stem);
    let clients = Clients::new(maps.encoding, settings.lambda.0);
    let statements =
        MapStatements { displacement: &map_file, base: clients.mtl.base, gain: clients.mtl.gain, normal: &normal_file };
    let library = materials::carrier_library(model.obj(), libraries, &statements, relocate);
    let size = maps.coverage.size();
    let mut manifest = Manifest {
        planish: manifest::VERSION,
        source: Source {
            file: names.source.clone(),
            sha256: source_sha256,
            vertices: model.obj().positions().len(),
            faces: model.obj().faces().len(),
        },
        method: settings.goal.method(),
        welding: settings.welding,
        normals: settings.normals,
        displacement: MapEntry {
            file: map_file,
            layout: Layout::Uv,
            interpolation: settings.interpolation,
            texels: settings.texels,
            width: size.width,
            height: size.height,
            bits: settings.bits,
            bias: maps.encoding.bias.into(),
            scale: maps.encoding.scale.into(),
            lambda: settings.lambda.0,
            origin: apply::origin(surface.bounds()),
        },
        dominant_uv: dominant_uv(model, &atlas),
        normal_map: NormalMapEntry { file: normal_file, convention: settings.convention },
        carrier: Carrier { obj: format!("{}.obj", names.carrier), mtl: library_file, sha256: carrier.sha256 },
        report: Report::default(),
        clients,
    };
    progress.stage("verifying");
    let layout = report::LayoutFindings::of(&atlas, &maps.spacing, &maps.coverage);
    let expected = displaced(model, &maps.heights, &normals, 1.0);
    manifest.report =
        report::measure(model, &expected, &normals, &manifest, &maps.displacement, &carrier.obj, &layout)?;
    progress.check()?;
    let file = |name: &str, bytes| File { name: name.to_owned(), bytes };
    let files = vec![
        file(&manifest.displacement.file, maps.displacement),
        file(&manifest.normal_map.file, maps.normal_map),
        file(&manifest.carrier.obj, carrier.obj.into_bytes()),
        file(&manifest.carrier.mtl, library),
        file(&format!("{}.planish.json", names.stem), manifest.to_json().into_bytes()),
    ];
    Ok(Bundle { files, manifest, choice: maps.choice })
}

/// p − λ · h · n for each vertex. #V×3, model units.
fn displaced(model: &Model, heights: &[f64], normals: &[Vec3], lambda: f64) -> Vec<DVec3> {
    let places = model.surface().positions().iter().zip(heights.iter().zip(normals));
    places.map(|(p, (h, n))| *p - lambda * h * n.as_dvec3()).collect()
}

/// The carrier as it reads back.
struct CarrierFile {
    obj: Obj,
    sha256: String,
}

impl CarrierFile {
    fn make(model: &Model, normals: &[Vec3], library_file: &str) -> Result<Self, ObjError> {
        let welded: Vec<DVec3> = model.weld().spread(model.surface().positions());
        let bytes = model.obj().carrier(&welded, &carrier_normals(model, normals), library_file);
        let sha256 = manifest::sha256(&bytes);
        Ok(Self { obj: Obj::parse(bytes)?, sha256 })
    }
}

/// Both maps and what they were made from.
struct Maps {
    /// #V, model units.
    heights: Vec<f64>,
    encoding: Encoding,
    spacing: Spacing,
    choice: Option<Choice>,
    coverage: Coverage,
    /// The image files.
    displacement: Vec<u8>,
    normal_map: Vec<u8>,
}

impl Maps {
    fn bake(
        model: &Model,
        atlas: &Atlas,
        normals: &[Vec3],
        settings: &Settings,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let surface = model.surface();
        let deltas = settings.goal.deltas(surface, progress)?;
        let heights = normals::heights(&deltas, normals);
        drop(deltas);
        if heights.iter().any(|h| !(*h as f32).is_finite()) {
            return Err(BakeError::NotFinite);
        }
        progress.stage("spacing");
        let spacing = Spacing::new(atlas);
        let choice = match (settings.side, settings.texels) {
            (Some(_), _) => None,
            (None, Texels::Fitted) => Some(spacing.choose_exact(atlas, &heights, settings.bits, progress)?),
            (None, Texels::Interpolated) => Some(spacing.choose()),
        };
        let side = settings.side.or(choice.map(|choice| choice.side)).unwrap_or_default();
        let coverage = Coverage::new(surface, atlas, Size::square(side), progress)?;
        let mut map = texture::bake(surface, atlas, &heights, &coverage, settings.interpolation, progress)?;
        if settings.texels == Texels::Fitted {
            texture::fit(&mut map, atlas, &heights, settings.bits, progress)?;
        }
        progress.stage("encoding");
        let [low, high] = map.range();
        let encoding = Encoding::covering(low.into(), high.into(), settings.bits);
        let displacement = Displacement::encode(&map, encoding).to_bytes()?;
        drop(map);
        progress.stage("tangent frames");
        let tangents = tangents::tangents(surface, atlas, normals);
        progress.check()?;
        let shaded = displaced(model, &heights, normals, settings.lambda.0);
        let normal_map =
            normal_map::bake(surface, normals, &tangents, shaded, &coverage, settings.convention, progress)?;
        progress.stage("encoding");
        let colour = image::ExtendedColorType::Rgb8;
        let normal_map = displacement::png(normal_map.texels.as_flattened(), coverage.size(), colour)?;
        Ok(Self { heights, encoding, spacing, choice, coverage, displacement, normal_map })
    }
}

/// Normals of the `v` lines. Where there is none the height is zero, and any direction does; a client would make NaN
/// of a zero vector.
fn carrier_normals(model: &Model, normals: &[Vec3]) -> Vec<Vec3> {
    let mut normals = model.weld().spread(normals);
    for n in normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        *n = Vec3::Z;
    }
    normals
}

/// Lists the `v` lines of vertices with several wedges, and those for which some corner names another place than the
/// dominant one: a face that the surface leaves out, a second layer say, is drawn all the same.
fn dominant_uv(model: &Model, atlas: &Atlas) -> DominantUv {
    let (obj, vertex_of) = (model.obj(), model.weld().vertex_of());
    let place = |uv: Index| obj.uvs()[uv as usize];
    let mut listed: Vec<bool> = vertex_of.iter().map(|&v| atlas.wedges().get(v).len() > 1).collect();
    for corner in obj.faces().items() {
        let line = corner.position as usize;
        listed[line] |= corner.uv().map(place) != atlas.dominant(vertex_of[line]).map(place);
    }
    let pair = |(line, &v): (Index, &Index)| {
        let uv = atlas.dominant(v).filter(|_| listed[line as usize])?;
        Some([line + 1, uv + 1])
    };
    let seam_vertices = (0..).zip(vertex_of).filter_map(pair).collect();
    DominantUv { rule: Atlas::DOMINANT_RULE.to_owned(), seam_vertices }
}
