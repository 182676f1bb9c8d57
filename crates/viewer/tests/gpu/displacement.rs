//! Positions that the GPU computes are those of `planish_geometry::apply`.

use crate::support::{Baked, gpu, obj, root};
use glam::Vec3;
use planish_geometry::bundle::{self, LayoutChoice};
use planish_geometry::displacement::{MapKind, TexelFormat};
use planish_geometry::obj::Obj;
use planish_viewer::gpu::{Backend, Gpu};
use planish_viewer::input::Frames;
use planish_viewer::renderer::Renderer;
use std::path::PathBuf;

/// Of the range of displacements: the same formula in single precision, where a driver may fuse products with sums.
const EXACT: f32 = 1e-6;
const BACKENDS: [Backend; 2] = [Backend::Vulkan, Backend::Gl];

/// Each kind of map in each layout that a mesh has.
fn bakes() -> Vec<bundle::Settings> {
    let kinds = [MapKind::Scalar, MapKind::VectorObject, MapKind::VectorTangent];
    let layouts = [LayoutChoice::Uv, LayoutChoice::Vertex];
    let of = |(map, layout)| bundle::Settings {
        map,
        layout,
        // Large enough to put texels between vertices, small enough to be baked in no time.
        side: (layout == LayoutChoice::Uv).then_some(256),
        texel: TexelFormat::Png16,
        ..bundle::Settings::default()
    };
    kinds.into_iter().flat_map(|map| layouts.map(|layout| (map, layout))).map(of).collect()
}

/// Compares all wedges of a mesh, and gives how many there were. None if the mesh cannot be baked so.
fn compare(gpu: &Gpu, renderer: &Renderer, obj: &Obj, settings: &bundle::Settings) -> Option<usize> {
    let baked = Baked::new(obj.clone(), settings).ok()?;
    let scene = baked.scene(Frames::None);
    let what = format!("{:?} {:?}", settings.map, settings.layout);
    let mut drawable = renderer.upload(gpu, scene).unwrap();
    for lambda in [0.0, 0.37, 1.0, 1.5] {
        let found = renderer.displaced_positions(gpu, &mut drawable, lambda).unwrap();
        let carried = drawable.scene().carried().unwrap();
        let expected: Vec<Vec3> = carried.vertices.iter().map(|v| v.displaced(&carried.map, lambda)).collect();
        let [low, high] = bounds(&expected);
        // Positions themselves are rounded to single precision.
        let ulp = f32::EPSILON * low.abs().max(high.abs()).max_element();
        let range = carried.map.encoding().scale * lambda.abs().max(1.0);
        let mut first: Vec<Option<Vec3>> = vec![None; expected.len()];
        for (place, vertex) in found.iter().zip(drawable.vertices_of_wedges()) {
            let vertex = vertex as usize;
            let off = (*place - expected[vertex]).abs().max_element();
            assert!(off <= EXACT * range + ulp, "{what} λ = {lambda}, vertex {vertex}: {place} {}", expected[vertex]);
            let same = first[vertex].get_or_insert(*place);
            let bits = |p: Vec3| p.to_array().map(f32::to_bits);
            assert_eq!(bits(*same), bits(*place), "{what} λ = {lambda}: wedges of vertex {vertex}");
        }
        if lambda == 0.0 {
            assert!(found.iter().zip(drawable.vertices_of_wedges()).all(|(p, v)| *p == expected[v as usize]));
        }
    }
    Some(drawable.vertices_of_wedges().len())
}

fn bounds(points: &[Vec3]) -> [Vec3; 2] {
    let start = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.iter().fold(start, |[low, high], p| [low.min(*p), high.max(*p)])
}

#[test]
fn of_the_meshes_of_this_project() {
    for backend in BACKENDS {
        let gpu = gpu(backend);
        let renderer = Renderer::new(&gpu).unwrap();
        for name in ["duck_noisy", "flange_noisy"] {
            let obj = obj(&root().join(format!("data/{name}.obj")));
            for settings in bakes() {
                let wedges = compare(&gpu, &renderer, &obj, &settings);
                assert!(wedges.is_some_and(|n| n > 1000), "{name} {settings:?}: {wedges:?}");
            }
        }
    }
}

#[test]
fn of_a_mesh_far_from_the_origin_and_without_texture_coordinates() {
    let mut text = String::new();
    for (x, y) in (0..20).flat_map(|y| (0..20).map(move |x| (x, y))) {
        let height = f64::from((7 * x + 13 * y) % 5) * 0.02;
        text += &format!("v {} {} {height}\n", 500_000.0 + f64::from(x), 4_500_000.0 + f64::from(y));
    }
    for (x, y) in (0..19).flat_map(|y| (0..19).map(move |x| (x, y))) {
        let at = |dx, dy| 20 * (y + dy) + x + dx + 1;
        text += &format!("f {} {} {} {}\n", at(0, 0), at(1, 0), at(1, 1), at(0, 1));
    }
    let obj = Obj::parse(text.into_bytes()).unwrap();
    let settings = bundle::Settings { layout: LayoutChoice::Auto, ..bundle::Settings::default() };
    for backend in BACKENDS {
        let gpu = gpu(backend);
        let renderer = Renderer::new(&gpu).unwrap();
        assert_eq!(compare(&gpu, &renderer, &obj, &settings), Some(400));
    }
}

/// Real meshes, which are not part of the project: their notices are in `../shared/data`.
fn shared_meshes() -> Option<Vec<PathBuf>> {
    let folder = root().join("../shared/data");
    let mut found: Vec<PathBuf> = std::fs::read_dir(&folder)
        .ok()?
        .chain(std::fs::read_dir(folder.join("scans")).ok()?)
        .filter_map(|entry| Some(entry.ok()?.path()))
        .flat_map(|path| if path.is_dir() { objs_in(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|e| e == "obj"))
        .collect();
    found.sort();
    Some(found)
}

fn objs_in(folder: &std::path::Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).map_or(Vec::new(), |all| all.filter_map(|e| Some(e.ok()?.path())).collect())
}

/// Larger files take minutes to bake.
const LARGEST: u64 = 12 << 20;

#[test]
#[expect(clippy::print_stderr, reason = "a test that is left out says so")]
fn of_the_meshes_beside_the_checkout() {
    let Some(meshes) = shared_meshes() else {
        eprintln!("left out: there is no ../shared/data");
        return;
    };
    let gpus = BACKENDS.map(gpu);
    let renderers = [0, 1].map(|i| Renderer::new(&gpus[i]).unwrap());
    let mut compared = 0;
    for path in meshes {
        if std::fs::metadata(&path).unwrap().len() > LARGEST {
            eprintln!("left out: {} is large", path.display());
            continue;
        }
        let Ok(obj) = Obj::parse(std::fs::read(&path).unwrap()) else {
            eprintln!("left out: {} cannot be read", path.display());
            continue;
        };
        for settings in bakes() {
            for (gpu, renderer) in gpus.iter().zip(&renderers) {
                match compare(gpu, renderer, &obj, &settings) {
                    Some(_) => compared += 1,
                    None => eprintln!("left out: {} as {:?} {:?}", path.display(), settings.map, settings.layout),
                }
            }
        }
    }
    assert!(compared > 0, "no mesh was compared");
}
