//! Drives the real binary.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::PathBuf;
#[cfg(unix)]
use std::process::Stdio;
use std::process::{Command, Output};

/// A folder with a triangle in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.path("in.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_planish-viewer"));
        // Without a desktop the graphics drivers say on standard error that this folder is not there.
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
        // A window would wait for somebody to close it.
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.current_dir(&self.0).args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Expects this exit status and a single line on standard error that has `word` in it.
    #[track_caller]
    fn fails(&self, line: &str, status: i32, word: &str) {
        let output = self.run(line);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(status), "{line}: {message}");
        assert!(message.lines().count() == 1 && message.contains(word), "{line}: {message}");
        assert!(!self.path("out.png").exists(), "{line}");
    }

    #[track_caller]
    fn draws(&self, line: &str) -> image::RgbaImage {
        let output = self.run(line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{line}");
        image::open(self.path("out.png")).unwrap().into_rgba8()
    }
}

#[test]
fn saved_settings_draw_the_same_picture() {
    let folder = Folder::new();
    let first = folder
        .draws("in.obj --headless out.png --size 40x30 --shading flat --yaw -20 --pitch 5 --save-settings s.json");
    assert_eq!(first.dimensions(), (40, 30));
    fs::remove_file(folder.path("out.png")).unwrap();
    assert_eq!(folder.draws("in.obj --headless out.png --settings s.json"), first);
    let mut names: Vec<_> = fs::read_dir(&folder.0).unwrap().map(|f| f.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["in.obj", "out.png", "s.json"], "nothing else is left behind");
}

#[test]
fn numbers_become_a_heat_map() {
    let folder = Folder::new();
    fs::write(folder.path("h.txt"), "-1\n0\n1e-3\n").unwrap();
    folder.draws("in.obj --headless out.png --size 40x30 --shading heat --scalars h.txt");
}

#[test]
fn bad_input_and_usage_exit_with_2_and_name_the_file() {
    let folder = Folder::new();
    fs::write(folder.path("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    fs::write(folder.path("bad.json"), r#"{ "supersampling": 0 }"#).unwrap();
    fs::write(folder.path("bad.txt"), "1 2 three").unwrap();
    fs::write(folder.path("short.txt"), "1 2").unwrap();
    folder.fails("none.obj --headless out.png", 2, "none.obj");
    folder.fails("bad.obj --headless out.png", 2, "bad.obj: line 2");
    folder.fails("in.obj --headless out.png --settings bad.json", 2, "bad.json: supersampling");
    folder.fails("in.obj --headless out.png --size 0x30", 2, "size.width");
    folder.fails("in.obj --headless out.png --shading heat", 2, "--scalars");
    folder.fails("in.obj --headless out.png --shading heat --scalars bad.txt", 2, "bad.txt: `three`");
    folder.fails("in.obj --headless out.png --shading heat --scalars short.txt", 2, "short.txt: 2 numbers");
    folder.fails("in.obj --headless out.png --texture in.obj", 2, "in.obj");
}

#[test]
fn a_window_without_a_display_exits_with_1() {
    Folder::new().fails("in.obj", 1, "--headless");
}

#[test]
fn what_cannot_be_written_to_is_named_and_inputs_stay() {
    let folder = Folder::new();
    folder.fails("in.obj --headless in.obj/out.png", 2, "in.obj: is a file, and a folder is needed here");
    folder.fails("in.obj --headless .", 2, ".: is a directory");
    let before = fs::read(folder.path("in.obj")).unwrap();
    folder.fails("in.obj --headless in.obj", 2, "in.obj: is an input");
    folder.fails("in.obj --headless new.png --save-settings in.obj", 2, "in.obj: is an input");
    assert_eq!(fs::read(folder.path("in.obj")).unwrap(), before);
    assert!(!folder.path("new.png").exists());
    folder.fails("none.obj --headless new/folder/out.png", 2, "none.obj: No such file");
    assert!(!folder.path("new").exists(), "a folder for nothing is taken away again");
}

#[test]
fn a_folder_is_made_for_the_picture() {
    let folder = Folder::new();
    let output = folder.run("in.obj --headless new/out.png --size 8x8 --backend software --lambda 0");
    assert!(output.status.success() && folder.path("new/out.png").is_file(), "{output:?}");
}

/// A sheet of n × n squares with bumps.
#[cfg(unix)]
fn sheet(n: usize) -> String {
    let mut text = String::new();
    for (x, y) in (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y))) {
        text += &format!("v {x} {y} {}\n", (7 * x + 13 * y) % 5);
    }
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let a = y * (n + 1) + x + 1;
        text += &format!("f {a} {} {} {}\n", a + 1, a + n + 2, a + n + 1);
    }
    text
}

#[cfg(unix)]
#[test]
fn an_interrupt_stops_the_bake_and_leaves_nothing_behind() {
    let folder = Folder::new();
    fs::write(folder.path("large.obj"), sheet(400)).unwrap();
    let mut command = folder.command("large.obj --headless new/out.png --backend software");
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The folder is made when Ctrl-C is listened to, and before the mesh is read.
    while !folder.path("new").exists() {
        std::thread::yield_now();
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.as_str()), (Some(1), "error: interrupted; nothing was written\n"));
    assert!(!folder.path("new").exists());
}

