//! Files become a scene.

mod materials;

use crate::environment::{self, Surroundings};
use crate::input;
use crate::scene::Scene;
use crate::settings::{Settings, Shading};
use crate::texture::{Content, Texture, Textures};
use image::ImageReader;
use planish_geometry::apply::{self, ShaderVertex};
use planish_geometry::bundle::{self, Belongings, Bundle, Names};
use planish_geometry::displacement::{Displacement, Encoding, MapKind, TexelFormat};
use planish_geometry::manifest::{Manifest, NormalMapEntry};
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::progress::Progress;
use planish_geometry::texture::normal_map::Convention;
use planish_geometry::texture::{HeightMap, Size};
use planish_geometry::weld::Welding;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be read or makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}: {reason}", path.display())]
pub struct BadFile {
    /// Which one.
    pub path: PathBuf,
    /// What is wrong.
    pub reason: String,
}

impl BadFile {
    pub(crate) fn at<E: ToString>(path: &Path) -> impl Fn(E) -> Self + Copy + '_ {
        move |e| Self { path: path.to_owned(), reason: e.to_string() }
    }
}

/// What to show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files {
    /// The mesh; where there is none, the carrier of the map.
    pub mesh: Option<PathBuf>,
    /// The manifest of its map; without one it is baked with the defaults.
    pub map: Option<PathBuf>,
    /// A picture of heights to put on instead, from 0 at black to 1 at white.
    pub heights: Option<PathBuf>,
    /// Base colour, instead of those that the materials name.
    pub texture: Option<PathBuf>,
    /// Tangent-space normals (green up), instead of those of the map.
    pub normal_map: Option<PathBuf>,
    /// A number for each `v` line.
    pub scalars: Option<PathBuf>,
}

/// What was read.
#[derive(Debug)]
pub struct Opened {
    /// Where the mesh was.
    pub mesh: PathBuf,
    /// The mesh.
    pub model: Model,
    /// What is drawn.
    pub scene: Scene,
    /// What is known of the map; none without one.
    pub manifest: Option<Manifest>,
    /// What is missing, and the picture can do without.
    pub warnings: Vec<String>,
}

/// Reads all files, and bakes where `settings` need a map and none is given.
pub fn open(files: &Files, settings: &Settings, progress: &dyn Progress) -> Result<Opened, BadFile> {
    progress.stage("reading");
    let manifest = files.map.as_deref().map(read_manifest).transpose()?;
    let mesh = match (&files.mesh, &files.map, &manifest) {
        (Some(mesh), ..) => mesh.clone(),
        (None, Some(map), Some(manifest)) => map.with_file_name(&manifest.carrier.obj),
        _ => return Err(BadFile { path: PathBuf::new(), reason: "no mesh".to_owned() }),
    };
    let obj = Obj::parse(read(&mesh)?).map_err(BadFile::at(&mesh))?;
    let welding = manifest.as_ref().map_or(Welding::Exact, |m| m.welding);
    let model = Model::new(obj, welding);
    let scalars = files.scalars.as_deref().map(read_scalars).transpose()?;
    // Only the count of numbers can be wrong: the model's own indices are in range.
    let blamed = files.scalars.as_deref().unwrap_or(&mesh);
    let mut scene = input::scene(&model, scalars.as_deref()).map_err(BadFile::at(blamed))?;
    let mut warnings = Vec::new();
    scene.textures = match &files.texture {
        Some(path) => Textures::one(picture(path, Content::Colour)?),
        None => materials::textures(&mesh, &model, &mut warnings),
    };
    let manifest = match (&files.heights, &files.map, manifest) {
        (Some(path), ..) => {
            let map = heights(path)?;
            let relief = input::effect(&model, &scene, map);
            let none = "has no texture coordinates for a picture of heights";
            scene.relief = Some(relief.ok_or_else(|| BadFile::at(&mesh)(none))?);
            None
        }
        (None, Some(path), Some(manifest)) => {
            let image = path.with_file_name(&manifest.displacement.file);
            let carrier = || Obj::parse(read(&path.with_file_name(&manifest.carrier.obj)).ok()?).ok();
            let lines = apply::baked_vertices(model.source(), &manifest, &carrier).map_err(BadFile::at(&mesh))?;
            add_map(&mut scene, &model, &manifest, &lines, &read(&image)?, &image)?;
            if let Some(entry) = &manifest.normal_map {
                let path = path.with_file_name(&entry.file);
                scene.normal_map = Some(normal_map(&read(&path)?, entry, &path)?);
            }
            Some(manifest)
        }
        _ if needs_map(settings) => Some(bake(&mut scene, &model, &mesh, progress)?),
        _ => None,
    };
    if let Some(path) = &files.normal_map {
        scene.normal_map = Some(picture(path, Content::Data)?);
    }
    if let Some(Surroundings { source, resolution, .. }) = &settings.environment {
        progress.stage("environment");
        scene.environment = Some(environment::file::load(source, *resolution as usize)?);
    }
    Ok(Opened { mesh, model, scene, manifest, warnings })
}

