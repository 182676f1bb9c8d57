//! `planish noise --kind`.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;

/// Kinds with the settings that each has.
const KINDS: [(&str, &[&str]); 12] = [
    ("white", &["sigma", "direction"]),
    ("impulsive", &["sigma", "direction", "share"]),
    ("correlated", &["sigma", "correlation"]),
    ("rounded", &["sigma"]),
    ("camera", &["sigma", "correlation", "towards", "distance"]),
    ("fade", &["sigma", "direction", "towards"]),
    ("partial", &["sigma", "direction", "share", "towards"]),
    ("local", &["sigma", "direction"]),
    ("spikes", &["share", "length"]),
    ("range-image", &["sigma", "correlation", "towards", "distance", "step"]),
    ("fusion", &["sigma", "correlation", "distance", "step"]),
    ("voxels", &["step"]),
];

/// Kinds that make a mesh with vertices of its own.
const REMESHED: [&str; 3] = ["range-image", "fusion", "voxels"];

/// A value for each setting, which is the default of no kind.
const VALUES: [(&str, &str); 8] = [
    ("sigma", "0.15"),
    ("direction", "random"),
    ("share", "0.3"),
    ("length", "3"),
    ("correlation", "2"),
    ("towards", "-1,0.5,2"),
    ("distance", "4"),
    ("step", "0.7"),
];

#[test]
fn every_kind_reports_the_settings_it_has_and_repeats_with_its_seed() {
    let folder = Folder::with("in.obj", Mesh::sphere(8).noisy(0.01).obj());
    for (kind, settings) in KINDS {
        let line = format!("noise in.obj -o out.obj --kind {kind} --seed 5");
        let printed = folder.succeeds_with_json(&line);
        assert_eq!([&printed["kind"], &printed["seed"]], [&Value::from(kind), &Value::from(5)]);
        let mut named: Vec<&str> = printed["settings"].as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(named, settings, "{kind}");
        let first = folder.bytes("out.obj");
        assert!(first != folder.bytes("in.obj"), "{kind}");
        folder.succeeds(&line);
        assert!(folder.bytes("out.obj") == first, "{kind}");
        folder.succeeds(&format!("noise in.obj -o out.obj --kind {kind} --seed 6"));
        assert!(folder.bytes("out.obj") != first, "{kind}");
        named.retain(|name| *name == "sigma");
        assert_eq!(printed["sigma"].is_null(), named.is_empty(), "{kind}");
    }
}

#[test]
fn a_setting_is_used_by_the_kinds_that_have_it_and_refused_for_the_others() {
    let folder = Folder::with("in.obj", Mesh::sphere(8).noisy(0.01).obj());
    for (kind, settings) in KINDS {
        folder.succeeds(&format!("noise in.obj -o plain.obj --kind {kind}"));
        for (setting, value) in VALUES {
            let line = format!("noise in.obj -o out.obj --kind {kind} --{setting} {value}");
            if settings.contains(&setting) {
                let printed = folder.succeeds_with_json(&line);
                assert!(folder.bytes("out.obj") != folder.bytes("plain.obj"), "{line}");
                let shown = &printed["settings"][setting];
                let as_given = shown.as_str().map_or_else(|| shown.to_string(), str::to_owned);
                assert!(setting == "towards" || as_given.trim_end_matches(".0") == value, "{line}: {shown}");
            } else {
                folder.refuses(&line, &[&format!("--{setting} goes with --kind "), &format!(", not {kind}")]);
            }
        }
    }
    let printed = folder.succeeds_with_json("noise in.obj -o out.obj --kind fade --towards 0,-3,0");
    assert_eq!(printed["settings"]["towards"], serde_json::json!([0.0, -1.0, 0.0]));
}

#[test]
fn the_short_options_are_the_kinds_white_and_impulsive() {
    let folder = Folder::with("in.obj", Mesh::sphere(8).obj());
    for (short, long) in [
        ("--sigma 0.2 --seed 7", "--kind white --sigma 0.2 --seed 7"),
        ("--sigma 0.2 --direction random", "--kind white --sigma 0.2 --direction random"),
        ("--sigma 0.3 --impulsive 0.4", "--kind impulsive --share 0.4 --sigma 0.3"),
        ("--sigma 0.3 --impulsive 1", "--kind white --sigma 0.3"),
    ] {
        folder.succeeds(&format!("noise in.obj -o short.obj {short}"));
        folder.succeeds(&format!("noise in.obj -o long.obj {long}"));
        assert!(folder.bytes("short.obj") == folder.bytes("long.obj"), "{short}");
    }
    for line in ["--kind white --sigma 1 --impulsive 0.3", "--kind impulsive --impulsive 0.3 --share 0.2"] {
        folder.refuses_usage(&format!("noise in.obj -o out.obj {line}"), &["cannot be used with"]);
    }
}

