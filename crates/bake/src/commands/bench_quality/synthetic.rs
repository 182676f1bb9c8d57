//! `planish bench-quality --noise`: clean meshes times kinds of noise.

mod meshes;
mod report;

use super::{Part, Stdout, denoisers, timed, write_table};
use crate::args::{BenchQualityArgs, NoiseRequest};
use crate::commands::noise::{NoisyMesh, Refused};
use crate::console::Console;
use crate::csv::Csv;
use crate::failure::Failure;
use glam::DVec3;
use meshes::CleanMesh;
use planish_files::input::Trust;
use planish_geometry::denoise::Denoiser;
use planish_geometry::mesh::weld::Welding;
use planish_geometry::metrics::{self, Comparison, Triangles};
use planish_geometry::progress::Progress as _;
use planish_geometry::source::model::Model;
use report::{Pair, Report, Row, Unmeasured};
use serde::Serialize;
use std::path::Path;

/// A method with its settings and a name that no other has.
#[derive(Clone, Serialize)]
pub(super) struct Contender {
    name: String,
    settings: Denoiser,
}

pub(super) fn run(args: &BenchQualityArgs, console: &Console) -> Result<(), Failure> {
    let meshes = meshes::find(&args.folder, &args.pairs)?;
    let requests: Vec<NoiseRequest> = args.noise.iter().flatten().copied().collect();
    let inputs: Vec<&Path> = meshes.iter().map(|mesh| mesh.path.as_path()).collect();
    let csv = args.csv.as_ref().map(|path| Csv::open(path, &inputs, console)).transpose()?;
    let mut report = Report::new(&args.folder, contenders(args)?, &requests);

    // Kinds are dealt to the meshes in turn, as cards are.
    let mut dealt = 0;
    let complete = meshes.iter().enumerate().try_for_each(|(i, mesh)| {
        let part = Part { console, first: i as f64 / meshes.len() as f64, size: 1.0 / meshes.len() as f64 };
        let Some(model) = read(mesh, args.max_faces, &part, &mut report)? else { return Ok(()) };
        let count = args.per_mesh.map_or(requests.len(), |n| requests.len().min(n as usize));
        for k in 0..count {
            let share = part.size / count as f64;
            let part = Part { console, first: part.first + k as f64 * share, size: share };
            bench(mesh, &model, &requests[(dealt + k) % requests.len()], &part, &mut report)?;
        }
        dealt += count;
        Ok(())
    });
    report.finish();
    // After an interruption, results so far are printed, but no table is written: it would look complete.
    if complete.is_ok() && write_table(csv, &report.rows, console)? == Stdout::Taken {
        return report.verdict();
    }
    let printed = console.report(&report, || report.text());
    complete.and(printed).and(report.verdict())
}

/// Returns the methods that were asked for: `auto` and the classical ones if none is named.
fn contenders(args: &BenchQualityArgs) -> Result<Vec<Contender>, Failure> {
    if !args.methods.is_empty() {
        let named = |settings: Denoiser| Contender { name: settings.name().to_owned(), settings };
        return Ok(denoisers(args, &args.methods)?.into_iter().map(named).collect());
    }
    const DEFAULT: [(&str, Option<u32>); 8] = [
        ("auto", None),
        ("laplacian", None),
        ("taubin", Some(10)),
        // Strong and correlated noise wants more smoothing than the usual ten.
        ("taubin", Some(40)),
        ("bilateral-normals", None),
        ("guided-normals", None),
        ("l0", None),
        ("tgv-normals", None),
    ];
    let methods = DEFAULT.map(|(method, _)| Denoiser::named(method).map_err(Failure::internal));
    let methods = methods.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut all = Vec::new();
    for (mut settings, (method, iterations)) in denoisers(args, &methods)?.into_iter().zip(DEFAULT) {
        let mut name = method.to_owned();
        if let Some(count) = iterations {
            settings.set_all(&[("iterations", count.into())]).map_err(Failure::internal)?;
            name = format!("{method}-{count}");
        }
        all.push(Contender { name, settings });
    }
    Ok(all)
}

