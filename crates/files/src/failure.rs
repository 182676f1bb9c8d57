//! The error of everything that reads, bakes or writes files.
//!
//! ```
//! use planish_files::failure::Failure;
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::shapes;
//! use planish_geometry::progress::Progress;
//! use std::path::Path;
//!
//! /// A user who does not wait.
//! struct Impatient;
//! impl Progress for Impatient {
//!     fn cancelled(&self) -> bool {
//!         true
//!     }
//! }
//!
//! fn vertices(progress: &dyn Progress) -> Result<usize, Failure> {
//!     Ok(Denoiser::named("laplacian").unwrap().denoised(&shapes::cube(), progress)?.len())
//! }
//! assert_eq!(vertices(&Impatient), Err(Failure::Interrupted));
//!
//! let failure = Failure::at(Path::new("scan.obj"), "has no faces");
//! assert_eq!((failure.to_string().as_str(), failure.status()), ("scan.obj: has no faces", 2));
//! ```

use crate::text::shown;
use planish_geometry::denoise::limits::LimitsError;
use planish_geometry::progress::Cancelled;
use std::path::Path;

/// An error as one sentence for the user, with the exit code that it stands for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// Input or usage is wrong; exit code 2.
    #[error("{0}")]
    Input(String),
    /// Something failed that is not the user's doing; exit code 1.
    #[error("{0}")]
    Internal(String),
    /// The user interrupted the work; exit code 1.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

impl Failure {
    /// Makes an input error that begins with the path of the file at fault.
    pub fn at(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self::Input(format!("{}: {reason}", shown(path)))
    }
    /// Makes a failure that is not the user's doing from the error that caused it; exit code 1.
    pub fn internal(error: impl std::fmt::Display) -> Self {
        Self::Internal(error.to_string())
    }
    /// Explains limits that a mesh cannot keep, and names the option that helps.
    pub fn limits(error: &LimitsError, mesh: &Path) -> Self {
        match error {
            LimitsError::Open { .. } => Self::at(mesh, format!("{error}; --preserve-volume needs --fix for these")),
            LimitsError::NotAlongNormals(_) => Self::at(
                mesh,
                format!("{error}: --direction goes with --map vector, and not with --motion along-normal"),
            ),
            _ => Self::at(mesh, error),
        }
    }
    /// Returns the exit code that a program ends with.
    pub fn status(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Internal(_) | Self::Interrupted => 1,
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Interrupted
    }
}
