//! Statements besides vertices and faces: objects, groups, materials, lines and points, and names in any encoding.

use super::*;

#[test]
fn several_objects_and_groups_share_one_count() {
    let obj = parse(format!("o a\n{THREE}g x y\ns 1\nf 1 2 3\no b\ng\ns off\n{THREE}f 4 5 6\nf -3 -2 -1\n"));
    assert_eq!(faces(&obj), [[0, 1, 2], [3, 4, 5], [3, 4, 5]]);
    let extras = obj.extras();
    assert_eq!((extras.objects, extras.groups, extras.smoothing_groups), (2, 2, 2));
}

#[test]
fn lines_and_points_are_no_faces() {
    let obj = parse(format!("{THREE}l 1 2 3\np 1\np 2 3\nf 1 2 3\nl 1 \\\n2\n"));
    assert_eq!((obj.data().faces().len(), obj.extras().lines, obj.extras().points), (1, 2, 2));
}

#[test]
fn unknown_statements_are_passed_over() {
    let obj = parse(format!("vp 0 1\ncstype bezier\ncurv 0 1 1 2 3\n{THREE}f 1 2 3\n\u{1}\nnonsense v 1 2 3\n"));
    assert_eq!((obj.data().positions().len(), obj.extras().other), (3, 5));
}

#[test]
fn materials_are_listed_once_in_the_order_of_use() {
    let uses = "mtllib a.mtl b.mtl\nmtllib c d.mtl\nusemtl red\nusemtl  my skin \nusemtl red\n";
    let obj = parse(format!("{uses}{THREE}f 1 2 3\n"));
    assert_eq!(obj.extras().material_libraries, [&b"a.mtl b.mtl"[..], b"c d.mtl"]);
    assert_eq!(obj.data().materials(), [&b"red"[..], b"my skin"]);
}

fn face_materials(text: &str) -> Vec<Option<Index>> {
    let obj = parse(format!("{THREE}{text}"));
    (0..obj.data().faces().len() as Index).map(|f| obj.data().face_material(f)).collect()
}

#[test]
fn a_face_has_the_material_named_last() {
    let (f, a, b) = ("f 1 2 3\n", "usemtl a\n", "usemtl b\n");
    let cases: [(&[&str], &[Option<Index>]); 5] = [
        (&[f, f], &[None; 2]),
        (&[a, f, f], &[Some(0); 2]),
        (&[f, a, f, b, f, f, a, f], &[None, Some(0), Some(1), Some(1), Some(0)]),
        // Repeated, named for nothing, and named for nothing between faces that it does not part.
        (&[a, f, a, f, b, a, f, b], &[Some(0); 3]),
        (&[f, b, a, "g x\n", f, "o y\n", f], &[None, Some(1), Some(1)]),
    ];
    for (text, expected) in cases {
        assert_eq!(face_materials(&text.concat()), expected, "{text:?}");
    }
}

/// Latin-1, UTF-8, and Shift-JIS, where the second byte of a character may be a backslash.
const NAMES: [&[u8]; 3] = [b"caf\xe9", "Größe 目".as_bytes(), b"\x83\x5c"];

#[test]
fn names_in_any_encoding() {
    for name in NAMES {
        let mut text = Vec::new();
        for keyword in ["# ", "o ", "g ", "usemtl "] {
            text.extend_from_slice(&[keyword.as_bytes(), name, b"\n"].concat());
        }
        text.extend_from_slice(THREE.as_bytes());
        text.extend_from_slice(&[b"f 1 2 3 # ", name, b"\nf 3 2 1\n"].concat());
        let obj = parse(&text);
        assert_eq!(obj.data().materials(), [name]);
        assert_eq!(faces(&obj), [[0, 1, 2], [2, 1, 0]]);
        assert_eq!(obj.with_positions(obj.data().positions(), None), text);
    }
}
