//! Limits that hold for every method.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::{Value, json};

/// The numbers of the `v` lines.
fn vertices(obj: &str) -> Vec<Vec<f64>> {
    let lines = obj.lines().filter_map(|line| line.strip_prefix("v "));
    lines.map(|line| line.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect()
}

fn open() -> Folder {
    let folder = Folder::new();
    let mut grid = Mesh::grid(6).noisy(0.02);
    // A wave, so that there is something to smooth and to lose.
    for p in &mut grid.positions {
        p[2] += 0.2 * (p[0] * 6.0).sin() * (p[1] * 3.0).sin();
    }
    folder.write("in.obj", grid.obj());
    folder
}

fn closed() -> Folder {
    Folder::with("in.obj", Mesh::sphere(8).noisy(0.03).split_at_seams().with_defects().obj())
}

fn volume(folder: &Folder, mesh: &str) -> f64 {
    folder.succeeds_with_json(&format!("info {mesh}"))["volume"].as_f64().unwrap()
}

#[test]
fn fixed_lines_keep_their_bytes() {
    let folder = open();
    folder.write("eyes.txt", "# left and right\n10, 12-14\n");
    folder.write("nose.txt", "25 # tip");
    let report = folder.succeeds_with_json(
        "denoise in.obj -o out.obj --method taubin --boundary free --fix boundary --fix eyes.txt --fix nose.txt",
    );
    assert_eq!(report["method"]["limits"]["fixed"], "boundary 10 12-14 25");
    // 24 vertices of the boundary, of which 14 is one.
    assert_eq!(report["limits"], json!({ "fixed_vertices": 28, "stopped_vertices": 0 }));
    let [before, after] = ["in.obj", "out.obj"].map(|name| folder.text(name));
    let moved = before.lines().zip(after.lines()).map(|(a, b)| a != b);
    let moved: Vec<usize> = moved.enumerate().filter(|(_, moved)| *moved).map(|(i, _)| i + 1).collect();
    let boundary = |line: usize| [0, 6].contains(&((line - 1) % 7)) || !(8..=42).contains(&line);
    assert_eq!(moved, (1..=49).filter(|v| !boundary(*v) && ![10, 12, 13, 25].contains(v)).collect::<Vec<_>>());
}

#[test]
fn no_vertex_goes_farther_than_it_may() {
    let folder = closed();
    let report = folder
        .succeeds_with_json("denoise in.obj -o out.obj --method laplacian --iterations 20 --max-displacement 0.1");
    let most = 0.1 * report["mean_edge"].as_f64().unwrap();
    assert!(report["max_displacement"].as_f64().unwrap() <= most);
    assert!(report["limits"]["stopped_vertices"].as_u64().unwrap() > 0);
    let [before, after] = ["in.obj", "out.obj"].map(|name| vertices(&folder.text(name)));
    for (p, q) in before.iter().zip(&after) {
        let distance = p.iter().zip(q).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        // The position is rounded once more than the displacement.
        assert!(distance <= most * (1.0 + 1e-12), "{distance} {most}");
    }
    folder.succeeds("denoise in.obj -o same.obj --max-displacement 0");
    assert_eq!(folder.text("same.obj"), folder.text("in.obj"));
}

#[test]
fn the_volume_of_a_closed_mesh_is_restored() {
    let folder = closed();
    let before = volume(&folder, "in.obj");
    for limits in ["", "--max-displacement 0.3", "--fix mask.txt"] {
        folder.write("mask.txt", "1-60");
        let report = folder.succeeds_with_json(&format!(
            "denoise in.obj -o out.obj --method laplacian --iterations 20 --preserve-volume {limits}"
        ));
        let change = &report["limits"]["volume"];
        assert_eq!(change["restored"], true);
        assert!(change["by_method"].as_f64().unwrap() < -0.01 * before, "{change}");
        assert!((volume(&folder, "out.obj") / before - 1.0).abs() < 1e-9, "{limits}");
    }
    // The 60 lines are the pole, a vertex that no face uses, and 41 vertices of the rows after it.
    let said = folder.succeeds("denoise in.obj -o out.obj --method laplacian --preserve-volume --fix mask.txt").out;
    assert!(said.contains("limits: 43 fixed, 0 stopped, restored a volume of "), "{said}");
}

#[test]
fn a_bake_keeps_to_its_limits_and_its_manifest_repeats_them() {
    let folder = closed();
    folder.write("mask.txt", "3-20");
    let before = volume(&folder, "in.obj");
    let limits = "--method laplacian --iterations 20 --fix mask.txt --max-displacement 0.4 --preserve-volume";
    for map in ["", "--map vector", "--layout vertex"] {
        let baked = folder.succeeds_with_json(&format!("bake in.obj -o out {limits} {map}"));
        let manifest = &baked["manifest"];
        let expected = json!({ "fixed": "3-20", "max_displacement": 0.4, "volume": "preserve" });
        assert_eq!(manifest["method"]["limits"], expected);
        assert_eq!(manifest["report"]["limits"]["volume"]["restored"], true, "{map}");
        let checked = folder.succeeds_with_json("check out/in.planish.json");
        assert_eq!(checked["report"], manifest["report"], "{map}");
        folder.succeeds("apply out/in.planish.json -o displaced.obj");
        // As exact as the map is: the error of every vertex over the area of a unit sphere.
        let allowed = 4.0 * std::f64::consts::PI * manifest["report"]["max_error"].as_f64().unwrap();
        assert!((volume(&folder, "displaced.obj") - before).abs() < allowed, "{map}");
        let quantum = manifest["report"]["quantum"].as_f64().unwrap();
        let [input, displaced] = ["in.obj", "displaced.obj"].map(|name| vertices(&folder.text(name)));
        for v in 2..20 {
            let distance = input[v].iter().zip(&displaced[v]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            assert!(distance < 2.0 * quantum + 1e-6, "{map} {v}: {distance} {quantum}");
        }
    }
    // Without limits nothing speaks of them.
    let baked = folder.succeeds_with_json("bake in.obj -o out");
    assert_eq!(baked["manifest"]["method"].get("limits"), None);
    assert_eq!(baked["manifest"]["report"].get("limits"), None);
    // The 18 lines are the pole, a vertex that no face uses, and three vertices of the row after it.
    assert!(folder.succeeds(&format!("bake in.obj -o out {limits}")).out.contains("\nlimits    5 fixed, "));
}

#[test]
fn an_open_mesh_keeps_the_volume_under_it_if_its_rim_stays() {
    let folder = open();
    let words = ["in.obj: encloses no volume: 24 edges", "`v` lines 1 and 2", "--preserve-volume needs --fix"];
    folder.refuses("denoise in.obj -o new/out.obj --preserve-volume", &words);
    folder.refuses("bake in.obj -o new --preserve-volume", &words);
    let report = folder.succeeds_with_json("denoise in.obj -o out.obj --preserve-volume --fix boundary");
    assert_eq!(report["limits"]["volume"]["restored"], true);
    assert_ne!(report["limits"]["volume"]["by_method"], 0.0);
}

#[test]
fn a_bad_mask_is_refused_with_its_line() {
    let folder = open();
    for (text, words) in [
        ("1\n2\n50\n", "mask.txt: line 3: `50` names `v` line 50; there are 49"),
        ("1\n\n0", "mask.txt: line 3: `0` names `v` line 0"),
        ("4-2", "mask.txt: line 1: `4-2` ends before it begins"),
        ("1 2 x # y", "mask.txt: line 1: `x` is no number"),
        ("1.5", "mask.txt: line 1: `1.5` is no number"),
    ] {
        folder.write("mask.txt", text);
        folder.refuses("denoise in.obj -o new/out.obj --fix mask.txt", &[words]);
        folder.refuses("bake in.obj -o new --fix mask.txt", &[words]);
    }
    folder.write("mask.txt", b"\xff\xfe1\0");
    folder.refuses("denoise in.obj -o new/out.obj --fix mask.txt", &["mask.txt: is not a text"]);
    folder.refuses("denoise in.obj -o new/out.obj --fix none.txt", &["none.txt: ", "o such file"]);
    folder.refuses("denoise in.obj -o new/out.obj --fix .", &[".: is a directory"]);
    for d in ["-1", "nan", "inf", "x"] {
        folder.refuses_usage(&format!("denoise in.obj -o out.obj --max-displacement {d}"), &["--max-displacement"]);
    }
    folder.write("mask.txt", "1");
    folder.refuses("denoise in.obj -o mask.txt --fix mask.txt", &["mask.txt", "is an input"]);
    for option in ["--fix boundary", "--max-displacement 1", "--preserve-volume"] {
        folder.refuses_usage(&format!("bake in.obj -o new --target in.obj {option}"), &["--target"]);
    }
}

#[test]
fn a_manifest_with_the_limits_of_another_mesh_is_refused() {
    let folder = open();
    folder.succeeds("bake in.obj -o out --layout vertex --fix boundary");
    let manifest = folder.json("out/in.planish.json");
    let with = |limit: &str, value: Value| {
        let mut changed = manifest.clone();
        changed["method"]["limits"][limit] = value;
        folder.write("out/in.planish.json", changed.to_string());
    };
    with("fixed", "50".into());
    folder.refuses("check out/in.planish.json", &["in.obj: `v` line 50 shall stay, but there are 49"]);
    with("max_displacement", (-1.0).into());
    folder.refuses("check out/in.planish.json", &["-1 is no largest displacement"]);
    with("fixed", "3-".into());
    folder.refuses("check out/in.planish.json", &["in.planish.json: "]);
}

/// A grid of 7 × 7 vertices with texture coordinates, colours that grow to the right, two groups and two materials; the left half
/// is the group and the material `left`.
fn coloured() -> Folder {
    let folder = Folder::new();
    let mut obj = String::from("mtllib in.mtl\n");
    let at = |i: usize| [i % 7, i / 7].map(|x| x as f64 / 6.0);
    for i in 0..49 {
        let [x, y] = at(i);
        let z = 0.02 * ((i * i) as f64 * 1.7).sin() + 0.1 * (3.0 * x).sin();
        obj += &format!("v {x} {y} {z} {x} 0.5 0\nvt {x} {y}\n");
    }
    for half in [0..3, 3..6] {
        let name = if half.start == 0 { "left" } else { "right" };
        obj += &format!("g {name} half\nusemtl m_{name}\n");
        for (x, y) in half.flat_map(|x| (0..6).map(move |y| (x, y))) {
            let corner = |x: usize, y: usize| format!("{0}/{0}", 1 + x + 7 * y);
            obj += &format!("f {} {} {} {}\n", corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
        }
    }
    folder.write("in.obj", obj);
    folder.write("in.mtl", "newmtl m_left\nnewmtl m_right\n");
    folder
}

const SMOOTH: &str = "--method laplacian --iterations 3 --boundary free";

/// Displacements by `denoise` with options, as vectors.
fn moved(folder: &Folder, options: &str) -> Vec<[f64; 3]> {
    folder.succeeds(&format!("denoise in.obj -o out.obj {SMOOTH} {options}"));
    let [before, after] = ["in.obj", "out.obj"].map(|name| vertices(&folder.text(name)));
    before.iter().zip(&after).map(|(p, q)| [0, 1, 2].map(|k| p[k] - q[k])).collect()
}

#[test]
fn masks_hold_vertices_back() {
    let folder = coloured();
    let mut image = image::GrayImage::from_pixel(2, 1, image::Luma([255]));
    image.put_pixel(0, 0, image::Luma([51]));
    image.save(folder.path("mask.png")).unwrap();
    let free = moved(&folder, "");
    let column = |v: usize| v % 7;
    // Weight of each vertex by its column; that of the picture is bilinear between u = 1/4 and u = 3/4, and repeats beyond.
    let picture = |v: usize| {
        [0.6, 1.0 - 0.8 * 5.0 / 6.0, 0.2 + 0.8 / 6.0, 0.6, 1.0 - 0.8 / 6.0, 0.2 + 0.8 * 5.0 / 6.0, 0.6][column(v)]
    };
    let colour = |v: usize| column(v) as f64 / 6.0;
    let left = |v: usize| f64::from(u8::from(column(v) < 3));
    let right = |v: usize| f64::from(u8::from(column(v) > 3));
    let of_column: String = (0..49).map(|v| format!("{} ", colour(v))).collect();
    folder.write("column.txt", of_column);
    let cases: [(&str, &dyn Fn(usize) -> f64); 10] = [
        ("colour:red", &colour),
        ("not:color:red", &|v| 1.0 - colour(v)),
        ("colour:green", &|_| 0.5),
        ("group:left", &left),
        ("not:group:left", &right),
        ("material:m_left,m_right", &|_| 1.0),
        ("material:m_right", &right),
        ("mask.png", &|v| picture(v)),
        ("weights:column.txt", &colour),
        ("not:weights:column.txt", &|v| 1.0 - colour(v)),
    ];
    for (mask, weight) in cases {
        for (v, (moved, free)) in moved(&folder, &format!("--mask {mask}")).iter().zip(&free).enumerate() {
            for k in 0..3 {
                let off = moved[k] - weight(v) * free[k];
                assert!(
                    off.abs() <= free[k].abs() / 250.0 + 1e-12,
                    "{mask}: vertex {v} is off by {off} of {}",
                    free[k]
                );
                assert!(weight(v) > 0.0 || moved[k] == 0.0, "{mask}: vertex {v}");
            }
        }
    }
}

#[test]
fn masks_are_baked_and_checked_without_their_picture() {
    let folder = coloured();
    image::GrayImage::from_pixel(1, 1, image::Luma([102])).save(folder.path("mask.png")).unwrap();
    folder.succeeds(&format!("bake in.obj -o out {SMOOTH} --mask mask.png"));
    let manifest = folder.json("out/in.planish.json");
    assert_eq!(manifest["method"]["limits"]["mask"], json!({ "from": "mask.png", "weights": "1-49=102" }));
    assert_eq!(manifest["report"]["limits"]["weighted_vertices"], 49);
    std::fs::remove_file(folder.path("mask.png")).unwrap();
    folder.succeeds("check out/in.planish.json");
}

#[test]
fn masks_that_do_not_fit_are_named() {
    let folder = coloured();
    folder.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("text.png", "no picture");
    folder.write("few.txt", "1 0.5 0");
    folder.write("far.txt", "1 ".repeat(48) + "1.5");
    folder.write("nan.txt", "nan ".repeat(49));
    folder.write("odd.txt", "0.5 \u{1b}[31m");
    for (mesh, mask, words) in [
        ("in.obj", "group:middle", &["error: in.obj: has no group and no object `middle`"][..]),
        ("in.obj", "material:left", &["error: in.obj: ", "`left`", "m_left, m_right"]),
        ("in.obj", "text.png", &["error: text.png: "]),
        ("in.obj", "absent.png", &["error: absent.png: "]),
        ("in.obj", "weights:few.txt", &["error: few.txt: has 3 weights, but in.obj has 49 vertices"]),
        ("in.obj", "weights:far.txt", &["error: far.txt: weight 49 is 1.5, not from 0 to 1"]),
        ("in.obj", "weights:nan.txt", &["error: nan.txt: weight 1 is NaN"]),
        ("in.obj", "weights:text.png", &["error: text.png: `no` is not a number"]),
        ("in.obj", "weights:odd.txt", &["error: odd.txt: `\\u{1b}[31m` is not a number"]),
        ("bare.obj", "colour:red", &["error: bare.obj: has no colours"]),
        ("bare.obj", "text.png", &["error: bare.obj: has no texture coordinates"]),
        ("bare.obj", "material:a", &["error: bare.obj: ", "it has none"]),
    ] {
        folder.refuses(&format!("denoise {mesh} -o out.obj --mask {mask}"), words);
    }
    let command = "denoise in.obj -o out.obj --mask colour:alpha";
    folder.refuses_usage(command, &["`alpha` is no channel", "red, green, blue, grey"]);
}

#[test]
fn vertices_move_along_a_direction_alone() {
    let folder = coloured();
    let free = moved(&folder, "");
    assert!(free.iter().any(|moved| moved[0] != 0.0));
    let along = moved(&folder, "--direction 0,0,1");
    assert!(along.iter().all(|moved| moved[0] == 0.0 && moved[1] == 0.0));
    assert!(along.iter().any(|moved| moved[2].abs() > 0.005));
    assert_eq!(moved(&folder, "--direction 0,0,-3"), along);
    let rays = moved(&folder, "--direction ray:0.5,0.5,4");
    let positions = vertices(&folder.text("in.obj"));
    for (moved, p) in rays.iter().zip(&positions) {
        let ray = [p[0] - 0.5, p[1] - 0.5, p[2] - 4.0];
        for [a, b] in [[0, 1], [1, 2], [2, 0]] {
            assert!((moved[a] * ray[b] - moved[b] * ray[a]).abs() < 1e-12, "{moved:?} {ray:?}");
        }
    }
}

#[test]
fn directions_are_baked_as_vectors_and_not_as_heights() {
    let folder = coloured();
    let bake = format!("bake in.obj -o out {SMOOTH} --direction 0,0,1");
    folder.refuses(&bake, &["error: in.obj: ", "0,0,1", "--map vector"]);
    folder.refuses_usage("denoise in.obj -o out.obj --direction 1,2", &["`1,2` is no direction"]);
    folder.succeeds(&format!("{bake} --map vector --bits 32"));
    assert_eq!(folder.json("out/in.planish.json")["method"]["limits"]["direction"], "0,0,1");
    folder.succeeds("check out/in.planish.json");
    folder.succeeds("apply out/in.planish.json -o applied.obj");
    let [before, after] = ["in.obj", "applied.obj"].map(|name| vertices(&folder.text(name)));
    for (p, q) in before.iter().zip(&after) {
        assert!((p[0] - q[0]).abs() < 1e-7 && (p[1] - q[1]).abs() < 1e-7, "{p:?} {q:?}");
    }
}
