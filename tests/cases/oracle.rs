//! tobj as a second opinion, on files that it reads correctly: without forward references, continuations, inline
//! comments, weights, elements other than faces, or corners that lack what their neighbours have.

use crate::support::{meshes_from_outside, meshes_in, root};
use glam::{DVec2, DVec3, Vec2, Vec3};
use planish_geometry::source::obj::Obj;
use std::path::Path;

/// A corner's position and uv.
type Place<P, T> = (P, Option<T>);

/// Corners of each face as tobj reads them. It numbers vertices anew in every object, group and material, so faces
/// compare by what their corners hold.
fn by_tobj(bytes: &[u8]) -> Vec<Vec<Place<Vec3, Vec2>>> {
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut &bytes[..], &tobj::LoadOptions::default(), no_materials).unwrap();
    let mut faces = Vec::new();
    for tobj::Model { mesh, .. } in models {
        let position = |c: usize| Vec3::from_slice(&mesh.positions[3 * mesh.indices[c] as usize..]);
        let uv = |c: usize| mesh.texcoord_indices.get(c).map(|&t| Vec2::from_slice(&mesh.texcoords[2 * t as usize..]));
        let triangles = vec![3; mesh.indices.len() / 3];
        let arities = if mesh.face_arities.is_empty() { &triangles } else { &mesh.face_arities };
        let mut start = 0;
        for &arity in arities {
            let corners = start..start + arity as usize;
            start = corners.end;
            faces.push(corners.map(|c| (position(c), uv(c))).collect());
        }
    }
    faces
}

fn by_planish(obj: &Obj) -> Vec<Vec<Place<DVec3, DVec2>>> {
    let corner = |c: &planish_geometry::source::Corner| {
        (obj.data().positions()[c.position as usize], c.uv().map(|uv| obj.data().uvs()[uv as usize]))
    };
    obj.data().faces().iter().map(|face| face.iter().map(corner).collect()).collect()
}

/// Whether both stand for the same decimal: `single` is the f32 nearest to it, `double` the f64. So they are half an
/// ulp of the former apart, 2⁻²⁴ of it at most, and half an ulp of the latter, for which twice that is ample.
fn same(double: f64, single: f32) -> bool {
    let half_ulps = 2f64.powi(-24) + 2f64.powi(-52);
    (double - f64::from(single)).abs() <= half_ulps * double.abs() + f64::from(f32::from_bits(1))
}

fn agree(ours: &[Vec<Place<DVec3, DVec2>>], theirs: &[Vec<Place<Vec3, Vec2>>]) -> bool {
    let same_uv = |a: Option<DVec2>, b: Option<Vec2>| match (a, b) {
        (Some(a), Some(b)) => same(a.x, b.x) && same(a.y, b.y),
        (a, b) => a.is_none() && b.is_none(),
    };
    let same_place =
        |a: &Place<DVec3, DVec2>, b: &Place<Vec3, Vec2>| (0..3).all(|k| same(a.0[k], b.0[k])) && same_uv(a.1, b.1);
    let same_face = |a: &Vec<_>, b: &Vec<_>| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_place(a, b));
    ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(a, b)| same_face(a, b))
}

#[track_caller]
fn read_alike(folder: &Path) {
    let meshes = meshes_in(folder);
    assert!(!meshes.is_empty(), "{} has no meshes", folder.display());
    for path in meshes {
        let bytes = std::fs::read(&path).unwrap();
        let theirs = by_tobj(&bytes);
        let obj = Obj::parse(bytes).unwrap();
        assert!(agree(&by_planish(&obj), &theirs), "{}", path.display());
    }
}

#[test]
fn references_read_alike() {
    read_alike(&root().join("tests/reference"));
}

#[test]
fn own_meshes_read_alike() {
    read_alike(&root().join("data"));
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn external_meshes_read_alike() {
    let folder = meshes_from_outside();
    read_alike(&folder);
    read_alike(&folder.join("scans"));
}

#[test]
fn a_difference_is_found() {
    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nvt 0.1 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let read = |faces: &str| [QUAD, faces].concat().into_bytes();
    let theirs = by_tobj(&read("g a\nf 1/1 2/2 3/3 4/4\ng b\nf 1/1 3/3 4/4\n"));
    let ours = |faces| by_planish(&Obj::parse(read(faces)).unwrap());
    assert!(agree(&ours("f 1/1 2/2 3/3 4/4\nf 1/1 3/3 4/4\n"), &theirs));
    for other in ["f 1/1 2/2 3/3 4/4\nf 1/1 3/3 2/4\n", "f 1/1 2/2 3/3 4/4\nf 1/1 3/2 4/4\n", "f 1/1 2/2 3/3 4/4\n"] {
        assert!(!agree(&ours(other), &theirs), "{other}");
    }
    assert!(!same(0.1 + 1e-8, 0.1) && same(0.1, 0.1) && same(0.0, 0.0));
}
