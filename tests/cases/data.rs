//! The meshes in `data/` are what their commands make, and the documents speak of what is there.

use planish_geometry::bundle::{self, Belongings, Names, Settings};
use planish_geometry::manifest;
use planish_geometry::model::Model;
use planish_geometry::noise::{self, Direction, Noise};
use planish_geometry::obj::Obj;
use planish_geometry::progress::Silent;
use planish_geometry::weld::Welding;
use serde_json::Value;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn model(name: &str) -> Model {
    Model::new(Obj::parse(std::fs::read(root().join("data").join(name)).unwrap()).unwrap(), Welding::Exact)
}

#[test]
fn checksums_are_right() {
    let readme = std::fs::read_to_string(root().join("data/README.md")).unwrap();
    let (_, listed) = readme.split_once("## Checksums").unwrap();
    let lines: Vec<_> = listed.lines().filter_map(|line| line.trim().split_once("  ")).collect();
    assert_eq!(lines.len(), 6);
    for (digest, name) in lines {
        assert_eq!(manifest::sha256(&std::fs::read(root().join("data").join(name)).unwrap()), digest, "{name}");
    }
}

#[test]
fn clean_meshes_are_closed_manifolds_and_noisy_ones_are_made_of_them() {
    for name in ["duck", "flange"] {
        let clean = model(&format!("{name}_clean.obj"));
        assert_eq!(clean.defects(), Default::default(), "{name}");
        assert!(clean.surface().volume() > 0.0);
        let atlas = clean.atlas().unwrap();
        let charts = atlas.charts(clean.surface());
        assert_eq!(atlas.mirrored_faces(clean.surface()), 0);
        assert!(charts.seam_vertices > 500 && charts.unmapped_faces == 0, "{charts:?}");

        let settings = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 };
        let moved = noise::displacements(clean.surface(), &settings);
        let places: Vec<_> = clean.surface().positions().iter().zip(&moved).map(|(p, d)| *p + *d).collect();
        let noisy = clean.source().with_positions(&clean.weld().spread(&places), None).unwrap();
        assert!(noisy == *model(&format!("{name}_noisy.obj")).source().bytes(), "{name}");
    }
}

/// Names of all fields, with a dot in front of those inside objects.
fn fields(value: &Value, inside: bool, out: &mut Vec<String>) {
    for (key, value) in value.as_object().into_iter().flatten() {
        out.push(if inside { format!(".{key}") } else { key.clone() });
        fields(value, true, out);
    }
}

#[test]
fn every_field_of_a_manifest_is_documented() {
    let names = Names { source: "duck_noisy.obj".into(), stem: "duck_noisy".into(), carrier: "duck_noisy".into() };
    let settings = Settings { side: Some(64), ..Settings::default() };
    let bundle = bundle::bake(&model("duck_noisy.obj"), &names, Belongings::NONE, &settings, &Silent).unwrap();
    let json: Value = serde_json::from_slice(&bundle.files.last().unwrap().bytes).unwrap();
    let document = std::fs::read_to_string(root().join("docs/manifest.md")).unwrap();
    let mut names = Vec::new();
    fields(&json, false, &mut names);
    assert!(names.len() > 50);
    for name in names {
        // As `.field` after the first of a row, with the path before it otherwise, or in the words on `method`.
        let bare = name.trim_start_matches('.');
        let spellings = [format!("`{bare}`"), format!(".{bare}`"), format!("`{bare}."), format!(".{bare}.")];
        assert!(spellings.iter().any(|s| document.contains(s)), "docs/manifest.md does not mention {name}");
    }
}
