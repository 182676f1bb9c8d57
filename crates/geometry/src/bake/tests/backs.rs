//! Laws of leaves, whose two sides are both in the mesh.

use super::*;
use crate::source::backs::Backs;
use crate::source::{Corner, Source};

/// Texture coordinates of the back.
#[derive(Clone, Copy, PartialEq)]
enum BackUvs {
    Beside,
    OfFront,
    None,
}

/// A rough sheet with a back, which has positions of its own where `is_own` says so.
fn leaf(is_own: impl Fn(Index) -> bool, uvs: BackUvs) -> Arrays {
    let front = Arrays { normals: Vec::new(), corner_normals: Vec::new(), ..sheet() };
    let mut leaf = front.clone();
    let count = front.positions.len() as Index;
    leaf.positions.extend_from_slice(&front.positions);
    let own = |v: &Index| if is_own(*v) { v + count } else { *v };
    for face in front.faces.iter() {
        leaf.faces.push(face.iter().rev().map(&own));
    }
    leaf.uvs.extend(front.uvs.iter().map(|uv| *uv + DVec2::new(0.25, 0.0)));
    let shift = if uvs == BackUvs::Beside { front.uvs.len() as Index } else { 0 };
    let of_back = |face: &[Option<Index>]| face.iter().rev().map(|uv| uv.map(|uv| uv + shift)).collect::<Vec<_>>();
    leaf.corner_uvs.extend(front.corner_uvs.chunks(4).flat_map(of_back));
    leaf.face_materials.extend_from_within(..);
    if uvs == BackUvs::None {
        (leaf.uvs, leaf.corner_uvs) = (Vec::new(), Vec::new());
    }
    leaf
}

fn model_of(leaf: &Arrays) -> Model {
    Model::new(as_obj(leaf), Welding::Exact)
}

fn all_kinds() -> [MapKind; 3] {
    [MapKind::Scalar, MapKind::VectorObject, MapKind::VectorTangent]
}

fn settings(map: MapKind) -> BakeSettings {
    BakeSettings { target: Denoiser::Laplacian(Laplacian::default()).into(), map, ..BakeSettings::default() }
}

/// Faces of a mesh with the least cosine between them and the normals that their corners name.
fn faces_and_light(mesh: &MeshData) -> (usize, f64) {
    let cosine = |face: &[Corner]| {
        let points = face.iter().map(|corner| mesh.positions()[corner.position as usize]);
        let normal = crate::mesh::polygon::newell(points).normalize();
        let named = face.iter().map(|corner| mesh.normals()[corner.normal().unwrap() as usize]);
        named.map(|n| n.dot(normal)).fold(1.0, f64::min)
    };
    (mesh.faces().len(), mesh.faces().iter().map(cosine).fold(1.0, f64::min))
}

/// Triangles of two sheets.
const TRIANGLES: usize = (4 * SIDE * SIDE) as usize;

