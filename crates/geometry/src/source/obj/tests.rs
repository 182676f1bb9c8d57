//! Tests of the spellings that files in the wild use, and of the bytes that are written.

use super::*;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Three vertices that a face can name.
const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[track_caller]
fn parse(text: impl AsRef<[u8]>) -> Obj {
    Obj::parse(text.as_ref().to_vec()).unwrap()
}

/// Line and kind of the error.
#[track_caller]
fn error(text: impl AsRef<[u8]>) -> (Option<u32>, ObjErrorKind) {
    let ObjError { line, kind } = Obj::parse(text.as_ref().to_vec()).unwrap_err();
    (line, kind)
}

/// Indices that a corner names, counted from 0: position, uv, normal.
type Named = (Index, Option<Index>, Option<Index>);

fn corners(obj: &Obj) -> Vec<Vec<Named>> {
    obj.data().faces().iter().map(|face| face.iter().map(|c| (c.position, c.uv(), c.normal())).collect()).collect()
}

/// Position of each corner of each face.
fn faces(obj: &Obj) -> Vec<Vec<Index>> {
    obj.data().faces().iter().map(|face| face.iter().map(|c| c.position).collect()).collect()
}

/// A file must be the plain triangle, whatever its spelling.
#[track_caller]
fn is_the_triangle(text: impl AsRef<[u8]>) {
    let obj = parse(text);
    assert_eq!(obj.data().positions(), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(faces(&obj), [[0, 1, 2]]);
}

fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

mod corner_spellings {
    use super::*;

    const EACH_THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n";

    #[track_caller]
    fn reads(face: &str, uvs: [Option<Index>; 3], normals: [Option<Index>; 3]) {
        let obj = parse(format!("{EACH_THREE}{face}\n"));
        assert_eq!(corners(&obj), [[0, 1, 2].map(|k| (k, uvs[k as usize], normals[k as usize]))]);
    }

    const NONE: [Option<Index>; 3] = [None; 3];
    const ALL: [Option<Index>; 3] = [Some(0), Some(1), Some(2)];

    #[test]
    fn position_only() {
        reads("f 1 2 3", NONE, NONE);
    }

    #[test]
    fn position_and_uv() {
        reads("f 1/1 2/2 3/3", ALL, NONE);
    }

    #[test]
    fn position_and_normal() {
        reads("f 1//1 2//2 3//3", NONE, ALL);
    }

    #[test]
    fn all_three() {
        reads("f 1/1/1 2/2/2 3/3/3", ALL, ALL);
    }

    #[test]
    fn slashes_with_nothing_behind() {
        reads("f 1/ 2// 3//", NONE, NONE);
        reads("f 1/1/ 2/2/ 3/3/", ALL, NONE);
    }

    #[test]
    fn mixed_in_one_face() {
        reads("f 1 2/2 3//3", [None, Some(1), None], [None, None, Some(2)]);
    }

    #[test]
    fn mixed_in_one_file() {
        let obj = parse(format!("{EACH_THREE}f 1 2 3\nf 1/3 2/2 3/1\nf 3//1 2//1 1//1\n"));
        let expected = [
            [(0, None, None), (1, None, None), (2, None, None)],
            [(0, Some(2), None), (1, Some(1), None), (2, Some(0), None)],
            [(2, None, Some(0)), (1, None, Some(0)), (0, None, Some(0))],
        ];
        assert_eq!(corners(&obj), expected);
    }

    #[test]
    fn a_plus_in_front() {
        reads("f +1/+1 +2/+2 +3/+3", ALL, NONE);
    }

    #[test]
    fn leading_zeros() {
        reads("f 001 0002 3", NONE, NONE);
    }

    #[test]
    fn negative_indices_count_from_the_line() {
        reads("f -3/-3/-3 -2/-2/-2 -1/-1/-1", ALL, ALL);
        let obj = parse(format!("{THREE}f -3 -2 -1\nv 0 0 1\nf -4 -3 -1\n"));
        assert_eq!(faces(&obj), [[0, 1, 2], [0, 1, 3]]);
    }

    #[test]
    fn forward_references() {
        let obj = parse(format!("f 1/2/1 2/1/1 4/1/1\n{THREE}v 0 0 1\nvt 0 0\nvt 1 1\nvn 1 0 0\n"));
        assert_eq!(corners(&obj), [[(0, Some(1), Some(0)), (1, Some(0), Some(0)), (3, Some(0), Some(0))]]);
    }

    #[test]
    fn polygons() {
        let obj = parse("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 .5 0\nf 1 2 3 4\nf 1 2 3 4 5\nf 5 4 3\n");
        assert_eq!(faces(&obj), [vec![0, 1, 2, 3], vec![0, 1, 2, 3, 4], vec![4, 3, 2]]);
    }

    #[test]
    fn the_old_name_of_a_face() {
        is_the_triangle(format!("{THREE}fo 1 2 3\n"));
    }
}

mod layout {
    use super::*;

    #[test]
    fn every_line_ending() {
        for eol in ["\n", "\r\n", "\r"] {
            is_the_triangle(format!("# first\n{THREE}\nf 1 2 3\n").replace('\n', eol));
        }
    }

    #[test]
    fn mixed_line_endings() {
        is_the_triangle("v 0 0 0\r\nv 1 0 0\nv 0 1 0\r\nf 1 2 3");
    }

    #[test]
    fn no_final_line_end() {
        is_the_triangle(format!("{THREE}f 1 2 3"));
    }

    #[test]
    fn tabs_and_runs_of_blanks() {
        is_the_triangle("v\t0\t0\t0\nv  1 \t 0   0\nv 0 1\t0\nf\t1  2\t3\n");
    }

    #[test]
    fn blanks_around_a_line() {
        is_the_triangle("  v 0 0 0  \n\tv 1 0 0\t\n v 0 1 0 \r\n   \n\t\n  f 1 2 3   \n");
    }

    #[test]
    fn a_byte_order_mark() {
        is_the_triangle(format!("\u{feff}{THREE}f 1 2 3\n"));
        is_the_triangle(format!("\u{feff}# exporter\n{THREE}f 1 2 3\n"));
    }

    #[test]
    fn inline_comments() {
        is_the_triangle("v 0 0 0 # 9 9\nv 1 0 0#\nv 0 1 0 #c\nf 1 2 3 # 1 2\n# f 3 2 1\n  # f 3 2 1\n");
    }

    #[test]
    fn continued_positions() {
        is_the_triangle("v 0 \\\n0 0\nv 1\\\n 0\\\n 0\nv \\\n0 1 0\nf 1 2 3\n");
    }

    #[test]
    fn continued_faces() {
        is_the_triangle(format!("{THREE}f 1 \\\n2 \\\n3\n"));
        is_the_triangle(format!("{THREE}f 1 2\\\n\t3\n"));
    }

    #[test]
    fn a_keyword_alone_on_its_line() {
        is_the_triangle("v\\\n0 0 0\nv \\\n1 0 0\nv\t\\\n0 1 0\nf\\\n1 2 3\n");
    }

    #[test]
    fn continuations_before_every_line_ending() {
        for eol in ["\n", "\r\n", "\r"] {
            is_the_triangle("v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 3\n".replace('\n', eol));
        }
    }

    #[test]
    fn a_continuation_into_nothing() {
        is_the_triangle(format!("{THREE}f 1 2 3 \\\n\n"));
        is_the_triangle(format!("{THREE}f 1 2 3\\\n"));
        is_the_triangle(format!("{THREE}f 1 2 3 \\"));
    }

    #[test]
    fn a_comment_that_ends_in_a_backslash_swallows_nothing() {
        is_the_triangle("# C:\\\nv 0 0 0 # C:\\\nv 1 0 0\nv 0 1 0\n#\\\nf 1 2 3\n");
    }

    #[test]
    fn a_name_that_ends_in_a_backslash_swallows_nothing() {
        let obj = parse("mtllib C:\\\nv 0 0 0\no \\\nv 1 0 0\ng a\\\nv 0 1 0\nusemtl C:\\\nf 1 2 3\n");
        assert_eq!(faces(&obj), [[0, 1, 2]]);
        assert_eq!(obj.data().materials(), [b"C:\\"]);
        assert_eq!(obj.extras().material_libraries, [b"C:\\"]);
    }

    #[test]
    fn lines_are_counted_through_continuations() {
        let obj = parse(format!("# first\n\n{THREE}f 1 \\\n2 \\\n3\nf 3 2 1\n"));
        assert_eq!([obj.data().face_line(0), obj.data().face_line(1)], [Some(6), Some(9)]);
        let (line, _) = error("v 0 \\\n0 \\\n0\nv x 0 0\n");
        assert_eq!(line, Some(4));
    }
}

mod other_statements {
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
}

mod numbers {
    use super::*;

    /// x of the first vertex.
    #[track_caller]
    fn read(token: &str) -> f64 {
        parse(format!("v {token} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).data().positions()[0].x
    }

    #[test]
    fn exponents_signs_and_missing_digits() {
        let spellings = ["1.5e2", "1.5E+2", "+150", "150.", "15000e-2", ".15e3", "0150.000"];
        for token in spellings {
            assert_eq!(read(token), 150.0, "{token}");
        }
        assert_eq!([read(".5"), read("-.5"), read("+.5"), read("5.")], [0.5, -0.5, 0.5, 5.0]);
    }

    #[test]
    fn a_map_coordinate_keeps_every_bit() {
        assert_eq!(read("500000.123").to_bits(), 500_000.123_f64.to_bits());
        assert_eq!(read("4649776.22482").to_bits(), 4_649_776.224_82_f64.to_bits());
        // Nearer to the upper neighbour only by its 21st digit.
        assert_eq!(read("1.00000000000000011102230246251565404236316680908203126"), 1.0 + f64::EPSILON);
    }

    #[test]
    fn zero_keeps_its_sign() {
        assert_eq!(read("-0.0").to_bits(), (-0.0_f64).to_bits());
        assert_eq!(read("-1e-999").to_bits(), (-0.0_f64).to_bits());
    }

    #[test]
    fn what_is_written_reads_back_to_the_same_bits() {
        let extreme = [1e-300, 5e-324, 1.7e308, -0.0, 0.1 + 0.2, 500_000.123, f64::MIN, f64::MIN_POSITIVE, 1e23];
        let source = parse(format!("{THREE}f 1 2 3\n"));
        for x in extreme {
            let positions = [DVec3::splat(x), DVec3::splat(-x), DVec3::new(x, 1.0, x)];
            let written = parse(source.with_positions(&positions, None));
            assert_eq!(bits(written.data().positions()), bits(&positions), "{x:e}");
        }
    }

    #[test]
    fn weights_and_colours_are_counted_and_left_alone() {
        let obj = parse("v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 2 .1 .2 .3\nf 1 2 3\n");
        assert_eq!(obj.data().positions(), [DVec3::ZERO, DVec3::X, DVec3::Y], "w divides nothing");
        assert_eq!(obj.extras().extended_vertices, 3);
    }

    #[test]
    fn uvs_of_one_and_three_numbers() {
        let obj = parse(format!("{THREE}vt 0.5\nvt 0.5 0.25\nvt 0.5 0.25 0\nf 1/1 2/2 3/3\n"));
        assert_eq!(obj.data().uvs(), [DVec2::new(0.5, 0.0), DVec2::new(0.5, 0.25), DVec2::new(0.5, 0.25)]);
    }

    /// Spellings of NaN of C and C++ libraries.
    const BROKEN: [&str; 8] = ["nan", "NaN", "-nan", "nan(ind)", "-nan(ind)", "-1.#IND", "1.#QNAN0", "-1.#IND00"];

    #[test]
    fn a_broken_uv_or_normal_is_let_through() {
        for token in BROKEN {
            let obj = parse(format!("{THREE}vt 0 0\nvt {token} 0\nvn 0 {token} 0\nf 1/1/1 2/2/1 3/1/1\n"));
            assert!(obj.data().uvs()[1].x.is_nan() && obj.data().normals()[0].y.is_nan(), "{token}");
            assert_eq!(obj.non_finite_uvs(), [(1, 5)], "{token}");
        }
    }

    #[test]
    fn an_infinite_uv_counts_as_broken() {
        for token in ["inf", "-Infinity", "1.#INF", "1e999"] {
            let obj = parse(format!("{THREE}vt {token} 0\nf 1/1 2/1 3/1\n"));
            assert_eq!(obj.non_finite_uvs(), [(0, 4)], "{token}");
        }
    }

    /// What a surface can do without is broken in each way that files have it, each in a face of its own.
    fn oddities() -> String {
        format!(
            "{THREE}v 1 1 0\nv nan 0 0\nvt 0 0\nvt nan 0\nvn 0 0 1\nf 1/1/0 2/1/0 3/1\nf 2/9 4/-9 3/1\nf 2/2 4/1 3//9\nf 1/1/1 2/1/1\nf 1\n"
        )
    }

    #[test]
    fn what_a_surface_can_do_without_may_be_broken() {
        let obj = parse(oddities());
        let data = obj.data();
        assert_eq!((data.faces().len(), data.unplaced()), (3, &[4][..]));
        let named: Vec<_> = data.faces().items().iter().map(|c| (c.uv(), c.normal())).collect();
        let (mapped, bare) = ((Some(0), None), (None, None));
        assert_eq!(named, [mapped, mapped, mapped, bare, bare, mapped, bare, mapped, bare]);
        let notes = MeshFile::notes(&obj);
        for (words, line) in [
            ("2 `f` lines have fewer than three corners", 12),
            ("2 corners have an index 0", 9),
            ("4 corners name a `vt` or `vn` that does not exist or is not finite", 10),
            ("1 `v` line that no face uses is not finite", 5),
        ] {
            let told = notes.iter().any(|note| note.starts_with(words) && note.ends_with(&format!("line {line}")));
            assert!(told, "{words}, line {line}: {notes:?}");
        }
        assert!(MeshFile::notes(&parse(format!("{THREE}f 1 2 3\n"))).is_empty());
    }

    #[test]
    fn what_is_broken_stays_and_a_carrier_is_whole() {
        let text = oddities();
        let obj = parse(text.clone());
        let moved: Vec<DVec3> = obj.data().positions().iter().map(|p| *p + DVec3::Z).collect();
        let out = String::from_utf8(obj.with_positions(&moved, None)).unwrap();
        assert_eq!(out.lines().skip(4).collect::<Vec<_>>(), text.lines().skip(4).collect::<Vec<_>>());
        let carrier = parse(String::from_utf8(obj.carrier(&moved, &[Vec3::Z; 5], None, "a.mtl")).unwrap());
        let corners = |obj: &Obj| obj.data().faces().items().iter().map(|c| (c.position, c.uv())).collect::<Vec<_>>();
        assert_eq!(corners(&carrier), corners(&obj));
        assert_eq!(
            MeshFile::notes(&carrier).len(),
            1,
            "the vertex that is not finite: {:?}",
            MeshFile::notes(&carrier)
        );
        let uvs = parse(String::from_utf8(obj.with_uvs(&[Vec2::ONE], &[0; 9])).unwrap());
        assert!(uvs.data().faces().items().iter().all(|c| c.uv() == Some(0)));
    }

    #[test]
    fn normals_keep_their_length() {
        let obj = parse(format!("{THREE}vn 0 0 2\nvn 0 0 0\nf 1//1 2//2 3//1\n"));
        assert_eq!(obj.data().normals(), [DVec3::Z * 2.0, DVec3::ZERO]);
    }
}

mod errors {
    use super::*;
    use ObjErrorKind::*;

    #[test]
    fn an_empty_file() {
        assert_eq!(error(""), (None, Empty));
    }

    #[test]
    fn decimal_commas_are_told() {
        let text = |obj: &str| Obj::parse(obj.as_bytes().to_vec()).unwrap_err().to_string();
        assert_eq!(
            text("v -0,5 1 2\n"),
            "line 1: `-0,5` is not a number: it has a decimal comma, and OBJ needs a point"
        );
        assert_eq!(text("v 1,2,3 1 2\n"), "line 1: `1,2,3` is not a number");
    }

    #[test]
    fn a_binary_file() {
        assert_eq!(error(b"glTF\x02\0\0\0"), (None, Binary { offset: 5 }));
        let utf_16: Vec<u8> = "v 0 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(error([&b"\xff\xfe"[..], &utf_16].concat()), (None, Utf16));
        assert_eq!(error(b"\xfe\xff\0v\0 \0a"), (None, Utf16));
        assert_eq!(error(utf_16), (None, Binary { offset: 1 }));
    }

    #[test]
    fn no_vertices() {
        assert_eq!(error("# nothing\n"), (None, NoVertices));
        assert_eq!(error("\r\n \t\n"), (None, NoVertices));
        assert_eq!(error("f 1 2 3\n"), (None, NoVertices));
        assert_eq!(error("<html>\n"), (None, NoVertices));
    }

    #[test]
    fn no_faces() {
        assert_eq!(error(format!("{THREE}l 1 2\np 3\n")), (None, NoFaces));
    }

    #[test]
    fn no_number() {
        assert_eq!(error("\nv 1 2 three\n"), (Some(2), NotANumber("three".to_owned())));
        assert_eq!(error("v 1,5 2 3\n"), (Some(1), NotANumber("1,5".to_owned())));
        assert_eq!(error(format!("{THREE}vt 0 x\n")), (Some(4), NotANumber("x".to_owned())));
        assert_eq!(error(format!("{THREE}vn 0 x 0\n")), (Some(4), NotANumber("x".to_owned())));
    }

    #[test]
    fn a_coordinate_that_is_not_finite() {
        for token in ["nan", "NaN", "-nan", "inf", "-Infinity", "1e309", "-1.#IND"] {
            let text = format!("v 0 0 0\nv 1 {token} 0\nv 0 1 0\nf 1 2 3\n");
            assert_eq!(error(text), (Some(2), NotFinite(token.to_owned())));
        }
    }

    #[test]
    fn too_few_numbers() {
        for (line, keyword, needed, found) in [
            ("v 1 2", "v", 3, 2),
            ("v", "v", 3, 0),
            ("v 1 2 # 3", "v", 3, 2),
            ("vt", "vt", 1, 0),
            ("vn 1 2", "vn", 3, 2),
        ] {
            assert_eq!(error(format!("v 0 0 0\n{line}\n")), (Some(2), TooFewNumbers { keyword, needed, found }));
        }
    }

    #[test]
    fn no_corner() {
        for corner in ["x", "1.0", "1/2/3/4", "/1", "//1", "/", "1/x", "--1", "-", "1e0", "99999999999999999999"] {
            assert_eq!(error(format!("{THREE}f 1 2 {corner}\n")), (Some(4), BadCorner(corner.to_owned())));
        }
    }

    #[test]
    fn index_zero() {
        for corner in ["0", "-0", "0/1/1"] {
            assert_eq!(error(format!("{THREE}f 1 2 {corner}\n")), (Some(4), ZeroIndex(corner.to_owned())));
        }
    }

    #[test]
    fn an_index_out_of_range() {
        for (corner, index) in [("4", 4), ("4294967295", 4_294_967_295)] {
            let text = format!("{THREE}vt 0 0\nvn 0 0 1\nvn 0 0 1\nf 1 2 3\nf 1 2 {corner}\nf 3 2 1\n");
            assert_eq!(error(text), (Some(8), OutOfRange { index, count: 3 }));
        }
    }

    #[test]
    fn a_negative_index_before_the_first_line() {
        // Lines that come later do not help.
        let text = format!("{THREE}f 1 2 -4\nv 1 1 1\n");
        assert_eq!(error(text), (Some(4), OutOfRange { index: -4, count: 3 }));
    }

    #[test]
    fn an_index_beyond_32_bits() {
        // One less would be the number that stands for "absent".
        let text = |corner: &str| format!("{THREE}vt 0 0\nvn 0 0 1\nf 1 2 {corner}\n");
        for corner in ["4294967296", "4294967297"] {
            assert_eq!(error(text(corner)).0, Some(6), "{corner}");
        }
        for corner in ["1/4294967296", "1/4294967297", "1//-4294967296"] {
            let notes = MeshFile::notes(&parse(text(corner))).to_vec();
            assert!(notes[0].starts_with("1 corner names a `vt` or `vn` that does not exist"), "{corner}: {notes:?}");
        }
    }

    #[test]
    fn messages_fit_on_a_line_and_name_the_line_at_fault() {
        let long = "x".repeat(1000);
        let message = Obj::parse(format!("v 0 0 0\nv {long} 0 0\n").into_bytes()).unwrap_err().to_string();
        assert_eq!(message, format!("line 2: `{}` is not a number", &long[..40]));
        let message = Obj::parse(b"v \x1b[31m\xff 0 0\n".to_vec()).unwrap_err().to_string();
        assert_eq!(message, "line 1: `\\u{1b}[31m\u{fffd}` is not a number");
        assert_eq!(Obj::parse(Vec::new()).unwrap_err().to_string(), "the file is empty");
    }
}

mod writing {
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
        assert!(
            text.contains("vn 0 1.0 0.0\n") && text.contains("vn 1 0 0\n") && text.contains("vn 0.5 1 0\n"),
            "{text}"
        );
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
}
