use super::*;
use crate::source::Source;
use crate::source::read_error::ReadErrorKind;
use glam::DVec2;
use proptest::prelude::*;

/// A square with a triangle, whose vertices have everything, in an unruly spelling.
const EVERYTHING: &str = "STCNOFF # all of it\r\n# a comment\r\n5 2 0\r\n\r\n\
    0 0 0  0 0 1  255 0 0 255  0 0\r\n1 0 0.1  0 0 1  0 255 0 255  1 0 # right\r\n1 1 0  0 1 0  0 0 255 255  1 1\r\n\
    0 1 0  1 0 0  1 2 3 255  0 1\r\n2 0 0.50  0 0 1  9 9 9 9  .5 .5\r\n4 0 1 2 3 0.5 0.5 0.5\r\n3 1 4 2\r\n";

fn parse(text: &str) -> Off {
    Off::parse(text.into()).unwrap()
}

#[test]
fn all_attributes_are_read() {
    let off = parse(EVERYTHING);
    let data = off.data();
    assert_eq!(data.positions()[4], DVec3::new(2.0, 0.0, 0.5));
    assert_eq!(data.normals()[2], DVec3::Y);
    assert_eq!(data.colours()[3], [1.0 / 255.0, 2.0 / 255.0, 3.0 / 255.0]);
    assert_eq!(data.uvs()[4], DVec2::splat(0.5));
    let corner = data.faces().get(1)[1];
    assert_eq!((corner.position, corner.uv(), corner.normal()), (4, Some(4), Some(4)));
    assert_eq!(data.face_line(1), Some(11));
    assert_eq!(off.contents(), ["1 faces with colours"]);
}

#[test]
fn only_the_numbers_that_change_change() {
    let off = parse(EVERYTHING);
    let (mut positions, mut normals) = (off.data().positions().to_vec(), off.data().normals().to_vec());
    assert_eq!(off.with_positions(&positions, Some(&normals)), EVERYTHING.as_bytes());
    positions[1].z = 0.25;
    normals[3] = DVec3::new(0.5, 0.0, 0.0);
    let expected = EVERYTHING.replace("1 0 0.1  0", "1 0 0.25  0").replace("0 1 0  1 0 0  1 2", "0 1 0  0.5 0 0  1 2");
    assert_eq!(String::from_utf8(off.with_positions(&positions, Some(&normals))).unwrap(), expected);
}

#[test]
fn the_first_word_and_the_line_of_counts_come_in_many_ways() {
    let rest = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for head in [
        "OFF\n3 1 0\n",
        "OFF 3 1 0\n",
        "3 1 0\n",
        "OFF\n3 1\n",
        "\u{feff}OFF\n3 1 3\n",
        "# x\n\nOFF # y\n# z\n3 1 0 # w\n",
    ] {
        let off = parse(&format!("{head}{rest}"));
        assert_eq!((off.data().positions().len(), off.data().faces().len()), (3, 1), "{head}");
        let mut moved = off.data().positions().to_vec();
        moved[0].x = 7.5;
        let out = String::from_utf8(off.with_positions(&moved, None)).unwrap();
        assert_eq!(out, format!("{head}7.5{}", &rest[1..]));
    }
}

#[test]
fn colours_are_read_where_none_are_promised() {
    for (colour, expected) in [("255 128 0", [1.0, 128.0 / 255.0, 0.0]), ("1.0 0.5 0.0 1.0", [1.0, 0.5, 0.0])] {
        let off = parse(&format!("OFF\n3 1 0\n0 0 0 {colour}\n1 0 0 {colour}\n0 1 0 {colour}\n3 0 1 2\n"));
        assert_eq!(off.data().colours(), [expected; 3]);
    }
}

#[test]
fn errors_name_the_line_and_the_element() {
    let broken = |old: &str, new: &str| {
        assert!(EVERYTHING.contains(old), "{old}");
        Off::parse(EVERYTHING.replacen(old, new, 1).into()).unwrap_err().to_string()
    };
    assert_eq!(broken("0 1 0  1 0 0", "0 one 0  1 0 0"), "line 8: vertex 3: `one` is not a number");
    assert_eq!(
        broken("1 0 0.1  0", "1 nan 0.1  0"),
        "vertex 1, which a face uses, has a coordinate that is not finite"
    );
    assert_eq!(broken("3 1 4 2", "3 1 5 2"), "line 11: face 1 names vertex 5: there are 5, counted from 0");
    assert_eq!(broken("3 1 4 2", "5 1 4 2"), "line 11: face 1 promises 5 corners and has 3 numbers");
    assert_eq!(broken("3 1 4 2\r\n", ""), "line 11: the file ends within face 1");
    assert_eq!(
        broken("STCNOFF", "nOFF"),
        "line 1: the file uses `nOFF`, vertices with another number of dimensions than three, which planish does not read"
    );
    assert_eq!(broken("STCNOFF #", "OFF BINARY #"), "line 1: the file uses binary OFF, which planish does not read");
    assert_eq!(
        broken("5 2 0", "five 2 0"),
        "line 3: this is no OFF file: the numbers of vertices and faces are missing"
    );
    assert!(broken("5 2 0", "4000000000 2 0").contains("promises 4000000000 × `vertex`"));
    assert!(broken("5 2 0", "5 18446744073709551615 0").contains("promises 18446744073709551615 × `face`"));
    assert_eq!(Off::parse(Vec::new()).unwrap_err().kind, ReadErrorKind::Empty);
}

#[test]
fn a_vertex_that_no_face_uses_may_be_nothing() {
    let off = parse("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\nnan nan nan\n3 0 1 2\n");
    assert_eq!(off.data().unplaced(), [3]);
    let moved: Vec<DVec3> = off.data().positions().iter().map(|p| *p + DVec3::ONE).collect();
    assert!(String::from_utf8(off.with_positions(&moved, None)).unwrap().contains("nan nan nan"));
}

#[test]
fn meshes_from_elsewhere_are_printed_with_the_attributes_of_vertices() {
    let obj =
        "v 0 0 0 1 0 0\nv 1 0 0.1 0 1 0.2\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n";
    let source = Source::parse(obj.into(), None).unwrap();
    let written = source.written_as(Format::Off, source.data().positions(), None);
    assert_eq!((written.rounding, written.lost.len()), (0.0, 0));
    let off = Off::parse(written.bytes).unwrap();
    let (a, b) = (off.data(), source.data());
    assert_eq!((a.positions(), a.uvs(), a.colours()), (b.positions(), b.uvs(), b.colours()));
    assert_eq!(a.normals(), [DVec3::Z; 3]);
}

proptest! {
    #[test]
    fn any_bytes_are_a_mesh_or_an_error(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = EVERYTHING.as_bytes().to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(off) = Off::parse(bytes.clone()) {
            prop_assert_eq!(off.with_positions(off.data().positions(), None), bytes);
        }
    }

    #[test]
    fn moved_vertices_come_back(moves in prop::collection::vec(prop::array::uniform3(-1e300_f64..1e300), 5)) {
        let off = parse(EVERYTHING);
        let moved: Vec<DVec3> = moves.into_iter().map(DVec3::from_array).collect();
        let out = Off::parse(off.with_positions(&moved, None)).unwrap();
        prop_assert_eq!(out.data().positions(), moved);
        prop_assert_eq!(out.data().colours(), off.data().colours());
    }
}
