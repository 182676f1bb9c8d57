use super::*;
use crate::source::Source;
use crate::source::read_error::ReadErrorKind;
use glam::{DQuat, DVec2};
use proptest::prelude::*;
use serde_json::json;
use std::f64::consts::FRAC_1_SQRT_2;

/// A square in single precision, split along its diagonal as at a seam, with normals and texture coordinates, interleaved: six
/// vertices of 32 bytes and six indices of 16 bits. Then a triangle of three positions as normalised whole numbers of 16 bits.
fn buffer() -> Vec<u8> {
    let mut out = Vec::new();
    let corners =
        [[0.0, 0.0, 0.1], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for (i, p) in corners.iter().enumerate() {
        let uv = [p[0] * 0.5 + f32::from(u8::from(i > 2)) * 0.5, p[1]];
        p.iter().chain(&[0.0, 0.0, 1.0]).chain(&uv).for_each(|x: &f32| out.extend(x.to_le_bytes()));
    }
    (0..6_u16).for_each(|i| out.extend(i.to_le_bytes()));
    for p in [[0_i16, 0, 0], [32767, 0, 0], [0, -32767, 16384]] {
        p.iter().for_each(|x| out.extend(x.to_le_bytes()));
        out.extend([0xaa, 0xbb]);
    }
    out
}

/// A scene with the square twice, under a parent, and the triangle.
fn document() -> Value {
    let interleaved = |offset: usize, kind: &str| json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": 6, "type": kind });
    let mut position = interleaved(0, "VEC3");
    position["min"] = json!([0.0, 0.0, 0.0]);
    position["max"] = json!([1.0, 1.0, 0.1]);
    json!({
        "asset": { "version": "2.0", "generator": "a test" },
        "extras": { "kept": [1, 2.50, "three"] },
        "scene": 0,
        "scenes": [{ "nodes": [0, 3] }],
        "nodes": [
            { "children": [1, 2], "translation": [10.0, 0.0, 0.0] },
            { "mesh": 0, "rotation": [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], "scale": [2.0, 2.0, 2.0] },
            { "mesh": 0, "translation": [0.0, 5.0, 0.0] },
            { "mesh": 1 },
        ],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "material": 1 }] },
            { "primitives": [{ "attributes": { "POSITION": 4 } }, { "attributes": { "POSITION": 4 }, "mode": 0 }] },
        ],
        "materials": [
            { "name": "bare" },
            { "name": "skin", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1.0, 1.0], "baseColorTexture": { "index": 0 } } },
        ],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "data:image/png;base64,iVBORw==" }],
        "accessors": [
            position, interleaved(12, "VEC3"), interleaved(24, "VEC2"),
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3", "min": [0, -32767, 0], "max": [32767, 0, 16384] },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 192, "byteStride": 32 },
            { "buffer": 0, "byteOffset": 192, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 204, "byteLength": 24, "byteStride": 8 },
        ],
        "buffers": [{ "byteLength": 228 }],
    })
}

