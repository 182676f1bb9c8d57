//! Files that are refused, and what is said of them.

use super::*;
use ObjErrorKind::*;

#[test]
fn an_empty_file() {
    assert_eq!(error(""), (None, Empty));
}

#[test]
fn decimal_commas_are_told() {
    let text = |obj: &str| Obj::parse(obj.as_bytes().to_vec()).unwrap_err().to_string();
    assert_eq!(text("v -0,5 1 2\n"), "line 1: `-0,5` is not a number: it has a decimal comma, and OBJ needs a point");
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
fn capitals_are_told() {
    let capital = |obj: &str| error(obj.as_bytes());
    assert_eq!(capital("# a\nV 0 0 0\nV 1 0 0\nF 1 2 3\n"), (Some(2), Capital { keyword: "v" }));
    assert_eq!(capital(&format!("{THREE}VT 0 0\nF 1 2 3\n")), (Some(5), Capital { keyword: "f" }));
    let text = Obj::parse(b"V 0 0 0\n".to_vec()).unwrap_err().to_string();
    assert_eq!(text, "line 1: `V` is no keyword of OBJ, and other programs skip such lines: write `v`");
    // A file that has both is none of these: readers skip what they do not know.
    assert_eq!(capital(&format!("{THREE}V 1 2 3\nl 1 2\n")), (None, NoFaces));
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
    for (line, keyword, needed, found) in
        [("v 1 2", "v", 3, 2), ("v", "v", 3, 0), ("v 1 2 # 3", "v", 3, 2), ("vt", "vt", 1, 0), ("vn 1 2", "vn", 3, 2)]
    {
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