#[test]
fn both_sides_of_a_leaf_are_lit_and_displaced_alike() {
    for uvs in [BackUvs::Beside, BackUvs::None] {
        let model = model_of(&leaf(|_| true, uvs));
        let count = model.surface().positions().len();
        for map in all_kinds().into_iter().filter(|map| uvs != BackUvs::None || *map != MapKind::VectorTangent) {
            let bundle = bake_of(&model, &settings(map));
            let (manifest, report) = (&bundle.manifest, &bundle.manifest.report);
            assert_eq!(bundle.shared_backs, 0);
            assert_eq!((manifest.planish, manifest.backs.indices().count()), (5, count));
            assert_eq!(manifest.normal_map.is_some(), uvs == BackUvs::Beside);
            // Half a quantum for each channel, and single precision.
            let half = 0.5 * 3f64.sqrt() * report.quantum + 1e-6;
            assert!(report.max_error <= half && report.unresolved_vertices == 0, "{report:?}");

            let carrier = Obj::parse(bytes_of(&bundle, "sheet.obj").to_vec()).unwrap();
            let vertices = displace::baked_vertices(&carrier.clone().into(), manifest, &|| None).unwrap();
            let own = displace::baked_vertices(model.source(), manifest, &|| Some(carrier.clone())).unwrap();
            let map = Displacement::decode(
                bytes_of(&bundle, &manifest.displacement.file),
                map,
                manifest.displacement.size(),
                manifest.displacement.encoding(),
            );
            let map = map.unwrap();
            for (front, back) in vertices.iter().zip(&vertices[count..]) {
                assert_eq!(front.normal, -back.normal);
                let [front, back] = [front, back].map(|vertex| vertex.displaced(&map, 1.0));
                // A quantum apart at most: each is half of one from the same place.
                assert!(f64::from(front.distance(back)) <= 2.0 * half, "{front} {back}");
            }
            for (carried, own) in vertices.iter().zip(&own) {
                assert!(carried.displaced(&map, 1.0).distance(own.displaced(&map, 1.0)) < 1e-6);
            }
            // Angles between neighbours of this rough sheet reach 60°.
            let (faces, light) = faces_and_light(carrier.data());
            assert!(faces == 2 * (SIDE * SIDE) as usize && light > 0.1, "{faces} {light}");
            let glb = Source::parse(bytes_of(&bundle, "sheet.glb").to_vec(), None).unwrap();
            let (faces, light) = faces_and_light(glb.data());
            assert!(faces == TRIANGLES && light > 0.1, "{faces} {light}");

            let image = bytes_of(&bundle, &manifest.displacement.file);
            let written = WrittenFiles { displacement: &[image], carrier: carrier.data() };
            let again = check(&model, manifest, &settings(manifest.displacement.map).target, written, &Silent);
            assert_eq!(&again.unwrap(), report);
        }
    }
}

#[test]
fn a_back_that_shares_vertices_or_texels_is_in_the_binary_gltf_all_the_same() {
    let half = |v: Index| v % (SIDE + 1) > SIDE / 2;
    let cases = [
        (leaf(|_| false, BackUvs::Beside), (2 * SIDE * SIDE) as usize / 2, 0),
        (leaf(|_| true, BackUvs::OfFront), (2 * SIDE * SIDE) as usize / 2, 0),
        // Of the right half only the backs that touch no vertex of the left one have a side of their own.
        (leaf(half, BackUvs::Beside), (SIDE * (SIDE / 2 + 1)) as usize, ((SIDE + 1) * (SIDE / 2)) as usize),
    ];
    for (arrays, shared, own) in cases {
        let model = model_of(&arrays);
        let bundle = bake_of(&model, &settings(MapKind::Scalar));
        assert_eq!((bundle.shared_backs, bundle.manifest.backs.indices().count()), (shared, own));
        let report = &bundle.manifest.report;
        assert!(report.max_error <= 0.5 * report.quantum + 1e-6, "{report:?}");
        assert!(bundle.manifest.normal_map.is_some());
        let glb = Source::parse(bytes_of(&bundle, "sheet.glb").to_vec(), None).unwrap();
        let (faces, light) = faces_and_light(glb.data());
        assert!(faces == TRIANGLES && light > 0.1, "{faces} {light}");
        assert_eq!(
            Obj::parse(bytes_of(&bundle, "sheet.obj").to_vec()).unwrap().data().faces().len(),
            model.data().faces().len()
        );
    }
}

#[test]
fn only_faces_the_other_way_round_are_backs() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let backs = |faces: &str| {
        let obj = Obj::parse(format!("{square}{square}{faces}").into_bytes()).unwrap();
        Backs::of(&Model::new(obj, Welding::Exact))
    };
    let vertices = |backs: &Backs| backs.vertices().to_vec();
    let two = backs("f 1 2 3 4\nf 8 7 6 5\n");
    assert_eq!((two.pairs(), vertices(&two)), (&[[1, 0]][..], vec![4, 5, 6, 7]));
    // Another layer of the front, with the `v` lines of the back, makes them those of a front.
    let three = backs("f 1 2 3 4\nf 8 7 6 5\nf 6 7 8 5\n");
    assert_eq!((three.pairs(), vertices(&three)), (&[[1, 0]][..], vec![]));
    let repeated = backs("f 1 2 3 4\nf 7 8 5 6\n");
    assert_eq!(repeated, Backs::default());
    // Corners that repeat are none.
    let doubled = backs("f 1 2 3 4\nf 8 7 7 6 5 5\n");
    assert_eq!(doubled.pairs(), [[1, 0]]);
}
