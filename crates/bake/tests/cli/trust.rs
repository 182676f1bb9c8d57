//! What a file may name, and files that do not belong together.

use crate::folder::Folder;
use crate::mesh::{Mesh, TRIANGLE};
use planish_geometry::map::manifest::sha256;
use serde_json::{Value, json};

/// A noisy sphere, baked into `out`.
fn baked(options: &str) -> Folder {
    let folder = Folder::with("in.obj", Mesh::sphere(4).noisy(0.05).obj());
    folder.succeeds(&format!("bake in.obj --method laplacian -o out {options}"));
    folder
}

/// Changes a manifest.
fn edit(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let mut manifest = folder.json("out/in.planish.json");
    change(&mut manifest);
    folder.write("out/in.planish.json", manifest.to_string());
}

#[test]
fn a_manifest_that_does_not_fit_its_meshes_is_refused_though_their_checksums_are_right() {
    let commands = ["check out/in.planish.json", "apply out/in.planish.json -o a.obj"];
    let folder = baked("--size 64");
    // A texture coordinate that no mesh has.
    edit(&folder, |manifest| manifest["dominant_uv"]["seam_vertices"][0] = json!([1, 99]));
    for command in commands {
        folder
            .refuses(command, &["out/in.planish.json: field `dominant_uv.seam_vertices`: the mesh has no", "`vt` 99"]);
    }
    // A number of vertices that neither mesh has.
    for options in ["--size 64", "--layout vertex", "--layout vertex --normals denoised"] {
        let folder = baked(options);
        let vertices = folder.json("out/in.planish.json")["source"]["vertices"].as_u64().unwrap();
        edit(&folder, |manifest| manifest["source"]["vertices"] = (vertices + 1).into());
        for command in commands.into_iter().chain(["apply out/in.planish.json --mesh in.obj -o a.obj"]) {
            folder.refuses(command, &[&format!("has {vertices} vertices"), &format!("manifest says {}", vertices + 1)]);
        }
        edit(&folder, |manifest| manifest["source"]["vertices"] = u64::MAX.into());
        folder.refuses(commands[0], &["error: out/in."]);
    }
}

#[test]
fn a_carrier_with_other_vertices_than_its_source_is_refused() {
    for options in ["--size 64", "--layout vertex --normals denoised"] {
        let folder = baked(options);
        let short = Mesh::grid(2).obj();
        edit(&folder, |manifest| {
            let sum = sha256(short.as_bytes());
            manifest["carrier"]["sha256"] = sum.clone().into();
            for entry in manifest["files"].as_array_mut().unwrap() {
                if entry["file"] == "in.obj" {
                    entry["sha256"] = sum.clone().into();
                }
            }
        });
        folder.write("out/in.obj", &short);
        let words = ["out/in.obj: has 9 vertices", "the manifest says"];
        folder.refuses("check out/in.planish.json", &words);
        folder.refuses("apply out/in.planish.json -o a.obj", &words);
    }
    // Where only the carrier has the normals of the map.
    let folder = baked("--layout vertex --normals denoised");
    let short = Mesh::grid(2).obj();
    edit(&folder, |manifest| {
        manifest.as_object_mut().unwrap().shift_remove("files");
        manifest["carrier"]["sha256"] = sha256(short.as_bytes()).into();
    });
    folder.write("out/in.obj", &short);
    folder.refuses("apply out/in.planish.json --mesh in.obj -o a.obj", &["vertices, and the manifest says"]);
}

/// CRC-32 of bytes, as PNG has it.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// A PNG of a few bytes that claims to have a hundred thousand by a hundred thousand texels.
fn bomb() -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let body = [kind.as_slice(), data].concat();
        [&(data.len() as u32).to_be_bytes(), body.as_slice(), &crc(&body).to_be_bytes()].concat()
    };
    let side = 100_000u32.to_be_bytes();
    let header = [&side[..], &side, &[16, 0, 0, 0, 0]].concat();
    let parts = [chunk(b"IHDR", &header), chunk(b"IDAT", &[0x78, 0x9c, 3, 0, 0, 0, 0, 1]), chunk(b"IEND", &[])];
    [b"\x89PNG\r\n\x1a\n".as_slice(), &parts.concat()].concat()
}

#[test]
fn an_image_that_claims_any_size_is_refused_by_its_header() {
    let folder = baked("--size 64");
    folder.without_checksums("out/in.planish.json");
    folder.write("out/in.displacement.png", bomb());
    for command in ["check out/in.planish.json", "apply out/in.planish.json -o a.obj"] {
        folder.refuses(command, &["in.displacement.png: holds 100000 × 100000 texels", "manifest says 64 × 64"]);
    }
}

