//! Every format goes through every command.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;

/// A noisy sphere with one seam, as an OBJ, and in each other format as planish writes it.
fn folder() -> Folder {
    let folder = Folder::with("in.obj", Mesh::sphere(8).noisy(0.02).obj());
    for format in FORMATS {
        // No iteration moves anything.
        folder.succeeds(&format!("denoise in.obj -o in.{format} --method laplacian --iterations 0"));
    }
    folder
}

const FORMATS: [&str; 6] = ["ply", "stl", "off", "glb", "gltf", "ply.gz"];

#[test]
fn a_mesh_in_any_format_goes_through_every_command() {
    let folder = folder();
    for format in FORMATS {
        let mesh = format!("in.{format}");
        let info = folder.succeeds_with_json(&format!("info {mesh}"));
        let name = format.split('.').next().unwrap();
        assert_eq!((info["format"].as_str(), info["vertices"].as_u64()), (Some(name), Some(114)), "{format}");
        folder.succeeds(&format!("denoise {mesh} -o out.{format} --method taubin"));
        folder.succeeds(&format!("noise {mesh} -o noisy.{format} --sigma 0.1"));
        folder.succeeds(&format!("compare {mesh} noisy.{format} out.{format}"));
        folder.succeeds(&format!("bake {mesh} -o map --method taubin"));
        folder.succeeds("check map/in.planish.json");
        folder.succeeds(&format!("apply map/in.planish.json --mesh {mesh} -o applied.{format}"));
        folder.succeeds("apply map/in.planish.json -o applied.obj");
        folder.succeeds(&format!("bake {mesh} -o to --target out.{format}"));
        folder.succeeds("check to/in.planish.json");
        // What the map does is what the method does, as far as heights can express it.
        let compared = folder.succeeds_with_json(&format!("compare out.{format} applied.{format}"));
        assert!(compared["results"][0]["d_max_el"].as_f64().unwrap() < 0.2, "{format}: {compared}");
    }
}

#[test]
fn every_format_is_denoised_alike() {
    let folder = folder();
    folder.succeeds("denoise in.ply -o out.ply --method taubin");
    for format in ["off", "ply.gz", "ply"] {
        folder.succeeds(&format!("denoise in.{format} -o out.{format} --method taubin"));
        folder.succeeds(&format!("denoise out.{format} -o {format}.obj --method laplacian --iterations 0"));
    }
    let positions = |name: &str| -> Vec<String> {
        folder.text(name).lines().filter(|line| line.starts_with("v ")).map(str::to_owned).collect()
    };
    folder.succeeds("denoise in.obj -o obj.obj --method taubin");
    for format in ["off", "ply.gz", "ply"] {
        assert_eq!(positions(&format!("{format}.obj")), positions("obj.obj"), "{format}");
    }
}

#[test]
fn a_ply_keeps_every_byte_but_those_of_positions() {
    let folder = folder();
    folder.succeeds("denoise in.ply -o out.ply --method taubin");
    let (before, after) = (folder.bytes("in.ply"), folder.bytes("out.ply"));
    assert_eq!(before.len(), after.len());
    let header = before.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let vertices = header..header + 114 * 24;
    assert!((0..before.len()).all(|i| vertices.contains(&i) || before[i] == after[i]));
    assert_ne!(before, after);
}

#[test]
fn what_an_output_has_no_place_for_is_named() {
    let folder = folder();
    for (format, lost) in [
        (
            "stl",
            "STL has no place for what the source has: polygons, which are cut into triangles, texture coordinates",
        ),
        ("off", "OFF has no place for what the source has: texture coordinates"),
        ("glb", "GLB has no place for what the source has: polygons, which are cut into triangles"),
    ] {
        let warnings = folder.succeeds(&format!("denoise in.obj -o again.{format} --method taubin")).err;
        assert!(warnings.contains(lost), "{warnings}");
        let report = folder.succeeds_with_json(&format!("denoise in.obj -o again.{format} --method taubin"));
        assert!(!report["lost"].as_array().unwrap().is_empty(), "{report}");
    }
    let report = folder.succeeds_with_json("denoise in.obj -o again.ply --method taubin");
    assert_eq!((&report["lost"], report["rounding"].as_f64()), (&Value::Null, Some(0.0)));
    let rounded =
        folder.succeeds_with_json("denoise in.obj -o again.stl --method taubin")["rounding"].as_f64().unwrap();
    assert!(rounded > 0.0 && rounded < 1e-7, "{rounded}");
}

