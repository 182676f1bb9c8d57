//! `planish bench-quality --noise`.

use crate::folder::{Folder, Printed};
use crate::mesh::Mesh;
use serde_json::Value;

/// Two clean meshes, a sphere and a grid, in two groups and one.
fn meshes() -> Folder {
    let folder = Folder::with("clean/ball.obj", Mesh::sphere(10).obj());
    folder.write("clean/grid.obj", Mesh::grid(8).obj());
    folder.write(
        "clean/MANIFEST.tsv",
        "name\tsplit\tgroup\nball\tx\tround,closed\ngrid.obj.xz\tx\tflat\nother\tx\tflat\n",
    );
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn strings<'a>(list: &'a Value, field: &str) -> Vec<&'a str> {
    list.as_array().unwrap().iter().map(|entry| entry[field].as_str().unwrap()).collect()
}

#[test]
fn pairs_are_what_noise_denoise_and_compare_make() {
    let folder = meshes();
    let line = "bench-quality clean --noise white:0.3,rounded,clean --methods taubin,laplacian,sun --csv q.csv";
    let json = folder.succeeds_with_json(line);
    assert_eq!(strings(&json["pairs"], "mesh"), ["ball", "ball", "ball", "grid", "grid", "grid"]);
    assert_eq!(strings(&json["pairs"], "kind")[..3], ["white:0.3", "rounded", "clean"]);
    for pair in json["pairs"].as_array().unwrap() {
        let [mesh, kind] = ["mesh", "kind"].map(|field| pair[field].as_str().unwrap());
        let clean = format!("clean/{mesh}.obj");
        match kind {
            "clean" => folder.write("noisy.obj", folder.bytes(&clean)),
            _ => {
                let options = kind.replace(":", " --sigma ");
                folder.succeeds(&format!("noise {clean} -o noisy.obj --kind {options} --seed {}", pair["seed"]));
            }
        }
        let ea = |method: &str| {
            folder.succeeds(&format!("denoise noisy.obj -o out.obj --method {method}"));
            let compared = folder.succeeds_with_json(&format!("compare {clean} noisy.obj out.obj"));
            [0, 1].map(|k| number(&compared["results"][k]["Ea_deg"]))
        };
        let [noisy, first] = ea("taubin");
        assert_eq!([&pair["Ea_noisy_deg"], &pair["Ea_first_deg"]].map(number), [noisy, first], "{mesh} {kind}");
        assert_eq!(pair["worse_than_input"], first > noisy);
        if kind == "clean" {
            assert!(pair["ratio"].is_null() && pair["best_method"].is_null());
        } else {
            let others = [ea("laplacian")[1], ea("sun")[1]];
            let best = others[0].min(others[1]);
            assert_eq!(number(&pair["Ea_best_deg"]), best, "{mesh} {kind}");
            assert_eq!(pair["best_method"], if best == others[0] { "laplacian" } else { "sun" });
            // The grid is flat, and stays so where it is rounded.
            let ratio = (best > 0.0).then_some(first / best);
            assert_eq!(pair["ratio"].as_f64(), ratio, "{mesh} {kind}");
        }
    }
    // Three methods on each noisy mesh, and one on each clean mesh.
    let table = folder.text("q.csv");
    assert_eq!(table.lines().count(), 1 + 2 * (3 + 3 + 1));
    assert!(table.starts_with("mesh,group,kind,method,seconds,Ea_noisy_deg,V,F,closed,Ea_deg,"), "{table}");
    assert_eq!(json["rows"].as_array().unwrap().len(), 14);
}