/// At λ = 0 only some ways of shading look at the map.
fn needs_map(settings: &Settings) -> bool {
    settings.displace.lambda != 0.0 || matches!(settings.shading, Shading::Height | Shading::NormalMap | Shading::Bump)
}

fn bake(scene: &mut Scene, model: &Model, mesh: &Path, progress: &dyn Progress) -> Result<Manifest, BadFile> {
    let name = mesh.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let names = Names { source: format!("{name}.obj"), stem: name.clone(), carrier: format!("{name}.planish") };
    let bundle = bundle::bake(model, &names, Belongings::NONE, &bundle::Settings::default(), progress)
        .map_err(BadFile::at(mesh))?;
    dress(scene, model, mesh, &bundle)?;
    Ok(bundle.manifest)
}

/// Puts a map that was baked from the model, but perhaps not written, on its scene.
pub fn dress(scene: &mut Scene, model: &Model, mesh: &Path, bundle: &Bundle) -> Result<(), BadFile> {
    let bytes = |name: &str| bundle.files.iter().find(|f| f.name == name).map_or(&[][..], |f| &f.bytes);
    let map = Path::new(&bundle.manifest.displacement.file);
    let carrier = || Obj::parse(bytes(&bundle.manifest.carrier.obj).to_vec()).ok();
    let lines = apply::baked_vertices(model.source(), &bundle.manifest, &carrier).map_err(BadFile::at(mesh))?;
    add_map(scene, model, &bundle.manifest, &lines, bytes(&bundle.manifest.displacement.file), map)?;
    let entry = bundle.manifest.normal_map.as_ref();
    scene.normal_map = entry.map(|e| normal_map(bytes(&e.file), e, Path::new(&e.file))).transpose()?;
    Ok(())
}

fn add_map(
    scene: &mut Scene,
    model: &Model,
    manifest: &Manifest,
    lines: &[ShaderVertex],
    image: &[u8],
    path: &Path,
) -> Result<(), BadFile> {
    let entry = &manifest.displacement;
    let map = Displacement::decode(image, entry.map, entry.size(), entry.encoding()).map_err(BadFile::at(path))?;
    scene.relief = Some(input::relief(model, scene, map, lines));
    Ok(())
}

fn normal_map(bytes: &[u8], entry: &NormalMapEntry, path: &Path) -> Result<Texture, BadFile> {
    let mut image = decode(bytes, path)?.into_rgba8();
    if entry.convention == Convention::DirectX {
        image.pixels_mut().for_each(|p| p.0[1] = u8::MAX - p.0[1]);
    }
    Texture::new(image, Content::Data).ok_or_else(|| BadFile::at(path)("the image is empty"))
}

/// Black is 0 and white is 1, until the settings say otherwise.
fn heights(path: &Path) -> Result<Displacement, BadFile> {
    let image = decode(&read(path)?, path)?.into_luma16();
    let size = Size { width: image.width(), height: image.height() };
    let texels = image.iter().map(|&t| f32::from(t) / f32::from(u16::MAX)).collect();
    let encoding = Encoding { texel: TexelFormat::Png16, bias: 0.0, scale: 1.0 };
    Ok(Displacement::encode(&[HeightMap { size, texels }], MapKind::Scalar, encoding))
}

fn picture(path: &Path, content: Content) -> Result<Texture, BadFile> {
    let image = decode(&read(path)?, path)?.into_rgba8();
    Texture::new(image, content).ok_or_else(|| BadFile::at(path)("the image is empty"))
}

fn decode(bytes: &[u8], path: &Path) -> Result<image::DynamicImage, BadFile> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(BadFile::at(path))?;
    reader.decode().map_err(BadFile::at(path))
}

fn read_manifest(path: &Path) -> Result<Manifest, BadFile> {
    Manifest::from_json(&read(path)?).map_err(BadFile::at(path))
}

fn read_scalars(path: &Path) -> Result<Vec<f32>, BadFile> {
    let bytes = read(path)?;
    let number = |token: &str| token.parse().map_err(|_| BadFile::at(path)(format!("`{token}` is not a number")));
    String::from_utf8_lossy(&bytes).split_whitespace().map(number).collect()
}

/// All bytes of a file.
pub fn read(path: &Path) -> Result<Vec<u8>, BadFile> {
    std::fs::read(path).map_err(BadFile::at(path))
}
