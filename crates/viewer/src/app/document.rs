//! Documents: a mesh, its map, and what is known of both. They never change once they are read or baked, so that the window
//! draws one while the next is made.

use super::bake_config::BakeConfig;
use super::vertex_numbers::VertexNumbers;
use crate::open::{self, Files, Opened, OpenedMap};
use crate::report;
use image::{Rgba, RgbaImage};
use planish_files::bake_files::{Baked, Job};
use planish_files::failure::Failure;
use planish_files::info::{self, Info};
use planish_files::input::{self, Trust};
use planish_files::map_files::MapFiles;
use planish_files::text::{self, shown};
use planish_geometry::denoise::LastResult;
use planish_geometry::map::displace::ShaderVertex;
use planish_geometry::map::displacement::Displacement;
use planish_geometry::map::manifest::{self, Manifest};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::format::Format;
use planish_geometry::source::model::Model;
use planish_render::scene::Scene;
use planish_render::settings::{Displace, Settings, Shading};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Mesh that was read from a file.
#[derive(Debug)]
pub struct Document {
    /// Path of the mesh.
    pub mesh: PathBuf,
    /// Model that was read from the file.
    pub model: Model,
    /// Report on the mesh, as `planish info` prints it.
    pub info: Info,
    /// Scene that is drawn until there is a map.
    pub scene: Arc<Scene>,
    /// Rule on the files that the mesh names.
    pub trust: Trust,
    /// Rule by which vertices became one.
    pub welding: Welding,
    /// Memory of the last result of a method on the mesh, for bakes that change only limits or the map.
    last_result: LastResult,
}

/// Displacement map that can be shown.
#[derive(Debug)]
pub struct Map {
    /// Scene of the mesh with the map attached.
    pub scene: Arc<Scene>,
    /// Manifest of the map.
    pub manifest: Manifest,
    /// Vertices of the mesh as the map displaces them, one for each `v` line. #v
    pub vertices: Vec<ShaderVertex>,
    /// Noise that was found at each vertex; `None` if the map comes from a file, or from a method that measures none.
    pub noise: Option<VertexNumbers>,
    /// Picture of the map: heights as greys, or vectors as colours.
    pub picture: RgbaImage,
    /// Sentences about what was found in the mesh and what the map does.
    pub summary: String,
    /// Reasons for the layout and size of the map, in words.
    pub reasons: Vec<String>,
    /// Warnings about the bake.
    pub warnings: Vec<String>,
    /// Origin of the map.
    pub origin: Origin,
}

/// Origin of a map.
#[derive(Debug)]
pub enum Origin {
    /// The map was read from this file.
    File(PathBuf),
    /// The map was baked here, for a folder.
    Baked {
        /// Configuration of the bake.
        bake_config: Box<BakeConfig>,
        /// Folder that the files are for.
        folder: PathBuf,
        /// Files of the bake, as bytes.
        baked: Box<Baked>,
    },
}

impl Map {
    /// Returns the decoded map.
    pub fn displacement(&self) -> Option<&Displacement> {
        self.scene.displacement.as_ref().map(|binding| &binding.map)
    }
}

/// Kinds of files that can be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A mesh in any format that can be read.
    Mesh,
    /// The manifest of a map.
    Manifest,
    /// A picture: a map that has its manifest beside it, or heights to put on the mesh.
    Picture,
}

