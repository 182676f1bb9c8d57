//! Denoises a welded mesh, with the report that every program gives of it.
//!
//! ```
//! use planish_files::denoise_mesh::{self, DenoiseError, WeldedMesh};
//! use planish_geometry::denoise::{Denoiser, Denoising, limits::Limits};
//! use planish_geometry::mesh::{shapes, weld::{Weld, Welding}};
//! use planish_geometry::progress::Silent;
//!
//! let surface = shapes::dented_sphere(2);
//! let weld = Weld::new(surface.positions(), Welding::None);
//! let mesh = WeldedMesh { surface: &surface, weld: &weld, faces: surface.topology().faces().len() };
//! let limits = Limits { max_displacement: Some(0.01), ..Limits::default() };
//! let method = Denoising { denoiser: Denoiser::named("laplacian").unwrap(), limits };
//! let denoised = denoise_mesh::denoise(mesh, method, &Silent)?;
//!
//! // The limit is in mean edge lengths, and the report in model units.
//! let report = &denoised.report;
//! assert!((report.max_displacement / report.mean_edge - 0.01).abs() < 1e-9);
//! assert!(report.limits.as_ref().is_some_and(|limits| limits.stopped_vertices > 0));
//! let noisy = denoised.positions.iter().zip(&denoised.deltas).map(|(p, delta)| p + delta);
//! assert!(noisy.zip(surface.positions()).all(|(p, noisy)| p.distance(*noisy) < 1e-12));
//! # Ok::<(), DenoiseError>(())
//! ```

use crate::failure::Failure;
use crate::input;
use crate::text::shown;
use glam::DVec3;
use planish_geometry::denoise::limits::{LimitsError, Outcome};
use planish_geometry::denoise::{Denoiser, Denoising, DenoisingError, Moved, NormalField, auto};
use planish_geometry::map::manifest::HeightsLoss;
use planish_geometry::mesh::jagged::Index;
use planish_geometry::mesh::surface::Surface;
use planish_geometry::mesh::weld::Weld;
use planish_geometry::progress::Progress;
use planish_geometry::source::Source;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Mesh to denoise, which came from a file or as arrays.
#[derive(Clone, Copy, Debug)]
pub struct WeldedMesh<'a> {
    /// Welded surface.
    pub surface: &'a Surface,
    /// Vertex that each source vertex became.
    pub weld: &'a Weld,
    /// Number of faces of the source.
    pub faces: usize,
}

/// Figures of a denoising.
#[derive(Clone, Debug, Serialize)]
pub struct DenoiseReport {
    /// Method with its settings and limits.
    pub method: Denoising,
    /// Noise that the method `auto` measured, and the candidates that it chose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<auto::DenoiseChoice>,
    /// Number of source vertices.
    pub vertices: usize,
    /// Number of faces of the source.
    pub faces: usize,
    /// Mean edge length, model units.
    pub mean_edge: f64,
    /// Mean length of the displacements, model units.
    pub mean_displacement: f64,
    /// Largest length of a displacement, model units.
    pub max_displacement: f64,
    /// Loss of heights; only for methods that move vertices along normals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heights: Option<ReportedHeights>,
    /// Effect of the limits; `None` without limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Outcome>,
}

/// Difference between the surface that heights can express and the free result.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ReportedHeights {
    /// Normals that the heights go along.
    pub normals: NormalField,
    /// Loss of the heights.
    #[serde(flatten)]
    pub loss: HeightsLoss,
}

/// Result of a denoising.
#[derive(Clone, Debug)]
pub struct DenoisedMesh {
    /// Denoised positions. #V×3, model units
    pub positions: Vec<DVec3>,
    /// Displacements from the denoised positions to the vertices. #V×3, model units
    pub deltas: Vec<DVec3>,
    /// Figures for people and programs.
    pub report: DenoiseReport,
}

/// Reasons why there is no denoised mesh, without the name of the mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DenoiseError {
    /// The limits do not fit the mesh.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// The caller stopped the work.
    #[error("interrupted")]
    Cancelled,
    /// The method moved a vertex to infinity.
    #[error("{method} moved this vertex to infinity{advice}")]
    Infinite {
        /// Source vertex that was moved.
        vertex: Index,
        /// Name of the method.
        method: &'static str,
        /// Settings that would help, for the end of the sentence; empty where the method has none.
        advice: String,
    },
}

impl DenoiseError {
    /// Makes the error of a mesh that was read from `path`.
    pub fn at(&self, path: &Path, source: &Source) -> Failure {
        match self {
            Self::Limits(e) => Failure::limits(e, path),
            Self::Cancelled => Failure::Interrupted,
            Self::Infinite { vertex, .. } => {
                Failure::Internal(format!("{}: {}{self}", shown(path), input::vertex_place(source, *vertex)))
            }
        }
    }
}

/// Denoises a mesh by a method that [`prepare`](crate::method::prepare) has made ready.
pub fn denoise(mesh: WeldedMesh, method: Denoising, progress: &dyn Progress) -> Result<DenoisedMesh, DenoiseError> {
    let WeldedMesh { surface, weld, faces } = mesh;
    let moved = method.run(surface, weld, method.output(), progress).map_err(|e| match e {
        DenoisingError::Limits(e) => DenoiseError::Limits(e),
        DenoisingError::Cancelled(_) => DenoiseError::Cancelled,
    })?;
    let Moved { deltas, along, limits, choice } = moved;
    let positions = surface.moved_by(&deltas);
    if let Some(v) = positions.par_iter().position_first(|p| !p.is_finite()) {
        let (vertex, method) = (weld.first()[v], &method.denoiser);
        return Err(DenoiseError::Infinite { vertex, method: method.name(), advice: advice(method) });
    }
    let report = DenoiseReport {
        method,
        choice,
        vertices: weld.vertex_of().len(),
        faces,
        mean_edge: surface.mean_edge(),
        mean_displacement: deltas.iter().map(|d| d.length()).sum::<f64>() / deltas.len() as f64,
        max_displacement: deltas.par_iter().map(|d| d.length()).reduce(|| 0.0, f64::max),
        heights: along.map(|(along, normals)| ReportedHeights { normals, loss: along.residual.into() }),
        limits,
    };
    Ok(DenoisedMesh { positions, deltas, report })
}

/// Names the settings of a method that keep vertices from going too far.
fn advice(denoiser: &Denoiser) -> String {
    let has = |option: &&&str| denoiser.options().any(|parameter| parameter.name == **option);
    let smaller: Vec<String> = ["step", "iterations"].iter().filter(has).map(|o| format!("a smaller --{o}")).collect();
    if smaller.is_empty() { String::new() } else { format!(": use {}", smaller.join(" or ")) }
}
