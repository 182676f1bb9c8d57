//! A method within limits.

use super::Denoiser;
use super::limits::{Limits, LimitsError, Outcome};
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

impl Denoising {
    /// δᵢ = pᵢ − p*ᵢ within the limits (#V×3, model units), and what these did; `weld` says which vertices the `v` lines
    /// of the limits are.
    pub fn deltas(
        &self,
        surface: &Surface,
        weld: &Weld,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<Outcome>), DenoisingError> {
        let bounds = self.limits.on(surface, weld)?;
        let mut deltas = self.denoiser.deltas(surface, progress)?;
        let along = normals::vertex_normals(surface, FaceWeight::Angle);
        let outcome = bounds.apply(surface, &along, &mut deltas, progress)?;
        Ok((deltas, outcome))
    }
}
