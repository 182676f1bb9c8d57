//! The GPU and the renderer on the processor draw the same pictures.

use crate::golden::{shadows, volumes};
use crate::support::{duck, leaf, no_complaints, renderer, small};
use glam::Vec3;
use image::RgbaImage;
use planish_render::gpu::Backend;
use planish_render::scene::{Occlusion, Scene, SceneError};
use planish_render::settings::lights::{Light, LightKind};
use planish_render::settings::{Normals, Overlay, Range, Sampling, Settings, Shading};
use planish_render::software;
use planish_render::texture::{Content, Texture, Textures};

/// Mean of the absolute differences, and the difference that a thousandth exceeds; bytes.
const MEAN: f64 = 1.0;
const RARELY: u8 = 4;

/// Differences of all channels away from silhouettes: where the picture with one sample shows background or an edge of
/// the surface within two pixels, coverage decides.
fn differences(scene: &Scene, settings: &Settings, a: &RgbaImage, b: &RgbaImage) -> Vec<u8> {
    let plain = Settings { shading: Shading::Normals, overlay: Overlay::None, volume: None, ..settings.clone() };
    let normals = software::render(scene, &plain);
    let inside = |x: u32, y: u32| {
        let here = normals.get_pixel(x, y).0;
        let near = (x.saturating_sub(2)..=(x + 2).min(a.width() - 1))
            .flat_map(|x| (y.saturating_sub(2)..=(y + 2).min(a.height() - 1)).map(move |y| (x, y)));
        near.map(|(x, y)| normals.get_pixel(x, y).0).all(|n| (0..3).all(|c| n[c].abs_diff(here[c]) < 60))
    };
    let pixels = a.enumerate_pixels().filter(|(x, y, _)| inside(*x, *y));
    pixels.flat_map(|(x, y, p)| (0..3).map(move |c| p.0[c].abs_diff(b.get_pixel(x, y).0[c]))).collect()
}

#[track_caller]
fn agree(scene: &Scene, settings: &Settings, gpu: &RgbaImage, what: &str) {
    let twin = software::render(scene, settings);
    let mut off = differences(scene, settings, gpu, &twin);
    assert!(off.len() > 10_000, "{what}: {} numbers are too few", off.len());
    off.sort_unstable();
    let mean = off.iter().map(|d| f64::from(*d)).sum::<f64>() / off.len() as f64;
    let rarely = off[off.len() * 999 / 1000];
    assert!(mean < MEAN && rarely < RARELY, "{what}: mean {mean:.3}, 99.9th percentile {rarely}");
}

/// Three samples along each side: the GPU then takes one sample at each place, as the twin does.
fn settings() -> Settings {
    Settings { supersampling: 3, ..small([160, 140]) }
}

#[test]
fn numbers_that_are_replaced_are_drawn_as_those_of_a_scene_that_has_them() {
    let renderer = renderer(Backend::Vulkan);
    let without = duck();
    let numbers: Vec<f32> = without.mesh().positions.iter().map(|p| if p.y < 0.0 { f32::NAN } else { p.x }).collect();
    let mut with = without.clone();
    with.set_scalars(numbers.clone()).unwrap();
    let mut settings = Settings { shading: Shading::Heat, ..settings() };
    settings.heat.range = Some(Range { low: -1.0, high: 1.0 });
    let gpu_scene = renderer.upload(&without).unwrap();
    let plain = renderer.image_of(&gpu_scene, &without, &settings);
    renderer.set_scalars(&gpu_scene, &without, &numbers).unwrap();
    let replaced = renderer.image_of(&gpu_scene, &without, &settings);
    assert_ne!(plain, replaced);
    assert_eq!(replaced, renderer.image(&with, &settings).unwrap());
    let error = renderer.set_scalars(&gpu_scene, &without, &numbers[1..]).unwrap_err();
    assert_eq!(error, SceneError::ScalarCount { found: numbers.len() - 1, expected: numbers.len() });
    no_complaints(&renderer);
}

#[test]
fn every_way_of_shading_with_every_kind_of_normals() {
    let renderer = renderer(Backend::Vulkan);
    let scene = duck();
    let gpu_scene = renderer.upload(&scene).unwrap();
    for &shading in Shading::ALL {
        for &normals in Normals::ALL {
            let mut settings = Settings { shading, ..settings() };
            (settings.displace.normals, settings.displace.lambda) = (normals, 0.7);
            let picture = renderer.image_of(&gpu_scene, &scene, &settings);
            agree(&scene, &settings, &picture, &format!("{shading:?} {normals:?}"));
        }
    }
    no_complaints(&renderer);
}

