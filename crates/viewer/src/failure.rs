//! Why the program ends without a picture.

use planish_viewer::gpu::GpuError;
use std::path::PathBuf;
use thiserror::Error;

/// What went wrong.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    /// A file that cannot be read or makes no sense.
    #[error("{}: {reason}", path.display())]
    Input { path: PathBuf, reason: String },
    /// Options that do not go together.
    #[error("{0}")]
    Usage(String),
    /// A file that cannot be written.
    #[error("{}: {reason}", path.display())]
    Output { path: PathBuf, reason: String },
    /// The map could not be made.
    #[error("baking: {0}")]
    Bake(String),
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// No `--headless`.
    #[error("the window is not part of this version; draw into a file with --headless OUT.png")]
    NoWindow,
}

impl Failure {
    /// Exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Output { .. } | Self::NoWindow | Self::Bake(_) | Self::Gpu(_) => 1,
            Self::Input { .. } | Self::Usage(_) => 2,
        }
    }
}