#[test]
fn summaries_add_up_by_kind_and_by_group() {
    let folder = meshes();
    let line = "bench-quality clean --noise white,correlated,clean --methods laplacian,taubin";
    let json = folder.succeeds_with_json(line);
    assert_eq!(strings(&json["by_kind"], "name"), ["white", "correlated", "clean"]);
    assert_eq!(strings(&json["by_group"], "name"), ["closed", "flat", "round"]);
    let pairs = json["pairs"].as_array().unwrap();
    let ratios = |keep: &dyn Fn(&Value) -> bool| -> Vec<f64> {
        pairs.iter().filter(|pair| keep(pair) && !pair["ratio"].is_null()).map(|pair| number(&pair["ratio"])).collect()
    };
    let holds = |summary: &Value, ratios: &[f64]| {
        assert_eq!(summary["pairs"], ratios.len(), "{summary}");
        if ratios.is_empty() {
            assert!(summary["mean_ratio"].is_null() && summary["worst_ratio"].is_null());
            return;
        }
        let mean = ratios.iter().product::<f64>().powf(1.0 / ratios.len() as f64);
        assert!((number(&summary["mean_ratio"]) / mean - 1.0).abs() < 1e-12, "{summary}");
        assert_eq!(number(&summary["worst_ratio"]), ratios.iter().copied().fold(0.0, f64::max));
        for (field, limit) in [("share_above_1_05", 1.05), ("share_above_1_10", 1.1)] {
            let above = ratios.iter().filter(|ratio| **ratio > limit).count();
            assert_eq!(number(&summary[field]), above as f64 / ratios.len() as f64, "{field}");
        }
    };
    for summary in json["by_kind"].as_array().unwrap() {
        holds(summary, &ratios(&|pair| pair["kind"] == summary["name"]));
    }
    for summary in json["by_group"].as_array().unwrap() {
        holds(summary, &ratios(&|pair| pair["groups"].as_array().unwrap().contains(&summary["name"])));
    }
    holds(&json["all"], &ratios(&|_| true));
    let worst: Vec<f64> = json["worst"].as_array().unwrap().iter().map(|pair| number(&pair["ratio"])).collect();
    assert!(worst.len() == 4 && worst.is_sorted_by(|a, b| a >= b), "{worst:?}");

    let clean = &json["by_kind"][2];
    let on_clean = pairs.iter().filter(|pair| pair["kind"] == "clean").map(|pair| number(&pair["Ea_first_deg"]));
    assert_eq!([&clean["clean_meshes"], &clean["pairs"]], [2, 0]);
    assert_eq!(number(&clean["worst_on_clean_deg"]), on_clean.fold(0.0, f64::max));
    // A grid is flat, and smoothing it within its plane rotates no face.
    let grid = pairs.iter().find(|pair| pair["mesh"] == "grid" && pair["kind"] == "clean").unwrap();
    assert_eq!([&grid["left_alone"], &grid["worse_than_input"]], [true, false]);

    let text = folder.succeeds(line).out;
    for word in ["  by kind ", "\n  correlated ", "  by group ", "\n  round ", "\nthe worst 4:\n", "  left alone\n"] {
        assert!(text.contains(word), "{word} in {text}");
    }
    // Without a table there is one group, and two tables instead of one must not change the noise.
    std::fs::remove_file(folder.path("clean/MANIFEST.tsv")).unwrap();
    let alone = folder.succeeds_with_json("bench-quality clean --noise correlated --methods laplacian --pairs grid");
    assert_eq!(strings(&alone["by_group"], "name"), ["-"]);
    assert!(alone["pairs"][0]["ratio"].is_null(), "one method has nobody to be measured against");
    let same = pairs.iter().find(|pair| pair["mesh"] == "grid" && pair["kind"] == "correlated").unwrap();
    assert_eq!(alone["pairs"][0]["Ea_first_deg"], same["Ea_first_deg"]);
}

