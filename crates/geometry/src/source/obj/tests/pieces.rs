//! Files that are read in pieces: a cut changes nothing, wherever it is.

use super::*;
use crate::source::obj::parse::parse_in_pieces;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// Reads a file in pieces of this size. Returns all that was read, as text, and the file with other positions and normals.
fn read(text: &[u8], size: usize) -> Result<(String, Vec<u8>), ObjError> {
    let obj = parse_in_pieces(text.to_vec(), size)?;
    let contents = format!("{:?} {:?} {:?} {:?}", obj.data, obj.non_finite_uvs, obj.extras, obj.notes);
    let positions: Vec<DVec3> = obj.data.positions.iter().map(|p| *p + DVec3::X).collect();
    let normals: Vec<DVec3> = obj.data.normals.iter().map(|n| -*n).collect();
    Ok((contents, obj.with_positions(&positions, Some(&normals))))
}

/// Lines that are right, odd or wrong; `\` at their ends continues them where they have numbers.
const LINES: &[&str] = &[
    "v 0 0 0",
    "v 1 0.5 -2e3",
    "v 1 \\\n 0 \\",
    "v 0 1 0 0.1 0.2 0.3",
    "v nan 0 0",
    "v 1 2",
    "vt 0 0.25",
    "vt nan 1",
    "vn 0 0 1",
    "f 1 2 3",
    "f 3/1 2/1/1 1//1",
    "f -1 -2 -3",
    "f -1/-1/-1 -2/-2 -3//-1",
    "f 1 2 -40",
    "f 1 2 3 \\",
    "f 1 2",
    "f 1/9 2/0 3",
    "f 1 2 99",
    "f 1 2 x",
    "usemtl red",
    "usemtl blue \\",
    "g skin \\",
    "o left",
    "s off",
    "l 1 2",
    "mtllib a b.mtl",
    "# comment \\",
    "",
    "  ",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cuts_change_nothing(
        lines in vec(select(LINES), 0..40),
        mostly_right in any::<bool>(),
        end in select(vec!["\n", "\r\n", "\r"]),
        has_last_end in any::<bool>(),
        mark in any::<bool>(),
    ) {
        let wrong = ["v 1 2", "f 1 2 x", "f 1 2 -40", "f 1 2 99", "v nan 0 0"];
        let kept = lines.into_iter().filter(|line| !mostly_right || !wrong.contains(line));
        let three = if mostly_right { THREE.trim_end() } else { "" };
        let text = [three].into_iter().chain(kept).collect::<Vec<_>>().join("\n");
        let text = text + if has_last_end { "\n" } else { "" };
        let text = if mark { "\u{feff}" } else { "" }.to_owned() + &text.replace('\n', end);
        let whole = read(text.as_bytes(), usize::MAX);
        for size in [1, 2, 13, 50] {
            prop_assert_eq!(read(text.as_bytes(), size), whole.clone(), "pieces of {} bytes", size);
        }
    }
}

/// A piece for each line.
fn in_lines(text: &str) -> Result<Obj, ObjError> {
    parse_in_pieces(text.as_bytes().to_vec(), 1)
}

#[test]
fn an_error_in_a_later_piece_names_its_line_and_the_first_error_wins() {
    // More pieces than one round of them has.
    let comments = "# nothing\n".repeat(100);
    let text = format!("{THREE}{comments}f 1 2 3\nf 1 2 x\nv 1\n");
    let ObjError { line, kind } = in_lines(&text).unwrap_err();
    assert_eq!((line, kind), (Some(105), ObjErrorKind::BadCorner("x".to_owned())));
    let text = format!("{THREE}{comments}f -1 -2 -4\nf 1 2 x\n");
    let ObjError { line, kind } = in_lines(&text).unwrap_err();
    assert_eq!((line, kind), (Some(104), ObjErrorKind::OutOfRange { index: -4, count: 3 }));
}

#[test]
fn indices_count_backwards_across_pieces() {
    let comments = "# nothing\n".repeat(40);
    let obj =
        in_lines(&format!("{THREE}vt 0 0\n{comments}vt 1 1\nf -3/-1 -2/-2 -1\nv 1 1 0\nf -1 -2 -3/-2\n")).unwrap();
    assert_eq!(
        corners(&obj),
        [
            vec![(0, Some(1), None), (1, Some(0), None), (2, None, None)],
            vec![(3, None, None), (2, None, None), (1, Some(0), None)]
        ]
    );
}

#[test]
fn no_cut_is_within_a_continued_line() {
    let obj = in_lines("v 0 0 0\nv 1 \\\n0 \\\r\n0\nv 0 1 0\nf 1 \\\n2 \\\n3").unwrap();
    assert_eq!((faces(&obj), obj.pieces.len()), (vec![vec![0, 1, 2]], 4));
    assert_eq!(obj.data().positions()[1], DVec3::X);
    assert_eq!(obj.data().face_line(0), Some(6));
}

#[test]
fn pieces_that_do_not_change_are_those_of_the_file() {
    let obj = in_lines(&format!("{THREE}# 1\nvt 0 0\nf 1 2 3\n")).unwrap();
    let moved: Vec<DVec3> = obj.data().positions().iter().map(|p| *p * 2.0).collect();
    let pieces = obj.pieces_with_positions(&moved, None);
    assert_eq!(
        pieces.iter().map(|piece| matches!(piece, Cow::Borrowed(_))).collect::<Vec<_>>(),
        [false, false, false, true, true, true]
    );
    assert_eq!(pieces.concat(), obj.with_positions(&moved, None));
}
