//! Denoises arrays of positions and triangles, first without a parameter, then by a method of one's own choice.
//!
//! `cargo run --release --example denoise_arrays`
#![allow(clippy::print_stdout)]

use glam::DVec3;
use planish_geometry::denoise::{BilateralNormals, Denoiser};
use planish_geometry::mesh::shapes;
use planish_geometry::mesh::synthetic_noise::{self, Direction, Noise};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::{ArrayError, Arrays, MeshData};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let clean = shapes::sphere(4);
    let noise = Noise { sigma: 0.3, direction: Direction::Normal, share: 1.0, seed: 1 };
    let noisy = synthetic_noise::noisy(&clean, &noise);
    let faces: Vec<[u32; 3]> = noisy.triangles().collect();
    println!("noisy: {:.5} from the unit sphere", distance(noisy.positions()));

    let denoised = planish_geometry::denoise(noisy.positions(), &faces)?;
    println!("auto: {:.5}", distance(&denoised));

    // A method with its settings takes a surface, and can report progress and be stopped.
    let model = model(noisy.positions(), &faces)?;
    let method = Denoiser::BilateralNormals(BilateralNormals::default());
    let denoised = method.denoised(model.surface(), &Silent)?;
    println!("{}: {:.5}", method.name(), distance(&denoised));
    Ok(())
}

/// Makes a model of arrays, whose surface has vertices with equal positions welded.
fn model(positions: &[DVec3], faces: &[[u32; 3]]) -> Result<Model, ArrayError> {
    let faces = faces.iter().map(|face| face.to_vec()).collect();
    let arrays = Arrays { positions: positions.to_vec(), faces, ..Arrays::default() };
    Ok(Model::new(MeshData::try_from(arrays)?, Welding::Exact))
}

/// Mean distance of positions to the unit sphere.
fn distance(positions: &[DVec3]) -> f64 {
    positions.iter().map(|p| (p.length() - 1.0).abs()).sum::<f64>() / positions.len() as f64
}
