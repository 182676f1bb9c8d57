//! Scenes, devices, and how pictures are compared.

use image::{Rgb, RgbImage, RgbaImage};
use planish_geometry::bundle::{self, Belongings, Bundle, Carriers, Names};
use planish_geometry::model::Model;
use planish_geometry::obj::Obj;
use planish_geometry::progress::Silent;
use planish_geometry::weld::Welding;
use planish_viewer::baked;
use planish_viewer::gpu::{Backend, Gpu};
use planish_viewer::input::{self, Extras, Frames};
use planish_viewer::painter::Painter;
use planish_viewer::scene::{FrameNormals, NormalMap, Scene};
use planish_viewer::settings::{Map, Relief, Settings, Shading, Size};
use planish_viewer::texture::Texture;
use std::path::{Path, PathBuf};

/// The repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A device, or a failure that says what to install.
#[track_caller]
pub(crate) fn gpu(backend: Backend) -> Gpu {
    Gpu::open(backend).unwrap_or_else(|e| panic!("these tests need a GPU or a driver that computes like one: {e}"))
}

/// A model and what was baked from it.
pub(crate) struct Baked {
    pub(crate) model: Model,
    pub(crate) bundle: Bundle,
}

impl Baked {
    pub(crate) fn new(obj: Obj, settings: &bundle::Settings) -> Result<Self, bundle::BakeError> {
        let model = Model::new(obj, Welding::Exact);
        let names = Names { source: "in.obj".into(), stem: "in".into(), carrier: "carrier".into() };
        let settings = bundle::Settings { carriers: Carriers::Obj, ..settings.clone() };
        let bundle = bundle::bake(&model, &names, Belongings::NONE, &settings, &Silent)?;
        Ok(Self { model, bundle })
    }

    pub(crate) fn file(&self, name: &str) -> &[u8] {
        &self.bundle.files.iter().find(|file| file.name == name).unwrap().bytes
    }

    /// With the map, and the baked normal map where there is one.
    pub(crate) fn scene(&self, frames: Frames) -> Scene {
        let manifest = &self.bundle.manifest;
        let mut scene = input::scene(&self.model, Extras { tangents: frames, ..Extras::default() }).unwrap();
        let displacement = self.file(&manifest.displacement.file);
        let mut carried = baked::carried(&self.model, manifest, displacement).unwrap();
        carried.errors = baked::errors(&self.model, manifest, &carried, &Silent).unwrap();
        scene.carry(carried).unwrap();
        if let Some(map) = &manifest.normal_map {
            let texels = texture(image::load_from_memory(self.file(&map.file)).unwrap().into_rgba8());
            scene.normal_map = Some(NormalMap { texels, frames: FrameNormals::Carrier });
        }
        scene
    }
}

pub(crate) fn texture(image: RgbaImage) -> Texture {
    Texture::new(image).unwrap()
}

pub(crate) fn obj(path: &Path) -> Obj {
    Obj::parse(std::fs::read(path).unwrap()).unwrap()
}

/// The noisy duck, denoised, with all its maps and pictures.
pub(crate) fn duck() -> Scene {
    let baked = Baked::new(obj(&root().join("data/duck_noisy.obj")), &bundle::Settings::default()).unwrap();
    let mut scene = baked.scene(Frames::MikkTSpace);
    scene.textures = vec![texture(bricks())];
    scene.relief = Some(texture(dots()));
    scene
}

/// Bricks that differ in colour, with light joints.
fn bricks() -> RgbaImage {
    RgbaImage::from_fn(128, 128, |x, y| {
        let (row, shift) = (y / 16, if y / 16 % 2 == 0 { 0 } else { 16 });
        let (column, in_brick) = ((x + shift) / 32 % 4, ((x + shift) % 32, y % 16));
        if in_brick.0 < 2 || in_brick.1 < 2 {
            return image::Rgba([214, 206, 190, 255]);
        }
        let tone = (37 * row + 91 * column) % 48;
        image::Rgba([(150 + tone) as u8, (70 + tone / 2) as u8, (52 + tone / 3) as u8, 255])
    })
}

/// Round studs.
fn dots() -> RgbaImage {
    RgbaImage::from_fn(128, 128, |x, y| {
        let [dx, dy] = [x, y].map(|i| (i % 16) as f32 - 7.5);
        let height = (1.0 - (dx * dx + dy * dy) / 40.0).max(0.0).sqrt();
        let grey = (255.0 * height) as u8;
        image::Rgba([grey, grey, grey, 255])
    })
}

/// A small picture; one sample a pixel, which both renderers have at the same place.
pub(crate) fn settings(shading: Shading) -> Settings {
    Settings {
        size: Size { width: 160, height: 120 },
        supersampling: 1,
        shading,
        relief: Relief { lambda: 0.04, ..Relief::default() },
        map: Map { lambda: 0.8, ..Map::default() },
        ..Settings::default()
    }
}

pub(crate) fn painter(backend: Backend, scene: &Scene) -> Painter {
    Painter::on(backend, gpu(backend), scene.clone()).unwrap()
}

/// Differences of the channels of two pictures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    /// Mean, in steps of a byte.
    pub(crate) mean: f64,
    /// 99.9th percentile.
    pub(crate) p999: u8,
    /// Largest.
    pub(crate) max: u8,
}

/// Compares two pictures where `counts` says so.
pub(crate) fn difference(a: &RgbaImage, b: &RgbaImage, counts: impl Fn(u32, u32) -> bool) -> Difference {
    assert_eq!(a.dimensions(), b.dimensions());
    let mut all: Vec<u8> = a
        .enumerate_pixels()
        .filter(|(x, y, _)| counts(*x, *y))
        .flat_map(|(x, y, p)| (0..3).map(move |k| (x, y, k, p[k])))
        .map(|(x, y, k, value)| value.abs_diff(b.get_pixel(x, y)[k]))
        .collect();
    all.sort_unstable();
    let mean = all.iter().map(|d| f64::from(*d)).sum::<f64>() / all.len() as f64;
    Difference { mean, p999: all[(all.len() - 1) * 999 / 1000], max: all[all.len() - 1] }
}

/// Leaves a picture, another one and eight times their difference behind, side by side.
pub(crate) fn leave_behind(name: &str, actual: &RgbaImage, expected: &RgbaImage) -> PathBuf {
    let folder = root().join("target/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}.png"));
    let (width, height) = actual.dimensions();
    let picture = RgbImage::from_fn(3 * width, height, |x, y| {
        let (a, b) = (actual.get_pixel(x % width, y), expected.get_pixel(x % width, y));
        match x / width {
            0 => Rgb([a[0], a[1], a[2]]),
            1 => Rgb([b[0], b[1], b[2]]),
            _ => Rgb([0, 1, 2].map(|k| a[k].abs_diff(b[k]).saturating_mul(8))),
        }
    });
    picture.save(&path).unwrap();
    path
}
