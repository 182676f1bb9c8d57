//! Tests of glTF files with a minimal reader of their own.

use super::*;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::shapes;
use crate::mesh::weld::Welding;
use crate::source::materials::CARRIER_MATERIAL;
use crate::source::model::NormalSource;
use crate::source::obj::Obj;
use glam::DVec2;

mod materials;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n, as far as this goes";
const EXR: &[u8] = b"\x76\x2f\x31\x01\x02";

/// JSON and buffer of a parsed file.
struct Parsed {
    json: Value,
    binary: Vec<u8>,
}

impl Parsed {
    #[track_caller]
    fn new(bytes: &[u8]) -> Self {
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
        let json = number(12);
        assert_eq!((&bytes[16..20], json % 4, bytes.len() % 4), (&b"JSON"[..], 0, 0));
        let binary = bytes[20 + json..].to_vec();
        if !binary.is_empty() {
            assert_eq!((number(20 + json), &binary[4..8]), (binary.len() - 8, &b"BIN\0"[..]));
        }
        let json: Value = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
        assert_eq!(json["buffers"][0]["byteLength"].as_u64().unwrap_or(0) as usize, binary.len().saturating_sub(8));
        Self { json, binary: binary.get(8..).unwrap_or_default().to_vec() }
    }
    fn view(&self, view: &Value) -> &[u8] {
        let view = &self.json["bufferViews"][view.as_u64().unwrap() as usize];
        let [offset, length] = ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
        assert_eq!(offset % 4, 0);
        &self.binary[offset..offset + length]
    }
    fn accessor(&self, accessor: &Value) -> &Value {
        &self.json["accessors"][accessor.as_u64().unwrap() as usize]
    }
    fn floats<const N: usize>(&self, accessor: &Value) -> Vec<[f32; N]> {
        let accessor = self.accessor(accessor);
        assert_eq!((&accessor["componentType"], &accessor["type"]), (&json!(5126), &json!(format!("VEC{N}"))));
        let numbers = self.view(&accessor["bufferView"]).as_chunks().0.iter().map(|x| f32::from_le_bytes(*x));
        let values = numbers.collect::<Vec<_>>().as_chunks().0.to_vec();
        assert_eq!(accessor["count"], values.len());
        values
    }
    fn primitives(&self) -> &[Value] {
        self.json["meshes"][0]["primitives"].as_array().unwrap()
    }
    /// Values of an attribute, which all primitives must share.
    fn attribute<const N: usize>(&self, name: &str) -> Vec<[f32; N]> {
        let attributes = &self.primitives()[0]["attributes"];
        assert!(self.primitives().iter().all(|p| &p["attributes"] == attributes));
        self.floats(&attributes[name])
    }
    fn target(&self, name: &str) -> Vec<[f32; 3]> {
        let target = &self.primitives()[0]["targets"];
        assert!(self.primitives().iter().all(|p| &p["targets"] == target) && target[1].is_null());
        self.floats(&target[0][name])
    }
    fn triangles(&self, primitive: &Value) -> Vec<[usize; 3]> {
        let accessor = self.accessor(&primitive["indices"]);
        let bytes = self.view(&accessor["bufferView"]);
        let indices: Vec<usize> = match accessor["componentType"].as_u64() {
            Some(5123) => bytes.as_chunks().0.iter().map(|i| u16::from_le_bytes(*i).into()).collect(),
            Some(5125) => bytes.as_chunks().0.iter().map(|i| u32::from_le_bytes(*i) as usize).collect(),
            other => panic!("{other:?}"),
        };
        assert_eq!(accessor["count"], indices.len());
        indices.as_chunks().0.to_vec()
    }
    fn material(&self, name: &str) -> &Value {
        let materials = self.json["materials"].as_array().unwrap();
        materials.iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("no {name}"))
    }
}

/// Values that a carrier borrows. The denoised surface has half the size and is moved aside.
struct Owned {
    model: Model,
    normals: Vec<Vec3>,
    samples: Vec<Option<Vec2>>,
    denoised: Vec<DVec3>,
    denoised_normals: Vec<DVec3>,
    materials: Vec<Material>,
    backs: Backs,
}

