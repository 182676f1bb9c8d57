//! `check` measures again, and notices what changed.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::json;

fn mesh() -> String {
    Mesh::sphere(5).noisy(0.05).split_at_seams().with_defects().obj()
}

#[test]
fn files_that_were_left_alone_do_what_their_manifest_says() {
    let folder = Folder::with("scans/in.obj", mesh());
    folder.succeeds("denoise scans/in.obj -o scans/smooth.obj --method laplacian --iterations 4");
    let maps = [
        "--method laplacian --layout uv --size 32",
        "--method laplacian --layout uv --size 128 --texels interpolated",
        "--method laplacian --layout vertex --bits 8",
        "--method laplacian --layout vertex --map vector --format tiff",
        "--method laplacian --layout uv --size 128 --map vector --space tangent --weld 0.001",
        "--method sun --layout vertex",
        "--method sun --layout vertex --normals denoised --max-displacement 0.1",
        "--layout vertex --target scans/smooth.obj",
    ];
    for map in maps {
        let baked = folder.succeeds_with_json(&format!("bake scans/in.obj -o out {map}"));
        let checked = folder.succeeds_with_json("check out/in.planish.json");
        assert_eq!(checked["report"], baked["manifest"]["report"], "{map}");
        assert_eq!(checked["differences"], json!([]), "{map}");
        assert!(folder.succeeds("check out/in.planish.json").out.contains("as its manifest says"), "{map}");
    }
    folder.succeeds("check out/in.planish.json --mesh scans/in.obj");
}

#[test]
fn a_promise_that_is_not_kept_is_an_error() {
    let folder = Folder::with("in.obj", mesh());
    folder.succeeds("bake in.obj --method laplacian -o out --layout vertex");
    // The scale of another bake, as after mixing up two manifests.
    let mut manifest = folder.json("out/in.planish.json");
    let scale = manifest["displacement"]["scale"].as_f64().unwrap();
    manifest["displacement"]["scale"] = (scale * 1.5).into();
    folder.write("out/in.planish.json", manifest.to_string());
    let output = folder.planish("check out/in.planish.json").output().unwrap();
    let (out, err) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(out.contains("not as its manifest says"), "{out}");
    assert!(err.starts_with("error: out/in.planish.json: the largest error is "), "{err}");
    assert_eq!(err.lines().count(), 1, "{err}");
}

#[test]
fn other_files_than_those_that_were_baked_are_refused() {
    let folder = Folder::with("in.obj", mesh());
    folder.succeeds("bake in.obj --method laplacian -o out --layout vertex");
    let manifest = folder.json("out/in.planish.json");
    let mut unknown = manifest.clone();
    unknown["method"] = json!({ "name": "clairvoyance" });
    folder.write("out/unknown.planish.json", unknown.to_string());
    folder.refuses("check out/unknown.planish.json", &["unknown.planish.json: field `method`", "clairvoyance"]);

    folder.write("other.obj", Mesh::grid(3).obj());
    folder.refuses("check out/in.planish.json --mesh other.obj", &["other.obj: is not the file", "in.planish.json"]);
    let carrier = folder.text("out/in.obj");
    folder.write("out/in.obj", carrier.clone() + "# touched\n");
    folder.refuses("check out/in.planish.json", &["out/in.obj: is not the file", "byte for byte"]);
    folder.write("out/in.obj", carrier);
    folder.without_checksums("out/in.planish.json");
    folder.write("out/in.displacement.png", "");
    folder.refuses("check out/in.planish.json", &["in.displacement.png: not a readable PNG"]);
    std::fs::remove_file(folder.path("in.obj")).unwrap();
    folder.refuses("check out/in.planish.json", &["in.obj: does not exist any more", "--mesh"]);
}
