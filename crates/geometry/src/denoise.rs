//! Every method answers one question: how far is each vertex off?
//!
//! ```
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::{shapes, synthetic_noise::{self, Direction, Noise}};
//! use planish_geometry::progress::Silent;
//!
//! let clean = shapes::gridded_box(8);
//! let noisy = synthetic_noise::noisy(&clean, &Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 });
//! let method = Denoiser::named("bilateral-normals").unwrap();
//! let denoised = method.denoised(&noisy, &Silent)?;
//!
//! let error = |positions: &[glam::DVec3]| positions.iter().zip(clean.positions()).map(|(a, b)| a.distance(*b)).sum::<f64>();
//! assert!(error(&denoised) < 0.7 * error(noisy.positions()));
//! # Ok::<(), planish_geometry::progress::Cancelled>(())
//! ```

pub mod auto;
mod bilaplacian;
mod bilateral;
mod bilateral_normals;
mod boundary;
mod choice;
mod conjugate_gradients;
mod connectivity;
mod denoising;
mod face_geometry;
mod flips;
mod guided_normals;
mod hc;
mod heights;
mod implicit;
mod l0;
mod laplacian;
mod learned;
pub mod limits;
mod map;
mod method;
mod motion;
mod near;
mod no_data;
mod noise_field;
mod noise_level;
mod normal_field;
mod parameters;
mod sun;
mod taubin;
mod tgv_normals;
mod triangle_mesh;
mod vertex_update;

pub use auto::Auto;
pub use bilateral::Bilateral;
pub use bilateral_normals::{BilateralNormals, Neighbours, Scheme};
pub use boundary::Boundary;
pub use denoising::{Denoising, DenoisingError, LastResult, Moved, Output};
pub(crate) use denoising::{HeightFit, Unbounded};
pub use guided_normals::{GuidedNormals, GuidedRound};
pub use hc::Hc;
pub use heights::{HeightField, HeightResidual};
pub use implicit::{Implicit, Solver};
pub use l0::L0;
pub use laplacian::{EdgeWeights, Laplacian};
pub use learned::{FaceSamples, Learned, LearnedWeights, WeightsError, samples as learned_samples};
pub use map::{Map, Prior, PriorName};
pub use method::{MethodInfo, Reference};
pub use motion::Motion;
pub use noise_field::{RegionSample, samples as noise_samples};
pub use noise_level::{Kind, NoiseLevel};
pub use normal_field::{HeightDirections, NormalField, NormalFieldName};
pub use parameters::{NotAllowed, Parameter, ParameterError, Preset, Values};
pub use sun::Sun;
pub use taubin::Taubin;
pub use tgv_normals::TgvNormals;
pub use vertex_update::{FoldOvers, VertexScheme, VertexUpdate};

use crate::mesh::orientation;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use method::DenoiseMethod;
use serde::Serialize;
use std::borrow::Cow;

/// Declares the methods, by their settings.
macro_rules! methods {
    ($($method:ident,)+) => {
        /// A method with its settings; in JSON an object with the field `name`.
        #[derive(Clone, Debug, PartialEq, Serialize)]
        #[serde(tag = "name", rename_all = "kebab-case")]
        #[non_exhaustive]
        pub enum Denoiser {
            $(#[doc = concat!("The method of [`", stringify!($method), "`].")] $method($method),)+
        }

        impl Denoiser {
            /// Every method with its default settings.
            pub fn every() -> [Self; [$(stringify!($method)),+].len()] {
                [$(Self::$method(<_>::default())),+]
            }
            /// Facts about the method that do not depend on its settings.
            pub fn info(&self) -> &'static MethodInfo {
                match self { $(Self::$method(_) => const { &$method::INFO },)+ }
            }
            /// Returns this method with the settings of its paper; `None` if the paper gives no settings that apply to every mesh.
            pub fn paper(&self) -> Option<Self> {
                match self { $(Self::$method(_) => $method::published().map(Self::$method),)+ }
            }
            fn choose(&self, surface: &Surface, progress: &dyn Progress) -> Result<Outcome, Cancelled> {
                match self { $(Self::$method(settings) => settings.choose(surface, progress),)+ }
            }
            fn motion_mut(&mut self) -> Option<&mut Motion> {
                match self { $(Self::$method(settings) => settings.motion_mut(),)+ }
            }
            /// Reads settings of the method of a name.
            fn from_settings(name: &str, settings: serde_json::Value) -> Result<Self, serde_json::Error> {
                $(if name == $method::INFO.name {
                    return serde_json::from_value(settings).map(Self::$method);
                })+
                Err(serde::de::Error::custom(format!("there is no method `{name}`")))
            }
        }
    };
}