impl Owned {
    fn new(obj: &str) -> Self {
        let model = Model::new(Obj::parse(obj.into()).unwrap(), Welding::Exact);
        let surface = model.surface();
        let normals = model.vertex_normals(NormalSource::Angle).unwrap().iter().map(|n| n.as_vec3()).collect();
        let [low, high] = surface.bounds();
        let centre = if low.is_finite() { (low + high) / 2.0 } else { DVec3::ZERO };
        let aside = |i: u32| DVec3::new(0.1, 0.01 * f64::from(i), 0.0);
        let moved = (0..).zip(surface.positions()).map(|(i, p)| centre + (*p - centre) / 2.0 + aside(i));
        let denoised: Vec<DVec3> = moved.collect();
        let denoised_normals = normals::vertex_normals(&surface.at(denoised.clone()), FaceWeight::Angle);
        let sample = |i: usize| (i % 5 != 4).then(|| Vec2::new(0.125 + i as f32 / 1024.0, 0.25));
        let samples = (0..model.data().positions().len()).map(sample).collect();
        Self { model, normals, samples, denoised, denoised_normals, materials: Vec::new(), backs: Backs::default() }
    }
    fn carrier(&self) -> Carrier<'_> {
        let Value::Object(entry) = json!({ "file": "a.png", "layout": "uv", "bias": -0.5 }) else { unreachable!() };
        Carrier {
            name: "a",
            relocate: &str::to_owned,
            model: &self.model,
            backs: &self.backs,
            original: None,
            normals: &self.normals,
            sample_at: &self.samples,
            vertex_texels: None,
            denoised: &self.denoised,
            denoised_normals: &self.denoised_normals,
            origin: DVec3::ZERO,
            lambda: 0.75,
            materials: &self.materials,
            map: Map { bytes: PNG, filter: Filter::Linear, entry },
            pages: None,
            normal_map: json!({ "file": "n.png" }),
            occlusion: None,
            curvature: None,
        }
    }
    #[track_caller]
    fn parsed(&self) -> Parsed {
        Parsed::new(&glb(&self.carrier(), &|_| None).unwrap())
    }
}

fn no_files(_: Picture) -> Option<Vec<u8>> {
    None
}

/// A cube whose faces each have the whole texture, with all that a surface leaves out or puts together: twins of the
/// vertices 1 and 2, a vertex that nothing uses, collapsed and repeated faces, a sheet without area, normals that cancel.
const UNRULY: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
    v 0 0 0\nv 1 0 0\nv 9 9 9\nv 3 0 0\nv 4 0 0\nv 5 0 0\nv 7 0 0\nv 8 0 0\nv 7 1 0\nv 8 1 0\nv 7.5 0.5 0\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.25 0.125\nvt nan 0\n\
    f 1/1 3/2 4/3 2/4\nusemtl a\nf 5/1 6/2 8/3 7/4\nf 9/1 10/2 6/3 5/4\nusemtl b\nf 3/1 7/2 8/3 4/4\n\
    usemtl a\nf 1/1 5/2 7/3 3/4\nf 2 4/2 8/3 6/4\nf 2/1 2/1 4/1\nusemtl unused\nf 2/1 4/1 8/1 6/1\n\
    usemtl b\nf 12/5 13/5 14/6\nf 15/1 16/2 19/5\nf 18/1 17/2 19/5\nf 16 15 19\n";

fn sphere(levels: u32, offset: DVec3) -> String {
    let sphere = shapes::dented_sphere(levels);
    let lines = |p: &DVec3| (*p + offset).to_array().map(|x| x.to_string()).join(" ");
    let positions = sphere.positions().iter().map(|p| format!("v {}\n", lines(p)));
    let faces = sphere.triangles().map(|t| format!("f {}\n", t.map(|v| (v + 1).to_string()).join(" ")));
    positions.chain(faces).collect()
}

fn far() -> DVec3 {
    DVec3::new(500_000.0, 4_500_000.0, 250.0)
}

