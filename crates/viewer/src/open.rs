//! Files become a scene.

mod materials;

use crate::environment;
use crate::image_file;
use crate::volume;
use image::DynamicImage;
use planish_files::bake_files::{self, Baked, Job};
use planish_files::failure::Failure;
use planish_files::input::{self, LARGEST_PICTURE, Trust};
use planish_files::map_files::MapFiles;
use planish_geometry::bake::{BakeSettings, Bundle};
use planish_geometry::map::displace::{self, ShaderVertex};
use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, TexelFormat};
use planish_geometry::map::manifest::{Manifest, NormalMapEntry, OcclusionEntry};
use planish_geometry::map::normal_map::Convention;
use planish_geometry::map::pages::{Pages, Part};
use planish_geometry::map::{HeightMap, Size};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::model::Model;
use planish_render::input as model_input;
use planish_render::mesh::Mesh;
use planish_render::scene::{Occlusion, Scene};
use planish_render::settings::environment::Surroundings;
use planish_render::settings::volume::VolumeView;
use planish_render::settings::{Settings, Shading};
use planish_render::texture::{Content, Texture, Textures};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files that make up a scene.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Rule by which vertices become one; a manifest says its own.
    pub welding: Welding,
    /// Rule on the files that these name.
    pub trust: Trust,
}

/// Model and scene that were read, and what was baked for them.
#[derive(Debug)]
pub struct Opened {
    /// Path of the mesh.
    pub mesh: PathBuf,
    /// Model of the mesh.
    pub model: Model,
    /// Scene that is drawn.
    pub scene: Scene,
    /// The map that the scene has on it; none without one.
    pub map: Option<OpenedMap>,
    /// Files of the map that are not written; none where none was baked.
    pub baked: Option<Baked>,
    /// Warnings about files that are missing and not essential.
    pub warnings: Vec<String>,
}

/// A map on a scene.
#[derive(Debug)]
pub struct OpenedMap {
    /// Manifest of the map.
    pub manifest: Manifest,
    /// Vertices of the mesh as the map displaces them, one for each `v` line. #v
    pub vertices: Vec<ShaderVertex>,
}

/// Reads all files, and bakes where `settings` need a map and none is given: into the very files that `planish bake` would
/// write to a folder beside the mesh.
pub fn open(files: &Files, settings: &Settings, progress: &dyn Progress) -> Result<Opened, Failure> {
    progress.stage("reading");
    let map_files = files.map.as_deref().map(|path| MapFiles::read(path, files.trust)).transpose()?;
    let mesh = files.mesh.clone().or_else(|| map_files.as_ref().map(MapFiles::carrier));
    let mesh = mesh.ok_or_else(|| Failure::Input("no mesh is named".to_owned()))?;
    let welding = map_files.as_ref().map_or(files.welding, |map| map.manifest.welding);
    let model = match &map_files {
        // A mesh that the manifest names is read by the rule.
        Some(map) if files.mesh.is_none() => input::weld(map.carrier_mesh()?, &mesh, welding, progress)?,
        _ => input::model(&mesh, welding, files.trust, progress)?,
    };
    let scalars = files.scalars.as_deref().map(input::numbers).transpose()?;
    // Only the count of numbers can be wrong: the model's own indices are in range.
    let blamed = files.scalars.as_deref().unwrap_or(&mesh);
    let mut scene = model_input::scene(&model, scalars.as_deref()).map_err(|e| Failure::at(blamed, e))?;
    let mut warnings = Vec::new();
    scene.textures = match &files.texture {
        Some(path) => Textures::one(picture(path, Content::Colour)?),
        None => materials::textures(&mesh, &model, files.trust, &mut warnings),
    };
    let mut baked = None;
    let map = match (&files.heights, map_files) {
        (Some(path), _) => {
            let binding = model_input::bind_heights(&model, &scene, heights(path)?);
            let none = || Failure::at(&mesh, "has no texture coordinates for a picture of heights");
            scene.displacement = Some(binding.ok_or_else(none)?);
            None
        }
        (None, Some(map)) => Some(read_map(&mut scene, &model, &mesh, map)?),
        (None, None) if needs_map(settings) => {
            let folder = bake_files::folder_beside(&mesh)?;
            let job = Job { input: &mesh, model: &model, folder: &folder, protected: &[], trust: files.trust };
            let (map, files) = bake_map(&mut scene, &job, &BakeSettings::default(), progress)?;
            baked = Some(files);
            Some(map)
        }
        (None, None) => None,
    };
    if let Some(path) = &files.normal_map {
        scene.normal_maps = Textures::one(picture(path, Content::Data)?);
    }
    if let Some(Surroundings { source, resolution, .. }) = &settings.environment {
        progress.stage("environment");
        scene.environment = Some(environment::load(source, *resolution as usize)?);
    }
    if let Some(VolumeView { source, placement, .. }) = &settings.volume {
        let volume = volume::load(source, *placement, Some(&model), files.trust, progress)?;
        scene.set_volume(Some(Arc::new(volume)));
    }
    Ok(Opened { mesh, model, scene, map, baked, warnings })
}

