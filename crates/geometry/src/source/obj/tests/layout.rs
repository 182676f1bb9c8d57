//! Line ends, blanks, comments and continued lines.

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
