//! Pictures that were looked at, and have to stay as they are.
//!
//! Reference pictures lie in `tests/golden`. To draw them anew, and look at them:
//!
//! ```text
//! PLANISH_GOLDEN=write cargo test -p planish-render --test gpu golden
//! ```

use crate::alike::alike;
use crate::support::{duck, no_complaints, renderer, repository, small};
use image::{Rgba, RgbaImage};
use planish_render::environment::Environment;
use planish_render::gpu::Backend;
use planish_render::settings::camera::{Camera, Projection};
use planish_render::settings::environment::{Part, Scene, Surroundings};
use planish_render::settings::ground::{Ground, Show};
use planish_render::settings::lights::{Anchor, Light, LightKind};
use planish_render::settings::shadow::{Casters, Filter, LightProjection, Outside, Shadow};
use planish_render::settings::volume::{Transfer, TransferPreset, VolumeDisplay, VolumeView};
use planish_render::settings::{Normals, Overlay, Sampling, Settings, Shading};
use std::path::Path;

fn pictures() -> Vec<(String, Settings)> {
    let base = small([160, 120]);
    let name = |kind: &str, value: &dyn std::fmt::Debug| {
        let words: String = format!("{value:?}").chars().take_while(|c| c.is_alphanumeric()).collect();
        format!("{kind}-{}", words.to_lowercase())
    };
    let mut all = Vec::new();
    for &shading in Shading::ALL {
        all.push((name("shading", &shading), Settings { shading, ..base.clone() }));
    }
    for overlay in [Overlay::Wireframe, Overlay::Seams] {
        let mut settings = Settings { overlay, ..base.clone() };
        // Near enough to tell one triangle from the next.
        settings.camera.distance = 0.35;
        all.push((name("overlay", &overlay), settings));
    }
    for &sampling in Sampling::ALL {
        all.push((name("sampling", &sampling), Settings { sampling, shading: Shading::Texture, ..base.clone() }));
    }
    for &normals in Normals::ALL {
        let mut settings = base.clone();
        settings.displace.normals = normals;
        all.push((name("normals", &normals), settings));
    }
    for kind in
        [LightKind::Directional, LightKind::Spot { distance: 2.5, angle: 30.0 }, LightKind::Point { distance: 1.4 }]
    {
        let lights = vec![Light { kind, ..base.lights[0] }];
        all.push((name("light", &kind), Settings { lights, ..base.clone() }));
    }
    all
}

/// Each kind of light, each filter and what goes wrong without its cure.
pub(crate) fn shadows() -> Vec<(String, Settings)> {
    let mut base = small([160, 120]);
    base.camera = Camera { yaw: 25.0, pitch: 24.0, distance: 1.45, ..Camera::default() };
    base.ground = Ground { show: Show::Plane, ..Ground::default() };
    let key = Light { azimuth: -35.0, elevation: 35.0, anchor: Anchor::Model, ..base.lights[0] };
    let with = |kind, shadow| Settings { lights: vec![Light { kind, ..key }], shadow, ..base.clone() };
    let far = |shadow| with(LightKind::Directional, shadow);
    let soft = Shadow { filter: Filter::Pcss, size: 1024, light_angle: 9.0, ..Shadow::default() };
    let hard = Shadow { filter: Filter::Hard, size: 512, ..soft };
    let pcf = |kernel| far(Shadow { filter: Filter::Pcf, kernel, ..hard });
    let (spot, point) = (LightKind::Spot { distance: 3.0, angle: 42.0 }, LightKind::Point { distance: 1.7 });
    let no_bias = Shadow { slope_bias: 0.0, least_bias: 0.0, ..hard };
    let catcher = Ground { show: Show::Shadows, ..base.ground };
    [
        ("hard", far(hard)),
        ("pcf-3", pcf(3)),
        ("pcf-7", pcf(7)),
        ("pcss", far(soft)),
        ("spot", with(spot, soft)),
        ("point", with(point, soft)),
        ("acne", far(no_bias)),
        ("panning", far(Shadow { slope_bias: 0.25, least_bias: 0.25, ..hard })),
        ("back-faces", far(Shadow { casters: Casters::BackFaces, least_bias: 1e-3, slope_bias: 5e-3, ..hard })),
        ("border", far(Shadow { outside: Outside::Repeated, extent: 0.7, ..hard })),
        ("perspective", far(Shadow { projection: LightProjection::Perspective, ..hard })),
        ("map", far(Shadow { show_map: Some(0), ..hard })),
        ("catcher", Settings { ground: catcher, ..far(soft) }),
    ]
    .map(|(name, settings)| (format!("shadow-{name}"), settings))
    .to_vec()
}

