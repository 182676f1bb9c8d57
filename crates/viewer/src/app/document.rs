//! What is open: a mesh, its map, and what is known of both. Values that never change once they are read or baked, so that
//! the window draws one while the next is made.

use super::recipe::Recipe;
use crate::open::{self, BadFile, Files, Opened};
use crate::scene::Scene;
use crate::settings::{Displace, Settings, Shading};
use egui::{Color32, ColorImage};
use planish_files::bake::{Baked, Job};
use planish_files::failure::Failure;
use planish_files::info::{self, Info};
use planish_files::{input, words};
use planish_geometry::apply;
use planish_geometry::displacement::Displacement;
use planish_geometry::manifest::{self, Manifest};
use planish_geometry::metrics::{self, Comparison, Triangles};
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::progress::Progress;
use planish_geometry::source::MeshData;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl From<BadFile> for Failure {
    fn from(bad: BadFile) -> Self {
        Self::at(&bad.path, bad.reason)
    }
}

/// A mesh that was read.
#[derive(Debug)]
pub struct Document {
    /// Where it lies.
    pub mesh: PathBuf,
    /// What is in it.
    pub model: Model,
    /// The same as `planish info` says.
    pub info: Info,
    /// What is drawn until there is another map.
    pub scene: Arc<Scene>,
}

/// A map that can be shown.
#[derive(Debug)]
pub struct Map {
    /// The mesh with the map on it.
    pub scene: Arc<Scene>,
    /// What is known of the map.
    pub manifest: Manifest,
    /// Its heights as greys, or its vectors as colours.
    pub picture: Arc<ColorImage>,
    /// Why its layout and size are what they are, in words.
    pub reasons: Vec<String>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Where it is from.
    pub origin: Origin,
}

/// Where a map is from.
#[derive(Debug)]
pub enum Origin {
    /// Read from a file.
    File(PathBuf),
    /// Baked here, for a folder.
    Baked {
        /// By this.
        recipe: Box<Recipe>,
        /// For this folder.
        folder: PathBuf,
        /// Files to write.
        baked: Box<Baked>,
    },
}

impl Map {
    /// The decoded map.
    pub fn displacement(&self) -> Option<&Displacement> {
        self.scene.relief.as_ref().map(|relief| &relief.map)
    }

    /// The mesh that carries it, as it is or would be written.
    fn carrier(&self) -> Option<Obj> {
        let name = &self.manifest.carrier.obj;
        let bytes = match &self.origin {
            Origin::File(manifest) => input::read(&manifest.with_file_name(name)).ok()?,
            Origin::Baked { baked, .. } => baked.bundle.files.iter().find(|f| f.name == *name)?.bytes.clone(),
        };
        Obj::parse(bytes).ok()
    }
}

/// What can be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A mesh.
    Mesh,
    /// The manifest of a map.
    Manifest,
    /// A picture: a map that has its manifest beside it, or heights to put on the mesh.
    Picture,
}

/// What a path names, by its ending.
pub fn kind(path: &Path) -> Option<Kind> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
        "obj" => Some(Kind::Mesh),
        "json" => Some(Kind::Manifest),
        "png" | "exr" | "tif" | "tiff" => Some(Kind::Picture),
        _ => None,
    }
}

/// Settings that need no map: the map is baked in a job of its own, or comes with its manifest.
fn without_map() -> Settings {
    Settings {
        shading: Shading::Phong,
        displace: Displace { lambda: 0.0, ..Displace::default() },
        ..Settings::default()
    }
}

/// Reads a mesh, or a manifest with its mesh and map.
pub fn load(path: &Path, progress: &dyn Progress) -> Result<(Document, Option<Map>), Failure> {
    progress.stage("reading");
    if path.is_dir() {
        return Err(Failure::at(path, "is a directory, not a file"));
    }
    match kind(path) {
        Some(Kind::Mesh) => {
            Ok((document(&Files { mesh: Some(path.to_owned()), ..Files::default() }, progress)?.0, None))
        }
        Some(Kind::Manifest) => with_map(path, progress),
        Some(Kind::Picture) => with_map(&manifest_of(path)?, progress),
        None => Err(Failure::at(path, "is neither a mesh (.obj) nor the manifest of a map (.planish.json)")),
    }
}

fn document(files: &Files, progress: &dyn Progress) -> Result<(Document, Option<Manifest>), Failure> {
    let Opened { mesh, model, scene, manifest, warnings } = open::open(files, &without_map(), progress)?;
    progress.check()?;
    if model.surface().topology().faces().is_empty() {
        return Err(Failure::at(&mesh, "no face has three different vertices"));
    }
    progress.stage("looking");
    let mut info = info::look(&mesh, &model, progress)?;
    info.notes.extend(warnings);
    Ok((Document { mesh, model, info, scene: Arc::new(scene) }, manifest))
}

/// The manifest beside a map that names it.
fn manifest_of(map: &Path) -> Result<PathBuf, Failure> {
    input::read(map)?;
    let name = map.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = name.split(".displacement.").next().unwrap_or(&name);
    let manifest = map.with_file_name(format!("{stem}.planish.json"));
    if manifest.is_file() {
        return Ok(manifest);
    }
    Err(Failure::at(map, format!("has no manifest {} beside it that says what it is", manifest.display())))
}