#[test]
fn overlays_lights_and_samplings() {
    let renderer = renderer(Backend::Vulkan);
    let scene = duck();
    let gpu_scene = renderer.upload(&scene).unwrap();
    let light = |kind| Light { kind, ..settings().lights[0] };
    let lit = |kind| Settings { lights: vec![light(kind)], ..settings() };
    let mut all = vec![
        ("wireframe".to_owned(), Settings { overlay: Overlay::Wireframe, size: small([480, 420]).size, ..settings() }),
        ("seams".to_owned(), Settings { overlay: Overlay::Seams, ..settings() }),
        ("point".to_owned(), lit(LightKind::Point { distance: 1.5 })),
        ("spot".to_owned(), lit(LightKind::Spot { distance: 2.5, angle: 30.0 })),
    ];
    // What anisotropic filters do is up to the driver.
    for sampling in [Sampling::Nearest, Sampling::Bilinear, Sampling::Bicubic, Sampling::Trilinear] {
        all.push((format!("{sampling:?}"), Settings { shading: Shading::Texture, sampling, ..settings() }));
    }
    for (what, settings) in all {
        agree(&scene, &settings, &renderer.image_of(&gpu_scene, &scene, &settings), &what);
    }
    no_complaints(&renderer);
}

#[test]
fn triangles_have_their_own_textures_or_none() {
    let renderer = renderer(Backend::Vulkan);
    let mut scene = duck();
    let blue = Texture::new(RgbaImage::from_pixel(2, 2, image::Rgba([40, 60, 200, 255])), Content::Colour).unwrap();
    let all = vec![blue, scene.textures.all()[0].clone()];
    let bands = (0..scene.mesh().triangles.len()).map(|t| [Some(1), None, Some(0)][t / 40 % 3]).collect();
    scene.textures = Textures::by_triangle(all, bands).unwrap();
    let settings = Settings { shading: Shading::Texture, ..settings() };
    let image = renderer.image(&scene, &settings).unwrap();
    agree(&scene, &settings, &image, "bands");
    let bluish = image.pixels().filter(|p| u16::from(p.0[2]) > 2 * u16::from(p.0[0])).count();
    assert!(bluish > image.pixels().len() / 50, "{bluish}");
    no_complaints(&renderer);
}

#[test]
fn triangles_have_their_own_normal_maps_or_none() {
    let renderer = renderer(Backend::Vulkan);
    let mut scene = duck();
    let tilted = Texture::new(RgbaImage::from_pixel(2, 2, image::Rgba([190, 90, 220, 255])), Content::Data).unwrap();
    let all = vec![tilted, scene.normal_maps.all()[0].clone()];
    let bands = (0..scene.mesh().triangles.len()).map(|t| [Some(1), None, Some(0)][t / 40 % 3]).collect();
    scene.normal_maps = Textures::by_triangle(all, bands).unwrap();
    let gpu_scene = renderer.upload(&scene).unwrap();
    let mut pictures = Vec::new();
    for &normals in Normals::ALL {
        let mut settings = Settings { shading: Shading::Phong, ..settings() };
        (settings.displace.normals, settings.displace.lambda) = (normals, 0.7);
        pictures.push(renderer.image_of(&gpu_scene, &scene, &settings));
        agree(&scene, &settings, &pictures[pictures.len() - 1], &format!("{normals:?}"));
    }
    let map = Normals::ALL.iter().position(|normals| *normals == Normals::Map).unwrap();
    let one = duck();
    let mut settings = Settings { shading: Shading::Phong, ..settings() };
    (settings.displace.normals, settings.displace.lambda) = (Normals::Map, 0.7);
    let whole = renderer.image(&one, &settings).unwrap();
    let off = whole.iter().zip(pictures[map].iter()).filter(|(a, b)| a.abs_diff(**b) > 20).count();
    assert!(off > whole.len() / 50, "{off} numbers show the maps");
    no_complaints(&renderer);
}

#[test]
fn both_sides_of_a_leaf() {
    let renderer = renderer(Backend::Vulkan);
    let scene = leaf();
    let gpu_scene = renderer.upload(&scene).unwrap();
    for yaw in [25.0, 205.0] {
        for shading in
            [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Texture, Shading::Normals, Shading::Bump]
        {
            for &normals in Normals::ALL {
                let mut settings = Settings { shading, ..settings() };
                (settings.displace.normals, settings.displace.lambda) = (normals, 0.7);
                (settings.camera.yaw, settings.camera.pitch) = (yaw, 15.0);
                let picture = renderer.image_of(&gpu_scene, &scene, &settings);
                agree(&scene, &settings, &picture, &format!("{yaw} {shading:?} {normals:?}"));
            }
        }
    }
    no_complaints(&renderer);
}