#[test]
fn every_file_of_a_bundle_must_be_there_and_of_this_bundle() {
    let folder = baked("--size 64");
    let names = ["in.displacement.png", "in.normal.png", "in.obj", "in.mtl", "in.glb"];
    for entry in folder.json("out/in.planish.json")["files"].as_array().unwrap() {
        let name = entry["file"].as_str().unwrap();
        assert!(names.contains(&name), "{name}");
        assert_eq!(entry["sha256"], sha256(&folder.bytes(&format!("out/{name}"))), "{name}");
    }
    folder.succeeds("bake in.obj --method laplacian --iterations 2 -o other --size 64");
    for name in names {
        let path = format!("out/{name}");
        let own = folder.bytes(&path);
        std::fs::remove_file(folder.path(&path)).unwrap();
        folder.refuses("check out/in.planish.json", &[&format!("error: {path}: "), "o such file"]);
        let foreign = folder.bytes(&format!("other/{name}"));
        // The material library is the same unless the heights have another range.
        if foreign != own {
            folder.write(&path, foreign);
            let words = [&format!("error: {path}: "), "is not the file that out/in.planish.json was made with"];
            folder.refuses("check out/in.planish.json", &words);
            if ["in.displacement.png", "in.obj"].contains(&name) {
                folder.refuses("apply out/in.planish.json -o a.obj", &words);
            }
        }
        folder.write(&path, own);
    }
    folder.succeeds("check out/in.planish.json");
    // A list that does not name all files is no list.
    edit(&folder, |manifest| manifest["files"].as_array_mut().unwrap().truncate(2));
    folder.refuses("check out/in.planish.json", &["field `files`: lacks \"in.obj\""]);
    // Manifests of earlier versions have none.
    folder.without_checksums("out/in.planish.json");
    folder.succeeds("check out/in.planish.json");
}

#[test]
fn a_manifest_names_files_in_its_folder_only() {
    let folder = baked("--size 64");
    folder.write("maps/in.displacement.png", folder.bytes("out/in.displacement.png"));
    let absolute = folder.path("maps/in.displacement.png").display().to_string();
    for name in ["../maps/in.displacement.png", &absolute] {
        folder.without_checksums("out/in.planish.json");
        edit(&folder, |manifest| manifest["displacement"]["file"] = name.into());
        for command in ["check out/in.planish.json", "apply out/in.planish.json -o a.obj"] {
            folder.refuses(command, &["in.displacement.png: lies outside of the folder", "--trust"]);
        }
        folder.succeeds("check out/in.planish.json --trust");
        folder.succeeds("apply out/in.planish.json --trust -o a.obj");
        std::fs::remove_file(folder.path("a.obj")).unwrap();
    }
}

#[test]
fn a_library_that_is_none_gets_into_no_result() {
    let folder = Folder::with("in.obj", format!("mtllib notes.txt\n{TRIANGLE}"));
    folder.write("notes.txt", "password swordfish\n");
    let err = folder.succeeds("bake in.obj --method laplacian -o out").err;
    assert!(err.contains("warning: notes.txt: is no material library: it has no `newmtl`"), "{err}");
    assert!(!folder.text("out/in.mtl").contains("swordfish"));
    assert!(folder.succeeds("info in.obj").out.contains("notes.txt: is no material library"));
    // One that is, but has more in it than a library.
    folder.write("notes.txt", "newmtl a\nKd 1 0 0\npassword swordfish\n# a comment\n");
    folder.succeeds("bake in.obj --method laplacian -o out");
    let library = folder.text("out/in.mtl");
    assert!(library.contains("Kd 1 0 0\n# a comment\n") && !library.contains("swordfish"), "{library}");
}

#[test]
fn libraries_and_textures_outside_of_the_folder_are_read_with_trust_only() {
    let folder = Folder::with("meshes/in.obj", format!("mtllib ../in.mtl\nusemtl skin\n{TRIANGLE}"));
    folder.write("in.mtl", "newmtl skin\nmap_Kd skin.png\n");
    let err = folder.succeeds("bake meshes/in.obj --method laplacian -o out").err;
    assert!(err.contains("meshes/../in.mtl: lies outside of the folder"), "{err}");
    assert!(!folder.text("out/in.mtl").contains("map_Kd"));
    folder.succeeds("bake meshes/in.obj --method laplacian -o out --trust");
    assert!(folder.text("out/in.mtl").contains("map_Kd"));

    let picture = [b"\x89PNG\r\n\x1a\n".as_slice(), b"a picture of a stranger"].concat();
    folder.write("secret.png", &picture);
    folder.write("meshes/in.obj", format!("mtllib in.mtl\nusemtl skin\n{TRIANGLE}"));
    folder.write("meshes/in.mtl", "newmtl skin\nmap_Kd ../secret.png\n");
    let holds_picture = || folder.bytes("out/in.glb").windows(picture.len()).any(|bytes| bytes == picture);
    let err = folder.succeeds("bake meshes/in.obj --method laplacian -o out").err;
    assert!(err.contains("meshes/../secret.png: lies outside of the folder"), "{err}");
    assert!(!holds_picture());
    folder.succeeds("bake meshes/in.obj --method laplacian -o out --trust");
    assert!(holds_picture());
}

