//! The command `planish check`.

use crate::args::CheckArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use planish_files::map_files::MapFiles;
use planish_files::method;
use planish_files::text::{self, shown};
use planish_geometry::bake::{self, BakeTarget, WrittenFiles};
use planish_geometry::denoise::Denoising;
use planish_geometry::map::manifest::{self, Method, Report};
use planish_geometry::progress::Progress as _;
use planish_geometry::source::model::Model;
use serde::Serialize;
use std::path::PathBuf;

/// Report of the command.
#[derive(Serialize)]
struct Checked<'a> {
    manifest: String,
    mesh: String,
    /// Errors of the files, measured now.
    report: &'a Report,
    /// Ways in which the files are worse than the manifest says, one sentence each.
    differences: Vec<String>,
}

pub(crate) fn run(args: &CheckArgs, console: &Console) -> Result<(), Failure> {
    console.stage("reading");
    let path = &args.manifest;
    let files = MapFiles::read(path, args.trust.rule())?;
    let manifest = &files.manifest;
    let mesh: PathBuf = args.mesh.clone().unwrap_or_else(|| files.source());
    if args.mesh.is_none() && !mesh.exists() {
        return Err(Failure::at(&mesh, "does not exist any more; name the mesh that was baked with --mesh"));
    }
    let source = files.source_mesh(args.mesh.as_deref())?;
    if manifest::sha256(&source.bytes()) != manifest.source.sha256 {
        return Err(files.foreign(&mesh));
    }
    files.check_all()?;
    console.check()?;
    let carrier = files.carrier_mesh()?;
    let model = Model::new(source, manifest.welding);
    console.check()?;
    let target = target(&files, &model)?;
    let read = |name: &str| files.bytes_of(name, input::LARGEST_PICTURE);
    let images = files.images().into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let images: Vec<&[u8]> = images.iter().map(Vec::as_slice).collect();
    let written = WrittenFiles { displacement: &images, carrier: carrier.data() };
    let report = bake::check(&model, manifest, &target, written, console).map_err(|e| match e {
        bake::BakeError::Cancelled(_) => Failure::Interrupted,
        bake::BakeError::Decode(e) => Failure::at(&files.path_of(&manifest.displacement.file), e),
        bake::BakeError::DecodePage { ref page, .. } => {
            let entry = manifest.page_entries().iter().find(|entry| entry.part.to_string() == *page);
            Failure::at(&files.path_of(entry.map_or(&manifest.displacement.file, |entry| &entry.file)), e)
        }
        bake::BakeError::OtherPages => Failure::at(path, format!("field `pages`: {e}")),
        bake::BakeError::OtherMesh(e) => files.explain(e, &mesh),
        bake::BakeError::OtherCarrier(e) => files.explain(e, &files.carrier()),
        e => Failure::at(&mesh, e),
    })?;
    let checked = Checked {
        manifest: path.display().to_string(),
        mesh: mesh.display().to_string(),
        report: &report,
        differences: differences(&manifest.report, &report),
    };
    console.report(&checked, || {
        let errors = text::errors(&report, manifest.displacement.scale);
        let verdict = if checked.differences.is_empty() { "as its manifest says" } else { "not as its manifest says" };
        format!("{}: {verdict}\n  error {errors}\n  gap {} at seams\n", shown(path), report.seam_gap)
    })?;
    match checked.differences.as_slice() {
        [] => Ok(()),
        all => Err(Failure::Internal(format!("{}: {}", shown(path), all.join("; ")))),
    }
}

/// Returns what the map was baked from: a method that is ready to run, or the mesh that other means denoised.
fn target(files: &MapFiles, model: &Model) -> Result<BakeTarget, Failure> {
    let path = files.path.as_path();
    match &files.manifest.method {
        Method::Denoiser(Denoising { denoiser, limits }) => {
            let denoiser = method::prepare_of_manifest(denoiser.clone(), path, files.trust)?;
            Ok(BakeTarget::Method(Denoising { denoiser, limits: limits.clone() }))
        }
        Method::Target(target) => {
            let target_path = files.path_of(&target.file);
            let denoised = files.target_mesh(target)?;
            if denoised.data().positions().len() != model.data().positions().len() {
                return Err(Failure::at(
                    &target_path,
                    format!("has not as many {} as the mesh", denoised.format().vertices()),
                ));
            }
            Ok(BakeTarget::from_mesh(model, denoised.data(), target.clone()))
        }
        Method::Other(_) => {
            let name = files.manifest.method.name();
            Err(Failure::at(path, format!("field `method`: this planish does not know {name:?}")))
        }
    }
}

/// Lists where the measured report is worse than the one in the manifest.
fn differences(promised: &Report, measured: &Report) -> Vec<String> {
    let mut out = Vec::new();
    let mut compare = |quantity: &str, promised: f64, measured: f64| {
        // A measurement that is not a number keeps no promise.
        let is_kept = measured <= promised;
        if !is_kept {
            out.push(format!("{quantity} is {measured:e}, and the manifest says {promised:e}"));
        }
    };
    compare("the largest error", promised.error_bound, measured.max_error);
    compare(
        "the 99th percentile of the errors",
        promised.error_bound.min(promised.p99_error * 1.01),
        measured.p99_error,
    );
    compare("the gap at seams", promised.seam_gap, measured.seam_gap);
    compare(
        "the number of unresolved vertices",
        promised.unresolved_vertices as f64,
        measured.unresolved_vertices as f64,
    );
    out
}
