//! Laws of a whole bake that do not depend on the format of the mesh.

use super::*;
use crate::denoise::{Denoiser, Laplacian, NormalField};
use crate::map::HeightMap;
use crate::map::displace;
use crate::map::displacement::{Displacement, Encoding, TexelFormat};
use crate::map::manifest::{self, Layout};
use crate::map::occlusion::Occlusion;
use crate::mesh::jagged::Index;
use crate::mesh::weld::Welding;
use crate::progress::Silent;
use crate::source::model::NormalSource;
use crate::source::obj::Obj;
use crate::source::{Arrays, MeshData};
use glam::{DVec2, DVec3};
use std::fmt::Write as _;

/// Squares along a side.
const SIDE: u32 = 8;

/// A rough sheet of squares, cut into two charts, of two materials.
fn sheet() -> Arrays {
    let (row, half) = (SIDE + 1, SIDE / 2);
    let grid = || (0..row * row).map(|i| DVec2::new((i % row).into(), (i / row).into()));
    let lift = |p: DVec2| ((13.0 * p.x + 7.0 * p.y).sin() * 1e3).fract() / 3.0;
    let squares = || (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    let corners = |(x, y)| [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y): (u32, u32)| x + row * y);
    // The right half is a chart of its own, with texture coordinates of its own along the cut.
    let uv = |x: u32, v: u32| Some(if x < half { v } else { v + row * row });
    let left = grid().map(|p| p / 20.0);
    Arrays {
        positions: grid().map(|p| DVec3::new(p.x, p.y, lift(p))).collect(),
        faces: squares().map(|square| corners(square).to_vec()).collect(),
        uvs: left.clone().chain(left.map(|uv| uv + DVec2::new(0.3, 0.5))).collect(),
        corner_uvs: squares().flat_map(|square| corners(square).map(|v| uv(square.0, v))).collect(),
        normals: vec![DVec3::new(0.1, 0.0, 2.0)],
        corner_normals: vec![Some(0); (4 * SIDE * SIDE) as usize],
        materials: vec!["left".into(), "right".into()],
        face_materials: squares().map(|(x, _)| Some((x >= half).into())).collect(),
        ..Arrays::default()
    }
}

/// Largest distance between source vertices that were displaced (#v×3) and where the displacements lead, model units.
fn largest_error(model: &Model, displacements: &VertexDisplacements, displaced: &[DVec3]) -> f64 {
    let error = |(p, v): (&DVec3, &Index)| {
        let v = *v as usize;
        let delta = match &displacements.heights {
            Some((heights, _)) => heights[v] * displacements.normals[v].as_dvec3(),
            None => displacements.deltas[v],
        };
        p.distance(model.surface().positions()[v] - delta)
    };
    // A number that is none counts as the largest.
    displaced.iter().zip(model.weld().vertex_of()).map(error).max_by(f64::total_cmp).unwrap()
}

/// The mesh of the arrays as another program may write it.
fn as_obj(arrays: &Arrays) -> Obj {
    let mut text = "# a sheet\no sheet\n".to_owned();
    for p in &arrays.positions {
        writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
    }
    for uv in &arrays.uvs {
        writeln!(text, "vt {:?} {:?}", uv.x, uv.y).unwrap();
    }
    for n in &arrays.normals {
        writeln!(text, "vn {:?} {:?} {:?}", n.x, n.y, n.z).unwrap();
    }
    let one_more = |i: &Option<Index>| i.map(|i| (i + 1).to_string()).unwrap_or_default();
    for (f, face) in (0..).zip(arrays.faces.iter()) {
        if let Some(Some(material)) = arrays.face_materials.get(f as usize) {
            writeln!(text, "usemtl {}", arrays.materials[*material as usize]).unwrap();
        }
        text.push('f');
        for (c, v) in arrays.faces.range(f).zip(face) {
            let named = [&arrays.corner_uvs, &arrays.corner_normals].map(|of| of.get(c).map(one_more));
            write!(text, " {}", v + 1).unwrap();
            named.into_iter().for_each(|index| write!(text, "/{}", index.unwrap_or_default()).unwrap());
        }
        text.push('\n');
    }
    Obj::parse(text.into_bytes()).unwrap()
}

