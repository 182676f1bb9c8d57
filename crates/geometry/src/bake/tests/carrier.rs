//! Laws of the binary glTF carrier: what the source had stays, and every texture has the texture coordinates that belong to it.

use super::pages::{accessor, as_gltf, drawn, meshes, paged};
use super::*;
#[cfg(feature = "unwrap")]
use crate::map::displacement::Weights;
use crate::map::pages::PageRule;
use crate::map::{Size, per_vertex};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};

/// Charts that lie upon each other have private texels for heights, and no space for shading.
fn folded() -> Model {
    sheet_with_uvs(|p| DVec2::new((p.x - 0.35).abs(), p.y % 0.5))
}

fn list<'a>(document: &'a Value, name: &str) -> &'a [Value] {
    document[name].as_array().map_or(&[], Vec::as_slice)
}

fn at(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

#[test]
fn a_shading_map_with_a_texel_for_each_vertex_is_sampled_at_these_texels() {
    let in_tiles = sheet_with_uvs(|p| if p.x < 0.3 { p } else { p + DVec2::X });
    let as_mesh = |model: Model| [as_gltf(&model, |_| ()), model];
    let cases = as_mesh(folded()).into_iter().map(|model| (model, PageRule::None));
    for (model, rule) in cases.chain(as_mesh(in_tiles).into_iter().map(|model| (model, PageRule::Udim))) {
        let bundle = bake_of(&model, &BakeSettings { pages: rule, ..shaded() });
        let manifest = &bundle.manifest;
        let shading = &manifest.occlusion.as_ref().unwrap().map;
        assert_eq!((manifest.displacement.layout, shading.layout), (Layout::Uv, Layout::Vertex));
        let size = Size { width: shading.width, height: shading.height };
        let glb = bytes_of(&bundle, "sheet.glb");
        let document = document_of(glb);
        let mut texels = 0;
        for primitive in list(&document["meshes"][0], "primitives") {
            let material = &document["materials"][at(&primitive["material"])];
            let maps = &material["extras"]["planish"];
            assert_eq!(maps["displacement"]["texCoord"], 1);
            assert!(material["occlusionTexture"].is_null(), "between vertices the texels say nothing");
            for map in ["occlusion", "curvature"] {
                let places = &primitive["attributes"][format!("TEXCOORD_{}", maps[map]["texCoord"])];
                let places = accessor::<2>(glb, &document, places);
                let positions = accessor::<3>(glb, &document, &primitive["attributes"]["POSITION"]);
                for v in drawn(glb, &document, primitive) {
                    let place = Vec2::from(places[v]) * Vec2::new(size.width as f32, size.height as f32);
                    let texel = place.x as usize + place.y as usize * size.width as usize;
                    let own = model.data().positions()[texel] - manifest.displacement.origin;
                    assert_eq!(own.as_vec3(), Vec3::from(positions[v]), "{map} of {rule:?}");
                    texels += 1;
                }
            }
        }
        assert!(texels > 0);
        assert_eq!(size, per_vertex::size(model.data().positions().len()));
    }
}

#[test]
fn maps_in_the_texture_coordinates_of_the_mesh_name_their_set() {
    // The base colours are at the second set, and the first one is of something else.
    let change = |document: &mut Value| {
        let other = document["accessors"].as_array().unwrap().iter().position(|a| a["type"] == "VEC2").unwrap();
        for primitive in document["meshes"][0]["primitives"].as_array_mut().unwrap() {
            primitive["attributes"]["TEXCOORD_1"] = primitive["attributes"]["TEXCOORD_0"].clone();
            primitive["attributes"]["TEXCOORD_0"] = other.into();
        }
        for material in document["materials"].as_array_mut().unwrap() {
            material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0, "texCoord": 1 });
        }
        document["textures"] = json!([{}]);
    };
    let model = as_gltf(&Model::new(as_obj(&sheet()), Welding::Exact), change);
    let bundle = bake_of(&model, &shaded());
    assert_eq!(bundle.manifest.occlusion.as_ref().unwrap().map.layout, Layout::Uv);
    let document = document_of(bytes_of(&bundle, "sheet.glb"));
    for primitive in list(&document["meshes"][0], "primitives") {
        let material = &document["materials"][at(&primitive["material"])];
        let maps = &material["extras"]["planish"];
        let sets = ["displacement", "normalMap", "occlusion", "curvature"].map(|map| maps[map]["texCoord"].as_u64());
        assert_eq!(sets, [Some(2), Some(1), Some(1), Some(1)]);
        assert_eq!(material["occlusionTexture"]["texCoord"], 1);
        assert!(primitive["attributes"]["TEXCOORD_2"].is_u64());
    }
}

