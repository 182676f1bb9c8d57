//! From a mesh on disk to the files of its displacement map.

use crate::failure::Failure;
use crate::input;
use crate::method;
use crate::output::{self, Folder};
use crate::text::{count, volume_not_restored};
use planish_geometry::bake::{self, BakeError, Belongings, Bundle, Fallback, Goal, LayoutChoice, Names, Settings};
use planish_geometry::denoise::Denoising;
use planish_geometry::map::manifest::{self, HeightsLoss, Layout, Target};
use planish_geometry::mesh::atlas::AtlasError;
use planish_geometry::progress::Progress;
use planish_geometry::source::materials;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use std::path::{Path, PathBuf};

/// What is baked, and where its files will lie: names in the manifest and the materials depend on that.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The mesh.
    pub input: &'a Path,
    /// What is in it.
    pub model: &'a Model,
    /// The folder for the results.
    pub folder: &'a Path,
    /// What else was read, and must not be written over.
    pub spared: &'a [PathBuf],
}

/// Files that are not written yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Their content.
    pub bundle: Bundle,
    /// What the user should know although all went well.
    pub warnings: Vec<String>,
    /// Files that were read, and must not be written over.
    inputs: Vec<PathBuf>,
}

/// The folder for the results where none is named: `NAME-planish` in the working folder.
pub fn default_folder(input: &Path) -> Result<PathBuf, Failure> {
    Ok(PathBuf::from(format!("{}-planish", stem(input)?)))
}

/// The folder `NAME-planish` beside the mesh: where maps go that are baked without a working folder, as those of a window.
pub fn folder_beside(input: &Path) -> Result<PathBuf, Failure> {
    Ok(input.with_file_name(default_folder(input)?))
}

/// What the files are called after.
fn stem(input: &Path) -> Result<String, Failure> {
    let stem = input.file_stem().map(|s| s.to_string_lossy().into_owned());
    stem.ok_or_else(|| Failure::at(input, "names no file"))
}

impl Job<'_> {
    /// The goal of denoising by a method, once that is ready to run.
    pub fn method(&self, denoising: Denoising) -> Result<Goal, Failure> {
        let denoiser = method::prepare(denoising.denoiser, self.input)?;
        Ok(Goal::Denoiser(Denoising { denoiser, ..denoising }))
    }

    /// The way to the result of any other denoiser.
    pub fn target(&self, path: &Path) -> Result<Goal, Failure> {
        let denoised = input::source(path)?;
        let (found, needed) = (denoised.data().positions().len(), self.model.data().positions().len());
        if found != needed {
            let reason = format!("has {found} `v` lines, but {} has {needed}", self.input.display());
            return Err(Failure::at(path, reason));
        }
        let target = Target::new(from_folder(path, self.folder), manifest::sha256(&denoised.bytes()));
        Ok(Goal::to(self.model, denoised.data(), target))
    }

    /// Bakes into memory. The folder need not be there yet.
    pub fn run(&self, settings: &Settings, progress: &dyn Progress) -> Result<Baked, Failure> {
        let Self { input, model, folder, spared } = *self;
        let names = names(input, folder, stem(input)?);
        let (found, missing): (Vec<_>, Vec<_>) =
            input::libraries(input, model.source()).into_iter().partition(|library| library.bytes.is_some());
        let missing = missing.iter().map(|l| l.path.display());
        let mut warnings: Vec<String> =
            missing.map(|path| format!("{path} cannot be read; the carrier will lack its materials")).collect();
        let (places, libraries): (Vec<_>, Vec<_>) =
            found.into_iter().filter_map(|library| Some((library.path, library.bytes?))).unzip();
        let textures = libraries.iter().flat_map(|bytes| materials::textures(bytes)).map(|name| beside(input, &name));
        let textures: Vec<PathBuf> = textures.collect();
        if settings.layout == LayoutChoice::Unwrap && !textures.is_empty() && !model.data().uvs().is_empty() {
            warnings.push(
                "the textures of its materials do not fit the carrier, whose texture coordinates are new".to_owned(),
            );
        }
        let mut inputs: Vec<PathBuf> = textures.into_iter().chain(places).collect();
        inputs.push(input.to_path_buf());
        inputs.extend_from_slice(spared);
        if let Goal::Target { target, .. } = &settings.goal {
            inputs.push(folder.join(&target.file));
        }
        let relocate = |texture: &str| {
            let place = beside(input, texture);
            // What is not there stays as it was written: the user may know why.
            if place.is_file() { from_folder(&place, folder) } else { texture.to_owned() }
        };
        let texture = |name: &str| std::fs::read(beside(input, name)).ok();
        let belongings = Belongings { libraries: &libraries, relocate: &relocate, texture: &texture };
        let bundle = bake::bake(model, &names, belongings, settings, progress).map_err(|e| explain(e, model, input))?;
        warnings.extend(warn(&bundle));
        Ok(Baked { bundle, warnings, inputs })
    }
}

