//! Drives the state behind the window as the window does, without one.

use super::document::Kind;
use super::*;
use planish_geometry::denoise::Denoiser;
use planish_geometry::mesh::shapes;
use planish_geometry::source::format::Format;
use planish_render::settings::Shading;
use std::fs;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

pub(super) struct Bench {
    pub(super) app: App,
    folder: tempfile::TempDir,
    /// Says that the app has something to do.
    woken: Receiver<()>,
    /// The time that the app is told.
    now: Instant,
}

impl Bench {
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (wake, woken) = channel();
        let wake: Wake = Arc::new(move || {
            // At the end of a test nobody listens any more.
            let _ = wake.send(());
        });
        let bench = Self { app: App::new(&wake, WindowState::default()), folder, woken, now: Instant::now() };
        fs::write(bench.path("in.obj"), sphere()).unwrap();
        bench
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Lets a frame of the window pass after some time.
    pub(super) fn tick_after(&mut self, time: Duration, gesture: Gesture) -> Option<Instant> {
        self.now += time;
        self.app.tick(self.now, gesture)
    }

    pub(super) fn tick(&mut self) {
        self.tick_after(Duration::ZERO, Gesture::None);
    }

    /// Lets frames pass as the window does, whenever there is something to do, until the state is as expected. Where nothing
    /// goes on in the background it is at once as late as the app wants to be looked at again.
    #[track_caller]
    pub(super) fn until(&mut self, what: &str, holds: impl Fn(&App) -> bool) {
        loop {
            let again = self.tick_after(Duration::ZERO, Gesture::None);
            if holds(&self.app) {
                return;
            }
            let is_busy = Work::ALL.iter().any(|&work| self.app.status(work).is_some());
            match again.filter(|_| !is_busy) {
                Some(later) => self.now = later,
                None => {
                    let woken = self.woken.recv_timeout(Duration::from_secs(120));
                    assert!(woken.is_ok(), "never {what}: {:?}", self.app.messages());
                }
            }
        }
    }

    #[track_caller]
    pub(super) fn open(&mut self, name: &str) {
        let path = self.path(name);
        self.app.open(&path);
        self.until("opened", |app| app.status(Work::Load).is_none());
    }

    /// A mesh with its map.
    #[track_caller]
    pub(super) fn baked() -> Self {
        let mut bench = Self::new();
        bench.open("in.obj");
        bench.until("baked", App::is_baked);
        bench
    }

    /// The only message, which is an error.
    #[track_caller]
    fn complaint(&mut self, name: &str) -> String {
        self.open(name);
        let errors: Vec<_> = self.app.messages().iter().filter(|m| m.kind == MessageKind::Error).collect();
        let [Message { text, .. }] = errors[..] else {
            panic!("{name}: {:?}", self.app.messages());
        };
        let text = text.clone();
        while !self.app.messages().is_empty() {
            self.app.dismiss(0);
        }
        text
    }
}