fn bake_of(model: &Model, settings: &BakeSettings) -> Bundle {
    let names = BundleNames { source: "sheet".to_owned(), stem: "sheet".to_owned(), carrier: "sheet".to_owned() };
    bake(model, &names, SideFiles::NONE, settings, &Silent).unwrap()
}

fn bytes_of<'a>(bundle: &'a Bundle, name: &str) -> &'a [u8] {
    &bundle.files.iter().find(|file| file.name == name).unwrap().bytes
}

#[test]
fn arrays_and_a_file_of_the_same_numbers_give_the_same_maps() {
    let smooth = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    let of_file = Some(NormalField::Source(NormalSource::File));
    let settings = || BakeSettings { target: smooth.clone(), ..BakeSettings::default() };
    let without_uvs = Arrays { uvs: Vec::new(), corner_uvs: Vec::new(), ..sheet() };
    for (arrays, settings) in [
        (sheet(), settings()),
        (sheet(), BakeSettings { layout: LayoutChoice::Uv, normals: of_file, side: Some(64), ..settings() }),
        (sheet(), BakeSettings { layout: LayoutChoice::Vertex, map: MapKind::VectorObject, ..settings() }),
        (sheet(), BakeSettings { map: MapKind::VectorTangent, ..settings() }),
        (without_uvs, settings()),
    ] {
        let of_file = Model::new(as_obj(&arrays), Welding::Exact);
        let of_arrays = Model::new(MeshData::try_from(arrays).unwrap(), Welding::Exact);
        let [file, own] = [&of_file, &of_arrays].map(|model| bake_of(model, &settings));
        let maps = |bundle: &Bundle| {
            let normal_map = bundle.manifest.normal_map.as_ref().map(|entry| bytes_of(bundle, &entry.file).to_vec());
            (bytes_of(bundle, &bundle.manifest.displacement.file).to_vec(), normal_map)
        };
        assert!(maps(&own) == maps(&file), "{settings:?}");
        let without_names = |bundle: &Bundle| {
            let mut manifest = bundle.manifest.clone();
            (manifest.source.sha256, manifest.carrier.sha256) = Default::default();
            manifest.files.retain(|entry| entry.file != manifest.carrier.obj);
            manifest
        };
        assert_eq!(without_names(&own), without_names(&file));
        for end in [".mtl", ".glb"] {
            assert!(bytes_of(&own, &format!("sheet{end}")) == bytes_of(&file, &format!("sheet{end}")), "{end}");
        }
    }
}

/// Occlusion with few rays, and curvature.
fn shaded() -> BakeSettings {
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    let occlusion = Some(Occlusion { rays: 16, distance: Some(2.0) });
    BakeSettings { target, occlusion, curvature: CurvatureMap::Mean, ..BakeSettings::default() }
}

