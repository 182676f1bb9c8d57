//! `planish denoise`

use crate::args::DenoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use planish_geometry::denoise::{Along, Motion};
use planish_geometry::manifest::HeightsLoss;
use planish_geometry::model::NormalSource;
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::fmt::Write as _;

#[derive(Serialize)]
struct Denoised {
    output: String,
    method: planish_geometry::denoise::Denoiser,
    vertices: usize,
    faces: usize,
    mean_edge: f64,
    mean_displacement: f64,
    max_displacement: f64,
    /// With --motion along-normal.
    #[serde(skip_serializing_if = "Option::is_none")]
    heights: Option<Heights>,
}

/// What heights can hold of the free form.
#[derive(Serialize)]
struct Heights {
    normals: NormalSource,
    #[serde(flatten)]
    loss: HeightsLoss,
}

pub(crate) fn run(args: &DenoiseArgs, console: &Console) -> Result<(), Failure> {
    let method = args.method.denoiser()?;
    let output = Output::open(&args.output, &[&args.input])?;
    let model = super::model(&args.input, args.method.weld, console)?;
    let surface = model.surface();
    let (deltas, heights) = if method.motion() == Some(Motion::AlongNormal) {
        let free = method.freed().deltas(surface, console)?;
        let (along, normals) = Along::best(surface, &free, console)?;
        let loss = HeightsLoss::from(along.loss);
        (along.deltas(), Some(Heights { normals, loss }))
    } else {
        (method.deltas(surface, console)?, None)
    };
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
        vertices: model.obj().positions().len(),
        faces: model.obj().faces().len(),
        mean_edge: surface.mean_edge(),
        mean_displacement: lengths().sum::<f64>() / deltas.len() as f64,
        max_displacement: lengths().fold(0.0, f64::max),
        heights,
    };
    if model.obj().normals().is_empty() && args.update_normals {
        console.warn(&format!("{}: --update-normals has nothing to do, there are no `vn` lines", args.input.display()));
    } else if !model.obj().normals().is_empty() && !args.update_normals {
        console.warn("the `vn` lines still hold the noisy normals; --update-normals gives them new numbers");
    }
    console.report(&report, || {
        let Denoised { output, mean_edge, mean_displacement, max_displacement, vertices, heights, .. } = &report;
        let mut text = format!(
            "wrote {output}\n  {vertices} vertices, moved by {:.3} mean edge lengths on average, {:.3} at most\n",
            mean_displacement / mean_edge,
            max_displacement / mean_edge
        );
        if let Some(Heights { normals, loss }) = heights {
            let _ = writeln!(text, "  along normals ({}): {loss}", super::bake::along(*normals));
        }
        text
    });
    Ok(())
}
