//! Where the vertices shall go, and along what.

use super::BakeError;
use crate::denoise::limits::{Limits, Outcome};
use crate::denoise::{
    Denoiser, Denoising, DenoisingError, HeightField, HeightFit, HeightResidual, Motion, Moved, NormalField, Output,
    Unbounded, auto,
};
use crate::map::displacement::MapKind;
use crate::map::manifest::{Method, Target};
use crate::mesh::surface::Surface;
use crate::progress::Progress;
use crate::source::MeshData;
use crate::source::model::Model;
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
    /// Where the normals come from.
    pub source: NormalField,
    /// ⟨δ, n⟩, with a map of heights (#V, model units); what they leave out.
    pub heights: Option<(Vec<f64>, HeightResidual)>,
    /// What limits did; none without any.
    pub limits: Option<Outcome>,
    /// What the method chose.
    pub choice: Option<auto::DenoiseChoice>,
}

impl Goal {
    /// Positions of another mesh with the same source vertices.
    ///
    /// # Panics
    /// If it has fewer.
    pub fn to(model: &Model, denoised: &MeshData, target: Target) -> Self {
        let positions = model.weld().first().iter().map(|&v| denoised.positions()[v as usize]).collect();
        Self::Target { positions, target }
    }

    /// Denoises for a kind of map, which displaces along `normals`.
    ///
    /// With `None`, heights of methods with a [`Motion`] go along the normals that lose least, all else along the
    /// angle-weighted normals of the input. [`NormalField::Tilted`] always fits heights; tangent frames are never tilted.
    ///
    /// # Panics
    /// If a target has not one position for each vertex.
    pub fn ways(
        &self,
        model: &Model,
        map: MapKind,
        normals: Option<NormalField>,
        progress: &dyn Progress,
    ) -> Result<Ways, BakeError> {
        let output = match (map, self) {
            (MapKind::Scalar, _) => Output::Heights(normals.map(|field| field.directions(model)).transpose()?),
            (_, Self::Denoiser(denoising)) => denoising.output(),
            (_, Self::Target { .. }) => Output::Free,
        };
        let Moved { deltas, along, limits, choice } = self.moved(model, output, progress)?;
        Ok(match along.filter(|_| map == MapKind::Scalar) {
            Some((HeightField { normals, heights, residual }, source)) => {
                Ways { deltas, normals, source, heights: Some((heights, residual)), limits, choice }
            }
            None => {
                let source = match normals.unwrap_or_default() {
                    NormalField::Tilted => NormalField::Denoised,
                    field => field,
                };
                let normals = source.normals(model, &deltas)?;
                Ways { deltas, normals, source, heights: None, limits, choice }
            }
        })
    }

    /// Displacements in a form, within the limits of the method; a target has none.
    fn moved(&self, model: &Model, output: Output, progress: &dyn Progress) -> Result<Moved, BakeError> {
        let surface = model.surface();
        match self {
            Self::Denoiser(denoising) => Ok(denoising.run(surface, model.weld(), output, progress)?),
            Self::Target { positions, .. } => {
                let bounds = Limits::default().on(surface, model.weld())?;
                let deltas = ways_to(surface, positions);
                let free = Unbounded { deltas, bounds, fit: HeightFit::Positions, choice: None };
                Ok(free.into_output(surface, output, progress)?)
            }
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
