//! The gate that every method passes before it runs, whoever runs it.

use crate::failure::Failure;
use planish_geometry::denoise::Denoiser;
use std::path::Path;

/// Makes a method ready to run. `origin` is the file that the method comes with: the manifest that names it, or else the mesh
/// that it is for; errors name that file.
///
/// Today this checks the settings against their ranges. A method with a file of weights is resolved here as well: its settings
/// hold the name and the SHA-256 of that file, which are what manifests keep; this function reads the file beside `origin`,
/// compares the sum, and puts the bytes into a field that serde skips. `Denoiser::deltas` then needs no file.
pub fn prepare(denoiser: Denoiser, origin: &Path) -> Result<Denoiser, Failure> {
    denoiser.check().map_err(|e| Failure::at(origin, e))?;
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
