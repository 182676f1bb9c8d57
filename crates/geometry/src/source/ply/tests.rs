use super::*;
use crate::source::Source;
use crate::source::convert::Written;
use crate::source::read_error::{Place, ReadErrorKind};
use glam::DVec2;
use proptest::prelude::*;

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// Bytes of numbers, given as pairs of type and value, in a format.
fn body(format: &str, rows: &[Vec<(Scalar, f64)>]) -> Vec<u8> {
    let encoding = match format {
        "ascii" => scalar::Encoding::Text,
        "binary_little_endian" => scalar::Encoding::Little,
        _ => scalar::Encoding::Big,
    };
    let mut out = Vec::new();
    for row in rows {
        for (k, (scalar, x)) in row.iter().enumerate() {
            if k > 0 && encoding == scalar::Encoding::Text {
                out.push(b' ');
            }
            scalar.write(*x, encoding, &mut out);
        }
        if encoding == scalar::Encoding::Text {
            out.push(b'\n');
        }
    }
    out
}

/// A tetrahedron with everything that a file can have: a list among the properties of vertices, elements before, between and after
/// that nobody knows, properties in an unusual order, colours, normals and texture coordinates of faces.
fn everything(format: &str) -> Vec<u8> {
    use Scalar::*;
    let header = format!(
        "ply\r\nformat {format} 1.0\r\ncomment made by hand\r\ncomment TextureFile my skin.png\r\nobj_info scanned\r\n\
         element camera 1\r\nproperty list uchar short rays\r\n\
         element vertex 4\r\nproperty double z\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n\
         property list uchar int links\r\nproperty float x\r\nproperty uchar red\r\nproperty uchar green\r\n\
         property uchar blue\r\nproperty short quality\r\nproperty double y\r\n\
         element patch 2\r\nproperty int a\r\n\
         element face 4\r\nproperty list uchar int vertex_indices\r\nproperty list uchar float texcoord\r\n\
         property int texnumber\r\nproperty uchar flags\r\n\
         element edge 1\r\nproperty int vertex1\r\nproperty int vertex2\r\nend_header\r\n"
    );
    let mut rows = vec![vec![(U8, 2.0), (I16, -3.0), (I16, 7.0)]];
    for v in 0..4 {
        let [x, y, z] = [[0.0, 0.1, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, 0.3], [0.2, 0.1, 1.0]][v];
        let normal = (0..3).map(|k| (F32, f64::from(u8::from(k == v % 3))));
        let links = std::iter::once((U8, v as f64)).chain((0..v).map(|k| (I32, k as f64)));
        let mut row = vec![(F64, z)];
        row.extend(normal);
        row.extend(links);
        row.extend([(F32, x), (U8, 255.0), (U8, v as f64), (U8, 0.0), (I16, -5.0), (F64, y)]);
        rows.push(row);
    }
    rows.extend([vec![(I32, 5.0)], vec![(I32, -6.0)]]);
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
        let mut row = vec![(U8, 3.0)];
        row.extend(face.map(|v| (I32, f64::from(v))));
        row.push((U8, 6.0));
        row.extend(face.iter().flat_map(|v| [(F32, f64::from(*v) / 4.0), (F32, 0.5)]));
        row.extend([(I32, 0.0), (U8, 9.0)]);
        rows.push(row);
    }
    rows.push(vec![(I32, 0.0), (I32, 1.0)]);
    [header.into_bytes(), body(format, &rows)].concat()
}

fn parse(bytes: &[u8]) -> Ply {
    Ply::parse(bytes.to_vec()).unwrap()
}

#[test]
fn every_encoding_is_read_alike() {
    for format in FORMATS {
        let ply = parse(&everything(format));
        let data = ply.data();
        let rounded = |x: f32| f64::from(x);
        let x = if format == "ascii" { 0.2 } else { rounded(0.2) };
        assert_eq!(data.positions()[3], DVec3::new(x, 0.1, 1.0), "{format}");
        assert_eq!(data.normals()[1], DVec3::Y);
        assert_eq!(data.colours()[2], [1.0, 2.0 / 255.0, 0.0]);
        let corners: Vec<_> = data.faces().get(1).iter().map(|c| (c.position, c.normal())).collect();
        assert_eq!(corners, [(0, Some(0)), (1, Some(1)), (3, Some(3))]);
        let uvs: Vec<DVec2> = data.faces().get(1).iter().map(|c| data.uvs()[c.uv().unwrap() as usize]).collect();
        assert_eq!(uvs, [DVec2::new(0.0, 0.5), DVec2::new(0.25, 0.5), DVec2::new(0.75, 0.5)]);
        assert_eq!(data.uvs().len(), 4, "equal texture coordinates are one");
        assert_eq!((data.materials(), data.face_material(3)), (&[b"my skin".to_vec()][..], Some(0)));
        assert_eq!(ply.embedded_library(), b"newmtl my skin\nmap_Kd my skin.png\n");
        assert_eq!(data.face_line(1), (format == "ascii").then_some(39), "{format}");
        let contents = ply.contents().join("; ");
        for word in ["1 × element `camera`", "2 × element `patch`", "2 comments", "links, quality", "flags"] {
            assert!(contents.contains(word), "{contents}");
        }
    }
}

