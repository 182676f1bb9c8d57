//! Options that limit what any method may do.

use super::values::not_negative;
use crate::failure::Failure;
use crate::input;
use clap::Args;
use planish_geometry::denoise::limits::{Limits, Mask, Volume};
use planish_geometry::source::MeshData;
use std::convert::Infallible;
use std::path::PathBuf;

/// Options for the limits of denoising.
#[derive(Args, Debug)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Keep vertices where they are: the boundary of an open mesh, or those listed in a file; may be given several times
    ///
    /// The file has numbers of `v` lines, counted from 1, and ranges of them like 3-9, separated by blanks, commas or line
    /// breaks. A comment begins with # and ends with the line.
    #[arg(long, value_name = "boundary|FILE", value_parser = fix)]
    fix: Vec<Fix>,
    /// Largest displacement of a vertex, in mean edge lengths
    #[arg(long, value_name = "D", value_parser = not_negative, allow_negative_numbers = true)]
    max_displacement: Option<f64>,
    /// Restore the enclosed volume by an even offset; an open mesh needs --fix boundary with it
    #[arg(long)]
    preserve_volume: bool,
}

/// Value of `--fix`.
#[derive(Clone, Debug)]
enum Fix {
    Boundary,
    File(PathBuf),
}

fn fix(text: &str) -> Result<Fix, Infallible> {
    Ok(if text == "boundary" { Fix::Boundary } else { Fix::File(text.into()) })
}

impl LimitArgs {
    /// Lists the files with vertices that stay.
    pub(super) fn masks(&self) -> impl Iterator<Item = &PathBuf> {
        self.fix.iter().filter_map(|fix| match fix {
            Fix::Boundary => None,
            Fix::File(path) => Some(path),
        })
    }
    /// Reads those files and returns the limits for a mesh.
    pub(super) fn limits(&self, mesh: &MeshData) -> Result<Limits, Failure> {
        let mut fixed = Mask::default();
        for fix in &self.fix {
            fixed = fixed.and(match fix {
                Fix::Boundary => Mask::boundary(),
                Fix::File(path) => input::mask(path, mesh.positions().len())?,
            });
        }
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        Ok(Limits { fixed, max_displacement: self.max_displacement, volume })
    }
}
