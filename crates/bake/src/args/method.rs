//! Options of the denoising methods.
//!
//! A method is its name and the settings of the library, as they stand in the manifest; each option names the setting
//! that it replaces, and so goes with the methods that have it.

use super::limits::LimitArgs;
use super::values::{
    BoundaryArg, FoldOversArg, KindArg, MotionArg, NeighboursArg, PriorArg, SchemeArg, SolverArg, VertexUpdateArg,
    WeightsArg, above_zero, candidate, in_unit_interval, inflation, not_negative, share_above_zero, welding,
};
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use planish_geometry::denoise::auto::Candidate;
use planish_geometry::denoise::{
    Boundary, Denoiser, Denoising, EdgeWeights, FoldOvers, Kind, Motion, Neighbours, Prior, Scheme, Solver,
    VertexScheme,
};
use planish_geometry::source::MeshData;
use planish_geometry::weld::Welding;
use serde::Serialize;
use serde_json::Value;
use std::path::PathBuf;

/// Methods by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodArg {
    /// Steps towards the mean of the neighbours
    Laplacian,
    /// The same without shrinking: each step is followed by one away from the mean
    Taubin,
    /// The same, pushed back by how far vertices and their neighbours went (Vollmer 1999)
    Hc,
    /// One long stable step of diffusion or mean curvature flow (Desbrun 1999)
    Implicit,
    /// Bilateral filter of the vertices, keeps edges (Fleishman 2003)
    Bilateral,
    /// Normals averaged over faces that look the same way (Sun 2007)
    Sun,
    /// Bilateral filter of the face normals (Zheng 2011)
    BilateralNormals,
    /// The same guided by consistent patches, for corners and heavy noise (Zhang 2015)
    GuidedNormals,
    /// As few edges as possible that are not flat, for parts made of planes (He & Schaefer 2013)
    L0,
    /// Total generalised variation of the face normals: sharp edges and curved faces (Liu 2021)
    TgvNormals,
    /// The most probable surface, given the noise, where normals turn evenly but for creases
    Map,
    /// Measures the noise, tries several priors and smoothings, and mixes the best; leaves clean meshes alone
    #[default]
    Auto,
}

/// Where settings start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetArg {
    /// What works on most meshes
    #[default]
    Default,
    /// What the authors of the method used
    Paper,
}

impl MethodArg {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
    /// The method with its default settings.
    pub(crate) fn denoiser(self) -> Result<Denoiser, Failure> {
        let name = self.name();
        let found = Denoiser::every().into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| Failure::Internal(format!("the library has no method {name}")))
    }
}

