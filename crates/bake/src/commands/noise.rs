//! The command `planish noise`.

use super::{measure, one_line};
use crate::args::NoiseArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use crate::output::{self, Output};
use glam::DVec3;
use planish_files::mesh_output;
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::synthetic_noise::{self, Disturbed, NoiseSetting, Remeshed, SyntheticKind, SyntheticNoise};
use planish_geometry::progress::Progress as _;
use planish_geometry::source::model::Model;
use planish_geometry::source::{Arrays, MeshData, Source};
use serde::Serialize;
use serde_json::{Map, Value};
use std::borrow::Cow;

/// Report of the command.
#[derive(Serialize)]
struct Added {
    output: String,
    /// File of the clean counterpart.
    #[serde(skip_serializing_if = "Option::is_none")]
    clean: Option<String>,
    kind: SyntheticKind,
    /// Settings that the kind has.
    settings: Map<String, Value>,
    seed: u64,
    vertices: usize,
    moved_vertices: usize,
    mean_edge: f64,
    /// Standard deviation that was asked for; `None` for a kind that has none.
    sigma: Option<f64>,
    rms_displacement: f64,
    /// Largest distance between a noisy position and the one that the file holds, model units.
    rounding: f64,
}

pub(crate) fn run(args: &NoiseArgs, console: &Console) -> Result<(), Failure> {
    let noise = args.noise()?;
    let output = Output::open(&args.output, &[&args.input])?;
    let clean_output = args.clean.as_ref().map(|path| Output::open(path, &[&args.input])).transpose()?;
    console.reserve_stdout([&output].into_iter().chain(&clean_output))?;
    if args.clean.as_ref() == Some(&args.output) {
        return Err(Failure::at(&args.output, "cannot be both the noisy mesh and --clean"));
    }
    let model = super::model(&args.input, args.welding.weld, args.trust.rule(), console)?;
    console.stage("noise");
    let made = NoisyMesh::new(&model, &noise).map_err(|e| Failure::at(&args.input, e))?;
    console.check()?;
    console.stage("writing");
    let file = mesh_output::write(&args.output, &made.source, &made.positions, None)?;
    let mean_edge = model.surface().mean_edge();
    mesh_output::warnings(&args.output, &args.input, &made.source, &file, mean_edge)
        .iter()
        .for_each(|w| console.warn(w));
    let report = Added::new(args, &noise, &model, &made, file.rounding);
    let clean_path = args.clean.as_deref().unwrap_or(&args.output);
    let written = |clean: &Source| mesh_output::write(clean_path, clean, clean.data().positions(), None);
    let clean = clean_output.zip(made.clean.as_ref().map(written).transpose()?.map(|file| file.bytes));
    output::write_all([(output, file.bytes)].into_iter().chain(clean).collect())?;
    console.report(&report, || report.text())
}

/// A mesh with noise.
pub(super) struct NoisyMesh<'a> {
    /// Mesh whose positions are replaced: the clean mesh, if its connectivity is kept.
    pub(super) source: Cow<'a, Source>,
    /// Positions with noise. #v×3, model units
    pub(super) positions: Vec<DVec3>,
    /// Clean mesh with the same connectivity; `None` if that is the mesh that the noise was made from.
    pub(super) clean: Option<Source>,
    /// Lengths of the displacements of the vertices, model units. #V
    lengths: Vec<f64>,
}

/// Reasons why there is no noisy mesh, as texts for people.
#[derive(Debug)]
pub(super) enum Refused {
    /// The kind of noise does not go with the mesh, as voxels do not with an open one.
    Inapplicable(String),
    /// Something is wrong with the mesh.
    Broken(String),
}

impl Refused {
    pub(super) fn broken(error: impl std::fmt::Display) -> Self {
        Self::Broken(error.to_string())
    }
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Self::Inapplicable(text) | Self::Broken(text)) = self;
        f.write_str(text)
    }
}

impl<'a> NoisyMesh<'a> {
    /// Adds noise to a mesh.
    pub(super) fn new(model: &'a Model, noise: &SyntheticNoise) -> Result<Self, Refused> {
        let disturbed = synthetic_noise::disturb(model.surface(), noise);
        match disturbed.map_err(|e| Refused::Inapplicable(e.to_string()))? {
            Disturbed::Moved(displacements) => {
                let noisy: Vec<_> =
                    model.surface().positions().iter().zip(&displacements).map(|(p, d)| *p + *d).collect();
                if let Some(v) = noisy.iter().position(|p| !p.is_finite()) {
                    let place = input::vertex_place(model.source(), model.weld().first()[v]);
                    return Err(Refused::Broken(format!("{place}the noise moves this vertex to infinity")));
                }
                Ok(Self {
                    source: Cow::Borrowed(model.source()),
                    positions: model.weld().spread(&noisy),
                    clean: None,
                    lengths: displacements.iter().map(|d| d.length()).collect(),
                })
            }
            Disturbed::Remeshed(pair) => {
                let Remeshed { clean, noisy } = *pair;
                let pairs = clean.positions().iter().zip(noisy.positions());
                let lengths = pairs.map(|(p, q)| p.distance(*q)).collect();
                let (source, clean) = (source(&noisy)?, Some(source(&clean)?));
                let positions = source.data().positions().to_vec();
                Ok(Self { source: Cow::Owned(source), positions, clean, lengths })
            }
        }
    }

    /// Reads the mesh again as it would be written in its own format. Rounded vertices that meet are welded then, as they would be
    /// for everybody.
    pub(super) fn read_again(&self) -> Result<Source, Refused> {
        let format = self.source.format();
        let written = self.source.written_as(format, &self.positions, None);
        Source::parse(written.bytes, Some(format)).map_err(Refused::broken)
    }
}

/// Returns a surface as a mesh of its own.
fn source(surface: &Surface) -> Result<Source, Refused> {
    let (positions, faces) = (surface.positions().to_vec(), surface.topology().faces().clone());
    let data = MeshData::try_from(Arrays { positions, faces, ..Arrays::default() });
    Ok(data.map_err(Refused::broken)?.into())
}

impl Added {
    fn new(args: &NoiseArgs, noise: &SyntheticNoise, model: &Model, made: &NoisyMesh, rounding: f64) -> Self {
        let moved_vertices = made.lengths.iter().filter(|length| **length > 0.0).count();
        let squares = made.lengths.iter().map(|length| length * length).sum::<f64>();
        Self {
            output: args.output.display().to_string(),
            clean: args.clean.as_ref().map(|path| path.display().to_string()),
            kind: noise.kind,
            settings: noise.to_json(),
            seed: noise.seed,
            vertices: made.lengths.len(),
            moved_vertices,
            mean_edge: model.surface().mean_edge(),
            sigma: noise.kind.settings().contains(&NoiseSetting::Sigma).then_some(noise.sigma),
            rounding,
            rms_displacement: (squares / moved_vertices.max(1) as f64).sqrt(),
        }
    }

    fn text(&self) -> String {
        let Self { output, clean, kind, vertices, moved_vertices, mean_edge, rms_displacement, .. } = self;
        let rms = rms_displacement / mean_edge;
        let clean = clean.as_ref().map(|clean| format!(" and {}", one_line(clean))).unwrap_or_default();
        let output = one_line(output);
        format!(
            "wrote {output}{clean}\n  {} noise: {moved_vertices} of {vertices} vertices moved, rms {rms:.4} mean edge lengths of {}\n",
            kind.name(),
            measure(*mean_edge)
        )
    }
}