#[test]
fn the_clean_part_of_partial_noise_keeps_its_bytes() {
    let mesh = Mesh::sphere(12).obj();
    let folder = Folder::with("in.obj", &mesh);
    folder.succeeds("noise in.obj -o out.obj --kind partial --share 0.5 --towards 1,0,0");
    let out = folder.text("out.obj");
    let pairs = mesh.lines().zip(out.lines()).filter(|(line, _)| line.starts_with("v "));
    let x = |line: &str| line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap();
    // The wavy line stays within a tenth of the radius of the sphere around the box, and half the area is at positive x.
    for (before, after) in pairs {
        assert!(before == after || x(before) > -0.4, "{before}");
        assert!(before != after || x(before) < 0.4, "{before}");
    }
}

#[test]
fn vertices_that_a_seam_splits_move_together() {
    let mesh = Mesh::sphere(8).split_at_seams();
    let folder = Folder::with("in.obj", mesh.obj());
    for (kind, _) in KINDS.iter().filter(|(kind, _)| !REMESHED.contains(kind)) {
        folder.succeeds(&format!("noise in.obj -o out.obj --kind {kind}"));
        let out = folder.text("out.obj");
        let lines: Vec<&str> = out.lines().filter(|line| line.starts_with("v ")).collect();
        for (i, p) in mesh.positions.iter().enumerate() {
            let first = mesh.positions.iter().position(|q| q == p).unwrap();
            assert_eq!(lines[i], lines[first], "{kind}");
        }
    }
}

#[test]
fn values_out_of_range_are_refused() {
    let folder = Folder::with("in.obj", Mesh::grid(4).obj());
    for (option, word) in [
        ("--kind loud", "loud"),
        ("--kind spikes --share 1.5", "between 0 and 1"),
        ("--kind spikes --length -1", "between 0 and"),
        ("--kind correlated --correlation 101", "between 0 and 100"),
        ("--kind camera --distance 1", "at least 1.1"),
        ("--kind voxels --step 0", "between 0.000001 and"),
        ("--kind camera --towards 0,0,0", "three numbers"),
        ("--kind camera --towards 1,2", "three numbers"),
        ("--kind fade --towards 1,nan,2", "three numbers"),
    ] {
        folder.refuses_usage(&format!("noise in.obj -o new/out.obj {option}"), &[word]);
    }
}

#[test]
fn a_mesh_that_is_measured_anew_comes_with_its_clean_counterpart() {
    let folder = Folder::with("in.obj", Mesh::sphere(12).obj());
    for kind in REMESHED {
        folder.succeeds(&format!("noise in.obj -o noisy.obj --clean truth.obj --kind {kind} --seed 4"));
        let line = format!("noise in.obj -o alone.obj --kind {kind} --seed 4");
        assert!(folder.succeeds_with_json(&line).get("clean").is_none());
        assert!(folder.bytes("alone.obj") == folder.bytes("noisy.obj"), "{kind}");
        let faces = |name: &str| -> Vec<String> {
            folder.text(name).lines().filter(|line| line.starts_with("f ")).map(str::to_owned).collect()
        };
        assert!(faces("noisy.obj") == faces("truth.obj") && faces("noisy.obj") != faces("in.obj"), "{kind}");
        let compared = folder.succeeds_with_json("compare truth.obj noisy.obj");
        let ea = compared["results"][0]["Ea_deg"].as_f64().unwrap();
        assert!((1.0..60.0).contains(&ea), "{kind}: {ea}");
    }
    let printed = folder.succeeds("noise in.obj -o noisy.obj --clean truth.obj --kind fusion").out;
    assert!(printed.starts_with("wrote noisy.obj and truth.obj\n  fusion noise: "), "{printed}");

    let line = "noise in.obj -o new/noisy.obj --clean";
    folder.refuses(&format!("{line} new/noisy.obj --kind voxels"), &["new/noisy.obj", "both"]);
    folder.refuses(&format!("{line} in.obj --kind voxels"), &["in.obj", "is an input"]);
    folder.refuses(&format!("{line} truth.obj --sigma 1"), &["--clean", "range-image, fusion, voxels", "the input"]);
    folder.write("open.obj", Mesh::grid(4).obj());
    folder.refuses("noise open.obj -o new/noisy.obj --kind voxels", &["open.obj: ", "is open"]);
    folder.refuses("noise in.obj -o new/noisy.obj --kind voxels --step 0.0001", &["in.obj: ", "too many", "step"]);
}