/// Each file of the family with the origin that it is written with.
fn family() -> Vec<(Owned, DVec3)> {
    let pairs = [(UNRULY.to_owned(), DVec3::ZERO), (sphere(3, far()), far()), (sphere(2, DVec3::ZERO), DVec3::X)];
    pairs.into_iter().map(|(text, origin)| (Owned::new(&text), origin)).collect()
}

fn written(owned: &Owned, origin: DVec3) -> Parsed {
    Parsed::new(&glb(&Carrier { origin, ..owned.carrier() }, &no_files).unwrap())
}

/// Position, texture coordinates (v down) and sampling coordinates of the corners of a triangle.
type Shown = [([f32; 3], [f32; 2], [f32; 2]); 3];

fn shown_by_model(owned: &Owned, origin: DVec3, material: Option<Index>) -> Vec<Shown> {
    let (model, surface) = (&owned.model, owned.model.surface());
    let down =
        |uv: Option<DVec2>| uv.filter(|uv| uv.is_finite()).map_or([0.0; 2], |uv| [uv.x as f32, (1.0 - uv.y) as f32]);
    let corner = |c: Index| {
        let source = model.source_corner(c);
        let sample = down(owned.samples[source.position as usize].map(Vec2::as_dvec2));
        let uvs = model.data().uvs();
        let uv = if uvs.is_empty() { sample } else { down(source.uv().map(|vt| uvs[vt as usize])) };
        ((surface.at_corner(c) - origin).as_vec3().to_array(), uv, sample)
    };
    let of_material =
        |t: &&[Index; 3]| model.data().face_material(model.source_face(surface.topology().face(t[0]))) == material;
    surface.triangle_corners().iter().filter(of_material).map(|t| t.map(corner)).collect()
}

#[test]
fn triangles_show_what_the_model_has_material_by_material_in_its_order() {
    for (owned, origin) in family() {
        let parsed = written(&owned, origin);
        let (positions, uvs) = (parsed.attribute::<3>("POSITION"), parsed.attribute::<2>("TEXCOORD_0"));
        let samples = parsed.attribute::<2>("TEXCOORD_1");
        let names = owned.model.data().materials().iter().map(|n| String::from_utf8_lossy(n).into_owned());
        let mut groups: Vec<(Option<Index>, String)> = (0..).map(Some).zip(names).collect();
        groups.insert(0, (None, CARRIER_MATERIAL.to_owned()));
        groups.retain(|(material, _)| !shown_by_model(&owned, origin, *material).is_empty());
        assert_eq!(parsed.primitives().len(), groups.len());
        let mut count = 0;
        for (primitive, (material, name)) in parsed.primitives().iter().zip(groups) {
            let triangles = parsed.triangles(primitive);
            let shown: Vec<Shown> = triangles.iter().map(|t| t.map(|i| (positions[i], uvs[i], samples[i]))).collect();
            assert_eq!(shown, shown_by_model(&owned, origin, material));
            assert_eq!(parsed.json["materials"][primitive["material"].as_u64().unwrap() as usize]["name"], name);
            count += triangles.len();
        }
        assert_eq!(count, owned.model.surface().triangle_corners().len());
    }
}

#[test]
fn vertices_are_the_distinct_pairs_in_order() {
    let owned = Owned::new(UNRULY);
    let wedges = Wedges::new(&owned.model, &owned.backs, &|_| 0);
    let pairs: Vec<_> = wedges.sources.iter().zip(&wedges.uvs).collect();
    assert!(pairs.is_sorted_by(|a, b| a < b), "{pairs:?}");
    let corners = 0..owned.model.surface().topology().faces().items().len() as Index;
    let mut named: Vec<_> = corners.map(|c| owned.model.source_corner(c)).map(|c| (c.position, c.uv())).collect();
    named.sort_unstable();
    named.dedup();
    assert_eq!(pairs, named.iter().map(|(line, uv)| (line, uv)).collect::<Vec<_>>());
    assert_eq!(owned.parsed().attribute::<3>("POSITION").len(), named.len());
}