/// Document of a binary glTF file.
fn document_of(glb: &[u8]) -> serde_json::Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn maps_of_shading_are_in_the_manifest_and_in_the_gltf_file() {
    let without_uvs = Arrays { uvs: Vec::new(), corner_uvs: Vec::new(), ..sheet() };
    for (arrays, layout) in [(sheet(), Layout::Uv), (without_uvs, Layout::Vertex)] {
        let model = Model::new(as_obj(&arrays), Welding::Exact);
        let bundle = bake_of(&model, &shaded());
        let manifest = Manifest::from_json(&bundle.files.last().unwrap().bytes).unwrap();
        assert_eq!(manifest, bundle.manifest);
        let (occlusion, curvature) = (manifest.occlusion.unwrap(), manifest.curvature.unwrap());
        assert_eq!((occlusion.rays, occlusion.distance), (16, Some(2.0)));
        assert!(curvature.range > 0.0);
        let glb = document_of(bytes_of(&bundle, "sheet.glb"));
        for (map, field) in [(&occlusion.map, "occlusion"), (&curvature.map, "curvature")] {
            assert_eq!((map.file.as_str(), map.layout), (format!("sheet.{field}.png").as_str(), layout));
            let bytes = bytes_of(&bundle, &map.file);
            let entry = manifest.files.iter().find(|entry| entry.file == map.file).unwrap();
            assert_eq!(entry.sha256, manifest::sha256(bytes));
            let image = image::load_from_memory(bytes).unwrap();
            assert_eq!((image.color(), image.width(), image.height()), (image::ColorType::L8, map.width, map.height));
            let mut greys = image.into_luma8().into_raw();
            greys.sort_unstable();
            assert!(greys[0] < greys[greys.len() - 1], "{field} is not even");
            for material in glb["materials"].as_array().unwrap() {
                let described = &material["extras"]["planish"][field];
                assert_eq!(described["file"], map.file);
                let image = &glb["images"][glb["textures"][described["texture"].as_u64().unwrap() as usize]["source"]
                    .as_u64()
                    .unwrap() as usize];
                assert_eq!(image["name"], map.file);
                let attached = &material["occlusionTexture"]["index"];
                let is_attached = field == "occlusion" && layout == Layout::Uv;
                assert_eq!(*attached == described["texture"], is_attached, "{material}");
            }
        }
    }
}

#[test]
fn maps_of_shading_change_no_other_file() {
    let model = Model::new(as_obj(&sheet()), Welding::Exact);
    let plain = bake_of(&model, &BakeSettings { occlusion: None, curvature: CurvatureMap::None, ..shaded() });
    let shaded = bake_of(&model, &shaded());
    for file in plain.files.iter().filter(|file| !file.name.ends_with(".glb") && !file.name.ends_with(".json")) {
        assert!(bytes_of(&shaded, &file.name) == file.bytes, "{}", file.name);
    }
    assert_eq!(shaded.files.len(), plain.files.len() + 2);
    assert!(plain.manifest.occlusion.is_none() && !plain.manifest.to_json().contains("occlusion"));
}

#[test]
fn bad_entries_of_shading_are_named() {
    let bundle = bake_of(&Model::new(as_obj(&sheet()), Welding::Exact), &shaded());
    let json: serde_json::Value = serde_json::from_slice(&bundle.files.last().unwrap().bytes).unwrap();
    for (pointer, value, field) in [
        ("/occlusion/width", 0.into(), "occlusion"),
        ("/curvature/height", 70_000.into(), "curvature"),
        ("/occlusion/distance", (-1.0).into(), "occlusion.distance"),
        ("/curvature/range", (-0.5).into(), "curvature.range"),
        ("/occlusion/file", "other.png".into(), "files"),
    ] {
        let mut json = json.clone();
        let place: &mut serde_json::Value = json.pointer_mut(pointer).unwrap();
        *place = value;
        let error = Manifest::from_json(json.to_string().as_bytes()).unwrap_err().to_string();
        assert!(error.contains(&format!("field `{field}`")), "{error}");
    }
    let mut few = json.clone();
    (few["occlusion"]["layout"], few["occlusion"]["width"], few["occlusion"]["height"]) =
        ("vertex".into(), 2.into(), 2.into());
    assert!(Manifest::from_json(few.to_string().as_bytes()).is_err(), "four texels for 81 vertices");
}

