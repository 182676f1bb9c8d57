//! Meshes as they are out there, from the folder that `PLANISH_MESHES` names.

use crate::support::{bake, keeps_its_promises, meshes_from_outside, meshes_in, model};
use planish_geometry::bake::BakeSettings;
use planish_geometry::denoise::{Denoiser, Laplacian};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;

fn one_full_step() -> BakeSettings {
    let method = Denoiser::Laplacian(Laplacian { iterations: 1, step: 1.0, ..Laplacian::default() });
    BakeSettings { target: method.into(), ..BakeSettings::default() }
}

/// Bakes a mesh at the usual sizes: from crowded to two texels and more between vertices.
fn is_baked_within_bounds(name: &str) {
    let folder = meshes_from_outside();
    let model = model(std::fs::read(folder.join(name)).unwrap(), Welding::Exact);
    for side in [512, 1024, 2048, 4096] {
        let settings = BakeSettings { side: Some(side), ..one_full_step() };
        keeps_its_promises(&model, &settings, &bake(&model, &settings));
    }
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn spot_is_baked_within_bounds() {
    is_baked_within_bounds("spot_n0.2_noisy.obj");
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn the_boat_is_baked_within_bounds() {
    is_baked_within_bounds("boat_n0.2_noisy.obj");
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn every_scan_with_texture_coordinates_is_baked_within_bounds() {
    let folder = meshes_from_outside();
    let scans = meshes_in(&folder.join("scans"));
    assert!(!scans.is_empty());
    for path in scans {
        let model = model(std::fs::read(&path).unwrap(), Welding::Exact);
        if model.atlas().is_ok() {
            println!("{}", path.display());
            let settings = BakeSettings { side: Some(256), ..one_full_step() };
            keeps_its_promises(&model, &settings, &bake(&model, &settings));
        }
    }
}

#[test]
#[ignore = "needs PLANISH_MESHES"]
fn every_mesh_gets_through() {
    let folder = meshes_from_outside();
    let meshes = [meshes_in(&folder), meshes_in(&folder.join("scans"))].concat();
    assert!(!meshes.is_empty());
    for path in meshes {
        let model = model(std::fs::read(&path).unwrap(), Welding::Exact);
        let defects = model.defects();
        let topology = model.surface().topology();
        let left_out = defects.degenerate_faces + defects.duplicate_faces;
        assert_eq!(topology.faces().len() + left_out, model.data().faces().len(), "{}", path.display());
        let denoised = Denoiser::default().denoised(model.surface(), &Silent).unwrap();
        assert!(denoised.iter().all(|p| p.is_finite()), "{}", path.display());
        let written = model.source().with_positions(&model.weld().spread(&denoised), None).unwrap();
        let spread = model.weld().spread(&denoised);
        assert!(
            planish_geometry::source::obj::Obj::parse(written).unwrap().data().positions() == spread,
            "{}",
            path.display()
        );
    }
}
