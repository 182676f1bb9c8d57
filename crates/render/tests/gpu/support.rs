//! Adapters, scenes and pictures.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use image::RgbaImage;
use planish_geometry::bake::{self, BakeSettings, Bundle, BundleNames, SideFiles};
use planish_geometry::map::displace::{self, ShaderVertex};
use planish_geometry::map::displacement::Displacement;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use planish_render::gpu::renderer::Renderer;
use planish_render::gpu::{Backend, Gpu};
use planish_render::input;
use planish_render::scene::Scene;
use planish_render::settings::camera::Camera;
use planish_render::settings::{Settings, Size};
use planish_render::texture::{Content, Texture, Textures};
use planish_render::volume::Volume;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

/// The renderer of a backend, one at a time: a device is opened once for all tests. Who needs two takes that of Vulkan
/// first.
pub(crate) fn renderer(backend: Backend) -> MutexGuard<'static, Renderer> {
    static VULKAN: LazyLock<Mutex<Renderer>> = LazyLock::new(|| Mutex::new(own_renderer(Backend::Vulkan)));
    static GL: LazyLock<Mutex<Renderer>> = LazyLock::new(|| Mutex::new(own_renderer(Backend::Gl)));
    let renderer = if backend == Backend::Gl { &GL } else { &VULKAN };
    // A test that failed leaves nothing behind in it but what the driver said.
    renderer.lock().unwrap_or_else(|poisoned| {
        let renderer = PoisonError::into_inner(poisoned);
        renderer.gpu().validation_errors();
        renderer
    })
}

/// A renderer on a device of its own, or a failure that says what to install.
pub(crate) fn own_renderer(backend: Backend) -> Renderer {
    match Gpu::open(backend) {
        Ok(gpu) => Renderer::new(gpu),
        Err(e) => panic!(
            "{e}\nThese tests need a graphics adapter; on Debian: apt install mesa-vulkan-drivers libvulkan1 libegl1 libegl-mesa0 libgl1-mesa-dri libgbm1"
        ),
    }
}

/// Asserts that neither the driver nor its validation had anything to say.
#[track_caller]
pub(crate) fn no_complaints(renderer: &Renderer) {
    assert_eq!(renderer.gpu().validation_errors(), Vec::<String>::new());
}

pub(crate) fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub(crate) fn model(path: &Path) -> Model {
    Model::new(Obj::parse(std::fs::read(path).unwrap()).unwrap(), Welding::Exact)
}

/// A mesh with its map.
pub(crate) struct Baked {
    pub(crate) model: Model,
    pub(crate) bundle: Bundle,
    pub(crate) map: Displacement,
}

pub(crate) fn baked(path: &Path, settings: &BakeSettings) -> Baked {
    baked_model(model(path), settings)
}

fn baked_model(model: Model, settings: &BakeSettings) -> Baked {
    let names = BundleNames { source: "in.obj".into(), stem: "in".into(), carrier: "in".into() };
    let bundle = bake::bake(&model, &names, SideFiles::NONE, settings, &Silent).unwrap();
    let entry = &bundle.manifest.displacement;
    let map = Displacement::decode(bytes(&bundle, &entry.file), entry.map, entry.size(), entry.encoding()).unwrap();
    Baked { model, bundle, map }
}

pub(crate) fn bytes<'a>(bundle: &'a Bundle, name: &str) -> &'a [u8] {
    &bundle.files.iter().find(|file| file.name == name).unwrap().bytes
}

impl Baked {
    /// The vertices of the map, one for each line.
    pub(crate) fn lines(&self) -> Vec<ShaderVertex> {
        let carrier = || Obj::parse(bytes(&self.bundle, &self.bundle.manifest.carrier.obj).to_vec()).ok();
        displace::baked_vertices(self.model.source(), &self.bundle.manifest, &carrier).unwrap()
    }

    /// The scene, with a texture, the normal map, a volume and a number for each line.
    pub(crate) fn scene(&self) -> Scene {
        let lines = self.lines();
        let numbers: Vec<f32> = self.model.data().positions().iter().map(|p| p.y as f32).collect();
        let mut scene = input::scene(&self.model, Some(&numbers)).unwrap();
        scene.displacement = Some(input::bind_map(&self.model, &scene, self.map.clone(), &lines));
        scene.textures = Textures::one(Texture::new(stripes(), Content::Colour).unwrap());
        if let Some(entry) = &self.bundle.manifest.normal_map {
            let image = image::load_from_memory(bytes(&self.bundle, &entry.file)).unwrap().into_rgba8();
            scene.normal_maps = Textures::one(Texture::new(image, Content::Data).unwrap());
        }
        let bounds = scene.bounds();
        scene.set_volume(Some(Arc::new(waves(bounds.centre, bounds.radius))));
        scene
    }
}

