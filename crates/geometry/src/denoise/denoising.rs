//! A method within limits, and the form of its result: displacements in any direction, or heights along normals.

use super::limits::{Bounds, Limits, LimitsError, Outcome};
use super::motion::Motion;
use super::normal_field::{self, HeightDirections, NormalField};
use super::{Denoiser, HeightField, auto};
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::mesh::weld::Weld;
use crate::progress::{Cancelled, Progress};
use crate::source::model::NormalSource;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A method and what it may not do; in JSON the settings of the method with the field `limits` beside them, which is
/// absent where there are none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Denoising {
    /// The method.
    #[serde(flatten)]
    pub denoiser: Denoiser,
    /// Limits of the vertices.
    #[serde(default, skip_serializing_if = "Limits::is_none")]
    pub limits: Limits,
}

impl From<Denoiser> for Denoising {
    fn from(denoiser: Denoiser) -> Self {
        Self { denoiser, limits: Limits::default() }
    }
}

/// Reasons why a denoising has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DenoisingError {
    /// The limits do not fit the surface.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Form of the result of a denoising.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Output {
    /// Vertices may go in any direction.
    #[default]
    Free,
    /// Vertices go along one normal each, as a map of heights takes them. With `None` the normals are chosen: methods
    /// with a [`Motion`] get those that lose least ([`HeightField::best`]), all others the angle-weighted ones of the input.
    Heights(Option<HeightDirections>),
}

/// Result of a denoising.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Displacements δᵢ = pᵢ − p*ᵢ. #V×3, model units
    pub deltas: Vec<DVec3>,
    /// Height field that represents the displacements and the normals it goes along; only with [`Output::Heights`].
    pub along: Option<(HeightField, NormalField)>,
    /// Effect of the limits; `None` without limits.
    pub limits: Option<Outcome>,
    /// Choice of a method that chooses; `None` for all others.
    pub choice: Option<auto::DenoiseChoice>,
}

impl Denoising {
    /// Output that the motion of the method asks for.
    pub fn output(&self) -> Output {
        match self.denoiser.motion() {
            Some(Motion::AlongNormal) => Output::Heights(None),
            Some(Motion::Free) | None => Output::Free,
        }
    }

    /// Denoises within the limits; `weld` says which source vertices each vertex of these is. Limits hold for the
    /// displacements in the form that is asked for, whatever the motion of the method.
    pub fn run(
        &self,
        surface: &Surface,
        weld: &Weld,
        output: Output,
        progress: &dyn Progress,
    ) -> Result<Moved, DenoisingError> {
        if let (Output::Heights(_), Some(direction)) = (&output, self.limits.direction) {
            return Err(LimitsError::NotAlongNormals(direction).into());
        }
        let bounds = self.limits.on(surface, weld)?;
        let (mut deltas, choice) = self.denoiser.freed().run(surface, progress)?;
        bounds.shape(surface, &mut deltas);
        let fit = if self.denoiser.motion().is_some() { HeightFit::FaceNormals } else { HeightFit::Positions };
        Ok(Unbounded { deltas, bounds, fit, choice }.into_output(surface, output, progress)?)
    }
}

/// Property of the denoised surface that heights are fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeightFit {
    /// Positions of the denoised surface: displacements are projected.
    Positions,
    /// Face normals of the denoised surface, which is what filters of normals are about.
    FaceNormals,
}

/// Displacements before their limits and their form.
#[derive(Clone, Debug)]
pub(crate) struct Unbounded {
    /// Displacements δᵢ = pᵢ − p*ᵢ. #V×3, model units
    pub(crate) deltas: Vec<DVec3>,
    /// Limits of the vertices.
    pub(crate) bounds: Bounds,
    /// Property of the denoised surface that heights are fitted to.
    pub(crate) fit: HeightFit,
    /// Choice of a method that chooses; `None` for all others.
    pub(crate) choice: Option<auto::DenoiseChoice>,
}

impl Unbounded {
    /// Puts displacements into a form and keeps them within their limits there.
    pub(crate) fn into_output(
        self,
        surface: &Surface,
        output: Output,
        progress: &dyn Progress,
    ) -> Result<Moved, Cancelled> {
        let Self { mut deltas, bounds, fit, choice } = self;
        let Output::Heights(directions) = output else {
            // Normals cost more than many a method, and are of use to limits alone.
            let none = bounds.are_none();
            let normals = if none { Vec::new() } else { normals::vertex_normals(surface, FaceWeight::Angle) };
            let limits = bounds.apply(surface, &normals, &mut deltas, progress)?;
            return Ok(Moved { deltas, along: None, limits, choice });
        };
        bounds.clamp(&mut deltas);
        let (along, field) = heights(surface, &deltas, directions, fit, progress)?;
        let (along, limits) = along.constrained(&bounds, surface, &deltas, progress)?;
        Ok(Moved { deltas: along.deltas(), along: Some((along, field)), limits, choice })
    }
}

/// Heights of δ (#V×3, model units) along directions, and the name of these. Heights along tilted normals are always
/// fitted to face normals, because the tilt comes from that fit.
fn heights(
    surface: &Surface,
    deltas: &[DVec3],
    directions: Option<HeightDirections>,
    fit: HeightFit,
    progress: &dyn Progress,
) -> Result<(HeightField, NormalField), Cancelled> {
    let (normals, field) = match (directions, fit) {
        (None, HeightFit::FaceNormals) => return HeightField::best(surface, deltas, progress),
        (Some(HeightDirections::Tilted), _) => {
            return Ok((HeightField::tilted(surface, deltas, progress)?, NormalField::Tilted));
        }
        (None, HeightFit::Positions) => (normal_field::in_single_precision(surface), NormalSource::Angle.into()),
        (Some(HeightDirections::Given(normals, source)), _) => (normals, source.into()),
        (Some(HeightDirections::Denoised), _) => (normal_field::of_denoised(surface, deltas), NormalField::Denoised),
    };
    let along = match fit {
        HeightFit::FaceNormals => HeightField::fitted(surface, deltas, normals, progress)?,
        HeightFit::Positions => HeightField::projected(surface, deltas, normals),
    };
    Ok((along, field))
}
