//! The meshes in `data/` are what their commands make.

use planish_geometry::map::manifest;
use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
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
        let moved = synthetic_noise::noisy(clean.surface(), &settings);
        let noisy = clean.source().with_positions(&clean.weld().spread(moved.positions()), None).unwrap();
        assert!(noisy == *model(&format!("{name}_noisy.obj")).source().bytes(), "{name}");
    }
}
