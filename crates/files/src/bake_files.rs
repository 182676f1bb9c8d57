//! Bakes a mesh on disk into the files of its displacement map.
//!
//! ```
//! use planish_files::bake_files::{self, Job};
//! use planish_files::input::{self, Trust};
//! use planish_files::output::Folder;
//! use planish_geometry::bake::BakeSettings;
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//!
//! # let disk = tempfile::tempdir()?;
//! # let input = disk.path().join("tent.obj");
//! # std::fs::write(&input, "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")?;
//! let model = input::model(&input, Welding::Exact, Trust::Folder, &Silent)?;
//! let folder = bake_files::folder_beside(&input)?;
//! let job = Job { input: &input, model: &model, folder: &folder, protected: &[], trust: Trust::Folder };
//! let target = job.method(Denoiser::named("laplacian").unwrap().into())?;
//! let baked = job.run(&BakeSettings { target, ..BakeSettings::default() }, &Silent)?;
//! let written = baked.write(Folder::open(&folder)?)?;
//!
//! // The manifest comes last, and leads back to the mesh.
//! assert_eq!(written.last(), Some(&folder.join("tent.planish.json")));
//! assert_eq!(input::manifest(&folder.join("tent.planish.json"))?.source.file, "../tent.obj");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod lost;
mod pictures;
#[cfg(not(target_family = "wasm"))]
mod write;

#[cfg(not(target_family = "wasm"))]
pub(crate) use write::earlier;

use crate::compression;
use crate::disk;
use crate::failure::Failure;
use crate::input::{self, LARGEST_PICTURE, NamedFile, Trust};
use crate::method;
use crate::named_path::{self, NamedPath};
use crate::text::{count, in_tile, measure, one_line, shown, volume_not_restored};
use planish_geometry::bake::gltf::Picture;
use planish_geometry::bake::{
    self, BakeError, BakeSettings, BakeTarget, Bundle, BundleFile, BundleNames, Fallback, LayoutChoice, SideFiles, gltf,
};
use planish_geometry::denoise::{Denoiser, Denoising, Learned};
use planish_geometry::map::layout_issues::OutOfRange;
use planish_geometry::map::manifest::{self, HeightsLoss, Layout, Report, Target};
use planish_geometry::mesh::atlas::AtlasError;
use planish_geometry::progress::Progress;
use planish_geometry::source::flaws::flaws;
use planish_geometry::source::materials;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A mesh to bake and the folder that its files will lie in; names in the manifest and the materials depend on that folder.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// Path of the mesh.
    pub input: &'a Path,
    /// The mesh as it was read from `input`.
    pub model: &'a Model,
    /// Folder for the results; it need not exist yet.
    pub folder: &'a Path,
    /// Other files that were read, such as masks, and must not be overwritten.
    pub protected: &'a [PathBuf],
    /// Rule on the libraries and textures that the mesh names.
    pub trust: Trust,
}

/// A bake in memory, before its files are written.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Names and content of the files.
    pub bundle: Bundle,
    /// Warnings for the user about a bake that succeeded, one sentence each.
    pub warnings: Vec<String>,
    /// Paths of the files that were read, and must not be overwritten.
    inputs: Vec<PathBuf>,
    /// Name of the file of the bundle that holds the mesh itself; `None` if the mesh came from a file.
    own_source: Option<String>,
}

/// Returns the folder for the results if the user names none: `NAME-planish` in the working folder.
pub fn default_folder(input: &Path) -> Result<PathBuf, Failure> {
    Ok(PathBuf::from(format!("{}-planish", stem(input)?)))
}

/// Returns the folder `NAME-planish` beside the mesh, for programs without a working folder, such as the window.
pub fn folder_beside(input: &Path) -> Result<PathBuf, Failure> {
    Ok(input.with_file_name(default_folder(input)?))
}

