//! Files become a scene: the mesh with its materials, and its displacement map, which is baked where none is given.

use crate::args::Args;
use crate::failure::Failure;
use crate::files::{self, at, read};
use planish_geometry::bundle::{self, Belongings, Bundle, Carriers, Names};
use planish_geometry::manifest::{Manifest, NormalMapEntry};
use planish_geometry::materials;
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::progress::Silent;
use planish_geometry::texture::normal_map::Convention;
use planish_geometry::weld::Welding;
use planish_viewer::baked;
use planish_viewer::input::{self, Extras, Frames, Textures};
use planish_viewer::scene::{FrameNormals, NormalMap, Scene};
use planish_viewer::settings::{HeatSource, Normals, Settings, Shading};
use planish_viewer::texture::Texture;
use std::path::{Path, PathBuf};

/// What a picture needs of a scene beside its mesh: nothing of it is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Needs {
    pub(crate) map: bool,
    pub(crate) errors: bool,
    pub(crate) frames: bool,
}

impl Needs {
    /// Of one picture.
    pub(crate) fn of(settings: &Settings) -> Self {
        let heat = Some(settings.heat.source).filter(|_| settings.shading == Shading::Heat);
        let of_heat = matches!(heat, Some(HeatSource::Height | HeatSource::Error));
        let of_normals = settings.map.normals == Normals::Map;
        Self {
            map: settings.map.lambda != 0.0 || of_heat || of_normals,
            errors: heat == Some(HeatSource::Error),
            frames: of_normals || matches!(settings.shading, Shading::Bump | Shading::Displacement),
        }
    }
}

/// The displacement map's files.
struct Baked {
    manifest: Manifest,
    displacement: Vec<u8>,
    normal_map: Option<Vec<u8>>,
    /// That errors about the map are told with.
    path: PathBuf,
}

/// The scene of the files that the command line names.
pub(crate) fn scene(args: &Args, needs: Needs) -> Result<Scene, Failure> {
    let obj = Obj::parse(read(&args.input)?).map_err(at(&args.input))?;
    let given = args.map.as_deref().filter(|_| needs.map).map(from_files).transpose()?;
    let welding = match &given {
        Some(baked) => baked::welding(&obj, &baked.manifest).map_err(at(&args.input))?,
        None => Welding::Exact,
    };
    let model = Model::new(obj, welding);
    let baked = match given {
        None if needs.map => Some(bake(&model, &args.input)?),
        given => given,
    };
    let scalars = args.scalars.as_deref().map(files::scalars).transpose()?;
    let (textures, of_materials) = textures(args, model.obj())?;
    let extras = Extras {
        scalars: scalars.as_deref(),
        textures: of_materials.as_deref().map_or(Textures::First, Textures::ByMaterial),
        tangents: if needs.frames { Frames::MikkTSpace } else { Frames::None },
    };
    // Only the count of numbers can be wrong: the model's own indices are in range.
    let blamed = args.scalars.as_deref().unwrap_or(&args.input);
    let mut scene = input::scene(&model, extras).map_err(at(blamed))?;
    scene.textures = textures;
    if let Some(baked) = &baked {
        let blamed = at(&baked.path);
        let mut carried = baked::carried(&model, &baked.manifest, &baked.displacement).map_err(&blamed)?;
        if needs.errors {
            let errors = baked::errors(&model, &baked.manifest, &carried, &Silent).map_err(|e| blamed(e.into()))?;
            carried.errors = errors;
        }
        scene.carry(carried).map_err(at(&baked.path))?;
    }
    scene.normal_map = normal_map(args, baked)?;
    scene.relief = args.height_map.as_deref().map(|path| files::texture(read(path)?, path)).transpose()?;
    Ok(scene)
}

