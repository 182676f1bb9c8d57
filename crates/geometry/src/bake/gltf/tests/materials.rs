//! Materials and sides of a glTF file.

use super::*;
use std::cell::RefCell;

#[test]
fn materials_are_those_of_the_library_and_share_their_images() {
    let mut owned = Owned::new(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\nvt 0 0\nf 1/1 2/1 3/1\nusemtl skin\nf 1/1 2/1 4/1\nusemtl nails\n\
         f 2/1 3/1 4/1\nusemtl hair\nf 1/1 3/1 4/1\nusemtl lost\nf 1/1 4/1 3/1 2/1\nusemtl broken\nf 1/1 2/1 5/1\n",
    );
    let library = "newmtl skin\nKd 0.5 0.25 7\nmap_Kd a.jpg\nnewmtl hair\nmap_Kd a.jpg\nnewmtl nails\nKd -1 0 1\n\
                   map_Kd gone.png\nnewmtl broken\nKd nan 0 0\nmap_Kd a.txt\nnewmtl skin\nKd 0 0 0\n";
    owned.materials = crate::source::materials::read(library.as_bytes()).unwrap();
    let asked = RefCell::new(Vec::new());
    let files = |picture: Picture| {
        asked.borrow_mut().push(picture.name());
        match picture {
            Picture::File("a.jpg") => Some(b"\xff\xd8\xff.".to_vec()),
            Picture::File("a.txt") => Some(b"words".to_vec()),
            _ => None,
        }
    };
    let parsed = Parsed::new(&glb(&owned.carrier(), &files).unwrap());
    let shading = |name: &str| {
        let material = parsed.material(name);
        assert_eq!(material["doubleSided"], true);
        let shading = &material["pbrMetallicRoughness"];
        assert_eq!(shading["metallicFactor"], 0.0);
        (shading["baseColorFactor"].clone(), shading["baseColorTexture"]["index"].as_u64())
    };
    let grey = json!([0.8_f32, 0.8_f32, 0.8_f32, 1.0]);
    assert_eq!(shading("skin"), (json!([0.5, 0.25, 1.0, 1.0]), Some(1)));
    assert_eq!(shading("hair"), (json!([1.0, 1.0, 1.0, 1.0]), Some(1)));
    assert_eq!(shading("nails"), (json!([0.0, 0.0, 1.0, 1.0]), None));
    for name in ["lost", "broken", "planish"] {
        assert_eq!(shading(name), (grey.clone(), None), "{name}");
    }
    assert_eq!(parsed.json["images"].as_array().unwrap().len(), 2);
    assert_eq!(parsed.json["images"][1]["mimeType"], "image/jpeg");
    assert_eq!(*asked.borrow(), ["a.jpg", "gone.png", "a.txt"]);
}

