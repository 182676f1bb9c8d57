//! The command `planish apply`.

use super::measure;
use crate::args::ApplyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use planish_files::map_files::MapFiles;
use planish_files::mesh_output;
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
    /// Largest distance between a displaced position and the one that the file holds, model units.
    rounding: f64,
    /// What the mesh has and the output does not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lost: Vec<String>,
}

pub(crate) fn run(args: &ApplyArgs, console: &Console) -> Result<(), Failure> {
    console.stage("reading");
    let files = MapFiles::read(&args.manifest)?;
    let entry = &files.manifest.displacement;
    let mesh: PathBuf = args.mesh.clone().unwrap_or_else(|| files.mesh_for(&args.output));
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
            "wrote {output}\n  {vertices} vertices of {mesh} displaced with λ = {lambda}, by {} at most\n",
            measure(*max_displacement)
        )
    });
    Ok(())
}