/// Returns the kind of file that a path names, by its extension.
pub fn kind(path: &Path) -> Option<Kind> {
    if input::format_of(path).is_some() {
        return Some(Kind::Mesh);
    }
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
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

/// Reads a mesh, or a manifest with its mesh and map, which are welded as the manifest says.
pub fn load(
    path: &Path,
    welding: Welding,
    trust: Trust,
    progress: &dyn Progress,
) -> Result<(Document, Option<Map>), Failure> {
    match kind(path) {
        Some(Kind::Mesh) => {
            let files = Files { mesh: Some(path.to_owned()), welding, trust, ..Files::default() };
            Ok((document(&files, progress)?.0, None))
        }
        Some(Kind::Manifest) => with_map(path, trust, progress),
        Some(Kind::Picture) => with_map(&manifest_of(path)?, trust, progress),
        None if path.is_dir() => Err(Failure::at(path, "is a directory, not a file")),
        None => {
            let meshes = Format::extensions();
            Err(Failure::at(path, format!("is neither a mesh ({meshes}) nor the manifest of a map (.planish.json)")))
        }
    }
}

fn document(files: &Files, progress: &dyn Progress) -> Result<(Document, Option<OpenedMap>), Failure> {
    let Opened { mesh, model, scene, map, warnings, .. } = open::open(files, &without_map(), progress)?;
    progress.check()?;
    progress.stage("looking");
    let mut info = info::inspect(&mesh, &model, files.trust, progress)?;
    info.notes.extend(warnings);
    let last_result = LastResult::remembered();
    let welding = map.as_ref().map_or(files.welding, |map| map.manifest.welding);
    Ok((Document { mesh, model, info, scene: Arc::new(scene), trust: files.trust, welding, last_result }, map))
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
    Err(Failure::at(map, format!("has no manifest {} beside it that says what it is", shown(&manifest))))
}

fn with_map(path: &Path, trust: Trust, progress: &dyn Progress) -> Result<(Document, Option<Map>), Failure> {
    progress.stage("reading");
    let map_files = MapFiles::read(path, trust)?;
    let manifest = &map_files.manifest;
    // The source can be baked again; where it is gone or has changed, its carrier can be shown.
    let carries_uvs = manifest.displacement.uvs != manifest::UvSource::Mesh;
    let mesh = (!carries_uvs && map_files.has_source()).then(|| map_files.source());
    let files = Files { mesh, map: Some(path.to_owned()), trust, ..Files::default() };
    let (document, map) = document(&files, progress)?;
    let OpenedMap { manifest, vertices } = map.ok_or_else(|| Failure::at(path, "has no map"))?;
    let scene = Arc::clone(&document.scene);
    let picture = picture(&scene);
    let origin = Origin::File(path.to_owned());
    let summary = report::summary_of(&scene, &manifest);
    let (reasons, warnings) = (Vec::new(), Vec::new());
    let map = Map { scene, manifest, vertices, noise: None, picture, summary, reasons, warnings, origin };
    Ok((document, Some(map)))
}

/// Longest side of the picture of a map in the panel, pixels: what is copied to the device within a frame.
const LARGEST_PICTURE: u32 = 1024;

/// The map of a scene with its texels as greys, or as colours; every n-th texel where there are more than can be shown.
fn picture(scene: &Scene) -> RgbaImage {
    let Some(map) = scene.displacement.as_ref().map(|binding| &binding.map) else {
        return RgbaImage::from_pixel(1, 1, Rgba([128, 128, 128, u8::MAX]));
    };
    let size = map.size();
    let every = size.width.max(size.height).div_ceil(LARGEST_PICTURE).max(1);
    let [width, height] = [size.width, size.height].map(|side| side.div_ceil(every));
    let byte = |plane: &[f32], i: usize| (255.0 * plane[i]).round() as u8;
    RgbaImage::from_fn(width, height, |x, y| {
        let i = (y * every) as usize * size.width as usize + (x * every) as usize;
        let [r, g, b] = match map.planes() {
            [heights] => [byte(heights, i); 3],
            planes => [0, 1, 2].map(|k| byte(&planes[k], i)),
        };
        Rgba([r, g, b, u8::MAX])
    })
}

/// Bakes a map for a folder, without writing it.
pub fn bake(
    document: &Document,
    bake_config: &BakeConfig,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Map, Failure> {
    let read: Vec<PathBuf> = bake_config.limits.fixed_file.iter().cloned().collect();
    let job = Job { input: &document.mesh, model: &document.model, folder, protected: &read, trust: document.trust };
    let mut scene = (*document.scene).clone();
    let mut settings = bake_config.settings(&job)?;
    settings.last_result = document.last_result.clone();
    let (map, baked) = open::bake_map(&mut scene, &job, &settings, progress)?;
    let OpenedMap { manifest, vertices } = map;
    let reasons = baked.bundle.choice.iter().map(ToString::to_string).collect();
    let (warnings, picture) = (baked.warnings.clone(), picture(&scene));
    let noise = VertexNumbers::of_noise(&baked.bundle.deviations, document.model.surface().mean_edge());
    let origin =
        Origin::Baked { bake_config: Box::new(bake_config.clone()), folder: folder.to_owned(), baked: Box::new(baked) };
    let summary = report::summary_of(&scene, &manifest);
    Ok(Map { scene: Arc::new(scene), manifest, vertices, noise, picture, summary, reasons, warnings, origin })
}

/// A line about the map: size, bits, formula.
pub fn map_line(manifest: &Manifest) -> String {
    let map = &manifest.displacement;
    let [bias, scale] = [map.bias, map.scale].map(text::measure);
    format!("{} × {}, {}: {bias} + {scale} · texel", map.width, map.height, map.texel)
}
