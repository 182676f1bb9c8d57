//! Where the vertices shall go, and along what.

use super::BakeError;
use crate::denoise::{Along, Denoiser, Loss, Motion};
use crate::displacement::MapKind;
use crate::manifest::{Method, Target};
use crate::model::{Model, NormalSource};
use crate::obj::Obj;
use crate::progress::Progress;
use glam::{DVec3, Vec3};

/// Where the vertices shall go.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// Where a method takes them.
    Denoiser(Denoiser),
    /// To these places: the heights of any denoised mesh.
    Target {
        /// Of the vertices. #V×3, model units
        positions: Vec<DVec3>,
        /// Where they are from.
        target: Target,
    },
}

impl Default for Goal {
    fn default() -> Self {
        Self::Denoiser(Denoiser::default())
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
    /// that lose least, all else along the angle-weighted ones of the input.
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
        let deltas = match self {
            Self::Denoiser(denoiser) if map == MapKind::Scalar => denoiser.freed().deltas(surface, progress)?,
            Self::Denoiser(denoiser) => denoiser.deltas(surface, progress)?,
            Self::Target { positions, .. } => {
                assert_eq!(positions.len(), surface.positions().len(), "one target for each vertex");
                surface.positions().iter().zip(positions).map(|(p, q)| *p - *q).collect()
            }
        };
        let fits = matches!(self, Self::Denoiser(denoiser) if denoiser.motion().is_some());
        let chosen = normals.unwrap_or_default();
        let given = || model.displacement_normals(chosen, &deltas);
        let (along, source) = match normals {
            _ if map != MapKind::Scalar => {
                let normals = given()?;
                return Ok(Ways { deltas, normals, source: chosen, heights: None });
            }
            None if fits => Along::best(surface, &deltas, progress)?,
            _ if fits => (Along::fitted(surface, &deltas, given()?, progress)?, chosen),
            _ => (Along::projected(surface, &deltas, given()?), chosen),
        };
        let (deltas, Along { normals, heights, loss }) = (along.deltas(), along);
        Ok(Ways { deltas, normals, source, heights: Some((heights, loss)) })
    }

    /// What the manifest says of it.
    pub(super) fn method(&self, map: MapKind) -> Method {
        match self {
            Self::Denoiser(denoiser) if map == MapKind::Scalar => {
                Method::Denoiser(denoiser.clone().with_motion(Motion::AlongNormal))
            }
            Self::Denoiser(denoiser) => Method::Denoiser(denoiser.clone()),
            Self::Target { target, .. } => Method::Target(target.clone()),
        }
    }
}