#[test]
fn what_a_library_says_stands_where_gltf_has_it() {
    let names = ["lamp", "black", "leaf", "fern", "steel", "rough", "dull", "bumpy"];
    let vertices: String = (0..10).map(|i| format!("v {i} {} 0\n", i * i)).collect();
    let face = |(i, name): (u32, &str)| format!("usemtl {name}\nf {}/1 {}/1 {}/1\n", i, i + 1, i + 2);
    let faces: String = (1..).zip(names).map(face).collect();
    let mut owned = Owned::new(&format!("{vertices}vt 0 0\n{faces}"));
    let library = "newmtl lamp\nKe 1 2 4\nmap_Ke glow.png\nnewmtl black\nKe 0 0 0\nmap_Ke -clamp on glow.png\n\
                   newmtl leaf\nmap_Kd leaf.png\nmap_d leaf.png\nnewmtl fern\nmap_Kd fern.png\nmap_d holes.png\n\
                   newmtl steel\nPr 0.25\nPm 1\nmap_Pm m.png\nnewmtl rough\nmap_Pr gone.png\nPr 0.5\nPm 7\n\
                   newmtl dull\nKd 0.5 0.5 0.5\nmap_d gone.png\nnewmtl bumpy\nnorm n.png\nmap_Bump b.png\n";
    owned.materials = crate::source::materials::read(library.as_bytes()).unwrap();
    let asked = RefCell::new(Vec::new());
    let files = |picture: Picture| {
        asked.borrow_mut().push(picture.name());
        (!picture.name().contains("gone")).then(|| PNG.to_vec())
    };
    let parsed = Parsed::new(&glb(&owned.carrier(), &files).unwrap());
    let image = |texture: &Value| {
        let source = &parsed.json["textures"][texture["index"].as_u64().unwrap() as usize]["source"];
        parsed.json["images"][source.as_u64().unwrap() as usize]["name"].clone()
    };
    let [lamp, black, leaf, fern, steel, rough, dull, bumpy] = names.map(|name| parsed.material(name));
    assert_eq!(
        (&lamp["emissiveFactor"], image(&lamp["emissiveTexture"])),
        (&json!([0.25, 0.5, 1.0]), json!("glow.png"))
    );
    assert_eq!(
        (&black["emissiveFactor"], &black["emissiveTexture"]),
        (&json!([1.0, 1.0, 1.0]), &lamp["emissiveTexture"])
    );
    let colours = |material: &Value| image(&material["pbrMetallicRoughness"]["baseColorTexture"]);
    assert_eq!((&leaf["alphaMode"], colours(leaf)), (&json!("MASK"), json!("leaf.png")));
    assert_eq!((&fern["alphaMode"], colours(fern)), (&json!("MASK"), json!("fern.png + holes.png")));
    let surface = |material: &Value| {
        let shading = &material["pbrMetallicRoughness"];
        (shading["metallicFactor"].as_f64().unwrap(), shading["roughnessFactor"].as_f64().unwrap())
    };
    assert_eq!(
        (surface(steel), image(&steel["pbrMetallicRoughness"]["metallicRoughnessTexture"])),
        ((1.0, 0.25), json!("m.png"))
    );
    // Without its picture a material has its numbers.
    assert_eq!(
        (surface(rough), &rough["pbrMetallicRoughness"]["metallicRoughnessTexture"]),
        ((1.0, 0.5), &Value::Null)
    );
    assert_eq!((&dull["alphaMode"], surface(dull)), (&Value::Null, (0.0, 0.8)));
    // The normal map of the file is attached, that of the bake is described, and bumps have no place.
    assert_eq!(
        (image(&bumpy["normalTexture"]), &bumpy["extras"]["planish"]["normalMap"]["file"]),
        (json!("n.png"), &json!("n.png"))
    );
    assert!(!asked.borrow().contains(&"b.png".to_owned()), "{asked:?}");
    assert!(leaf["emissiveFactor"].is_null() && leaf["normalTexture"].is_null());
}

#[test]
fn a_back_that_shares_vertices_is_turned_round_with_its_map() {
    let front = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nf 1/1 2/1 3/1\nf 2 4 3\n";
    let mut owned = Owned::new(&format!("{front}usemtl back\nf 3/2 2/2 1/2\n"));
    owned.backs = Backs::of(&owned.model);
    assert_eq!(owned.backs.pairs(), [[2, 0]]);
    let parsed = owned.parsed();
    let (positions, normals) = (parsed.attribute::<3>("POSITION"), parsed.attribute::<3>("NORMAL"));
    let sides = |primitive: &Value| {
        let material = &parsed.json["materials"][primitive["material"].as_u64().unwrap() as usize];
        let triangles = parsed.triangles(primitive);
        for t in &triangles {
            let [a, b, c] = t.map(|k| Vec3::from(positions[k]));
            t.iter().for_each(|k| assert_eq!(Vec3::from(normals[*k]), (b - a).cross(c - a).normalize()));
        }
        let bias = material["extras"]["planish"]["displacement"]["bias"].as_f64().unwrap();
        (material["name"].clone(), material["doubleSided"].clone(), bias, triangles.len())
    };
    let found: Vec<_> = parsed.primitives().iter().map(sides).collect();
    let expected = [("planish", true, -0.5, 1), ("planish", false, -0.5, 1), ("back", false, 0.5, 1)];
    assert_eq!(found, expected.map(|(name, both, bias, count)| (json!(name), json!(both), bias, count)));
    // Both sides morph to the same places.
    let moves = parsed.target("POSITION");
    let moved = |k: usize| (positions[k], moves[k]);
    let [front, back] = [1, 2].map(|primitive: usize| parsed.triangles(&parsed.primitives()[primitive])[0]);
    assert_eq!(front.map(moved), [2, 1, 0].map(|k| moved(back[k])));
}
