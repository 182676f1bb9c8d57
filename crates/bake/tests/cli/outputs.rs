//! What outputs replace, and what they leave alone.

use crate::folder::Folder;
use crate::mesh::Mesh;

fn folder() -> Folder {
    Folder::with("in.obj", Mesh::grid(6).noisy(0.02).obj())
}

#[test]
fn a_bake_replaces_files_of_earlier_bakes_and_no_others() {
    let folder = folder();
    for name in ["in.normal.png", "in.displacement.png", "in.mtl", "in.glb", "in.planish.json"] {
        folder.write(&format!("out/{name}"), "mine");
        let words = [&format!("out/{name}: exists and is not a file of an earlier bake"), "-o"];
        folder.refuses("bake in.obj --method laplacian -o out", &words);
        std::fs::remove_file(folder.path(&format!("out/{name}"))).unwrap();
    }
    folder.write("out/notes.txt", "mine");
    folder.succeeds("bake in.obj --method laplacian -o out");
    folder.succeeds("bake in.obj --method laplacian --iterations 3 -o out");
    folder.succeeds("check out/in.planish.json");
    // Files that the new bake does not have go, unless somebody has changed them.
    folder.succeeds("bake in.obj --method laplacian -o out --bits 32 --no-glb");
    let names = ["in.displacement.exr", "in.mtl", "in.normal.png", "in.obj", "in.planish.json", "notes.txt"];
    assert_eq!(folder.names("out"), names);
    folder.write("out/in.displacement.exr", "touched");
    folder.succeeds("bake in.obj --method laplacian -o out");
    assert_eq!(folder.text("out/in.displacement.exr"), "touched");
    assert_eq!(folder.text("out/notes.txt"), "mine");
}

#[test]
fn a_bake_replaces_what_a_manifest_names_that_cannot_be_read_any_more() {
    let folder = folder();
    folder.succeeds("bake in.obj --method laplacian -o out");
    let mut manifest = folder.json("out/in.planish.json");
    manifest["planish"] = 2.into();
    folder.write("out/in.planish.json", manifest.to_string());
    folder.succeeds("bake in.obj --method laplacian -o out");
    folder.succeeds("check out/in.planish.json");
}

#[test]
fn apply_writes_over_no_file_of_the_bundle() {
    let folder = folder();
    folder.succeeds("bake in.obj --method laplacian -o out");
    for name in folder.names("out") {
        for mesh in ["", " --mesh in.obj"] {
            folder.refuses(&format!("apply out/in.planish.json{mesh} -o out/{name}"), &[&name, "is an input"]);
        }
    }
    folder.refuses("apply out/in.planish.json -o in.obj", &["in.obj: is an input"]);
}

#[test]
fn a_result_on_standard_output_is_alone_there() {
    let folder = folder();
    folder.succeeds("denoise in.obj --method laplacian -o out.obj");
    let whole = folder.text("out.obj");
    for place in if cfg!(unix) { &["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"][..] } else { &["-"] } {
        if *place != "-" && !folder.path(place).exists() {
            continue;
        }
        let printed = folder.succeeds(&format!("denoise in.obj --method laplacian -o {place} -v"));
        assert!(printed.out == whole, "{place}");
        assert!(printed.err.starts_with("wrote ") && printed.err.contains("\n  total "), "{place}: {}", printed.err);
    }
    folder.refuses("denoise in.obj --method laplacian -o - --json", &["--json", "standard output"]);
    folder.refuses("noise in.obj --kind voxels -o - --clean -", &["two outputs", "standard output"]);
    let noisy = folder.succeeds("noise in.obj --sigma 0.1 -o -");
    assert!(noisy.out.starts_with("v ") && noisy.err.starts_with("wrote -\n"), "{}", noisy.err);
    folder.succeeds("bake in.obj --method laplacian -o out");
    assert!(folder.succeeds("apply out/in.planish.json -o -").out.contains("mtllib in.mtl"));
    assert!(!folder.path("-").exists());
}

#[test]
fn an_empty_name_names_no_file() {
    let folder = folder();
    let printed = folder.planish("denoise in.obj -o out.obj --fix=").output().unwrap();
    assert_eq!(String::from_utf8(printed.stderr).unwrap(), "error: \"\": names no file\n");
    assert_eq!(printed.status.code(), Some(2));
}
