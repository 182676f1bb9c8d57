//! The software renderer and the GPU draw the same picture.

use crate::support::{difference, duck, leave_behind, painter, settings};
use image::RgbaImage;
use planish_viewer::colour::Colour;
use planish_viewer::gpu::Backend;
use planish_viewer::lights::{Light, LightFrame, LightKind};
use planish_viewer::settings::{Filter, Heat, HeatSource, Map, Material, Normals, Overlay, Pattern, Settings, Shading};
use planish_viewer::software;

/// Steps of a byte: mean absolute difference, and 99.9th percentile away from silhouettes.
const MEAN: f64 = 1.0;
const P999: u8 = 3;

/// Whether all around a pixel is the surface, or all is background: both renderers round corners to a raster of their
/// own, so that at a silhouette they may disagree about who is seen.
fn is_away_from_silhouettes(depth: &RgbaImage, x: u32, y: u32) -> bool {
    let neighbours = (-1i64..=1).flat_map(|dy| (-1i64..=1).map(move |dx| (i64::from(x) + dx, i64::from(y) + dy)));
    let inside = neighbours.filter_map(|(x, y)| {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        (x < depth.width() && y < depth.height()).then(|| depth.get_pixel(x, y))
    });
    let pixels: Vec<_> = inside.collect();
    // Folds show as jumps of the normal, which is what the picture has as colours.
    let spread = |k: usize| {
        let channel = pixels.iter().map(|p| p[k]);
        channel.clone().max().unwrap() - channel.min().unwrap()
    };
    (0..3).all(|k| spread(k) < 96)
}

#[track_caller]
fn agree(backend: Backend, name: &str, pictures: &[(String, Settings)]) {
    let scene = duck();
    let mut painter = painter(backend, &scene);
    let mut failures = Vec::new();
    for (what, settings) in pictures {
        let drawn = painter.picture(settings).unwrap();
        let twin = software::render(&scene, settings);
        let outline = software::render(
            &scene,
            &Settings { shading: Shading::Normals, overlay: Overlay::default(), ..settings.clone() },
        );
        let apart = difference(&drawn, &twin, |x, y| is_away_from_silhouettes(&outline, x, y));
        if apart.mean >= MEAN || apart.p999 > P999 {
            let path = leave_behind(&format!("{name}_{what}"), &drawn, &twin);
            failures.push(format!("{what}: {apart:?}, see {}", path.display()));
        }
    }
    assert!(failures.is_empty(), "GPU and software renderer differ:\n{}", failures.join("\n"));
}

/// Each way to shade and each way to get normals.
fn ways_to_shade() -> Vec<(String, Settings)> {
    let mut all = Vec::new();
    for shading in Shading::ALL {
        for normals in [Normals::Base, Normals::Map, Normals::Derived] {
            let base = settings(shading);
            let map = Map { normals, ..base.map };
            all.push((format!("{shading:?}_{normals:?}"), Settings { map, ..base }));
        }
    }
    for source in [HeatSource::Height, HeatSource::Error] {
        let heat = Heat { source, ..Heat::default() };
        all.push((format!("heat_{source:?}"), Settings { heat, ..settings(Shading::Heat) }));
    }
    let pattern = Pattern::Noise { frequency: 6.0, colour: Colour::hex(0x30506a) };
    let material = Material { pattern, ..Material::default() };
    all.push(("noise".to_owned(), Settings { material, ..settings(Shading::BlinnPhong) }));
    all
}

/// Each kind of light.
fn kinds_of_light() -> Vec<(String, Settings)> {
    let kinds = [
        ("directional", LightKind::Directional),
        ("spot", LightKind::Spot { distance: 3.0, angle: 24.0, softness: 0.3 }),
        ("point", LightKind::Point { distance: 1.6 }),
    ];
    let with = |(name, kind): (&str, LightKind)| {
        let light = Light { kind, frame: LightFrame::Model, ..Light::directional(20.0, 40.0, Colour::WHITE, 1.0) };
        let fill = Light::directional(-60.0, 10.0, Colour::hex(0x8090c0), 0.3);
        (name.to_owned(), Settings { lights: vec![light, fill], ..settings(Shading::BlinnPhong) })
    };
    kinds.into_iter().map(with).collect()
}

#[test]
fn every_way_to_shade_on_vulkan() {
    agree(Backend::Vulkan, "vulkan", &ways_to_shade());
}

#[test]
fn every_way_to_shade_on_opengl() {
    agree(Backend::Gl, "gl", &ways_to_shade());
}

#[test]
fn every_kind_of_light() {
    agree(Backend::Vulkan, "light", &kinds_of_light());
}

#[test]
fn every_filter_without_and_with_a_mip_chain() {
    let with = |filter| {
        let mut settings = settings(Shading::Texture);
        settings.sampling.filter = filter;
        (format!("{filter:?}"), settings)
    };
    // How a sampler places its probes along the longer side is up to the GPU.
    let defined = Filter::ALL.into_iter().filter(|filter| *filter != Filter::Anisotropic);
    agree(Backend::Vulkan, "filter", &defined.map(with).collect::<Vec<_>>());
}

#[test]
fn lines_on_the_surface() {
    let base = settings(Shading::Clay);
    let wires = Overlay { wireframe: Some(Overlay::WIREFRAME), ..Overlay::default() };
    let seams = Overlay { seams: Some(Overlay::SEAMS), width: 2.0, ..Overlay::default() };
    let pictures = [("wires", wires), ("seams", seams)];
    let with = |(name, overlay): (&str, Overlay)| (name.to_owned(), Settings { overlay, ..base.clone() });
    agree(Backend::Vulkan, "lines", &pictures.map(with));
}
