//! The whole bake: a model becomes the files of a displacement map, each as bytes.
//!
//! Whoever bakes, the command line or a window, writes these bytes and nothing else.

mod carrier;
mod goal;
mod layout;
mod maps;
mod report;
mod settings;
#[cfg(feature = "unwrap")]
mod unwrapped;

pub use goal::{Goal, Ways};
pub use layout::{Fallback, LayoutChoice};
pub use settings::{Carriers, Lambda, LargestSide, Quanta, Settings};

use crate::apply;
use crate::atlas::{Atlas, AtlasError};
use crate::denoise::limits::LimitsError;
use crate::displacement::{DecodeError, EncodeError, MapKind};
use crate::gltf::GltfError;
use crate::manifest::{
    self, Carrier, Clients, DominantUv, Layout, Manifest, MapEntry, NormalMapEntry, Report, Source, UvSource,
};
use crate::materials::{self, MapStatements};
use crate::model::{Model, NoFileNormals};
use crate::obj::{Obj, ObjError};
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use crate::texture::findings::Findings;
use crate::texture::resolution::{Choice, Reason, Spacing};
use crate::texture::{Coverage, Texels, tangents};
use crate::weld::Welding;
use carrier::CarrierFile;
use glam::{DVec3, Vec2};
use maps::{Maps, Offsets};
use report::Evidence;

/// What belongs to a source and lies in other files.
#[derive(Clone, Copy)]
pub struct Belongings<'a> {
    /// Its material libraries.
    pub libraries: &'a [Vec<u8>],
    /// Turns the name of a texture as it stands in them into one that holds where the carrier will lie.
    pub relocate: &'a dyn Fn(&str) -> String,
    /// The bytes of a texture, by its name in the libraries.
    pub texture: &'a dyn Fn(&str) -> Option<Vec<u8>>,
}

impl Belongings<'_> {
    /// Nothing.
    pub const NONE: Belongings<'static> = Belongings { libraries: &[], relocate: &str::to_owned, texture: &|_| None };
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
    /// Why the size was chosen; none where it was given or follows from the number of vertices.
    pub choice: Option<Choice>,
    /// Why the texture coordinates of the mesh were not used; none where they were, or were not asked for.
    pub fallback: Option<Fallback>,
}

/// Whether [`LayoutChoice::Unwrap`] is there: the feature `unwrap`.
pub const CAN_UNWRAP: bool = cfg!(feature = "unwrap");

/// Why there is no bundle.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// No layout.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// [`MapKind::VectorTangent`] without texture coordinates.
    #[error("tangent space needs texture coordinates, and the mesh has none")]
    NoTangents,
    /// [`NormalSource::File`](crate::model::NormalSource::File) without normals in the file.
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
    Unwrap(crate::unwrap::UnwrapError),
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

/// Denoises, bakes, writes to memory, reads back and measures.
///
/// `beside` is what the source's materials need.
pub fn bake(
    model: &Model,
    names: &Names,
    beside: Belongings,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    if settings.layout == LayoutChoice::Unwrap && !CAN_UNWRAP {
        return Err(BakeError::CannotUnwrap);
    }
    // What cannot be baked shall not have to be denoised first.
    match (model.atlas(), settings.layout) {
        (Ok(_), _) | (_, LayoutChoice::Unwrap) => {}
        (Err(AtlasError::NoUvs), _) if settings.map == MapKind::VectorTangent => return Err(BakeError::NoTangents),
        (Err(AtlasError::NoUvs), LayoutChoice::Auto | LayoutChoice::Vertex) => {}
        (Err(e), _) => return Err(e.into()),
    }
    let ways = settings.goal.ways(model, settings.map, settings.normals, progress)?;
    if ways.deltas.iter().any(|delta| !delta.as_vec3().is_finite()) {
        return Err(BakeError::NotFinite);
    }
    #[cfg(feature = "unwrap")]
    if settings.layout == LayoutChoice::Unwrap {
        return unwrapped::bake(model, &ways, names, beside, settings, progress);
    }
    bake_model(model, None, &ways, names, beside, settings, progress)
}