/// How to denoise.
#[derive(Args, Debug)]
#[command(next_help_heading = "Denoising")]
pub(crate) struct MethodArgs {
    /// Denoising method
    #[arg(long, value_enum, default_value_t)]
    method: MethodArg,
    /// Settings that are not given: paper for those of the method's authors, where they differ
    #[arg(long, value_enum, default_value_t)]
    preset: PresetArg,
    /// Number of steps; of pairs of steps with taubin, of steps of the normals with the filters of normals, of rounds with map
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=100_000), allow_negative_numbers = true)]
    iterations: Option<u32>,
    /// laplacian, taubin: share of the way to the mean of the neighbours that a step goes, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "S", value_parser = in_unit_interval, allow_negative_numbers = true)]
    step: Option<f64>,
    /// taubin: the step away from the mean that follows each step, −1.5 to 0 [default: -0.53]
    #[arg(long, value_name = "MU", value_parser = inflation, allow_negative_numbers = true)]
    inflate: Option<f64>,
    /// implicit: how long a step is, in whole steps of the laplacian [default: 0.5]
    #[arg(long, value_name = "T", value_parser = not_negative, allow_negative_numbers = true)]
    time: Option<f64>,
    /// implicit: how the linear system is solved [default: iterative]
    #[arg(long, value_enum)]
    solver: Option<SolverArg>,
    /// laplacian, taubin, implicit: weights of the neighbours [default: uniform]
    #[arg(long, value_enum)]
    weights: Option<WeightsArg>,
    /// hc: share of the input in the place that vertices are pushed back to [default: 0]; l0: weight against folds
    /// [default: 0.1]
    #[arg(long, value_name = "A", value_parser = in_unit_interval, allow_negative_numbers = true)]
    alpha: Option<f64>,
    /// hc: share of a vertex's own way in how far it is pushed back, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "B", value_parser = in_unit_interval, allow_negative_numbers = true)]
    beta: Option<f64>,
    /// sun: cosine of the angle beyond which neighbours do not count, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "T", value_parser = in_unit_interval, allow_negative_numbers = true)]
    threshold: Option<f64>,
    /// bilateral-normals: step by step, or as the solution of one linear system [default: local]
    #[arg(long, value_enum)]
    scheme: Option<SchemeArg>,
    /// bilateral-normals --scheme global: how near normals stay to the input, 0 to 1 [default: 0.01]
    #[arg(long, value_name = "L", value_parser = share_above_zero, allow_negative_numbers = true)]
    smoothness: Option<f64>,
    /// bilateral-normals: which faces are averaged [default: vertex]
    #[arg(long, value_enum)]
    neighbours: Option<NeighboursArg>,
    /// guided-normals: how far off faces are averaged, in mean distances of neighbouring faces [default: 2]
    #[arg(long, value_name = "R", value_parser = above_zero, allow_negative_numbers = true)]
    radius: Option<f64>,
    /// bilateral-normals, guided-normals: reach of the filter, in mean distances of neighbouring faces [default: 1]
    #[arg(long, value_name = "S", value_parser = above_zero, allow_negative_numbers = true)]
    sigma_spatial: Option<f64>,
    /// bilateral-normals, guided-normals: how far unit normals may differ and still be averaged [default: 0.35]
    #[arg(long, value_name = "S", value_parser = above_zero, allow_negative_numbers = true)]
    sigma_range: Option<f64>,
    /// l0: more than 1 makes more edges flat, less makes fewer [default: 1]
    #[arg(long, value_name = "X", value_parser = not_negative, allow_negative_numbers = true)]
    sparsity: Option<f64>,
    /// tgv-normals: how near normals stay to the input, against how noisy they are [default: 0.7]
    #[arg(long, value_name = "W", value_parser = above_zero, allow_negative_numbers = true)]
    fidelity: Option<f64>,
    /// tgv-normals: weight of curvature that changes against normals that jump [default: 0.4]
    #[arg(long, value_name = "W", value_parser = above_zero, allow_negative_numbers = true)]
    second_order: Option<f64>,
    /// map, auto: standard deviation of the noise in mean edge lengths [default: measured on the mesh]
    #[arg(long, value_name = "S", value_parser = not_negative, allow_negative_numbers = true)]
    noise: Option<f64>,
    /// map, auto: the same across the normals, at most; as much as along them where noise goes in all directions [default:
    /// measured on the mesh]
    #[arg(long, value_name = "S", value_parser = not_negative, allow_negative_numbers = true)]
    noise_across: Option<f64>,
    /// auto: what the noise is like [default: measured on the mesh]
    #[arg(long, value_enum)]
    noise_kind: Option<KindArg>,
    /// auto: what is tried: flat, sharp, creases, mixed, detail, smooth (priors of map), linear-faint, linear-light, linear,
    /// linear-strong, stay; several with commas between them [default: all that suit the noise]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = candidate)]
    candidates: Option<Vec<Candidate>>,
    /// map: what surfaces are taken to be like [default: creases]
    #[arg(long, value_enum)]
    prior: Option<PriorArg>,
    /// map: weight of the prior against the data [default: as --prior has it]
    #[arg(long, value_name = "W", value_parser = above_zero, allow_negative_numbers = true)]
    strength: Option<f64>,
    /// Filters of normals: how vertices follow [default: descent]
    #[arg(long, value_enum)]
    vertex_update: Option<VertexUpdateArg>,
    /// Filters of normals: steps of the vertices with --vertex-update descent [default: 10, sun: 50, tgv-normals: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=100_000), allow_negative_numbers = true)]
    vertex_iterations: Option<u32>,
    /// Filters of normals: pull of the vertices to the input, in pulls of a face around [default: 0.05, paper: 0]
    #[arg(long, value_name = "W", value_parser = not_negative, allow_negative_numbers = true)]
    closeness: Option<f64>,
    /// map, auto and filters of normals: where vertices may go [default: free; bake --map scalar: along-normal]
    #[arg(long, value_enum)]
    motion: Option<MotionArg>,
    /// Filters of normals: what happens to steps that fold the surface over [default: prevent, paper: allow]
    #[arg(long, value_enum)]
    fold_overs: Option<FoldOversArg>,
    /// What happens at the rim of an open mesh [default: free; fixed with laplacian, taubin, hc, implicit, bilateral, sun and
    /// bilateral-normals]
    #[arg(long, value_enum)]
    boundary: Option<BoundaryArg>,
    #[command(flatten)]
    limits: LimitArgs,
    /// Which `v` lines are one vertex: exact (equal coordinates), none, or a distance in model units
    ///
    /// Exporters split vertices at UV seams; without welding the mesh would be cut open there.
    #[arg(long, value_name = "exact|none|EPS", default_value = "exact", allow_negative_numbers = true, value_parser = welding)]
    pub(crate) weld: Welding,
}

