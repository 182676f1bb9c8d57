//! Drives the real window with mouse and keyboard, on a display of its own.

mod desk;

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

#[test]
fn a_map_is_made_compared_saved_and_opened_with_mouse_and_keyboard() {
    let Some(mut desk) = Desk::new() else { return };
    let mesh = desk.path("duck.obj");
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../data/duck_noisy.obj"), &mesh).unwrap();
    desk.start();

    desk.open(&mesh);
    desk.until("baked", |s| s["baked"] == true && s["showing"] == false);
    let denoised = desk.settled_view();
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
    planish_bake::run(line);
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
    let expected = ["broken.obj", "command", "config", "duck.obj", "duck.view.001.png", "log.jsonl", "window"];
    assert_eq!(names, expected, "nothing half written");
    assert!(fs::read_to_string(desk.path("config/planish/window.json")).unwrap().contains("duck.planish.json"));
}

fn contents_names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}