impl Baked {
    /// Writes all files or none, and says where they are.
    pub fn write(&self, folder: Folder) -> Result<Vec<PathBuf>, Failure> {
        let files = &self.bundle.files;
        files.iter().try_for_each(|f| output::spare(&folder.path().join(&f.name), &self.inputs))?;
        folder.write(files.iter().map(|f| (Path::new(&f.name), f.bytes.as_slice())))
    }
}

/// The carrier is called like the source, unless that is where it would go.
fn names(input: &Path, folder: &Path, stem: String) -> Names {
    let taken = output::same_file(&folder.join(format!("{stem}.obj")), input);
    let carrier = if taken { format!("{stem}.planish") } else { stem.clone() };
    Names { source: from_folder(input, folder), stem, carrier }
}

/// A path as seen from a folder, with slashes.
fn from_folder(path: &Path, folder: &Path) -> String {
    let absolute = |p: &Path| p.canonicalize().or_else(|_| std::path::absolute(p)).unwrap_or_else(|_| p.to_path_buf());
    let relative = pathdiff::diff_paths(absolute(path), absolute(folder));
    relative.unwrap_or_else(|| path.to_path_buf()).to_string_lossy().replace('\\', "/")
}

/// A file that the source's materials name.
fn beside(input: &Path, texture: &str) -> PathBuf {
    input.parent().unwrap_or(Path::new("")).join(texture.replace('\\', "/"))
}

fn explain(error: BakeError, model: &Model, input: &Path) -> Failure {
    match error {
        BakeError::Cancelled(_) => Failure::Interrupted,
        BakeError::Atlas(AtlasError::NoUvs) => Failure::at(
            input,
            "has no texture coordinates (no face names a `vt`): use --layout vertex, which needs none, --layout unwrap, or unwrap it first (in Blender: Edit Mode, U, Smart UV Project)",
        ),
        BakeError::Atlas(AtlasError::NonFinite { uv }) => {
            let lines = model.source().as_obj().map_or(&[][..], Obj::non_finite_uvs);
            let line = lines.iter().find(|l| l.0 == uv).or(lines.first());
            let line = line.map(|l| format!("line {}: ", l.1)).unwrap_or_default();
            Failure::at(input, format!("{line}a texture coordinate that a face uses is not finite"))
        }
        BakeError::NoTangents => {
            Failure::at(input, "has no texture coordinates, and --space tangent needs some; use --space object")
        }
        BakeError::Limits(e) => Failure::limits(&e, input),
        BakeError::Normals(e) => Failure::at(input, format!("{e}; use --normals angle")),
        #[cfg(feature = "unwrap")]
        e @ BakeError::Unwrap(_) => Failure::at(input, e),
        BakeError::NoRoom { .. } => Failure::at(input, format!("{error}; use a larger --size or --max-size")),
        e @ (BakeError::NotFinite | BakeError::Gltf(_)) => Failure::at(input, e),
        other => Failure::Internal(format!("{}: {other}", input.display())),
    }
}

fn warn(bundle: &Bundle) -> Vec<String> {
    let m = &bundle.manifest;
    let r = &m.report;
    let mut out = r.layout.problems();
    if let Some(reason) = &bundle.fallback {
        out.push(format!("one texel for each vertex, because {reason}"));
    }
    if m.normal_map.is_none() && bundle.fallback != Some(Fallback::NoUvs) && m.displacement.layout == Layout::Vertex {
        out.push("no normal map: the texture coordinates of the mesh have no room for one".to_owned());
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
        let cure = r.suggestion.as_ref().map(|s| format!("; {s}")).unwrap_or_default();
        out.push(format!("{n} off by more than {tolerance} quanta at {side}{cure}"));
    }
    out
}