/// Reads a clean mesh. Returns `None` if it has too many triangles, or if it cannot be read, which is listed in the report.
fn read(
    mesh: &CleanMesh,
    max_faces: Option<usize>,
    part: &Part<'_>,
    report: &mut Report,
) -> Result<Option<Model>, Failure> {
    part.done(0.0);
    let failed = |error: String| Unmeasured { mesh: mesh.name.clone(), kind: None, method: None, error };
    match crate::commands::model(&mesh.path, Welding::Exact, Trust::Folder, part.console) {
        Ok(model) => {
            let triangles = model.surface().triangle_corners().len();
            if max_faces.is_some_and(|most| triangles > most) {
                report.skipped.push(failed(format!("{triangles} triangles")));
                return Ok(None);
            }
            Ok(Some(model))
        }
        Err(Failure::Interrupted) => Err(Failure::Interrupted),
        Err(failure) => {
            report.broken.push(failed(failure.to_string()));
            Ok(None)
        }
    }
}

/// The clean mesh of a pair, and the noisy one as a program reads it from a file.
struct Input {
    clean: Triangles,
    model: Model,
    noisy: Triangles,
    before: Comparison,
}

impl Input {
    fn new(mesh: &CleanMesh, clean: &Model, request: &NoiseRequest) -> Result<Self, Refused> {
        let (model, remeshed) = match request.noise(mesh.seed(&request.name())) {
            Some(noise) => {
                let made = NoisyMesh::new(clean, &noise)?;
                (Model::new(made.read_again()?, Welding::Exact), made.clean)
            }
            None => (clean.clone(), None),
        };
        if model.surface().topology().faces().is_empty() {
            return Err(Refused::Inapplicable("no face is left".to_owned()));
        }
        let clean = Triangles::from(remeshed.as_ref().map_or_else(|| clean.data(), |source| source.data()));
        let noisy = Triangles::from(model.data());
        let before = metrics::compare(&clean, &noisy).map_err(Refused::broken)?;
        Ok(Self { clean, model, noisy, before })
    }

    /// Compares denoised source vertices (#v×3) with the clean mesh.
    fn compare(&self, denoised: Vec<DVec3>) -> Result<Comparison, String> {
        if let Some(v) = denoised.iter().position(|p| !p.is_finite()) {
            return Err(format!("vertex {} went to infinity", v + 1));
        }
        metrics::compare(&self.clean, &self.noisy.at(denoised)).map_err(|e| e.to_string())
    }
}

/// Runs every method on a mesh with noise of one kind; on a clean mesh the first method alone, because the question there is what it
/// spoils.
fn bench(
    mesh: &CleanMesh,
    clean: &Model,
    request: &NoiseRequest,
    part: &Part<'_>,
    report: &mut Report,
) -> Result<(), Failure> {
    let kind = request.name();
    let failed = |method: Option<&str>, error: String| {
        let method = method.map(str::to_owned);
        Unmeasured { mesh: mesh.name.clone(), kind: Some(kind.clone()), method, error }
    };
    part.console.stage("noise");
    let input = match Input::new(mesh, clean, request) {
        Ok(input) => input,
        Err(Refused::Inapplicable(error)) => {
            report.skipped.push(failed(None, error));
            return Ok(());
        }
        Err(Refused::Broken(error)) => {
            report.broken.push(failed(None, error));
            return Ok(());
        }
    };
    let count = if request.kind.is_some() { report.methods.len() } else { 1 };
    let mut rows = Vec::new();
    for (k, contender) in report.methods[..count].iter().enumerate() {
        let share = part.size / count as f64;
        let part = Part { console: part.console, first: part.first + k as f64 * share, size: share };
        let (denoised, seconds) = timed(&contender.settings, &input.model, &part)?;
        part.console.stage("comparing");
        match input.compare(denoised) {
            Ok(found) => rows.push(Row::new(mesh, &kind, &contender.name, (seconds, &input.before), found)),
            Err(error) => report.broken.push(failed(Some(&contender.name), error)),
        }
    }
    report.pairs.extend(Pair::new(mesh, request, &report.methods, &rows));
    report.rows.extend(rows);
    Ok(())
}
