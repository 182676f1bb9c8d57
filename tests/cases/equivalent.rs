//! The command line that the window shows does what the window does.

use planish_files::bake_files::Job;
use planish_files::input::{self, Trust};
use planish_geometry::bake::{Carriers, LayoutChoice};
use planish_geometry::denoise::{Denoiser, Parameter, Values};
use planish_geometry::map::displacement::{MapKind, TexelFormat};
use planish_geometry::map::manifest::Manifest;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::NormalSource;
use planish_viewer::app::bake_config::BakeConfig;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// Vertices along a side of the mesh.
const SIDE: usize = 9;

/// A bumpy sheet.
fn mesh(place: &Path) {
    let mut text = String::new();
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let [u, v] = [x, y].map(|k| (k as f64 + 0.5) / SIDE as f64);
        let z = 0.02 * (7.0 * u + 40.0 * v).sin() + 0.01 * (91.0 * u).cos();
        let _ = writeln!(text, "v {u} {v} {z}\nvt {u} {v}");
    }
    for (x, y) in (0..(SIDE - 1) * (SIDE - 1)).map(|i| (i % (SIDE - 1), i / (SIDE - 1))) {
        let (a, b) = (y * SIDE + x + 1, (y + 1) * SIDE + x + 1);
        let _ = writeln!(text, "f {a}/{a} {0}/{0} {1}/{1}\nf {a}/{a} {1}/{1} {b}/{b}", a + 1, b + 1);
    }
    std::fs::write(place, text).unwrap();
}

/// Bakes both ways, and compares all files.
fn assert_same(bake_config: &BakeConfig, folder: &Path) {
    let [mesh, out] = ["sheet.obj", "out"].map(|name| folder.join(name));
    let arguments = bake_config.arguments(&mesh, &out);
    let line = std::iter::once("planish".to_owned()).chain(arguments.clone()).chain(["--quiet".to_owned()]);
    planish::run(line.map(Into::into));
    let model = input::model(&mesh, bake_config.settings.welding, Trust::Folder, &Silent).unwrap();
    let job = Job { input: &mesh, model: &model, folder: &out, protected: &[], trust: Trust::Folder };
    let baked = job.run(&bake_config.settings(&job).unwrap(), &Silent).unwrap();
    for file in &baked.bundle.files {
        let written = std::fs::read(out.join(&file.name));
        let written = written.unwrap_or_else(|e| panic!("{arguments:?}: {}: {e}", file.name));
        assert!(written == file.bytes, "{arguments:?}: {}", file.name);
    }
    std::fs::remove_dir_all(&out).unwrap();
}

/// Values that differ from the default, and are quick.
fn values(parameter: &Parameter) -> Vec<Value> {
    match parameter.values {
        Values::Count { .. } => vec![2.into()],
        Values::Number { min, max, .. } => vec![(0.37_f64).clamp(min, max).into()],
        Values::Word(words) => words.iter().map(|word| Value::from(word.name)).collect(),
        Values::Words(words) => vec![words[2..4].iter().map(|word| word.name).collect()],
        Values::Preset(_) => parameter.choices().iter().map(|word| Value::from(word.name)).collect(),
        // The window has no files of weights.
        Values::Text(_) => Vec::new(),
    }
}

#[test]
fn every_setting_of_every_method() {
    let folder = tempfile::tempdir().unwrap();
    mesh(&folder.path().join("sheet.obj"));
    // The layout that takes least time.
    let mut bake_config = BakeConfig::default();
    (bake_config.settings.layout, bake_config.settings.carriers) = (LayoutChoice::Vertex, Carriers::Obj);
    for denoiser in Denoiser::every() {
        for parameter in denoiser.options() {
            for value in values(parameter) {
                bake_config.denoiser = denoiser.clone();
                bake_config.denoiser.set_parameter(parameter, value).unwrap();
                assert_same(&bake_config, folder.path());
            }
        }
        if let Some(paper) = denoiser.paper() {
            bake_config.denoiser = paper;
            assert_same(&bake_config, folder.path());
        }
    }
}

#[test]
fn everything_else_that_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    mesh(&folder.path().join("sheet.obj"));
    std::fs::write(folder.path().join("patch.txt"), "7 12-40 # a patch\n").unwrap();
    let changes: [fn(&mut BakeConfig); 12] = [
        |r| r.settings.lambda.0 = 0.25,
        |r| r.settings.map = MapKind::VectorObject,
        |r| r.settings.map = MapKind::VectorTangent,
        |r| r.settings.texel = TexelFormat::Exr32,
        |r| r.settings.layout = LayoutChoice::Vertex,
        |r| (r.settings.layout, r.settings.side) = (LayoutChoice::Uv, Some(512)),
        |r| r.settings.carriers = Carriers::Obj,
        |r| r.settings.welding = Welding::None,
        |r| r.settings.tolerance.0 = 3.0,
        |r| r.limits.max_displacement = Some(0.1),
        |r| (r.limits.boundary, r.limits.preserve_volume) = (true, true),
        |r| r.limits.boundary = true,
    ];
    for change in changes {
        let mut bake_config = BakeConfig { denoiser: Denoiser::named("taubin").unwrap(), ..BakeConfig::default() };
        change(&mut bake_config);
        assert_same(&bake_config, folder.path());
    }
    let mut bake_config = BakeConfig { denoiser: Denoiser::named("taubin").unwrap(), ..BakeConfig::default() };
    bake_config.limits.fixed_file = Some(folder.path().join("patch.txt"));
    assert_same(&bake_config, folder.path());
    for normals in NormalSource::ALL.into_iter().filter(|normals| *normals != NormalSource::File) {
        bake_config.settings.normals = Some(normals.into());
        assert_same(&bake_config, folder.path());
    }
}

#[test]
fn a_map_that_is_opened_is_baked_again_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh_path, out] = ["sheet.obj", "out"].map(|name| folder.path().join(name));
    mesh(&mesh_path);
    for method in ["auto", "taubin", "guided-normals"] {
        let line = ["planish", "bake", "--quiet", "--method", method, "-o"].map(Into::into);
        planish::run(line.into_iter().chain([out.clone().into(), mesh_path.clone().into()]));
        let path = out.join("sheet.planish.json");
        let manifest = Manifest::from_json(&std::fs::read(&path).unwrap()).unwrap();
        let bake_config = BakeConfig::of(&manifest, &path);
        let model = input::model(&mesh_path, bake_config.settings.welding, Trust::Folder, &Silent).unwrap();
        let job = Job { input: &mesh_path, model: &model, folder: &out, protected: &[], trust: Trust::Folder };
        let baked = job.run(&bake_config.settings(&job).unwrap(), &Silent).unwrap();
        for file in &baked.bundle.files {
            assert!(std::fs::read(out.join(&file.name)).unwrap() == file.bytes, "{method}: {}", file.name);
        }
    }
}