/// Picture that darkens ambient light along u, and in soft stripes along v: at hard ones the hundredth of a texel shows by which the
/// two renderers may differ.
fn dark_stripes() -> RgbaImage {
    RgbaImage::from_fn(64, 48, |x, y| {
        let wave = (y as f32 / 24.0 * std::f32::consts::TAU).sin();
        let grey = (2.0 * x as f32 + 64.0 * (1.0 + wave)) as u8;
        image::Rgba([grey, grey, grey, 255])
    })
}

#[test]
fn occlusion_darkens_ambient_light_alike() {
    let renderer = renderer(Backend::Vulkan);
    let plain = duck();
    let in_picture = Occlusion::Picture(Texture::new(dark_stripes(), Content::Data).unwrap());
    let of_height = |p: &Vec3| if p.y > 0.0 { 0.1 } else { 0.9 };
    let at_vertices = Occlusion::Vertices(plain.mesh().positions.iter().map(of_height).collect());
    for (kind, occlusion) in [("picture", in_picture), ("vertices", at_vertices)] {
        let mut scene = plain.clone();
        scene.occlusion = Some(occlusion);
        let gpu_scene = renderer.upload(&scene).unwrap();
        for shading in [Shading::Phong, Shading::Gouraud, Shading::Texture, Shading::Height, Shading::Flat] {
            let mut settings = Settings { shading, ..settings() };
            (settings.ambient.intensity, settings.ambient.occlusion) = (0.8, 0.9);
            let picture = renderer.image_of(&gpu_scene, &scene, &settings);
            agree(&scene, &settings, &picture, &format!("{kind} {shading:?}"));
            let light = |image: &RgbaImage| image.pixels().map(|p| u64::from(p.0[1])).sum::<u64>();
            let open = software::render(&plain, &settings);
            assert!(light(&picture) < light(&open), "{kind} {shading:?} is not darker");
            settings.ambient.occlusion = 0.0;
            let without = software::render(&scene, &settings);
            assert!(without == software::render(&plain, &settings), "{kind} {shading:?}: nothing shows at 0");
        }
    }
    no_complaints(&renderer);
}

#[test]
fn shadows_on_the_ground_and_on_the_surface() {
    let renderer = renderer(Backend::Vulkan);
    let scene = duck();
    let gpu_scene = renderer.upload(&scene).unwrap();
    for (what, settings) in shadows() {
        // A map itself is for graphics adapters; acne is what rounding makes of it.
        if settings.shadow.show_map.is_none() && settings.shadow.least_bias > 0.0 {
            let settings = Settings { supersampling: 3, ..settings };
            agree(&scene, &settings, &renderer.image_of(&gpu_scene, &scene, &settings), &what);
        }
    }
    no_complaints(&renderer);
}

#[test]
fn volumes_around_the_surface_and_alone() {
    let renderer = renderer(Backend::Vulkan);
    let scene = duck();
    let gpu_scene = renderer.upload(&scene).unwrap();
    for (what, settings) in volumes() {
        let settings = Settings { supersampling: 3, ..settings };
        let picture = renderer.image_of(&gpu_scene, &scene, &settings);
        agree(&scene, &settings, &picture, &what);
        let without = software::render(&scene, &Settings { volume: None, ..settings });
        let changed = picture.iter().zip(without.iter()).filter(|(a, b)| a.abs_diff(**b) > 20).count();
        assert!(changed > picture.len() / 20, "{what}: {changed} numbers show the volume");
    }
    no_complaints(&renderer);
}

#[test]
fn opengl_draws_what_vulkan_draws() {
    let (vulkan, gl) = (renderer(Backend::Vulkan), renderer(Backend::Gl));
    let scene = duck();
    let shadings = Shading::ALL.iter().map(|&shading| (format!("{shading:?}"), Settings { shading, ..settings() }));
    let volumes = volumes().into_iter().map(|(what, volume)| (what, Settings { supersampling: 3, ..volume }));
    for (what, settings) in shadings.chain(volumes) {
        let [a, b] = [&vulkan, &gl].map(|renderer| renderer.image(&scene, &settings).unwrap());
        let off = a.iter().zip(b.iter()).filter(|(a, b)| a.abs_diff(**b) > RARELY).count();
        // Silhouettes, where the drivers' rasterisers may take different samples, are longer than a thousandth of the picture.
        assert!(off * 500 < a.len(), "{what}: {off} numbers differ");
    }
    no_complaints(&vulkan);
    no_complaints(&gl);
}
