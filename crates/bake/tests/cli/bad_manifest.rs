//! `apply` trusts nothing: not the manifest, not the map, not the mesh.

use crate::folder::Folder;
use crate::mesh::{Mesh, TRIANGLE};
use serde_json::{Value, json};

const APPLY: &str = "apply out/in.planish.json -o new/applied.obj";

/// A folder with a mesh that has a seam, and its bake in `out`.
fn baked() -> Folder {
    let folder = Folder::with("in.obj", Mesh::sphere(4).noisy(0.05).obj());
    folder.succeeds("bake in.obj --method laplacian -o out --size 64");
    folder
}

#[test]
fn values_that_make_no_sense_are_named() {
    let vertices = Mesh::sphere(4).positions.len();
    let (beyond, no_uv) = (json!([[vertices + 1, 1]]), json!([[1, 9999]]));
    let cases: &[(&str, Value, &[&str])] = &[
        ("/planish", json!(7), &["version 7", "versions 1 to 6"]),
        ("/private_texels", json!([[0, 0, 0]]), &["private_texels", "names no vertex"]),
        ("/private_texels", json!([[1, 99999, 0]]), &["private_texels", "no texel"]),
        ("/private_texels", json!([[1, 0]]), &["invalid length 2"]),
        ("/planish", json!("one"), &["version"]),
        ("/displacement/scale", json!(-1.0), &["displacement.scale", "-1"]),
        ("/displacement/scale", json!(1e300), &["displacement.scale"]),
        ("/displacement/bias", json!(-1e300), &["displacement.bias"]),
        ("/displacement/bias", json!("low"), &["low", "line"]),
        ("/displacement/width", json!(0), &["displacement.width", "0"]),
        ("/displacement/height", json!(100_000), &["displacement.height", "100000"]),
        ("/displacement/bits", json!(12), &["no 12-bit texels", "12"]),
        ("/displacement/layout", json!("spiral"), &["spiral"]),
        ("/displacement/lambda", json!(1e300), &["displacement.lambda"]),
        ("/displacement/origin", json!([0.0, 1e300, 0.0]), &["displacement.origin"]),
        ("/method", json!("magic"), &["method"]),
        ("/dominant_uv/seam_vertices", json!([[0, 1]]), &["dominant_uv.seam_vertices", "count from 1"]),
        ("/dominant_uv/seam_vertices", json!([[1, 0]]), &["dominant_uv.seam_vertices", "count from 1"]),
        ("/dominant_uv/seam_vertices", beyond, &["dominant_uv.seam_vertices", "names no vertex"]),
        ("/dominant_uv/seam_vertices", no_uv, &["dominant_uv.seam_vertices", "no `vt` 9999"]),
    ];
    for (field, value, words) in cases {
        let folder = baked();
        let mut manifest = folder.json("out/in.planish.json");
        match manifest.pointer_mut(field) {
            Some(place) => *place = value.clone(),
            // A field that this map has no need of.
            None => manifest[&field[1..]] = value.clone(),
        }
        folder.write("out/in.planish.json", manifest.to_string());
        folder.refuses(APPLY, &[&["error: out/in.planish.json: "], *words].concat());
    }
}

#[test]
fn missing_fields_are_named() {
    let folder = baked();
    let whole = folder.json("out/in.planish.json");
    // Not every map comes with a normal map, and manifests of earlier versions list no files.
    for field in whole.as_object().unwrap().keys().filter(|field| !["normal_map", "files"].contains(&field.as_str())) {
        let mut manifest = whole.clone();
        manifest.as_object_mut().unwrap().shift_remove(field);
        folder.write("out/in.planish.json", manifest.to_string());
        folder.refuses(APPLY, &["error: out/in.planish.json: ", &format!("`{field}`")]);
    }
}

#[test]
fn what_is_no_manifest_is_refused() {
    let folder = baked();
    for text in ["", "hello", "[1, 2", "[]", "null", "{}", TRIANGLE, "\u{0}\u{1}"] {
        folder.write("out/in.planish.json", text);
        folder.refuses(APPLY, &["error: out/in.planish.json: not a planish manifest: "]);
    }
}

