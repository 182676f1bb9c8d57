//! The command `planish denoise`.

use crate::args::DenoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::Output;
use planish_files::text::{self, one_line, shown};
use planish_files::{mesh_output, method};
use planish_geometry::denoise::limits::Outcome;
use planish_geometry::denoise::{Denoiser, Denoising, DenoisingError, Moved, NormalField, auto};
use planish_geometry::map::manifest::HeightsLoss;
use planish_geometry::progress::Progress as _;
use planish_geometry::source::flaws::flaws;
use planish_geometry::source::format::Format;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Report of the command.
#[derive(Serialize)]
struct Denoised {
    output: String,
    method: Denoising,
    /// Noise that the method `auto` measured, and the candidates that it chose.
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<auto::DenoiseChoice>,
    vertices: usize,
    faces: usize,
    mean_edge: f64,
    mean_displacement: f64,
    max_displacement: f64,
    /// Loss of heights; only with `--motion along-normal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    heights: Option<Heights>,
    #[serde(skip_serializing_if = "Option::is_none")]
    limits: Option<Outcome>,
    /// Largest distance between a denoised position and the one that the file holds, model units.
    rounding: f64,
    /// What the input has and the output does not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lost: Vec<String>,
}

/// Difference between the surface that heights can express and the free result.
#[derive(Serialize)]
struct Heights {
    normals: NormalField,
    #[serde(flatten)]
    loss: HeightsLoss,
}

pub(crate) fn run(args: &DenoiseArgs, console: &Console) -> Result<(), Failure> {
    let inputs: Vec<&Path> = [&args.input].into_iter().chain(args.method.masks()).map(PathBuf::as_path).collect();
    let output = Output::open(&args.output, &inputs)?;
    console.reserve_stdout([&output])?;
    let model = super::model(&args.input, args.welding.weld, args.trust.rule(), console)?;
    let surface = model.surface();
    for flaw in flaws(&model).iter().filter(|flaw| flaw.concerns_denoising()) {
        console.warn(&format!("{}: {flaw}", shown(&args.input)));
    }
    let mut method = args.method.denoising(model.source(), &args.input)?;
    method.denoiser = method::prepare(method.denoiser, &args.input)?;
    let moved = method.run(surface, model.weld(), method.output(), console).map_err(|e| match e {
        DenoisingError::Limits(e) => Failure::limits(&e, &args.input),
        DenoisingError::Cancelled(_) => Failure::Interrupted,
    })?;
    let Moved { deltas, along, limits, choice } = moved;
    let denoised = surface.moved_by(&deltas);
    if let Some(v) = denoised.iter().position(|p| !p.is_finite()) {
        return Err(went_to_infinity(&args.input, &model, v, &method.denoiser));
    }
    console.stage("writing");
    let normals = args.update_normals.then(|| model.updated_file_normals(&denoised));
    let source = model.source();
    let file = mesh_output::write(&args.output, source, &model.weld().spread(&denoised), normals.as_deref())?;
    console.check()?;
    let written = output.write(&file.bytes)?;
    let lengths = || deltas.iter().map(|d| d.length());
    let report = Denoised {
        output: written.display().to_string(),
        method,
        choice,
        vertices: model.data().positions().len(),
        faces: model.data().faces().len(),
        mean_edge: surface.mean_edge(),
        mean_displacement: lengths().sum::<f64>() / deltas.len() as f64,
        max_displacement: lengths().fold(0.0, f64::max),
        heights: along.map(|(along, normals)| Heights { normals, loss: along.residual.into() }),
        limits,
        rounding: file.rounding,
        lost: file.lost.clone(),
    };
    let notes = source.file().map_or(&[][..], MeshFile::notes);
    notes.iter().for_each(|note| console.warn(&format!("{}: {note}", shown(&args.input))));
    mesh_output::warnings(&args.output, &args.input, source, &file, surface.mean_edge())
        .iter()
        .for_each(|w| console.warn(w));
    if let Some(warning) = limits.as_ref().and_then(text::volume_not_restored) {
        console.warn(&warning);
    }
    let normals_of_file = if source.format() == Format::Obj { "`vn` lines" } else { "normals of the vertices" };
    if model.data().normals().is_empty() && args.update_normals {
        let input = shown(&args.input);
        console.warn(&format!("{input}: --update-normals has no effect, because there are no {normals_of_file}"));
    } else if !model.data().normals().is_empty() && !args.update_normals {
        console.warn(&format!(
            "the {normals_of_file} are still those of the noisy mesh; use --update-normals to update them"
        ));
    }
    console.report(&report, || text(&report))
}

/// Says which vertex a method moved to infinity, and which of its settings would help.
fn went_to_infinity(input: &Path, model: &Model, vertex: usize, denoiser: &Denoiser) -> Failure {
    let place = input::vertex_place(model.source(), model.weld().first()[vertex]);
    let has = |option: &&&str| denoiser.options().any(|parameter| parameter.name == **option);
    let smaller: Vec<String> = ["step", "iterations"].iter().filter(has).map(|o| format!("a smaller --{o}")).collect();
    let advice = if smaller.is_empty() { String::new() } else { format!(": use {}", smaller.join(" or ")) };
    Failure::Internal(format!("{}: {place}{} moved this vertex to infinity{advice}", shown(input), denoiser.name()))
}

/// Formats the report for people.
fn text(report: &Denoised) -> String {
    let Denoised { output, mean_edge, mean_displacement, max_displacement, vertices, .. } = report;
    let chosen = report.choice.as_ref().map(|choice| format!("  auto: {choice}\n")).unwrap_or_default();
    let mut out = format!(
        "wrote {}\n{chosen}  {vertices} vertices, moved by {:.3} mean edge lengths on average, {:.3} at most\n",
        one_line(output),
        mean_displacement / mean_edge,
        max_displacement / mean_edge
    );
    if let Some(Heights { normals, loss }) = &report.heights {
        let _ = writeln!(out, "  along normals ({}): {loss}", text::along(*normals));
    }
    if let Some(limits) = &report.limits {
        let _ = writeln!(out, "  limits: {}", text::limits(limits));
    }
    out
}