#[test]
fn numbers_that_lead_to_infinity_are_refused_wherever_they_enter() {
    let square = |size: &str| format!("v 0 0 0\nv {size} 0 0\nv {size} {size} 0\nv 0 {size} 1\nf 1 2 3\nf 1 3 4\n");
    for size in ["1e300", "1e155", "-1e51"] {
        let folder = Folder::with("in.obj", square(size));
        for command in [
            "info in.obj",
            "bake in.obj -o out --method laplacian --no-glb",
            "denoise in.obj -o out.obj",
            "denoise in.obj -o out.obj --method tgv-normals",
            "noise in.obj -o out.obj --sigma 0.1",
        ] {
            folder.refuses(command, &["error: in.obj: line 2: a coordinate is too large", "1e50"]);
        }
    }
    let folder = Folder::with("in.obj", "v 0 0 0\nv 1e-60 0 0\nv 0 1e-60 0\nf 1 2 3\n");
    folder.refuses("denoise in.obj -o out.obj", &["error: in.obj: the mesh is too small", "1e-50"]);
    // A bake is in single precision, with and without the glTF file.
    let folder = Folder::with("in.obj", square("1e39"));
    folder.succeeds("denoise in.obj -o out.obj --method laplacian");
    for options in ["", "--no-glb"] {
        let command = format!("bake in.obj -o out --method laplacian {options}");
        folder.refuses(&command, &["in.obj: line 2: a coordinate is too large for single precision"]);
    }
    folder.write("uv.obj", TRIANGLE.replace("vt 1 0", "vt 1e300 0"));
    folder.refuses("bake uv.obj -o out", &["uv.obj: line 5: a texture coordinate", "single precision"]);
    // Meshes without area cannot be compared.
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.refuses("compare flat.obj flat.obj", &["error: flat.obj: cannot be measured"]);
    folder.refuses("compare flat.obj flat.obj --json", &["error: flat.obj: cannot be measured"]);
}

#[test]
fn vertices_that_no_face_uses_take_part_in_nothing() {
    let plain = Mesh::sphere(6).noisy(0.02);
    let mut strewn = plain.clone();
    strewn.positions.extend([[1e8, 0.0, 0.0], [f64::from(f32::MAX), 0.0, 0.0], [-1e308, 1e308, 0.0]]);
    let folder = Folder::with("plain.obj", plain.obj());
    folder.write("strewn.obj", strewn.obj());
    let [plain, strewn] = ["plain", "strewn"].map(|name| folder.succeeds_with_json(&format!("info {name}.obj")));
    assert_eq!(strewn["volume"], plain["volume"]);
    assert_eq!(strewn["bounds"], plain["bounds"]);
    let volume = |name: &str| {
        let line = format!("denoise {name}.obj -o {name}.out.obj --method laplacian --preserve-volume");
        folder.succeeds_with_json(&line)["limits"]["volume"].clone()
    };
    assert_eq!(volume("strewn"), volume("plain"));
    let baked = folder.succeeds_with_json("bake strewn.obj -o out --method laplacian");
    assert!(baked["manifest"]["report"]["error_bound"].as_f64().unwrap() < 1.0);
    folder.succeeds("check out/strewn.planish.json");
}

#[test]
fn flaws_that_spoil_a_result_are_told_with_it() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let cases = [
        (format!("{corners}f 1 2 3\nf 4 3 1\n"), "faces whose normals point to opposite sides"),
        (format!("{corners}v 0.000003 0 0\nv 1 0.999998 0\nf 1 2 3\nf 5 6 4\n"), "--weld 1e-5 makes them one"),
        (
            "v 500000 4500000 0\nv 500000.0625 4500000 0\nv 500000 4500000.5 0\nf 1 2 3\n".to_owned(),
            "y has steps of 0.5",
        ),
    ];
    for (mesh, words) in cases {
        let folder = Folder::with("in.obj", mesh);
        assert!(folder.succeeds("info in.obj").out.contains(words), "{words}");
        assert!(folder.succeeds("bake in.obj -o out --method laplacian").err.contains(words), "{words}");
        let err = folder.succeeds("denoise in.obj -o out.obj --method laplacian").err;
        assert!(err.contains(words), "{err}");
    }
}