/// A tent over a square, whose tip the default method takes down.
const TENT: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n\
    f 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n";

/// Two triangles, each of its own material.
const PATCHES: &str = "mtllib a.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl red\nf 1/1 2/2 3/3\nusemtl blue\nf 1/1 3/3 4/4\n";

#[test]
fn materials_have_their_own_textures() {
    let folder = Folder::new();
    fs::write(folder.path("two.obj"), PATCHES).unwrap();
    fs::write(folder.path("a.mtl"), "newmtl blue\nmap_Kd blue.png\nnewmtl red\nmap_Kd red.png\n").unwrap();
    let paint = |name: &str, rgb| image::RgbImage::from_pixel(2, 2, image::Rgb(rgb)).save(folder.path(name)).unwrap();
    paint("red.png", [220, 20, 20]);
    paint("blue.png", [20, 20, 220]);
    let line = "two.obj --headless out.png --size 60x60 --lambda 0 --yaw 0 --pitch 0 --backend software";
    let found = |line: &str| {
        let out = folder.run(line);
        assert!(out.status.success(), "{out:?}");
        let image = image::open(folder.path("out.png")).unwrap().into_rgb8();
        let reds = image.pixels().filter(|p| u16::from(p.0[0]) > 2 * u16::from(p.0[2])).count();
        let blues = image.pixels().filter(|p| u16::from(p.0[2]) > 2 * u16::from(p.0[0])).count();
        (reds > 300, blues > 300, String::from_utf8(out.stderr).unwrap())
    };
    assert_eq!(found(line), (true, true, String::new()));
    fs::remove_file(folder.path("red.png")).unwrap();
    let (reds, blues, said) = found(line);
    assert!(!reds && blues && said.contains("red.png"), "{said}");
}

#[test]
fn a_clean_mesh_shows_the_error() {
    let folder = Folder::new();
    fs::write(folder.path("tent.obj"), TENT).unwrap();
    fs::write(folder.path("flat.obj"), TENT.replace("v 1 1 1", "v 1 1 0")).unwrap();
    let line = "tent.obj --headless out.png --size 60x50 --backend software --lambda 0";
    let plain = folder.draws(line);
    let distance = folder.draws(&format!("{line} --clean flat.obj"));
    let angle = folder.draws(&format!("{line} --clean flat.obj --error angle"));
    assert!(distance != plain && angle != distance);
    fs::remove_file(folder.path("out.png")).unwrap();
    fs::write(folder.path("other.obj"), PATCHES).unwrap();
    folder.fails("tent.obj --headless new.png --lambda 0 --clean other.obj", 2, "other.obj: ");
    folder.fails("tent.obj --headless new.png --lambda 0 --clean none.obj", 2, "none.obj: ");
}

/// A sheet of triangles with noise of this size, edges.
fn noisy_sheet(noise: f64) -> String {
    const SIDE: usize = 30;
    let random = |k: usize| (12.9898 * k as f64).sin() * 43758.5453;
    let height = |k: usize| noise * (random(k) - random(k).floor() - 0.5);
    let vertices = (0..SIDE * SIDE).map(|k| format!("v {} {} {}\n", k % SIDE, k / SIDE, height(k)));
    let inner = (0..SIDE * (SIDE - 1)).filter(|k| k % SIDE != SIDE - 1);
    let faces = inner.map(|k| [k + 1, k + 2, k + SIDE + 2, k + SIDE + 1]);
    let faces = faces.map(|[a, b, c, d]| format!("f {a} {b} {c}\nf {a} {c} {d}\n"));
    vertices.chain(faces).collect()
}

#[test]
fn a_report_is_one_page_with_pictures_before_and_after() {
    let folder = Folder::new();
    // A name with signs that mean something in HTML.
    fs::write(folder.path("a&b.obj"), noisy_sheet(0.5)).unwrap();
    fs::write(folder.path("flat.obj"), noisy_sheet(0.0)).unwrap();
    let line = "a&b.obj --report out.html --size 60x50 --backend software";
    let page = |options: &str| {
        let output = folder.run(&format!("{line} {options}"));
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        fs::read_to_string(folder.path("out.html")).unwrap()
    };
    let plain = page("");
    assert!(plain.contains("<h1>a&amp;b.obj</h1>") && plain.contains("planish bake &#39;a&amp;b.obj&#39;"), "{plain}");
    let pictures: Vec<&str> = plain.split("data:image/png;base64,").skip(1).collect();
    assert_eq!(pictures.len(), 4, "before, after, heights and noise");
    assert!(plain.contains("Where the noise is"));
    assert_ne!(pictures[0].split('"').next(), pictures[1].split('"').next(), "the noise is gone");
    let compared = page("--clean flat.obj");
    assert_eq!(compared.matches("data:image/png").count(), 6, "the error before and after as well");
    assert!(compared.contains("Mean distance from the clean mesh, before") && compared.contains("flat.obj"));
    assert_eq!(page(""), plain, "the same input gives the same bytes");
    fs::remove_file(folder.path("out.html")).unwrap();
    folder.fails("none.obj --report out.html", 2, "none.obj");
    folder.fails("a&b.obj --report a&b.obj", 2, "is an input");
    assert!(!folder.path("out.html").exists());
}

