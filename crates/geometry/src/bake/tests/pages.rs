//! Laws of maps with pages.

use super::*;
use crate::map::displacement::{PageSample, SampleAt, Weights};
use crate::map::manifest::PageEntry;
use crate::map::pages::{PageRule, Part};
use crate::source::Source;
use crate::source::format::Format;
use glam::{Vec2, Vec3};
use serde_json::Value;

fn laplacian() -> BakeTarget {
    Denoiser::Laplacian(Laplacian::default()).into()
}

pub(super) fn paged(pages: PageRule) -> BakeSettings {
    BakeSettings { target: laplacian(), pages, ..small() }
}

/// The sheet in one chart over several tiles, whose vertices on their border have one texture coordinate: `uv` maps [0, 1]².
fn one_chart(uv: impl Fn(DVec2) -> DVec2) -> Arrays {
    let sheet = sheet();
    let corner_uvs = sheet.faces.iter().flatten().map(|v| Some(*v)).collect();
    let uvs = sheet.positions.iter().map(|p| uv(p.truncate() / f64::from(SIDE))).collect();
    Arrays { uvs, corner_uvs, ..sheet }
}

/// The mesh with a position of its own for each corner, as exporters split vertices.
fn split(arrays: Arrays) -> Arrays {
    let positions = arrays.faces.iter().flatten().map(|v| arrays.positions[*v as usize]).collect();
    let mut next = 0..;
    let faces = arrays.faces.iter().map(|face| next.by_ref().take(face.len()).collect()).collect();
    Arrays { positions, faces, ..arrays }
}

fn model(arrays: Arrays) -> Model {
    Model::new(MeshData::try_from(arrays).unwrap(), Welding::Exact)
}

/// Meshes with several pages, the rule, and the names of the pages.
pub(super) fn meshes() -> Vec<(&'static str, Model, PageRule, Vec<&'static str>)> {
    let inside = |p: DVec2| DVec2::new(p.x, 0.05 + 0.9 * p.y);
    let two = move |p: DVec2| inside(p) * DVec2::new(2.0, 1.0);
    let sheet_in_two_tiles = sheet_with_uvs(|p| if p.x < 0.3 { p } else { p + DVec2::X });
    let overlapping = sheet_with_uvs(|p| if p.x < 0.3 { p } else { p - DVec2::new(0.3, 0.5) });
    vec![
        ("side by side", model(one_chart(two)), PageRule::Udim, vec!["1001", "1002"]),
        ("split", model(split(one_chart(two))), PageRule::Udim, vec!["1001", "1002"]),
        (
            "whole tiles away",
            model(one_chart(move |p| two(p) + DVec2::new(8.0, 3.0))),
            PageRule::Udim,
            vec!["1039", "1040"],
        ),
        ("four tiles", model(one_chart(|p| 2.0 * p)), PageRule::Udim, vec!["1001", "1002", "1011", "1012"]),
        // The border of the tiles goes through the middle of squares.
        ("crossing", model(one_chart(move |p| two(p) + DVec2::new(0.12, 0.0))), PageRule::Udim, vec!["1001", "1002"]),
        ("two charts", sheet_in_two_tiles, PageRule::Udim, vec!["1001", "1002"]),
        // Both materials lie on one chart, the second one mirrored onto the first in the last mesh.
        ("materials", overlapping, PageRule::Material, vec!["left", "right"]),
        (
            "mirror",
            sheet_with_uvs(|p| DVec2::new((p.x - 0.35).abs(), p.y % 0.5)),
            PageRule::Material,
            vec!["left", "right"],
        ),
    ]
}

pub(super) fn decoded(bundle: &Bundle) -> Vec<Displacement> {
    let entry = &bundle.manifest.displacement;
    let decode = |page: &PageEntry| {
        Displacement::decode(bytes_of(bundle, &page.file), entry.map, page.size(), entry.encoding()).unwrap()
    };
    bundle.manifest.page_entries().iter().map(decode).collect()
}

/// Place at which a corner of a face on a page samples the page, found in the manifest as a client does.
fn place(page: &PageEntry, mesh: &MeshData, corner: crate::source::Corner) -> SampleAt {
    let v = corner.position + 1;
    if let Some(texel) = page.private_texels.iter().find(|texel| texel.vertex == v) {
        return SampleAt::Texel(texel.row * page.width + texel.column);
    }
    let listed = page.seam_vertices.iter().find(|pair| pair[0] == v).map(|pair| pair[1] - 1);
    let uv = mesh.uvs()[listed.or(corner.uv()).unwrap() as usize];
    let Part::Tile(tile) = page.part else { return SampleAt::Uv(uv.as_vec2()) };
    let corner = Vec2::new(((tile - 1001) % 10) as f32, ((tile - 1001) / 10) as f32);
    SampleAt::Uv(uv.as_vec2() - corner)
}

