//! Options of `planish noise`, and the kinds of noise that `planish bench-quality` makes.

use super::values::{above_zero, in_unit_interval, named, not_negative, number, numbers};
use super::{TrustArgs, WeldArgs};
use crate::failure::Failure;
use clap::Args;
use glam::DVec3;
use planish_geometry::mesh::synthetic_noise::{Direction, NoiseSetting, SyntheticKind, SyntheticNoise};
use std::path::PathBuf;

/// Longest correlation, in edges: the time to make the noise grows with its square.
const LONGEST_CORRELATION: f64 = 100.0;

#[derive(Args, Debug)]
pub(crate) struct NoiseArgs {
    /// The clean mesh
    #[arg(value_name = "CLEAN")]
    pub(crate) input: PathBuf,
    /// Output file for the noisy mesh; `-` for stdout
    #[arg(short, long, value_name = "NOISY|-")]
    pub(crate) output: PathBuf,
    /// Output file for the clean counterpart of the noisy mesh, for kinds that make a mesh with vertices of its own
    #[arg(long, value_name = "CLEAN-OUT.obj")]
    pub(crate) clean: Option<PathBuf>,
    /// Kind of noise [default: white]
    #[arg(long, value_parser = named::<SyntheticKind>())]
    kind: Option<SyntheticKind>,
    #[command(flatten)]
    settings: NoiseSettingArgs,
    /// Move only this fraction of the vertices, 0 to 1; the same as --kind impulsive --share P
    #[arg(long, value_name = "P", conflicts_with_all = ["kind", "share"])]
    #[arg(allow_negative_numbers = true, value_parser = in_unit_interval)]
    impulsive: Option<f64>,
    /// Seed of the random numbers; the same seed gives the same noise
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    #[command(flatten)]
    pub(crate) welding: WeldArgs,
    #[command(flatten)]
    pub(crate) trust: TrustArgs,
}

/// Settings of the kinds of noise.
#[derive(Args, Debug)]
struct NoiseSettingArgs {
    /// Standard deviation of the noise, in mean edge lengths; needed without --kind [default: that of the kind]
    #[arg(long, value_name = "S", required_unless_present = "kind")]
    #[arg(allow_negative_numbers = true, value_parser = not_negative)]
    sigma: Option<f64>,
    /// Direction in which vertices move [default: normal]
    #[arg(long, value_parser = named::<Direction>())]
    direction: Option<Direction>,
    /// Fraction of the vertices that move, 0 to 1; with --kind partial, of the area [default: that of the kind]
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = in_unit_interval)]
    share: Option<f64>,
    /// Length of a spike, in mean edge lengths [default: 4]
    #[arg(long, value_name = "L", allow_negative_numbers = true, value_parser = not_negative)]
    length: Option<f64>,
    /// Distance over which the correlation of the noise falls to 1/e, in edges or pixels [default: 1, with --kind correlated 3]
    #[arg(long, value_name = "R", allow_negative_numbers = true, value_parser = correlation)]
    correlation: Option<f64>,
    /// Direction to the eye of the camera, in which noise grows, or to the noisy part [default: random]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction)]
    towards: Option<DVec3>,
    /// Distance of the eye from the centre of the mesh, in radii of the sphere around its bounding box [default: 2.5]
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = distance)]
    distance: Option<f64>,
    /// Width of a pixel at the centre of the mesh, or of a voxel, in mean edge lengths [default: 1]
    #[arg(long, value_name = "W", allow_negative_numbers = true, value_parser = above_zero)]
    step: Option<f64>,
}

impl NoiseArgs {
    /// Returns the noise that was asked for. Fails if its kind does not have a setting that was given.
    pub(crate) fn noise(&self) -> Result<SyntheticNoise, Failure> {
        let short = self.impulsive.map(|_| SyntheticKind::Impulsive);
        let kind = self.kind.or(short).unwrap_or_default();
        let mut noise = SyntheticNoise::of_kind(kind, self.seed);
        let given = &self.settings;
        take(&mut noise.sigma, given.sigma, kind, NoiseSetting::Sigma)?;
        take(&mut noise.direction, given.direction, kind, NoiseSetting::Direction)?;
        take(&mut noise.share, self.impulsive.or(given.share), kind, NoiseSetting::Share)?;
        take(&mut noise.length, given.length, kind, NoiseSetting::Length)?;
        take(&mut noise.correlation, given.correlation, kind, NoiseSetting::Correlation)?;
        take(&mut noise.towards, given.towards.map(Some), kind, NoiseSetting::Towards)?;
        take(&mut noise.distance, given.distance, kind, NoiseSetting::Distance)?;
        take(&mut noise.step, given.step, kind, NoiseSetting::Step)?;
        if self.clean.is_some() && kind.keeps_connectivity() {
            let others = SyntheticKind::ALL.into_iter().filter(|kind| !kind.keeps_connectivity());
            let kinds: Vec<&str> = others.map(SyntheticKind::name).collect();
            let (kinds, kind) = (kinds.join(", "), kind.name());
            return Err(Failure::Input(format!(
                "--clean goes with --kind {kinds}; with {kind} the clean mesh is the input"
            )));
        }
        Ok(noise)
    }
}

