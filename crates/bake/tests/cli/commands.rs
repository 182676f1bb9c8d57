//! Results of `denoise`, `noise`, `compare` and `info` on good input.

use crate::folder::Folder;
use crate::mesh::Mesh;
use crate::reference::{Lines, OneStep, statements};

/// Legal and awkward: carriage returns, tabs, comments, continuations, colours, groups, bytes that are no UTF-8, and no
/// line end at the end. Vertex 5 is inside, the others are the boundary. `@` stands for what may change.
const AWKWARD: &[u8] = b"# caf\xe9 scan\r\no  plate\r\n\
v\t0 0\t0.50  1 0 0 # red\r\nv 1e0 +0.0 .5\r\nv 1.000 1 0.500\r\nv -0 1 5e-1\r\n\
  v  @ @ @ 0.25 0.25 0.25\r\n\
vt 0 0\r\n\r\nvn 0 0.6 0.8\r\ng  a b\r\ns off\r\nusemtl m\xfcsli\r\n\
f 1/1/1 \\\r\n 2/1/1 5/1/1\r\nf 2 3 5\r\nf -3 -2 -1 # last\r\nf 4 1 5\r\nl 1 2\r\np 3";

fn awkward(z: [&str; 3]) -> Vec<u8> {
    let mut numbers = z.iter();
    let number = |b: &u8| if *b == b'@' { numbers.next().unwrap().as_bytes().to_vec() } else { vec![*b] };
    AWKWARD.iter().flat_map(number).collect()
}

#[test]
fn denoise_changes_the_numbers_of_vertices_and_nothing_else() {
    let folder = Folder::with("in.obj", awkward(["0.5", "0.50", "0.9"]));
    folder.succeeds("denoise in.obj -o out.obj --method laplacian --iterations 1 --step 1");
    // The mean of the corners is (0.5, 0.5, 0.5), exactly: only the third number changes, and 0.50 stays 0.50.
    let expected = awkward(["0.5", "0.50", "0.5"]);
    assert_eq!(folder.bytes("out.obj").escape_ascii().to_string(), expected.escape_ascii().to_string());
    folder.succeeds("denoise in.obj -o none.obj --method laplacian --iterations 0");
    assert_eq!(folder.bytes("none.obj"), folder.bytes("in.obj"));
}