/// The same in the layout that is there. A model that was unwrapped comes with the one that it was before.
fn bake_model(
    model: &Model,
    before: Option<&Model>,
    ways: &Ways,
    names: &Names,
    beside: Belongings,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Bundle, BakeError> {
    progress.stage("layout");
    let atlas = match (model.atlas(), settings.layout) {
        (Ok(atlas), _) => Some(atlas),
        (Err(AtlasError::NoUvs), LayoutChoice::Auto | LayoutChoice::Vertex) => None,
        (Err(e), _) => return Err(e.into()),
    };
    let normals = &ways.normals;
    let library_file = format!("{}.mtl", names.carrier);
    // Writing and reading a text file keeps one thread as busy as the maps keep the others.
    let ((source_sha256, carrier), maps) = rayon::join(
        || {
            let places = atlas.is_none().then(|| carrier::places(model));
            let carrier = CarrierFile::make(model, normals, places.as_deref(), &library_file);
            (manifest::sha256(before.unwrap_or(model).obj().bytes()), carrier)
        },
        || Maps::bake(model, atlas.as_ref(), ways, settings, progress),
    );
    let (carrier, mut maps) = (carrier?, maps?);
    progress.check()?;
    let mut manifest = describe(model, ways, names, atlas.as_ref(), settings, &maps);
    manifest.source.sha256 = source_sha256;
    if manifest.displacement.layout == Layout::Uv {
        manifest.displacement.uvs = if before.is_some() { UvSource::Unwrapped } else { UvSource::Mesh };
    }
    let glb = (settings.carriers == Carriers::ObjAndGlb).then(|| format!("{}.glb", names.carrier));
    manifest.carrier =
        Carrier { obj: format!("{}.obj", names.carrier), mtl: library_file, glb, sha256: carrier.sha256.clone() };
    progress.stage("verifying");
    let evidence = Evidence {
        model,
        ways,
        frames: &maps.frames,
        offsets: &maps.offsets,
        findings: maps.findings.clone(),
        channels: &maps.channels,
        displacement: &maps.displacement,
        carrier: &carrier.obj,
    };
    manifest.report = report::measure(&evidence, &manifest)?;
    let missed = manifest.report.unresolved_vertices;
    if settings.layout == LayoutChoice::Auto && settings.texels == Texels::Fitted && missed > 0 && maps.plan.is_uv() {
        // What was written is what counts, whatever the plan promised.
        let instead = Settings { layout: LayoutChoice::Vertex, ..settings.clone() };
        let (side, vertices) = (maps.size.width, model.surface().positions().len());
        let choice = Choice { side, vertices, left: missed, reason: Reason::AlmostExact, largest: side };
        let problems = maps.findings.problems().into_iter().chain(maps.findings.crowding()).collect();
        let bundle = bake_model(model, None, ways, names, beside, &instead, progress)?;
        return Ok(Bundle { fallback: Some(Fallback::Layout { choice, problems }), ..bundle });
    }
    progress.check()?;
    let library = materials::carrier_library(
        model.obj(),
        beside.libraries,
        &statements(&manifest, atlas.is_some()),
        beside.relocate,
    );
    let glb = manifest.carrier.glb.as_ref().map(|_| {
        progress.stage("glTF");
        carrier::glb(model, normals, &manifest, &maps, &carrier.obj, names, beside)
    });
    let glb = glb.transpose()?;
    progress.check()?;
    let file = |name: &str, bytes| File { name: name.to_owned(), bytes };
    let mut files = vec![file(&manifest.displacement.file, std::mem::take(&mut maps.displacement))];
    if let (Some(entry), Some((image, _))) = (&manifest.normal_map, maps.normal_map) {
        files.push(file(&entry.file, image));
    }
    files.push(file(&manifest.carrier.obj, carrier.obj.into_bytes()));
    files.push(file(&manifest.carrier.mtl, library));
    files.extend(manifest.carrier.glb.as_ref().zip(glb).map(|(name, bytes)| file(name, bytes)));
    files.push(file(&format!("{}.planish.json", names.stem), manifest.to_json().into_bytes()));
    let (choice, fallback) = maps.plan.into_reasons();
    Ok(Bundle { files, manifest, choice, fallback })
}

/// Measures written files once more: the report that their manifest should have.
///
/// `goal` is what the manifest's method says, `displacement` and `carrier` are the files that it names.
pub fn check(
    model: &Model,
    manifest: &Manifest,
    goal: &Goal,
    displacement: &[u8],
    carrier: &Obj,
    progress: &dyn Progress,
) -> Result<Report, BakeError> {
    progress.stage("layout");
    let entry = &manifest.displacement;
    let unwrapped =
        (entry.uvs == UvSource::Unwrapped).then(|| with_uvs_of(model, carrier, manifest.welding)).transpose()?;
    let model = unwrapped.as_ref().unwrap_or(model);
    let atlas = match model.atlas() {
        Err(AtlasError::NoUvs) if entry.layout == Layout::Vertex => None,
        atlas => Some(atlas?),
    };
    let ways = goal.ways(model, entry.map, Some(manifest.normals), progress)?;
    let mut frames = Vec::new();
    if entry.map == MapKind::VectorTangent {
        let atlas = atlas.as_ref().ok_or(BakeError::NoTangents)?;
        let of_corners = tangents::tangents(model.surface(), atlas, &ways.normals);
        frames = tangents::at_vertices(model.surface(), atlas, &ways.normals, &of_corners);
    }
    let offsets = Offsets::new(model, entry.map, &ways, &frames);
    let findings = match (&atlas, entry.layout) {
        (Some(atlas), Layout::Uv) => {
            let coverage = Coverage::new(model.surface(), atlas, entry.size(), progress)?;
            Findings::of(model.surface(), atlas, &Spacing::new(atlas), &coverage)
        }
        _ => Findings { coverage: maps::share(model, entry.size()), ..Findings::default() },
    };
    progress.stage("verifying");
    let evidence = Evidence {
        model,
        ways: &ways,
        frames: &frames,
        offsets: &offsets,
        findings,
        channels: &[],
        displacement,
        carrier,
    };
    Ok(report::measure(&evidence, manifest)?)
}

/// A mesh with the texture coordinates of its carrier.
fn with_uvs_of(model: &Model, carrier: &Obj, welding: Welding) -> Result<Model, BakeError> {
    let (own, of_carrier) = (model.obj().faces(), carrier.faces());
    let same = own.len() == of_carrier.len() && own.iter().zip(of_carrier.iter()).all(|(f, g)| f.len() == g.len());
    let corners: Option<Vec<Index>> = of_carrier.items().iter().map(|corner| corner.uv()).collect();
    let corners = corners.filter(|_| same).ok_or(BakeError::OtherFaces)?;
    let uvs: Vec<Vec2> = carrier.uvs().iter().map(|uv| uv.as_vec2()).collect();
    Ok(Model::new(Obj::parse(model.obj().with_uvs(&uvs, &corners))?, welding))
}

/// The manifest as far as it is known before the files are.
fn describe(
    model: &Model,
    ways: &Ways,
    names: &Names,
    atlas: Option<&Atlas>,
    settings: &Settings,
    maps: &Maps,
) -> Manifest {
    let size = maps.size;
    let is_uv = maps.plan.is_uv();
    let normal_map = maps.normal_map.as_ref().map(|(_, size)| NormalMapEntry {
        file: format!("{}.normal.png", names.stem),
        width: size.width,
        height: size.height,
        convention: settings.convention,
    });
    Manifest {
        planish: manifest::VERSION,
        source: Source {
            file: names.source.clone(),
            sha256: String::new(),
            vertices: model.obj().positions().len(),
            faces: model.obj().faces().len(),
        },
        method: settings.goal.method(settings.map),
        choice: ways.choice.clone(),
        welding: settings.welding,
        normals: ways.source,
        displacement: MapEntry {
            file: format!("{}.displacement.{}", names.stem, settings.texel.file().extension()),
            map: settings.map,
            layout: if is_uv { Layout::Uv } else { Layout::Vertex },
            interpolation: is_uv.then_some(settings.interpolation),
            texels: is_uv.then_some(settings.texels),
            uvs: UvSource::Mesh,
            width: size.width,
            height: size.height,
            texel: settings.texel,
            bias: maps.encoding.bias.into(),
            scale: maps.encoding.scale.into(),
            lambda: settings.lambda.0,
            origin: apply::origin(model.surface().bounds()),
        },
        dominant_uv: atlas.filter(|_| is_uv).map(|atlas| dominant_uv(model, atlas)),
        normal_map,
        carrier: Carrier::default(),
        report: Report { tolerance_quanta: settings.tolerance.0, ..Report::default() },
        clients: Clients::new(settings.map, ways.source, maps.encoding, settings.lambda.0),
    }
}

/// What the carrier's materials say. A client would take a map in the wrong place for one in the right place, so it is
/// named only where it belongs to the texture coordinates in the file.
fn statements(manifest: &Manifest, has_own_uvs: bool) -> MapStatements<'_> {
    let in_place = manifest.displacement.layout == Layout::Uv || !has_own_uvs;
    let displacement = manifest.clients.mtl.filter(|_| in_place).map(|mtl| materials::DisplacementStatement {
        file: &manifest.displacement.file,
        base: mtl.base,
        gain: mtl.gain,
    });
    MapStatements { displacement, normal: manifest.normal_map.as_ref().map(|map| map.file.as_str()) }
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

/// p − λ · δ for each vertex, given where they go at λ = 1 (#V×3). #V×3, model units.
fn apply_offsets(model: &Model, places: &[DVec3], lambda: f64) -> Vec<DVec3> {
    model.surface().positions().iter().zip(places).map(|(p, q)| *p - lambda * (*p - *q)).collect()
}
