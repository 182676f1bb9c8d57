//! The command `planish noise`.

use super::measure;
use crate::args::NoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use planish_geometry::mesh::synthetic_noise::{self, Noise};
use planish_geometry::progress::Progress as _;
use serde::Serialize;

/// Report of the command.
#[derive(Serialize)]
struct Added {
    output: String,
    vertices: usize,
    moved_vertices: usize,
    mean_edge: f64,
    sigma: f64,
    rms_displacement: f64,
}

pub(crate) fn run(args: &NoiseArgs, console: &Console) -> Result<(), Failure> {
    let output = Output::open(&args.output, &[&args.input])?;
    let model = super::model(&args.input, args.welding.weld, console)?;
    let surface = model.surface();
    console.stage("noise");
    let share = args.impulsive.unwrap_or(1.0);
    let noise = Noise { sigma: args.sigma, direction: args.direction, share, seed: args.seed };
    let displacements = synthetic_noise::displacements(surface, &noise);
    let noisy: Vec<_> = surface.positions().iter().zip(&displacements).map(|(p, d)| *p + *d).collect();
    console.stage("writing");
    let bytes = model.source().with_positions(&model.weld().spread(&noisy), None);
    let bytes = bytes.map_err(|e| Failure::at(&args.input, e))?;
    console.check()?;
    let written = output.write(&bytes)?;
    let moved_vertices = displacements.iter().filter(|d| d.length_squared() > 0.0).count();
    let squares = displacements.iter().map(|d| d.length_squared()).sum::<f64>();
    let report = Added {
        output: written.display().to_string(),
        vertices: displacements.len(),
        moved_vertices,
        mean_edge: surface.mean_edge(),
        sigma: args.sigma,
        rms_displacement: (squares / moved_vertices.max(1) as f64).sqrt(),
    };
    console.report(&report, || {
        let Added { output, vertices, moved_vertices, mean_edge, rms_displacement, .. } = &report;
        let rms = rms_displacement / mean_edge;
        format!(
            "wrote {output}\n  {moved_vertices} of {vertices} vertices moved, rms {rms:.4} mean edge lengths of {}\n",
            measure(*mean_edge)
        )
    });
    Ok(())
}