#[test]
fn kinds_are_dealt_in_turn_and_large_meshes_left_out() {
    let folder = meshes();
    folder.write("clean/a_large.obj", Mesh::grid(20).obj());
    let line = "bench-quality clean --noise white,fade,local --per-mesh 2 --max-faces 500 --methods laplacian";
    let json = folder.succeeds_with_json(line);
    assert_eq!(strings(&json["skipped"], "mesh"), ["a_large"]);
    assert_eq!(json["skipped"][0]["error"], "800 triangles");
    assert_eq!(strings(&json["pairs"], "mesh"), ["ball", "ball", "grid", "grid"]);
    assert_eq!(strings(&json["pairs"], "kind"), ["white", "fade", "local", "white"]);
    // Voxels need a closed mesh, which is no fault of the grid.
    let voxels =
        folder.succeeds_with_json("bench-quality clean --noise voxels,range-image --max-faces 500 --methods laplacian");
    assert_eq!(strings(&voxels["pairs"], "kind"), ["voxels", "range-image", "range-image"]);
    assert_eq!([&voxels["skipped"][1]["mesh"], &voxels["skipped"][1]["kind"]], ["grid", "voxels"]);
    let many = folder.succeeds_with_json("bench-quality clean --noise white --per-mesh 5 --methods laplacian");
    assert_eq!(many["pairs"].as_array().unwrap().len(), 3, "no kind comes twice");
}

#[test]
fn all_kinds_meet_auto_and_the_classical_methods() {
    let folder = Folder::with("clean/ball.obj", Mesh::sphere(6).obj());
    let json = folder.succeeds_with_json("bench-quality clean --noise all");
    let names =
        ["auto", "laplacian", "taubin-10", "taubin-40", "bilateral-normals", "guided-normals", "l0", "tgv-normals"];
    assert_eq!(strings(&json["methods"], "name"), names);
    let iterations: Vec<&Value> = [2, 3].iter().map(|k| &json["methods"][k]["settings"]["iterations"]).collect();
    assert_eq!(iterations, [10, 40]);
    let kinds = strings(&json["pairs"], "kind");
    assert_eq!(kinds.last(), Some(&"clean"));
    assert!(kinds.len() >= 10 && json["broken"].as_array().unwrap().is_empty(), "{json}");
}

#[test]
fn a_broken_mesh_is_named_and_the_others_are_measured() {
    let folder = meshes();
    folder.write("clean/bad.obj", "v 0 0 x\n");
    let line = "bench-quality clean --noise white --methods laplacian";
    let Printed { code, out, err } = folder.planish(line).output().unwrap().into();
    assert_eq!(code, Some(2));
    assert!(err.starts_with("error: bad: clean/bad.obj: line 1") && err.lines().count() == 1, "{err}");
    for word in ["\n  ball ", "\n  grid ", "not measured: bad: clean/bad.obj"] {
        assert!(out.contains(word), "{word} in {out}");
    }
}

#[test]
fn what_cannot_be_made_is_refused() {
    let folder = meshes();
    folder.write("empty/x", "");
    folder.refuses("bench-quality nowhere --noise all", &["nowhere"]);
    folder.refuses("bench-quality empty --noise all", &["empty: has no mesh *.obj"]);
    folder.refuses("bench-quality clean --noise all --pairs ball,cube", &["no mesh cube.obj"]);
    folder.refuses("bench-quality clean --noise all --set colour=red", &["colour"]);
    folder.refuses("bench-quality clean --noise white --methods laplacian --csv clean/ball.obj", &["is an input"]);
    for (option, word) in [
        ("--noise loud", "loud"),
        ("--noise white:-1", "between 0 and"),
        ("--noise clean:0.2", "clean has no standard deviation"),
        ("--noise spikes:0.2", "spikes has no standard deviation"),
        ("--noise all --per-mesh 0", "per-mesh"),
        ("--noise all --harm", "--harm"),
        ("--per-mesh 2", "required"),
        ("--max-faces 9", "required"),
    ] {
        folder.refuses_usage(&format!("bench-quality clean {option}"), &[word]);
    }
    folder.write("clean/MANIFEST.tsv", "title\tgroup\nball\tround\n");
    folder.refuses("bench-quality clean --noise all", &["MANIFEST.tsv", "no column name or file"]);
}