#[test]
fn weight_one_is_the_denoised_surface() {
    for (owned, origin) in family() {
        let parsed = written(&owned, origin);
        let vertex = |line: Index| owned.model.weld().vertex_of()[line as usize] as usize;
        let wedges = Wedges::new(&owned.model, &owned.backs, &|_| 0);
        let morphed = |name: &str| {
            let base = parsed.attribute::<3>(name).into_iter().map(Vec3::from);
            base.zip(parsed.target(name)).map(|(base, delta)| base + Vec3::from(delta)).collect::<Vec<_>>()
        };
        // Half a unit in the last place of the difference and of the sum.
        let close = |found: Vec3, expected: DVec3, largest: f64| {
            (found.as_dvec3() - expected).abs().max_element() <= largest * f64::from(f32::EPSILON)
        };
        for (line, found) in wedges.sources.iter().zip(morphed("POSITION")) {
            let expected = owned.denoised[vertex(*line)] - origin;
            let base = owned.model.surface().positions()[vertex(*line)] - origin;
            assert!(close(found, expected, expected.abs().max_element().max(base.abs().max_element())), "{found}");
        }
        for (line, found) in wedges.sources.iter().zip(morphed("NORMAL")) {
            let expected = owned.denoised_normals[vertex(*line)];
            // The difference of unit vectors is up to two.
            assert!(expected == DVec3::ZERO || close(found, expected, 2.0), "{found} {expected}");
            assert!((found.length() - 1.0).abs() < 1e-6, "{found}");
        }
        for normal in parsed.attribute::<3>("NORMAL") {
            assert!((Vec3::from(normal).length() - 1.0).abs() < 1e-6);
        }
    }
    // The sheets without area and with normals that cancel are what this is about.
    let without = Owned::new(UNRULY).normals.iter().filter(|n| **n == Vec3::ZERO).count();
    assert!(without > 3, "{without}");
}

#[test]
fn the_normals_are_those_given() {
    let owned = Owned::new(&sphere(2, DVec3::ZERO));
    let normals: Vec<Vec3> = owned.parsed().attribute::<3>("NORMAL").into_iter().map(Vec3::from).collect();
    assert_eq!(normals, owned.normals);
}

#[test]
fn colours_of_vertices_are_linear() {
    let obj = "v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 0 1 0 1 1 1\nf 1 2 3\n";
    let model = Model::new(Obj::parse(obj.into()).unwrap(), Welding::Exact);
    let (normals, positions) = (vec![Vec3::Z; 3], model.surface().positions().to_vec());
    let samples = vec![Some(Vec2::ZERO); 3];
    let png =
        crate::map::displacement::png(&[0; 3], crate::map::Size::square(1), image::ExtendedColorType::Rgb8).unwrap();
    let carrier = Carrier {
        name: "a",
        model: &model,
        backs: &Backs::default(),
        original: None,
        normals: &normals,
        sample_at: &samples,
        vertex_texels: None,
        denoised: &positions,
        denoised_normals: &[DVec3::Z; 3],
        origin: DVec3::ZERO,
        lambda: 1.0,
        materials: &[],
        map: Map { bytes: &png, filter: Filter::Linear, entry: Object::new() },
        relocate: &str::to_owned,
        pages: None,
        normal_map: Value::Null,
        occlusion: None,
        curvature: None,
    };
    let bytes = glb(&carrier, &no_files).unwrap();
    let file = crate::source::Source::parse(bytes, None).unwrap();
    let colours = file.data().colours();
    assert_eq!(colours[1..], model.data().colours()[1..]);
    assert!((colours[0][2] - 0.5).abs() < 1e-6, "encoded again: {colours:?}");
}

#[test]
fn bounds_are_those_of_the_values() {
    for (owned, origin) in family() {
        let parsed = written(&owned, origin);
        let primitive = &parsed.primitives()[0];
        for accessor in [&primitive["attributes"]["POSITION"], &primitive["targets"][0]["POSITION"]] {
            let values = parsed.floats::<3>(accessor);
            for k in 0..3 {
                let of_axis = || values.iter().map(|v| v[k]);
                let found = ["min", "max"].map(|name| parsed.accessor(accessor)[name][k].as_f64().unwrap() as f32);
                assert_eq!(found, [of_axis().fold(f32::MAX, f32::min), of_axis().fold(f32::MIN, f32::max)]);
            }
        }
    }
}

