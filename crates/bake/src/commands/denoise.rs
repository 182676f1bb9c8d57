//! The command `planish denoise`.

use crate::args::{DenoiseArgs, MethodArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::heat_map;
use crate::output::{self, Output};
use planish_files::denoise_mesh::{self, DenoiseReport, ReportedHeights, WeldedMesh};
use planish_files::input::Trust;
use planish_files::text::{self, one_line, shown};
use planish_files::{mesh_output, method};
use planish_geometry::mesh::weld::Welding;
use planish_geometry::metrics::Triangles;
use planish_geometry::progress::Progress;
use planish_geometry::source::flaws::flaws;
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
    /// Heat map of the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_map: Option<String>,
    /// Contents of the input that the output has no place for, each in a few words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lost: Vec<String>,
}

pub(crate) fn run(args: &DenoiseArgs, console: &Console) -> Result<(), Failure> {
    let output = Request::of(args).open()?;
    let noise_map = args.noise_map.as_ref().map(|path| open_noise_map(path, args)).transpose()?;
    console.reserve_stdout([&output].into_iter().chain(&noise_map))?;
    let (report, warnings) = Request::of(args).run(output, noise_map, console)?;
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
        Output::open(self.output, &self.inputs())
    }

    /// Files that the command reads.
    fn inputs(&self) -> Vec<&'a Path> {
        [self.input].into_iter().chain(self.method.masks().map(PathBuf::as_path)).collect()
    }

    /// Denoises the mesh and writes it to the output, which [`Self::open`] gave, and a heat map of the noise if one is wanted. Returns the
    /// report and warnings, one line each.
    pub(super) fn run(
        &self,
        output: Output,
        noise_map: Option<Output>,
        progress: &dyn Progress,
    ) -> Result<(Denoised, Vec<String>), Failure> {
        let Self { input, update_normals, .. } = *self;
        let model = super::model(input, self.welding, self.trust, progress)?;
        let mut warnings: Vec<String> = flaws(&model).iter().map(|flaw| format!("{}: {flaw}", shown(input))).collect();
        let mut method = self.method.denoising(model.source(), input)?;
        method.denoiser = method::prepare(method.denoiser, input)?;
        let mesh = WeldedMesh { surface: model.surface(), weld: model.weld(), faces: model.data().faces().len() };
        let denoised = denoise_mesh::denoise(mesh, method, progress).map_err(|e| e.at(input, model.source()))?;
        progress.stage("writing");
        let normals = update_normals.then(|| model.updated_file_normals(&denoised.positions));
        let source = model.source();
        let positions = model.weld().spread_from(&denoised.positions);
        let mut file = mesh_output::pieces(self.output, source, &positions, normals.as_deref())?;
        progress.check()?;
        let shown_path = |output: &Output| output.path().display().to_string();
        let (written, noise_map_path) = (shown_path(&output), noise_map.as_ref().map(shown_path));
        let deviations = denoised.report.choice.as_ref().map(|choice| &choice.deviations[..]);
        let painted = noise_map.zip(deviations).map(|(map, deviations)| {
            let bytes = paint_noise(map.path(), &model, deviations);
            (map, vec![bytes.into()])
        });
        let bytes = std::mem::take(&mut file.bytes);
        output::write_all_in_pieces([(output, bytes)].into_iter().chain(painted).collect())?;
        let notes = source.file().map_or(&[][..], MeshFile::notes);
        warnings.extend(notes.iter().map(|note| format!("{}: {note}", shown(input))));
        warnings.extend(mesh_output::warnings(self.output, input, source, &file, denoised.report.mean_edge));
        warnings.extend(denoised.report.limits.as_ref().and_then(text::volume_not_restored));
        warnings.extend(self.stale_normals(&model));
        let figures = denoised.report;
        let (rounding, lost) = (file.rounding, file.lost);
        let report = Denoised { output: written, figures, rounding, noise_map: noise_map_path, lost };
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

/// Opens the file of `--noise-map`, which no other file of the command may be.
fn open_noise_map(path: &Path, args: &DenoiseArgs) -> Result<Output, Failure> {
    heat_map::extension(path, "--noise-map")?;
    if !args.method.measures_noise() {
        return Err(Failure::Input("--noise-map goes with --method auto".to_owned()));
    }
    if path == args.output || output::same_file(path, &args.output) {
        return Err(Failure::at(path, "is named for the denoised mesh and for --noise-map"));
    }
    Output::open(path, &Request::of(args).inputs())
}

/// Formats the input with the deviations of its noise (#V, model units) as colours.
fn paint_noise(path: &Path, model: &Model, deviations: &[f64]) -> Vec<u8> {
    let max = heat_map::percentile_99(deviations);
    let legend =
        format!("standard deviation of the noise: violet 0, teal {:.4e}, yellow {max:.4e} and more", max / 2.0);
    heat_map::paint(path, &Triangles::from(model.data()), &model.weld().spread(deviations), max, &legend)
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