/// The duck of `data/`, baked as quickly as it goes.
pub(crate) fn duck() -> Scene {
    static DUCK: LazyLock<Scene> = LazyLock::new(|| {
        let settings = BakeSettings { side: Some(512), ..quick() };
        baked(&repository().join("data/duck_noisy.obj"), &settings).scene()
    });
    DUCK.clone()
}

/// A rough, curved sheet with a back, whose faces name `v` and `vt` lines of their own; the sides have different colours.
pub(crate) fn leaf() -> Scene {
    let (mut text, n) = (String::new(), 25);
    for side in 0..2 {
        for i in 0..n * n {
            let [x, y] = [i % n, i / n].map(f64::from);
            let z = 0.02 * (x - 12.0).powi(2) + 0.05 * f64::from(i * i % 11);
            text += &format!("v {x} {y} {z}\n");
            text += &format!("vt {} {}\n", 0.01 + 0.019 * x + 0.5 * f64::from(side), 0.02 + 0.038 * y);
        }
    }
    for i in (0..n * (n - 1)).filter(|i| i % n < n - 1) {
        for corners in [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]] {
            let [a, b, c] = corners.map(|v| v + 1);
            text += &format!("f {a}/{a} {b}/{b} {c}/{c}\n");
            let [a, b, c] = corners.map(|v| v + 1 + n * n);
            text += &format!("f {c}/{c} {b}/{b} {a}/{a}\n");
        }
    }
    let model = Model::new(Obj::parse(text.into_bytes()).unwrap(), Welding::Exact);
    let baked = baked_model(model, &BakeSettings { side: Some(512), ..quick() });
    assert!(baked.bundle.manifest.normal_map.is_some() && baked.bundle.manifest.backs.highest() == 1250);
    baked.scene()
}

/// A density that is high in the middle of a sphere and along waves, in a box whose axes are askew and whose voxels are not cubes.
fn waves(centre: Vec3, radius: f32) -> Volume {
    const SIZE: [u32; 3] = [28, 24, 20];
    let axes = Mat3A::from_rotation_y(0.5) * Mat3A::from_rotation_x(0.3);
    let voxels = Vec3::from(SIZE.map(|n| 1.9 * radius / n as f32));
    let matrix3 = axes * Mat3A::from_diagonal(voxels);
    let half = Vec3A::from(SIZE.map(|n| 0.5 * n as f32));
    let place = Affine3A { matrix3, translation: Vec3A::from(centre) - matrix3 * half };
    let value = |i: u32| {
        let texel = Vec3::new((i % SIZE[0]) as f32, (i / SIZE[0] % SIZE[1]) as f32, (i / SIZE[0] / SIZE[1]) as f32);
        let p = (place.transform_point3(texel + 0.5) - centre) / radius;
        1.0 - p.length() + 0.25 * (7.0 * p.x).sin() * (6.0 * p.y + 2.0 * p.z).cos()
    };
    Volume::new(SIZE, (0..SIZE.iter().product()).map(value).collect(), place).unwrap()
}

/// The map does not matter here, and some methods take their time.
pub(crate) fn quick() -> BakeSettings {
    use planish_geometry::denoise::{Denoiser, Laplacian};
    BakeSettings { target: Denoiser::Laplacian(Laplacian::default()).into(), ..<_>::default() }
}

/// Colours that tell u from v, with fine and coarse detail.
fn stripes() -> RgbaImage {
    RgbaImage::from_fn(96, 80, |x, y| {
        let fine = if (x / 2 + y / 3) % 2 == 0 { 255 } else { 150 };
        image::Rgba([(x * 255 / 95) as u8, fine, (y * 255 / 79) as u8, 255])
    })
}

pub(crate) fn small(size: [u32; 2]) -> Settings {
    Settings {
        size: Size { width: size[0], height: size[1] },
        supersampling: 1,
        camera: Camera { yaw: 35.0, pitch: 12.0, ..Camera::default() },
        ..Settings::default()
    }
}
