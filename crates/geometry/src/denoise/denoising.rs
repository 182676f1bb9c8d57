//! A method within limits, and the form of its result: displacements in any direction, or heights along normals.

use super::limits::{Bounds, Limits, LimitsError, Outcome};
use super::motion::Motion;
use super::normal_field::{self, HeightDirections, NormalField};
use super::{Denoiser, HeightField, auto};
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::mesh::weld::Weld;
use crate::progress::{Cancelled, Progress};
use crate::source::model::NormalSource;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::sync::{Arc, Mutex, PoisonError};

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
        self.run_with(&LastResult::default(), surface, weld, output, progress)
    }

    /// Denoises as [`Self::run`] does, with the result that is remembered if the method is the same.
    pub(crate) fn run_with(
        &self,
        last: &LastResult,
        surface: &Surface,
        weld: &Weld,
        output: Output,
        progress: &dyn Progress,
    ) -> Result<Moved, DenoisingError> {
        if let (Output::Heights(_), Some(direction)) = (&output, self.limits.direction) {
            return Err(LimitsError::NotAlongNormals(direction).into());
        }
        let bounds = self.limits.on(surface, weld)?;
        let (mut deltas, choice) = last.of(&self.denoiser, surface, progress)?;
        bounds.shape(surface, &mut deltas);
        let fit = if self.denoiser.motion().is_some() { HeightFit::FaceNormals } else { HeightFit::Positions };
        Ok(Unbounded { deltas, bounds, fit, choice }.into_output(surface, output, progress)?)
    }
}

/// Result of a method whose vertices may go anywhere, before its limits.
#[derive(Clone, Debug)]
struct FreeResult {
    /// The method.
    denoiser: Denoiser,
    /// SHA-256 of the surface.
    surface: [u8; 32],
    /// Displacements δᵢ = pᵢ − p*ᵢ. #V×3, model units
    deltas: Vec<DVec3>,
    /// Choice of a method that chooses; `None` for all others.
    choice: Option<auto::DenoiseChoice>,
}

/// Memory of the last result of a method: whoever bakes a mesh again with other limits, or another map, need not denoise it again. The
/// default remembers nothing, and a clone is the same memory. It changes no result, so that all of them are equal.
#[derive(Clone, Debug, Default)]
pub struct LastResult(Option<Arc<Mutex<Option<FreeResult>>>>);

impl PartialEq for LastResult {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LastResult {
    /// A memory with nothing in it yet.
    pub fn remembered() -> Self {
        Self(Some(Arc::default()))
    }

    /// Displacements of a method (#V×3, model units), and the choice of one that chooses: those that are remembered if both the method
    /// and the surface are the same, else new ones.
    fn of(
        &self,
        denoiser: &Denoiser,
        surface: &Surface,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<auto::DenoiseChoice>), Cancelled> {
        let denoiser = denoiser.freed();
        let Some(memory) = &self.0 else { return denoiser.run(surface, progress) };
        // A thread that panicked while it had the memory left a whole result.
        let lock = || memory.lock().unwrap_or_else(PoisonError::into_inner);
        let digest = digest(surface);
        let is_same = |last: &&FreeResult| last.denoiser == denoiser && last.surface == digest;
        if let Some(FreeResult { deltas, choice, .. }) = lock().as_ref().filter(is_same).cloned() {
            return Ok((deltas, choice));
        }
        let (deltas, choice) = denoiser.run(surface, progress)?;
        *lock() = Some(FreeResult { denoiser, surface: digest, deltas: deltas.clone(), choice: choice.clone() });
        Ok((deltas, choice))
    }
}

/// SHA-256 of the positions and faces of a surface.
fn digest(surface: &Surface) -> [u8; 32] {
    let mut hash = Sha256::new();
    for p in surface.positions() {
        hash.update(p.to_array().map(f64::to_le_bytes).as_flattened());
    }
    for face in surface.topology().faces().iter() {
        hash.update((face.len() as Index).to_le_bytes());
        face.iter().for_each(|v| hash.update(v.to_le_bytes()));
    }
    hash.finalize().into()
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
