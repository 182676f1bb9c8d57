//! Makes the samples to which the networks and the trees of the noise estimate are fitted (see `training/README.md`).
//!
//! ```text
//! cargo run --release -p planish-geometry --example noise_samples -- FOLDER samples.npy
//! ```
//!
//! FOLDER holds clean meshes, OBJ. Each is disturbed by noise of many kinds, and is a sample without noise as well.

mod npy;

use planish_geometry::denoise::{RegionSample, noise_samples};
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::synthetic_noise::{Direction, Disturbed, SyntheticKind, SyntheticNoise, disturb};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Silent;
use planish_geometry::source::model::Model;
use planish_geometry::source::obj::Obj;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Number of noisy versions of each mesh.
const DRAWS: u64 = 20;

/// Kinds of noise; those that are hardest to tell are drawn more often.
const KINDS: [SyntheticKind; 16] = [
    SyntheticKind::White,
    SyntheticKind::White,
    SyntheticKind::White,
    SyntheticKind::Impulsive,
    SyntheticKind::Correlated,
    SyntheticKind::Correlated,
    SyntheticKind::Rounded,
    SyntheticKind::Camera,
    SyntheticKind::Fade,
    SyntheticKind::Partial,
    SyntheticKind::Partial,
    SyntheticKind::Local,
    SyntheticKind::RangeImage,
    SyntheticKind::Fusion,
    SyntheticKind::Fusion,
    SyntheticKind::Voxels,
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(folder), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: noise_samples FOLDER OUTPUT.npy".into());
    };
    let files = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
    let mut meshes: Vec<PathBuf> = files.into_iter().filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
    meshes.sort();
    let rows = meshes.par_iter().enumerate().map(|(mesh, path)| of_mesh(mesh, path).unwrap_or_default());
    let rows: Vec<Vec<f32>> = rows.flatten_iter().collect();
    std::fs::write(&output, file_of(&rows))?;
    let names = meshes.iter().filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned() + "\n"));
    std::fs::write(output.with_extension("txt"), names.collect::<String>())?;
    Ok(())
}

/// Rows of one mesh: statistics of a region, its σ and correlation, and the numbers of the mesh and of the draw, 0 of
/// which is the clean mesh.
fn of_mesh(mesh: usize, path: &Path) -> Result<Vec<Vec<f32>>, Box<dyn Error>> {
    let model = Model::new(Obj::parse(std::fs::read(path)?)?, Welding::Exact);
    let clean = model.surface();
    let mut rows = Vec::new();
    let mut add = |draw: u64, clean: &Surface, noisy: &Surface| -> Result<(), Box<dyn Error>> {
        let row = |sample: RegionSample| {
            let truth = [sample.sigma, sample.correlation, mesh as f64, draw as f64];
            sample.statistics.iter().chain(&truth).map(|x| *x as f32).collect()
        };
        rows.extend(noise_samples(clean, noisy, &Silent)?.into_iter().map(row));
        Ok(())
    };
    add(0, clean, clean)?;
    for draw in 1..=DRAWS {
        match disturb(clean, &drawn(mesh as u64 * 1000 + draw)) {
            Ok(Disturbed::Moved(offsets)) => {
                add(draw, clean, &clean.at(clean.positions().iter().zip(offsets).map(|(p, d)| *p + d).collect()))?;
            }
            Ok(Disturbed::Remeshed(pair)) => {
                add(draw, &pair.clean, &pair.noisy)?;
                // The triangles of an instrument alone are no noise.
                add(DRAWS + draw, &pair.clean, &pair.clean)?;
            }
            // An open mesh has no inside, and a coarse one shows a camera too little.
            Err(_) => {}
        }
    }
    Ok(rows)
}

/// Noise of a random kind, with random settings.
fn drawn(seed: u64) -> SyntheticNoise {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let kind = KINDS[random.random_range(0..KINDS.len())];
    let usual = SyntheticNoise::of_kind(kind, seed);
    let share = if kind == SyntheticKind::Impulsive { [0.05, 0.4] } else { [0.1, 0.8] };
    SyntheticNoise {
        sigma: between(&mut random, [0.03f64.ln(), 0.6f64.ln()]).exp(),
        direction: if random.random() { Direction::Normal } else { Direction::Random },
        share: between(&mut random, share),
        correlation: between(&mut random, if kind == SyntheticKind::Camera { [0.0, 3.0] } else { [1.0, 6.0] }),
        distance: between(&mut random, [1.6, 4.0]),
        ..usual
    }
}

fn between(random: &mut impl Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// Rows as a file of NumPy, in single precision.
fn file_of(rows: &[Vec<f32>]) -> Vec<u8> {
    let mut bytes = npy::head("<f4", rows.len(), rows.first().map_or(0, Vec::len));
    bytes.extend(rows.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}
