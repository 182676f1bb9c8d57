use super::*;
use crate::source::Source;
use crate::source::read_error::ReadErrorKind;
use proptest::prelude::*;

/// A tetrahedron.
const CORNERS: [[[f32; 3]; 3]; 4] = {
    let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, 0.0], [0.2, 0.1, 1.0]];
    [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
};

/// The tetrahedron as a binary file; its normals are wrong and its attribute bytes used.
fn binary() -> Vec<u8> {
    let mut out = b"solid, says the header, but it is binary".to_vec();
    out.resize(80, b' ');
    out.extend(4_u32.to_le_bytes());
    for (i, corners) in CORNERS.iter().enumerate() {
        [[7.0, 7.0, 7.0]].iter().chain(corners).flatten().for_each(|x: &f32| out.extend(x.to_le_bytes()));
        out.extend([i as u8, 0x80]);
    }
    out
}

/// The tetrahedron as text in an unruly spelling.
fn text() -> String {
    let mut out = "solid two words\r\n".to_owned();
    for corners in CORNERS {
        out += "  FACET normal 7 7e0 -nan(ind)\r\n\touter loop\r\n";
        for [x, y, z] in corners {
            out += &format!("    vertex  {x:.3}   {y:.3} {z:e}\r\n");
        }
        out += "  endloop\r\n  endfacet\r\n";
    }
    out + "endsolid two words\r\n"
}

fn parse(bytes: &[u8]) -> Stl {
    Stl::parse(bytes.to_vec()).unwrap()
}

#[test]
fn corners_at_one_position_are_one_vertex() {
    for bytes in [binary(), text().into_bytes()] {
        let stl = parse(&bytes);
        assert_eq!((stl.data().positions().len(), stl.data().faces().len()), (4, 4));
        let faces: Vec<Vec<u32>> = stl.data().faces().iter().map(|f| f.iter().map(|c| c.position).collect()).collect();
        assert_eq!(faces, [[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]]);
        assert_eq!(stl.with_positions(stl.data().positions(), None), bytes, "nothing moves, nothing changes");
    }
    assert_eq!(parse(text().as_bytes()).data().face_line(1), Some(9));
    assert_eq!(parse(&binary()).contents(), ["4 facets with attribute bytes"]);
}

#[test]
fn signs_of_zeros_keep_no_corners_apart_and_stay() {
    let mut bytes = binary();
    // The first corner of the second facet.
    bytes[84 + 50 + 12..][..4].copy_from_slice(&(-0.0_f32).to_le_bytes());
    let stl = parse(&bytes);
    assert_eq!(stl.data().positions().len(), 4);
    assert_eq!(stl.with_positions(stl.data().positions(), None), bytes);
}

#[test]
fn facets_that_move_get_their_normal_and_others_keep_all_bytes() {
    for bytes in [binary(), text().into_bytes()] {
        let stl = parse(&bytes);
        let mut moved = stl.data().positions().to_vec();
        moved[3] = DVec3::new(0.25, 0.125, 2.0);
        let out = stl.with_positions(&moved, None);
        let again = parse(&out);
        assert_eq!(again.data().positions(), moved);
        if stl.is_text {
            let out = String::from_utf8(out).unwrap();
            let lines = |text: &str| text.split_inclusive('\n').map(str::to_owned).collect::<Vec<_>>();
            let before = text();
            let changed: Vec<String> =
                lines(&before).iter().zip(lines(&out)).filter(|(a, b)| *a != b).map(|(_, b)| b).collect();
            assert_eq!(changed.len(), 6, "three normals and three corners: {changed:?}");
            assert!(changed[1].starts_with("    vertex  0.25   0.125 2.0\r\n"), "{changed:?}");
            assert!(changed[0].starts_with("  FACET normal ") && !changed[0].contains("nan"), "{changed:?}");
        } else {
            assert_eq!((&out[..134], out.len()), (&bytes[..134], bytes.len()), "the first facet does not move");
            let facet = &out[134..184];
            assert_eq!(facet[48..], [1, 0x80]);
            let n: Vec<f32> = facet[..12].chunks(4).map(|n| f32::from_le_bytes(n.try_into().unwrap())).collect();
            let corners = [0, 2, 3].map(|v| moved[v]);
            let expected = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            assert!((DVec3::new(n[0].into(), n[1].into(), n[2].into()) - expected).length() < 1e-6, "{n:?}");
        }
    }
}

