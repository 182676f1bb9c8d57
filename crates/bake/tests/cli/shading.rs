//! Maps of shading: ambient occlusion and curvature.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::json;

const BAKE: &str = "bake in.obj --method laplacian --size 64";

#[test]
fn shading_is_baked_beside_the_map_and_checked_with_it() {
    let folder = Folder::with("in.obj", Mesh::sphere(6).noisy(0.05).obj());
    let printed = folder.succeeds_with_json(&format!("{BAKE} -o out --ao --ao-rays 8 --ao-distance 0.5 --curvature"));
    let manifest = folder.json("out/in.planish.json");
    let occlusion =
        json!({ "file": "in.occlusion.png", "layout": "uv", "width": 64, "height": 64, "rays": 8, "distance": 0.5 });
    assert_eq!(manifest["occlusion"], occlusion);
    assert_eq!(manifest["curvature"]["file"], "in.curvature.png");
    let files = printed["files"].as_array().unwrap();
    for name in ["in.occlusion.png", "in.curvature.png"] {
        assert!(files.contains(&json!(format!("out/{name}"))), "{files:?}");
        folder.succeeds("check out/in.planish.json");
        let bytes = folder.bytes(&format!("out/{name}"));
        let mut other = bytes.clone();
        *other.last_mut().unwrap() ^= 1;
        folder.write(&format!("out/{name}"), other);
        folder.refuses("check out/in.planish.json", &[name]);
        folder.write(&format!("out/{name}"), bytes);
    }
    // A later bake without them takes them away, because they would belong to nothing.
    folder.succeeds(&format!("{BAKE} -o out"));
    assert!(!folder.names("out").iter().any(|name| name.contains("occlusion") || name.contains("curvature")));
}

#[test]
fn any_number_of_threads_gives_the_same_shading() {
    let folder = Folder::with("in.obj", Mesh::grid(9).noisy(0.3).obj());
    for threads in ["1", "3"] {
        let mut command = folder.planish(&format!("{BAKE} -o out{threads} --ao --curvature --ao-rays 33"));
        assert!(command.env("RAYON_NUM_THREADS", threads).output().unwrap().status.success());
    }
    for name in ["in.occlusion.png", "in.curvature.png", "in.glb"] {
        assert!(folder.bytes(&format!("out1/{name}")) == folder.bytes(&format!("out3/{name}")), "{name}");
    }
}

#[test]
fn bad_options_of_shading_are_named() {
    let folder = Folder::with("in.obj", Mesh::grid(3).obj());
    for (options, expected) in [
        ("--ao --ao-rays 0", "--ao-rays"),
        ("--ao --ao-rays 70000", "from 1 to 65536"),
        ("--ao --ao-distance 0", "not a length above 0"),
        ("--ao --ao-distance nan", "--ao-distance"),
    ] {
        folder.refuses_usage(&format!("bake in.obj {options}"), &[expected]);
    }
}
