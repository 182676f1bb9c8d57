//! Every method answers one question: how far is each vertex off?

pub mod auto;
mod bilaplacian;
mod bilateral;
mod bilateral_normals;
mod conjugate_gradients;
mod connectivity;
mod denoising;
mod face_geometry;
mod guided_normals;
mod hc;
mod heights;
mod implicit;
mod l0;
mod laplacian;
pub mod limits;
mod map;
mod noise_level;
mod normal_field;
mod sun;
mod taubin;
mod tgv_normals;
mod triangle_mesh;
mod vertex_update;

pub use auto::Auto;
pub use bilateral::Bilateral;
pub use bilateral_normals::{BilateralNormals, Neighbours, Scheme};
pub use denoising::{Denoising, DenoisingError, Moved, Output};
pub(crate) use denoising::{HeightFit, Unbounded};
pub use guided_normals::GuidedNormals;
pub use hc::Hc;
pub use heights::{HeightField, HeightResidual};
pub use implicit::{Implicit, Solver};
pub use l0::L0;
pub use laplacian::{Boundary, EdgeWeights, Laplacian};
pub use map::{Map, Prior};
pub use noise_level::{Kind, NoiseLevel};
pub use normal_field::{HeightDirections, NormalField};
pub use sun::Sun;
pub use taubin::Taubin;
pub use tgv_normals::TgvNormals;
pub use vertex_update::{FoldOvers, Motion, VertexScheme, VertexUpdate};

use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A method with its settings; in JSON an object with the field `name`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Denoiser {
    /// Steps towards the mean of the neighbours.
    Laplacian(Laplacian),
    /// The same without shrinking.
    Taubin(Taubin),
    /// Steps that are pushed back.
    Hc(Hc),
    /// One long step, by solving a linear system.
    Implicit(Implicit),
    /// Bilateral filter of the heights over the tangent planes.
    Bilateral(Bilateral),
    /// Normals averaged over faces that look the same way.
    Sun(Sun),
    /// Bilateral filter of the normals.
    BilateralNormals(BilateralNormals),
    /// The same, guided by the most consistent patches.
    GuidedNormals(GuidedNormals),
    /// As few edges that are not flat as possible.
    L0(L0),
    /// Total generalised variation of the normals.
    TgvNormals(TgvNormals),
    /// The most probable surface, where normals turn evenly but for creases.
    Map(Map),
    /// Whatever the mesh seems to need.
    Auto(Auto),
}

impl Default for Denoiser {
    fn default() -> Self {
        Self::Auto(Auto::default())
    }
}

