//! Where the vertices shall go, and along what.

use super::BakeError;
use crate::denoise::limits::{Bounds, Limits, LimitsError, Outcome};
use crate::denoise::{Along, Denoiser, Denoising, DenoisingError, Loss, Motion, Moved, auto};
use crate::displacement::MapKind;
use crate::manifest::{Method, Target};
use crate::model::{Model, NormalSource};
use crate::obj::Obj;
use crate::progress::Progress;
use crate::surface::Surface;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Where the vertices shall go; in JSON an object with the field `name`, which is that of a method or `target`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Map<String, serde_json::Value>")]
pub enum Goal {
    /// Where a method takes them, within its limits.
    Denoiser(Denoising),
    /// To these places: the heights of any denoised mesh.
    Target {
        /// Of the vertices. #V×3, model units
        positions: Vec<DVec3>,
        /// Where they are from.
        #[serde(flatten)]
        target: Target,
    },
}

impl TryFrom<serde_json::Map<String, serde_json::Value>> for Goal {
    type Error = serde_json::Error;

    fn try_from(mut goal: serde_json::Map<String, serde_json::Value>) -> Result<Self, Self::Error> {
        let positions = goal.shift_remove("positions");
        match (Method::try_from(goal)?, positions) {
            (Method::Denoiser(denoising), None) => Ok(Self::Denoiser(denoising)),
            (Method::Target(target), Some(positions)) => {
                Ok(Self::Target { positions: serde_json::from_value(positions)?, target })
            }
            (method, _) => Err(serde::de::Error::custom(format!(
                "`{}` is neither a method nor a target with positions",
                method.name()
            ))),
        }
    }
}

impl Default for Goal {
    fn default() -> Self {
        Denoiser::default().into()
    }
}

impl From<Denoiser> for Goal {
    fn from(denoiser: Denoiser) -> Self {
        Self::Denoiser(denoiser.into())
    }
}

impl From<DenoisingError> for BakeError {
    fn from(error: DenoisingError) -> Self {
        match error {
            DenoisingError::Limits(error) => Self::Limits(error),
            DenoisingError::Cancelled(error) => Self::Cancelled(error),
        }
    }
}

/// How a map takes the vertices there.
#[derive(Clone, Debug, PartialEq)]
pub struct Ways {
    /// δ as the map holds it. #V×3, model units
    pub deltas: Vec<DVec3>,
    /// Those that it displaces along, or that stand in its tangent frames. #V×3
    pub normals: Vec<Vec3>,
    /// Whose these are.
    pub source: NormalSource,
    /// ⟨δ, n⟩, with a map of heights (#V, model units); what they leave out.
    pub heights: Option<(Vec<f64>, Loss)>,
    /// What limits did; none without any.
    pub limits: Option<Outcome>,
    /// What the method chose.
    pub choice: Option<auto::Choice>,
}

impl Goal {
    /// The places of another mesh with the same `v` lines.
    ///
    /// # Panics
    /// If it has fewer.
    pub fn to(model: &Model, denoised: &Obj, target: Target) -> Self {
        let positions = model.weld().first().iter().map(|&line| denoised.positions()[line as usize]).collect();
        Self::Target { positions, target }
    }

    /// Denoises for a kind of map, along certain normals. Without any, heights of methods with a [`Motion`] go along those
    /// that lose least, all else along the angle-weighted ones of the input. Heights along normals that lean are fitted
    /// whatever the method, and tangent frames do not lean.
    ///
    /// # Panics
    /// If a target has not one position for each vertex.
    pub fn ways(
        &self,
        model: &Model,
        map: MapKind,
        normals: Option<NormalSource>,
        progress: &dyn Progress,
    ) -> Result<Ways, BakeError> {
        let surface = model.surface();
        let chosen = normals.unwrap_or_default();
        if map != MapKind::Scalar {
            let Moved { deltas, limits, choice, .. } = match self {
                Self::Denoiser(denoising) => denoising.run(surface, model.weld(), progress)?,
                Self::Target { positions, .. } => {
                    Moved { deltas: ways_to(surface, positions), along: None, limits: None, choice: None }
                }
            };
            let chosen = if chosen == NormalSource::Leaning { NormalSource::Denoised } else { chosen };
            let normals = model.displacement_normals(chosen, &deltas)?;
            return Ok(Ways { deltas, normals, source: chosen, heights: None, limits, choice });
        }
        // Limits hold for the way that the map can hold.
        let bounds = self.bounds(model)?;
        let ((mut deltas, choice), fits) = match self {
            Self::Denoiser(Denoising { denoiser, .. }) => {
                (denoiser.freed().run(surface, progress)?, denoiser.motion().is_some())
            }
            Self::Target { positions, .. } => ((ways_to(surface, positions), None), false),
        };
        bounds.clamp(&mut deltas);
        let (along, source) = if fits && normals.is_none() {
            Along::best(surface, &deltas, progress)?
        } else if chosen == NormalSource::Leaning {
            (Along::leaning(surface, &deltas, progress)?, chosen)
        } else {
            let normals = model.displacement_normals(chosen, &deltas)?;
            let along = match fits {
                true => Along::fitted(surface, &deltas, normals, progress)?,
                false => Along::projected(surface, &deltas, normals),
            };
            (along, chosen)
        };
        let (along, limits) = along.within(&bounds, surface, &deltas, progress)?;
        let (deltas, Along { normals, heights, loss }) = (along.deltas(), along);
        Ok(Ways { deltas, normals, source, heights: Some((heights, loss)), limits, choice })
    }

    /// Limits of the vertices.
    fn bounds(&self, model: &Model) -> Result<Bounds, LimitsError> {
        match self {
            Self::Denoiser(denoising) => denoising.limits.on(model.surface(), model.weld()),
            Self::Target { .. } => Limits::default().on(model.surface(), model.weld()),
        }
    }

    /// What the manifest says of it.
    pub(super) fn method(&self, map: MapKind) -> Method {
        match self {
            Self::Denoiser(Denoising { denoiser, limits }) if map == MapKind::Scalar => {
                let denoiser = denoiser.clone().with_motion(Motion::AlongNormal);
                Method::Denoiser(Denoising { denoiser, limits: limits.clone() })
            }
            Self::Denoiser(denoising) => Method::Denoiser(denoising.clone()),
            Self::Target { target, .. } => Method::Target(target.clone()),
        }
    }
}

/// p − p*. #V×3, model units
fn ways_to(surface: &Surface, positions: &[DVec3]) -> Vec<DVec3> {
    assert_eq!(positions.len(), surface.positions().len(), "one target for each vertex");
    surface.positions().iter().zip(positions).map(|(p, q)| *p - *q).collect()
}