#[test]
fn normals_follow_when_asked_and_stay_otherwise() {
    let folder = Folder::with("in.obj", awkward(["0.5", "0.5", "0.9"]));
    let normals = |options: &str| {
        folder.succeeds(&format!("denoise in.obj -o out.obj --method laplacian --iterations 1 --step 1 {options}"));
        let text = String::from_utf8_lossy(&folder.bytes("out.obj")).into_owned();
        statements(&text, "vn").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(normals(""), ["vn 0 0.6 0.8"]);
    // Denoised, the plate is flat.
    assert_eq!(normals("--update-normals"), ["vn 0 0.0 1.0"]);
}

#[test]
fn one_whole_step_is_the_mean_of_the_neighbours() {
    let mesh = Mesh::sphere(8).noisy(0.03).split_at_seams().with_defects();
    let folder = Folder::with("in.obj", mesh.obj());
    folder.succeeds("denoise in.obj -o out.obj --method laplacian --iterations 1 --step 1");
    let source = Lines::of(&mesh.obj()).positions;
    let denoised = Lines::of(&folder.text("out.obj")).positions;
    let along_normals = OneStep::of(&mesh.obj());
    for (line, v) in along_normals.vertex_of_line.iter().enumerate() {
        let first = along_normals.vertex_of_line.iter().position(|w| w == v).unwrap();
        assert_eq!(denoised[line], denoised[first], "`v` lines of one vertex stay together");
        // What was baked is the part of this step along the normal: the rest is at right angles to it.
        let (whole, along) = (denoised[line] - source[line], along_normals.positions[line] - source[line]);
        assert!((whole - along).dot(along).abs() < 1e-8 * (1.0 + along.length()), "v line {}", line + 1);
    }
}

#[test]
fn the_boundary_moves_only_when_it_is_free() {
    let mesh = Mesh::grid(4).noisy(0.05).obj();
    let folder = Folder::with("in.obj", &mesh);
    let moved = |options: &str| {
        folder.succeeds(&format!("denoise in.obj -o out.obj --method laplacian {options}"));
        let out = folder.text("out.obj");
        let pairs: Vec<bool> = statements(&mesh, "v").iter().zip(statements(&out, "v")).map(|(a, b)| *a != b).collect();
        pairs.iter().filter(|moved| **moved).count()
    };
    assert_eq!((moved("--boundary fixed"), moved("--boundary free")), (9, 25));
    assert_eq!((moved("--weights cotangent"), moved("--step 0")), (9, 0));
}

#[test]
fn welding_decides_what_is_one_vertex() {
    let folder = Folder::with("in.obj", Mesh::sphere(6).split_at_seams().obj());
    let vertices = |weld: &str| folder.succeeds_with_json(&format!("info in.obj --weld {weld}"))["vertices"].clone();
    let lines = Mesh::sphere(6).split_at_seams().positions.len();
    // Five meridian vertices are split in two, each pole in thirteen of which one has no face and lies at the origin.
    let whole = Mesh::sphere(6).positions.len() + 1;
    assert_eq!((vertices("none"), vertices("exact"), vertices("1e-9")), (lines.into(), whole.into(), whole.into()));
}

#[test]
fn the_same_seed_gives_the_same_noise() {
    let folder = Folder::with("in.obj", Mesh::sphere(8).obj());
    let noise = |options: &str| {
        folder.succeeds(&format!("noise in.obj -o out.obj {options}"));
        folder.bytes("out.obj")
    };
    let first = noise("--sigma 0.2 --seed 7");
    assert!(noise("--sigma 0.2 --seed 7") == first);
    assert!(noise("--sigma 0.2") == noise("--sigma 0.2 --seed 1"), "1 is the default");
    for other in ["--sigma 0.2 --seed 8", "--sigma 0.3 --seed 7", "--sigma 0.2 --seed 7 --direction random"] {
        assert!(noise(other) != first, "{other}");
    }
    assert!(noise("--sigma 0") == folder.bytes("in.obj"));
}

#[test]
fn impulsive_noise_hits_its_share() {
    let folder = Folder::with("in.obj", Mesh::sphere(16).obj());
    let printed = folder.succeeds_with_json("noise in.obj -o out.obj --sigma 0.2 --impulsive 0.25");
    let count = |field: &str| printed[field].as_f64().unwrap();
    let share = count("moved_vertices") / count("vertices");
    // Binomial with about 480 trials: a standard deviation is 0.02.
    assert!((share - 0.25).abs() < 0.08, "{share}");
    let sigma = count("rms_displacement") / count("mean_edge");
    assert!((sigma - 0.2).abs() < 0.06, "{sigma}");
}

#[test]
fn compare_puts_better_results_below_worse_ones() {
    let folder = Folder::with("clean.obj", Mesh::sphere(16).obj());
    folder.succeeds("noise clean.obj -o noisy.obj --sigma 0.2");
    folder.succeeds("denoise noisy.obj --method laplacian -o smooth.obj");
    let line = "compare clean.obj noisy.obj smooth.obj clean.obj";
    let printed = folder.succeeds_with_json(line);
    let ea = |k: usize| printed["results"][k]["Ea_deg"].as_f64().unwrap();
    assert!(ea(0) > ea(1) && ea(1) > 0.0 && ea(2) == 0.0, "{printed}");
    let table = folder.succeeds(line).out;
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split_whitespace().collect()).collect();
    assert_eq!(rows[0], ["against", "clean.obj"]);
    assert_eq!(rows[1][..2], ["mesh", "Ea"]);
    for (k, file) in ["noisy.obj", "smooth.obj", "clean.obj"].into_iter().enumerate() {
        assert_eq!(rows[2 + k][..2], [file.to_owned(), format!("{:.3}", ea(k))]);
    }
}

