//! The command `planish apply`.

use super::measure;
use crate::args::ApplyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use planish_files::map_files::MapFiles;
use planish_geometry::map::displace;
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::path::PathBuf;

/// Report of the command.
#[derive(Serialize)]
struct Applied {
    output: String,
    mesh: String,
    lambda: f64,
    vertices: usize,
    max_displacement: f64,
}

pub(crate) fn run(args: &ApplyArgs, console: &Console) -> Result<(), Failure> {
    console.stage("reading");
    let files = MapFiles::read(&args.manifest)?;
    let entry = &files.manifest.displacement;
    let mesh: PathBuf = args.mesh.clone().unwrap_or_else(|| files.carrier());
    let output = Output::open(&args.output, &[&args.manifest, &mesh, &files.image()])?;

    let map = files.displacement()?;
    let source = input::source(&mesh)?;
    console.check()?;
    console.stage("displacing");
    let vertices = files.vertices(&source, &mesh)?;
    let lambda = args.lambda.unwrap_or(entry.lambda);
    let displaced = displace::displaced(&vertices, &map, lambda as f32, entry.origin);
    let moved = source.data().positions().iter().zip(&displaced).map(|(p, q)| p.distance(*q));
    let max_displacement = moved.fold(0.0, f64::max);
    console.stage("writing");
    let bytes = source.with_positions(&displaced, None).map_err(|e| Failure::at(&mesh, e))?;
    console.check()?;
    let written = output.write(&bytes)?;
    let report = Applied {
        output: written.display().to_string(),
        mesh: mesh.display().to_string(),
        lambda,
        vertices: displaced.len(),
        max_displacement,
    };
    console.report(&report, || {
        let Applied { output, mesh, lambda, vertices, max_displacement } = &report;
        format!(
            "wrote {output}\n  {vertices} vertices of {mesh} displaced with λ = {lambda}, by {} at most\n",
            measure(*max_displacement)
        )
    });
    Ok(())
}
