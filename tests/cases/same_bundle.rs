//! The command line, the window, and pictures without a window bake the same files, and read from them what they baked.

use planish_files::input::Trust;
use planish_files::output::Folder;
use planish_geometry::bake::{Bundle, LayoutChoice};
use planish_geometry::denoise::NormalField;
use planish_geometry::map::displacement::MapKind;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_render::settings::Settings;
use planish_viewer::app::bake_config::BakeConfig;
use planish_viewer::app::document::{self, Origin};
use planish_viewer::app::jobs::Wake;
use planish_viewer::app::window_state::WindowState;
use planish_viewer::app::{App, Gesture, Work};
use planish_viewer::open::{self, Files};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// A bumpy sheet with a material that has a texture, in a folder of its own.
fn scan(folder: &Path) -> PathBuf {
    const SIDE: usize = 9;
    let mut text = "mtllib paint.mtl\n".to_owned();
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let [u, v] = [x, y].map(|k| (k as f64 + 0.5) / SIDE as f64);
        let z = 0.02 * (7.0 * u + 40.0 * v).sin() + 0.01 * (91.0 * u).cos();
        let _ = writeln!(text, "v {u} {v} {z}\nvt {u} {v}");
    }
    text += "usemtl painted\n";
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)).filter(|(x, y)| x + 1 < SIDE && y + 1 < SIDE) {
        let a = y * SIDE + x + 1;
        let [b, c, d] = [a + 1, a + SIDE + 1, a + SIDE];
        let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c} {d}/{d}");
    }
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("scan.obj", text.as_bytes());
    write("paint.mtl", b"newmtl painted\nKd 0.5 0.6 0.7\nmap_Kd paint.png\n");
    image::RgbImage::from_pixel(4, 4, image::Rgb([200, 90, 30])).save(folder.join("paint.png")).unwrap();
    folder.join("scan.obj")
}

/// What the window bakes when it is given a mesh.
fn by_window(mesh: &Path) -> Bundle {
    let test = std::thread::current();
    let wake: Wake = Arc::new(move || test.unpark());
    let mut app = App::new(&wake, WindowState::default());
    app.open(mesh);
    while !app.is_baked() {
        app.tick(Instant::now(), Gesture::None);
        assert!(app.messages().is_empty(), "{:?}", app.messages());
        if Work::ALL.iter().any(|&work| app.status(work).is_some()) {
            std::thread::park();
        }
    }
    let Origin::Baked { baked, .. } = &app.map().unwrap().origin else { panic!("nothing was opened but a mesh") };
    baked.bundle.clone()
}

#[test]
fn one_mesh_becomes_the_same_files_whoever_bakes_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = scan(folder.path());
    let out = folder.path().join("scan-planish");
    let line = ["planish", "bake", "--quiet", "-o"].map(Into::into);
    planish::run(line.into_iter().chain([out.clone().into(), mesh.clone().into()]));
    let mut written: Vec<_> =
        std::fs::read_dir(&out).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap()).collect();
    written.sort();
    let library = std::fs::read_to_string(out.join("scan.mtl")).unwrap();
    assert!(library.contains("Kd 0.5 0.6 0.7") && library.contains("../paint.png"), "{library}");

    let files = Files { mesh: Some(mesh.clone()), ..Files::default() };
    let opened = open::open(&files, &Settings::default(), &Silent).unwrap();
    for (who, bundle) in [("a picture", opened.baked.unwrap().bundle), ("the window", by_window(&mesh))] {
        let mut names: Vec<_> = bundle.files.iter().map(|f| f.name.clone()).collect();
        names.sort();
        assert_eq!(names, written, "{who}");
        for file in &bundle.files {
            assert!(std::fs::read(out.join(&file.name)).unwrap() == file.bytes, "{who}: {}", file.name);
        }
    }
}

#[test]
fn a_map_displaces_the_same_vertices_when_it_was_baked_as_when_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = scan(folder.path());
    let (document, none) = document::load(&mesh, Welding::Exact, Trust::Folder, &Silent).unwrap();
    assert!(none.is_none());
    let changes: [fn(&mut BakeConfig); 5] = [
        |_| (),
        |r| r.settings.layout = LayoutChoice::Vertex,
        |r| r.settings.normals = Some(NormalField::Denoised),
        |r| r.settings.normals = Some(NormalField::Tilted),
        |r| (r.settings.map, r.settings.layout) = (MapKind::VectorTangent, LayoutChoice::Uv),
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let out = folder.path().join(i.to_string());
        let mut bake_config = BakeConfig::default();
        change(&mut bake_config);
        let map = document::bake(&document, &bake_config, &out, &Silent).unwrap();
        let Origin::Baked { baked, .. } = &map.origin else { panic!("it was baked") };
        baked.write(Folder::open(&out).unwrap()).unwrap();
        let (_, read) = document::load(&out.join("scan.planish.json"), Welding::Exact, Trust::Folder, &Silent).unwrap();
        assert_eq!(read.unwrap().vertices, map.vertices, "{i}");
    }
}
