//! How the tiles of a mesh are denoised.

use super::measure::Lengths;
use super::plan::of_tile;
use super::reach::{self, Halo};
use crate::failure::Failure;
use planish_geometry::denoise::Denoising;
use planish_geometry::denoise::limits::Volume;
use std::path::{Path, PathBuf};

/// How each tile of a mesh is denoised: decided once, for all of them.
#[derive(Clone, Debug)]
pub struct Job {
    /// Name by which the caller knows the mesh and all settings. Results under this name are those of this job.
    pub key: String,
    /// Method and limits. Masks of single vertices are in `weights`.
    pub method: Denoising,
    /// Halo of each tile.
    pub halo: Halo,
    /// Lengths of the whole mesh, where [`Job::needs_lengths`] asks for them.
    pub lengths: Option<Lengths>,
    /// File with a weight of each source vertex (f32, little endian); `None` if all are 1.
    pub weights: Option<PathBuf>,
}

impl Job {
    /// Whether the job needs the lengths of the whole mesh.
    pub fn needs_lengths(&self) -> bool {
        let is_measured = reach::needs_centroid_distance(&self.method.denoiser) || self.rounds().is_some();
        is_measured || self.method.limits.max_displacement.is_some()
    }

    /// Number of rounds that all tiles take together before [`denoise`](super::denoise()), by [`round`](super::round()) and
    /// [`end_round`](super::end_round); `None` for most methods.
    pub fn rounds(&self) -> Option<u32> {
        // A halo for blending is that of a caller who takes no rounds.
        let takes_rounds = self.halo.is_bounded && self.weights.is_none();
        reach::rounds(&self.method, None).filter(|_| takes_rounds).map(|(_, rounds)| rounds)
    }

    /// Checks that the method and its limits can be had tile by tile.
    pub fn check(&self) -> Result<(), Failure> {
        if self.method.limits.volume == Volume::Preserve {
            let reason = "the volume is that of the whole mesh: `preserve_volume` does not go with tiles";
            return Err(Failure::Input(reason.to_owned()));
        }
        Ok(())
    }

    /// File of the report on a tile, which is there when the tile is done.
    pub(super) fn report(&self, folder: &Path, tile: usize) -> PathBuf {
        of_tile(folder, tile, &format!("{}.json", self.key))
    }
}
