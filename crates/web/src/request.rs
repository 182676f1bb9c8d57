//! What the page asks for.

use planish_files::failure::Failure;
use planish_geometry::bake::BakeSettings;
use planish_geometry::denoise::limits::{Limits, Mask, Volume};
use planish_geometry::denoise::{Denoiser, Denoising};
use serde::Deserialize;
use serde_json::{Map, Value};

/// Settings of a bake as the page has them.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Name of the method.
    method: String,
    /// Parameters of the method, by the names of their options.
    parameters: Map<String, Value>,
    /// Whether vertices at the boundary stay.
    fix_boundary: bool,
    /// Largest distance of a vertex from its position in the input, mean edge lengths.
    max_displacement: Option<f64>,
    /// Whether the volume of the input is restored.
    preserve_volume: bool,
    /// Settings of the maps.
    pub bake: BakeSettings,
}

impl Request {
    /// Reads a request. Fails if a setting is unknown or missing.
    pub fn parse(json: &str) -> Result<Self, Failure> {
        serde_json::from_str(json).map_err(|e| Failure::Input(format!("settings: {e}")))
    }

    /// Method with its settings and limits. Fails if a value is not allowed.
    pub fn denoising(&self) -> Result<Denoising, Failure> {
        let wrong = |e: &dyn std::fmt::Display| Failure::Input(e.to_string());
        let mut denoiser = Denoiser::named(&self.method).map_err(|e| wrong(&e))?;
        let given: Vec<(&str, Value)> =
            self.parameters.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
        denoiser.set_all(&given).map_err(|e| wrong(&e))?;
        if let Some(d) = self.max_displacement.filter(|d| !(0.0..=1e6).contains(d)) {
            return Err(Failure::Input(format!("the largest displacement is a number between 0 and 1000000, not {d}")));
        }
        let fixed = if self.fix_boundary { Mask::boundary() } else { Mask::default() };
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        let limits = Limits { fixed, max_displacement: self.max_displacement, volume, ..Limits::default() };
        Ok(Denoising { denoiser, limits })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(change: impl Fn(&mut Value)) -> Result<Denoising, String> {
        let mut json = serde_json::json!({
            "method": "guided-normals", "parameters": { "iterations": 7 }, "fix_boundary": true, "max_displacement": 0.5,
            "preserve_volume": true, "bake": { "texel": { "format": "exr", "bits": 32 } },
        });
        change(&mut json);
        Request::parse(&json.to_string()).and_then(|request| request.denoising()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_request_becomes_a_method_with_its_limits() {
        let denoising = request(|_| ()).unwrap();
        assert_eq!(serde_json::to_value(&denoising.denoiser).unwrap()["iterations"], 7);
        assert_eq!(denoising.limits.fixed, Mask::boundary());
        assert_eq!((denoising.limits.max_displacement, denoising.limits.volume), (Some(0.5), Volume::Preserve));
    }

    #[test]
    fn what_cannot_be_is_told() {
        let error = |pointer: &str, value: Value| {
            request(|json| *json.pointer_mut(pointer).unwrap() = value.clone()).unwrap_err()
        };
        assert!(error("/method", "none".into()).contains("no method `none`"));
        assert!(error("/parameters", serde_json::json!({ "radios": 1 })).contains("no setting `radios`"));
        assert!(error("/parameters/iterations", (-1).into()).contains("-1 is not a whole number"));
        assert!(error("/max_displacement", (-1.0).into()).contains("not -1"));
        assert!(error("/bake", serde_json::json!({ "lamda": 1 })).contains("lamda"));
    }
}