#[test]
fn pages_take_nothing_from_a_gltf_file() {
    let added = json!({
        "nodes": [{ "mesh": 0, "name": "a", "extras": { "by": "hand" } }, { "name": "bone" }, { "mesh": 0, "name": "again" }],
        "scenes": [{ "nodes": [0, 1, 2] }],
        "skins": [{ "joints": [1] }],
        "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }], "samplers": [] }],
        "cameras": [{ "type": "orthographic" }],
        "extensionsUsed": ["OF_ANOTHER"],
        "extras": { "note": [1, 2.5] },
    });
    for (name, model, rule, parts) in meshes() {
        let mut before = Value::Null;
        let model = as_gltf(&model, |document| {
            added.as_object().unwrap().iter().for_each(|(key, value)| document[key] = value.clone());
            for primitive in document["meshes"][0]["primitives"].as_array_mut().unwrap() {
                let own = primitive["attributes"]["POSITION"].clone();
                primitive["targets"] = json!([{ "POSITION": own }]);
                primitive["extras"] = "of the primitive".into();
            }
            document["meshes"][0]["weights"] = json!([0.25]);
            before = document.clone();
        });
        let bundle = bake_of(&model, &paged(rule));
        let after = document_of(bytes_of(&bundle, "sheet.glb"));
        for key in added.as_object().unwrap().keys() {
            assert_eq!(after[key], before[key], "{name}: {key}");
        }
        assert_eq!(after["meshes"][0]["weights"], json!([0.25, 1.0]));
        let [of_before, of_after] = [&before, &after].map(|document| list(&document["meshes"][0], "primitives"));
        let triangles = |document: &Value, primitives: &[Value]| -> u64 {
            primitives.iter().map(|p| document["accessors"][at(&p["indices"])]["count"].as_u64().unwrap()).sum()
        };
        assert_eq!(triangles(&after, of_after), triangles(&before, of_before), "{name}");
        assert!(of_after.len() >= parts.len(), "{name}");
        for primitive in of_after {
            assert_eq!(primitive["extras"], "of the primitive");
            assert_eq!(list(primitive, "targets").len(), 2);
            let own = &primitive["attributes"]["POSITION"];
            assert!(of_before.iter().any(|p| p["attributes"]["POSITION"] == *own));
            assert_eq!(primitive["targets"][0]["POSITION"], *own);
        }
        // A material that is on several pages has a copy for each.
        let names: Vec<&str> = list(&after, "materials").iter().map(|m| m["name"].as_str().unwrap()).collect();
        let mut distinct = names.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(names.len(), distinct.len(), "{names:?}");
    }
}

/// A box whose sides lie on one chart, as a glTF file with more than a mesh in it.
#[cfg(feature = "unwrap")]
fn rich_box() -> (Model, Value) {
    let surface = crate::mesh::shapes::gridded_box(4);
    let faces = surface.topology().faces();
    let uv = |p: &DVec3| DVec2::new(0.1 + 0.3 * p.x + 0.1 * p.z, 0.1 + 0.3 * p.y);
    let arrays = Arrays {
        positions: surface.positions().to_vec(),
        faces: faces.iter().map(<[Index]>::to_vec).collect(),
        uvs: surface.positions().iter().map(uv).collect(),
        corner_uvs: faces.items().iter().map(|v| Some(*v)).collect(),
        normals: surface.positions().iter().map(|p| (*p - DVec3::new(0.5, 1.0, 1.5)).normalize()).collect(),
        corner_normals: faces.items().iter().map(|v| Some(*v)).collect(),
        materials: vec!["front".into(), "back".into()],
        face_materials: (0..faces.len()).map(|f| Some((2 * f >= faces.len()).into())).collect(),
        ..Arrays::default()
    };
    let mut before = Value::Null;
    let model = as_gltf(&Model::new(MeshData::try_from(arrays).unwrap(), Welding::Exact), |document| {
        document["nodes"] = json!([{ "mesh": 0, "skin": 0, "extras": [1] }, { "name": "bone" }]);
        document["scenes"] = json!([{ "nodes": [0, 1] }]);
        document["skins"] = json!([{ "joints": [1] }]);
        let channel = json!({ "sampler": 0, "target": { "node": 1, "path": "translation" } });
        document["animations"] = json!([{ "channels": [channel], "samplers": [] }]);
        for primitive in document["meshes"][0]["primitives"].as_array_mut().unwrap() {
            primitive["attributes"]["_PLACE"] = primitive["attributes"]["POSITION"].clone();
            primitive["targets"] = json!([{ "POSITION": primitive["attributes"]["NORMAL"] }]);
            primitive["extras"] = "of the primitive".into();
        }
        document["meshes"][0]["weights"] = json!([0.25]);
        before = document.clone();
    });
    (model, before)
}

