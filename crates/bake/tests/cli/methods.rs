//! Methods and their options.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;

/// Names of all methods.
fn methods(folder: &Folder) -> Vec<String> {
    let table = folder.succeeds_with_json("methods");
    let names: Vec<String> = table.as_array().unwrap().iter().map(|method| text(&method["name"])).collect();
    assert!(names.len() >= 12, "{names:?}");
    names
}

fn folder() -> Folder {
    Folder::with("in.obj", Mesh::sphere(8).noisy(0.1).with_defects().obj())
}

#[test]
fn every_method_denoises_and_bakes_a_mesh_of_polygons_with_defects() {
    let folder = folder();
    for method in methods(&folder) {
        let report = folder.succeeds_with_json(&format!("denoise in.obj -o out.obj --method {method}"));
        assert_eq!(report["method"]["name"], *method);
        assert!(report["max_displacement"].as_f64().unwrap() > 0.0, "{method}");
        folder.succeeds(&format!("bake in.obj -o out --size 64 --method {method}"));
        let mut method = folder.json("out/in.planish.json")["method"].clone();
        // A map of heights is a map of what heights can hold.
        let pointers = ["/motion", "/vertex_update/motion"]
            .into_iter()
            .filter(|pointer| report["method"].pointer(pointer).is_some());
        for pointer in pointers {
            let motion = method.pointer_mut(pointer).unwrap();
            assert_eq!(motion.take(), "along-normal");
            *motion = "free".into();
        }
        assert_eq!(method, report["method"]);
    }
}

#[test]
fn options_land_where_the_manifest_has_them() {
    let folder = folder();
    let method = |options: &str| -> Value {
        folder.succeeds_with_json(&format!("denoise in.obj -o out.obj --method {options}"))["method"].clone()
    };
    let guided = method("guided-normals --iterations 3 --sigma-range 0.5 --vertex-iterations 4 --motion along-normal");
    assert_eq!([&guided["iterations"], &guided["sigma_range"]], [&Value::from(3), &Value::from(0.5)]);
    let update = &guided["vertex_update"];
    assert_eq!([&update["iterations"], &update["motion"]], [&Value::from(4), &Value::from("along-normal")]);
    assert_eq!(method("sun --vertex-update least-squares")["vertex_update"]["scheme"], "least-squares");
    assert_eq!(method("sun --boundary free")["vertex_update"]["boundary"], "free");
    assert_eq!(method("hc --boundary free")["boundary"], "free");
    let map = method("map --noise 0.1 --prior smooth --strength 3 --iterations 2 --motion along-normal");
    assert_eq!([&map["noise"], &map["prior"]["threshold"]], [0.1, 0.1]);
    assert_eq!([&map["prior"]["strength"], &map["prior"]["rounds"]], [&Value::from(3.0), &Value::from(2)]);
    assert_eq!(map["motion"], "along-normal");
    let auto = method("auto --noise 0.2 --noise-kind uneven --candidates flat,linear --boundary fixed");
    assert_eq!([&auto["kind"], &auto["boundary"]], ["uneven", "fixed"]);
    assert_eq!(auto["candidates"], serde_json::json!(["flat", "linear"]));
    // Those of the paper hold nothing back, and options come on top.
    let paper = method("bilateral-normals --preset paper --sigma-range 0.4");
    assert_eq!(paper["vertex_update"]["closeness"], 0.0);
    assert_eq!(paper["vertex_update"]["fold_overs"], "allow");
    assert_eq!([&paper["iterations"], &paper["sigma_range"]], [&Value::from(20), &Value::from(0.4)]);
}

#[test]
fn auto_is_the_default_and_says_what_it_measured_and_chose() {
    let folder = Folder::with("in.obj", Mesh::sphere(24).noisy(0.05).obj());
    let said = folder.succeeds("denoise in.obj -o out.obj").out;
    assert!(said.contains("auto: noise of") && said.contains(" % "), "{said}");
    let printed = folder.succeeds_with_json("denoise in.obj -o out.obj");
    assert_eq!(printed["method"]["name"], "auto");
    let shares = printed["choice"]["candidates"].as_array().unwrap();
    let total: f64 = shares.iter().map(|share| share["share"].as_f64().unwrap()).sum();
    assert!((total - 1.0).abs() < 1e-12 && printed["choice"]["sigma"].as_f64().unwrap() > 0.1, "{printed}");
    folder.succeeds("bake in.obj -o out --size 64");
    assert_eq!(folder.json("out/in.planish.json")["choice"], printed["choice"]);
    // Nothing has to be done to a clean mesh.
    let clean = Folder::with("in.obj", Mesh::sphere(24).obj());
    let said = clean.succeeds("denoise in.obj -o out.obj").out;
    assert!(said.contains("no noise that could be told from the surface: left alone"), "{said}");
    assert_eq!(clean.text("out.obj"), clean.text("in.obj"));
}

#[test]
fn an_option_of_another_method_is_refused_with_the_methods_it_goes_with() {
    let folder = folder();
    for (options, words) in [
        ("--inflate -0.6", "--inflate goes with --method taubin"),
        ("--method hc --time 3", "--time goes with --method implicit"),
        (
            "--method l0 --closeness 1",
            "--closeness goes with --method sun, bilateral-normals, guided-normals, tgv-normals",
        ),
        ("--method sun --weights uniform", "--weights goes with --method laplacian, taubin, implicit"),
        ("--method l0 --iterations 3", "--iterations goes with --method laplacian, taubin, hc, implicit, bilateral, "),
        ("--preset paper", "--preset paper goes with --method hc, bilateral, sun, "),
    ] {
        folder.refuses(&format!("denoise in.obj -o new/out.obj {options}"), &[words]);
        folder.refuses(&format!("bake in.obj -o new {options}"), &[words]);
    }
    for option in ["--method sun", "--sigma-range 1", "--closeness 0", "--preset paper", "--boundary free"] {
        folder.refuses_usage(&format!("bake in.obj -o new --target in.obj {option}"), &["--target"]);
    }
}