#[test]
fn a_mesh_far_from_the_origin_is_moved_by_its_node() {
    let owned = Owned::new(&sphere(3, far()));
    let parsed = written(&owned, far());
    assert_eq!(parsed.json["nodes"][0]["translation"], json!(far().to_array()));
    // Steps of single precision are 0.5 so far out; a dented unit sphere about zero has some of 6e-8.
    assert!(parsed.attribute::<3>("POSITION").as_flattened().iter().all(|x| x.abs() < 1.1));
    assert!(written(&owned, DVec3::ZERO).json["nodes"][0].get("translation").is_none());
}

#[test]
fn a_slider_begins_at_lambda() {
    let mesh = &Owned::new(UNRULY).parsed().json["meshes"][0];
    assert_eq!((&mesh["weights"], &mesh["extras"]["targetNames"]), (&json!([0.75]), &json!(["denoised"])));
}

#[test]
fn the_map_is_a_texture_of_its_own_sampler() {
    let owned = Owned::new(UNRULY);
    for (filter, number) in [(Filter::Nearest, 9728), (Filter::Linear, 9729)] {
        let mut carrier = owned.carrier();
        carrier.map.filter = filter;
        let parsed = Parsed::new(&glb(&carrier, &no_files).unwrap());
        let expected = json!({
            "displacement": {
                "texture": 0, "mimeType": "image/png", "texCoord": 1, "file": "a.png", "layout": "uv", "bias": -0.5
            },
            "normalMap": { "file": "n.png" },
        });
        for material in parsed.json["materials"].as_array().unwrap() {
            assert_eq!(material["extras"]["planish"], expected);
            assert!(material.get("normalTexture").is_none());
        }
        let texture = &parsed.json["textures"][0];
        let sampler = &parsed.json["samplers"][texture["sampler"].as_u64().unwrap() as usize];
        assert_eq!(*sampler, json!({ "magFilter": number, "minFilter": number, "wrapS": 33071, "wrapT": 33071 }));
        let image = &parsed.json["images"][texture["source"].as_u64().unwrap() as usize];
        assert_eq!((&image["mimeType"], &image["name"]), (&json!("image/png"), &json!("a.png")));
        assert_eq!(parsed.view(&image["bufferView"]), PNG);
    }
}

#[test]
fn a_map_that_is_no_texture_is_a_view() {
    let owned = Owned::new(UNRULY);
    for (bytes, kind) in [(EXR, "image/x-exr"), (b"II*\0....", "image/tiff"), (b"?", "application/octet-stream")] {
        let mut carrier = owned.carrier();
        carrier.map.bytes = bytes;
        let parsed = Parsed::new(&glb(&carrier, &no_files).unwrap());
        let entry = &parsed.material("a")["extras"]["planish"]["displacement"];
        assert_eq!((&entry["mimeType"], parsed.view(&entry["bufferView"])), (&json!(kind), bytes));
        assert!(["textures", "images", "samplers"].iter().all(|list| parsed.json.get(list).is_none()));
    }
}

#[test]
fn without_uvs_both_sets_are_the_places_and_no_texture_is_shown() {
    let mut owned = Owned::new("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nusemtl a\nf 1 2 3\n");
    owned.materials = crate::source::materials::read(b"newmtl a\nmap_Kd a.png\n").unwrap();
    let parsed = Parsed::new(&glb(&owned.carrier(), &|_| Some(PNG.to_vec())).unwrap());
    let attributes = &parsed.primitives()[0]["attributes"];
    assert_eq!(attributes["TEXCOORD_0"], attributes["TEXCOORD_1"]);
    assert!(parsed.material("a")["pbrMetallicRoughness"].get("baseColorTexture").is_none());
    assert_eq!(parsed.json["images"].as_array().unwrap().len(), 1, "the map");
}

