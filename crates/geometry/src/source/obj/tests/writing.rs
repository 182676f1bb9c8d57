//! Bytes that are written: changed positions and normals, and carriers.

use super::*;

/// A file whose faces name later lines, from the end and from the front, in two objects.
fn unruly() -> Obj {
    parse(concat!(
        "\u{feff}# odd\n",
        "f 1/2/1 2/1/1 3\n",
        "o first\n",
        "\tv 0.0 +0 0e0 0.25 0.5 0.75 # corner\n",
        "v  1 \\\n 0 0\n",
        "vn 0 0 1\n",
        "v 0 1 0 1.0\n",
        "vt 0 0\n",
        "vt 1 0 0\n",
        "mtllib late.mtl\n",
        "usemtl skin\n",
        "f -3/-2 -2//-1 \\\n -1/-1/-1 # face\n",
        "l 1 2\n",
        "p 3\n",
        "o second\n",
        "vn 1 0 0\n",
        "v 5 5 5\n",
        "fo 4// 1/ 2/1\n",
        "vn 0 1 0\n",
        "v 6 6 6",
    ))
}

#[test]
fn unchanged_positions_give_the_same_bytes() {
    let obj = unruly();
    assert_eq!(obj.with_positions(obj.data().positions(), Some(obj.data().normals())), obj.bytes());
    assert_eq!(obj.with_positions(obj.data().positions(), None), obj.clone().into_bytes());
}

#[test]
fn one_changed_number_changes_one_token() {
    let obj = parse("v +0.50 1e0 .5 0.1 0.2 0.3 # v\r\n\tv 1\t\\\r\n 2 3.000\r\nv 7 8 9 1\r\nf 1 2 3\r\n");
    let mut positions = obj.data().positions().to_vec();
    positions[1].y = 2.5;
    let written = String::from_utf8(obj.with_positions(&positions, None)).unwrap();
    assert_eq!(written, "v +0.50 1e0 .5 0.1 0.2 0.3 # v\r\n\tv 1\t\\\r\n 2.5 3.000\r\nv 7 8 9 1\r\nf 1 2 3\r\n");
}

#[test]
fn a_sign_of_zero_is_a_change() {
    let obj = parse(format!("{THREE}f 1 2 3\n"));
    let mut positions = obj.data().positions().to_vec();
    positions[0].x = -0.0;
    assert!(obj.with_positions(&positions, None).starts_with(b"v -0.0 0 0\n"));
}

#[test]
fn normals_change_only_where_they_are_given() {
    let obj = unruly();
    let rotated = [DVec3::Y, DVec3::X, DVec3::new(0.5, 1.0, 0.0)];
    let written = parse(obj.with_positions(obj.data().positions(), Some(&rotated)));
    assert_eq!(written.data().normals(), rotated);
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    assert!(text.contains("vn 0 1.0 0.0\n") && text.contains("vn 1 0 0\n") && text.contains("vn 0.5 1 0\n"), "{text}");
}

fn carrier_of(obj: &Obj) -> (Obj, Vec<DVec3>, Vec<Vec3>) {
    let positions: Vec<DVec3> = obj.data().positions().iter().map(|p| *p + 0.1).collect();
    let normals: Vec<Vec3> = (0..positions.len()).map(|i| Vec3::new(i as f32, 1.0, 0.3).normalize()).collect();
    (parse(obj.carrier(&positions, &normals, None, "new name.mtl")), positions, normals)
}

/// Asserts that the carrier of a file has the properties that every carrier has.
#[track_caller]
fn is_a_carrier(obj: &Obj) -> Obj {
    let (carrier, positions, normals) = carrier_of(obj);
    assert_eq!(bits(carrier.data().positions()), bits(&positions));
    assert_eq!(carrier.data().uvs(), obj.data().uvs());
    let single: Vec<Vec3> = carrier.data().normals().iter().map(|n| n.as_vec3()).collect();
    assert_eq!(single, normals, "one for each `v` line");
    let expected: Vec<Vec<_>> =
        obj.data().faces().iter().map(|f| f.iter().map(|c| (c.position, c.uv())).collect()).collect();
    let found: Vec<Vec<_>> =
        carrier.data().faces().iter().map(|f| f.iter().map(|c| (c.position, c.uv())).collect()).collect();
    assert_eq!(found, expected);
    assert!(carrier.data().faces().items().iter().all(|c| c.normal() == Some(c.position)));
    assert_eq!(carrier.extras().material_libraries, [b"new name.mtl"]);
    let (before, after) = (obj.extras(), carrier.extras());
    let counts =
        |e: &Extras| [e.objects, e.groups, e.smoothing_groups, e.lines, e.points, e.extended_vertices, e.other];
    assert_eq!(counts(after), counts(before));
    carrier
}

