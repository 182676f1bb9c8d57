//! Bakes a mesh on disk into the files of its displacement map.

use crate::compression;
use crate::failure::Failure;
use crate::input;
use crate::method;
use crate::output::{self, Folder};
use crate::text::{count, volume_not_restored};
use planish_geometry::bake::{
    self, BakeError, BakeSettings, BakeTarget, Bundle, BundleFile, BundleNames, Fallback, LayoutChoice, SideFiles,
};
use planish_geometry::denoise::Denoising;
use planish_geometry::map::manifest::{self, HeightsLoss, Layout, Target};
use planish_geometry::mesh::atlas::AtlasError;
use planish_geometry::progress::Progress;
use planish_geometry::source::materials;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use std::path::{Path, PathBuf};

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
fn stem(input: &Path) -> Result<String, Failure> {
    let stem = compression::uncompressed_name(input).file_stem().map(|s| s.to_string_lossy().into_owned());
    stem.ok_or_else(|| Failure::at(input, "names no file"))
}

impl Job<'_> {
    /// Makes a method ready to run, and returns it as the goal of a bake.
    pub fn method(&self, denoising: Denoising) -> Result<BakeTarget, Failure> {
        let denoiser = method::prepare(denoising.denoiser, self.input)?;
        Ok(BakeTarget::Method(Denoising { denoiser, ..denoising }))
    }

    /// Reads the result of any other denoiser from `path`, and returns it as the goal of a bake. Fails if that mesh has another
    /// number of `v` lines than the input.
    pub fn target(&self, path: &Path) -> Result<BakeTarget, Failure> {
        let denoised = input::source(path)?;
        let (found, needed) = (denoised.data().positions().len(), self.model.data().positions().len());
        if found != needed {
            let reason =
                format!("has {found} {}, but {} has {needed}", denoised.format().vertices(), self.input.display());
            return Err(Failure::at(path, reason));
        }
        let target = Target::new(from_folder(path, self.folder), manifest::sha256(&denoised.bytes()));
        Ok(BakeTarget::from_mesh(self.model, denoised.data(), target))
    }

    /// Bakes into memory.
    pub fn run(&self, settings: &BakeSettings, progress: &dyn Progress) -> Result<Baked, Failure> {
        let Self { input, model, folder, protected } = *self;
        let names = names(input, folder, stem(input)?);
        let (found, missing): (Vec<_>, Vec<_>) =
            input::libraries(input, model.source()).into_iter().partition(|library| library.bytes.is_some());
        let missing = missing.iter().map(|l| l.path.display());
        let mut warnings: Vec<String> =
            missing.map(|path| format!("{path} cannot be read; the carrier will lack its materials")).collect();
        let (library_paths, libraries): (Vec<_>, Vec<_>) =
            found.into_iter().filter_map(|library| Some((library.path, library.bytes?))).unzip();
        warnings.extend(model.source().file().map_or(&[][..], MeshFile::notes).iter().cloned());
        let names_of_textures: Vec<String> = libraries.iter().flat_map(|bytes| materials::textures(bytes)).collect();
        let textures: Vec<PathBuf> = names_of_textures.iter().map(|name| texture_path(input, name)).collect();
        if settings.layout == LayoutChoice::Unwrap && !textures.is_empty() && !model.data().uvs().is_empty() {
            let reason = "the textures of the materials do not fit the carrier, which has new texture coordinates";
            warnings.push(reason.to_owned());
        }
        let mut inputs: Vec<PathBuf> = textures.into_iter().chain(library_paths).collect();
        inputs.push(input.to_path_buf());
        inputs.extend_from_slice(protected);
        if let BakeTarget::Positions { target, .. } = &settings.target {
            inputs.push(folder.join(&target.file));
        }
        // Textures within the mesh file become files beside the carrier.
        let embedded = |texture: &str| model.source().file().and_then(|file| file.embedded_texture(texture));
        let embedded_name = |texture: &str| format!("{}.{texture}", names.stem);
        let relocate = |texture: &str| {
            if embedded(texture).is_some() {
                return embedded_name(texture);
            }
            let path = texture_path(input, texture);
            // The name of a missing texture stays as it was written: the user may know why.
            if path.is_file() { from_folder(&path, folder) } else { texture.to_owned() }
        };
        let texture = |name: &str| embedded(name).or_else(|| std::fs::read(texture_path(input, name)).ok());
        let side_files = SideFiles { libraries: &libraries, relocate: &relocate, texture: &texture };
        let mut bundle = bake::bake(model, &names, side_files, settings, progress).map_err(|e| explain(e, input))?;
        let within = names_of_textures.iter().filter_map(|name| Some((embedded_name(name), embedded(name)?)));
        for (name, bytes) in within {
            if bundle.files.iter().all(|file| file.name != name) {
                bundle.files.push(BundleFile { name, bytes });
            }
        }
        warnings.extend(warn(&bundle));
        Ok(Baked { bundle, warnings, inputs })
    }
}

