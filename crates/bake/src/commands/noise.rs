//! The command `planish noise`.

use super::measure;
use crate::args::NoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use glam::DVec3;
use planish_geometry::mesh::synthetic_noise::{self, NoiseSetting, SyntheticKind, SyntheticNoise};
use planish_geometry::progress::Progress as _;
use planish_geometry::source::model::Model;
use serde::Serialize;
use serde_json::{Map, Value};

/// Report of the command.
#[derive(Serialize)]
struct Added {
    output: String,
    kind: SyntheticKind,
    /// Settings that the kind has.
    settings: Map<String, Value>,
    seed: u64,
    vertices: usize,
    moved_vertices: usize,
    mean_edge: f64,
    /// Standard deviation that was asked for; `None` for a kind that has none.
    sigma: Option<f64>,
    rms_displacement: f64,
}

pub(crate) fn run(args: &NoiseArgs, console: &Console) -> Result<(), Failure> {
    let noise = args.noise()?;
    let output = Output::open(&args.output, &[&args.input])?;
    let model = super::model(&args.input, args.welding.weld, console)?;
    console.stage("noise");
    let displacements = synthetic_noise::synthetic_displacements(model.surface(), &noise);
    console.stage("writing");
    let bytes = displaced(&model, &displacements).map_err(|e| Failure::at(&args.input, e))?;
    console.check()?;
    let written = output.write(&bytes)?;
    let report = Added::new(written.display().to_string(), &noise, &model, &displacements);
    console.report(&report, || report.text());
    Ok(())
}

/// Returns the file of a mesh with displacements (#V×3) added to its positions.
pub(super) fn displaced(model: &Model, displacements: &[DVec3]) -> Result<Vec<u8>, planish_geometry::source::NoFile> {
    let noisy: Vec<_> = model.surface().positions().iter().zip(displacements).map(|(p, d)| *p + *d).collect();
    model.source().with_positions(&model.weld().spread(&noisy), None)
}

impl Added {
    fn new(output: String, noise: &SyntheticNoise, model: &Model, displacements: &[DVec3]) -> Self {
        let moved_vertices = displacements.iter().filter(|d| d.length_squared() > 0.0).count();
        let squares = displacements.iter().map(|d| d.length_squared()).sum::<f64>();
        Self {
            output,
            kind: noise.kind,
            settings: noise.to_json(),
            seed: noise.seed,
            vertices: displacements.len(),
            moved_vertices,
            mean_edge: model.surface().mean_edge(),
            sigma: noise.kind.settings().contains(&NoiseSetting::Sigma).then_some(noise.sigma),
            rms_displacement: (squares / moved_vertices.max(1) as f64).sqrt(),
        }
    }

    fn text(&self) -> String {
        let Self { output, kind, vertices, moved_vertices, mean_edge, rms_displacement, .. } = self;
        let rms = rms_displacement / mean_edge;
        format!(
            "wrote {output}\n  {} noise: {moved_vertices} of {vertices} vertices moved, rms {rms:.4} mean edge lengths of {}\n",
            kind.name(),
            measure(*mean_edge)
        )
    }
}
