//! The whole bake: a model becomes the files of a displacement map, each as bytes.
//!
//! Whoever bakes, the command line or a window, writes these bytes and nothing else.

mod carrier;
mod check;
mod describe;
mod error;
mod goal;
mod layout;
mod maps;
mod report;
mod settings;
#[cfg(feature = "unwrap")]
mod unwrapped;

pub use check::check;
pub use error::BakeError;
pub use goal::{Goal, Ways};
pub use layout::{Fallback, LayoutChoice};
pub use settings::{Carriers, Lambda, LargestSide, Quanta, Settings};

use crate::atlas::AtlasError;
use crate::displacement::MapKind;
use crate::manifest::{self, Carrier, Layout, Manifest, UvSource};
use crate::materials;
use crate::model::Model;
use crate::progress::Progress;
use crate::texture::Texels;
use crate::texture::resolution::{Choice, Reason};
use carrier::CarrierFile;
use describe::{describe, statements};
use maps::Maps;
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