fn with_map(path: &Path, progress: &dyn Progress) -> Result<(Document, Option<Map>), Failure> {
    let manifest = Manifest::from_json(&input::read(path)?).map_err(|e| Failure::at(path, e))?;
    // The source can be baked again; where it is gone or has changed, its carrier can be shown.
    let source = path.with_file_name(&manifest.source.file);
    let unchanged = input::read(&source).is_ok_and(|bytes| manifest::sha256(&bytes) == manifest.source.sha256);
    let carries_uvs = manifest.displacement.uvs != manifest::UvSource::Mesh;
    let mesh = if unchanged && !carries_uvs { source } else { path.with_file_name(&manifest.carrier.obj) };
    let files = Files { mesh: Some(mesh), map: Some(path.to_owned()), ..Files::default() };
    let (document, manifest) = document(&files, progress)?;
    let manifest = manifest.ok_or_else(|| Failure::at(path, "has no map"))?;
    let dressed = Arc::clone(&document.scene);
    let map = map(dressed, manifest, Origin::File(path.to_owned()), Vec::new(), Vec::new());
    Ok((document, Some(map)))
}

fn map(scene: Arc<Scene>, manifest: Manifest, origin: Origin, reasons: Vec<String>, warnings: Vec<String>) -> Map {
    let nothing = || ColorImage::filled([1, 1], Color32::GRAY);
    let picture = scene.relief.as_ref().map_or_else(nothing, |relief| picture(&relief.map));
    Map { scene, manifest, picture: Arc::new(picture), reasons, warnings, origin }
}

/// Longest side of the picture of a map in the panel, pixels: what is copied to the device within a frame.
const LARGEST_PICTURE: u32 = 1024;

/// Texels as greys, or as colours, every n-th where there are more than can be shown.
fn picture(map: &Displacement) -> ColorImage {
    let size = map.size();
    let every = size.width.max(size.height).div_ceil(LARGEST_PICTURE).max(1);
    let [width, height] = [size.width, size.height].map(|side| side.div_ceil(every));
    let byte = |plane: &[f32], i: usize| (255.0 * plane[i]).round() as u8;
    let pixel = |(x, y): (u32, u32)| {
        let i = (y * every) as usize * size.width as usize + (x * every) as usize;
        match map.planes() {
            [heights] => Color32::from_gray(byte(heights, i)),
            planes => {
                let [r, g, b] = [0, 1, 2].map(|k| byte(&planes[k], i));
                Color32::from_rgb(r, g, b)
            }
        }
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(pixel).collect();
    ColorImage::new([width as usize, height as usize], pixels)
}

/// Bakes a map for a folder, without writing it.
pub fn bake(document: &Document, recipe: &Recipe, folder: &Path, progress: &dyn Progress) -> Result<Map, Failure> {
    let read: Vec<PathBuf> = recipe.limits.mask.iter().cloned().collect();
    let job = Job { input: &document.mesh, model: &document.model, folder, spared: &read };
    let baked = job.run(&recipe.settings(&job)?, progress)?;
    progress.stage("showing");
    let mut scene = (*document.scene).clone();
    open::dress(&mut scene, &document.model, &document.mesh, &baked.bundle)?;
    let bundle = &baked.bundle;
    let reasons = bundle.choice.iter().map(ToString::to_string).collect();
    let (manifest, warnings) = (bundle.manifest.clone(), baked.warnings.clone());
    let origin = Origin::Baked { recipe: Box::new(recipe.clone()), folder: folder.to_owned(), baked: Box::new(baked) };
    Ok(map(Arc::new(scene), manifest, origin, reasons, warnings))
}

/// A clean mesh to compare with.
#[derive(Debug)]
pub struct Clean {
    /// Where it lies.
    pub path: PathBuf,
    triangles: Triangles,
}

impl Clean {
    /// Reads it.
    pub fn read(path: &Path, progress: &dyn Progress) -> Result<Self, Failure> {
        progress.stage("reading");
        Ok(Self { path: path.to_owned(), triangles: Triangles::from(input::source(path)?.data()) })
    }
}

/// What a mesh and its displaced form measure against the clean mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The mesh as it is.
    pub noisy: Comparison,
    /// With the map at some λ; none without a map.
    pub displaced: Option<(f32, Comparison)>,
}

/// Measures what `planish compare` would measure of the mesh, and of what `planish apply` would write.
pub fn measure(
    clean: &Clean,
    document: &Document,
    map: Option<&Map>,
    lambda: f32,
    progress: &dyn Progress,
) -> Result<Measured, Failure> {
    progress.stage("comparing");
    let compare = |mesh: &MeshData| {
        metrics::compare(&clean.triangles, &Triangles::from(mesh)).map_err(|e| Failure::at(&clean.path, e))
    };
    let source = document.model.source();
    let noisy = compare(source.data())?;
    progress.check()?;
    let displaced = match map.and_then(|map| Some((map, map.displacement()?))) {
        Some((map, displacement)) => {
            let vertices = apply::baked_vertices(source, &map.manifest, &|| map.carrier())
                .map_err(|e| Failure::at(&document.mesh, e))?;
            let places = apply::displaced(&vertices, displacement, lambda, map.manifest.displacement.origin);
            progress.check()?;
            let written = source.with_positions(&places, None).map_err(|e| Failure::at(&document.mesh, e))?;
            let moved = Obj::parse(written).map_err(|e| Failure::at(&document.mesh, e))?;
            Some((lambda, compare(moved.data())?))
        }
        None => None,
    };
    Ok(Measured { noisy, displaced })
}

/// A line about the map: size, bits, formula.
pub fn map_line(manifest: &Manifest) -> String {
    let map = &manifest.displacement;
    let [bias, scale] = [map.bias, map.scale].map(words::measure);
    format!("{} × {}, {}: {bias} + {scale} · texel", map.width, map.height, map.texel)
}