#[test]
fn charts_that_overlap_many_times_are_not_tried() {
    // Each square has the whole texture, as tiles have.
    let mut mesh = Mesh::grid(40).noisy(0.01);
    mesh.uvs = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for face in &mut mesh.faces {
        face.iter_mut().enumerate().for_each(|(k, corner)| corner[1] = k);
    }
    let folder = Folder::with("in.obj", mesh.obj());
    let baked = folder.succeeds_with_json("bake in.obj -o out --method laplacian");
    assert_eq!(baked["manifest"]["displacement"]["layout"], "vertex");
    assert!(baked["layout_reason"].as_str().unwrap().contains("1600 times the area of the texture"), "{baked}");
}

/// A noisy sphere as glTF: the document, and the bytes of its one buffer.
fn gltf() -> (Value, Vec<u8>) {
    let folder = Folder::with("in.obj", Mesh::sphere(6).noisy(0.02).obj());
    folder.succeeds("denoise in.obj -o in.glb --method laplacian --iterations 0");
    let bytes = folder.bytes("in.glb");
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let end = 20 + length(12);
    (serde_json::from_slice(&bytes[20..end]).unwrap(), bytes[end + 8..end + 8 + length(end)].to_vec())
}

/// A picture, as far as its first bytes say.
fn picture() -> Vec<u8> {
    [b"\x89PNG\r\n\x1a\n".as_slice(), b"a picture of a stranger"].concat()
}

fn holds(folder: &Folder, name: &str, part: &[u8]) -> bool {
    folder.bytes(name).windows(part.len()).any(|bytes| bytes == part)
}

#[test]
fn buffers_of_a_gltf_file_are_read_by_the_same_rule() {
    let (mut document, buffer) = gltf();
    let folder = Folder::with("in.bin", &buffer);
    document["buffers"][0]["uri"] = "../in.bin".into();
    folder.write("meshes/in.gltf", document.to_string());
    let mesh = "meshes/in.gltf";
    let commands = [
        format!("info {mesh}"),
        format!("bake {mesh} -o out --method laplacian"),
        format!("denoise {mesh} -o out.gltf --method laplacian"),
        format!("noise {mesh} -o noisy.ply --sigma 0.1"),
        format!("compare {mesh} {mesh}"),
    ];
    for command in &commands {
        folder.refuses(command, &["meshes/in.gltf: buffer 0: ", "in.bin: lies outside of the folder", "--trust"]);
    }
    for command in &commands {
        folder.succeeds(&format!("{command} --trust"));
    }
    // A manifest that names the mesh does not make its buffers harmless.
    folder.refuses("check out/in.planish.json", &["in.bin: lies outside of the folder"]);
    folder.succeeds("check out/in.planish.json --trust");
    folder.succeeds("apply out/in.planish.json -o applied.obj");
    // What is in the folder is read without.
    document["buffers"][0]["uri"] = "parts/in%20a.bin".into();
    folder.write("meshes/parts/in a.bin", &buffer);
    folder.write(mesh, document.to_string());
    for command in &commands {
        folder.succeeds(command);
    }
    folder.succeeds("check out/in.planish.json");
    // The numbers are those of the mesh, wherever they are.
    folder.write("meshes/parts/in a.bin", [&0.125_f32.to_le_bytes(), &buffer[4..]].concat());
    folder.refuses("check out/in.planish.json", &["is not the file that out/in.planish.json was made with"]);
    for (uri, words) in [("parts", "is a directory"), ("none.bin", "o such file"), ("/dev/zero", "lies outside")] {
        document["buffers"][0]["uri"] = uri.into();
        folder.write(mesh, document.to_string());
        for command in &commands {
            folder.refuses(command, &["buffer 0: ", words]);
        }
    }
}

