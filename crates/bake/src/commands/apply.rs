//! `planish apply`

use super::measure;
use crate::args::ApplyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use glam::Vec3;
use planish_geometry::apply::{self, Places, ShaderVertex};
use planish_geometry::displacement::{Displacement, MapKind};
use planish_geometry::manifest::{self, Manifest, UvSource};
use planish_geometry::model::{Model, NormalSource};
use planish_geometry::obj::Obj;
use planish_geometry::progress::Progress as _;
use planish_geometry::texture::tangents;
use planish_geometry::weld::Welding;
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
    let obj = input::obj(&mesh)?;
    console.check()?;
    console.stage("displacing");
    let vertices = shader_vertices(&obj, &manifest, &mesh, &args.manifest)?;
    let lambda = args.lambda.unwrap_or(entry.lambda);
    let places = apply::displaced(&vertices, &map, lambda as f32, entry.origin);
    let moved = obj.positions().iter().zip(&places).map(|(p, q)| p.distance(*q));
    let max_displacement = moved.fold(0.0, f64::max);
    console.stage("writing");
    let bytes = obj.with_positions(&places, None);
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

/// The vertices of the carrier as it is, or of the source with the normals that the bake used.
fn shader_vertices(obj: &Obj, manifest: &Manifest, mesh: &Path, named_in: &Path) -> Result<Vec<ShaderVertex>, Failure> {
    let digest = manifest::sha256(obj.bytes());
    let dominant = manifest.dominant_pairs();
    let named = |&[v, vt]: &[u32; 2]| (v as usize) < obj.positions().len() && (vt as usize) < obj.uvs().len();
    let is_carrier = digest == manifest.carrier.sha256;
    if !is_carrier && digest != manifest.source.sha256 {
        let reason = format!(
            "is not the mesh that {} belongs to: neither {} nor its carrier {}, byte for byte",
            named_in.display(),
            manifest.source.file,
            manifest.carrier.obj
        );
        return Err(Failure::at(mesh, reason));
    }
    if !is_carrier && manifest.displacement.uvs == UvSource::Unwrapped {
        let carrier = named_in.with_file_name(&manifest.carrier.obj);
        let reason = format!(
            "lacks the texture coordinates of the map, which the bake made; use the carrier {}",
            carrier.display()
        );
        return Err(Failure::at(mesh, reason));
    }
    if let Some([v, vt]) = dominant.iter().find(|pair| !named(pair)) {
        let reason =
            format!("field `dominant_uv.seam_vertices`: the mesh has no vertex {} or no `vt` {}", v + 1, vt + 1);
        return Err(Failure::at(named_in, reason));
    }
    let places = Places::new(manifest.displacement.layout, &dominant);
    let origin = manifest.displacement.origin;
    let needs_frames = manifest.displacement.map == MapKind::VectorTangent;
    if is_carrier && !needs_frames {
        return Ok(apply::carrier_vertices(obj, places, origin));
    }
    // A carrier has its vertices where welding put them.
    let welding = match manifest.welding {
        Welding::Epsilon(_) if is_carrier => Welding::Exact,
        welding => welding,
    };
    let model = Model::new(obj.clone(), welding);
    let of_carrier = |carrier: &Obj| -> Vec<Vec3> {
        let of_lines: Vec<Vec3> = apply::carrier_vertices(carrier, places, origin).iter().map(|v| v.normal).collect();
        model.weld().first().iter().map(|&line| of_lines[line as usize]).collect()
    };
    let normals = if is_carrier {
        of_carrier(obj)
    } else if manifest.normals == NormalSource::Denoised {
        // Only its carrier has them without denoising once more.
        let path = named_in.with_file_name(&manifest.carrier.obj);
        let carrier = input::obj(&path)?;
        if manifest::sha256(carrier.bytes()) != manifest.carrier.sha256 {
            let reason = format!("has the normals of the map, and is not the file that {} names", named_in.display());
            return Err(Failure::at(&path, reason));
        }
        of_carrier(&carrier)
    } else {
        model.displacement_normals(manifest.normals, &[]).map_err(|e| Failure::at(mesh, e))?
    };
    let mut vertices = apply::source_vertices(obj, &model.weld().spread(&normals), places, origin);
    if needs_frames {
        let atlas = model.atlas().map_err(|e| Failure::at(mesh, e))?;
        let of_corners = tangents::tangents(model.surface(), &atlas, &normals);
        let frames = tangents::at_vertices(model.surface(), &atlas, &normals, &of_corners);
        for (vertex, frame) in vertices.iter_mut().zip(model.weld().spread(&frames)) {
            vertex.tangent = frame;
        }
    }
    Ok(vertices)
}
