//! Noise that comes with a mesh of its own: what a scanner makes of a surface has other vertices than the surface.
//!
//! The result is a pair of meshes with the same connectivity. The noisy one is the measurement; the clean one has the positions that
//! an exact measurement would have given to the same vertices.

mod depth_image;
mod fusion;
mod lattice;
mod range_image;
mod surface_nets;
#[cfg(test)]
mod tests;
mod voxels;

use super::settings::{SyntheticKind, SyntheticNoise};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;

/// A surface as it was measured, and as an exact measurement would have been, with the same connectivity.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// Surface without the noise.
    pub clean: Surface,
    /// Surface with the noise.
    pub noisy: Surface,
}

/// Reasons why a mesh cannot be measured anew.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RemeshError {
    /// The mesh has no extent or no faces, or the steps are so large that no face is left.
    #[error("no face is left of the mesh at this step")]
    Nothing,
    /// The mesh has a boundary, but voxels need to know what is inside.
    #[error("the mesh is open, so it has no inside that voxels could fill")]
    Open,
    /// The image or grid would have more cells than fit into memory.
    #[error("{cells:.1e} cells are too many for this mesh; a larger step needs fewer")]
    TooLarge {
        /// Number of cells in scientific notation.
        cells: Cells,
    },
}

/// Number of cells, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells(u128);

impl std::fmt::LowerExp for Cells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::LowerExp::fmt(&(self.0 as f64), f)
    }
}

/// Cells that an image or a grid may have: some hundred megabytes.
const MOST_CELLS: u128 = 1 << 25;

/// Returns the number of cells of a grid, if they are not too many.
fn cell_count(sides: &[f64]) -> Result<usize, RemeshError> {
    let cells = sides.iter().map(|side| side.max(1.0)).product::<f64>();
    // Conversions of numbers that are too large end at the largest integer.
    let cells = cells as u128;
    if cells > MOST_CELLS { Err(RemeshError::TooLarge { cells: Cells(cells) }) } else { Ok(cells as usize) }
}

/// Measures a surface anew: a range image, a fusion of several, or voxels. `None` for kinds that keep the connectivity.
pub(super) fn remeshed(surface: &Surface, noise: &SyntheticNoise) -> Option<Result<Remeshed, RemeshError>> {
    match noise.kind {
        SyntheticKind::RangeImage => Some(range_image::remeshed(surface, noise)),
        SyntheticKind::Fusion => Some(fusion::remeshed(surface, noise)),
        SyntheticKind::Voxels => Some(voxels::remeshed(surface, noise)),
        _ => None,
    }
}

/// Step of the pixels or voxels in model units. Fails if the mesh has no extent.
fn step(surface: &Surface, noise: &SyntheticNoise) -> Result<f64, RemeshError> {
    let step = noise.step * surface.mean_edge();
    if step.is_normal() && step > 0.0 { Ok(step) } else { Err(RemeshError::Nothing) }
}

/// Combines clean and noisy positions (#V×3) with faces, and leaves out the vertices that no face uses.
fn pair(clean: &[DVec3], noisy: &[DVec3], faces: &[[Index; 3]]) -> Result<Remeshed, RemeshError> {
    if faces.is_empty() {
        return Err(RemeshError::Nothing);
    }
    let mut new_index = vec![Index::MAX; clean.len()];
    let mut used: Vec<usize> = faces.iter().flatten().map(|&v| v as usize).collect();
    used.sort_unstable();
    used.dedup();
    for (new, &old) in (0..).zip(&used) {
        new_index[old] = new;
    }
    let faces: Ragged<Index> = faces.iter().map(|t| t.map(|v| new_index[v as usize]).to_vec()).collect();
    let at = |positions: &[DVec3]| used.iter().map(|&v| positions[v]).collect::<Vec<_>>();
    let clean = Surface::new(Topology::new(used.len(), faces), at(clean));
    Ok(Remeshed { noisy: clean.at(at(noisy)), clean })
}