#[test]
fn every_page_gives_each_of_its_vertices_its_height() {
    for (name, model, rule, parts) in meshes() {
        let bundle = bake_of(&model, &paged(rule));
        let (manifest, report) = (&bundle.manifest, &bundle.manifest.report);
        let names: Vec<String> = manifest.page_entries().iter().map(|page| page.part.to_string()).collect();
        assert_eq!((manifest.planish, names), (3, parts.iter().map(ToString::to_string).collect()), "{name}");
        assert_eq!((report.unresolved_vertices, report.seam_gap), (0, 0.0), "{name}: {report:?}");
        assert!(report.map_errors.max_quanta <= Some(0.64), "{name}: {report:?}");
        let displacements = laplacian().displacements(&model, MapKind::Scalar, Some(manifest.normals), &Silent);
        let heights = displacements.unwrap().heights.unwrap().0;
        let images = decoded(&bundle);
        let data = model.data();
        for (f, face) in (0..).zip(data.faces().iter()) {
            let uvs = face.iter().map(|c| data.uvs()[c.uv().unwrap() as usize]);
            let middle = uvs.sum::<DVec2>() / face.len() as f64;
            let material = data.face_material(f).map(|m| String::from_utf8_lossy(&data.materials()[m as usize]));
            let is_page = |page: &PageEntry| match &page.part {
                Part::Tile(tile) => *tile == 1001 + middle.x as u32 + 10 * middle.y as u32,
                Part::Material(name) => Some(name.as_str()) == material.as_deref(),
                Part::Cut(_) => false,
            };
            let page = manifest.page_entries().iter().position(is_page).unwrap();
            for corner in face {
                let entry = &manifest.page_entries()[page];
                let height = images[page].height_at(place(entry, data, *corner), Weights::Exact);
                let exact = heights[model.weld().vertex_of()[corner.position as usize] as usize];
                let error = (f64::from(height) - exact).abs();
                assert!(error <= 0.64 * report.quantum, "{name}, page {page}: {corner:?}: {error:e}");
            }
        }
    }
}

#[test]
fn files_of_pages_are_understood_as_they_were_written() {
    for (name, model, rule, _) in meshes() {
        for map in [MapKind::Scalar, MapKind::VectorTangent] {
            let bundle = bake_of(&model, &BakeSettings { map, ..paged(rule) });
            let manifest = Manifest::from_json(bytes_of(&bundle, "sheet.planish.json")).unwrap();
            assert_eq!(manifest, bundle.manifest, "{name}");
            let listed = |page: &PageEntry| page.files().all(|file| manifest.sha256_of(file).is_some());
            assert!(manifest.page_entries().iter().all(listed), "{name}");
            let carrier = Obj::parse(bytes_of(&bundle, &manifest.carrier.obj).to_vec()).unwrap();
            let images: Vec<&[u8]> = manifest.page_entries().iter().map(|page| bytes_of(&bundle, &page.file)).collect();
            let files = WrittenFiles { displacement: &images, carrier: carrier.data() };
            assert_eq!(check(&model, &manifest, &laplacian(), files, &Silent).unwrap(), manifest.report, "{name}");

            // The carrier and the mesh that was baked go to the same places, which are those of the report.
            let map = |mesh: &MeshData| {
                let samples: Vec<Option<PageSample>> = displace::page_samples(mesh, &manifest);
                Displacement::gathered(&decoded(&bundle), &samples, Weights::Exact)
            };
            let origin = manifest.displacement.origin;
            let own = displace::baked_vertices(model.source(), &manifest, &|| Some(carrier.clone())).unwrap();
            let own = displace::displaced(&own, &map(model.data()), 1.0, origin);
            let carried = displace::baked_vertices(&carrier.clone().into(), &manifest, &|| None).unwrap();
            let carried = displace::displaced(&carried, &map(carrier.data()), 1.0, origin);
            assert_eq!(own, carried, "{name}");
            let displacements =
                laplacian().displacements(&model, manifest.displacement.map, Some(manifest.normals), &Silent);
            let displacements = displacements.unwrap();
            let error = largest_error(&model, &displacements, &own);
            assert!(error <= manifest.report.error_bound, "{name}: {error:e}");
        }
    }
}

