//! The entry of the method by which a mesh was denoised.

use crate::denoise::{Denoiser, Denoising};
use serde::{Deserialize, Serialize};

/// Method by which a mesh was denoised; in JSON an object with the field `name`. The settings of a method that this version
/// knows must exist and be in their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Map<String, serde_json::Value>")]
pub enum Method {
    /// The mesh was denoised by this method with these settings.
    Denoiser(Denoising),
    /// The mesh was denoised by other means; the result is in this file.
    Target(Target),
    /// The mesh was denoised by a method that this version does not know; its map can be used all the same.
    Other(serde_json::Map<String, serde_json::Value>),
}

impl Method {
    /// Name of the method, or `target`.
    pub fn name(&self) -> &str {
        match self {
            Self::Denoiser(Denoising { denoiser, .. }) => denoiser.name(),
            Self::Target(_) => TARGET,
            Self::Other(method) => method.get("name").and_then(serde_json::Value::as_str).unwrap_or_default(),
        }
    }
}

impl TryFrom<serde_json::Map<String, serde_json::Value>> for Method {
    type Error = serde_json::Error;

    fn try_from(method: serde_json::Map<String, serde_json::Value>) -> Result<Self, Self::Error> {
        let name = method.get("name").and_then(serde_json::Value::as_str).unwrap_or_default();
        if Denoiser::named(name).is_ok() {
            serde_json::from_value(method.into()).map(Self::Denoiser)
        } else if name == TARGET {
            serde_json::from_value(method.into()).map(Self::Target)
        } else {
            Ok(Self::Other(method))
        }
    }
}

/// Name that stands for the name of a method if the mesh was denoised by other means.
const TARGET: &str = "target";

/// A mesh that was denoised by other means.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Target {
    name: TargetName,
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the bytes of the file, hexadecimal.
    pub sha256: String,
}

/// Field that distinguishes a target from a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum TargetName {
    Target,
}

impl Target {
    /// Describes a mesh by its file name and the SHA-256 of its bytes.
    pub fn new(file: String, sha256: String) -> Self {
        Self { name: TargetName::Target, file, sha256 }
    }
}