methods! {
    Laplacian,
    Taubin,
    Hc,
    Implicit,
    Bilateral,
    Sun,
    BilateralNormals,
    GuidedNormals,
    L0,
    TgvNormals,
    Map,
    Learned,
    Auto,
}

/// Displacements δ (#V×3, model units) and the choice of a method that chooses.
type Outcome = (Vec<DVec3>, Option<auto::DenoiseChoice>);

impl Default for Denoiser {
    fn default() -> Self {
        Self::Auto(Auto::default())
    }
}

impl Denoiser {
    /// Name of the method, as in JSON and on the command line.
    pub fn name(&self) -> &'static str {
        self.info().name
    }
    /// One line on what the method does and what it is good for.
    pub fn summary(&self) -> &'static str {
        self.info().summary
    }
    /// Denoises; returns δ as [`Denoiser::deltas`] does, and the choice of a method that chooses, `None` for all others.
    pub fn run(
        &self,
        surface: &Surface,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<auto::DenoiseChoice>), Cancelled> {
        let (surface, no_data) = prepared(surface);
        let (deltas, mut choice) = self.run_prepared(&surface, progress)?;
        if let Some(choice) = &mut choice {
            choice.no_data += no_data;
        }
        Ok((deltas, choice))
    }
    fn run_prepared(&self, surface: &Surface, progress: &dyn Progress) -> Result<Outcome, Cancelled> {
        if self.motion() == Some(Motion::AlongNormal) {
            let (free, choice) = self.freed().run_prepared(surface, progress)?;
            return Ok((HeightField::best(surface, &free, progress)?.0.deltas(), choice));
        }
        progress.stage("denoising");
        // From a thread outside the pool each parallel loop would be handed over and waited for asleep.
        rayon::scope(|_| self.choose(surface, progress))
    }
    /// Motion that this method allows its vertices; `None` for a method without such a setting.
    pub fn motion(&self) -> Option<Motion> {
        self.clone().motion_mut().copied()
    }
    /// Returns this method with another motion; methods without a motion stay as they are.
    pub fn with_motion(mut self, motion: Motion) -> Self {
        if let Some(own) = self.motion_mut() {
            *own = motion;
        }
        self
    }
    /// Returns this method with vertices that may go anywhere.
    pub fn freed(&self) -> Self {
        self.clone().with_motion(Motion::Free)
    }
    /// Displacements δᵢ = pᵢ − p*ᵢ from the denoised position to the vertex, zero where a vertex stays. #V×3, model units
    pub fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        Ok(self.run(surface, progress)?.0)
    }
    /// Denoised positions p*ᵢ = pᵢ − δᵢ. #V×3, model units
    pub fn denoised(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        Ok(surface.moved_by(&self.deltas(surface, progress)?))
    }
}

impl GuidedNormals {
    /// Takes one round on a part of a mesh and returns the positions after it (#V×3, model units). Each round measures the whole mesh, so
    /// whoever has it in parts takes a round on all of them and measures before the next one; so many rounds as there are
    /// `iterations` are the method, but for motion along normals.
    pub fn round(
        &self,
        surface: &Surface,
        start: GuidedRound,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        guided_normals::round(&prepared(surface).0, self, start, progress)
    }
}

/// The surface as methods get it: with faces that agree about the outside, since which way a face was wound says nothing of where its
/// vertices are, and without those of vertices that stand for missing data. Also returns the number of these vertices.
fn prepared(surface: &Surface) -> (Cow<'_, Surface>, usize) {
    let (mut prepared, mut no_data) = (Cow::Borrowed(surface), 0);
    loop {
        if let Some(turned) = orientation::turned_faces(prepared.topology()) {
            let topology = orientation::with_turned(prepared.topology(), &turned);
            prepared = Cow::Owned(Surface::new(topology, prepared.positions().to_vec()));
        }
        let Some(marks) = no_data::marks(&prepared) else { return (prepared, no_data) };
        no_data += marks.iter().filter(|mark| **mark).count();
        prepared = Cow::Owned(no_data::without(&prepared, &marks));
    }
}

#[cfg(test)]
mod tests;
