//! Laws of maps of meshes whose texture coordinates lie in another tile than [0, 1]².

use super::pages::{accessor, as_gltf, drawn};
use super::*;
use crate::map::displacement::{SampleAt, Weights};
use glam::{IVec2, Vec2, Vec3};
use serde_json::{Value, json};

/// Lower left corners of tiles.
const TILES: [IVec2; 4] = [IVec2::new(1, 0), IVec2::new(0, -1), IVec2::new(-3, 7), IVec2::new(12, -4)];

fn settings() -> BakeSettings {
    BakeSettings { target: Denoiser::Laplacian(Laplacian::default()).into(), ..small() }
}

fn in_tile(tile: IVec2) -> Model {
    // The charts of the sheet reach the border of the tile.
    sheet_with_uvs(|p| p * DVec2::new(1.0 / 0.7, 1.0 / 0.9) + tile.as_dvec2())
}

fn decoded(bundle: &Bundle) -> Displacement {
    let entry = &bundle.manifest.displacement;
    Displacement::decode(bytes_of(bundle, &entry.file), entry.map, entry.size(), entry.encoding()).unwrap()
}

#[test]
fn a_layout_in_another_tile_is_as_good_as_in_the_unit_square() {
    for map in [MapKind::Scalar, MapKind::VectorTangent] {
        let settings = BakeSettings { map, ..settings() };
        let plain = bake_of(&in_tile(IVec2::ZERO), &settings);
        assert_eq!((plain.manifest.planish, plain.manifest.displacement.tile), (1, IVec2::ZERO));
        assert!(!plain.manifest.to_json().contains("\"tile\""));
        for tile in TILES {
            let model = in_tile(tile);
            let bundle = bake_of(&model, &settings);
            let (manifest, report) = (&bundle.manifest, &bundle.manifest.report);
            assert_eq!((manifest.planish, manifest.displacement.tile), (4, tile));
            let size = (manifest.displacement.width, manifest.displacement.height);
            assert_eq!(size, (plain.manifest.displacement.width, plain.manifest.displacement.height), "{tile}");
            assert_eq!((report.private_vertices, report.unresolved_vertices, report.seam_gap), (0, 0, 0.0), "{tile}");
            assert!(report.map_errors.max_quanta <= Some(0.64), "{tile}: {report:?}");
            assert_eq!((report.layout.out_of_range_vertices, report.layout.out_of_range), (0, None), "{tile}");
            assert!(manifest.normal_map.is_some(), "{tile}");

            // The files are read as they were written, and displace as the report says, the mesh as well as its carrier.
            let read = Manifest::from_json(bytes_of(&bundle, "sheet.planish.json")).unwrap();
            assert_eq!(&read, manifest, "{tile}");
            let carrier = Obj::parse(bytes_of(&bundle, &manifest.carrier.obj).to_vec()).unwrap();
            let images = [bytes_of(&bundle, &manifest.displacement.file)];
            let files = WrittenFiles { displacement: &images, carrier: carrier.data() };
            assert_eq!(check(&model, &read, &settings.target, files, &Silent).unwrap(), *report, "{tile}");
            let (image, origin) = (decoded(&bundle), manifest.displacement.origin);
            let own = displace::baked_vertices(model.source(), manifest, &|| Some(carrier.clone())).unwrap();
            let own = displace::displaced(&own, &image, 1.0, origin);
            let carried = displace::baked_vertices(&carrier.clone().into(), manifest, &|| None).unwrap();
            assert_eq!(own, displace::displaced(&carried, &image, 1.0, origin), "{tile}");
            let displacements = settings.target.displacements(&model, map, Some(manifest.normals), &Silent).unwrap();
            let error = largest_error(&model, &displacements, &own);
            assert!(error <= report.error_bound, "{tile}: {error:e}");
        }
    }
}

#[test]
fn the_gltf_file_and_the_materials_lead_into_the_tile() {
    for tile in TILES {
        for model in [in_tile(tile), as_gltf(&in_tile(tile), |_| ())] {
            let bundle = bake_of(&model, &settings());
            let (image, glb) = (decoded(&bundle), bytes_of(&bundle, "sheet.glb"));
            let document = document_of(glb);
            for primitive in document["meshes"][0]["primitives"].as_array().unwrap() {
                let attributes = &primitive["attributes"];
                let [positions, normals] =
                    ["POSITION", "NORMAL"].map(|of| accessor::<3>(glb, &document, &attributes[of]));
                let moves = accessor::<3>(glb, &document, &primitive["targets"][0]["POSITION"]);
                let [own, samples] =
                    ["TEXCOORD_0", "TEXCOORD_1"].map(|of| accessor::<2>(glb, &document, &attributes[of]));
                for v in drawn(glb, &document, primitive) {
                    let uv = Vec2::new(samples[v][0], 1.0 - samples[v][1]);
                    assert!(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all(), "{tile}: {uv}");
                    let by_map = Vec3::from(positions[v])
                        - image.height_at(SampleAt::Uv(uv), Weights::Exact) * Vec3::from(normals[v]);
                    let error = f64::from(by_map.distance(Vec3::from(positions[v]) + Vec3::from(moves[v])));
                    assert!(error <= 0.7 * bundle.manifest.report.quantum + 1e-6, "{tile}: {error:e}");
                    // The artist's coordinates stay where they are.
                    let corner = Vec2::new(own[v][0], 1.0 - own[v][1]) - tile.as_vec2();
                    assert!(corner.cmpge(Vec2::splat(-1e-5)).all() && corner.cmple(Vec2::splat(1.0 + 1e-5)).all());
                }
            }
            let library = String::from_utf8(bytes_of(&bundle, "sheet.mtl").to_vec()).unwrap();
            let offset = format!("-o {} {} 0 sheet.", -tile.x, -tile.y);
            let statements: Vec<&str> =
                library.lines().filter(|line| line.starts_with("disp ") || line.starts_with("norm ")).collect();
            assert!(statements.len() >= 4 && statements.iter().all(|line| line.contains(&offset)), "{library}");
        }
    }
}

#[test]
fn charts_that_overlap_in_another_tile_have_private_texels_there() {
    let model = sheet_with_uvs(|p| DVec2::new(p.x % 0.3 + 5.0, p.y % 0.5));
    let manifest = bake_of(&model, &settings()).manifest;
    assert_eq!((manifest.planish, manifest.displacement.tile), (4, IVec2::new(5, 0)));
    assert!(manifest.report.private_vertices > 0 && 2 * manifest.private_texels.len() <= manifest.source.vertices);
    assert_eq!((manifest.report.unresolved_vertices, manifest.report.seam_gap), (0, 0.0));
}

#[test]
fn a_tile_that_is_not_allowed_is_named() {
    let bundle = bake_of(&in_tile(TILES[0]), &settings());
    let json: Value = serde_json::from_slice(bytes_of(&bundle, "sheet.planish.json")).unwrap();
    for tile in [json!([1001, 0]), json!([0, -1001])] {
        let mut far = json.clone();
        far["displacement"]["tile"] = tile;
        let error = Manifest::from_json(far.to_string().as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("field `displacement.tile`: "), "{error}");
    }
}