/// Reads a volume that is drawn without a mesh.
pub fn open_volume(settings: &Settings, trust: Trust, progress: &dyn Progress) -> Result<Scene, Failure> {
    let mut scene = Scene::new(Mesh::default()).map_err(Failure::internal)?;
    if let Some(VolumeView { source, placement, .. }) = &settings.volume {
        scene.set_volume(Some(Arc::new(volume::load(source, *placement, None, trust, progress)?)));
    }
    if let Some(Surroundings { source, resolution, .. }) = &settings.environment {
        progress.stage("environment");
        scene.environment = Some(environment::load(source, *resolution as usize)?);
    }
    Ok(scene)
}

/// Returns whether the settings need a map: at λ = 0 only some shadings look at it.
fn needs_map(settings: &Settings) -> bool {
    settings.displace.lambda != 0.0 || matches!(settings.shading, Shading::Height | Shading::NormalMap | Shading::Bump)
}

/// Reads the files of a map, and attaches it to the scene.
fn read_map(scene: &mut Scene, model: &Model, mesh: &Path, files: MapFiles) -> Result<OpenedMap, Failure> {
    let (map, vertices) = files.map_for(model.source(), mesh)?;
    scene.displacement = Some(model_input::bind_map(model, scene, map, &vertices));
    scene.normal_maps = normal_maps(model, &files.manifest, &|entry| {
        normal_map(&files.bytes_of(&entry.file, LARGEST_PICTURE)?, entry, &files.path_of(&entry.file))
    })?;
    if let Some(entry) = &files.manifest.occlusion {
        let path = files.path_of(&entry.map.file);
        let bytes = files.bytes_of(&entry.map.file, LARGEST_PICTURE)?;
        scene.occlusion = Some(occlusion(&bytes, model, entry, &path)?);
    }
    Ok(OpenedMap { manifest: files.manifest, vertices })
}

