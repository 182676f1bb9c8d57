//! Height maps of a denoised surface, and the report on what heights leave out.

use crate::folder::Folder;
use crate::mesh::Mesh;
use serde_json::Value;

/// A noisy sphere; noise along the normals or in random directions.
fn folder(direction: &str) -> Folder {
    let mut mesh = Mesh::sphere(24);
    // Polygons that noise bends would be cut otherwise than the clean ones.
    let halves = |face: Vec<[usize; 2]>| (2..face.len()).map(move |k| vec![face[0], face[k - 1], face[k]]);
    mesh.faces = std::mem::take(&mut mesh.faces).into_iter().flat_map(halves).collect();
    let folder = Folder::with("clean.obj", mesh.obj());
    folder.succeeds(&format!("noise clean.obj -o in.obj --sigma 0.2 --direction {direction}"));
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// Ea of some results, degrees.
fn ea(folder: &Folder, results: &str) -> Vec<f64> {
    let printed = folder.succeeds_with_json(&format!("compare clean.obj {results}"));
    printed["results"].as_array().unwrap().iter().map(|result| number(&result["Ea_deg"])).collect()
}

#[test]
fn a_baked_map_does_what_the_along_normal_form_does() {
    for direction in ["normal", "random"] {
        let folder = folder(direction);
        for method in ["bilateral-normals", "sun"] {
            let report = folder
                .succeeds_with_json(&format!("denoise in.obj -o along.obj --method {method} --motion along-normal"));
            let baked = folder.succeeds_with_json(&format!("bake in.obj -o out --layout vertex --method {method}"));
            folder.succeeds("apply out/in.planish.json -o applied.obj");
            folder.succeeds("apply out/in.planish.json --mesh in.obj -o from_source.obj");
            assert!(folder.bytes("applied.obj").len() > 1000);
            let manifest = &baked["manifest"];
            assert_eq!(manifest["method"]["vertex_update"]["motion"], "along-normal");
            assert_eq!(
                [&manifest["normals"], &manifest["report"]["heights"]["lost_deg"]],
                [&report["heights"]["normals"], &report["heights"]["lost_deg"]]
            );
            let [along, applied, from_source] = ea(&folder, "along.obj applied.obj from_source.obj")[..] else {
                panic!("three results")
            };
            // 16 bits and single precision.
            assert!((applied / along - 1.0).abs() < 0.01, "{method}: {along} {applied}");
            assert!((from_source - applied).abs() < 1e-3, "{method}: {applied} {from_source}");
            assert!(folder.succeeds("check out/in.planish.json").out.contains("as its manifest says"));
        }
    }
}

#[test]
fn noise_that_heights_cannot_hold_is_named_and_a_map_of_vectors_recommended() {
    for (direction, sigma, much) in [("normal", 0.2, false), ("random", 0.4, true)] {
        let folder = folder(direction);
        folder.succeeds(&format!("noise clean.obj -o in.obj --sigma {sigma} --direction {direction}"));
        let line = "bake in.obj -o out --layout vertex --method bilateral-normals";
        let printed = folder.succeeds(line);
        assert_eq!(printed.err.contains("--map vector"), much, "{direction}: {}", printed.err);
        assert!(printed.out.contains("heights lose"), "{}", printed.out);
        let heights = &folder.json("out/in.planish.json")["report"]["heights"];
        let (turned, lost) = (number(&heights["turned_deg"]), number(&heights["lost_deg"]));
        assert_eq!((lost > 0.5 && lost > 0.1 * turned) || number(&heights["leaning"]) > 0.2, much, "{heights}");
        // A map of vectors loses nothing and says nothing of it.
        let printed = folder.succeeds_with_json(&format!("{line} --map vector"));
        assert!(printed["manifest"]["report"].get("heights").is_none());
        assert_eq!(printed["manifest"]["method"]["vertex_update"]["motion"], "free");
        folder.succeeds("apply out/in.planish.json -o applied.obj");
        folder.succeeds("denoise in.obj -o free.obj --method bilateral-normals");
        let [free, applied] = ea(&folder, "free.obj applied.obj")[..] else { panic!("two results") };
        assert!((applied / free - 1.0).abs() < 1e-3, "{free} {applied}");
    }
}

#[test]
fn normals_can_be_chosen_and_others_project() {
    let folder = folder("normal");
    let baked = |options: &str| folder.succeeds_with_json(&format!("bake in.obj -o out --layout vertex {options}"));
    for normals in ["angle", "denoised", "leaning", "area"] {
        for method in ["laplacian", "bilateral-normals"] {
            let manifest = &baked(&format!("--method {method} --normals {normals}"))["manifest"];
            assert_eq!(manifest["normals"], normals);
            let direction = if normals == "angle" { "NORMAL" } else { "CUSTOM_NORMAL" };
            assert_eq!(manifest["clients"]["blender"]["direction"], direction);
            folder.succeeds("check out/in.planish.json");
        }
    }
    // Without a motion of its own a method is projected, as ever.
    let manifest = &baked("--method taubin")["manifest"];
    assert_eq!((&manifest["normals"], manifest["method"].get("motion")), (&"angle".into(), None));
    assert!(number(&manifest["report"]["heights"]["lost_deg"]) > 0.0);
}

#[test]
fn the_normals_of_the_denoised_surface_are_in_the_carrier() {
    let folder = folder("normal");
    folder.succeeds("bake in.obj -o out --layout vertex --method sun --normals denoised");
    let carrier = folder.bytes("out/in.obj");
    folder.write("out/in.obj", [carrier.as_slice(), b"# touched\n"].concat());
    folder.refuses("apply out/in.planish.json --mesh in.obj -o new.obj", &["out/in.obj", "normals of the map"]);
}