#[test]
fn only_the_numbers_that_change_change() {
    for format in FORMATS {
        let bytes = everything(format);
        let ply = parse(&bytes);
        let (positions, normals) = (ply.data().positions().to_vec(), ply.data().normals().to_vec());
        assert_eq!(ply.with_positions(&positions, Some(&normals)), bytes, "{format}");
        let mut moved = positions;
        moved[2].y = 1.0 / 3.0;
        let out = ply.with_positions(&moved, None);
        let again = parse(&out);
        assert_eq!(again.data().positions(), moved);
        let kept = again.with_positions(ply.data().positions(), None);
        assert_eq!(kept.len(), bytes.len());
        if format != "ascii" {
            let changed: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i] != out[i]).collect();
            assert!(changed[changed.len() - 1] - changed[0] < 8, "{format}: only one double changes");
        } else {
            let lines = |bytes: &[u8]| String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect::<Vec<_>>();
            let differ = lines(&bytes).iter().zip(lines(&out)).filter(|(a, b)| *a != b).count();
            assert_eq!(differ, 1);
        }
    }
}

#[test]
fn single_precision_is_rounded_to_nearest_and_the_rounding_is_told() {
    for format in FORMATS {
        let source = Source::Ply(parse(&everything(format)));
        let mut moved = source.data().positions().to_vec();
        moved[1].x = 1.0 / 3.0;
        let written = source.written_as(Format::Ply, &moved, None);
        let rounding = (f64::from(1.0_f32 / 3.0) - 1.0 / 3.0).abs();
        assert_eq!(written.rounding, rounding, "{format}");
        let read = parse(&written.bytes).data().positions()[1].x as f32;
        assert_eq!(read, 1.0_f32 / 3.0, "{format}");
    }
}

#[test]
fn coordinates_that_are_whole_numbers_stay_whole() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty short x\nproperty int y\nproperty uchar z\n\
                element face 1\nproperty list uchar int vertex_index\nend_header\n1 2 3\n-4 5 6\n7 8 9\n3 0 1 2\n";
    let source = Source::Ply(parse(text.as_bytes()));
    let mut moved = source.data().positions().to_vec();
    moved[1] = DVec3::new(-4.4, 5.6, 400.0);
    let written = source.written_as(Format::Ply, &moved, None);
    assert!(String::from_utf8(written.bytes).unwrap().contains("\n-4 6 255\n7 8 9\n"));
    assert!((written.rounding - DVec3::new(0.4, 0.4, 145.0).length()).abs() < 1e-9);
}

#[test]
fn triangle_strips_become_triangles() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 0\n8 0 1 2 3 -1 1 4 3\n";
    let ply = parse(text.as_bytes());
    let faces: Vec<Vec<u32>> = ply.data().faces().iter().map(|f| f.iter().map(|c| c.position).collect()).collect();
    assert_eq!(faces, [[0, 1, 2], [2, 1, 3], [1, 4, 3]]);
}

#[test]
fn texture_coordinates_of_vertices_have_many_names() {
    for names in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float {}\nproperty float {}\nelement face 1\nproperty list uchar uint vertex_indices\nend_header\n\
             0 0 0 0 1\n1 0 0 1 1\n0 1 0 nan 0\n3 0 1 2\n",
            names[0], names[1]
        );
        let ply = parse(text.as_bytes());
        assert_eq!(ply.data().uvs()[1], DVec2::ONE);
        assert_eq!(ply.data().faces().items()[1].uv(), Some(1));
    }
}

/// A square as text, with a line of the header, of the vertices or of the faces replaced.
fn square(old: &str, new: &str) -> Vec<u8> {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n1 1 0\n0 1 0\n5 5 5\n3 0 1 2\n3 0 2 3\n";
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1).into_bytes()
}

#[test]
fn vertices_that_no_face_uses_may_be_nothing() {
    let bytes = square("5 5 5", "nan -inf 0");
    let ply = parse(&bytes);
    assert_eq!(ply.data().unplaced(), [4]);
    assert!(ply.notes()[0].contains("the first is vertex 4"), "{:?}", ply.notes());
    let moved: Vec<DVec3> = ply.data().positions().iter().map(|p| *p + DVec3::Z).collect();
    let out = String::from_utf8(ply.with_positions(&moved, None)).unwrap();
    assert!(out.contains("nan -inf 0\n") && out.contains("1 1 1.0\n"), "{out}");
}

#[test]
fn faces_with_two_corners_stay_in_the_file_and_out_of_the_surface() {
    let ply = parse(&square("3 0 1 2\n", "2 0 1\n"));
    assert_eq!(ply.data().faces().len(), 1);
    assert_eq!(ply.data().face_line(0), Some(16));
    assert!(ply.notes()[0].contains("the first is face 0"), "{:?}", ply.notes());
}