/// Sets a field to the value that was given, if any. Fails if the kind does not have the setting.
fn take<T>(field: &mut T, given: Option<T>, kind: SyntheticKind, setting: NoiseSetting) -> Result<(), Failure> {
    let Some(value) = given else { return Ok(()) };
    if !kind.settings().contains(&setting) {
        let having = SyntheticKind::ALL.into_iter().filter(|kind| kind.settings().contains(&setting));
        let kinds: Vec<&str> = having.map(SyntheticKind::name).collect();
        let (setting, kind) = (setting.name(), kind.name());
        return Err(Failure::Input(format!("--{setting} goes with --kind {}, not {kind}", kinds.join(", "))));
    }
    *field = value;
    Ok(())
}

/// Noise that `bench-quality` makes: a kind with the deviation that was asked for, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoiseRequest {
    /// Kind of the noise; `None` for clean meshes.
    pub(crate) kind: Option<SyntheticKind>,
    /// Deviation in mean edge lengths; `None` for that of the kind.
    pub(crate) sigma: Option<f64>,
}

/// Word for meshes without noise among the kinds of `--noise`.
const CLEAN: &str = "clean";

impl NoiseRequest {
    /// Every kind of noise with its usual settings, and clean meshes without any.
    pub(crate) fn every() -> Vec<Self> {
        let kinds = SyntheticKind::ALL.into_iter().map(Some).chain([None]);
        kinds.map(|kind| Self { kind, sigma: None }).collect()
    }

    /// Name of the request, as it was spelt.
    pub(crate) fn name(&self) -> String {
        let kind = self.kind.map_or(CLEAN, SyntheticKind::name);
        self.sigma.map_or_else(|| kind.to_owned(), |sigma| format!("{kind}:{sigma}"))
    }

    /// Noise with the usual settings of the kind; `None` for clean meshes.
    pub(crate) fn noise(&self, seed: u64) -> Option<SyntheticNoise> {
        let mut noise = SyntheticNoise::of_kind(self.kind?, seed);
        noise.sigma = self.sigma.unwrap_or(noise.sigma);
        Some(noise)
    }
}

/// Parses `all`, `clean`, or KIND or KIND:SIGMA.
pub(super) fn noise_requests(text: &str) -> Result<Vec<NoiseRequest>, String> {
    if text == "all" {
        return Ok(NoiseRequest::every());
    }
    let (word, sigma) = text.split_once(':').map_or((text, None), |(word, sigma)| (word, Some(sigma)));
    let unknown = |e: &dyn std::fmt::Display| format!("{e}, {CLEAN}, all");
    let kind = if word == CLEAN { None } else { Some(word.parse::<SyntheticKind>().map_err(|e| unknown(&e))?) };
    let sigma = sigma.map(not_negative).transpose()?;
    if sigma.is_some() && !kind.is_some_and(|kind| kind.settings().contains(&NoiseSetting::Sigma)) {
        return Err(format!("{word} has no standard deviation"));
    }
    Ok(vec![NoiseRequest { kind, sigma }])
}

/// Parses `--correlation`.
fn correlation(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=LONGEST_CORRELATION).contains(&x), "not a number between 0 and 100")
}

/// Parses `--distance`, in radii.
fn distance(text: &str) -> Result<f64, String> {
    above_zero(text)?;
    let rule = "not a number of at least 1.1; nearer than that the eye is almost inside of the mesh";
    number(text, |x| x >= SyntheticNoise::NEAREST, rule)
}

/// Parses `--towards`.
fn direction(text: &str) -> Result<DVec3, String> {
    let rule = "a direction is three numbers with commas between them, not all of them 0";
    let parsed = numbers(text).and_then(|all| <[f64; 3]>::try_from(all).ok()).map(DVec3::from);
    parsed.filter(|v| v.try_normalize().is_some()).ok_or_else(|| rule.to_owned())
}
