//! The command `planish bench-quality`.

mod pairs;
mod report;
mod synthetic;

use crate::args::{BenchQualityArgs, PresetArg};
use crate::console::Console;
use crate::csv::{self, Csv};
use crate::failure::Failure;
use crate::{input, output};
use pairs::Pair;
use planish_files::input::Trust;
use planish_files::method;
use planish_geometry::denoise::{Denoiser, Parameter};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::metrics::{self, Triangles};
use planish_geometry::progress::Progress;
use planish_geometry::source::model::Model;
use report::{Broken, Measured, Report, Row};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(args: &BenchQualityArgs, console: &Console) -> Result<(), Failure> {
    if !args.noise.is_empty() {
        return synthetic::run(args, console);
    }
    let pairs = pairs::find(&args.folder, &args.pairs)?;
    let requested = if args.methods.is_empty() { &Denoiser::every()[..] } else { &args.methods };
    let denoisers = denoisers(args, requested)?;
    let inputs: Vec<&Path> = pairs.iter().flat_map(|pair| [pair.clean.as_path(), &pair.noisy]).collect();
    let csv = args.csv.as_ref().map(|path| Csv::open(path, &inputs, console)).transpose()?;

    let mut report = Report::new(&args.folder, denoisers);
    let complete = pairs.iter().enumerate().try_for_each(|(i, pair)| {
        let part = Part { console, first: i as f64 / pairs.len() as f64, size: 1.0 / pairs.len() as f64 };
        measure(pair, args.harm, &part, &mut report)
    });
    report.finish();
    // After an interruption, results so far are printed, but no table is written: it would look complete.
    if complete.is_ok() && write_table(csv, &report.rows, console)? == Stdout::Taken {
        return report.verdict();
    }
    let printed = console.report(&report, || report.text());
    complete.and(printed).and(report.verdict())
}

/// Whether stdout is left for the report, or has a table.
#[derive(PartialEq, Eq)]
enum Stdout {
    Free,
    Taken,
}

/// Writes a table where it was asked for.
fn write_table(csv: Option<Csv>, rows: &[impl Serialize], console: &Console) -> Result<Stdout, Failure> {
    let Some(csv) = csv else { return Ok(Stdout::Free) };
    let table = csv::table(rows)?;
    match csv {
        Csv::File(output) => output::write_all(vec![(output, table)]).map(|()| Stdout::Free),
        Csv::Stdout => {
            console.print_bytes(&table)?;
            Ok(Stdout::Taken)
        }
    }
}

/// Returns methods with the settings that were asked for.
fn denoisers(args: &BenchQualityArgs, requested: &[Denoiser]) -> Result<Vec<Denoiser>, Failure> {
    let mut used = vec![false; args.set.len()];
    let mut all = Vec::new();
    for method in requested {
        let mut denoiser = match args.preset {
            PresetArg::Default => method.clone(),
            PresetArg::Paper => method.paper().unwrap_or_else(|| method.clone()),
        };
        for ((name, value), used) in args.set.iter().zip(&mut used) {
            if let Some(parameter) = parameter(&denoiser, name) {
                let refused = |e| Failure::Input(format!("--set: {e}"));
                denoiser.set_parameter(parameter, value.clone()).map_err(refused)?;
                *used = true;
            }
        }
        all.push(method::prepare(denoiser, &args.folder)?);
    }
    match args.set.iter().zip(used).find(|(_, used)| !used) {
        Some(((name, _), _)) => Err(Failure::Input(format!("--set {name}: none of the methods has this setting"))),
        None => Ok(all),
    }
}

/// Returns the parameter of a method that has this name in its JSON, in the JSON of its vertex update, or on the command line.
fn parameter(denoiser: &Denoiser, name: &str) -> Option<&'static Parameter> {
    let at = |pointer: String| denoiser.parameters().find(|parameter| parameter.pointer == pointer);
    at(format!("/{name}")).or_else(|| at(format!("/vertex_update/{name}"))).or_else(|| denoiser.parameter(name))
}

/// Runs every method on the noisy mesh of a pair, and with `harm` on the clean mesh as well. A mesh that cannot be used is listed
/// in the report.
fn measure(pair: &Pair, harm: bool, part: &Part<'_>, report: &mut Report) -> Result<(), Failure> {
    let broken = |method: Option<&Denoiser>, error: String| Broken {
        pair: pair.name.clone(),
        method: method.map(Denoiser::name),
        error,
    };
    let read = || -> Result<_, Failure> {
        let clean_model =
            if harm { Some(super::model(&pair.clean, Welding::Exact, Trust::Folder, part.console)?) } else { None };
        let clean = match &clean_model {
            Some(model) => Triangles::from(model.data()),
            None => Triangles::from(input::source(&pair.clean, Trust::Folder)?.data()),
        };
        let model = super::model(&pair.noisy, Welding::Exact, Trust::Folder, part.console)?;
        let noisy = Triangles::from(model.data());
        let before = metrics::compare(&clean, &noisy).map_err(|e| Failure::at(&pair.noisy, e))?;
        Ok((clean, clean_model, model, noisy, before))
    };
    let (clean, clean_model, model, noisy, before) = match read() {
        Ok(read) => read,
        Err(Failure::Interrupted) => return Err(Failure::Interrupted),
        Err(failure) => {
            report.broken.push(broken(None, failure.to_string()));
            return Ok(());
        }
    };
    report.pairs.push(Measured::new(pair, &before));
    for (k, denoiser) in report.methods.iter().enumerate() {
        let share = part.size / report.methods.len() as f64;
        let runs = if harm { 2.0 } else { 1.0 };
        let part = Part { console: part.console, first: part.first + k as f64 * share, size: share / runs };
        let (denoised, seconds) = timed(denoiser, &model, &part)?;
        if let Some(v) = denoised.iter().position(|p| !p.is_finite()) {
            report.broken.push(broken(Some(denoiser), format!("vertex {} went to infinity", v + 1)));
            continue;
        }
        let denoised_clean = match &clean_model {
            Some(model) => {
                let part = Part { first: part.first + part.size, ..part };
                Some(timed(denoiser, model, &part)?.0)
            }
            None => None,
        };
        part.console.stage("comparing");
        let harm =
            denoised_clean.map(|p| metrics::compare(&clean, &clean.clone().at(p)).map(|found| found.ea)).transpose();
        match (metrics::compare(&clean, &noisy.at(denoised)), harm) {
            (Ok(found), Ok(harm)) => {
                report.rows.push(Row::new(pair, denoiser, &before, found, seconds).with_harm(harm));
            }
            (Err(e), _) | (_, Err(e)) => report.broken.push(broken(Some(denoiser), e.to_string())),
        }
    }
    Ok(())
}

/// Returns the denoised positions of the source vertices (#v×3), and the seconds that the method takes.
fn timed(denoiser: &Denoiser, model: &Model, part: &Part<'_>) -> Result<(Vec<glam::DVec3>, f64), Failure> {
    part.console.stage(denoiser.name());
    part.done(0.0);
    let start = Instant::now();
    let denoised = denoiser.denoised(model.surface(), part)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok((model.weld().spread(&denoised), seconds))
}

/// Progress of one part of the work, as a fraction of all of it.
struct Part<'a> {
    console: &'a Console,
    /// Fraction of all work that is done when this part begins.
    first: f64,
    /// Fraction of all work that this part is.
    size: f64,
}

impl Progress for Part<'_> {
    fn done(&self, share: f64) {
        self.console.done(self.first + share * self.size);
    }
    fn cancelled(&self) -> bool {
        self.console.cancelled()
    }
}
