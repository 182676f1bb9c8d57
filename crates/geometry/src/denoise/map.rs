//! The most probable surface (maximum a posteriori, MAP), given noisy vertices and a prior on how normals turn.
//!
//! The prior says that the surface is curved evenly: the normal changes from face to face as a shape operator says, and the
//! shape operator itself changes little. Both terms are robust, so that a crease costs no more than it must. This is a
//! second-order total variation of the normals (compare Liu et al., Mesh total generalized variation for denoising, 2021),
//! but it is estimated in the positions themselves: there is no second stage in which vertices follow normals, and the data
//! term acts on positions.
//!
//! In mean edge lengths, with a symmetric 3×3 shape operator S_f for each face as a further unknown, the estimate minimises
//!
//! E(x, S) = Σᵥ (|xᵥ − pᵥ|² + k |(1 − N Nᵀ)(xᵥ − pᵥ)|²) / σ²\
//!   \+ Σₑ wₑ |nᵢ − nⱼ − ½ (Sᵢ + Sⱼ) (cᵢ − cⱼ)|² + Σₑ vₑ |Sᵢ − Sⱼ|² + 10⁻³ λ Σ_f |S_f|²\
//!   \+ τ min(1/σ², 5²) Σᵥ |(1 − N Nᵀ) (U x)ᵥ|²
//!
//! over vertices v with normals N, edges e between faces i and j with normals n and centroids c, faces f, and the umbrella
//! operator U.
//!
//! - The first line is the data term. Scanner noise, and the noise of the literature, acts along the normal. The tangential
//!   part of the data term is therefore weighted 1 + k times; k is estimated from the mesh.
//! - The second line is the prior, with a small weight on the shape operators that makes the system definite.
//! - The third line spreads the vertices evenly in the tangent plane.
//!
//! Each round takes the normals as linear in the positions (Gauss–Newton), computes the weights w and v from the last residuals
//! r (iteratively reweighted least squares: φ = (1 + |r|²/κ²)^−p), and solves for positions and shape operators together. κ
//! falls from 0.4 to the threshold of the settings, so that strong creases form first (graduated non-convexity).

mod edge_weights;
mod iterations;
mod linearised_normals;
mod normal_equations;
mod symmetric;

pub(super) use iterations::Problem;
pub(super) use linearised_normals::LinearisedNormals;

