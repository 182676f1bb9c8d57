//! The files of a bake: what is in them, where they go, and that they are always the same.

use crate::folder::Folder;
use crate::mesh::Mesh;
use crate::reference::{Lines, statements};
use serde_json::json;
use std::path::Path;

#[test]
fn a_bake_writes_six_files_that_name_each_other() {
    let folder = Folder::with("scans/statue.obj", Mesh::sphere(4).noisy(0.05).obj());
    for (bits, map) in [(8, "png"), (16, "png"), (32, "exr")] {
        let out = format!("out{bits}");
        let printed = folder
            .succeeds_with_json(&format!("bake scans/statue.obj --method laplacian -o {out} --bits {bits} --size 128"));
        let map = format!("statue.displacement.{map}");
        let names = [&map, "statue.glb", "statue.mtl", "statue.normal.png", "statue.obj", "statue.planish.json"];
        assert_eq!(folder.names(&out), names);
        let mut written: Vec<&str> = printed["files"].as_array().unwrap().iter().filter_map(|f| f.as_str()).collect();
        written.sort_unstable();
        assert_eq!(written, names.map(|name| format!("{out}/{name}")));

        let manifest = folder.json(&format!("{out}/statue.planish.json"));
        assert_eq!(printed["manifest"], manifest);
        assert_eq!(manifest["source"]["file"], "../scans/statue.obj", "relative to the manifest");
        let entry = &manifest["displacement"];
        assert_eq!((&entry["file"], &entry["bits"]), (&json!(map), &json!(bits)));
        assert_eq!((&entry["width"], &entry["height"]), (&json!(128), &json!(128)));
        assert_eq!(
            manifest["normal_map"],
            json!({ "file": "statue.normal.png", "width": 128, "height": 128, "convention": "opengl" })
        );
        assert_eq!((&manifest["carrier"]["obj"], &manifest["carrier"]["mtl"]), (&json!(names[4]), &json!(names[2])));
    }
}

#[test]
fn the_folder_has_a_default_and_the_size_a_reason() {
    let folder = Folder::with("scans/statue.obj", Mesh::grid(8).noisy(0.01).obj());
    let printed = folder.succeeds_with_json("bake scans/statue.obj --method laplacian");
    assert_eq!(folder.names("."), ["scans", "statue-planish"]);
    let reason = printed["size_reason"].as_str().unwrap();
    assert!(reason.starts_with(&printed["manifest"]["displacement"]["width"].to_string()), "{reason}");
    let printed = folder.succeeds_with_json("bake scans/statue.obj --method laplacian --size 100");
    assert_eq!((&printed["size_reason"], &printed["manifest"]["displacement"]["width"]), (&json!(null), &json!(100)));
}

#[test]
fn the_result_of_any_denoiser_can_be_baked() {
    let folder = Folder::with("in.obj", Mesh::sphere(3).noisy(0.05).obj());
    folder.succeeds("denoise in.obj -o smooth.obj --method laplacian --iterations 7");
    let options = "--size 256 --weld exact";
    let target = folder.succeeds_with_json(&format!("bake in.obj -o target --target smooth.obj {options}"));
    folder.succeeds(&format!("bake in.obj -o method --method laplacian --iterations 7 {options}"));
    for name in ["in.displacement.png", "in.normal.png", "in.obj"] {
        assert!(folder.bytes(&format!("target/{name}")) == folder.bytes(&format!("method/{name}")), "{name}");
    }
    let method = &target["manifest"]["method"];
    assert_eq!((&method["name"], &method["file"]), (&json!("target"), &json!("../smooth.obj")));
    folder.succeeds("apply target/in.planish.json -o out.obj");

    folder.write("other.obj", Mesh::grid(3).obj());
    folder.refuses("bake in.obj --target other.obj", &["other.obj", "16 `v` lines", "in.obj"]);
    folder.refuses_usage("bake in.obj --target smooth.obj --iterations 3", &["--target", "--iterations"]);
}

