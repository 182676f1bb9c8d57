//! Denoised positions that a map leads to, and displacements that it can express.

use super::BakeError;
use crate::denoise::limits::{Limits, Outcome};
use crate::denoise::{
    Denoiser, Denoising, DenoisingError, HeightField, HeightFit, HeightResidual, LastResult, Motion, Moved,
    NormalField, Output, Unbounded, auto,
};
use crate::map::displacement::MapKind;
use crate::map::manifest::{Method, Target};
use crate::mesh::surface::Surface;
use crate::progress::Progress;
use crate::source::MeshData;
use crate::source::model::Model;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Denoised surface that a map leads to; in JSON an object with the field `name`, which is the name of a method or `target`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Map<String, serde_json::Value>")]
pub enum BakeTarget {
    /// The result of a method within its limits.
    Method(Denoising),
    /// Positions from elsewhere, for example the result of another denoiser.
    Positions {
        /// Denoised position of each vertex. #V×3, model units
        positions: Vec<DVec3>,
        /// File that the positions come from.
        #[serde(flatten)]
        target: Target,
    },
}

impl TryFrom<serde_json::Map<String, serde_json::Value>> for BakeTarget {
    type Error = serde_json::Error;

    fn try_from(mut target: serde_json::Map<String, serde_json::Value>) -> Result<Self, Self::Error> {
        let positions = target.shift_remove("positions");
        match (Method::try_from(target)?, positions) {
            (Method::Denoiser(denoising), None) => Ok(Self::Method(denoising)),
            (Method::Target(target), Some(positions)) => {
                Ok(Self::Positions { positions: serde_json::from_value(positions)?, target })
            }
            (method, _) => Err(serde::de::Error::custom(format!(
                "`{}` is neither a method nor a target with positions",
                method.name()
            ))),
        }
    }
}

impl Default for BakeTarget {
    fn default() -> Self {
        Denoiser::default().into()
    }
}

impl From<Denoiser> for BakeTarget {
    fn from(denoiser: Denoiser) -> Self {
        Self::Method(denoiser.into())
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

/// Displacements of the vertices as a map of some kind can express them.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexDisplacements {
    /// Displacements δ from the denoised positions to the vertices, as the map expresses them. #V×3, model units
    pub deltas: Vec<DVec3>,
    /// Unit normals that the map displaces along, or that stand in its tangent frames; zero where there is none. #V×3
    pub normals: Vec<Vec3>,
    /// Origin of the normals.
    pub source: NormalField,
    /// Heights ⟨δ, n⟩ (#V, model units), positive where a vertex lies outside the denoised surface, with the part of the
    /// denoised surface that they cannot represent; `None` for maps of vectors.
    pub heights: Option<(Vec<f64>, HeightResidual)>,
    /// Effect of the limits; `None` if there are no limits.
    pub limits: Option<Outcome>,
    /// Choice of a method that chooses its own parameters.
    pub choice: Option<auto::DenoiseChoice>,
}

impl BakeTarget {
    /// Target whose positions are those of another mesh with the same source vertices.
    ///
    /// # Panics
    /// If the other mesh has fewer source vertices.
    #[must_use]
    pub fn from_mesh(model: &Model, denoised: &MeshData, target: Target) -> Self {
        let positions = model.weld().first().iter().map(|&v| denoised.positions()[v as usize]).collect();
        Self::Positions { positions, target }
    }

    /// Runs the method and fits the result to a kind of map, which displaces along `normals`.
    ///
    /// If `normals` is `None`, methods with a [`Motion`] displace along the normals with the smallest residual; targets,
    /// other methods and maps of vectors use the angle-weighted normals of the input. [`NormalField::Tilted`] always fits
    /// heights; tangent frames are never tilted.
    ///
    /// # Errors
    /// If the mesh has not the normals that were chosen, if the limits do not fit it, or if the caller cancels.
    ///
    /// # Panics
    /// If a target has not one position for each vertex.
    pub fn displacements(
        &self,
        model: &Model,
        map: MapKind,
        normals: Option<NormalField>,
        progress: &dyn Progress,
    ) -> Result<VertexDisplacements, BakeError> {
        self.displacements_with(&LastResult::default(), model, map, normals, progress)
    }

    /// Displacements as [`Self::displacements`] finds them, with the result that is remembered if the method is the same.
    pub(super) fn displacements_with(
        &self,
        last: &LastResult,
        model: &Model,
        map: MapKind,
        normals: Option<NormalField>,
        progress: &dyn Progress,
    ) -> Result<VertexDisplacements, BakeError> {
        let output = match (map, self) {
            (MapKind::Scalar, _) => Output::Heights(normals.map(|field| field.directions(model)).transpose()?),
            (_, Self::Method(denoising)) => denoising.output(),
            (_, Self::Positions { .. }) => Output::Free,
        };
        let Moved { deltas, along, limits, choice } = self.moved(last, model, output, progress)?;
        Ok(match along.filter(|_| map == MapKind::Scalar) {
            Some((HeightField { normals, heights, residual }, source)) => {
                VertexDisplacements { deltas, normals, source, heights: Some((heights, residual)), limits, choice }
            }
            None => {
                let source = match normals.unwrap_or_default() {
                    NormalField::Tilted => NormalField::Denoised,
                    field => field,
                };
                let normals = source.normals(model, &deltas)?;
                VertexDisplacements { deltas, normals, source, heights: None, limits, choice }
            }
        })
    }

    /// Displacements in the form of `output`, within the limits of the method; given positions have no limits.
    fn moved(
        &self,
        last: &LastResult,
        model: &Model,
        output: Output,
        progress: &dyn Progress,
    ) -> Result<Moved, BakeError> {
        let surface = model.surface();
        match self {
            Self::Method(denoising) => Ok(denoising.run_with(last, surface, model.weld(), output, progress)?),
            Self::Positions { positions, .. } => {
                let bounds = Limits::default().on(surface, model.weld())?;
                let deltas = displacements_to(surface, positions);
                let free = Unbounded { deltas, bounds, fit: HeightFit::Positions, choice: None };
                Ok(free.into_output(surface, output, progress)?)
            }
        }
    }

    /// Entry of the manifest for this target. The motion of a method is along the normals in maps of heights.
    pub(super) fn method(&self, map: MapKind) -> Method {
        match self {
            Self::Method(Denoising { denoiser, limits }) if map == MapKind::Scalar => {
                let denoiser = denoiser.clone().with_motion(Motion::AlongNormal);
                Method::Denoiser(Denoising { denoiser, limits: limits.clone() })
            }
            Self::Method(denoising) => Method::Denoiser(denoising.clone()),
            Self::Positions { target, .. } => Method::Target(target.clone()),
        }
    }
}

/// Displacements p − p* to positions p*. #V×3, model units
fn displacements_to(surface: &Surface, positions: &[DVec3]) -> Vec<DVec3> {
    assert_eq!(positions.len(), surface.positions().len(), "one target position for each vertex");
    surface.positions().iter().zip(positions).map(|(p, q)| *p - *q).collect()
}
