//! `compare` with tables and heat maps, and `bench-quality`.

use crate::folder::{Folder, Printed};
use crate::mesh::Mesh;
use serde_json::Value;
use std::collections::HashMap;

/// Two pairs by name: a sphere and a grid.
fn pairs() -> Folder {
    let folder = Folder::new();
    for (name, mesh) in [("ball", Mesh::sphere(10)), ("grid", Mesh::grid(8))] {
        folder.write(&format!("pairs/{name}_clean.obj"), mesh.obj());
        folder.write(&format!("pairs/{name}_noisy.obj"), mesh.noisy(0.02).obj());
    }
    folder
}

/// Rows of a table without quotes, by head.
fn rows(csv: &str) -> Vec<HashMap<String, String>> {
    let mut lines = csv.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let heads = lines.next().unwrap();
    lines
        .map(|cells| {
            assert_eq!(cells.len(), heads.len());
            heads.iter().cloned().zip(cells).collect()
        })
        .collect()
}

/// Place, colour and error of a vertex.
type Coloured = ([f64; 3], [u8; 3], f32);

/// Positions, colours and numbers of a PLY whose vertices are 24 + 3 + 4 bytes, and the number of its faces.
fn ply(bytes: &[u8]) -> (Vec<Coloured>, usize) {
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {element} ")));
        line.unwrap().parse::<usize>().unwrap()
    };
    let (vertices, faces) = bytes[start..].split_at(31 * count("vertex"));
    assert_eq!(faces.len(), 13 * count("face"));
    let vertex = |v: &[u8]| {
        let double = |k: usize| f64::from_le_bytes(v[8 * k..8 * k + 8].try_into().unwrap());
        let quality = f32::from_le_bytes(v[27..31].try_into().unwrap());
        ([double(0), double(1), double(2)], v[24..27].try_into().unwrap(), quality)
    };
    (vertices.chunks(31).map(vertex).collect(), count("face"))
}