#[test]
fn a_method_of_a_later_version_does_not_stop_the_map() {
    let folder = Folder::with("in.obj", Mesh::grid(4).noisy(0.05).obj());
    folder.succeeds("bake in.obj --method laplacian -o out");
    let mut manifest = folder.json("out/in.planish.json");
    manifest["method"] = json!({ "name": "clairvoyance", "depth": 3 });
    folder.write("out/in.planish.json", manifest.to_string());
    folder.succeeds("apply out/in.planish.json -o out.obj");
}

#[test]
fn the_manifest_holds_every_setting_defaults_included() {
    let folder = Folder::with("in.obj", Mesh::grid(4).obj());
    let method = |printed: &serde_json::Value| {
        let m = &printed["manifest"];
        json!([
            m["method"],
            m["welding"],
            m["normals"],
            m["displacement"]["interpolation"],
            m["displacement"]["texels"],
            m["displacement"]["lambda"]
        ])
    };
    let name = "laplacian";
    assert_eq!(
        method(&folder.succeeds_with_json("bake in.obj --method laplacian")),
        json!([
            { "name": name, "iterations": 3, "step": 0.5, "weights": "uniform", "boundary": "fixed" },
            "exact", "angle", "barycentric", "fitted", 1.0
        ])
    );
    let options = "--method laplacian --iterations 7 --step 0.25 --weights cotangent --boundary free --weld 0.001 --normals area \
                   --interpolation natural --texels interpolated --lambda -0.5";
    assert_eq!(
        method(&folder.succeeds_with_json(&format!("bake in.obj {options}"))),
        json!([
            { "name": name, "iterations": 7, "step": 0.25, "weights": "cotangent", "boundary": "free" },
            { "epsilon": 0.001 }, "area", "natural", "interpolated", -0.5
        ])
    );
}

#[test]
fn the_green_of_the_normal_map_follows_the_convention() {
    let folder = Folder::with("in.obj", Mesh::grid(8).noisy(0.03).obj());
    for convention in ["opengl", "directx"] {
        folder.succeeds(&format!("bake in.obj --method laplacian -o {convention} --normal-convention {convention}"));
        let manifest = folder.json(&format!("{convention}/in.planish.json"));
        assert_eq!(manifest["normal_map"]["convention"], convention);
    }
    let [up, down] = ["opengl", "directx"].map(|c| folder.contents(c));
    let differing: Vec<_> =
        up.keys().filter(|name| up[*name] != down[*name]).map(|n| n.display().to_string()).collect();
    assert_eq!(differing, ["in.glb", "in.normal.png", "in.planish.json"]);
}

#[test]
fn the_carrier_is_the_mesh_with_one_normal_for_each_vertex() {
    let mesh = Mesh::sphere(6).noisy(0.05).split_at_seams().with_defects();
    let source = mesh.obj() + "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n";
    let folder = Folder::with("in.obj", &source);
    folder.succeeds("bake in.obj --method laplacian -o out");
    let carrier = folder.text("out/in.obj");
    for keyword in ["v", "vt"] {
        assert!(statements(&carrier, keyword) == statements(&source, keyword), "{keyword}");
    }
    let (carrier, source) = (Lines::of(&carrier), Lines::of(&source));
    assert_eq!(carrier.normals.len(), carrier.positions.len());
    for (made, given) in carrier.faces.iter().zip(&source.faces) {
        let expected: Vec<_> = given.iter().map(|[v, vt, _]| [*v, *vt, *v]).collect();
        assert_eq!(*made, expected);
    }
    for n in &carrier.normals {
        // Rounded to single precision: three components off by 2⁻²⁵ each.
        assert!((n.length() - 1.0).abs() < 1e-7, "{n}");
    }
}