#[test]
fn wrong_counts_are_told_and_the_facets_of_the_file_are_read() {
    let count = |count: u32, mut bytes: Vec<u8>| {
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        // A file that begins with `solid` is binary only if its size goes with its count.
        bytes[..5].copy_from_slice(b"model");
        bytes
    };
    for wrong in [0, 3, 5, u32::MAX] {
        let bytes = count(wrong, binary());
        let stl = parse(&bytes);
        assert_eq!(stl.data().faces().len(), 4);
        assert!(stl.notes()[0].contains(&format!("promises {wrong} facets")), "{:?}", stl.notes());
        assert_eq!(stl.with_positions(stl.data().positions(), None), bytes);
    }
    let longer = [count(4, binary()), vec![1; 7]].concat();
    assert!(parse(&longer).notes()[0].starts_with("7 bytes behind"));
    let mut moved = parse(&longer).data().positions().to_vec();
    moved[0].x = 9.0;
    assert_eq!(parse(&longer).with_positions(&moved, None)[284..], [1; 7]);
    let shorter = count(4, binary())[..280].to_vec();
    let error = Stl::parse(shorter).unwrap_err();
    assert!(matches!(error.kind, ReadErrorKind::Truncated { count: 4, needed: 200, left: 196, .. }), "{error}");
}

#[test]
fn errors_name_the_place_and_the_facet() {
    let broken = |old: &str, new: &str| Stl::parse(text().replacen(old, new, 1).into_bytes()).unwrap_err().to_string();
    assert_eq!(broken("vertex  1.000", "vertex  one"), "line 6: facet 0: `one` is not a number");
    assert_eq!(broken("vertex  1.000", "vertex  inf"), "line 6: facet 0 has a coordinate that is not finite");
    assert_eq!(broken("  endfacet\r\n", ""), "line 8: the file ends within facet 0");
    let mut bytes = binary();
    bytes[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(Stl::parse(bytes).unwrap_err().to_string(), "byte 134: facet 1 has a coordinate that is not finite");
    assert_eq!(Stl::parse(Vec::new()).unwrap_err().kind, ReadErrorKind::Empty);
    assert!(Stl::parse(b"short".to_vec()).unwrap_err().to_string().starts_with("this is no STL file"));
    assert_eq!(Stl::parse(b"solid x\nendsolid x\n".to_vec()).unwrap_err().kind, ReadErrorKind::NoVertices);
}

#[test]
fn several_solids_and_polygons_are_one_mesh() {
    let second = "solid b\nfacet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 6 0 0\nvertex 6 1 0\nvertex 5 1 0\n\
                  endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 6 0 0\nendloop\nendfacet\nendsolid\n";
    let both = text() + second;
    let stl = parse(both.as_bytes());
    assert_eq!((stl.data().faces().len(), stl.data().faces().get(4).len()), (5, 4));
    assert_eq!(stl.contents(), ["2 solids"]);
    assert!(stl.notes()[0].contains("fewer than three corners"));
    let moved: Vec<DVec3> = stl.data().positions().iter().map(|p| *p + DVec3::Z).collect();
    let out = stl.with_positions(&moved, None);
    assert_eq!(parse(&out).data().positions(), moved);
}

#[test]
fn meshes_from_elsewhere_become_triangles() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3 4\n";
    let source = Source::parse(obj.into(), None).unwrap();
    let written = source.written_as(Format::Stl, source.data().positions(), None);
    assert_eq!(written.lost, ["polygons, which are cut into triangles"]);
    assert_eq!(written.rounding, (f64::from(0.1_f32) - 0.1).abs());
    let stl = parse(&written.bytes);
    assert_eq!((stl.data().positions().len(), stl.data().faces().len()), (4, 2));
    assert!(stl.notes().is_empty(), "{:?}", stl.notes());
}

proptest! {
    #[test]
    fn any_bytes_are_a_mesh_or_an_error(is_text: bool, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)) {
        let mut bytes = if is_text { text().into_bytes() } else { binary() };
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(stl) = Stl::parse(bytes.clone()) {
            prop_assert_eq!(stl.with_positions(stl.data().positions(), None), bytes);
        }
    }

    #[test]
    fn moved_corners_come_back(is_text: bool, moves in prop::collection::vec(prop::array::uniform3(-1e3_f32..1e3), 4)) {
        let stl = parse(&if is_text { text().into_bytes() } else { binary() });
        let moved: Vec<DVec3> = moves.into_iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let out = parse(&stl.with_positions(&moved, None));
        prop_assert_eq!(out.data().positions(), moved);
    }
}

#[test]
fn zeros_between_numbers_make_no_text_a_binary_file() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let text = format!("solid a\n{}endsolid a\n", facet.repeat(4));
    let mut bytes = text.into_bytes();
    // Behind what would be the header, in a number.
    let at = 110 + bytes[110..].windows(8).position(|w| w == b"vertex 1").unwrap() + 8;
    bytes[at] = 0;
    assert!(Stl::parse(bytes).unwrap_err().to_string().contains("is not a number"));
}
