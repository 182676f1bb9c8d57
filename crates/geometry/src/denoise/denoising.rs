//! A method within limits.

use super::limits::{Limits, LimitsError, Outcome};
use super::{Denoiser, HeightField, Motion, auto};
use crate::model::NormalSource;
use crate::normals::{self, FaceWeight};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use crate::weld::Weld;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A method and what it may not do; in JSON the settings of the method with the field `limits` beside them, which is
/// absent where there are none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Denoising {
    /// The method.
    #[serde(flatten)]
    pub denoiser: Denoiser,
    /// What it may not do.
    #[serde(default, skip_serializing_if = "Limits::is_none")]
    pub limits: Limits,
}

impl From<Denoiser> for Denoising {
    fn from(denoiser: Denoiser) -> Self {
        Self { denoiser, limits: Limits::default() }
    }
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DenoisingError {
    /// They do not fit the surface.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// As asked.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Where vertices go.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// δᵢ = pᵢ − p*ᵢ. #V×3, model units
    pub deltas: Vec<DVec3>,
    /// The same as heights and whose normals they go along, with [`Motion::AlongNormal`].
    pub along: Option<(HeightField, NormalSource)>,
    /// What limits did; none without any.
    pub limits: Option<Outcome>,
    /// What the method chose; none by methods that choose nothing.
    pub choice: Option<auto::DenoiseChoice>,
}

impl Denoising {
    /// Denoises within the limits; `weld` says which vertices the `v` lines of these are.
    pub fn run(&self, surface: &Surface, weld: &Weld, progress: &dyn Progress) -> Result<Moved, DenoisingError> {
        let bounds = self.limits.on(surface, weld)?;
        let (mut deltas, choice) = self.denoiser.freed().run(surface, progress)?;
        if self.denoiser.motion() == Some(Motion::AlongNormal) {
            bounds.clamp(&mut deltas);
            let (best, source) = HeightField::best(surface, &deltas, progress)?;
            let (along, limits) = best.constrained(&bounds, surface, &deltas, progress)?;
            return Ok(Moved { deltas: along.deltas(), along: Some((along, source)), limits, choice });
        }
        let along = normals::vertex_normals(surface, FaceWeight::Angle);
        let limits = bounds.apply(surface, &along, &mut deltas, progress)?;
        Ok(Moved { deltas, along: None, limits, choice })
    }
}
