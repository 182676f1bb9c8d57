//! How work ends that does not end well.

use planish_geometry::denoise::limits::LimitsError;
use planish_geometry::progress::Cancelled;
use std::path::Path;
use std::process::ExitCode;

/// One clear sentence, and whose fault it was.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// Input or usage that cannot work; exit code 2.
    #[error("{0}")]
    Input(String),
    /// Anything else; exit code 1.
    #[error("{0}")]
    Internal(String),
    /// Interrupted; exit code 1.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

impl Failure {
    /// A failure that a file is the reason of.
    pub fn at(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::Input(format!("{}: {reason}", path.display()))
    }
    /// A failure that is not the user's doing, in the words of the error behind it; exit code 1.
    pub fn internal(error: impl std::fmt::Display) -> Self {
        Self::Internal(error.to_string())
    }
    /// Limits that a mesh cannot have, with the way out.
    pub fn limits(error: &LimitsError, mesh: &Path) -> Self {
        match error {
            LimitsError::Open { .. } => Self::at(mesh, format!("{error}; --preserve-volume needs --fix for these")),
            LimitsError::NoSuchLine { .. } | LimitsError::NotALength(_) => Self::at(mesh, error),
        }
    }
    /// What a program ends with.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Internal(_) | Self::Interrupted => ExitCode::from(1),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Interrupted
    }
}
