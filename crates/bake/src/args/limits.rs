//! Options that limit what any method may do.

use super::values::not_negative;
use crate::failure::Failure;
use crate::input;
use clap::Args;
use planish_files::mask::MaskOption;
use planish_geometry::denoise::limits::{Direction, Limits, Mask, Volume};
use planish_geometry::source::Source;
use std::convert::Infallible;
use std::path::{Path, PathBuf};

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
    /// How far each vertex may go: colour:CHANNEL, group:NAME, material:NAME, weights:FILE, or a grey PNG in the UVs of the mesh
    ///
    /// Weights are from 0 (a vertex stays) to 1. The channels are red, green, blue and grey, of the colours of the vertices. Names of
    /// groups, objects and materials are separated by commas: those vertices go all of whose faces are named, so that no other
    /// face changes. A file of weights has one number for each vertex of the mesh; the window writes what was painted there. `not:` before a mask takes 1 minus its weights, and the other faces.
    #[arg(long, value_name = "MASK")]
    mask: Option<MaskOption>,
    /// Move vertices along one direction only: X,Y,Z is an axis (0,0,1 for terrain), ray:X,Y,Z the rays from a camera
    ///
    /// The surface moves as far along its normals as it would freely, where normals are within 60° of the direction, and less
    /// beyond. `bake` needs --map vector with it.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    direction: Option<Direction>,
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
    /// Lists the files of masks: those with vertices that stay, and the one of weights.
    pub(super) fn masks(&self) -> impl Iterator<Item = &PathBuf> {
        let fixed = self.fix.iter().filter_map(|fix| match fix {
            Fix::Boundary => None,
            Fix::File(path) => Some(path),
        });
        fixed.chain(self.mask.as_ref().and_then(MaskOption::file))
    }
    /// Reads those files and returns the limits for the mesh that was read from `path`.
    pub(super) fn limits(&self, source: &Source, path: &Path) -> Result<Limits, Failure> {
        let mesh = source.data();
        let mut fixed = Mask::default();
        for fix in &self.fix {
            fixed = fixed.and(match fix {
                Fix::Boundary => Mask::boundary(),
                Fix::File(path) => input::fixed_vertices(path, mesh.positions().len())?,
            });
        }
        let volume = if self.preserve_volume { Volume::Preserve } else { Volume::Free };
        let mask = self.mask.as_ref().map(|mask| mask.weights(source, path)).transpose()?;
        Ok(Limits { fixed, max_displacement: self.max_displacement, volume, mask, direction: self.direction })
    }
}