#[test]
fn a_map_that_is_not_the_one_of_the_manifest_is_refused() {
    let folder = baked();
    folder.without_checksums("out/in.planish.json");
    let map = "out/in.displacement.png";
    let whole = folder.bytes(map);
    let refuses = |bytes: &[u8], words: &[&str]| {
        folder.write(map, bytes);
        folder.refuses(APPLY, &[&["error: out/in.displacement.png: "], words].concat());
    };
    let not_png = ["not a readable PNG"];
    refuses(&whole[..whole.len() / 2], &not_png);
    refuses(&whole[..20], &not_png);
    refuses(&[], &not_png);
    refuses(TRIANGLE.as_bytes(), &not_png);
    for (options, found) in
        [("--size 32", "32 × 32 texels of 16 bits"), ("--size 64 --bits 8", "64 × 64 texels of 8 bits")]
    {
        folder.succeeds(&format!("bake in.obj -o other {options}"));
        let expected = "the manifest says 64 × 64 texels of 16 bits";
        refuses(&folder.bytes("other/in.displacement.png"), &[found, expected]);
    }
    std::fs::remove_file(folder.path(map)).unwrap();
    folder.refuses(APPLY, &["error: out/in.displacement.png: ", "o such file"]);
}

#[test]
fn an_exr_is_checked_as_well() {
    let folder = baked();
    folder.succeeds("bake in.obj --method laplacian -o out --size 64 --bits 32");
    folder.without_checksums("out/in.planish.json");
    let whole = folder.bytes("out/in.displacement.exr");
    for bytes in [&whole[..whole.len() / 2], b"", b"exr"] {
        folder.write("out/in.displacement.exr", bytes);
        folder.refuses(APPLY, &["error: out/in.displacement.exr: not a readable EXR"]);
    }
}

#[test]
fn a_mesh_that_was_not_baked_is_refused() {
    let folder = baked();
    folder.write("other.obj", Mesh::sphere(4).obj());
    let words = ["is not the mesh that out/in.planish.json belongs to", "in.obj"];
    folder.refuses(&format!("{APPLY} --mesh other.obj"), &[&["error: other.obj: "], &words[..]].concat());
    // The right vertices with one comment more are not the bytes that were baked either.
    folder.write("out/in.obj", folder.text("out/in.obj") + "# edited\n");
    folder.refuses(APPLY, &["error: out/in.obj: ", "is not the file that out/in.planish.json was made with"]);
    folder.refuses(&format!("{APPLY} --mesh out/in.obj"), &[&["error: out/in.obj: "], &words[..]].concat());
    std::fs::remove_file(folder.path("out/in.obj")).unwrap();
    folder.refuses(APPLY, &["error: out/in.obj: ", "o such file"]);
    folder.succeeds(&format!("{APPLY} --mesh in.obj"));
}

#[test]
fn apply_writes_over_none_of_its_inputs() {
    let folder = baked();
    for input in ["out/in.planish.json", "out/in.displacement.png", "out/in.obj"] {
        folder.refuses(&format!("apply out/in.planish.json -o {input}"), &[input, "is an input"]);
    }
    folder.refuses("apply out/in.planish.json --mesh in.obj -o in.obj", &["in.obj", "is an input"]);
}

#[test]
fn settings_that_a_method_does_not_have_or_cannot_have_are_named() {
    let folder = Folder::with("in.obj", Mesh::sphere(4).noisy(0.05).obj());
    let cases: &[(&str, &str, Value, &str)] = &[
        (
            "laplacian",
            "/iterations",
            json!(4_294_967_295_u32),
            "`iterations` of laplacian: 4294967295 is not a whole number",
        ),
        ("laplacian", "/step", json!(1.5), "`step` of laplacian: 1.5 is not a number between 0 and 1"),
        ("guided-normals", "/radius", json!(1e9), "`radius` of guided-normals: 1000000000.0 is not a number between"),
        ("bilateral-normals", "/smoothness", json!(0), "`smoothness` of bilateral-normals: 0 is not a number between"),
        ("map", "/prior/rounds", json!(-1), "`prior.rounds` of map: -1 is not a whole number between 0 and 100000"),
        ("auto", "/candidates", json!(["best"]), "`candidates` of auto: [\"best\"] is not a list of some of flat, "),
    ];
    for (method, pointer, value, words) in cases {
        folder.succeeds(&format!("bake in.obj --method {method} -o out --size 64"));
        let mut manifest = folder.json("out/in.planish.json");
        *manifest["method"].pointer_mut(pointer).unwrap() = value.clone();
        folder.write("out/in.planish.json", manifest.to_string());
        for command in [APPLY, "check out/in.planish.json"] {
            folder.refuses(command, &["error: out/in.planish.json: field `method`: setting ", words]);
        }
    }
    folder.succeeds("bake in.obj --method sun -o out --size 64");
    let mut manifest = folder.json("out/in.planish.json");
    manifest["method"]["treshold"] = manifest["method"]["threshold"].take();
    manifest["method"].as_object_mut().unwrap().shift_remove("threshold");
    folder.write("out/in.planish.json", manifest.to_string());
    for command in [APPLY, "check out/in.planish.json"] {
        folder.refuses(command, &["field `method`: sun has no setting `treshold`; it has iterations, threshold, "]);
    }
}