/// A mesh in two materials, with textures where the library says.
fn textured() -> Folder {
    let mesh = Mesh::sphere(4).noisy(0.05).obj();
    let (vertices, faces) = mesh.split_at(mesh.find("f ").unwrap());
    let second = faces.match_indices('\n').nth(9).unwrap().0 + 1;
    let (first, second) = faces.split_at(second);
    let obj = format!(
        "# scanned\nmtllib the statue.mtl\no statue\n{vertices}g head\nusemtl skin\n{first}g body\nusemtl stone\n{second}"
    );
    let library = "newmtl skin\nKd 1 0.5 0.5\nmap_Kd textures/skin colour.png\nbump old bump.png\n\n\
                   newmtl stone\nmap_Kd -s 2 2 1 textures/stone.png\nmap_Ks missing.png\ndisp old.png\n";
    let folder = Folder::with("scans/statue.obj", obj);
    folder.write("scans/the statue.mtl", library);
    folder.write("scans/textures/skin colour.png", "");
    folder.write("scans/textures/stone.png", "");
    folder
}

#[test]
fn the_materials_of_the_carrier_name_the_maps_and_find_their_textures() {
    let folder = textured();
    let printed = folder.succeeds_with_json("bake scans/statue.obj --method laplacian -o out/deep --lambda 0.5");
    let library = folder.text("out/deep/statue.mtl");
    let client = &printed["manifest"]["clients"]["mtl"];
    let materials: Vec<&str> = library.split("newmtl ").skip(1).collect();
    assert!(materials[0].starts_with("skin\n") && materials[1].starts_with("stone\n"), "{library}");
    for material in &materials {
        let disp = statements(material, "disp");
        let [words] = disp.as_slice() else { panic!("{material}") };
        let words: Vec<&str> = words.split(' ').collect();
        assert_eq!([words[1], words[4]], ["-mm", "statue.displacement.png"], "{material}");
        let numbers = [2, 3].map(|k| words[k].parse::<f64>().unwrap());
        assert_eq!(json!(numbers), json!([client["base"], client["gain"]]), "{material}");
        assert_eq!(statements(material, "norm"), ["norm statue.normal.png"], "{material}");
        assert!(statements(material, "bump").is_empty(), "{material}");
    }
    let textures: Vec<&str> = statements(&library, "map_Kd").iter().map(|line| &line["map_Kd ".len()..]).collect();
    assert_eq!(textures, ["../../scans/textures/skin colour.png", "-s 2 2 1 ../../scans/textures/stone.png"]);
    for texture in textures {
        let file = texture.trim_start_matches("-s 2 2 1 ");
        assert!(folder.path("out/deep").join(file).is_file(), "{file}");
    }
    assert_eq!(statements(&library, "map_Ks"), ["map_Ks missing.png"], "what is not there stays as it was written");
}

#[test]
fn the_carrier_keeps_groups_and_materials() {
    let folder = textured();
    folder.succeeds("bake scans/statue.obj --method laplacian -o out");
    let (carrier, source) = (folder.text("out/statue.obj"), folder.text("scans/statue.obj"));
    for keyword in ["#", "o", "g", "usemtl"] {
        assert!(!statements(&source, keyword).is_empty());
        assert_eq!(statements(&carrier, keyword), statements(&source, keyword));
    }
    assert_eq!(statements(&carrier, "mtllib"), ["mtllib statue.mtl"]);
    let order = |text: &str| -> Vec<String> {
        let kept = |line: &&str| ["v ", "vt ", "f ", "g ", "usemtl "].iter().any(|k| line.starts_with(k));
        text.lines().filter(kept).map(|line| line.split(' ').next().unwrap().to_owned()).collect()
    };
    assert!(order(&carrier) == order(&source));
}

#[test]
fn faces_without_a_material_get_one() {
    let folder = Folder::with("in.obj", Mesh::grid(2).obj());
    folder.succeeds("bake in.obj --method laplacian -o out");
    assert_eq!(statements(&folder.text("out/in.obj"), "usemtl"), ["usemtl planish"]);
    assert_eq!(statements(&folder.text("out/in.mtl"), "newmtl"), ["newmtl planish"]);
}