/// Volumes with the mesh in them: presets, slices, a part of the box, parallel rays, a plane of shadows behind.
pub(crate) fn volumes() -> Vec<(String, Settings)> {
    let mut base = small([160, 120]);
    base.camera.distance = 1.3;
    let view = VolumeView { density: 1.5, ..VolumeView::default() };
    let with = |view| Settings { volume: Some(view), ..base.clone() };
    let preset = |preset| VolumeView { transfer: Transfer::Preset(preset), ..view.clone() };
    let mut parallel = with(preset(TransferPreset::Bands));
    parallel.camera.projection = Projection::Orthographic;
    let alone = VolumeView { mesh: Part::Hidden, low: [0.0, 0.0, 0.4], ..preset(TransferPreset::Bone) };
    let slices = VolumeView { display: VolumeDisplay::Slices, slices: [Some(0.5), None, Some(0.3)], ..view.clone() };
    let wall = VolumeView { slices: [None, Some(0.55), None], ..preset(TransferPreset::Fog) };
    let shadows = Shadow { filter: Filter::Pcf, size: 512, ..Shadow::default() };
    let ground = |show| Settings {
        ground: Ground { show, ..Ground::default() },
        shadow: shadows,
        ..with(VolumeView { density: 0.6, ..preset(TransferPreset::Fog) })
    };
    [
        ("bands", parallel),
        ("bone", with(alone)),
        ("fog", ground(Show::Plane)),
        ("fog-shadows", ground(Show::Shadows)),
        ("slices", with(slices)),
        ("wall", with(wall)),
    ]
    .map(|(name, settings)| (format!("volume-{name}"), settings))
    .to_vec()
}

fn landscapes() -> Vec<(String, Scene, Settings)> {
    let around = |name: &str, scene, surroundings: Surroundings| {
        let mut settings = small([160, 120]);
        settings.camera.projection = Projection::Perspective { field_of_view: 60.0 };
        settings.lights = vec![Light { anchor: Anchor::Sun, ..settings.lights[0] }];
        (format!("environment-{name}"), scene, Settings { environment: Some(surroundings), ..settings })
    };
    let mirror = Surroundings { reflectance: 0.9, roughness: 0.0, ..Surroundings::default() };
    let glossy = Surroundings { roughness: 0.5, blur: 0.4, rotation: 140.0, ..mirror.clone() };
    let lit = Surroundings { background: Part::Hidden, ..Surroundings::default() };
    vec![
        around("desert", Scene::Desert, mirror.clone()),
        around("desert-glossy", Scene::Desert, glossy),
        around("ice", Scene::Ice, mirror),
        around("ice-ambient", Scene::Ice, lit),
    ]
}

#[test]
fn pictures_are_as_they_were() {
    let renderer = renderer(Backend::Vulkan);
    let scene = duck();
    let gpu_scene = renderer.upload(&scene).unwrap();
    let failures: Vec<String> = pictures()
        .iter()
        .filter_map(|(name, settings)| compare(name, &renderer.image_of(&gpu_scene, &scene, settings)).err())
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    no_complaints(&renderer);
}

#[test]
fn shadows_volumes_and_landscapes_are_as_they_were() {
    let renderer = renderer(Backend::Vulkan);
    let mut scene = duck();
    let mut failures = Vec::new();
    for (name, settings) in shadows() {
        failures.extend(compare(&name, &renderer.image(&scene, &settings).unwrap()).err());
    }
    for (name, settings) in volumes() {
        failures.extend(compare(&name, &renderer.image(&scene, &settings).unwrap()).err());
    }
    for (name, landscape, settings) in landscapes() {
        scene.environment = Some(Environment::generated(landscape, 64));
        failures.extend(compare(&name, &renderer.image(&scene, &settings).unwrap()).err());
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    no_complaints(&renderer);
}

/// Compares with the reference; leaves the picture and the difference behind where they are not alike.
pub(crate) fn compare(name: &str, picture: &RgbaImage) -> Result<(), String> {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"));
    if std::env::var_os("PLANISH_GOLDEN").is_some_and(|v| v == "write") {
        picture.save(&place).unwrap();
        return Ok(());
    }
    let left = repository().join("target/golden");
    let leave = |image: &RgbaImage, suffix: &str| {
        std::fs::create_dir_all(&left).unwrap();
        image.save(left.join(format!("{name}.{suffix}.png"))).unwrap();
    };
    let Ok(reference) = image::open(&place).map(image::DynamicImage::into_rgba8) else {
        leave(picture, "actual");
        return Err(format!("{name}: there is no reference {}; the picture is in {}", place.display(), left.display()));
    };
    if reference.dimensions() != picture.dimensions() {
        leave(picture, "actual");
        return Err(format!("{name}: {:?} and not {:?} pixels", picture.dimensions(), reference.dimensions()));
    }
    alike(picture, &reference).map_err(|how| {
        leave(picture, "actual");
        leave(&difference(picture, &reference), "difference");
        format!("{name}: {how}; see {}", left.display())
    })
}

/// Eight times the differences.
fn difference(a: &RgbaImage, b: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(a.width(), a.height(), |x, y| {
        let (a, b) = (a.get_pixel(x, y).0, b.get_pixel(x, y).0);
        let [r, g, b] = [0, 1, 2].map(|c| a[c].abs_diff(b[c]).saturating_mul(8));
        Rgba([r, g, b, 255])
    })
}
