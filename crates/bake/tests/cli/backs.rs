//! Leaves and sheets, both sides of which are in the mesh.

use crate::folder::Folder;
use serde_json::Value;

/// A rough sheet with a back, whose faces name other `v` and `vt` lines than those in front, or the same.
fn leaf(has_own_vertices: bool, has_own_uvs: bool) -> String {
    let mut obj = String::new();
    let [mut front, mut back] = [(); 2].map(|()| String::new());
    let count = 49;
    for side in 0..2 {
        for i in 0..count {
            let [x, y] = [i % 7, i / 7].map(f64::from);
            let z = 0.1 * f64::from(i * i % 11);
            obj += &format!("v {x} {y} {z}\nvt {} {}\n", 0.02 + 0.06 * x + 0.5 * f64::from(side), 0.02 + 0.06 * y);
        }
    }
    for i in (0..count - 7).filter(|i| i % 7 < 6) {
        let corners = [i + 1, i + 2, i + 9, i + 8];
        let other = |own: bool| if own { count } else { 0 };
        let corner = |v: i32| format!(" {}/{}", v + other(has_own_vertices), v + other(has_own_uvs));
        front += &format!("f{}\n", corners.map(|v| format!(" {v}/{v}")).concat());
        let [a, b, c, d] = corners.map(corner);
        back += &format!("f{d}{c}{b}{a}\n");
    }
    obj + &front + &back
}

/// Number of triangles of a binary glTF file.
fn triangles(folder: &Folder, name: &str) -> u64 {
    let glb = folder.bytes(name);
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
    let indices = primitives.iter().map(|primitive| primitive["indices"].as_u64().unwrap() as usize);
    indices.map(|accessor| document["accessors"][accessor]["count"].as_u64().unwrap() / 3).sum()
}

#[test]
fn a_leaf_with_two_sides_is_baked_and_applied_on_both() {
    let folder = Folder::with("in.obj", leaf(true, true));
    let baked = folder.succeeds_with_json("bake in.obj -o out --method laplacian");
    let manifest = &baked["manifest"];
    assert_eq!((&manifest["planish"], &manifest["backs"]), (&5.into(), &"50-98".into()));
    assert_eq!(manifest["report"]["unresolved_vertices"], 0);
    assert!(manifest["normal_map"].is_object(), "{baked}");
    let said = folder.succeeds("bake in.obj -o out --method laplacian").err;
    assert!(!said.contains("back"), "{said}");
    assert_eq!(triangles(&folder, "out/in.glb"), 144);
    folder.succeeds("check out/in.planish.json");
    // Applied to the mesh and to its carrier, the map leads to the same places on both sides.
    folder.succeeds("apply out/in.planish.json -o own.obj --mesh in.obj");
    folder.succeeds("apply out/in.planish.json -o carried.obj");
    let positions = |name: &str| -> Vec<[f64; 3]> {
        let text = folder.text(name);
        let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
        lines.map(|line| std::array::from_fn(|k| line.split(' ').nth(k).unwrap().parse().unwrap())).collect()
    };
    let near = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    let (own, carried) = (positions("own.obj"), positions("carried.obj"));
    assert!(own.iter().zip(&carried).all(|(a, b)| near(a, b)));
    assert!(own[..49].iter().zip(&own[49..]).all(|(a, b)| near(a, b)));
    let noisy = positions("in.obj");
    assert!(!own.iter().zip(&noisy).all(|(a, b)| near(a, b)));
}

#[test]
fn backs_that_share_with_their_fronts_are_in_the_binary_gltf_and_told() {
    for (has_own_vertices, has_own_uvs) in [(false, true), (true, false), (false, false)] {
        let folder = Folder::with("in.obj", leaf(has_own_vertices, has_own_uvs));
        let said = folder.succeeds("bake in.obj -o out --method laplacian").err;
        assert!(said.contains("36 faces are backs of others with which they share vertices or texels"), "{said}");
        assert_eq!(triangles(&folder, "out/in.glb"), 144);
        folder.succeeds("check out/in.planish.json");
    }
}