#[cfg(feature = "unwrap")]
#[test]
fn unwrapping_takes_nothing_from_a_gltf_file() {
    let (model, before) = rich_box();
    let bundle = bake_of(&model, &BakeSettings { layout: LayoutChoice::Unwrap, ..shaded() });
    let glb = bytes_of(&bundle, "sheet.glb");
    let after = document_of(glb);
    for key in ["nodes", "scenes", "skins", "animations"] {
        assert_eq!(after[key], before[key], "{key}");
    }
    assert_eq!(after["meshes"][0]["weights"], json!([0.25, 1.0]));
    let carrier = Obj::parse(bytes_of(&bundle, "sheet.obj").to_vec()).unwrap();
    let (data, unwrapped) = (model.data(), carrier.data());
    let entry = &bundle.manifest.displacement;
    let image =
        Displacement::decode(bytes_of(&bundle, &entry.file), entry.map, entry.size(), entry.encoding()).unwrap();
    let (mut corner, mut copies) = (0, 0);
    let mut seen = std::collections::BTreeMap::new();
    let primitives = list(&after["meshes"][0], "primitives");
    assert_eq!(primitives.len(), 2);
    for (primitive, old) in primitives.iter().zip(list(&before["meshes"][0], "primitives")) {
        assert_eq!((&primitive["extras"], &primitive["material"]), (&json!("of the primitive"), &old["material"]));
        let maps = &after["materials"][at(&primitive["material"])]["extras"]["planish"];
        let sets = ["displacement", "normalMap", "occlusion", "curvature"].map(|map| maps[map]["texCoord"].as_u64());
        assert_eq!(sets, [Some(2), Some(1), Some(1), Some(1)]);
        let vectors = |of: &Value| accessor::<3>(glb, &after, of);
        let uvs = |set: usize| accessor::<2>(glb, &after, &primitive["attributes"][format!("TEXCOORD_{set}")]);
        let attributes = &primitive["attributes"];
        let [places, positions, normals] = ["_PLACE", "POSITION", "NORMAL"].map(|of| vectors(&attributes[of]));
        let [own, moves] = [0, 1].map(|target| vectors(&primitive["targets"][target]["POSITION"]));
        let (colours, maps, samples) = (uvs(0), uvs(1), uvs(2));
        let lengths = [places.len(), normals.len(), own.len(), moves.len(), colours.len(), maps.len(), samples.len()];
        assert_eq!(lengths, [positions.len(); 7]);
        let accessors = list(&before, "accessors");
        copies += positions.len() - at(&accessors[at(&old["attributes"]["POSITION"])]["count"]);
        for v in drawn(glb, &after, primitive) {
            let (was, is) = (data.faces().items()[corner], unwrapped.faces().items()[corner]);
            let uv = data.uvs()[was.uv().unwrap() as usize];
            assert_eq!(DVec3::from(Vec3::from(positions[v])), data.positions()[was.position as usize]);
            assert_eq!(places[v], positions[v]);
            assert_eq!(DVec3::from(Vec3::from(own[v])), data.normals()[was.normal().unwrap() as usize]);
            assert_eq!(colours[v], [uv.x as f32, (1.0 - uv.y) as f32]);
            let uv = unwrapped.uvs()[is.uv().unwrap() as usize].as_vec2();
            assert_eq!(maps[v], [uv.x, 1.0 - uv.y]);
            let sample = Vec2::new(samples[v][0], 1.0 - samples[v][1]);
            let height = image.height_at(crate::map::displacement::SampleAt::Uv(sample), Weights::Exact);
            let by_map = Vec3::from(positions[v]) - height * Vec3::from(normals[v]);
            let by_target = Vec3::from(positions[v]) + Vec3::from(moves[v]);
            let error = f64::from(by_map.distance(by_target));
            assert!(error <= 0.7 * bundle.manifest.report.quantum + 1e-6, "{error:e}");
            // All vertices of a place sample one texel and go to one place, so that nothing tears.
            let place = positions[v].map(f32::to_bits);
            assert_eq!(*seen.entry(place).or_insert((samples[v], moves[v])), (samples[v], moves[v]));
            corner += 1;
        }
    }
    assert_eq!(corner, data.faces().items().len());
    assert!(copies > 0, "the sides of the box are charts of their own");
}
