//! `planish apply`

use super::measure;
use crate::args::ApplyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use planish_geometry::apply::{self, MeshError};
use planish_geometry::displacement::Displacement;
use planish_geometry::manifest::Manifest;
use planish_geometry::progress::Progress as _;
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    let manifest = Manifest::from_json(&input::read(&args.manifest)?).map_err(|e| Failure::at(&args.manifest, e))?;
    let beside = |name: &str| args.manifest.parent().unwrap_or(Path::new("")).join(name);
    let mesh: PathBuf = args.mesh.clone().unwrap_or_else(|| beside(&manifest.carrier.obj));
    let image = beside(&manifest.displacement.file);
    let output = Output::open(&args.output, &[&args.manifest, &mesh, &image])?;

    let entry = &manifest.displacement;
    let map = Displacement::decode(&input::read(&image)?, entry.map, entry.size(), entry.encoding())
        .map_err(|e| Failure::at(&image, e))?;
    let source = input::source(&mesh)?;
    console.check()?;
    console.stage("displacing");
    let vertices = apply::baked_vertices(&source, &manifest, &|| input::obj(&beside(&manifest.carrier.obj)).ok())
        .map_err(|e| explain(e, &manifest, &mesh, &args.manifest))?;
    let lambda = args.lambda.unwrap_or(entry.lambda);
    let places = apply::displaced(&vertices, &map, lambda as f32, entry.origin);
    let moved = source.data().positions().iter().zip(&places).map(|(p, q)| p.distance(*q));
    let max_displacement = moved.fold(0.0, f64::max);
    console.stage("writing");
    let bytes = source.with_positions(&places, None).map_err(|e| Failure::at(&mesh, e))?;
    console.check()?;
    let written = output.write(&bytes)?;
    let report = Applied {
        output: written.display().to_string(),
        mesh: mesh.display().to_string(),
        lambda,
        vertices: places.len(),
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

/// What is wrong, in the words of somebody who gave the two files.
fn explain(error: MeshError, manifest: &Manifest, mesh: &Path, named_in: &Path) -> Failure {
    match error {
        MeshError::Foreign => {
            let reason = format!(
                "is not the mesh that {} belongs to: neither {} nor its carrier {}, byte for byte",
                named_in.display(),
                manifest.source.file,
                manifest.carrier.obj
            );
            Failure::at(mesh, reason)
        }
        MeshError::NeedsCarrier => {
            let carrier = named_in.with_file_name(&manifest.carrier.obj);
            let reason = format!(
                "lacks the texture coordinates of the map, which the bake made; use the carrier {}",
                carrier.display()
            );
            Failure::at(mesh, reason)
        }
        MeshError::NeedsCarrierNormals => {
            let carrier = named_in.with_file_name(&manifest.carrier.obj);
            let reason = format!("has the normals of the map, and is not the file that {} names", named_in.display());
            Failure::at(&carrier, reason)
        }
        MeshError::NoSuchPlace { vertex, uv } => {
            let (v, vt) = (vertex + 1, uv + 1);
            let reason = format!("field `dominant_uv.seam_vertices`: the mesh has no vertex {v} or no `vt` {vt}");
            Failure::at(named_in, reason)
        }
        e @ (MeshError::Normals(_) | MeshError::Atlas(_)) => Failure::at(mesh, e),
    }
}