#[test]
fn info_names_what_is_wrong_and_where() {
    let mesh = Mesh::grid(4).with_defects().obj();
    let mesh = format!("mtllib none.mtl\nusemtl paint\n{mesh}vt 0 nan\nv 0 0 0\n");
    let folder = Folder::with("in.obj", &mesh);
    let text = folder.succeeds("info in.obj").out;
    let line_of = |face: usize| {
        let is_face = |(_, line): &(usize, &str)| line.starts_with("f ");
        mesh.lines().enumerate().filter(is_face).nth(face).unwrap().0 + 1
    };
    let nan = mesh.lines().position(|line| line == "vt 0 nan").unwrap() + 1;
    for note in [
        "1 vertex is used by no face".to_owned(),
        "1 `v` line is welded to another one".to_owned(),
        "16 edges have one face only: the mesh is open there".to_owned(),
        format!("1 face has fewer than three different vertices, the first in line {}", line_of(18)),
        format!("2 faces repeat an earlier one, the first in line {}", line_of(16)),
        format!("1 `vt` line is not finite, the first in line {nan}"),
        "none.mtl: No such file".to_owned(),
    ] {
        assert!(text.contains(&note), "no `{note}` in\n{text}");
    }
    let printed = folder.succeeds_with_json("info in.obj");
    assert_eq!((printed["closed"].clone(), printed["volume"].is_null()), (false.into(), true));
    assert_eq!((&printed["faces"], &printed["defects"]["isolated_vertices"]), (&19.into(), &1.into()));
}

#[test]
fn measures_have_digits_whatever_the_unit() {
    let mut tiny = Mesh::grid(4).obj();
    tiny.push_str("v 0 0 -0.0\n");
    let folder = Folder::with("in.obj", tiny);
    let text = folder.succeeds("info in.obj").out;
    assert!(text.contains("area 1.00000\n") && text.contains("from (0, 0, 0) to (1, 1, 0)"), "{text}");
    let mut mesh = Mesh::grid(4);
    mesh.positions.iter_mut().flatten().for_each(|x| *x *= 1e-3);
    folder.write("in.obj", mesh.obj());
    let text = folder.succeeds("info in.obj").out;
    assert!(text.contains("mean edge 0.000250000, area 1.00000e-6"), "{text}");
}

#[test]
fn info_and_bake_count_the_same_seam() {
    let folder = Folder::with("in.obj", Mesh::sphere(6).split_at_seams().obj());
    let [info, baked] =
        ["info in.obj", "bake in.obj --method laplacian -o out --layout uv"].map(|line| folder.succeeds(line).out);
    // Five vertices of the meridian, and the poles.
    assert!(info.contains("7 vertices on seams"), "{info}");
    assert!(baked.contains("7 vertices with several"), "{baked}");
}

#[test]
fn info_measures_a_closed_surface() {
    let folder = Folder::with("in.obj", Mesh::sphere(64).obj());
    let printed = folder.succeeds_with_json("info in.obj");
    let number = |field: &str| printed[field].as_f64().unwrap();
    // The surface of chords lies inside the sphere by (π/64)²/8 at most, and more so in both directions.
    assert!((number("area") / (4.0 * std::f64::consts::PI) - 1.0).abs() < 3e-3);
    assert!((number("volume") / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 3e-3);
    assert_eq!((&printed["closed"], &printed["components"]), (&true.into(), &1.into()));
    // The meridian without its ends, and at each pole all edges: there the triangles have a uv vertex each.
    let seams = 62 + 2 * 128;
    let layout = &printed["layout"];
    assert_eq!((&layout["charts"], &layout["seam_edges"]), (&1.into(), &seams.into()));
    assert!(folder.succeeds("info in.obj").out.contains(&format!("1 chart, {seams} edges along seams")));
}