#[test]
fn meshes_of_one_part_need_no_pages() {
    for (rule, model) in [
        (PageRule::Udim, model(sheet())),
        (PageRule::Material, model(Arrays { materials: Vec::new(), face_materials: Vec::new(), ..sheet() })),
    ] {
        assert_eq!(bake_of(&model, &paged(rule)).files, bake_of(&model, &paged(PageRule::None)).files);
    }
    let error = bake(
        &model(sheet()),
        &BundleNames { source: "a".to_owned(), stem: "a".to_owned(), carrier: "a".to_owned() },
        SideFiles::NONE,
        &BakeSettings { layout: LayoutChoice::Vertex, ..paged(PageRule::Udim) },
        &Silent,
    );
    assert!(matches!(error, Err(BakeError::PagesWithLayout(LayoutChoice::Vertex))));
}

#[test]
fn a_page_without_room_is_named() {
    // All texture coordinates of the right half are at one point, and four texels are too few for its vertices.
    let crowded = sheet_with_uvs(|p| if p.x < 0.3 { p } else { DVec2::new(1.5, 0.5) });
    let bundle = bake_of(&crowded, &BakeSettings { side: Some(2), ..paged(PageRule::Udim) });
    let reason = bundle.fallback.as_ref().unwrap().to_string();
    assert!(reason.starts_with("page 1001: "), "{reason}");
    assert_eq!((bundle.manifest.displacement.layout, bundle.manifest.pages.is_none()), (Layout::Vertex, true));
}

/// Values of an accessor of a binary glTF file, which may be sparse.
pub(super) fn accessor<const N: usize>(glb: &[u8], document: &Value, index: &Value) -> Vec<[f32; N]> {
    let at = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let entry = &document["accessors"][at(index)];
    let start = |view: &Value| {
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        28 + length + at(&document["bufferViews"][at(view)]["byteOffset"])
    };
    let word = |view: &Value, i: usize| glb[start(view) + 4 * i..start(view) + 4 * i + 4].try_into().unwrap();
    let value = |view: &Value, k: usize| std::array::from_fn(|i| f32::from_le_bytes(word(view, N * k + i)));
    let mut values: Vec<[f32; N]> = (0..at(&entry["count"])).map(|k| value(&entry["bufferView"], k)).collect();
    let sparse = &entry["sparse"];
    for k in 0..at(&sparse["count"]) {
        let changed = u32::from_le_bytes(word(&sparse["indices"]["bufferView"], k)) as usize;
        values[changed] = value(&sparse["values"]["bufferView"], k);
    }
    values
}

/// Vertices that the primitives of a glTF file draw.
pub(super) fn drawn(glb: &[u8], document: &Value, primitive: &Value) -> Vec<usize> {
    let at = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let entry = &document["accessors"][at(&primitive["indices"])];
    let start = 28
        + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize
        + at(&document["bufferViews"][at(&entry["bufferView"])]["byteOffset"]);
    let bytes = &glb[start..];
    let count = at(&entry["count"]);
    match at(&entry["componentType"]) {
        5123 => bytes.as_chunks().0[..count].iter().map(|i| u16::from_le_bytes(*i).into()).collect(),
        5125 => bytes.as_chunks().0[..count].iter().map(|i| u32::from_le_bytes(*i) as usize).collect(),
        other => panic!("{other}"),
    }
}

/// The mesh as it is after it went through a glTF file.
pub(super) fn as_gltf(model: &Model, change: impl FnOnce(&mut Value)) -> Model {
    let source = model.source();
    let text = source.written_as(Format::Gltf, source.data().positions(), None).bytes;
    let mut document = serde_json::from_slice(&text).unwrap();
    change(&mut document);
    Model::new(Source::parse(document.to_string().into_bytes(), Some(Format::Gltf)).unwrap(), Welding::Exact)
}