/// A map that was baked before.
fn from_files(path: &Path) -> Result<Baked, Failure> {
    let manifest = Manifest::from_json(&read(path)?).map_err(at(path))?;
    let beside = |name: &str| path.parent().unwrap_or(Path::new("")).join(name);
    let displacement = read(&beside(&manifest.displacement.file))?;
    let normal_map = manifest.normal_map.as_ref().map(|map| read(&beside(&map.file))).transpose()?;
    Ok(Baked { manifest, displacement, normal_map, path: path.to_owned() })
}

/// A map made with the defaults of `planish bake`.
fn bake(model: &Model, path: &Path) -> Result<Baked, Failure> {
    let named = |text: &str| text.to_owned();
    let stem = path.file_stem().map_or_else(|| named("mesh"), |stem| stem.to_string_lossy().into_owned());
    let source = path.file_name().map_or_else(|| named("mesh.obj"), |name| name.to_string_lossy().into_owned());
    let names = Names { source, stem: stem.clone(), carrier: stem };
    let settings = bundle::Settings { carriers: Carriers::Obj, ..bundle::Settings::default() };
    let baked = bundle::bake(model, &names, Belongings::NONE, &settings, &Silent);
    let Bundle { mut files, manifest, .. } = baked.map_err(|e| Failure::Bake(e.to_string()))?;
    let mut take = |name: &str| {
        let file = files.iter_mut().find(|file| file.name == name);
        file.map(|file| std::mem::take(&mut file.bytes))
    };
    let displacement = take(&manifest.displacement.file).unwrap_or_default();
    let normal_map = manifest.normal_map.as_ref().and_then(|map| take(&map.file));
    Ok(Baked { manifest, displacement, normal_map, path: path.to_owned() })
}

/// The normal map that is named, or else the baked one.
fn normal_map(args: &Args, baked: Option<Baked>) -> Result<Option<NormalMap>, Failure> {
    if let Some(path) = &args.normal_map {
        let texels = files::texture(read(path)?, path)?;
        return Ok(Some(NormalMap { texels, frames: FrameNormals::Corner }));
    }
    let Some(Baked { manifest, normal_map: Some(bytes), path, .. }) = baked else { return Ok(None) };
    let Some(NormalMapEntry { convention, .. }) = manifest.normal_map else { return Ok(None) };
    let mut texels = files::texture(bytes, &path)?;
    if convention == Convention::DirectX {
        texels = texels.with_green_up();
    }
    Ok(Some(NormalMap { texels, frames: FrameNormals::Carrier }))
}

/// Textures, and which material has which. One that cannot be read is as good as none: the mesh can be seen without it.
type OfMaterials = (Vec<Texture>, Option<Vec<Option<usize>>>);

fn textures(args: &Args, obj: &Obj) -> Result<OfMaterials, Failure> {
    if let Some(path) = &args.texture {
        return Ok((vec![files::texture(read(path)?, path)?], None));
    }
    let folder = args.input.parent().unwrap_or(Path::new(""));
    let place = |name: &str| folder.join(name.replace('\\', "/"));
    let (mut textures, mut names, mut known) = (Vec::new(), Vec::new(), Vec::new());
    for library in &obj.extras().material_libraries {
        let Ok(bytes) = std::fs::read(place(&String::from_utf8_lossy(library))) else { continue };
        known.extend(materials::read(&bytes).unwrap_or_default());
    }
    let mut texture_of = |name: &[u8]| {
        let material = known.iter().find(|material| material.name.as_bytes() == name)?;
        let file = material.diffuse_texture.clone()?;
        if let Some(found) = names.iter().position(|known| *known == file) {
            return Some(found);
        }
        let path = place(&file);
        textures.push(files::texture(std::fs::read(&path).ok()?, &path).ok()?);
        names.push(file);
        Some(textures.len() - 1)
    };
    let mut of_materials: Vec<Option<usize>> = obj.extras().materials.iter().map(|name| texture_of(name)).collect();
    // Faces without a material.
    of_materials.push(None);
    Ok((textures, Some(of_materials)))
}
