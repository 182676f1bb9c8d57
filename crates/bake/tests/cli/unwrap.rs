//! `--layout unwrap`, and what a planish without it says.

use crate::folder::Folder;
use crate::mesh::Mesh;

/// A sphere of squares and triangles whose file has no texture coordinates.
fn sphere() -> String {
    let mesh = Mesh { uvs: Vec::new(), ..Mesh::sphere(8).noisy(0.02) };
    let mut text: String = mesh.positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for face in &mesh.faces {
        let corners: Vec<String> = face.iter().map(|[v, _]| (v + 1).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

#[test]
#[cfg(not(feature = "unwrap"))]
fn a_build_without_it_says_how_to_get_it() {
    let folder = Folder::with("in.obj", sphere());
    folder.refuses("bake in.obj -o out --layout unwrap", &["--layout unwrap", "cargo install", "--features unwrap"]);
}

#[test]
#[cfg(feature = "unwrap")]
fn a_new_atlas_is_baked_checked_and_applied() {
    use crate::reference::statements;

    let folder = Folder::with("in.obj", sphere());
    let baked = folder.succeeds_with_json("bake in.obj -o out --layout unwrap");
    let manifest = &baked["manifest"];
    assert_eq!(
        (&manifest["displacement"]["layout"], &manifest["displacement"]["uvs"]),
        (&"uv".into(), &"unwrapped".into())
    );
    assert_eq!(manifest["report"]["unresolved_vertices"], 0);
    assert_eq!(manifest["report"]["overlapping_texels"], 0);
    assert!(manifest["normal_map"].is_object());
    let reason = baked["size_reason"].as_str().unwrap();
    assert!(reason.ends_with("each vertex gets its height"), "{reason}");

    let [source, carrier] = ["in.obj", "out/in.obj"].map(|name| folder.text(name));
    let corners = |text: &str| statements(text, "f").iter().map(|l| l.split_whitespace().count()).collect::<Vec<_>>();
    assert_eq!(corners(&source), corners(&carrier), "polygons stay");
    assert!(!statements(&carrier, "vt").is_empty());

    folder.succeeds("check out/in.planish.json");
    folder.succeeds("apply out/in.planish.json -o moved.obj");
    folder.succeeds("apply out/in.planish.json --mesh out/in.obj -o moved.obj");
    folder.refuses("apply out/in.planish.json --mesh in.obj -o moved.obj", &["in.obj: ", "carrier out/in.obj"]);
}

#[test]
#[cfg(feature = "unwrap")]
fn the_size_can_be_given_and_may_be_too_small() {
    let folder = Folder::with("in.obj", sphere());
    let baked = folder.succeeds_with_json("bake in.obj -o out --layout unwrap --size 300");
    assert_eq!((&baked["manifest"]["displacement"]["width"], &baked["size_reason"]), (&300.into(), &().into()));
    folder.refuses("bake in.obj -o new --layout unwrap --size 4", &["in.obj: ", "4 × 4", "--size"]);
}

#[test]
#[cfg(feature = "unwrap")]
fn texture_coordinates_that_are_there_are_replaced() {
    let folder = Folder::with("in.obj", Mesh::sphere(8).noisy(0.02).with_defects().obj());
    folder.succeeds("bake in.obj -o out --layout unwrap");
    folder.succeeds("bake in.obj -o again --layout unwrap");
    assert!(folder.contents("out") == folder.contents("again"), "the same files twice");
    folder.succeeds("check out/in.planish.json");
}