#[test]
fn a_surface_without_faces_is_an_empty_node() {
    let parsed = Owned::new("v 0 0 0\nv 1 0 0\nv 1 0 0\nf 1 2 3\nf 1 1 2\n").parsed();
    assert_eq!(parsed.json["nodes"], json!([{ "name": "a" }]));
    let kept: Vec<&str> = parsed.json.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(kept, ["asset", "scene", "scenes", "nodes"]);
}

#[test]
fn what_single_precision_cannot_hold_is_an_error() {
    let owned = Owned::new("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(glb(&owned.carrier(), &no_files), Err(GltfError::NotFinite));
    let mut owned = Owned::new("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    owned.denoised[2].y = f64::NAN;
    assert_eq!(glb(&owned.carrier(), &no_files), Err(GltfError::NotFinite));
}

#[test]
fn indices_are_short_where_the_highest_one_is_left_over() {
    for (vertices, kind) in [(65_535, 5123), (65_536, 5125)] {
        let mut buffer = glb::Buffer::default();
        let last = vertices as u32 - 1;
        let accessor = buffer.indices(&[[last, 1, 2]], vertices);
        let parsed = Parsed::new(&buffer.finish(Object::new()).unwrap());
        assert_eq!(parsed.accessor(&accessor.into())["componentType"], kind);
        assert_eq!(parsed.triangles(&json!({ "indices": accessor })), [[last as usize, 1, 2]]);
    }
}

#[test]
fn values_are_copied_behind_all_kinds_of_accessors() {
    let mut buffer = glb::Buffer::with_capacity(0);
    let plain = buffer.attribute(&[[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
    let sparse = buffer.changed(plain, 3, &[(1, [7.0, 8.0])]);
    let zeros = buffer.zeros(3);
    let copied = [plain, sparse, zeros].map(|of| buffer.with_copies(of, 3, &[1, 0, 1]).unwrap());
    assert_eq!(buffer.with_copies(99, 3, &[]), None, "there is no such accessor");
    assert_eq!(buffer.with_copies(plain, 4, &[]), None, "the view has three values");
    let parsed = Parsed::new(&buffer.finish(Object::new()).unwrap());
    let [plain, sparse, zeros] = copied.map(Value::from);
    let own = [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]];
    assert_eq!(parsed.floats::<2>(&plain), [own[0], own[1], own[2], own[1], own[0], own[1]]);
    let changed = [7.0, 8.0];
    assert_eq!(parsed.floats::<2>(&sparse), [own[0], changed, own[2], changed, own[0], changed]);
    assert_eq!(parsed.floats::<3>(&zeros), [[0.0; 3]; 6]);
    assert_eq!(parsed.accessor(&plain)["max"], json!([5.0, 6.0]));

    // Two bytes of three stand behind each other in a view with four bytes from value to value, behind an offset.
    let view = json!({ "buffer": 0, "byteOffset": 1, "byteLength": 11, "byteStride": 4 });
    let entry = json!({
        "bufferView": 0, "byteOffset": 3, "componentType": 5121, "normalized": true, "count": 2, "type": "VEC3", "name": "colours",
    });
    let compressed = json!({ "buffer": 0, "byteLength": 8, "extensions": { "EXT_meshopt_compression": {} } });
    let other = json!({ "bufferView": 1, "componentType": 5121, "count": 2, "type": "VEC4" });
    let bytes = (0..12).collect();
    let mut buffer = glb::Buffer::continuing(bytes, vec![view, compressed], vec![entry, other]);
    let copied: Value = buffer.with_copies(0, 2, &[1]).unwrap().into();
    assert_eq!(buffer.with_copies(1, 2, &[1]), None, "compressed");
    let parsed = Parsed::new(&buffer.finish(Object::new()).unwrap());
    let entry = parsed.accessor(&copied);
    assert_eq!(parsed.view(&entry["bufferView"]), [4, 5, 6, 0, 8, 9, 10, 0, 8, 9, 10, 0]);
    assert_eq!(parsed.json["bufferViews"][at(&entry["bufferView"])]["byteStride"], 4);
    assert_eq!((&entry["count"], &entry["normalized"], &entry["name"]), (&json!(3), &json!(true), &json!("colours")));
    assert!(entry["byteOffset"].is_null());
}

fn at(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}