#[test]
fn a_bundle_of_arrays_is_understood_from_its_own_files() {
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    let settings = BakeSettings { target: target.clone(), ..BakeSettings::default() };
    let model = Model::new(MeshData::try_from(sheet()).unwrap(), Welding::Exact);
    let bundle = bake_of(&model, &settings);
    let manifest = &bundle.manifest;
    let carrier = Obj::parse(bytes_of(&bundle, &manifest.carrier.obj).to_vec()).unwrap();
    assert_eq!(manifest::sha256(carrier.bytes()), manifest.carrier.sha256);
    let displacement = bytes_of(&bundle, &manifest.displacement.file);
    let files = WrittenFiles { displacement: &[displacement], carrier: carrier.data() };
    assert_eq!(check(&model, manifest, &target, files, &Silent).unwrap(), manifest.report);

    let entry = &manifest.displacement;
    let map = Displacement::decode(displacement, entry.map, entry.size(), entry.encoding()).unwrap();
    let vertices = displace::baked_vertices(model.source(), manifest, &|| None).unwrap();
    let displaced = displace::displaced(&vertices, &map, 1.0, entry.origin);
    let displacements = target.displacements(&model, MapKind::Scalar, Some(manifest.normals), &Silent).unwrap();
    let expected = model.weld().spread(model.surface().positions());
    for ((position, source), v) in displaced.iter().zip(expected).zip(model.weld().vertex_of()) {
        let height = displacements.heights.as_ref().unwrap().0[*v as usize];
        let denoised = source - height * displacements.normals[*v as usize].as_dvec3();
        assert!(position.distance(denoised) <= manifest.report.error_bound, "{position} {denoised}");
    }
}

/// A mesh in whose texture coordinates several vertices share a place.
fn sheet_with_uvs(uv: impl Fn(DVec2) -> DVec2) -> Model {
    let sheet = sheet();
    let uvs = sheet.uvs.iter().map(|p| uv(*p)).collect();
    Model::new(MeshData::try_from(Arrays { uvs, ..sheet }).unwrap(), Welding::Exact)
}

/// Layouts that cannot give each vertex a place: charts one upon the other, mirrored charts, a crowd, charts in other tiles, all
/// texture coordinates at one point, and a chart that fills the image and lies upon another one.
fn layouts_without_space() -> Vec<(&'static str, Model)> {
    vec![
        ("overlap", sheet_with_uvs(|p| DVec2::new(p.x % 0.3, p.y % 0.5))),
        ("mirror", sheet_with_uvs(|p| DVec2::new((p.x - 0.35).abs(), p.y % 0.5))),
        ("crowd", sheet_with_uvs(|p| if p.x + p.y < 0.4 { p * 1e-5 + 0.4 } else { p })),
        ("tiles", sheet_with_uvs(|p| p + DVec2::new((p.x / 0.3).floor() * 3.0, 0.0))),
        ("point", sheet_with_uvs(|_| DVec2::splat(0.25))),
        ("full", sheet_with_uvs(|p| DVec2::new((p.x % 0.3) / 0.2, (p.y % 0.5) / 0.4))),
    ]
}

/// Settings for maps that are small enough for a test.
fn small() -> BakeSettings {
    BakeSettings { largest_side: LargestSide(256), ..BakeSettings::default() }
}

#[test]
fn vertices_without_a_place_have_private_texels_and_all_are_exact() {
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    for (name, model) in layouts_without_space() {
        for (map, texel, side) in [
            (MapKind::Scalar, TexelFormat::Png16, None),
            (MapKind::Scalar, TexelFormat::Exr32, None),
            (MapKind::VectorObject, TexelFormat::Png16, None),
            (MapKind::VectorTangent, TexelFormat::Png16, Some(100)),
        ]
        .into_iter()
        .filter(|(_, texel, _)| texel.file().is_built())
        {
            let settings = BakeSettings { target: target.clone(), map, texel, side, ..small() };
            let bundle = bake_of(&model, &settings);
            let (manifest, report) = (&bundle.manifest, &bundle.manifest.report);
            assert_eq!((manifest.displacement.layout, manifest.planish), (Layout::Uv, 2), "{name}");
            assert_eq!((report.unresolved_vertices, report.seam_gap), (0, 0.0), "{name}: {report:?}");
            // What the fit leaves is an eighth of a step, and positions are rounded as well.
            assert!(texel == TexelFormat::Exr32 || report.map_errors.max_quanta <= Some(0.64), "{name}: {report:?}");
            if side.is_none() {
                assert_eq!(report.eight_bit_weights.seam_gap, 0.0, "{name}");
            }
            let private = manifest.private_texels.len();
            assert!(private > 0 && report.private_vertices <= private, "{name}");
            assert!(name == "point" || 2 * private <= manifest.source.vertices, "{name}: {private}");
            assert!(report.own_uvs.unwrap().errors.unwrap().max > report.quantum, "{name}");

            // The files are read as they were written, and displace as the report says.
            let displacement = bytes_of(&bundle, &manifest.displacement.file);
            let carrier = Obj::parse(bytes_of(&bundle, &manifest.carrier.obj).to_vec()).unwrap();
            let files = WrittenFiles { displacement: &[displacement], carrier: carrier.data() };
            let read = Manifest::from_json(manifest.to_json().as_bytes()).unwrap();
            assert_eq!(&read, manifest, "{name}");
            assert_eq!(check(&model, &read, &target, files, &Silent).unwrap(), *report, "{name}");
        }
    }
}