#[test]
fn a_glb_gives_a_carrier_that_keeps_what_it_had() {
    let folder = folder();
    folder.succeeds("bake in.glb -o map --method taubin");
    let read = |name: &str| -> Value {
        let bytes = folder.bytes(name);
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[20..20 + length]).unwrap()
    };
    let (before, after) = (read("in.glb"), read("map/in.glb"));
    let primitive = &after["meshes"][0]["primitives"][0];
    for name in ["POSITION", "TEXCOORD_0"] {
        assert_eq!(primitive["attributes"][name], before["meshes"][0]["primitives"][0]["attributes"][name]);
    }
    assert_eq!(primitive["indices"], before["meshes"][0]["primitives"][0]["indices"]);
    assert!(primitive["attributes"]["TEXCOORD_1"].is_u64() && primitive["targets"][0]["POSITION"].is_u64());
    assert_eq!(after["meshes"][0]["extras"]["targetNames"][0], "denoised");
    assert_eq!(after["asset"], before["asset"]);
    let material = primitive["material"].as_u64().unwrap() as usize;
    assert!(after["materials"][material]["extras"]["planish"]["displacement"].is_object());
}

#[test]
fn a_buffer_that_is_longer_than_it_says_goes_into_the_carrier_whole() {
    let folder = folder();
    let mut document: Value = serde_json::from_slice(&folder.bytes("in.gltf")).unwrap();
    document["buffers"][0]["byteLength"] = 96.into();
    std::fs::write(folder.path("short.gltf"), document.to_string()).unwrap();
    folder.succeeds("bake short.gltf -o map --method taubin");
    folder.succeeds("check map/short.planish.json");
    let [mesh, carrier] =
        ["short.gltf", "map/short.glb"].map(|name| folder.succeeds_with_json(&format!("info {name}")));
    assert_eq!((&mesh["vertices"], &mesh["faces"]), (&carrier["vertices"], &carrier["faces"]));
}

#[test]
fn the_carrier_of_a_glb_never_replaces_it() {
    let folder = folder();
    folder.succeeds("bake in.glb -o . --method taubin");
    assert!(folder.path("in.planish.glb").is_file());
    folder.succeeds("check in.planish.json");
}

#[test]
fn errors_name_the_file_and_the_place() {
    let folder = folder();
    let ply = folder.bytes("in.ply");
    folder.write("cut.ply", &ply[..ply.len() - 5]);
    let obj_named = folder.bytes("in.stl");
    folder.write("really-stl.obj", obj_named);
    assert_eq!(folder.succeeds_with_json("info really-stl.obj")["format"], "stl");
    folder.write("points.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n");
    let gz = folder.bytes("in.ply.gz");
    folder.write("cut.ply.gz", &gz[..gz.len() - 50]);
    for (file, words) in [
        ("cut.ply", "cut.ply: byte"),
        ("points.ply", "points.ply: no faces: planish works on surfaces, and these are points"),
        ("cut.ply.gz", "cut.ply.gz: this compressed file is damaged or cut"),
    ] {
        for command in ["info", "denoise -o x.ply", "bake -o x"] {
            let (command, options) = command.split_once(' ').unwrap_or((command, ""));
            folder.refuses(&format!("{command} {file} {options}"), &[words]);
        }
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused_and_nothing_written() {
    let folder =
        Folder::with("huge.obj", "v 0 0 0\nv 1e40 0 0\nv 0 1e40 0\nv 0 0 1e40\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    for format in ["stl", "glb"] {
        let line = format!("denoise huge.obj -o out.{format} --method laplacian --iterations 0");
        folder.refuses(&line, &[&format!("out.{format}: "), "too large for single precision"]);
    }
    folder.refuses("denoise huge.obj -o out.ply.xz", &["out.ply.xz: xz files are read, but not written"]);
}