/// Bakes a map without writing its files, and attaches it to the scene, which is that of the job's model.
pub fn bake_map(
    scene: &mut Scene,
    job: &Job,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<(OpenedMap, Baked), Failure> {
    let baked = job.run(settings, progress)?;
    progress.stage("showing");
    let vertices = attach(scene, job.model, &baked.bundle)?;
    Ok((OpenedMap { manifest: baked.bundle.manifest.clone(), vertices }, baked))
}

/// Attaches a map that was baked from the model to its scene; returns the vertices that it displaces.
fn attach(scene: &mut Scene, model: &Model, bundle: &Bundle) -> Result<Vec<ShaderVertex>, Failure> {
    let Bundle { manifest, along, .. } = bundle;
    let bytes = |name: &str| bundle.files.iter().find(|f| f.name == name).map_or(&[][..], |f| &f.bytes);
    let entry = &manifest.displacement;
    let decode = |file: &str, size| {
        let map = Displacement::decode(bytes(file), entry.map, size, entry.encoding());
        map.map_err(|e| Failure::at(Path::new(file), e))
    };
    let mut vertices = displace::model_vertices(model, along, manifest);
    let map = if manifest.pages.is_some() {
        let pages = manifest.page_entries().iter().map(|page| decode(&page.file, page.size()));
        let pages = pages.collect::<Result<Vec<_>, _>>()?;
        displace::gather(&pages, model.data(), manifest, &mut vertices)
    } else {
        decode(&entry.file, entry.size())?
    };
    scene.displacement = Some(model_input::bind_map(model, scene, map, &vertices));
    scene.normal_maps = normal_maps(model, manifest, &|e| normal_map(bytes(&e.file), e, Path::new(&e.file)))?;
    let occluded = |e: &OcclusionEntry| occlusion(bytes(&e.map.file), model, e, Path::new(&e.map.file));
    scene.occlusion = manifest.occlusion.as_ref().map(occluded).transpose()?;
    Ok(vertices)
}

/// Normal maps of the triangles of a model's scene: that of the map, or those of its pages.
fn normal_maps(
    model: &Model,
    manifest: &Manifest,
    read: &dyn Fn(&NormalMapEntry) -> Result<Texture, Failure>,
) -> Result<Textures, Failure> {
    if let Some(entry) = &manifest.normal_map {
        return Ok(Textures::one(read(entry)?));
    }
    let Some(pages) = &manifest.pages else { return Ok(Textures::default()) };
    let mut all = Vec::new();
    let mut of_entries = Vec::with_capacity(pages.maps.len());
    for entry in pages.maps.iter().map(|page| page.normal_map.as_ref()) {
        of_entries.push(entry.map(|_| all.len() as u32));
        all.extend(entry.map(read).transpose()?);
    }
    // Whoever wrote the manifest may have divided another mesh; parts of one that was cut have no normal maps.
    let Some(Ok(Some(division))) = pages.by.rule().map(|rule| Pages::of(model.data(), rule)) else {
        return Ok(Textures::default());
    };
    let of_part = |part: &Part| of_entries[pages.maps.iter().position(|page| page.part == *part)?];
    let of_pages: Vec<Option<u32>> = division.parts().iter().map(of_part).collect();
    let faces = model_input::faces_of_triangles(model);
    let of_triangles = faces.iter().map(|face| of_pages[division.of_face(*face) as usize]).collect();
    Ok(Textures::by_triangle(all, of_triangles).unwrap_or_default())
}

/// A normal map as shaders take it, with green up.
fn normal_map(bytes: &[u8], entry: &NormalMapEntry, path: &Path) -> Result<Texture, Failure> {
    let mut image = image_file::decode(bytes, path)?.into_rgba8();
    if entry.convention == Convention::DirectX {
        image.pixels_mut().for_each(|p| p.0[1] = u8::MAX - p.0[1]);
    }
    texture(DynamicImage::ImageRgba8(image), Content::Data, path)
}

/// Ambient occlusion as the renderer takes it.
fn occlusion(bytes: &[u8], model: &Model, entry: &OcclusionEntry, path: &Path) -> Result<Occlusion, Failure> {
    let image = image_file::decode(bytes, path)?.into_rgba8();
    let size = entry.map.size();
    if image.dimensions() != (size.width, size.height) {
        let found = format!("{} × {}", image.width(), image.height());
        let reason = format!("is {found} texels, but the manifest says {} × {}", size.width, size.height);
        return Err(Failure::at(path, reason));
    }
    let few = || Failure::at(path, "has no texel for each vertex");
    model_input::occlusion(model, image, entry.map.layout).ok_or_else(few)
}

/// Black is 0 and white is 1, until the settings say otherwise.
fn heights(path: &Path) -> Result<Displacement, Failure> {
    let image = image_file::read(path)?.into_luma16();
    let size = Size { width: image.width(), height: image.height() };
    let texels = image.iter().map(|&t| f32::from(t) / f32::from(u16::MAX)).collect();
    let encoding = Encoding { texel: TexelFormat::Png16, bias: 0.0, scale: 1.0 };
    Ok(Displacement::encode(&[HeightMap { size, texels }], MapKind::Scalar, encoding))
}

fn picture(path: &Path, content: Content) -> Result<Texture, Failure> {
    texture(image_file::read(path)?, content, path)
}

fn texture(image: DynamicImage, content: Content, path: &Path) -> Result<Texture, Failure> {
    Texture::new(image.into_rgba8(), content).ok_or_else(|| Failure::at(path, "the image is empty"))
}

#[cfg(test)]
mod tests;
