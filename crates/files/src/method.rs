//! Prepares a method for running; every program calls this before it runs one.

use crate::failure::Failure;
use planish_geometry::denoise::Denoiser;
use std::path::Path;

/// Makes a method ready to run. `origin` is the file that errors name: the manifest that contains the method, or else the mesh
/// that it will denoise.
///
/// This checks the settings against their ranges. A method with a file of weights would be resolved here as well: its settings
/// would name that file and its SHA-256, as a manifest keeps them; this function would read the file beside `origin`, compare
/// the sum, and put the bytes into a field that serde skips. `Denoiser::deltas` then needs no file.
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
