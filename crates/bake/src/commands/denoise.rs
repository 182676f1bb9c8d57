//! The command `planish denoise`.

use crate::args::{DenoiseArgs, MethodArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use planish_files::denoise_mesh::{self, DenoiseReport, ReportedHeights, WeldedMesh};
use planish_files::input::Trust;
use planish_files::text::{self, one_line, shown};
use planish_files::{mesh_output, method};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::progress::Progress;
use planish_geometry::source::flaws::{Flaw, flaws};
use planish_geometry::source::format::Format;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::Model;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Report of the command.
#[derive(Serialize)]
pub(super) struct Denoised {
    output: String,
    #[serde(flatten)]
    figures: DenoiseReport,
    /// Largest distance between a denoised position and the one that the file holds, model units.
    rounding: f64,
    /// What the input has and the output does not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lost: Vec<String>,
}

pub(crate) fn run(args: &DenoiseArgs, console: &Console) -> Result<(), Failure> {
    let output = Request::of(args).open()?;
    console.reserve_stdout([&output])?;
    let (report, warnings) = Request::of(args).run(output, console)?;
    warnings.iter().for_each(|w| console.warn(w));
    console.report(&report, || text(&report))
}

/// A mesh to denoise, and where the result goes.
pub(super) struct Request<'a> {
    pub(super) input: &'a Path,
    pub(super) output: &'a Path,
    pub(super) method: &'a MethodArgs,
    pub(super) welding: Welding,
    /// Whether the normals of the file follow the new shape.
    pub(super) update_normals: bool,
    pub(super) trust: Trust,
}

impl<'a> Request<'a> {
    fn of(args: &'a DenoiseArgs) -> Self {
        Self {
            input: &args.input,
            output: &args.output,
            method: &args.method,
            welding: args.welding.weld,
            update_normals: args.update_normals,
            trust: args.trust.rule(),
        }
    }

    /// Checks before any work is done that the result can be written.
    pub(super) fn open(&self) -> Result<Output, Failure> {
        let inputs: Vec<&Path> = [self.input].into_iter().chain(self.method.masks().map(PathBuf::as_path)).collect();
        Output::open(self.output, &inputs)
    }

    /// Denoises the mesh and writes it to the output, which [`Self::open`] gave. Returns the report and warnings, one line each.
    pub(super) fn run(&self, output: Output, progress: &dyn Progress) -> Result<(Denoised, Vec<String>), Failure> {
        let Self { input, update_normals, .. } = *self;
        let model = super::model(input, self.welding, self.trust, progress)?;
        let concern = |flaw: &Flaw| flaw.concerns_denoising().then(|| format!("{}: {flaw}", shown(input)));
        let mut warnings: Vec<String> = flaws(&model).iter().filter_map(concern).collect();
        let mut method = self.method.denoising(model.data())?;
        method.denoiser = method::prepare(method.denoiser, input)?;
        let mesh = WeldedMesh { surface: model.surface(), weld: model.weld(), faces: model.data().faces().len() };
        let denoised = denoise_mesh::denoise(mesh, method, progress).map_err(|e| e.at(input, model.source()))?;
        progress.stage("writing");
        let normals = update_normals.then(|| model.updated_file_normals(&denoised.positions));
        let source = model.source();
        let positions = model.weld().spread(&denoised.positions);
        let file = mesh_output::write(self.output, source, &positions, normals.as_deref())?;
        progress.check()?;
        let written = output.write(&file.bytes)?.display().to_string();
        let notes = source.file().map_or(&[][..], MeshFile::notes);
        warnings.extend(notes.iter().map(|note| format!("{}: {note}", shown(input))));
        warnings.extend(mesh_output::warnings(self.output, input, source, &file, denoised.report.mean_edge));
        warnings.extend(denoised.report.limits.as_ref().and_then(text::volume_not_restored));
        warnings.extend(self.stale_normals(&model));
        let report = Denoised { output: written, figures: denoised.report, rounding: file.rounding, lost: file.lost };
        Ok((report, warnings))
    }

    /// Warns if normals of the file should have been updated, or cannot be.
    fn stale_normals(&self, model: &Model) -> Option<String> {
        let normals = if model.source().format() == Format::Obj { "`vn` lines" } else { "normals of the vertices" };
        match (model.data().normals().is_empty(), self.update_normals) {
            (true, true) => {
                let input = shown(self.input);
                Some(format!("{input}: --update-normals has no effect, because there are no {normals}"))
            }
            (false, false) => {
                Some(format!("the {normals} are still those of the noisy mesh; use --update-normals to update them"))
            }
            _ => None,
        }
    }
}

/// Formats the report for people.
fn text(report: &Denoised) -> String {
    let DenoiseReport { mean_edge, mean_displacement, max_displacement, vertices, .. } = &report.figures;
    let chosen = report.figures.choice.as_ref().map(|choice| format!("  auto: {choice}\n")).unwrap_or_default();
    let mut out = format!(
        "wrote {}\n{chosen}  {vertices} vertices, moved by {:.3} mean edge lengths on average, {:.3} at most\n",
        one_line(&report.output),
        mean_displacement / mean_edge,
        max_displacement / mean_edge
    );
    if let Some(ReportedHeights { normals, loss }) = &report.figures.heights {
        let _ = writeln!(out, "  along normals ({}): {loss}", text::along(*normals));
    }
    if let Some(limits) = &report.figures.limits {
        let _ = writeln!(out, "  limits: {}", text::limits(limits));
    }
    out
}
