//! Maps with an image for each UDIM tile or material.

use crate::folder::Folder;
use crate::reference::{Lines, statements};
use std::fmt::Write as _;

/// A rough sheet of 8 × 8 squares whose UVs fill `tiles` UDIM tiles side by side, with a vertex of its own for each tile on their
/// borders, as exporters split vertices.
fn sheet(tiles: usize) -> String {
    let mut text = String::new();
    for (x, y) in (0..=8).flat_map(|x| (0..=8).map(move |y| (f64::from(x), f64::from(y)))) {
        writeln!(text, "v {x} {y} {:?}", (13.0 * x + 7.0 * y).sin() / 3.0).unwrap();
        writeln!(text, "vt {:?} {:?}", x / 8.0 * tiles as f64, 0.05 + 0.1 * y).unwrap();
    }
    for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
        let material = if x < 4 { "left" } else { "right/side" };
        let v = |x: usize, y: usize| 9 * x + y + 1;
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        writeln!(text, "usemtl {material}\nf {a}/{a} {b}/{b} {c}/{c} {d}/{d}").unwrap();
    }
    text
}

#[test]
fn tiles_side_by_side_give_back_the_denoised_mesh() {
    let folder = Folder::with("in.obj", sheet(2));
    // One texel a vertex in single precision says where the vertices go.
    folder.succeeds("bake in.obj --method laplacian -o exact --layout vertex --bits 32 --normals angle");
    folder.succeeds("apply exact/in.planish.json -o exact.obj --mesh in.obj");
    for (pages, files) in [
        ("udim", ["out/in.displacement.1001.png", "out/in.displacement.1002.png", "out/in.normal.1002.png"]),
        ("material", ["out/in.displacement.left.png", "out/in.displacement.right_side.png", "out/in.normal.left.png"]),
    ] {
        let line = format!("bake in.obj --method laplacian -o out --pages {pages} --normals angle");
        let baked = folder.succeeds_with_json(&line);
        let (manifest, report) = (&baked["manifest"], &baked["manifest"]["report"]);
        assert_eq!((&manifest["planish"], &manifest["pages"]["by"]), (&3.into(), &pages.into()));
        assert_eq!((&report["seam_gap"], &report["unresolved_vertices"]), (&0.0.into(), &0.into()), "{pages}");
        assert!(files.iter().all(|file| !folder.bytes(file).is_empty()), "{pages}");
        let checked = folder.succeeds_with_json("check out/in.planish.json");
        assert_eq!(&checked["report"], report, "{pages}");
        folder.succeeds("apply out/in.planish.json -o from_carrier.obj");
        folder.succeeds("apply out/in.planish.json -o from_source.obj --mesh in.obj");
        assert!(statements(&folder.text("from_carrier.obj"), "v") == statements(&folder.text("from_source.obj"), "v"));
        let [applied, exact] = ["from_source.obj", "exact.obj"].map(|file| Lines::of(&folder.text(file)).positions);
        let off = applied.iter().zip(&exact).map(|(a, e)| a.distance(*e)).fold(0.0, f64::max);
        assert!(off <= report["error_bound"].as_f64().unwrap() + 1e-6, "{pages}: {off:e}");
    }
}

#[test]
fn files_of_other_tiles_are_refused_and_named() {
    let folder = Folder::with("in.obj", sheet(2));
    folder.succeeds("bake in.obj --method laplacian -o out --pages udim");
    let [first, second] = ["1001", "1002"].map(|tile| folder.bytes(&format!("out/in.displacement.{tile}.png")));
    folder.write("out/in.displacement.1002.png", &first);
    for command in ["check out/in.planish.json", "apply out/in.planish.json -o a.obj"] {
        folder.refuses(command, &["in.displacement.1002.png", "is not the file"]);
    }
    // Without checksums what is wrong with the image counts.
    folder.write("out/in.displacement.1002.png", &second[..second.len() / 2]);
    let mut manifest = folder.json("out/in.planish.json");
    manifest["files"] = serde_json::json!([]);
    folder.write("out/in.planish.json", manifest.to_string());
    folder.refuses("apply out/in.planish.json -o a.obj", &["in.displacement.1002.png", "page 1002"]);
}

#[test]
fn pages_are_made_only_if_they_are_asked_for() {
    let folder = Folder::with("in.obj", sheet(2));
    let told = folder.succeeds("bake in.obj --method laplacian -o out --max-size 256").err;
    assert!(told.contains("--pages udim"), "{told}");
    assert!(folder.json("out/in.planish.json").get("pages").is_none());
    // The next bake takes the files of the earlier one away.
    folder.succeeds("bake in.obj --method laplacian -o out --pages udim");
    folder.succeeds("bake in.obj --method laplacian -o out --max-size 256");
    assert!(!folder.path("out/in.displacement.1001.png").exists());
    folder.refuses("bake in.obj -o out --pages udim --layout vertex", &["--pages udim", "--layout vertex"]);
    let one = Folder::with("in.obj", sheet(1));
    one.succeeds("bake in.obj --method laplacian -o plain");
    one.succeeds("bake in.obj --method laplacian -o tiled --pages udim");
    assert!(one.bytes("plain/in.planish.json") == one.bytes("tiled/in.planish.json"));
}