#[test]
fn no_option_of_a_method_or_limit_goes_with_a_target() {
    let folder = folder();
    let methods = folder.succeeds_with_json("methods");
    let parameters = methods.as_array().unwrap().iter().flat_map(|method| method["parameters"].as_array().unwrap());
    let mut options: Vec<String> = parameters
        .map(|p| {
            let value = if p["words"][0].is_null() { p["min"].to_string() } else { text(&p["words"][0]["name"]) };
            format!("--{}={value}", text(&p["name"]))
        })
        .collect();
    options.sort();
    options.dedup();
    let others = ["--method=sun", "--preset=paper", "--fix=boundary", "--max-displacement=1", "--preserve-volume"];
    options.extend(others.map(str::to_owned));
    for option in options {
        let name = option.split('=').next().unwrap();
        folder.refuses_usage(&format!("bake in.obj -o new --target in.obj {option}"), &["--target", name]);
    }
    folder.succeeds("bake in.obj -o out --size 64 --target in.obj --weld none");
}

fn text(value: &Value) -> String {
    value.as_str().unwrap().to_owned()
}

#[test]
fn the_help_of_every_option_says_default_range_and_methods() {
    let folder = folder();
    let help = folder.succeeds("denoise --help").out;
    // Line breaks are where the terminal has them.
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for method in folder.succeeds_with_json("methods").as_array().unwrap() {
        let name = text(&method["name"]);
        assert!(help.contains(&format!("- {name}: {}", text(&method["summary"]))), "{name}");
        for parameter in method["parameters"].as_array().unwrap() {
            let option = text(&parameter["name"]);
            let said = help.split(&format!(" --{option} <")).nth(1).unwrap_or_else(|| panic!("--{option}"));
            // The next option begins before its value.
            let said = said.split(" <").next().unwrap();
            assert!(said.contains(&name) && said.contains("[default: "), "--{option} of {name}: {said}");
            assert_eq!(said.contains("[range: "), !parameter["min"].is_null(), "--{option}: {said}");
        }
    }
}

#[test]
fn the_table_of_methods_is_the_help_of_the_command_and_the_documentation() {
    let folder = Folder::new();
    let all = folder.succeeds("methods").out;
    assert!(methods(&folder).iter().all(|name| all.contains(&format!("{name}\n  "))), "{all}");
    for help in ["help methods", "methods --help"] {
        let help = folder.succeeds(help).out;
        assert!(help.contains("--sigma-range") && help.contains("Smoothing that does not shrink"), "{help}");
    }
    let one = folder.succeeds("methods implicit").out;
    assert!(one.starts_with("implicit\n") && one.contains("Cholesky") && !one.contains("taubin"), "{one}");
    folder.refuses_usage("methods none", &["none"]);
    let page = folder.succeeds("methods --markdown").out;
    let committed = include_str!("../../../../docs/methods.md");
    assert!(page == committed, "docs/methods.md is old: cargo run -- methods --markdown > docs/methods.md");
}

#[test]
fn neighbours_may_be_spelt_either_way() {
    let folder = folder();
    for option in ["--neighbours", "--neighbors"] {
        let report =
            folder.succeeds_with_json(&format!("denoise in.obj -o o.obj --method bilateral-normals {option} edge"));
        assert_eq!(report["method"]["neighbours"], "edge");
    }
}

#[test]
fn networks_of_ones_own_are_read_from_a_file_and_checked_again() {
    let folder = Folder::with("in.obj", Mesh::sphere(12).noisy(0.01).obj());
    let weights = concat!(env!("CARGO_MANIFEST_DIR"), "/../geometry/src/denoise/learned/weights.safetensors");
    let bytes = std::fs::read(weights).unwrap();
    folder.write("own/w.safetensors", &bytes);
    folder.write("own/broken", &bytes[..1000]);
    folder.succeeds("denoise in.obj --method learned -o built-in.obj");
    folder.succeeds("denoise in.obj --method learned --network own/w.safetensors -o own.obj");
    assert!(folder.bytes("own.obj") == folder.bytes("built-in.obj"));
    folder.refuses(
        "denoise in.obj --method learned --network own/broken -o new.obj",
        &["own/broken: not a safetensors file"],
    );
    folder.refuses("denoise in.obj --method learned --network own -o new.obj", &["own: is a directory"]);
    folder.refuses("denoise in.obj --method learned --network none -o new.obj", &["none: "]);
    folder
        .refuses("denoise in.obj --method taubin --network none -o new.obj", &["--network goes with --method learned"]);
    let baked = folder.succeeds_with_json("bake in.obj --method learned --network own/w.safetensors -o own/out");
    let manifest = folder.json("own/out/in.planish.json");
    let settings = manifest["method"].as_object().unwrap();
    assert_eq!(settings["network"], "../w.safetensors", "{baked}");
    assert_eq!(settings["network_sha256"].as_str().unwrap().len(), 64);
    folder.refuses("check own/out/in.planish.json", &["w.safetensors", "--trust"]);
    folder.succeeds("check own/out/in.planish.json --trust");
    folder.write("own/w.safetensors", &bytes[..bytes.len() - 1]);
    folder.refuses("check own/out/in.planish.json --trust", &["w.safetensors: is not the file of weights"]);
}
