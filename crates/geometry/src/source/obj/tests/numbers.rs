//! Spellings of numbers, and numbers that are broken.

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
    assert_eq!(MeshFile::notes(&carrier).len(), 1, "the vertex that is not finite: {:?}", MeshFile::notes(&carrier));
    let uvs = parse(String::from_utf8(obj.with_uvs(&[Vec2::ONE], &[0; 9])).unwrap());
    assert!(uvs.data().faces().items().iter().all(|c| c.uv() == Some(0)));
}

#[test]
fn normals_keep_their_length() {
    let obj = parse(format!("{THREE}vn 0 0 2\nvn 0 0 0\nf 1//1 2//2 3//1\n"));
    assert_eq!(obj.data().normals(), [DVec3::Z * 2.0, DVec3::ZERO]);
}