#[test]
fn the_table_of_compare_has_the_numbers_of_its_json() {
    let folder = pairs();
    let line = "compare pairs/ball_clean.obj pairs/ball_noisy.obj pairs/ball_clean.obj";
    let json = folder.succeeds_with_json(&format!("{line} --csv out/table.csv"));
    let csv = folder.text("out/table.csv");
    assert_eq!(folder.succeeds(&format!("{line} --csv -")).out, csv);
    let table = rows(&csv);
    assert_eq!(table.len(), 2);
    for (k, row) in table.iter().enumerate() {
        for (field, value) in json["results"][k].as_object().unwrap() {
            let expected = match value {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            assert_eq!(row[field], expected, "{field}");
        }
    }
    let open = folder.succeeds("compare pairs/grid_clean.obj pairs/grid_noisy.obj --csv -").out;
    assert_eq!(rows(&open)[0]["vol_change_pct"], "", "an open mesh has no volume");
    folder.refuses(&format!("{line} --csv - --json"), &["--csv -", "--json"]);
    folder.refuses(&format!("{line} --csv pairs/ball_noisy.obj"), &["is an input"]);
}

#[test]
fn a_heat_map_is_hot_where_a_vertex_was_moved() {
    let mut mesh = Mesh::grid(8);
    let folder = Folder::with("clean.obj", mesh.obj());
    mesh.positions[40][2] = 0.05;
    folder.write("moved.obj", mesh.obj());
    for heat in ["angle", "distance"] {
        let line = format!("compare clean.obj moved.obj --heatmap heat.ply --heat {heat} --heat-max 0.01");
        assert_eq!(folder.succeeds_with_json(&line)["heatmap"]["max"], 0.01);
        let (vertices, faces) = ply(&folder.bytes("heat.ply"));
        assert_eq!((vertices.len(), faces), (81, 128));
        assert_eq!(vertices.iter().map(|v| v.0).collect::<Vec<_>>(), mesh.positions);
        assert_eq!((vertices[40].1, vertices[0].1), ([0xfd, 0xe7, 0x25], [0x44, 0x01, 0x54]), "viridis");
        assert!(vertices[40].2 > 0.01 && vertices[0].2 == 0.0);
        let largest = vertices.iter().map(|v| v.2).fold(0.0, f32::max);
        assert_eq!(vertices[40].2, largest, "{heat}");
    }
    let said = folder.succeeds("compare clean.obj moved.obj --heatmap heat.obj --heat-max 2").out;
    assert!(said.contains("yellow 2.0000°") && said.contains("wrote heat.obj"), "{said}");
    let hot = folder.text("heat.obj").lines().filter(|line| line.starts_with("v 0.5 0.5 0.05 0.99")).count();
    assert_eq!(hot, 1);
}

#[test]
fn each_result_has_its_own_heat_map_or_there_is_none() {
    let folder = pairs();
    folder.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    folder.write("other/ball_noisy.obj", Mesh::sphere(10).obj());
    let both = "compare pairs/ball_clean.obj pairs/ball_noisy.obj";
    folder.refuses(&format!("{both} other/ball_noisy.obj --heatmap new/heat.ply"), &["new/heat-ball_noisy.ply", "two"]);
    folder.refuses(&format!("{both} bad.obj --heatmap new/heat.ply --csv t.csv"), &["bad.obj: line 2"]);
    folder.refuses(&format!("{both} --heatmap heat.png"), &["heat.png", ".ply and .obj"]);
    folder.refuses(&format!("{both} --heatmap heat.ply --csv heat.ply"), &["heat.ply", "--csv"]);
    folder.refuses_usage(&format!("{both} --heat distance"), &["required"]);
    // If one path cannot be written, no other file is written either.
    folder.write("blocked/heat-ball_noisy.ply/x", "");
    folder.refuses(&format!("{both} pairs/ball_clean.obj --csv t.csv --heatmap blocked/heat.ply"), &["is a directory"]);
    folder.succeeds(&format!("{both} pairs/ball_clean.obj --heatmap new/heat.ply"));
    assert_eq!(folder.names("new"), ["heat-ball_clean.ply", "heat-ball_noisy.ply"]);
}

#[test]
fn bench_quality_measures_what_denoise_and_compare_do() {
    let folder = pairs();
    let line = "bench-quality pairs --methods laplacian,l0 --csv q.csv";
    let json = folder.succeeds_with_json(line);
    let found = json["rows"].as_array().unwrap();
    let names: Vec<[&str; 2]> = found.iter().map(|r| ["pair", "method"].map(|f| r[f].as_str().unwrap())).collect();
    assert_eq!(names, [["ball", "laplacian"], ["ball", "l0"], ["grid", "laplacian"], ["grid", "l0"]]);
    for row in found {
        let [pair, method] = ["pair", "method"].map(|field| row[field].as_str().unwrap());
        folder.succeeds(&format!("denoise pairs/{pair}_noisy.obj -o out.obj --method {method}"));
        let both = format!("compare pairs/{pair}_clean.obj out.obj pairs/{pair}_noisy.obj");
        let compared = folder.succeeds_with_json(&both);
        for field in ["Ea_deg", "d_mean_el", "drev_max_el", "flipped"] {
            assert_eq!(row[field], compared["results"][0][field], "{pair} {method} {field}");
        }
        let [ea, noisy] = [0, 1].map(|k| compared["results"][k]["Ea_deg"].as_f64().unwrap());
        assert_eq!(row["Ea_over_noisy"].as_f64().unwrap(), ea / noisy);
        assert!(row["Ea_over_best"].is_null() && row["Ea_over_reference"].is_null());
    }
    let ratio = |k: usize| found[k]["Ea_over_noisy"].as_f64().unwrap();
    let mean = json["means"][1]["Ea_over_noisy"].as_f64().unwrap();
    assert!((mean - (ratio(1) * ratio(3)).sqrt()).abs() < 1e-12);
    let table = rows(&folder.text("q.csv"));
    assert_eq!(table.len(), 4);
    assert_eq!(table[2]["Ea_deg"], found[2]["Ea_deg"].to_string());
}

#[test]
fn bench_quality_measures_harm_to_clean_meshes_where_it_is_asked() {
    let folder = pairs();
    let line = "bench-quality pairs --methods laplacian,auto";
    let json = folder.succeeds_with_json(&format!("{line} --harm"));
    for row in json["rows"].as_array().unwrap() {
        let [pair, method] = ["pair", "method"].map(|field| row[field].as_str().unwrap());
        folder.succeeds(&format!("denoise pairs/{pair}_clean.obj -o out.obj --method {method}"));
        let compared = folder.succeeds_with_json(&format!("compare pairs/{pair}_clean.obj out.obj"));
        assert_eq!(row["Ea_harm_deg"], compared["results"][0]["Ea_deg"], "{pair} {method}");
    }
    assert!(json["rows"][0]["Ea_harm_deg"].as_f64() > Some(0.0), "smoothing rotates the faces of a sphere");
    assert!(json["rows"][1]["Ea_harm_deg"].as_f64() < Some(0.1), "auto leaves clean meshes alone");
    assert!(folder.succeeds(&format!("{line} --harm")).out.contains("on the clean mesh"));
    assert!(folder.succeeds_with_json(line)["rows"][0].get("Ea_harm_deg").is_none());
}

#[test]
fn bench_quality_holds_methods_against_the_manifest() {
    let folder = pairs();
    let manifest = "name\tclean\tnoisy\tEa_noisy\tEa_lap_it3\tEa_bnf\tEa_PUB\n\
        ball\tball_clean.obj\tball_noisy.obj\t0.01\t4.00\t2.00\tABC(pub mesh)=1.00\n\
        scan\t-\tnowhere.obj\t-\t-\t-\t-\n";
    folder.write("pairs/MANIFEST.tsv", manifest);
    let json = folder.succeeds_with_json("bench-quality pairs --methods laplacian,taubin");
    let row = &json["rows"][0];
    let ea = row["Ea_deg"].as_f64().unwrap();
    assert_eq!(row["Ea_over_reference"].as_f64(), Some(ea / 4.0));
    assert_eq!(row["Ea_over_best"].as_f64(), Some(ea / 2.0), "neither the noisy column nor the published one");
    assert_eq!(json["pairs"][0]["best"]["of"], "Ea_bnf");
    assert_eq!(json["pairs"][0]["published"], serde_json::json!({"of": "ABC", "Ea_deg": 1.0}));
    assert_eq!(json["pairs"].as_array().unwrap().len(), 1, "what has no clean mesh is left out");
    // With other settings the column is not that of the method any more.
    let other = folder.succeeds_with_json("bench-quality pairs --methods laplacian --set iterations=7");
    assert!(other["rows"][0]["Ea_over_reference"].is_null());
    assert_eq!(other["methods"][0]["iterations"], 7);
    let text = folder.succeeds("bench-quality pairs --methods laplacian").out;
    for word in ["2.00° best of other programs (Ea_bnf)", "1.00° published (ABC)", "\n  laplacian "] {
        assert!(text.contains(word), "{word} in {text}");
    }
}

#[test]
fn a_broken_mesh_is_named_and_the_rest_goes_on() {
    let folder = pairs();
    folder.write("pairs/bad_clean.obj", "v 0 0 x\n");
    folder.write("pairs/bad_noisy.obj", "v 0 0 0\n");
    folder.write("pairs/odd_clean.obj", Mesh::grid(3).obj());
    folder.write("pairs/odd_noisy.obj", Mesh::grid(4).obj());
    let line = "bench-quality pairs --methods laplacian";
    let Printed { code, out, err } = folder.planish(line).output().unwrap().into();
    assert_eq!(code, Some(2));
    assert!(err.starts_with("error: bad: pairs/bad_clean.obj: line 1") && err.ends_with("(and 1 more)\n"), "{err}");
    assert_eq!(err.lines().count(), 1);
    for word in ["\nball: ", "\ngrid: ", "not measured: bad: ", "not measured: odd: pairs/odd_noisy.obj"] {
        assert!(out.contains(word), "{word} in {out}");
    }
    let json = folder.planish(&format!("{line} --json")).output().unwrap();
    let json: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!([json["rows"].as_array().unwrap().len(), json["broken"].as_array().unwrap().len()], [2, 2]);
}

#[test]
fn bench_quality_refuses_what_it_cannot_find() {
    let folder = pairs();
    folder.write("empty/x", "");
    folder.refuses("bench-quality nowhere", &["nowhere"]);
    folder.refuses("bench-quality empty", &["empty: has no MANIFEST.tsv"]);
    folder.refuses("bench-quality pairs --pairs ball,cube", &["no pair cube", "ball, grid"]);
    folder.refuses("bench-quality pairs --set colour=red", &["colour"]);
    folder.refuses("bench-quality pairs --set iterations=many", &["laplacian"]);
    folder.refuses_usage("bench-quality pairs --methods laplacian,magic", &["magic"]);
    folder.write("empty/MANIFEST.tsv", "name\tnoisy\nx\ty\n");
    folder.refuses("bench-quality empty", &["MANIFEST.tsv", "no column clean"]);
    folder.write("empty/MANIFEST.tsv", "name\tclean\tnoisy\nx\ty\n");
    folder.refuses("bench-quality empty", &["MANIFEST.tsv", "line: 2"]);
}

#[test]
fn a_noise_map_shows_the_deviation_of_the_noise_at_each_vertex() {
    let folder = Folder::with("clean.obj", Mesh::sphere(40).obj());
    folder.succeeds("noise clean.obj --sigma 0.2 --seed 3 -o in.obj");
    let mean_edge =
        folder.succeeds_with_json("denoise in.obj -o out.obj --noise-map new/noise.ply")["mean_edge"].as_f64();
    let (vertices, faces) = ply(&folder.bytes("new/noise.ply"));
    assert_eq!((vertices.len(), faces), (folder.text("in.obj").matches("v ").count(), 2 * (vertices.len() - 2)));
    let mut deviations: Vec<f64> = vertices.iter().map(|(_, _, quality)| f64::from(*quality)).collect();
    deviations.sort_unstable_by(f64::total_cmp);
    let median = deviations[deviations.len() / 2] / mean_edge.unwrap();
    assert!((0.12..0.28).contains(&median), "{median}");
    folder.succeeds("denoise clean.obj -o out.obj --noise-map clean.ply");
    assert!(ply(&folder.bytes("clean.ply")).0.iter().all(|(_, _, quality)| *quality == 0.0));
    folder
        .refuses("denoise in.obj -o a.obj --method taubin --noise-map a.ply", &["--noise-map goes with --method auto"]);
    folder.refuses("denoise in.obj -o a.ply --noise-map a.ply", &["a.ply", "--noise-map"]);
    folder.refuses("denoise in.obj -o a.obj --noise-map a.png", &["a.png", ".ply and .obj"]);
    folder.refuses("denoise in.obj -o a.obj --noise-map in.obj", &["in.obj"]);
}