#[test]
fn a_bake_into_the_folder_of_the_mesh_spares_the_mesh() {
    let folder = textured();
    let before = folder.contents("scans");
    for _ in 0..2 {
        folder.succeeds("bake scans/statue.obj --method laplacian -o scans");
        let after = folder.contents("scans");
        assert!(before.iter().all(|(name, bytes)| after[name] == *bytes));
        let added: Vec<_> =
            after.keys().filter(|name| !before.contains_key(*name)).map(|n| n.display().to_string()).collect();
        let names = ["displacement.png", "normal.png", "planish.glb", "planish.json", "planish.mtl", "planish.obj"];
        assert_eq!(added, names.map(|name| format!("statue.{name}")));
    }
    folder.succeeds("apply scans/statue.planish.json -o applied.obj");
    // From inside as well, where the folder has no name.
    folder.write("in.obj", Mesh::grid(2).obj());
    folder.succeeds("bake in.obj --method laplacian -o .");
    assert_eq!(folder.text("in.obj"), Mesh::grid(2).obj());
}

#[test]
fn no_input_is_written_over() {
    // The library of the mesh lies where the carrier's would go, and a texture where the normal map would.
    let folder = textured();
    let obj = folder.text("scans/statue.obj").replace("the statue.mtl", "../out/statue.mtl");
    folder.write("scans/statue.obj", obj);
    folder.write("out/statue.mtl", "newmtl skin\nmap_Kd statue.normal.png\nnewmtl stone\n");
    folder.refuses("bake scans/statue.obj -o out", &["out/statue.mtl", "is an input"]);
    folder.write("scans/statue.mtl", "newmtl skin\nmap_Kd statue.normal.png\nnewmtl stone\n");
    folder.write("scans/statue.normal.png", "");
    folder.write("scans/statue.obj", folder.text("scans/statue.obj").replace("../out/statue.mtl", "statue.mtl"));
    folder.refuses("bake scans/statue.obj -o scans", &["scans/statue.normal.png", "is an input"]);
}

#[test]
fn baking_twice_gives_the_same_bytes() {
    let folder = textured();
    folder.succeeds("bake scans/statue.obj --method laplacian -o out");
    let first = folder.contents("out");
    folder.succeeds("bake scans/statue.obj --method laplacian -o out");
    assert!(folder.contents("out") == first);
    // Files of somebody else stay.
    folder.write("out/notes.txt", "mine");
    folder.succeeds("bake scans/statue.obj --method laplacian -o out --bits 8");
    assert_eq!(folder.text("out/notes.txt"), "mine");
    assert!(folder.contents("out") != first);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = Folder::with("in.obj", Mesh::sphere(24).noisy(0.02).split_at_seams().with_defects().obj());
    let jobs = ["barycentric", "natural", "idw", "nearest"]
        .map(|i| format!("bake in.obj --method laplacian -o out --size 128 --interpolation {i}"));
    let denoise =
        |weights| format!("denoise in.obj -o out/x.obj --method laplacian --iterations 20 --weights {weights}");
    let jobs = jobs.into_iter().chain(["uniform", "cotangent"].map(denoise));
    for job in jobs {
        let on = |threads: &str| {
            let output = folder.planish(&job).env("RAYON_NUM_THREADS", threads).output().unwrap();
            assert!(output.status.success(), "{job}");
            let contents = folder.contents("out");
            std::fs::remove_dir_all(folder.path("out")).unwrap();
            contents
        };
        let one = on("1");
        assert!(one.contains_key(Path::new("in.planish.json")) || one.contains_key(Path::new("x.obj")), "{job}");
        for threads in ["2", "7"] {
            assert!(on(threads) == one, "{job} on {threads} threads");
        }
    }
}