fn text(obj: &Obj) -> String {
    String::from_utf8_lossy(obj.bytes()).into_owned()
}

#[test]
fn an_unruly_file_becomes_a_carrier() {
    let carrier = is_a_carrier(&unruly());
    assert_eq!(carrier.data().materials(), [&b"planish"[..], b"skin"]);
    // Before the first face, and nowhere else, stand library and material; behind the last line the last normal.
    let text = text(&carrier);
    assert!(text.starts_with("\u{feff}# odd\nmtllib new name.mtl\nusemtl planish\nf 1/2/1 2/1/2 3//3\n"), "{text}");
    assert!(text.lines().last().is_some_and(|line| line.starts_with("vn ")), "{text}");
    assert!(text.contains("l 1 2\np 3\no second\n") && text.contains(" # corner\n"), "{text}");
    assert!(text.contains("f 1/1/1 2//2 \\\n 3/2/3 # face\n"), "{text}");
}

#[test]
fn a_carrier_of_each_line_ending_keeps_it() {
    for eol in ["\n", "\r\n", "\r"] {
        let source = format!("{THREE}vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 3 2 1\nv 9 9 9\n").replace('\n', eol);
        let carrier = is_a_carrier(&parse(source));
        let lines = text(&carrier).matches(eol).count();
        // Three vertices, the uv, library, material, three normals, two faces, a vertex and its normal.
        assert_eq!(lines, 13, "{}", text(&carrier));
        let breaks = |b: &&u8| matches!(b, b'\n' | b'\r');
        assert_eq!(carrier.bytes().iter().filter(breaks).count(), lines * eol.len());
    }
}

#[test]
fn a_last_line_that_ends_in_a_backslash_swallows_no_normal() {
    for end in ["\\", " \\\n", " \\\n\n", " # \\"] {
        is_a_carrier(&parse(format!("{THREE}f 1 2 3\nv 9 9 9{end}")));
    }
}

#[test]
fn a_library_is_named_before_its_first_use() {
    let carrier = is_a_carrier(&parse(format!("{THREE}usemtl skin\nf 1 2 3\nmtllib late.mtl\nmtllib later.mtl\n")));
    assert!(text(&carrier).contains("mtllib new name.mtl\nusemtl skin\nvn "), "{}", text(&carrier));
    assert_eq!(carrier.data().materials(), [b"skin"]);
}

#[test]
fn the_new_library_replaces_the_old_one() {
    let carrier = is_a_carrier(&parse(format!("mtllib old.mtl\n# c\n{THREE}f 1 2 3\n")));
    assert!(text(&carrier).starts_with("mtllib new name.mtl\n# c\nv "), "{}", text(&carrier));
}

#[test]
fn normals_stand_before_the_faces_that_name_them() {
    let carrier = is_a_carrier(&parse(format!("{THREE}f 1 2 3\n{THREE}f 4 5 6\n")));
    let keywords: Vec<String> = text(&carrier).lines().map(|l| l.split(' ').next().unwrap().to_owned()).collect();
    let once = ["vn", "vn", "vn", "f"];
    let expected = [&["v", "v", "v", "mtllib", "usemtl"][..], &once, &["v", "v", "v"], &once].concat();
    assert_eq!(keywords, expected);
}

#[test]
fn a_nul_in_a_comment_does_not_keep_what_is_written_from_being_read() {
    // The carrier lacks the `vt` lines before it, so that the NUL comes near its start.
    let uvs = "vt 0.123456 0.654321\n".repeat(300);
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{uvs}# \0\nf 1/1 2/2 3/3\n");
    assert!(text.find('\0').unwrap() > 4096);
    let obj = Obj::parse(text.into()).unwrap();
    let carrier = obj.carrier(obj.data().positions(), &[Vec3::Z; 3], Some(&[Vec2::ZERO; 3]), "m.mtl");
    assert!(Obj::parse(carrier).is_ok());
    // What cannot be read is called by its name.
    let binary = Obj::parse(b"v 0 0 0\n\0\0\0".to_vec()).unwrap_err();
    assert_eq!(binary.kind, ObjErrorKind::Binary { offset: 8 });
}

#[test]
fn a_carrier_of_a_carrier_is_the_same_file() {
    let (carrier, positions, normals) = carrier_of(&unruly());
    assert_eq!(carrier.carrier(&positions, &normals, None, "new name.mtl"), carrier.bytes());
}
