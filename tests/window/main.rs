//! Drives the real window with mouse and keyboard, on a display of its own, and looks at what it shows and writes.
//!
//! `PLANISH_PICTURES=FOLDER` keeps screenshots.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]
#![expect(clippy::print_stderr, reason = "a failure says where its picture is, and a measurement is printed")]

mod desk;
mod frames;

use desk::Desk;
use std::fs;
use std::path::Path;

/// Every file of a folder, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap()))
        .collect();
    all.sort();
    all
}

/// Puts a file of this project on the desk.
fn bring(desk: &Desk, name: &str, as_name: &str) {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data");
    fs::copy(data.join(name), desk.path(as_name)).unwrap();
}

#[test]
#[ignore = "needs Xvfb, xdotool and ImageMagick; tests/run runs it"]
fn a_map_is_made_compared_saved_and_opened_with_mouse_and_keyboard() {
    let mut desk = Desk::new();
    let mesh = desk.path("duck.obj");
    bring(&desk, "duck_noisy.obj", "duck.obj");
    bring(&desk, "duck.mtl", "duck.mtl");
    desk.start();

    desk.open(&mesh);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    let denoised = desk.settled_view();
    desk.key("space");
    desk.until("split", |s| s["comparing"] == "Split");
    desk.settled_view();
    desk.key("space");
    desk.drag("λ", [0.4, 0.5], [0.01, 0.5]);
    desk.until("λ is small", |s| s["lambda"].as_f64().is_some_and(|l| l < 0.2));
    let noisy = desk.settled_view();
    assert!(denoised.differs(&noisy) > 0.05, "λ changes what is seen");
    desk.key("1");
    desk.until("λ is 1", |s| s["lambda"] == 1.0);
    assert_eq!(denoised.differs(&desk.settled_view()), 0.0, "the same λ gives the same picture");

    desk.choose_method("taubin");
    desk.until("baked again", |s| s["method"]["name"] == "taubin" && s["baked"] == true && s["showing"] == false);
    let taubin = desk.settled_view();
    assert!(taubin.differs(&denoised) > 0.01);

    desk.choose_method("tgv-normals");
    desk.until("baking", |s| s["busy"].as_array().is_some_and(|b| b.contains(&"bake".into())));
    desk.key("Escape");
    desk.until("stopped", |s| {
        s["busy"].as_array().is_some_and(Vec::is_empty) && s["messages"][0] == "stopped; the last result stays"
    });
    assert!(desk.state()["baked"] == false && desk.state()["method"]["name"] == "taubin");
    desk.key("ctrl+z");
    desk.until("back", |s| s["wanted"] == "taubin" && s["baked"] == true);
    desk.dismiss();
    assert_eq!(taubin.differs(&desk.settled_view()), 0.0, "the last result stays");

    desk.key("space");
    desk.until("split", |s| s["comparing"] == "Split");
    let split = desk.settled_view();
    assert!(split.left().differs(&taubin.left()) > 0.02, "noisy on the left");
    assert!(split.right().differs(&taubin.right()) < 0.01, "and the same as before on the right");
    desk.drag("divider", [0.5, 0.9], [-20.0, 0.9]);
    assert!(desk.settled_view().differs(&split) > 0.01);
    desk.key("space");
    desk.until("whole", |s| s["comparing"] == "Off");

    let (ours, theirs) = (desk.path("window"), desk.path("command"));
    desk.save(&ours);
    desk.until("saved", |s| s["messages"][0].as_str().is_some_and(|m| m.starts_with("wrote ")));
    let line = ["planish", "bake", &mesh.to_string_lossy(), "--method", "taubin", "--quiet", "-o"];
    let line = line.iter().copied().chain([&*theirs.to_string_lossy()]).map(Into::into).collect::<Vec<_>>();
    planish::run(line);
    assert_eq!(contents(&ours).len(), 6);
    assert!(contents(&ours) == contents(&theirs), "byte for byte what the command line writes");

    desk.open(&ours.join("duck.planish.json"));
    desk.until("opened", |s| s["busy"] == serde_json::json!([]) && s["messages"] == serde_json::json!([]));
    assert_eq!(desk.state()["method"]["name"], "taubin");
    desk.key("s");
    desk.until("pictured", |s| s["messages"][0].as_str().is_some_and(|m| m.ends_with("duck.view.001.png")));

    fs::write(desk.path("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let broken = desk.path("broken.obj");
    desk.open(&broken);
    desk.until("refused", |s| s["messages"].to_string().contains("broken.obj: line 2"));
    assert_eq!(desk.state()["method"]["name"], "taubin", "what was open stays");

    desk.choose_method("tgv-normals");
    desk.until("baking", |s| s["busy"].as_array().is_some_and(|b| b.contains(&"bake".into())));
    desk.key("ctrl+q");
    desk.ended();
    let names: Vec<_> = contents_names(desk.folder());
    let expected =
        ["broken.obj", "command", "config", "duck.mtl", "duck.obj", "duck.view.001.png", "log.jsonl", "window"];
    assert_eq!(names, expected, "nothing half written");
    assert!(fs::read_to_string(desk.path("config/planish/window.json")).unwrap().contains("duck.planish.json"));
}

#[test]
#[ignore = "needs Xvfb, xdotool and ImageMagick; tests/run runs it"]
fn a_denoised_mesh_is_looked_at_and_measured_against_the_clean_one() {
    let mut desk = Desk::new();
    bring(&desk, "flange_noisy.obj", "flange_noisy.obj");
    bring(&desk, "flange_clean.obj", "flange_clean.obj");
    bring(&desk, "flange.mtl", "flange.mtl");
    desk.start_with(&["flange_noisy.obj"]);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    desk.click("clean");
    let clean = desk.path("flange_clean.obj");
    desk.answer(&clean);
    desk.until("measured", |s| s["measured"][1].is_number());
    let angles = desk.state()["measured"].clone();
    let [noisy, denoised] = [0, 1].map(|i| angles[i].as_f64().unwrap());
    assert!(denoised < 0.3 * noisy, "{angles}");
    desk.key("0");
    desk.until("measured again", |s| s["measured"][1].as_f64().is_some_and(|ea| (ea - noisy).abs() < 1e-2));
    desk.key("1");
    desk.until("as before", |s| s["measured"][1] == denoised);

    desk.key("space");
    desk.until("split", |s| s["comparing"] == "Split");
    let captions: [String; 2] = serde_json::from_value(desk.state()["captions"].clone()).unwrap();
    let says = |caption: &str, ea: f64| caption.contains(&format!("\nEa {ea:.2}°\nd mean "));
    assert!(says(&captions[0], noisy) && says(&captions[1], denoised), "errors on both sides: {captions:?}");
    desk.settled_view();
    desk.keep("window_errors");
    desk.key("space");
    desk.until("whole", |s| s["comparing"] == "Off");

    let plain = desk.settled_view();
    desk.key("h");
    let heights = desk.settled_view();
    assert!(heights.differs(&plain) > 0.1, "heights are colours");
    desk.key("n");
    let noise = desk.settled_view();
    assert!(noise.differs(&heights) > 0.1 && noise.differs(&plain) > 0.1, "the noise is other colours");
    desk.click("Error");
    desk.until("compared", |s| s["busy"] == serde_json::json!([]));
    let errors = desk.settled_view();
    assert!(errors.differs(&noise) > 0.1, "so is what is left of it");
    desk.key("0");
    desk.until("λ is 0", |s| s["lambda"] == 0.0 && s["busy"] == serde_json::json!([]));
    assert!(desk.settled_view().differs(&errors) > 0.1, "colours follow λ");
    desk.keep("window_error");
    desk.key("1");
    desk.until("λ is 1 again", |s| s["lambda"] == 1.0 && s["busy"] == serde_json::json!([]));
    desk.click("Error");
    assert_eq!(desk.settled_view().differs(&plain), 0.0);
    desk.drag("view", [0.5, 0.5], [0.7, 0.4]);
    let turned = desk.settled_view();
    assert!(turned.differs(&plain) > 0.05, "a drag turns the model");
    desk.scroll("view", [0.6, 0.4], 5);
    assert!(desk.settled_view().differs(&turned) > 0.05, "the wheel goes nearer");
    desk.key("f");
    assert_eq!(desk.settled_view().differs(&turned), 0.0, "and all of it is seen again from there");
    desk.key("p");
    assert!(desk.settled_view().differs(&turned) > 0.02, "parallel rays");

    desk.click("turntable");
    desk.until("turning", |s| s["busy"].as_array().is_some_and(|b| b.contains(&"draw".into())));
    desk.key("Escape");
    desk.until("stopped", |s| s["messages"][0] == "interrupted; nothing was written");
    desk.key("ctrl+q");
    desk.ended();
    assert_eq!(
        contents_names(desk.folder()),
        ["config", "flange.mtl", "flange_clean.obj", "flange_noisy.obj", "log.jsonl"]
    );
}

#[test]
#[ignore = "needs Xvfb, xdotool and ImageMagick; tests/run runs it"]
fn a_mask_is_painted_saved_and_taken_by_the_command_line() {
    let mut desk = Desk::new();
    bring(&desk, "duck_noisy.obj", "duck.obj");
    bring(&desk, "duck.mtl", "duck.mtl");
    desk.start_with(&["duck.obj"]);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    desk.choose_method("taubin");
    desk.until("baked again", |s| s["method"]["name"] == "taubin" && s["baked"] == true && s["showing"] == false);
    let free = desk.settled_view();
    desk.key("n");
    desk.key("n");
    desk.key("m");
    desk.until("ready to paint", |s| s["busy"] == serde_json::json!([]) && s["painting"] == true);
    let before = desk.settled_view();
    desk.drag("view", [0.45, 0.45], [0.55, 0.55]);
    desk.until("baked with the mask", |s| s["baked"] == true && s["method"]["limits"]["mask"].is_object());
    let painted = desk.settled_view();
    assert!(painted.differs(&before) > 0.01, "what is painted is seen");
    // Beside the model the mouse turns it, and paints nothing.
    let mask = desk.state()["method"]["limits"]["mask"].clone();
    desk.drag("view", [0.03, 0.05], [0.1, 0.1]);
    assert!(desk.settled_view().differs(&painted) > 0.05, "the model is turned");
    desk.click("save mask");
    desk.until("saved", |s| s["messages"][0].as_str().is_some_and(|m| m.ends_with("duck-mask.txt")));
    desk.key("m");
    desk.until("painted", |s| s["painting"] == false);
    assert!(desk.settled_view().differs(&free) > 0.005, "the map obeys the mask");

    let ours = desk.path("window");
    desk.save(&ours);
    desk.until("saved", |s| s["messages"].to_string().contains("files to "));
    desk.key("ctrl+q");
    desk.ended();
    let saved: serde_json::Value = serde_json::from_slice(&fs::read(ours.join("duck.planish.json")).unwrap()).unwrap();
    assert_eq!(saved["method"]["limits"]["mask"], mask);
    let [mesh, list, theirs] = ["duck.obj", "duck-mask.txt", "command"].map(|name| desk.path(name));
    let mask = format!("weights:{}", list.display());
    let line = ["planish", "bake", &mesh.to_string_lossy(), "--method", "taubin", "--mask", &mask, "--quiet", "-o"];
    planish::run(line.iter().copied().chain([&*theirs.to_string_lossy()]).map(Into::into).collect::<Vec<_>>());
    let map = |folder: &Path| fs::read(folder.join("duck.displacement.png")).unwrap();
    assert!(map(&ours) == map(&theirs), "the mask in the file is the one that was painted");
}

/// The walk of docs/window.md in ten pictures; four of them are in the documents.
#[test]
#[ignore = "needs Xvfb, xdotool and ImageMagick; tests/run runs it"]
fn a_walk_from_a_raw_scan_to_a_saved_map_with_a_painted_mask() {
    let mut desk = Desk::new();
    bring(&desk, "duck_noisy.obj", "scan.obj");
    bring(&desk, "duck.mtl", "duck.mtl");
    desk.start();
    desk.keep("window_1_start");
    desk.key("ctrl+o");
    desk.until("asking", |s| s["widgets"]["path"].is_array());
    std::thread::sleep(std::time::Duration::from_millis(500));
    desk.keep("window_2_open");
    let scan = desk.path("scan.obj");
    desk.answer(&scan);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    let denoised = desk.settled_view();
    desk.keep("window_3_denoised");
    desk.key("space");
    desk.until("split", |s| s["comparing"] == "Split");
    desk.settled_view();
    desk.keep("window_split");
    desk.key("space");
    desk.key("n");
    let noise = desk.settled_view();
    assert!(noise.differs(&denoised) > 0.1, "the noise is colours");
    desk.keep("window_noise");
    desk.key("h");
    assert!(desk.settled_view().differs(&noise) > 0.1, "heights are other colours");
    desk.keep("window_heights");
    desk.key("h");
    desk.key("0");
    desk.until("λ is 0", |s| s["lambda"] == 0.0);
    assert!(desk.settled_view().differs(&denoised) > 0.1, "the scan as it is");
    desk.keep("window_7_lambda");
    desk.key("1");
    desk.key("m");
    desk.until("ready to paint", |s| s["busy"] == serde_json::json!([]) && s["painting"] == true);
    desk.drag("view", [0.42, 0.42], [0.5, 0.5]);
    desk.until("baked with the mask", |s| s["baked"] == true && s["method"]["limits"]["mask"].is_object());
    desk.settled_view();
    desk.keep("window_mask");
    desk.key("m");
    desk.until("painted", |s| s["painting"] == false && s["busy"] == serde_json::json!([]));
    assert!(desk.settled_view().differs(&denoised) > 0.002, "what was painted keeps its noise");
    desk.keep("window_9_masked");
    let folder = desk.path("scan-planish");
    desk.save(&folder);
    desk.until("saved", |s| s["messages"].to_string().contains("files to "));
    desk.settled_view();
    desk.keep("window_10_saved");
    desk.key("ctrl+q");
    desk.ended();
    let saved = fs::read_to_string(folder.join("scan.planish.json")).unwrap();
    let saved: serde_json::Value = serde_json::from_str(&saved).unwrap();
    assert!(saved["method"]["name"] == "auto" && saved["method"]["limits"]["mask"].is_object());
    assert_eq!(contents(&folder).len(), 6);
}

#[test]
#[ignore = "needs Xvfb, xdotool and ImageMagick; tests/run runs it"]
fn what_cannot_be_opened_is_named_and_what_is_open_stays() {
    let mut desk = Desk::new();
    let write = |name: &str, bytes: &[u8]| fs::write(desk.path(name), bytes).unwrap();
    write(
        "square.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    write("broken.obj", b"v 0 0 0\nv 1 0 zero\n");
    write("empty.displacement.png", b"");
    for folder in ["strange", "hollow"] {
        let [mesh, folder] = ["square.obj", folder].map(|name| desk.path(name).into_os_string());
        let line = ["planish".into(), "bake".into(), mesh, "--quiet".into(), "-o".into(), folder];
        planish::run(line);
    }
    fs::write(desk.path("strange/square.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(desk.path("hollow/square.displacement.png"), "").unwrap();
    fs::copy(desk.path("square.obj"), desk.path("other.obj")).unwrap();
    fs::create_dir(desk.path("folder.obj")).unwrap();

    desk.start_with(&["square.obj"]);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    // Changed after the bake, so that the map is one of another mesh.
    let square = fs::read_to_string(desk.path("other.obj")).unwrap();
    for (name, words) in [
        ("broken.obj", "broken.obj: line 2: `zero` is not a number"),
        ("empty.displacement.png", "empty.displacement.png: has no manifest"),
        ("folder.obj", "folder.obj: is a directory"),
        ("gone.obj", "gone.obj: No such file"),
        ("hollow/square.planish.json", "square.displacement.png: "),
    ] {
        let path = desk.path(name);
        desk.open(&path);
        desk.until(name, |s| s["messages"].to_string().contains(words));
        let mesh = desk.state()["mesh"].clone();
        assert!(mesh.as_str().is_some_and(|mesh| mesh.ends_with("square.obj")), "{name}: {mesh}");
        desk.dismiss();
    }
    fs::write(desk.path("square.obj"), square + "# changed\n").unwrap();
    let strange = desk.path("strange/square.planish.json");
    desk.open(&strange);
    desk.until("refused", |s| s["messages"].to_string().contains("strange/square.obj: is not the file that"));
    desk.dismiss();
    // What vanishes is still there to be looked at, and to be saved.
    fs::remove_file(desk.path("square.obj")).unwrap();
    desk.key("ctrl+r");
    desk.until("missed", |s| s["messages"].to_string().contains("square.obj: No such file"));
    desk.dismiss();
    let saved = desk.path("saved");
    desk.save(&saved);
    desk.until("saved", |s| s["messages"][0].as_str().is_some_and(|m| m.starts_with("wrote ")));
    desk.key("ctrl+q");
    desk.ended();
    assert_eq!(contents(&saved).len(), 6);
}

fn contents_names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}