#[test]
fn private_texels_are_read_by_their_vertex_alone() {
    for (name, model) in layouts_without_space() {
        let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
        let bundle = bake_of(&model, &BakeSettings { target, ..small() });
        let manifest = &bundle.manifest;
        let entry = &manifest.displacement;
        let map =
            Displacement::decode(bytes_of(&bundle, &entry.file), entry.map, entry.size(), entry.encoding()).unwrap();
        let vertices = displace::baked_vertices(model.source(), manifest, &|| None).unwrap();
        let texels: Vec<Index> = manifest.private_pairs().iter().map(|pair| pair[1]).collect();
        let Encoding { bias, scale, .. } = map.encoding();
        let mut heights: Vec<f32> = map.planes()[0].iter().map(|texel| bias + scale * texel).collect();
        texels.iter().for_each(|&texel| heights[texel as usize] = 2.0 * bias + scale - heights[texel as usize]);
        let changed = [HeightMap { size: map.size(), texels: heights }];
        let changed = Displacement::encode(&changed, map.kind(), map.encoding());
        for (v, vertex) in (0..).zip(&vertices) {
            let is_private = manifest.private_pairs().iter().any(|pair| pair[0] == v);
            assert_eq!(vertex.height(&changed) == vertex.height(&map), !is_private, "{name}: vertex {v}");
        }
        let mut distinct = texels.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), texels.len(), "{name}");
    }
}

#[test]
fn layouts_with_space_have_no_private_texels_and_the_first_version() {
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    let bundle = bake_of(&sheet_with_uvs(|p| p), &BakeSettings { target, ..small() });
    assert_eq!((bundle.manifest.planish, bundle.manifest.private_texels.len()), (1, 0));
    assert!(!bundle.manifest.to_json().contains("private"));
}

#[test]
fn normal_maps_are_flat_where_charts_overlap() {
    let target = BakeTarget::from(Denoiser::Laplacian(Laplacian::default()));
    let settings = BakeSettings { target, ..small() };
    // The second chart lies on the upper half of the first one.
    let model = sheet_with_uvs(|p| if p.x >= 0.3 { p + DVec2::new(-0.5, -0.3) } else { p });
    let bundle = bake_of(&model, &settings);
    let entry = bundle.manifest.normal_map.as_ref().unwrap();
    let image = image::load_from_memory(bytes_of(&bundle, &entry.file)).unwrap().into_rgb8();
    let at = |u: f64, v: f64| {
        let side = f64::from(entry.width);
        image.get_pixel((u * side) as u32, ((1.0 - v) * side) as u32).0
    };
    let flat = [128, 128, 255];
    assert!((0..50).all(|i| at(0.005 + 0.003 * f64::from(i), 0.3) == flat));
    assert!((0..50).any(|i| at(0.005 + 0.003 * f64::from(i), 0.1) != flat));
}

mod backs;
mod carrier;
mod last_result;
mod pages;
mod tile;
