//! `planish denoise`

use crate::args::DenoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use planish_geometry::denoise::{Denoiser, auto};
use planish_geometry::progress::Progress as _;
use serde::Serialize;

#[derive(Serialize)]
struct Denoised {
    output: String,
    method: Denoiser,
    /// What the method `auto` measured and chose.
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<auto::Choice>,
    vertices: usize,
    faces: usize,
    mean_edge: f64,
    mean_displacement: f64,
    max_displacement: f64,
}

pub(crate) fn run(args: &DenoiseArgs, console: &Console) -> Result<(), Failure> {
    let method = args.method.denoiser()?;
    let output = Output::open(&args.output, &[&args.input])?;
    let model = super::model(&args.input, args.method.weld, console)?;
    let surface = model.surface();
    let (deltas, choice) = method.run(surface, console)?;
    let places: Vec<_> = surface.positions().iter().zip(&deltas).map(|(p, d)| *p - *d).collect();
    if let Some(v) = places.iter().position(|p| !p.is_finite()) {
        let line = model.weld().first()[v] + 1;
        return Err(Failure::Internal(format!(
            "vertex {line} went to infinity: use a smaller --step or fewer --iterations"
        )));
    }
    console.stage("writing");
    let normals = args.update_normals.then(|| model.updated_file_normals(&places));
    let bytes = model.obj().with_positions(&model.weld().spread(&places), normals.as_deref());
    console.check()?;
    let written = output.write(&bytes)?;
    let lengths = || deltas.iter().map(|d| d.length());
    let report = Denoised {
        output: written.display().to_string(),
        method,
        choice,
        vertices: model.obj().positions().len(),
        faces: model.obj().faces().len(),
        mean_edge: surface.mean_edge(),
        mean_displacement: lengths().sum::<f64>() / deltas.len() as f64,
        max_displacement: lengths().fold(0.0, f64::max),
    };
    if model.obj().normals().is_empty() && args.update_normals {
        console.warn(&format!("{}: --update-normals has nothing to do, there are no `vn` lines", args.input.display()));
    } else if !model.obj().normals().is_empty() && !args.update_normals {
        console.warn("the `vn` lines still hold the noisy normals; --update-normals gives them new numbers");
    }
    console.report(&report, || {
        let Denoised { output, mean_edge, mean_displacement, max_displacement, vertices, .. } = &report;
        let chosen = report.choice.as_ref().map(|choice| format!("  auto: {choice}\n")).unwrap_or_default();
        format!(
            "wrote {output}\n{chosen}  {vertices} vertices, moved by {:.3} mean edge lengths on average, {:.3} at most\n",
            mean_displacement / mean_edge,
            max_displacement / mean_edge
        )
    });
    Ok(())
}
