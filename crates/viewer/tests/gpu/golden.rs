//! Pictures of record: what a change of the renderer changes, somebody has to look at.
//!
//! `cargo test -p planish-viewer --test gpu -- --ignored draw_the_golden_images` draws them again; look at each one.

use crate::support::{difference, duck, leave_behind, painter, root, settings};
use image::RgbaImage;
use planish_viewer::colour::Colour;
use planish_viewer::gpu::Backend;
use planish_viewer::lights::{Light, LightKind};
use planish_viewer::settings::{
    Filter, Heat, HeatSource, Map, Material, Multisampling, Normals, Overlay, Pattern, Settings, Shading,
};
use std::path::PathBuf;

/// The metric is the mean absolute difference of the channels in steps of a byte, and the 99.9th percentile of it. Drivers
/// differ in the last bits of what they interpolate, which moves a few pixels at silhouettes from one side to the other.
const MEAN: f64 = 0.25;
const P999: u8 = 24;

fn reference(name: &str) -> PathBuf {
    root().join("crates/viewer/tests/golden").join(format!("{name}.png"))
}

/// Everything that has a picture of record.
fn pictures() -> Vec<(String, Settings)> {
    let smooth = |shading| Settings { supersampling: 2, ..settings(shading) };
    let mut all: Vec<(String, Settings)> =
        Shading::ALL.map(|shading| (format!("shading_{}", name(&shading)), smooth(shading))).into();
    for filter in Filter::ALL {
        let mut settings = settings(Shading::Texture);
        settings.sampling.filter = filter;
        settings.camera.distance = 0.6;
        all.push((format!("filter_{}", name(&filter)), settings));
    }
    for normals in [Normals::Base, Normals::Map, Normals::Derived] {
        let base = smooth(Shading::BlinnPhong);
        all.push((format!("normals_{}", name(&normals)), Settings { map: Map { normals, ..base.map }, ..base }));
    }
    for lambda in [0.0, 0.5, 1.0] {
        let base = smooth(Shading::Flat);
        all.push((format!("lambda_{lambda}"), Settings { map: Map { lambda, ..base.map }, ..base }));
    }
    let heat = |source| Heat { source, ..Heat::default() };
    all.push(("heat_error".into(), Settings { heat: heat(HeatSource::Error), ..smooth(Shading::Heat) }));
    let pattern = Pattern::Noise { frequency: 6.0, colour: Colour::hex(0x30506a) };
    let material = Material { pattern, ..Material::default() };
    all.push(("pattern_noise".into(), Settings { material, ..smooth(Shading::BlinnPhong) }));
    for (light, kind) in [
        ("spot", LightKind::Spot { distance: 3.0, angle: 24.0, softness: 0.3 }),
        ("point", LightKind::Point { distance: 1.6 }),
    ] {
        let key = Light { kind, ..Light::directional(-30.0, 35.0, Colour::WHITE, 1.0) };
        let fill = Light::directional(58.0, 12.0, Colour::hex(0xd6e2fa), 0.28);
        all.push((format!("light_{light}"), Settings { lights: vec![key, fill], ..smooth(Shading::BlinnPhong) }));
    }
    let wires = Overlay { wireframe: Some(Overlay::WIREFRAME), width: 0.75, ..Overlay::default() };
    let seams = Overlay { seams: Some(Overlay::SEAMS), width: 2.0, ..Overlay::default() };
    for (lines, overlay) in [("wireframe", wires), ("seams", seams)] {
        all.push((format!("overlay_{lines}"), Settings { overlay, ..smooth(Shading::Clay) }));
    }
    let four = Settings { multisampling: Multisampling::Four, ..settings(Shading::Clay) };
    all.push(("multisampling_four".into(), four));
    all
}

/// As in JSON.
fn name(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).unwrap().as_str().unwrap().to_owned()
}

#[test]
fn pictures_are_those_of_record() {
    let mut painter = painter(Backend::Vulkan, &duck());
    let mut failures = Vec::new();
    for (name, settings) in pictures() {
        let drawn = painter.picture(&settings).unwrap();
        let path = reference(&name);
        let Ok(expected) = image::open(&path).map(image::DynamicImage::into_rgba8) else {
            let left = leave_behind(&format!("golden_{name}"), &drawn, &RgbaImage::new(drawn.width(), drawn.height()));
            failures.push(format!("{name}: there is no {}, see {}", path.display(), left.display()));
            continue;
        };
        let apart = difference(&drawn, &expected, |_, _| true);
        if apart.mean > MEAN || apart.p999 > P999 {
            let left = leave_behind(&format!("golden_{name}"), &drawn, &expected);
            failures.push(format!("{name}: {apart:?}, see {}", left.display()));
        }
    }
    assert!(failures.is_empty(), "not the pictures of record:\n{}", failures.join("\n"));
}

#[test]
#[ignore = "replaces the pictures of record"]
fn draw_the_golden_images() {
    let mut painter = painter(Backend::Vulkan, &duck());
    std::fs::create_dir_all(reference("any").parent().unwrap()).unwrap();
    for (name, settings) in pictures() {
        painter.picture(&settings).unwrap().save(reference(&name)).unwrap();
    }
}