#[test]
fn errors_name_the_place_and_the_element() {
    for (old, new, expected) in [
        ("ply\n", "plY\n", "this is no PLY file: its first line is not `ply`"),
        (
            "format ascii 1.0",
            "format gzip 1.0",
            "line 2: the file uses the PLY format `gzip`, which planish does not read",
        ),
        ("element vertex 5", "element vertex five", "line 3: `element vertex five` is no line of a PLY header"),
        ("element vertex 5", "element points 5", "no vertices: the file has no mesh"),
        ("property float z", "property float w", "the element `vertex` lacks `x`, `y` or `z`"),
        ("end_header\n", "", "line 9: `0 0 0` is no line of a PLY header"),
        ("1 1 0\n", "1 one 0\n", "line 12: vertex 2: `one` is not a number"),
        ("1 1 0\n", "1 nan 0\n", "vertex 2, which a face uses, has a coordinate that is not finite"),
        ("3 0 2 3\n", "3 0 2 5\n", "line 16: face 1 names vertex 5: there are 5, counted from 0"),
        ("3 0 2 3\n", "3 0 2 -1\n", "line 16: face 1 names vertex -1: there are 5, counted from 0"),
        ("3 0 2 3\n", "-3 0 2 3\n", "line 16: face 1: a list cannot have -3 items"),
        ("3 0 2 3\n", "4 0 2 3\n", "the file ends within face 1"),
        ("element face 2", "element face 0", "no faces: planish works on surfaces, and these are points"),
    ] {
        let error = Ply::parse(square(old, new)).unwrap_err().to_string();
        assert!(error.ends_with(expected), "{new}: {error}");
    }
    assert_eq!(Ply::parse(Vec::new()).unwrap_err().kind, ReadErrorKind::Empty);
}

#[test]
fn counts_that_the_file_has_no_space_for_are_refused_before_memory_is_taken() {
    for count in ["4000000000", "18446744073709551615"] {
        for format in FORMATS {
            let text = String::from_utf8(square("format ascii 1.0", &format!("format {format} 1.0"))).unwrap();
            for element in ["vertex 5", "face 2"] {
                let claim = format!("{} {count}", element.split(' ').next().unwrap());
                let error = Ply::parse(text.replace(element, &claim).into_bytes()).unwrap_err();
                assert!(matches!(error.kind, ReadErrorKind::Truncated { .. }), "{error}");
                assert!(matches!(error.place, Place::Byte(_)));
            }
        }
    }
    // The list of a face may promise too much as well.
    let mut bytes = everything("binary_little_endian");
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let at = text.find("list uchar int vertex_indices").unwrap();
    bytes.splice(at..at + 10, *b"list uint ");
    assert!(Ply::parse(bytes).is_err());
}

#[test]
fn a_cut_file_is_refused_wherever_it_is_cut() {
    for format in FORMATS {
        let bytes = everything(format);
        for end in 0..bytes.len() - 3 {
            assert!(Ply::parse(bytes[..end].to_vec()).is_err(), "{format}: {end}");
        }
    }
}

#[test]
fn a_mesh_from_elsewhere_is_printed_with_all_its_attributes() {
    let obj = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0.1 1 0 0 0 1\nv 0 0 1 1 1 1\nvt 0 0\nvt 0.5 0\nvt 1 1\nvn 0 0 1\n\
               f 1/1/1 2/2/1 3/3/1\nf 1/3 3/3 4/1\n";
    let source = Source::parse(obj.into(), None).unwrap();
    let Written { bytes, rounding, lost } = source.written_as(Format::Ply, source.data().positions(), None);
    let ply = parse(&bytes);
    assert_eq!(ply.data().positions(), source.data().positions(), "double precision, because 0.1 needs it");
    assert_eq!((rounding, lost.as_slice()), (0.0, &["normals".to_owned()][..]));
    assert_eq!(ply.data().colours(), source.data().colours());
    let uv = |data: &MeshData, c: usize| data.uvs()[data.faces().items()[c].uv().unwrap() as usize];
    assert!((0..6).all(|c| uv(ply.data(), c) == uv(source.data(), c)));
}

proptest! {
    #[test]
    fn any_bytes_are_a_mesh_or_an_error(mut bytes in proptest::sample::select(FORMATS.map(everything).to_vec()),
                                        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)) {
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(ply) = Ply::parse(bytes.clone()) {
            prop_assert_eq!(ply.with_positions(ply.data().positions(), None), bytes);
        }
    }

    #[test]
    fn moved_vertices_come_back_and_all_else_stays(format in proptest::sample::select(FORMATS.to_vec()),
                                                   moves in prop::collection::vec(prop::array::uniform3(-1e6_f64..1e6), 4)) {
        let bytes = everything(format);
        let ply = parse(&bytes);
        let moved: Vec<DVec3> = moves.into_iter().map(DVec3::from_array).collect();
        let out = parse(&ply.with_positions(&moved, None));
        for (p, q) in out.data().positions().iter().zip(&moved) {
            prop_assert_eq!((p.as_vec3().x, p.y, p.z), (q.as_vec3().x, q.y, q.z));
        }
        // Moved back, the binary file is the old one again; in a text file only spellings differ.
        let back = out.with_positions(ply.data().positions(), None);
        if format != "ascii" {
            prop_assert_eq!(back, bytes);
        }
    }
}
