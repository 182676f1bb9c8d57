//! Keyword arguments as settings.

use planish_files::failure::Failure;
use planish_files::method;
use planish_geometry::denoise::limits::{Limits, Mask, Volume, WeightMask, Weights};
use planish_geometry::denoise::{Denoiser, Denoising};
use planish_geometry::mesh::weld::Welding;
use pyo3::FromPyObject;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::path::Path;

/// A method with its settings and limits, as the package writes them.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MethodOptions {
    method: String,
    preset: String,
    parameters: Map<String, Value>,
    /// Vertices that stay, as text of a mask; its vertices are counted from 1.
    fix: Option<String>,
    max_displacement: Option<f64>,
    preserve_volume: bool,
    /// Direction along which vertices move, as text.
    direction: Option<String>,
}

impl MethodOptions {
    /// Reads options that the package has written as JSON.
    pub(crate) fn parse(json: &str) -> Result<Self, Failure> {
        serde_json::from_str(json).map_err(|e| Failure::Input(format!("options of denoising: {e}")))
    }

    /// Method with its settings and limits for a mesh of so many source vertices, which have these weights (#v), if any.
    pub(crate) fn denoising(&self, source_vertices: usize, mask: Option<&[f32]>) -> Result<Denoising, Failure> {
        let wrong = |e: &dyn std::fmt::Display| Failure::Input(e.to_string());
        let mut denoiser = Denoiser::named(&self.method).map_err(|e| wrong(&e))?;
        match self.preset.as_str() {
            "default" => {}
            "paper" => {
                let of_paper = denoiser.paper();
                let none = || Failure::Input(format!("`preset`: {} has no settings of its paper", self.method));
                denoiser = of_paper.ok_or_else(none)?;
            }
            other => return Err(Failure::Input(format!("`preset` is \"default\" or \"paper\", not {other:?}"))),
        }
        let settings: Vec<(&str, Value)> =
            self.parameters.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
        denoiser.set_all(&settings).map_err(|e| wrong(&e))?;
        let denoiser = method::prepare(denoiser, Path::new("settings"))?;
        let fixed = match &self.fix {
            Some(text) => Mask::parse(text, source_vertices).map_err(|e| Failure::Input(format!("`fix`: {e}")))?,
            None => Mask::default(),
        };
        if let Some(d) = self.max_displacement.filter(|d| !(0.0..=1e6).contains(d)) {
            return Err(Failure::Input(format!("`max_displacement` is a number between 0 and 1000000, not {d}")));
        }
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        if let Some((found, needed)) =
            mask.map(|m| (m.len(), source_vertices)).filter(|(found, needed)| found != needed)
        {
            return Err(Failure::Input(format!("`mask` has {found} weights, and the mesh has {needed} vertices")));
        }
        let mask = mask.map(|weights| WeightMask { from: "array".to_owned(), weights: Weights::new(weights) });
        let direction = self.direction.as_deref().map(str::parse).transpose();
        let direction = direction.map_err(|e| Failure::Input(format!("`direction`: {e}")))?;
        let max_displacement = self.max_displacement;
        Ok(Denoising { denoiser, limits: Limits { fixed, max_displacement, volume, mask, direction } })
    }
}

/// Rule of welding as a caller gives it.
#[derive(Debug, FromPyObject)]
pub(crate) enum Weld {
    /// Distance in model units.
    Distance(f64),
    /// A word.
    Word(String),
}

impl Weld {
    /// The rule.
    pub(crate) fn rule(&self) -> Result<Welding, Failure> {
        match self {
            Self::Word(word) if word == "exact" => Ok(Welding::Exact),
            Self::Word(word) if word == "none" => Ok(Welding::None),
            Self::Distance(d) if d.is_finite() && *d > 0.0 => Ok(Welding::Epsilon(*d)),
            _ => Err(Failure::Input("`weld` is \"exact\", \"none\" or a distance greater than 0".to_owned())),
        }
    }
}