/// Options that say how to denoise, and so mean nothing where the denoised mesh is given.
pub(super) const METHOD_OPTIONS: [&str; 35] = [
    "method",
    "preset",
    "iterations",
    "step",
    "inflate",
    "time",
    "solver",
    "weights",
    "alpha",
    "beta",
    "threshold",
    "scheme",
    "smoothness",
    "neighbours",
    "radius",
    "sigma_spatial",
    "sigma_range",
    "sparsity",
    "fidelity",
    "second_order",
    "noise",
    "noise_across",
    "noise_kind",
    "candidates",
    "prior",
    "strength",
    "vertex_update",
    "vertex_iterations",
    "closeness",
    "motion",
    "fold_overs",
    "boundary",
    "fix",
    "max_displacement",
    "preserve_volume",
];

impl MethodArgs {
    /// The method, and its limits for a mesh.
    pub(crate) fn denoising(&self, mesh: &MeshData) -> Result<Denoising, Failure> {
        Ok(Denoising { denoiser: self.denoiser()?, limits: self.limits.limits(mesh)? })
    }

    /// Files that say which vertices stay.
    pub(crate) fn masks(&self) -> impl Iterator<Item = &PathBuf> {
        self.limits.masks()
    }

    fn denoiser(&self) -> Result<Denoiser, Failure> {
        let default = self.method.denoiser()?;
        let internal =
            || Failure::Internal(format!("the method {} has settings that it does not know", default.name()));
        let start = match self.preset {
            PresetArg::Default => default.clone(),
            PresetArg::Paper => {
                default.paper().ok_or_else(|| goes_with("--preset paper", |method| method.paper().is_some()))?
            }
        };
        let mut settings = json(&start);
        for (option, places, value) in self.given() {
            let slot = places.iter().find(|place| settings.pointer(place).is_some());
            let slot = slot.and_then(|place| settings.pointer_mut(place));
            let has_it = |method: &Denoiser| places.iter().any(|place| json(method).pointer(place).is_some());
            *slot.ok_or_else(|| goes_with(option, has_it))? = value;
        }
        serde_json::from_value(settings).map_err(|_| internal())
    }

