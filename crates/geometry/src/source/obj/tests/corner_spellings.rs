//! Spellings of the corners of faces.

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