/// Returns the name of a mesh without folder and extension, with which the names of all results begin.
pub(crate) fn stem(input: &Path) -> Result<String, Failure> {
    let name = compression::uncompressed_name(input);
    let stem = name.file_stem().ok_or_else(|| Failure::at(input, "names no file"))?.to_string_lossy();
    // OBJ and MTL name files in a line, which must stay one.
    Ok(stem.chars().map(|c| if c.is_control() { '_' } else { c }).collect())
}

impl Job<'_> {
    /// Makes a method ready to run, and returns it as the goal of a bake.
    pub fn method(&self, denoising: Denoising) -> Result<BakeTarget, Failure> {
        let mut denoiser = method::prepare(denoising.denoiser, self.input)?;
        // The manifest names files from its own folder.
        if let Denoiser::Learned(Learned { network: Some(file), .. }) = &mut denoiser {
            *file = from_folder(Path::new(file), self.folder);
        }
        Ok(BakeTarget::Method(Denoising { denoiser, ..denoising }))
    }

    /// Reads the result of any other denoiser from `path`, and returns it as the goal of a bake. Fails if that mesh has another
    /// number of `v` lines than the input.
    pub fn target(&self, path: &Path) -> Result<BakeTarget, Failure> {
        let denoised = input::source(path, self.trust)?;
        let (found, needed) = (denoised.data().positions().len(), self.model.data().positions().len());
        if found != needed {
            let reason =
                format!("has {found} {}, but {} has {needed}", denoised.format().vertices(), shown(self.input));
            return Err(Failure::at(path, reason));
        }
        let target = Target::new(from_folder(path, self.folder), manifest::sha256(&denoised.bytes()));
        Ok(BakeTarget::from_mesh(self.model, denoised.data(), target))
    }

    /// Bakes into memory.
    pub fn run(&self, settings: &BakeSettings, progress: &dyn Progress) -> Result<Baked, Failure> {
        let Self { input, model, folder, protected, trust } = *self;
        let names = names(input, folder, stem(input)?);
        let (mut missing, mut library_paths, mut libraries) = (Vec::new(), Vec::new(), Vec::new());
        let read = input::libraries(input, model.source(), trust);
        let mut notes = input::library_notes(&read, model.data());
        for library in read {
            match library.bytes {
                Ok(bytes) => libraries.push(bytes),
                Err(reason) => missing.push(format!("{reason}; the carrier will lack its materials")),
            }
            library_paths.push(library.path);
        }
        let mut warnings = input::summary(missing);
        let find = |texture: &str| named_path::find(input::folder_of(input), texture, trust);
        warnings.extend(model.source().file().map_or(&[][..], MeshFile::notes).iter().cloned());
        warnings.extend(flaws(model).iter().map(ToString::to_string));
        if input.to_str().is_none() {
            warnings.push(
                "the name of the mesh is not UTF-8, so the manifest cannot hold it; `check` will need --mesh"
                    .to_owned(),
            );
        }
        let is_kept = gltf::keeps_document(model.source());
        // Textures within the mesh file become files beside the carrier.
        let embedded = |texture: &str| model.source().file().and_then(|file| file.embedded_texture(texture));
        let embedded_name = |texture: &str| format!("{}.{texture}", names.stem);
        let names_of_textures: BTreeSet<String> =
            libraries.iter().flat_map(|bytes| materials::textures(bytes)).collect();
        let (mut within, mut textures) = (Vec::new(), BTreeSet::new());
        for name in &names_of_textures {
            match embedded(name) {
                Some(bytes) => within.push(BundleFile { name: embedded_name(name), bytes }),
                None => {
                    let NamedPath { path, note } = find(name);
                    textures.insert(path);
                    notes.extend(note);
                }
            }
        }
        let replaced: BTreeSet<String> = libraries.iter().flat_map(|bytes| materials::replaced_maps(bytes)).collect();
        if !replaced.is_empty() {
            let names = Vec::from_iter(replaced).join(", ");
            notes.push(format!("the carrier has maps of its own instead of {}", one_line(&names)));
        }
        warnings.extend(input::summary_of_notes(notes));
        if settings.layout == LayoutChoice::Unwrap && !names_of_textures.is_empty() && !model.data().uvs().is_empty() {
            // A document keeps its own texture coordinates beside the new ones.
            let of_obj = if is_kept { format!(" {}.obj", names.carrier) } else { String::new() };
            let reason = "which has new texture coordinates";
            warnings.push(format!("the textures of the materials do not fit the carrier{of_obj}, {reason}"));
        }
        let mut inputs: Vec<PathBuf> = textures.iter().cloned().chain(library_paths).collect();
        inputs.push(input.to_path_buf());
        inputs.extend_from_slice(protected);
        if let BakeTarget::Positions { target, .. } = &settings.target {
            inputs.push(folder.join(&target.file));
        }
        let relocate = |texture: &str| {
            if embedded(texture).is_some() {
                return embedded_name(texture);
            }
            let path = find(texture).path;
            let relocated = disk::is_file(&path).then(|| from_folder(&path, folder));
            // The name of a missing texture stays as it was written: the user may know why. A statement is one line.
            relocated.filter(|name| !name.contains(char::is_control)).unwrap_or_else(|| texture.to_owned())
        };
        let named =
            |path: &Path| NamedFile { path, folder: input::folder_of(input), trust, largest: LARGEST_PICTURE }.read();
        // The reason for each texture that is refused. One that is missing was missing before.
        let refused = Mutex::new(BTreeSet::new());
        let refuse = |reason: String| {
            if let Ok(mut refused) = refused.lock() {
                refused.insert(format!("{reason}; the glTF file will lack this texture"));
            }
        };
        let from_file = |name: &str| {
            let path = find(name).path;
            let read = named(&path);
            if let (Err(reason), true) = (&read, disk::exists(&path)) {
                refuse(reason.to_string());
            }
            read.ok()
        };
        let bytes_of = |name: &str| embedded(name).or_else(|| from_file(name));
        let refuse_file = |name: &str, reason: String| refuse(format!("{}: {reason}", shown(&find(name).path)));
        let texture = |picture: Picture| match picture {
            Picture::File(name) if is_kept => bytes_of(name),
            Picture::File(name) => {
                let made = pictures::for_gltf(bytes_of(name)?, Path::new(name));
                made.map_err(|reason| refuse_file(name, reason)).ok()
            }
            _ => pictures::combined(picture, &bytes_of, &refuse_file),
        };
        let side_files = SideFiles { libraries: &libraries, relocate: &relocate, texture: &texture, within: &within };
        let bundle = bake::bake(model, &names, side_files, settings, progress).map_err(|e| explain(e, model, input))?;
        warnings.extend(input::summary(refused.into_inner().unwrap_or_default()));
        warnings.extend(lost::document(model.source(), &bundle));
        warnings.extend(lost::maps(&libraries, &bundle).filter(|_| !is_kept));
        warnings.extend(warn(&bundle));
        Ok(Baked { bundle, warnings, inputs, own_source: None })
    }
}