/// A bumpy ball without texture coordinates.
fn sphere() -> String {
    let surface = shapes::dented_sphere(3);
    let mut text = String::new();
    for p in surface.positions() {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for face in surface.topology().faces().iter() {
        let [a, b, c] = [0, 1, 2].map(|k| face[k] + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    text
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_mesh_is_baked_saved_and_opened_again() {
    let mut bench = Bench::baked();
    let out = bench.path("out");
    bench.app.save(&out);
    bench.until("saved", |app| app.messages().iter().any(|m| m.kind == MessageKind::Done));
    let names = ["in.displacement.png", "in.glb", "in.mtl", "in.obj", "in.planish.json"];
    assert_eq!(files(&out), names);
    let planes = bench.app.map().unwrap().displacement().unwrap().planes().to_vec();
    for name in ["out/in.planish.json", "out/in.displacement.png"] {
        bench.open(name);
        assert!(bench.app.is_baked() && matches!(bench.app.map().unwrap().origin, Origin::File(_)), "{name}");
        assert_eq!(bench.app.map().unwrap().displacement().unwrap().planes(), planes);
        assert_eq!(
            bench.app.document().unwrap().mesh.canonicalize().unwrap(),
            bench.path("in.obj").canonicalize().unwrap()
        );
    }
}

#[test]
fn a_change_is_baked_when_it_has_settled_and_the_last_result_stays_until_then() {
    let mut bench = Bench::baked();
    let first = Arc::clone(bench.app.map().unwrap());
    for i in 0..5 {
        bench.app.choices.bake_config.settings.lambda.0 = 0.1 * f64::from(i);
        bench.tick_after(DEBOUNCE / 2, Gesture::Ongoing);
        assert!(bench.app.status(Work::Bake).is_none(), "still moving");
    }
    assert!(Arc::ptr_eq(bench.app.map().unwrap(), &first) && !bench.app.is_baked());
    bench.tick_after(DEBOUNCE, Gesture::Ongoing);
    assert!(bench.app.status(Work::Bake).is_some(), "it rests, although the mouse is down");
    bench.until("baked", App::is_baked);
    assert_eq!(bench.app.map().unwrap().manifest.displacement.lambda, 0.4);
}

#[test]
fn a_stopped_bake_leaves_the_last_result_and_can_be_asked_for_again() {
    let mut bench = Bench::baked();
    let first = Arc::clone(bench.app.map().unwrap());
    let mut taubin = Denoiser::named("taubin").unwrap();
    taubin.set("iterations", 100_000).unwrap();
    bench.app.choices.bake_config.denoiser = taubin;
    bench.until("begun", |app| app.status(Work::Bake).is_some());
    bench.app.cancel(Work::Bake);
    bench.until("stopped", |app| app.status(Work::Bake).is_none());
    assert!(Arc::ptr_eq(bench.app.map().unwrap(), &first) && !bench.app.is_baked());
    assert_eq!(bench.app.messages()[0].text, "stopped; the last result stays");
    bench.tick_after(2 * DEBOUNCE, Gesture::None);
    assert!(bench.app.status(Work::Bake).is_none(), "stopped is stopped");
    bench.app.choices.bake_config.denoiser = <_>::default();
    bench.until("as before", App::is_baked);
}

#[test]
fn bad_files_are_named_and_what_is_open_stays() {
    let mut bench = Bench::baked();
    fs::write(bench.path("broken.obj"), "v 0 0 0\nv 1 0 zero\n").unwrap();
    fs::write(bench.path("empty.png"), "").unwrap();
    fs::write(bench.path("empty.obj"), "").unwrap();
    fs::create_dir(bench.path("folder.obj")).unwrap();
    fs::write(bench.path("notes.txt"), "hello").unwrap();
    fs::write(bench.path("not.planish.json"), "{}").unwrap();
    for (name, words) in [
        ("broken.obj", "broken.obj: line 2"),
        ("empty.png", "empty.png: has no manifest"),
        ("empty.obj", "empty.obj: "),
        ("folder.obj", "folder.obj: is a directory"),
        ("gone.obj", "gone.obj: No such file"),
        ("notes.txt", "notes.txt: is neither a mesh"),
        ("not.planish.json", "not.planish.json: not a planish manifest"),
    ] {
        let text = bench.complaint(name);
        assert!(text.contains(words), "{name}: {text}");
        assert_eq!(bench.app.document().unwrap().mesh, bench.path("in.obj"));
        assert!(bench.app.is_baked(), "{name}");
    }
    assert_eq!(document::kind(Path::new("a.PNG")), Some(Kind::Picture));
}

#[test]
fn meshes_of_all_formats_can_be_dropped_and_chosen() {
    for format in Format::ALL {
        for ending in ["", ".gz", ".xz", ".GZ"] {
            for name in [format.name().to_owned(), format.name().to_uppercase()] {
                let path = format!("a scan.{name}{ending}");
                assert_eq!(document::kind(Path::new(&path)), Some(Kind::Mesh), "{path}");
            }
        }
    }
    for path in ["a.gz", "a.png.gz", "obj", "a.txt"] {
        assert_eq!(document::kind(Path::new(path)), None, "{path}");
    }
}

#[test]
fn a_map_whose_files_are_not_its_own_is_refused() {
    let mut bench = Bench::baked();
    let out = bench.path("out");
    bench.app.save(&out);
    bench.until("saved", |app| app.messages().iter().any(|m| m.kind == MessageKind::Done));
    bench.app.dismiss(0);
    fs::write(out.join("in.displacement.png"), "").unwrap();
    let text = bench.complaint("out/in.planish.json");
    assert!(text.contains("in.displacement.png: "), "{text}");
    // The source has changed and the carrier is of another mesh.
    fs::write(bench.path("in.obj"), sphere() + "v 0 0 9\n").unwrap();
    let carrier = fs::read_to_string(out.join("in.obj")).unwrap();
    fs::write(out.join("in.obj"), carrier + "# changed\n").unwrap();
    let text = bench.complaint("out/in.planish.json");
    assert!(text.contains("in.obj: "), "{text}");
}

#[test]
fn a_folder_that_cannot_be_written_to_gets_nothing() {
    let mut bench = Bench::baked();
    fs::write(bench.path("taken"), "").unwrap();
    let taken = bench.path("taken");
    bench.app.save(&taken);
    bench.until("failed", |app| app.messages().iter().any(|m| m.kind == MessageKind::Error));
    assert_eq!(files(bench.folder.path()), ["in.obj", "taken"]);
}

#[test]
fn a_changed_file_is_read_again() {
    let mut bench = Bench::baked();
    let before = bench.app.document().unwrap().info.vertex_lines;
    fs::write(bench.path("in.obj"), sphere() + "v 0 0 9\n").unwrap();
    bench.app.watch.look_now();
    bench.until("read again", |app| app.document().unwrap().info.vertex_lines == before + 1);
    bench.until("baked again", App::is_baked);
    fs::remove_file(bench.path("in.obj")).unwrap();
    bench.app.watch.look_now();
    bench.tick();
    assert!(bench.app.status(Work::Load).is_none(), "what is gone is not read");
    assert!(bench.app.is_baked() && bench.app.messages().iter().all(|m| m.kind != MessageKind::Error));
}

#[test]
fn undo_goes_back_over_choices_and_not_over_the_camera() {
    let mut bench = Bench::baked();
    bench.app.choices.view.displace.lambda = 0.25;
    bench.tick();
    bench.app.choices.view.camera.yaw = 99.0;
    bench.app.choices.bake_config.settings.lambda.0 = 0.5;
    bench.tick();
    bench.app.undo();
    assert_eq!(bench.app.choices.bake_config.settings.lambda.0, 1.0);
    bench.app.undo();
    assert_eq!((bench.app.choices.view.displace.lambda, bench.app.choices.view.camera.yaw), (1.0, 99.0));
    assert_eq!(bench.app.can_undo_redo(), [false, true]);
    bench.app.redo();
    assert_eq!(bench.app.choices.view.displace.lambda, 0.25);
}

#[test]
fn a_clean_mesh_is_measured_against_while_lambda_moves() {
    let mut bench = Bench::baked();
    let clean = bench.path("in.obj");
    bench.app.compare_with(&clean);
    let displaced = |app: &App| app.measured().and_then(|m| m.displaced.clone());
    bench.until("measured", |app| displaced(app).is_some_and(|(lambda, _)| lambda == 1.0));
    let measured = bench.app.measured().cloned().unwrap();
    assert!(measured.noisy().ea < 1e-9 && measured.displaced.as_ref().unwrap().1.ea > 0.1, "{measured:?}");
    bench.app.choices.view.displace.lambda = 0.0;
    let known = measured.known();
    bench.until("measured again", |app| displaced(app).is_some_and(|(lambda, c)| lambda == 0.0 && c.ea < 1e-3));
    let again = bench.app.measured().unwrap().known();
    assert!(Arc::ptr_eq(&known, &again), "the mesh without its map is measured once");
    fs::write(bench.path("other.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let other = bench.path("other.obj");
    bench.app.compare_with(&other);
    bench.until("refused", |app| app.messages().iter().any(|m| m.text.contains("the clean mesh has 3 vertices")));
    assert!(bench.app.clean().is_none());
}

#[test]
fn a_textured_scan_is_shown_with_its_texture_at_once() {
    let mut bench = Bench::new();
    let square = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n";
    fs::write(bench.path("textured.obj"), square).unwrap();
    fs::write(bench.path("a.mtl"), "newmtl a\nmap_Kd a.png\n").unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([200, 30, 30])).save(bench.path("a.png")).unwrap();
    for (file, chosen, expected) in [
        ("textured.obj", Shading::Phong, Shading::Texture),
        ("in.obj", Shading::Texture, Shading::Phong),
        ("textured.obj", Shading::Clay, Shading::Clay),
    ] {
        bench.app.choices.view.shading = chosen;
        let path = bench.path(file);
        bench.app.open(&path);
        bench.until(file, |app| app.document().is_some_and(|document| document.mesh == path));
        assert_eq!(bench.app.choices.view.shading, expected, "{file}");
        bench.until("the map", |app| app.map().is_some());
        assert!(!bench.app.map().unwrap().summary.is_empty());
    }
}

#[test]
fn a_mesh_is_welded_anew_as_chosen_and_what_cannot_be_welded_stays() {
    let mut bench = Bench::new();
    // Two triangles of a square, whose common corners are a hair apart, as some exporters leave them.
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 0 1e-6\nv 1 1 0.100001\nv 0 1 0\nv 2 1 0\nv 2 0 0\nf 1 2 3\nf 4 5 6\nf 3 2 7\nf 2 8 7\n";
    fs::write(bench.path("split.obj"), square).unwrap();
    let vertices = |app: &App| app.document().map_or(0, |d| d.model.surface().positions().len());
    bench.open("split.obj");
    bench.until("baked", App::is_baked);
    assert_eq!(vertices(&bench.app), 8);
    bench.app.choices.bake_config.settings.welding = Welding::Epsilon(1e-4);
    bench.until("welded", |app| vertices(app) == 6);
    bench.until("baked again", App::is_baked);
    let map = Arc::clone(bench.app.map().unwrap());
    assert_eq!(map.manifest.welding, Welding::Epsilon(1e-4));
    assert!(bench.app.command().unwrap().contains("--weld 0.0001"));
    bench.app.reload();
    bench.until("read again", |app| app.status(Work::Load).is_none());
    assert_eq!(vertices(&bench.app), 6, "a mesh that is read again keeps its welding");
    bench.until("baked once more", App::is_baked);
    // Within such a distance the whole mesh is one point.
    let map = Arc::clone(bench.app.map().unwrap());
    bench.app.choices.bake_config.settings.welding = Welding::Epsilon(9.0);
    bench.until("refused", |app| app.messages().iter().any(|m| m.kind == MessageKind::Error));
    bench.tick_after(2 * DEBOUNCE, Gesture::None);
    assert_eq!(bench.app.choices.bake_config.settings.welding, Welding::Epsilon(1e-4));
    assert!(bench.app.is_baked() && Arc::ptr_eq(&map, bench.app.map().unwrap()), "what is open stays");
    bench.open("in.obj");
    assert_eq!(bench.app.document().unwrap().welding, Welding::Exact, "another mesh is welded as usual");
}