#[test]
fn before_and_after_are_in_one_picture_and_lambda_moves_in_an_animation() {
    let folder = Folder::new();
    fs::write(folder.path("a.obj"), noisy_sheet(0.5)).unwrap();
    let picture = |name: &str, options: &str| {
        let output = folder.run(&format!("a.obj --headless {name} --size 60x50 --backend software {options}"));
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        image::open(folder.path(name)).unwrap().into_rgba8()
    };
    let [noisy, denoised, both] =
        [("0.png", "--lambda 0"), ("1.png", ""), ("both.png", "--before-after")].map(|(name, o)| picture(name, o));
    assert_ne!(noisy, denoised);
    for (x, y, pixel) in both.enumerate_pixels().filter(|(x, ..)| x.abs_diff(30) > 1) {
        assert_eq!(pixel, if x < 30 { noisy.get_pixel(x, y) } else { denoised.get_pixel(x, y) }, "{x}, {y}");
    }
    assert_eq!(picture("moving.png", "--animate"), noisy, "where nothing moves, the first picture is shown");
    let bytes = fs::read(folder.path("moving.png")).unwrap();
    assert!(bytes.windows(4).any(|chunk| chunk == b"acTL"));
    for (options, word) in
        [("--animate", "--headless"), ("--headless a.png --animate --before-after", "cannot be used")]
    {
        let output = folder.run(&format!("a.obj {options}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(word) && !folder.path("a.png").exists(), "{said}");
    }
}

#[test]
fn heights_are_put_on_and_need_texture_coordinates() {
    let folder = Folder::new();
    fs::write(folder.path("tent.obj"), TENT).unwrap();
    image::GrayImage::from_pixel(2, 2, image::Luma([255])).save(folder.path("white.png")).unwrap();
    let draw =
        |options: &str| folder.draws(&format!("tent.obj --headless out.png --size 60x50 --backend software {options}"));
    let bare = draw("--lambda 0");
    assert_eq!(draw("--heights white.png --scale 0"), bare);
    let lifted = draw("--heights white.png --scale 0.3");
    assert_ne!(lifted, bare);
    // The same surface: p + 1 · (0.3 + 0 · texel) n.
    assert_eq!(draw("--heights white.png --scale 0 --bias 0.3"), lifted);
    fs::remove_file(folder.path("out.png")).unwrap();
    folder.fails("in.obj --headless out.png --heights white.png", 2, "in.obj: has no texture coordinates");
    folder.fails("tent.obj --headless out.png --heights none.png", 2, "none.png: ");
    folder.fails("none.planish.json --headless out.png", 2, "none.planish.json: ");
    folder.fails("a.planish.json --map b.planish.json --headless out.png", 2, "--map");
}

#[test]
fn a_volume_is_drawn_around_a_mesh_and_alone() {
    let folder = Folder::new();
    fs::write(folder.path("tent.obj"), TENT).unwrap();
    let line = "tent.obj --headless out.png --size 60x50 --backend software --lambda 0";
    let bare = folder.draws(line);
    let distance = folder.draws(&format!("{line} --volume distance --volume-grid 16 --save-settings s.json"));
    assert_ne!(distance, bare);
    assert_eq!(folder.draws("tent.obj --headless out.png --backend software --settings s.json"), distance);
    let solid =
        folder.draws(&format!("{line} --volume distance --volume-grid 16 --shading solid --volume-range -0.2,0.2"));
    assert!(solid != bare && solid != distance);
    fs::write(folder.path("a.raw"), (0..60).collect::<Vec<u8>>()).unwrap();
    let raw = "--volume a.raw --volume-size 3,4,5 --volume-type u8 --transfer fog";
    let around = folder.draws(&format!("{line} {raw}"));
    let hidden = folder.draws(&format!("{line} {raw} --hide-mesh"));
    let alone = folder.draws(&format!("--headless out.png --size 60x50 --backend software {raw}"));
    assert!(around != bare && around != hidden && alone != hidden);
    fs::remove_file(folder.path("out.png")).unwrap();
    for (options, word) in [
        ("--volume none.nrrd", "none.nrrd: "),
        ("--volume a.raw", "a.raw: is no NRRD file"),
        ("--volume a.raw --volume-size 3,4,6 --volume-type u8", "a.raw: has 60 bytes of values"),
        ("--volume a.raw --volume-size 3,4,0 --volume-type u8", "volume.source.raw.size"),
        ("--volume distance --volume-grid 4000", "volume.source.distance.size"),
        ("--volume distance --clip x=0.7..0.2", "volume.low"),
        ("--shading solid", "solid shading needs a volume"),
    ] {
        folder.fails(&format!("{line} {options}"), 2, word);
    }
    folder.fails("tent.obj --headless a.raw --volume a.raw", 2, "a.raw: is an input");
    folder.fails("--headless out.png --volume distance", 2, "need a mesh");
}
