//! Bakes arrays into the files of a displacement map, each as bytes in memory, and prints their sizes and errors.
//!
//! `cargo run --release --example bake_in_memory`
#![allow(clippy::print_stdout)]

use glam::DVec2;
use planish_geometry::bake::{self, BakeSettings, BundleNames, SideFiles};
use planish_geometry::mesh::shapes;
use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::{Arrays, MeshData};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A rough square sheet, whose texture coordinates leave a border free.
    let clean = shapes::grid(48);
    let noise = Noise { sigma: 0.3, direction: Direction::Normal, share: 1.0, seed: 1 };
    let noisy = synthetic_noise::noisy(&clean, &noise);
    let arrays = Arrays {
        positions: noisy.positions().to_vec(),
        faces: noisy.triangles().map(Vec::from).collect(),
        uvs: clean.positions().iter().map(|p| DVec2::splat(0.05) + 0.9 * p.truncate()).collect(),
        ..Arrays::default()
    };
    let model = Model::new(MeshData::try_from(arrays)?, Welding::Exact);

    let names = BundleNames { source: "sheet.obj".into(), stem: "sheet".into(), carrier: "sheet".into() };
    let bundle = bake::bake(&model, &names, SideFiles::NONE, &BakeSettings::default(), &Silent)?;
    for file in &bundle.files {
        println!("{:>8} bytes  {}", file.bytes.len(), file.name);
    }

    let (map, report) = (&bundle.manifest.displacement, &bundle.manifest.report);
    println!("{} × {} texels, height = {} + {} · texel", map.width, map.height, map.bias, map.scale);
    println!("largest error {:e}, mean error {:e}, one step {:e}", report.max_error, report.mean_error, report.quantum);
    println!(
        "gap at seams {:e}, vertices off by more than the tolerance: {}",
        report.seam_gap, report.unresolved_vertices
    );
    Ok(())
}
