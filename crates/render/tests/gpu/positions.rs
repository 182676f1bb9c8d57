//! Displaced positions on the GPU are those of `apply`.

use crate::support::{Baked, baked, no_complaints, quick, renderer, repository};
use planish_geometry::bake::{BakeSettings, LayoutChoice};
use planish_geometry::map::displacement::MapKind;
use planish_render::gpu::Backend;
use planish_render::gpu::renderer::Renderer;
use planish_render::settings::Displace;
use std::path::{Path, PathBuf};

/// Of the range of the map: the same formula in single precision, where a driver may fuse products with sums. Two units in
/// the last place of the largest coordinate come on top: a fused sum rounds once where two operations round twice.
const TOLERANCE: f64 = 1e-6;

/// Asserts it for one map; how far off the worst vertex is, in shares of the range.
#[track_caller]
fn agree(renderer: &Renderer, baked: &Baked, name: &str) -> f64 {
    let Baked { model, map, .. } = baked;
    let scene = baked.scene();
    let gpu_scene = renderer.upload(&scene).unwrap();
    let lines = baked.lines();
    let range = f64::from(map.encoding().scale);
    let mut worst = 0.0f64;
    for lambda in [0.0, 0.37, 1.0, -2.0] {
        let found = renderer.positions(&gpu_scene, &scene, &Displace { lambda, ..Displace::default() });
        let strength = f64::from(lambda.abs()).max(1.0);
        // Every line, so every wedge: those of one vertex are drawn from the same numbers.
        for (line, expected) in lines.iter().enumerate() {
            let vertex = model.weld().vertex_of()[line] as usize;
            let expected = expected.displaced(map, lambda);
            let off = f64::from(found[vertex].distance(expected));
            let ulp = f64::from(expected.abs().max_element()) * f64::from(f32::EPSILON);
            assert!(
                off <= TOLERANCE * range * strength + 2.0 * ulp,
                "{name}, λ = {lambda}, line {line}: {off:e} of {range:e}"
            );
            worst = worst.max(off / range);
        }
    }
    no_complaints(renderer);
    worst
}

/// Both layouts, heights and vectors in both spaces.
fn kinds() -> [BakeSettings; 4] {
    let with = |layout, map| BakeSettings { layout, map, side: (layout == LayoutChoice::Uv).then_some(256), ..quick() };
    [
        with(LayoutChoice::Uv, MapKind::Scalar),
        with(LayoutChoice::Vertex, MapKind::Scalar),
        with(LayoutChoice::Vertex, MapKind::VectorObject),
        with(LayoutChoice::Uv, MapKind::VectorTangent),
    ]
}

#[test]
fn own_meshes_with_every_kind_of_map_on_every_backend() {
    for backend in [Backend::Vulkan, Backend::Gl] {
        let renderer = renderer(backend);
        for name in ["duck_noisy.obj", "flange_noisy.obj"] {
            for settings in kinds() {
                let what = format!("{backend:?} {name} {:?} {:?}", settings.layout, settings.map);
                agree(&renderer, &baked(&repository().join("data").join(name), &settings), &what);
            }
        }
    }
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn every_external_mesh() {
    let folder = PathBuf::from(std::env::var_os("PLANISH_MESHES").expect("PLANISH_MESHES names a folder of meshes"));
    let meshes: Vec<PathBuf> = [folder.clone(), folder.join("scans")].iter().flat_map(|f| objs(f)).collect();
    assert!(!meshes.is_empty(), "{} has no meshes", folder.display());
    let renderer = renderer(Backend::Vulkan);
    for mesh in meshes {
        let name = mesh.file_name().unwrap().to_string_lossy().into_owned();
        let settings =
            |layout| BakeSettings { layout, largest_side: planish_geometry::bake::LargestSide(512), ..quick() };
        agree(&renderer, &baked(&mesh, &settings(LayoutChoice::Auto)), &name);
    }
}

fn objs(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = folder.read_dir() else { return Vec::new() };
    let mut all: Vec<PathBuf> =
        entries.map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
    all.sort();
    all
}
