//! Comparison of the open mesh with a clean one, without and with its map.

use super::document::{Document, Map};
use planish_files::failure::Failure;
use planish_files::input::{self, Trust};
use planish_geometry::map::displace;
use planish_geometry::metrics::{self, Comparison, Triangles};
use planish_geometry::progress::Progress;
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
}

/// The open mesh without its map, against the clean mesh: the part of a measurement that λ does not change.
#[derive(Debug)]
pub struct Noisy {
    triangles: Triangles,
    comparison: Comparison,
}

/// Comparisons of the open mesh with the clean mesh.
#[derive(Clone, Debug)]
pub struct Measured {
    noisy: Arc<Noisy>,
    /// The mesh with its map at some λ; none without a map.
    pub displaced: Option<(f32, Comparison)>,
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

/// Measures what `planish compare` would measure of the mesh, and of what `planish apply` would write for a map at some λ.
///
/// `known` is from an earlier measurement of the same two meshes. With it, a step of λ costs a displacement and a comparison.
pub fn measure(
    clean: &Clean,
    document: &Document,
    known: Option<Arc<Noisy>>,
    map: Option<(&Map, f32)>,
    progress: &dyn Progress,
) -> Result<Measured, Failure> {
    progress.stage("comparing");
    let noisy = match known {
        Some(noisy) => noisy,
        None => {
            let triangles = Triangles::from(document.model.data());
            let comparison = clean.compare(&triangles)?;
            Arc::new(Noisy { triangles, comparison })
        }
    };
    progress.check()?;
    let displaced = match map.and_then(|(map, lambda)| Some((map, map.displacement()?, lambda))) {
        Some((map, displacement, lambda)) => {
            let origin = map.manifest.displacement.origin;
            let positions = displace::displaced(&map.vertices, displacement, lambda, origin);
            progress.check()?;
            Some((lambda, clean.compare(&noisy.triangles.at(positions))?))
        }
        None => None,
    };
    Ok(Measured { noisy, displaced })
}