/// Bakes a mesh that was given as arrays into memory. The files of the bundle begin with `name`, and the mesh itself becomes one of
/// them, `NAME.noisy.obj`, so that the map can be checked and applied. Fails if `name` is no name of a file.
pub fn bake_arrays(
    model: &Model,
    name: &str,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Baked, Failure> {
    if Path::new(name).file_name() != Some(name.as_ref()) || name.contains(char::is_control) {
        return Err(Failure::Input(format!("`{}` is no name of a file", name.escape_default())));
    }
    let source = format!("{name}.noisy.obj");
    let names = BundleNames { source: source.clone(), stem: name.to_owned(), carrier: name.to_owned() };
    let baked = bake::bake(model, &names, SideFiles::NONE, settings, progress);
    let mut bundle = baked.map_err(|e| explain(e, model, Path::new(name)))?;
    let mut warnings: Vec<String> = flaws(model).iter().map(ToString::to_string).collect();
    warnings.extend(warn(&bundle));
    let bytes = model.source().bytes().into_owned();
    // The manifest stays the last file.
    bundle.files.insert(bundle.files.len().saturating_sub(1), BundleFile { name: source.clone(), bytes });
    Ok(Baked { bundle, warnings, inputs: Vec::new(), own_source: Some(source) })
}

/// BundleNames the files. The carrier has the name of the source, unless it would then overwrite the source.
pub(crate) fn names(input: &Path, folder: &Path, stem: String) -> BundleNames {
    let is_input = |extension: &str| disk::same_file(&folder.join(format!("{stem}.{extension}")), input);
    let taken = is_input("obj") || is_input("glb");
    let carrier = if taken { format!("{stem}.planish") } else { stem.clone() };
    // A pipe has no place to which a path could lead back.
    let is_file = disk::is_file(input);
    let name = || input.file_name().unwrap_or_default().to_string_lossy().into_owned();
    BundleNames { source: if is_file { from_folder(input, folder) } else { name() }, stem, carrier }
}

/// Returns a path relative to a folder, with slashes.
fn from_folder(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| disk::canonicalize(p).or_else(|_| disk::absolute(p)).unwrap_or_else(|_| p.to_path_buf());
    let relative = pathdiff::diff_paths(absolute(path), absolute(folder));
    relative.unwrap_or_else(|| path.to_path_buf()).to_string_lossy().replace('\\', "/")
}

/// Says why a mesh cannot be baked, with the option or the step in another program that helps.
fn explain(error: BakeError, model: &Model, input: &Path) -> Failure {
    match error {
        BakeError::Cancelled(_) => Failure::Interrupted,
        BakeError::Atlas(AtlasError::NoUvs) => Failure::at(
            input,
            "has no texture coordinates (no face names a `vt`): use --layout vertex, which needs none, --layout unwrap, or unwrap it first (in Blender: Edit Mode, U, Smart UV Project)",
        ),
        BakeError::Atlas(AtlasError::NonFinite { uv }) => {
            let line = model.source().as_obj().and_then(|obj| obj.uv_line(uv));
            let place = line
                .map_or_else(|| format!("texture coordinate {uv} (counted from 0): "), |line| format!("line {line}: "));
            let reason = "a texture coordinate that a face uses is not finite in single precision";
            Failure::at(input, format!("{place}{reason}"))
        }
        BakeError::TooFar { source_vertex } => {
            let place = input::vertex_place(model.source(), source_vertex);
            Failure::at(
                input,
                format!("{place}a coordinate is too large for single precision, in which maps are applied"),
            )
        }
        BakeError::NoTangents => {
            Failure::at(input, "has no texture coordinates, and --space tangent needs some; use --space object")
        }
        BakeError::Limits(e) => Failure::limits(&e, input),
        BakeError::Normals(e) => Failure::at(input, format!("{e}; use --normals angle")),
        #[cfg(feature = "unwrap")]
        e @ BakeError::Unwrap(_) => Failure::at(input, e),
        BakeError::ChartsDoNotFit { .. } => Failure::at(input, format!("{error}; use a larger --size or --max-size")),
        BakeError::TooManyPages(e) => Failure::at(input, format!("{e}; use --pages none")),
        BakeError::PagesWithLayout(layout) => {
            Failure::at(input, format!("pages do not go with the layout {}, which makes one image", layout.name()))
        }
        e @ (BakeError::NotFinite | BakeError::NotMeasurable | BakeError::Gltf(_)) => Failure::at(input, e),
        other => Failure::Internal(format!("{}: {other}", shown(input))),
    }
}

/// Says how many vertices have private texels, why, and what programs make of them that know only the mesh's own UVs.
fn private_texels(report: &Report) -> String {
    let vertices = |n| count(n, "vertex", "vertices");
    let layout = &report.layout;
    let mirrored = if layout.mirrored_faces > 0 { ", some of them mirrored" } else { "" };
    let reasons = [
        (layout.unmapped_vertices, "have no UVs".to_owned()),
        (layout.out_of_range_vertices, "lie outside [0, 1]".to_owned()),
        (layout.overlapping_texels, format!("lie where charts overlap{mirrored}")),
        (layout.crowded_vertices, "are less than two texels from another one".to_owned()),
    ];
    let reasons: Vec<String> = reasons.into_iter().filter(|reason| reason.0 > 0).map(|reason| reason.1).collect();
    let mut text =
        format!("private texels for {}, of those that {}", vertices(report.private_vertices), reasons.join(" or "));
    if let Some(errors) = report.own_uvs.as_ref().and_then(|own| own.errors).filter(|errors| errors.vertices > 0) {
        let (n, max) = (vertices(errors.vertices), measure(errors.max));
        text.push_str(&format!("; a program that knows only the mesh's own UVs puts {n} wrong, by {max} at most"));
    }
    text
}

/// Lists the warnings about a bake that succeeded.
fn warn(bundle: &Bundle) -> Vec<String> {
    let m = &bundle.manifest;
    let r = &m.report;
    let mut out = if r.private_vertices > 0 { vec![private_texels(r)] } else { r.layout.problems() };
    if let Some(reason) = &bundle.fallback {
        out.push(format!("one texel for each vertex, because {reason}"));
    }
    let without_normals = m.page_entries().iter().filter(|page| page.normal_map.is_none());
    let without_normals: Vec<String> = without_normals.map(|page| page.part.to_string()).collect();
    if !without_normals.is_empty() {
        let pages = one_line(&without_normals.join(", "));
        out.push(format!("no normal map on pages {pages}: the texture coordinates of the mesh have no space for one"));
    }
    if m.pages.is_none() && m.normal_map.is_none() && bundle.fallback != Some(Fallback::NoUvs) {
        out.push("no normal map: the texture coordinates of the mesh have no space for one".to_owned());
    }
    out.extend(in_tile(m.displacement.tile));
    if m.pages.is_none() && r.layout.out_of_range == Some(OutOfRange::Tiles) {
        out.push("the UVs lie in several whole tiles: --pages udim makes an image for each of them".to_owned());
    }
    let per_vertex = m.occlusion.as_ref().filter(|occlusion| occlusion.map.layout == Layout::Vertex);
    if let (Some(_), Some(name)) = (per_vertex, &m.carrier.glb) {
        let extras = "with a texel for each vertex it is in the extras of the materials";
        out.push(format!("{name} has the ambient occlusion as no `occlusionTexture`: {extras}"));
    }
    out.extend(r.limits.as_ref().and_then(volume_not_restored));
    if bundle.shared_backs > 0 {
        let are =
            if bundle.shared_backs == 1 { "face is the back of another one" } else { "faces are backs of others" };
        out.push(format!(
            "{} {are} with which they share vertices or texels: in {} both sides have the normals of the fronts",
            bundle.shared_backs, m.carrier.obj
        ));
    }
    let vertices = |n| count(n, "vertex", "vertices");
    if r.vertices_without_normal > 0 {
        let n = vertices(r.vertices_without_normal);
        out.push(format!("{n} without a normal (their faces cancel): they stay where they are"));
    }
    if let Some(heights) = r.heights.filter(HeightsLoss::is_much) {
        out.push(format!("{heights}; use --map vector"));
    }
    if r.unresolved_vertices > 0 {
        let (n, side) = (vertices(r.unresolved_vertices), m.displacement.width);
        let tolerance = r.tolerance_quanta;
        let suggestion = r.suggestion.as_ref().map(|s| format!("; {s}")).unwrap_or_default();
        out.push(format!("{n} off by more than {tolerance} quanta at {side}{suggestion}"));
    }
    out
}
