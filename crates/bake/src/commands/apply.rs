//! The command `planish apply`.

use super::{measure, one_line};
use crate::args::ApplyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use planish_files::map_files::MapFiles;
use planish_files::mesh_output;
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
    /// Largest distance between a displaced position and the one that the file holds, model units.
    rounding: f64,
    /// Contents of the mesh that the output has no place for, each in a few words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lost: Vec<String>,
}

pub(crate) fn run(args: &ApplyArgs, console: &Console) -> Result<(), Failure> {
    console.stage("reading");
    let files = MapFiles::read(&args.manifest, args.trust.rule())?;
    let entry = &files.manifest.displacement;
    let mesh: PathBuf = args.mesh.clone().unwrap_or_else(|| files.mesh_for(&args.output));
    // Not a file of the bundle either, even one that is not read now.
    let inputs: Vec<PathBuf> = files.paths().into_iter().chain([mesh.clone()]).collect();
    let output = Output::open(&args.output, &inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    console.reserve_stdout([&output])?;

    let source = match &args.mesh {
        Some(mesh) => input::source(mesh, args.trust.rule())?,
        None => files.mesh_at(&mesh)?,
    };
    console.check()?;
    console.stage("displacing");
    let lambda = args.lambda.unwrap_or(entry.lambda);
    let displaced = files.displaced(&source, &mesh, lambda)?;
    let moved = source.data().positions().iter().zip(&displaced).map(|(p, q)| p.distance(*q));
    let max_displacement = moved.fold(0.0, f64::max);
    console.stage("writing");
    let file = mesh_output::write(&args.output, &source, &displaced, None)?;
    console.check()?;
    let written = output.write(&file.bytes)?;
    mesh_output::warnings(&args.output, &mesh, &source, &file, f64::INFINITY).iter().for_each(|w| console.warn(w));
    let report = Applied {
        output: written.display().to_string(),
        mesh: mesh.display().to_string(),
        lambda,
        vertices: displaced.len(),
        max_displacement,
        rounding: file.rounding,
        lost: file.lost,
    };
    console.report(&report, || {
        let Applied { output, mesh, lambda, vertices, max_displacement, .. } = &report;
        format!(
            "wrote {}\n  {vertices} vertices of {} displaced with λ = {lambda}, by {} at most\n",
            one_line(output),
            one_line(mesh),
            measure(*max_displacement)
        )
    })
}