/// A binary file. Its JSON is spelled with blanks, as few programs do, and a chunk that nobody knows follows.
fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = serde_json::to_string_pretty(document).unwrap().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunks = Vec::new();
    for (kind, bytes) in [(b"JSON", json.as_slice()), (b"BIN\0", buffer), (b"XTRA", &[1, 2, 3, 4])] {
        chunks.extend((bytes.len() as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(bytes);
    }
    [&b"glTF\x02\0\0\0"[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

fn everything() -> Vec<u8> {
    glb(&document(), &buffer())
}

fn parse(bytes: &[u8]) -> Gltf {
    Gltf::parse(bytes.to_vec(), &|_| None).unwrap()
}

fn error(document: &Value) -> String {
    Gltf::parse(glb(document, &buffer()), &|_| None).unwrap_err().to_string()
}

#[test]
fn meshes_stand_where_their_nodes_put_them() {
    let gltf = parse(&everything());
    let data = gltf.data();
    assert_eq!((data.positions().len(), data.faces().len()), (9, 3));
    let expected =
        DVec3::new(10.0, 0.0, 0.0) + DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * (DVec3::new(2.0, 0.0, 0.0));
    assert!(data.positions()[1].distance(expected) < 1e-12, "{}", data.positions()[1]);
    assert_eq!(data.positions()[8], DVec3::new(0.0, -1.0, 16384.0 / 32767.0));
    assert!((data.normals()[0].normalize() - DVec3::Z).length() < 1e-12);
    assert_eq!(data.uvs()[2], DVec2::new(0.5, 0.0), "v is up");
    let corner = data.faces().get(1)[2];
    assert_eq!((corner.position, corner.uv(), corner.normal()), (5, Some(5), Some(5)));
    assert_eq!(data.materials(), [b"bare".to_vec(), b"skin".to_vec()]);
    assert_eq!([0, 1, 2].map(|f| data.face_material(f)), [Some(1), Some(1), None]);
    let notes = gltf.notes().join("; ");
    assert!(notes.contains("shows a mesh several times") && notes.contains("1 primitive of points"), "{notes}");
    assert_eq!(gltf.embedded_texture("image-0.png").unwrap(), [0x89, b'P', b'N', b'G']);
    let library = String::from_utf8(gltf.embedded_library()).unwrap();
    assert_eq!(library, "newmtl bare\nnewmtl skin\nKd 0.5 0.25 1\nmap_Kd image-0.png\n");
}

#[test]
fn nothing_changes_where_nothing_moves() {
    let bytes = everything();
    let gltf = parse(&bytes);
    assert_eq!(gltf.with_positions(gltf.data().positions(), Some(gltf.data().normals())), bytes);
}

#[test]
fn moved_vertices_change_their_numbers_and_the_bounds_alone() {
    let bytes = everything();
    let gltf = parse(&bytes);
    let mut moved = gltf.data().positions().to_vec();
    // In the numbers of the file: z from 0 to −0.5, under a scale of two.
    moved[1].z = -1.0;
    let out = gltf.with_positions(&moved, None);
    let text = String::from_utf8_lossy(&out).into_owned();
    let again = parse(&out);
    assert!((again.data().positions()[1] - moved[1]).length() < 1e-6);
    assert_eq!(again.document["accessors"][0]["min"], json!([0.0, 0.0, -0.5]));
    assert_eq!(again.document["accessors"][0]["max"], json!([1.0, 1.0, 0.1]));
    assert_eq!(again.document["accessors"][4], document()["accessors"][4]);
    assert!(text.contains("\"min\": [0.0,0.0,-0.5]"), "the span of the bounds alone is replaced");
    assert_eq!(u32::from_le_bytes(out[8..12].try_into().unwrap()) as usize, out.len());
    assert_eq!(out[out.len() - 12..], *b"\x04\0\0\0XTRA\x01\x02\x03\x04");
    let (before, after) = (gltf.container.buffer(0), again.container.buffer(0));
    let changed: Vec<usize> = (0..before.len()).filter(|&i| before[i] != after[i]).collect();
    assert!(changed.iter().all(|i| (40..44).contains(i)), "z of vertex 1: {changed:?}");
    // All other lines of the JSON are the same.
    let lines = |gltf: &Gltf| String::from_utf8(gltf.container.json().to_vec()).unwrap();
    let (before, after) = (lines(&gltf), lines(&again));
    let kept = before.lines().filter(|line| after.lines().any(|other| other.trim_end() == line.trim_end())).count();
    assert!(before.lines().count() - kept <= 5, "{kept} of {} lines", before.lines().count());
}

#[test]
fn whole_numbers_stay_whole_and_the_rounding_is_told() {
    let source = Source::parse(everything(), None).unwrap();
    let mut moved = source.data().positions().to_vec();
    moved[8] = DVec3::new(0.3, -1.5, 0.5);
    let written = source.written_as(Format::Glb, &moved, None);
    let again = parse(&written.bytes);
    let held = again.data().positions()[8];
    assert_eq!(held, DVec3::new(9830.0 / 32767.0, -1.0, 16384.0 / 32767.0), "ends at the limits of the type");
    assert!((written.rounding - held.distance(moved[8])).abs() < 1e-12, "{}", written.rounding);
    assert_eq!(again.document["accessors"][4]["max"], json!([32767, 0, 16384]));
    assert_eq!(again.container.buffer(0)[204 + 6..204 + 8], [0xaa, 0xbb], "bytes between the values");
}

#[test]
fn normals_change_where_they_are_given() {
    let gltf = parse(&everything());
    let mut normals = gltf.data().normals().to_vec();
    normals[2] = DVec3::Y;
    let out = parse(&gltf.with_positions(gltf.data().positions(), Some(&normals)));
    assert!((out.data().normals()[2].normalize() - DVec3::Y).length() < 1e-6, "{}", out.data().normals()[2]);
    let accessor = &out.normals[0].accessor;
    let stored = DVec3::from_array([0, 1, 2].map(|k| accessor.get(out.container.buffer(0), 2, k)));
    assert!((stored - DVec3::X).length() < 1e-6, "the node turns it by 90°: {stored}");
}

#[test]
fn json_with_buffers_beside_it_takes_them_in_where_they_change() {
    let mut document = document();
    document["buffers"][0]["uri"] = "my%20data.bin".into();
    let text = serde_json::to_vec_pretty(&document).unwrap();
    let beside = |path: &str| (path == "my data.bin").then(buffer);
    let source = Source::parse_beside(text.clone(), Some(Format::Gltf), &beside).unwrap();
    assert_eq!(source.bytes().len(), text.len() + buffer().len(), "both identify the mesh");
    let written = source.written_as(Format::Gltf, source.data().positions(), None);
    assert_eq!(written.bytes, text);
    let mut moved = source.data().positions().to_vec();
    moved[7].x -= 0.25;
    let written = source.written_as(Format::Gltf, &moved, None).bytes;
    let again = Source::parse(written, None).unwrap();
    assert!((again.data().positions()[7] - moved[7]).length() < 1e-4);
    assert_eq!(again.data().positions()[..7], moved[..7]);
    let missing = Source::parse(text, None).unwrap_err().to_string();
    assert_eq!(missing, "buffer 0: the file my data.bin cannot be read");
}

#[test]
fn meshes_that_share_all_numbers_are_one() {
    let mut document = document();
    let copy = document["meshes"][0].clone();
    document["meshes"].as_array_mut().unwrap().push(copy);
    document["nodes"][2]["mesh"] = 2.into();
    let gltf = parse(&glb(&document, &buffer()));
    assert_eq!(gltf.data().faces().len(), 3);
    assert!(gltf.notes()[0].starts_with("1 × a primitive has the numbers of an earlier one"), "{:?}", gltf.notes());
}

#[test]
fn strips_and_fans_become_triangles() {
    let faces = |mode: u64| -> Vec<Vec<u32>> {
        let mut document = document();
        document["meshes"][0]["primitives"][0]["mode"] = mode.into();
        document["accessors"][3]["count"] = 5.into();
        let gltf = parse(&glb(&document, &buffer()));
        gltf.data().faces().iter().take(3).map(|f| f.iter().map(|c| c.position).collect()).collect()
    };
    assert_eq!(faces(5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(faces(6), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
}

#[test]
fn skinned_meshes_ignore_their_nodes_and_a_file_without_a_scene_shows_its_roots() {
    let mut document = document();
    document["nodes"][1]["skin"] = 0.into();
    assert_eq!(parse(&glb(&document, &buffer())).data().positions()[1], DVec3::X);
    document["scenes"] = json!([]);
    assert_eq!(parse(&glb(&document, &buffer())).data().positions().len(), 9);
    document["scenes"] = json!([{ "nodes": [3] }]);
    let gltf = parse(&glb(&document, &buffer()));
    assert_eq!(gltf.data().positions().len(), 3);
    assert!(gltf.notes()[0].starts_with("1 of 2 meshes are not in the scene"), "{:?}", gltf.notes());
    document["nodes"] = json!([]);
    document["scenes"] = json!([]);
    assert_eq!(parse(&glb(&document, &buffer())).data().positions().len(), 9, "no node has a mesh");
    // A circle of nodes ends.
    document["nodes"] = json!([{ "children": [1] }, { "children": [0], "mesh": 1 }]);
    document["scenes"] = json!([{ "nodes": [0] }]);
    assert_eq!(parse(&glb(&document, &buffer())).data().positions().len(), 3);
}

#[test]
fn what_is_not_read_is_refused_by_name() {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut document = document();
        change(&mut document);
        error(&document)
    };
    let draco = with(&|d| d["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} }));
    assert_eq!(draco, "the file uses Draco compression (KHR_draco_mesh_compression), which planish does not read");
    let meshopt = with(&|d| d["bufferViews"][0]["extensions"] = json!({ "EXT_meshopt_compression": {} }));
    assert_eq!(meshopt, "the file uses meshopt compression (EXT_meshopt_compression), which planish does not read");
    let sparse = with(&|d| d["accessors"][0]["sparse"] = json!({ "count": 1 }));
    assert_eq!(sparse, "the file uses a sparse accessor (0, POSITION), which planish does not read");
    assert_eq!(
        with(&|d| d["asset"]["version"] = "1.0".into()),
        "the file uses glTF of version 1.0, which planish does not read"
    );
}

#[test]
fn errors_name_the_part_of_the_document() {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut document = document();
        change(&mut document);
        error(&document)
    };
    let count = with(&|d| d["accessors"][0]["count"] = 4_000_000_000_u64.into());
    assert_eq!(
        count,
        "the file promises 4000000000 × `POSITION of accessor 0`, which need 127999999980 bytes or more, and has 192 left"
    );
    let indices = with(&|d| d["accessors"][3]["count"] = json!(7));
    assert!(indices.contains("`indices of accessor 3`"), "{indices}");
    let missing = with(&|d| d["meshes"][0]["primitives"][0]["attributes"] = json!({}));
    assert_eq!(missing, "mesh 0, primitive 0: it has no `POSITION`");
    let view = with(&|d| d["bufferViews"][0]["byteLength"] = 1000.into());
    assert_eq!(view, "accessor 0 (POSITION): its buffer view is larger than its buffer");
    let mesh = with(&|d| d["nodes"][3]["mesh"] = 9.into());
    assert_eq!(mesh, "node 3: mesh 9 does not exist");
}

#[test]
fn indices_that_share_bytes_with_positions_are_refused() {
    let mut document = document();
    // The first six bytes are zero, as positions and as indices.
    document["bufferViews"][1]["byteOffset"] = 0.into();
    document["accessors"][3]["count"] = 3.into();
    assert_eq!(error(&document), "accessor 0 shares bytes with accessor 3, the indices of faces");
}

#[test]
fn indices_out_of_range_name_the_face() {
    let mut document = document();
    document["accessors"][0]["count"] = 4.into();
    assert_eq!(error(&document), "face 1 names vertex 4: there are 4, counted from 0");
}

#[test]
fn a_cut_file_is_refused_wherever_it_is_cut() {
    let bytes = everything();
    let whole = bytes.len() - 12;
    for end in (0..whole).step_by(7) {
        assert!(Gltf::parse(bytes[..end].to_vec(), &|_| None).is_err(), "{end}");
    }
    assert_eq!(Gltf::parse(Vec::new(), &|_| None).unwrap_err().kind, ReadErrorKind::Empty);
}

#[test]
fn meshes_from_elsewhere_are_printed() {
    let obj = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0.5 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
               usemtl a b\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let source = Source::parse(obj.into(), None).unwrap();
    for format in [Format::Glb, Format::Gltf] {
        let written = source.written_as(format, source.data().positions(), None);
        let lost = ["polygons, which are cut into triangles", "colours and textures of materials, whose names stay"];
        assert_eq!((written.rounding, written.lost.as_slice()), (0.0, &lost.map(str::to_owned)[..]));
        let again = Source::parse(written.bytes, None).unwrap();
        assert_eq!(again.format(), format);
        let (a, b) = (again.data(), source.data());
        assert_eq!((a.positions(), a.uvs(), a.colours()), (b.positions(), b.uvs(), b.colours()));
        assert_eq!((a.normals()[0], a.materials(), a.face_material(0)), (DVec3::Z, b.materials(), Some(0)));
    }
}

#[test]
fn meshes_far_from_the_origin_keep_their_detail() {
    let far = "v 500000.125 4500000.25 1\nv 500001 4500000 1\nv 500000 4500001.0625 1\nf 1 2 3\n";
    let source = Source::parse(far.into(), None).unwrap();
    let written = source.written_as(Format::Glb, source.data().positions(), None);
    assert_eq!(written.rounding, 0.0);
    assert_eq!(Source::parse(written.bytes, None).unwrap().data().positions(), source.data().positions());
}

proptest! {
    #[test]
    fn any_bytes_are_a_mesh_or_an_error(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = everything();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(gltf) = Gltf::parse(bytes.clone(), &|_| None) {
            prop_assert_eq!(gltf.with_positions(gltf.data().positions(), None), bytes);
        }
    }

    #[test]
    fn moved_vertices_come_back(moves in prop::collection::vec(prop::array::uniform3(-0.9_f64..0.9), 9)) {
        let gltf = parse(&everything());
        let moved: Vec<DVec3> = gltf.data().positions().iter().zip(&moves).enumerate().map(|(v, (p, m))| {
            if v < 6 { *p + DVec3::from_array(*m) } else { DVec3::from_array(*m) }
        }).collect();
        let out = parse(&gltf.with_positions(&moved, None));
        for (v, (p, q)) in out.data().positions().iter().zip(&moved).enumerate() {
            let allowed = if v < 6 { 1e-5 } else { 1e-4 };
            prop_assert!(p.distance(*q) < allowed, "{}: {} {}", v, p, q);
            prop_assert_eq!(*p, gltf.held(v as u32, *q));
        }
    }
}