#[test]
fn textures_of_ply_and_gltf_files_are_read_by_the_same_rule() {
    let picture = picture();
    let folder = Folder::with("secret.png", &picture);
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile ../secret.png\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
    folder.write("meshes/in.ply", ply);
    let (mut document, buffer) = gltf();
    folder.write("meshes/in.bin", buffer);
    document["buffers"][0]["uri"] = "in.bin".into();
    document["images"] = json!([{ "uri": "../secret.png" }]);
    document["textures"] = json!([{ "source": 0 }]);
    // A texture that material libraries have no statement for.
    document["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
    document["meshes"][0]["primitives"][0]["material"] = 0.into();
    folder.write("meshes/in.gltf", document.to_string());
    for mesh in ["meshes/in.ply", "meshes/in.gltf"] {
        let err = folder.succeeds(&format!("bake {mesh} -o out --method laplacian")).err;
        assert!(err.contains("meshes/../secret.png: lies outside of the folder"), "{mesh}: {err}");
        assert!(!holds(&folder, "out/in.glb", &picture), "{mesh}");
        let err = folder.succeeds(&format!("bake {mesh} -o out --method laplacian --trust")).err;
        assert!(!err.contains("lies outside"), "{mesh}: {err}");
        assert!(holds(&folder, "out/in.glb", &picture), "{mesh}");
    }
}

#[test]
fn textures_from_within_a_mesh_are_files_of_the_bundle() {
    let (mut document, mut buffer) = gltf();
    let picture = picture();
    let view = document["bufferViews"].as_array().unwrap().len();
    let start = buffer.len();
    buffer.extend(&picture);
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": start, "byteLength": picture.len() }));
    document["buffers"][0] = json!({ "uri": "in.bin", "byteLength": buffer.len() });
    document["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"] = json!([
        { "name": "a", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } },
        { "name": "b", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } },
    ]);
    document["meshes"][0]["primitives"][0]["material"] = 1.into();
    let folder = Folder::with("in.gltf", document.to_string());
    folder.write("in.bin", buffer);
    folder.succeeds("bake in.gltf -o out --method laplacian");
    let name = "out/in.image-0.png";
    assert_eq!(folder.bytes(name), picture);
    assert!(folder.text("out/in.mtl").contains("map_Kd in.image-0.png"));
    let listed: Vec<Value> = folder.json("out/in.planish.json")["files"].as_array().unwrap().clone();
    let entries: Vec<&Value> = listed.iter().filter(|entry| entry["file"] == "in.image-0.png").collect();
    assert_eq!(entries, [&json!({ "file": "in.image-0.png", "sha256": sha256(&picture) })]);
    folder.succeeds("check out/in.planish.json");
    folder.write(name, "another picture");
    folder.refuses("check out/in.planish.json", &[name, "is not the file that out/in.planish.json was made with"]);
    folder.refuses(&format!("apply out/in.planish.json -o {name}"), &["is an input"]);
    folder.write(name, &picture);
    // A later bake of a mesh without it takes it away.
    folder.write("plain/in.obj", Mesh::sphere(4).noisy(0.02).obj());
    folder.succeeds("bake plain/in.obj -o out --method laplacian");
    assert!(!folder.path(name).exists());
}

#[test]
fn a_mesh_in_any_format_is_known_again_by_its_content() {
    let folder = Folder::with("in.obj", Mesh::sphere(6).noisy(0.02).obj());
    for format in ["ply.gz", "obj.gz", "gltf", "glb", "stl", "off"] {
        folder.succeeds(&format!("denoise in.obj -o a/in.{format} --method laplacian --iterations 0"));
        folder.succeeds(&format!("denoise a/in.{format} -o a/to.{format} --method laplacian"));
        folder.succeeds(&format!("bake a/in.{format} --target a/to.{format} -o out"));
        folder.succeeds("check out/in.planish.json");
        let denoised = folder.bytes(&format!("a/to.{format}"));
        folder.write(&format!("a/to.{format}"), folder.bytes(&format!("a/in.{format}")));
        folder.refuses("check out/in.planish.json", &[&format!("to.{format}: is not the file that")]);
        folder.write(&format!("a/in.{format}"), denoised);
        folder.refuses("check out/in.planish.json", &[&format!("in.{format}: is not the file that")]);
    }
}

#[test]
fn apply_takes_the_mesh_that_was_baked_only_while_it_is_that() {
    let folder = Folder::with("in.obj", Mesh::sphere(6).noisy(0.02).obj());
    folder.succeeds("denoise in.obj -o in.ply --method laplacian --iterations 0");
    folder.succeeds("bake in.ply -o out --method laplacian");
    let mesh = || folder.succeeds_with_json("apply out/in.planish.json -o applied.ply")["mesh"].clone();
    assert!(mesh().as_str().unwrap().ends_with("in.ply"));
    folder.refuses("apply out/in.planish.json -o in.ply", &["is an input"]);
    folder.succeeds("noise in.ply -o in2.ply --sigma 0.1");
    folder.write("in.ply", folder.bytes("in2.ply"));
    assert!(mesh().as_str().unwrap().ends_with("out/in.obj"));
    std::fs::remove_file(folder.path("in.ply")).unwrap();
    assert!(mesh().as_str().unwrap().ends_with("out/in.obj"));
}