impl Baked {
    /// Writes all files or none, and returns their paths. Fails if one of them would overwrite an input.
    pub fn write(&self, folder: Folder) -> Result<Vec<PathBuf>, Failure> {
        let files = &self.bundle.files;
        files.iter().try_for_each(|f| output::refuse_overwrite(&folder.path().join(&f.name), &self.inputs))?;
        folder.write(files.iter().map(|f| (Path::new(&f.name), f.bytes.as_slice())))
    }
}

/// BundleNames the files. The carrier has the name of the source, unless it would then overwrite the source.
fn names(input: &Path, folder: &Path, stem: String) -> BundleNames {
    let is_input = |extension: &str| output::same_file(&folder.join(format!("{stem}.{extension}")), input);
    let taken = is_input("obj") || is_input("glb");
    let carrier = if taken { format!("{stem}.planish") } else { stem.clone() };
    BundleNames { source: from_folder(input, folder), stem, carrier }
}

/// Returns a path relative to a folder, with slashes.
fn from_folder(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().or_else(|_| std::path::absolute(p)).unwrap_or_else(|_| p.to_path_buf());
    let relative = pathdiff::diff_paths(absolute(path), absolute(folder));
    relative.unwrap_or_else(|| path.to_path_buf()).to_string_lossy().replace('\\', "/")
}

/// Returns the path of a texture that the materials of a mesh name.
fn texture_path(input: &Path, texture: &str) -> PathBuf {
    input.parent().unwrap_or(Path::new("")).join(texture.replace('\\', "/"))
}

/// Says why a mesh cannot be baked, with the option or the step in another program that helps.
fn explain(error: BakeError, input: &Path) -> Failure {
    match error {
        BakeError::Cancelled(_) => Failure::Interrupted,
        BakeError::Atlas(AtlasError::NoUvs) => Failure::at(
            input,
            "has no texture coordinates (no face names a `vt`): use --layout vertex, which needs none, --layout unwrap, or unwrap it first (in Blender: Edit Mode, U, Smart UV Project)",
        ),
        BakeError::NoTangents => {
            Failure::at(input, "has no texture coordinates, and --space tangent needs some; use --space object")
        }
        BakeError::Limits(e) => Failure::limits(&e, input),
        BakeError::Normals(e) => Failure::at(input, format!("{e}; use --normals angle")),
        #[cfg(feature = "unwrap")]
        e @ BakeError::Unwrap(_) => Failure::at(input, e),
        BakeError::ChartsDoNotFit { .. } => Failure::at(input, format!("{error}; use a larger --size or --max-size")),
        e @ (BakeError::NotFinite | BakeError::Gltf(_)) => Failure::at(input, e),
        other => Failure::Internal(format!("{}: {other}", input.display())),
    }
}

/// Lists the warnings about a bake that succeeded.
fn warn(bundle: &Bundle) -> Vec<String> {
    let m = &bundle.manifest;
    let r = &m.report;
    let mut out = r.layout.problems();
    if let Some(reason) = &bundle.fallback {
        out.push(format!("one texel for each vertex, because {reason}"));
    }
    if m.normal_map.is_none() && bundle.fallback != Some(Fallback::NoUvs) && m.displacement.layout == Layout::Vertex {
        out.push("no normal map: the texture coordinates of the mesh have no space for one".to_owned());
    }
    out.extend(r.limits.as_ref().and_then(volume_not_restored));
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