use super::bilaplacian::BoundaryConstraint;
use super::boundary::{BOUNDARY, Boundary};
use super::connectivity::Connectivity;
use super::method::{DenoiseMethod, MethodInfo};
use super::motion::{MOTION, Motion};
use super::noise_field::NoiseField;
use super::noise_level::{self, NoiseEstimate};
use super::parameters::{HUGE, Parameter, Preset, TINY};
use crate::mesh::locality::Localised;
use crate::mesh::surface::Surface;
use crate::named;
use crate::named::Named;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Map`](super::Denoiser::Map).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// σ, mean edge lengths; measured on the mesh where it is not given.
    pub noise: Option<f64>,
    /// Largest standard deviation of the tangential noise, mean edge lengths; measured if it is `None`.
    pub noise_across: Option<f64>,
    /// The prior.
    pub prior: Prior,
    /// Steps of conjugate gradients in each round, at most.
    pub steps: u32,
    /// Where vertices may go.
    pub motion: Motion,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

/// Prior: the shapes that are expected before the mesh is seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prior {
    /// p: how little a crease costs. 0 is quadratic, 0.5 grows with the angle, 1 with its logarithm.
    pub exponent: f64,
    /// λ: weight of the prior.
    pub strength: f64,
    /// The last κ: normals that turn by less, unit length, count as noise.
    pub threshold: f64,
    /// Weight of jumps of the shape operator against those of the normals.
    pub curvature: f64,
    /// τ: how much vertices spread tangentially.
    pub spread: f64,
    /// Rounds of reweighting.
    pub rounds: u32,
}

impl Prior {
    /// Flat parts with sharp creases.
    pub const FLAT: Self =
        Self { exponent: 0.75, strength: 1.5, threshold: 0.02, curvature: 10.0, spread: 1.0, rounds: 12 };
    /// Curved parts with sharp creases.
    pub const SHARP: Self = Self { strength: 1.0, threshold: 0.03, curvature: 3.0, ..Self::FLAT };
    /// Parts with creases that need not be sharp.
    pub const CREASES: Self = Self { exponent: 0.6, curvature: 3.0, ..Self::FLAT };
    /// Shapes with some creases.
    pub const MIXED: Self = Self { exponent: 0.5, strength: 2.0, ..Self::CREASES };
    /// Smooth shapes with detail.
    pub const DETAIL: Self =
        Self { exponent: 0.5, strength: 3.0, threshold: 0.05, curvature: 1.0, spread: 2.0, rounds: 4 };
    /// Smooth shapes.
    pub const SMOOTH: Self = Self { strength: 6.0, threshold: 0.1, rounds: 5, ..Self::DETAIL };
}

impl Default for Prior {
    /// Parts with creases, which is between the others.
    fn default() -> Self {
        Self::CREASES
    }
}

impl Default for Map {
    /// σ as measured, 40 steps a round; boundary vertices are held by their data like all others.
    fn default() -> Self {
        let (motion, boundary) = (Motion::Free, Boundary::Free);
        Self { noise: None, noise_across: None, prior: Prior::default(), steps: 40, motion, boundary }
    }
}

named! {
    /// A prior by its name, from flat to smooth.
    pub enum PriorName {
        /// Flat parts with sharp creases.
        Flat = "flat",
        /// Curved parts with sharp creases.
        Sharp = "sharp",
        /// Parts with creases that need not be sharp.
        Creases = "creases",
        /// Shapes with some creases.
        Mixed = "mixed",
        /// Smooth shapes with detail.
        Detail = "detail",
        /// Smooth shapes.
        Smooth = "smooth",
    }
}

impl PriorName {
    /// The prior of that name.
    pub fn prior(self) -> Prior {
        match self {
            Self::Flat => Prior::FLAT,
            Self::Sharp => Prior::SHARP,
            Self::Creases => Prior::CREASES,
            Self::Mixed => Prior::MIXED,
            Self::Detail => Prior::DETAIL,
            Self::Smooth => Prior::SMOOTH,
        }
    }
    /// The name of a prior, whatever its strength and rounds; none where it is not one of these.
    pub fn of(prior: &Prior) -> Option<Self> {
        let shape = |prior: Prior| Prior { strength: 0.0, rounds: 0, ..prior };
        Self::ALL.into_iter().find(|name| shape(name.prior()) == shape(*prior))
    }
}

/// Priors by name, for the table of parameters.
const PRIORS: Preset = Preset {
    words: <PriorName as Named>::WORDS,
    settings: |name| serde_json::to_value(name.parse::<PriorName>().ok()?.prior()).ok(),
    name: |prior| PriorName::of(&Prior::deserialize(prior).ok()?).map(PriorName::name),
};

/// Parameter of all methods to which the noise can be told.
pub(super) const NOISE: Parameter =
    Parameter::number("noise", "/noise", [0.0, HUGE], "standard deviation of the noise along the normals")
        .slider(1.0)
        .unit("mean edge lengths")
        .optional();

/// Parameter of all methods to which the tangential noise can be told.
pub(super) const NOISE_ACROSS: Parameter = Parameter::number(
    "noise-across",
    "/noise_across",
    [0.0, HUGE],
    "largest standard deviation of the noise within the surface (tangential)",
)
.label("across")
.slider(1.0)
.unit("mean edge lengths")
.optional();

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::preset("prior", "/prior", PRIORS, "what the surface is expected to be like"),
    NOISE,
    NOISE_ACROSS,
    Parameter::number(
        "strength",
        "/prior/strength",
        [0.0, HUGE],
        "weight of the prior against the data; more smooths more",
    )
    .slider(10.0),
    Parameter::count("iterations", "/prior/rounds", 30, "number of rounds of reweighting"),
    Parameter::number("exponent", "/prior/exponent", [0.0, 4.0], "how little a crease costs").internal(),
    Parameter::number(
        "threshold",
        "/prior/threshold",
        [TINY, 2.0],
        "difference of unit normals that still counts as noise",
    )
    .internal(),
    Parameter::number("curvature", "/prior/curvature", [0.0, HUGE], "cost of curvature that jumps").internal(),
    Parameter::number("spread", "/prior/spread", [0.0, HUGE], "how much vertices spread evenly over the surface")
        .internal(),
    Parameter::count("steps", "/steps", 100, "largest number of steps of conjugate gradients in a round").internal(),
    MOTION,
    BOUNDARY,
];

impl DenoiseMethod for Map {
    const INFO: MethodInfo = MethodInfo {
        name: "map",
        summary: "Most probable surface for the measured noise, smooth but for creases: for any shape whose nature is known",
        reference: None,
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.motion)
    }
}

/// Estimates the surface and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &Map, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let localised = Localised::of(surface);
    let surface = &localised.surface;
    let connectivity = Connectivity::of(surface);
    let noise = NoiseEstimate::of(surface, &connectivity, progress)?;
    let kind = noise.level.kind();
    let sigma = settings.noise.unwrap_or_else(|| noise.level.sigma_as(kind));
    let tangential_stiffness = match settings.noise_across {
        Some(tangential) => noise_level::tangential_stiffness(sigma, tangential),
        None => noise.level.tangential_stiffness(kind),
    };
    let input = surface.positions();
    let is_noisy = sigma > noise_level::ROUNDING_NOISE && noise.mean_edge > 0.0;
    if !is_noisy || settings.prior.strength == 0.0 {
        return Ok(vec![DVec3::ZERO; input.len()]);
    }
    let constraint = BoundaryConstraint::of(surface, settings.boundary);
    let field = NoiseField::uniform(input.len(), sigma, noise.mean_edge, tangential_stiffness);
    let problem = Problem { max_steps: settings.steps, ..Problem::new(&connectivity, &constraint, &field) };
    let guess = problem.guess(input, progress)?;
    let offsets = problem.estimate(input, &guess, &settings.prior, progress)?;
    Ok(localised.restored(&connectivity.undo_flips(input, offsets, &field)))
}
