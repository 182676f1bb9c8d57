//! Prepares a method for running; every program calls this before it runs one.
//!
//! ```
//! use planish_files::method;
//! use planish_geometry::denoise::{Denoiser, Laplacian, Learned};
//! use std::path::Path;
//!
//! let mesh = Path::new("scan.obj");
//! let usual = Denoiser::Laplacian(Laplacian::default());
//! assert_eq!(method::prepare(usual.clone(), mesh), Ok(usual));
//!
//! let wrong = method::prepare(Denoiser::Laplacian(Laplacian { step: f64::NAN, ..Laplacian::default() }), mesh);
//! assert!(wrong.unwrap_err().to_string().starts_with("scan.obj: "));
//! let network = Some("missing.weights".to_owned());
//! let without = method::prepare(Denoiser::Learned(Learned { network, ..Learned::default() }), mesh);
//! assert!(without.unwrap_err().to_string().starts_with("missing.weights: "));
//! ```

use crate::failure::Failure;
use crate::input::{self, LARGEST_WEIGHTS, NamedFile, Trust};
use planish_geometry::denoise::{Denoiser, Learned, LearnedWeights};
use planish_geometry::map::manifest;
use std::path::Path;

/// Makes a method that a user has set up ready to run: checks the settings against their ranges, and reads the file of weights, if
/// there is one. `mesh` is the file that errors name.
pub fn prepare(denoiser: Denoiser, mesh: &Path) -> Result<Denoiser, Failure> {
    ready(denoiser, mesh, Path::new(""), Trust::Anywhere)
}

/// Makes the method of a manifest ready to run. A file of weights lies where the manifest says, beside it or below unless it is trusted, and
/// has to be that of the bake.
pub fn prepare_of_manifest(denoiser: Denoiser, manifest: &Path, trust: Trust) -> Result<Denoiser, Failure> {
    ready(denoiser, manifest, input::folder_of(manifest), trust)
}

fn ready(mut denoiser: Denoiser, origin: &Path, folder: &Path, trust: Trust) -> Result<Denoiser, Failure> {
    denoiser.check().map_err(|e| Failure::at(origin, e))?;
    if let Denoiser::Learned(Learned { network: Some(file), network_sha256, loaded, .. }) = &mut denoiser {
        let path = &folder.join(file);
        let bytes = NamedFile { path, folder, trust, largest: LARGEST_WEIGHTS }.read()?;
        let sha256 = manifest::sha256(&bytes);
        if network_sha256.as_ref().is_some_and(|known| *known != sha256) {
            return Err(Failure::at(path, "is not the file of weights that the method was run with"));
        }
        *loaded = Some(LearnedWeights::parse(&bytes).map_err(|e| Failure::at(path, e))?.into());
        *network_sha256 = Some(sha256);
    }
    Ok(denoiser)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planish_geometry::denoise::GuidedNormals;

    #[test]
    fn settings_out_of_range_are_refused_with_their_name() {
        let wide = GuidedNormals { radius: 1e9, ..GuidedNormals::default() };
        let error = prepare(Denoiser::GuidedNormals(wide), Path::new("a.obj")).unwrap_err().to_string();
        assert!(error.starts_with("a.obj: setting `radius` of guided-normals: 1000000000.0 is not"), "{error}");
        for method in Denoiser::every() {
            assert_eq!(prepare(method.clone(), Path::new("a.obj")), Ok(method));
        }
    }
}