impl Denoiser {
    /// Every method with its default settings.
    pub fn every() -> [Self; 12] {
        [
            Self::Laplacian(<_>::default()),
            Self::Taubin(<_>::default()),
            Self::Hc(<_>::default()),
            Self::Implicit(<_>::default()),
            Self::Bilateral(<_>::default()),
            Self::Sun(<_>::default()),
            Self::BilateralNormals(<_>::default()),
            Self::GuidedNormals(<_>::default()),
            Self::L0(<_>::default()),
            Self::TgvNormals(<_>::default()),
            Self::Map(<_>::default()),
            Self::Auto(<_>::default()),
        ]
    }
    /// Its name, as in JSON and on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Laplacian(_) => "laplacian",
            Self::Taubin(_) => "taubin",
            Self::Hc(_) => "hc",
            Self::Implicit(_) => "implicit",
            Self::Bilateral(_) => "bilateral",
            Self::Sun(_) => "sun",
            Self::BilateralNormals(_) => "bilateral-normals",
            Self::GuidedNormals(_) => "guided-normals",
            Self::L0(_) => "l0",
            Self::TgvNormals(_) => "tgv-normals",
            Self::Map(_) => "map",
            Self::Auto(_) => "auto",
        }
    }
    /// The same method with the settings that its authors used; none where they named none that fit every mesh.
    pub fn paper(&self) -> Option<Self> {
        match self {
            Self::Bilateral(_) => Some(Self::Bilateral(Bilateral::paper())),
            Self::Sun(_) => Some(Self::Sun(Sun::paper())),
            Self::BilateralNormals(_) => Some(Self::BilateralNormals(BilateralNormals::paper())),
            Self::GuidedNormals(_) => Some(Self::GuidedNormals(GuidedNormals::paper())),
            Self::Hc(_) => Some(Self::Hc(Hc::default())),
            Self::L0(_) => Some(Self::L0(L0::default())),
            Self::Laplacian(_)
            | Self::Taubin(_)
            | Self::Implicit(_)
            | Self::TgvNormals(_)
            | Self::Map(_)
            | Self::Auto(_) => None,
        }
    }
    /// What [`Denoiser::deltas`] gives, and what was chosen on the way; none by methods that choose nothing.
    pub fn run(
        &self,
        surface: &Surface,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<auto::DenoiseChoice>), Cancelled> {
        if self.motion() == Some(Motion::AlongNormal) {
            let (free, choice) = self.freed().run(surface, progress)?;
            return Ok((HeightField::best(surface, &free, progress)?.0.deltas(), choice));
        }
        progress.stage("denoising");
        // From a thread outside the pool each parallel loop would be handed over and waited for asleep.
        rayon::scope(|_| {
            let deltas = match self {
                Self::Laplacian(settings) => laplacian::deltas(surface, settings, progress),
                Self::Taubin(settings) => taubin::deltas(surface, settings, progress),
                Self::Hc(settings) => hc::deltas(surface, settings, progress),
                Self::Implicit(settings) => implicit::deltas(surface, settings, progress),
                Self::Bilateral(settings) => bilateral::deltas(surface, settings, progress),
                Self::Sun(settings) => sun::deltas(surface, settings, progress),
                Self::BilateralNormals(settings) => bilateral_normals::deltas(surface, settings, progress),
                Self::GuidedNormals(settings) => guided_normals::deltas(surface, settings, progress),
                Self::L0(settings) => l0::deltas(surface, settings, progress),
                Self::TgvNormals(settings) => tgv_normals::deltas(surface, settings, progress),
                Self::Map(settings) => map::deltas(surface, settings, progress),
                Self::Auto(settings) => {
                    let (deltas, choice) = auto::choose(surface, settings, progress)?;
                    return Ok((deltas, Some(choice)));
                }
            };
            Ok((deltas?, None))
        })
    }
    /// Where its vertices may go; none where it says nothing of it.
    pub fn motion(&self) -> Option<Motion> {
        self.clone().motion_mut().copied()
    }
    /// The same method with another motion, where it has one.
    pub fn with_motion(mut self, motion: Motion) -> Self {
        if let Some(own) = self.motion_mut() {
            *own = motion;
        }
        self
    }
    /// The same method with vertices that may go anywhere.
    pub fn freed(&self) -> Self {
        self.clone().with_motion(Motion::Free)
    }
    fn motion_mut(&mut self) -> Option<&mut Motion> {
        match self {
            Self::Sun(settings) => Some(&mut settings.vertex_update.motion),
            Self::BilateralNormals(settings) => Some(&mut settings.vertex_update.motion),
            Self::GuidedNormals(settings) => Some(&mut settings.vertex_update.motion),
            Self::TgvNormals(settings) => Some(&mut settings.vertex_update.motion),
            Self::Map(settings) => Some(&mut settings.motion),
            Self::Auto(settings) => Some(&mut settings.motion),
            Self::Laplacian(_)
            | Self::Taubin(_)
            | Self::Hc(_)
            | Self::Implicit(_)
            | Self::Bilateral(_)
            | Self::L0(_) => None,
        }
    }
    /// δᵢ = pᵢ − p*ᵢ, from the denoised place to the vertex. #V×3, model units; zero where a vertex stays.
    pub fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        Ok(self.run(surface, progress)?.0)
    }
    /// p*ᵢ = pᵢ − δᵢ. #V×3, model units.
    pub fn denoised(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        Ok(surface.moved_by(&self.deltas(surface, progress)?))
    }
}

#[cfg(test)]
mod tests;
