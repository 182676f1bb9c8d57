//! Comparison of the open mesh with a clean one, without and with its map.

use super::document::{Document, Map};
use super::vertex_numbers::VertexNumbers;
use crate::vertex_error;
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_geometry::map::displace;
use planish_geometry::metrics::{self, Comparison, Heat, Triangles};
use planish_geometry::progress::Progress;
use planish_geometry::source::model::Model;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A clean mesh to compare with.
#[derive(Debug)]
pub struct Clean {
    /// Path of its file.
    pub path: PathBuf,
    triangles: Triangles,
}

impl Clean {
    /// Reads a clean mesh.
    pub fn read(path: &Path, trust: Trust, progress: &dyn Progress) -> Result<Self, Failure> {
        progress.stage("reading");
        Ok(Self { path: path.to_owned(), triangles: Triangles::from(input::source(path, trust)?.data()) })
    }

    fn compare(&self, triangles: &Triangles) -> Result<Comparison, Failure> {
        metrics::compare(&self.triangles, triangles).map_err(|e| Failure::at(&self.path, e))
    }

    /// Angle by which the normals around each vertex are off, degrees. #V
    fn errors(&self, triangles: &Triangles, model: &Model) -> Result<Vec<f32>, Failure> {
        let heat = metrics::heat(&self.triangles, triangles, Heat::Angle).map_err(|e| Failure::at(&self.path, e))?;
        Ok(model.weld().first().iter().map(|&line| heat[line as usize] as f32).collect())
    }
}

/// Subject of a measurement: λ, the map by its address, and whether the errors of the vertices are asked for.
pub(super) type Key = (f32, Option<usize>, bool);

/// The open mesh without its map, against the clean mesh: the part of a measurement that λ does not change.
#[derive(Debug)]
pub struct Noisy {
    triangles: Triangles,
    comparison: Comparison,
    /// Errors of the vertices, once they were wanted: their range is that of all heat maps, so that colours stay while λ moves.
    errors: OnceLock<VertexNumbers>,
}

/// Comparisons of the open mesh with the clean mesh.
#[derive(Clone, Debug)]
pub struct Measured {
    noisy: Arc<Noisy>,
    /// The mesh with its map at some λ; none without a map.
    pub displaced: Option<(f32, Comparison)>,
    /// Errors of the vertices of the mesh, with its map if it has one; `None` if they were not wanted.
    pub errors: Option<VertexNumbers>,
}

impl Measured {
    /// The mesh as it is.
    pub fn noisy(&self) -> &Comparison {
        &self.noisy.comparison
    }

    /// The part that the next measurement of the same two meshes can start from.
    pub fn known(&self) -> Arc<Noisy> {
        Arc::clone(&self.noisy)
    }
}

/// Job of a measurement.
#[derive(Debug)]
pub struct Request<'a> {
    /// Part of an earlier measurement of the same two meshes. With it, a step of λ costs a displacement and a comparison.
    pub known: Option<Arc<Noisy>>,
    /// Map and λ.
    pub map: Option<(&'a Map, f32)>,
    /// Whether the errors of the vertices are wanted, which take as long again.
    pub wants_errors: bool,
}

/// Measures what `planish compare` would measure of the mesh, and of what `planish apply` would write for a map at some λ.
pub fn measure(
    clean: &Clean,
    document: &Document,
    request: Request,
    progress: &dyn Progress,
) -> Result<Measured, Failure> {
    progress.stage("comparing");
    let Request { known, map, wants_errors } = request;
    let noisy = match known {
        Some(noisy) => noisy,
        None => {
            let triangles = Triangles::from(document.model.data());
            let comparison = clean.compare(&triangles)?;
            Arc::new(Noisy { triangles, comparison, errors: OnceLock::new() })
        }
    };
    progress.check()?;
    let mut displaced = None;
    let mut shown = None;
    if let Some((map, displacement, lambda)) = map.and_then(|(map, lambda)| Some((map, map.displacement()?, lambda))) {
        let origin = map.manifest.displacement.origin;
        let triangles = noisy.triangles.at(displace::displaced(&map.vertices, displacement, lambda, origin));
        progress.check()?;
        displaced = Some((lambda, clean.compare(&triangles)?));
        shown = Some(triangles);
    }
    let errors = if wants_errors {
        progress.check()?;
        Some(errors(clean, document, &noisy, shown.as_ref())?)
    } else {
        None
    };
    Ok(Measured { noisy, displaced, errors })
}

/// Errors of the vertices as they are displaced, in the colours of the mesh as it is.
fn errors(
    clean: &Clean,
    document: &Document,
    noisy: &Noisy,
    displaced: Option<&Triangles>,
) -> Result<VertexNumbers, Failure> {
    let without_map = match noisy.errors.get() {
        Some(known) => known.clone(),
        None => {
            let numbers = clean.errors(&noisy.triangles, &document.model)?;
            let range = vertex_error::range(&numbers);
            let errors = VertexNumbers { numbers: Arc::new(numbers), range, title: "error, degrees" };
            noisy.errors.get_or_init(|| errors).clone()
        }
    };
    match displaced {
        None => Ok(without_map),
        Some(triangles) => {
            Ok(VertexNumbers { numbers: Arc::new(clean.errors(triangles, &document.model)?), ..without_map })
        }
    }
}