#[test]
fn every_primitive_of_the_gltf_file_samples_its_own_page() {
    let own = meshes().into_iter().map(|(name, model, rule, parts)| (name, as_gltf(&model, |_| ()), rule, parts));
    for (name, model, rule, parts) in meshes().into_iter().chain(own) {
        let bundle = bake_of(&model, &paged(rule));
        let (manifest, images) = (&bundle.manifest, decoded(&bundle));
        let glb = bytes_of(&bundle, "sheet.glb");
        let document = document_of(glb);
        let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
        let mut seen = vec![false; parts.len()];
        for primitive in primitives {
            let material = &document["materials"][primitive["material"].as_u64().unwrap() as usize];
            let entry = &material["extras"]["planish"]["displacement"];
            let page = manifest.page_entries().iter().position(|page| entry["file"] == page.file.as_str()).unwrap();
            let part =
                entry.get("tile").map_or_else(|| entry["material"].as_str().unwrap().to_owned(), Value::to_string);
            assert_eq!(part, parts[page], "{name}");
            let texture = &document["textures"][entry["texture"].as_u64().unwrap() as usize];
            assert_eq!(document["images"][texture["source"].as_u64().unwrap() as usize]["name"], entry["file"]);
            seen[page] = true;
            let attributes = &primitive["attributes"];
            let [positions, normals] = ["POSITION", "NORMAL"].map(|of| accessor::<3>(glb, &document, &attributes[of]));
            let moves = accessor::<3>(glb, &document, &primitive["targets"][0]["POSITION"]);
            let samples = accessor::<2>(glb, &document, &attributes["TEXCOORD_1"]);
            for v in drawn(glb, &document, primitive) {
                let uv = Vec2::new(samples[v][0], 1.0 - samples[v][1]);
                let height = images[page].height_at(SampleAt::Uv(uv), Weights::Exact);
                let by_map = Vec3::from(positions[v]) - height * Vec3::from(normals[v]);
                let by_target = Vec3::from(positions[v]) + Vec3::from(moves[v]);
                let error = f64::from(by_map.distance(by_target));
                assert!(error <= 0.7 * manifest.report.quantum + 1e-6, "{name}: {error:e}");
            }
        }
        assert!(seen.iter().all(|seen| *seen), "{name}");
    }
}

#[test]
fn pages_that_are_not_allowed_are_named() {
    let bundle = bake_of(&model(one_chart(|p| 2.0 * p)), &paged(PageRule::Udim));
    let json: Value = serde_json::from_slice(bytes_of(&bundle, "sheet.planish.json")).unwrap();
    for (pointer, value, problem) in [
        ("/pages/maps/1/width", 0.into(), "page 1002: 0 is not in"),
        ("/pages/maps/0/width", 3.into(), "first page"),
        ("/pages/maps/2/vertices", "1-9999".into(), "page 1011: `vertices` names 9999"),
        ("/pages/maps/3/seam_vertices", serde_json::json!([[0, 1]]), "page 1012: `seam_vertices`"),
        ("/pages/maps", serde_json::json!([]), "there is none"),
        ("/displacement/layout", "vertex".into(), "layout `vertex`"),
    ] {
        let mut json = json.clone();
        *json.pointer_mut(pointer).unwrap() = value;
        let error = Manifest::from_json(json.to_string().as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("field `pages`: ") && error.contains(problem), "{error}");
    }
    let mut far = bundle.manifest.clone();
    far.pages.as_mut().unwrap().maps[1].seam_vertices = vec![[1, 9999]];
    let error = displace::check_mesh(&model(sheet()).data().clone(), &far).unwrap_err().to_string();
    assert_eq!(error, "page 1002: there is no vertex 0 or no `vt` 9998 (counted from 0)");
    let names = |bytes: &[u8]| manifest::named_files(bytes).unwrap().len();
    assert_eq!(names(bytes_of(&bundle, "sheet.planish.json")), bundle.files.len() - 1);
}

#[test]
fn a_material_of_backs_alone_gives_each_vertex_a_texel() {
    let mut leaf = Arrays { face_materials: vec![Some(0); (SIDE * SIDE) as usize], ..sheet() };
    for (face, uvs) in sheet().faces.iter().zip(sheet().corner_uvs.chunks(4)) {
        leaf.faces.push(face.iter().rev().copied());
        leaf.corner_uvs.extend(uvs.iter().rev());
        leaf.corner_normals.extend([Some(0); 4]);
        leaf.face_materials.push(Some(1));
    }
    let bundle = bake_of(&model(leaf), &paged(PageRule::Material));
    let manifest = &bundle.manifest;
    assert_eq!((manifest.displacement.layout, &manifest.pages), (Layout::Vertex, &None));
    assert!(manifest.report.max_error <= 0.5 * manifest.report.quantum + 1e-6, "{:?}", manifest.report);
    let reason = Box::new(Fallback::NoLayout);
    assert_eq!(bundle.fallback, Some(Fallback::Page { page: "right".into(), reason }));
    assert!(bundle.fallback.unwrap().to_string().starts_with("page right: all its faces are backs"));
}