    /// Options on the command line: name, where their setting may be, and value.
    fn given(&self) -> Vec<(&'static str, &'static [&'static str], Value)> {
        let number = |x: Option<f64>| x.map(Value::from);
        let count = |n: Option<u32>| n.map(Value::from);
        let all: [(_, &[_], _); 30] = [
            // First, for others change settings of it.
            ("--prior", &["/prior"], choice::<_, Prior>(self.prior)),
            ("--iterations", &["/iterations", "/prior/rounds"], count(self.iterations)),
            ("--step", &["/step"], number(self.step)),
            ("--inflate", &["/inflate"], number(self.inflate)),
            ("--time", &["/time"], number(self.time)),
            ("--solver", &["/solver"], choice::<_, Solver>(self.solver)),
            ("--weights", &["/weights"], choice::<_, EdgeWeights>(self.weights)),
            ("--alpha", &["/alpha"], number(self.alpha)),
            ("--beta", &["/beta"], number(self.beta)),
            ("--threshold", &["/threshold"], number(self.threshold)),
            ("--scheme", &["/scheme"], choice::<_, Scheme>(self.scheme)),
            ("--smoothness", &["/smoothness"], number(self.smoothness)),
            ("--neighbours", &["/neighbours"], choice::<_, Neighbours>(self.neighbours)),
            ("--radius", &["/radius"], number(self.radius)),
            ("--sigma-spatial", &["/sigma_spatial"], number(self.sigma_spatial)),
            ("--sigma-range", &["/sigma_range"], number(self.sigma_range)),
            ("--sparsity", &["/sparsity"], number(self.sparsity)),
            ("--fidelity", &["/fidelity"], number(self.fidelity)),
            ("--second-order", &["/second_order"], number(self.second_order)),
            ("--noise", &["/noise"], number(self.noise)),
            ("--noise-across", &["/noise_across"], number(self.noise_across)),
            ("--noise-kind", &["/kind"], choice::<_, Kind>(self.noise_kind)),
            ("--candidates", &["/candidates"], self.candidates.as_ref().map(json)),
            ("--strength", &["/prior/strength"], number(self.strength)),
            ("--vertex-update", &["/vertex_update/scheme"], choice::<_, VertexScheme>(self.vertex_update)),
            ("--vertex-iterations", &["/vertex_update/iterations"], count(self.vertex_iterations)),
            ("--closeness", &["/vertex_update/closeness"], number(self.closeness)),
            ("--motion", &["/motion", "/vertex_update/motion"], choice::<_, Motion>(self.motion)),
            ("--fold-overs", &["/vertex_update/fold_overs"], choice::<_, FoldOvers>(self.fold_overs)),
            ("--boundary", &["/boundary", "/vertex_update/boundary"], choice::<_, Boundary>(self.boundary)),
        ];
        all.into_iter().filter_map(|(option, places, value)| Some((option, places, value?))).collect()
    }
}

fn choice<A: Into<T>, T: Serialize>(choice: Option<A>) -> Option<Value> {
    choice.map(|choice| json(&choice.into()))
}

/// Settings are plain numbers and names, which always have a form in JSON.
fn json<T: Serialize>(settings: &T) -> Value {
    serde_json::to_value(settings).unwrap_or(Value::Null)
}

fn goes_with(option: &str, has_it: impl Fn(&Denoiser) -> bool) -> Failure {
    let every = Denoiser::every();
    let methods: Vec<&str> = every.iter().filter(|method| has_it(method)).map(Denoiser::name).collect();
    Failure::Input(format!("{option} goes with --method {}", methods.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_knows_every_method_of_the_library() {
        let names = MethodArg::value_variants().iter().map(|m| m.to_possible_value().unwrap().get_name().to_owned());
        let every = Denoiser::every();
        assert_eq!(names.collect::<Vec<_>>(), every.iter().map(Denoiser::name).collect::<Vec<_>>());
    }
}
