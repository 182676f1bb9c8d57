//! Noise that the automatic method assumes: that of the settings, or else as measured.

use super::Auto;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::{NoiseField, Verdict, lines};
use crate::denoise::noise_level::{self, Kind, NoiseEstimate};
use crate::mesh::jagged::Index;
use crate::mesh::normals;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// True for a triangulated depth image: nearly all vertices have six neighbours, and the faces look to one side. There the two bands of
/// the whole mesh tell shared noise from a surface; on other meshes the second one is mostly surface.
fn is_range_image(surface: &Surface) -> bool {
    /// Least fraction of the inner vertices that have six neighbours. Remeshing leaves far fewer.
    const REGULAR: f64 = 0.85;
    /// Least length of the mean of all unit normals. A camera sees those of a sphere with 2/3; noise shortens it.
    const FACING: f64 = 0.5;
    let topology = surface.topology();
    let inner = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_boundary(v) && !topology.is_isolated(v));
    let (count, regular) = inner.fold((0usize, 0usize), |(count, regular), v| {
        (count + 1, regular + usize::from(topology.rings().get(v).len() == 6))
    });
    let is_grid = count > 0 && regular as f64 >= REGULAR * count as f64;
    let normals: Vec<DVec3> = normals::face_normals(surface);
    is_grid && normals.iter().sum::<DVec3>().length() > FACING * normals.len() as f64
}

/// Kind of the noise and its field: those of the settings, or else as measured.
pub(super) fn assumed_noise(
    surface: &Surface,
    connectivity: &Connectivity,
    settings: &Auto,
    level: &NoiseEstimate,
    progress: &dyn Progress,
) -> Result<(Kind, NoiseField), Cancelled> {
    let white = level.level.kind();
    let count = surface.positions().len();
    if settings.noise.is_some() || settings.kind == Some(Kind::None) {
        let sigma = settings.noise.filter(|_| settings.kind != Some(Kind::None)).unwrap_or(0.0);
        let kind = settings.kind.unwrap_or(if white == Kind::None && sigma > 0.0 { Kind::Independent } else { white });
        let stiffness = match settings.noise_across {
            Some(tangential) => noise_level::tangential_stiffness(sigma, tangential),
            None => level.level.tangential_stiffness(kind),
        };
        return Ok((kind, NoiseField::uniform(count, sigma, level.mean_edge, stiffness)));
    }
    let fine = level.level.fine * level.mean_edge;
    let is_white = matches!(white, Kind::Independent | Kind::Uneven);
    let is_depth = is_range_image(surface);
    if white == Kind::Correlated && settings.kind.is_none() && is_depth {
        if let Some(noise) = NoiseField::terraces(surface, connectivity, fine) {
            return Ok((white, noise));
        }
        let sigma = level.level.sigma_as(white);
        return Ok((white, NoiseField::uniform(count, sigma, level.mean_edge, 0.0)));
    }
    // A few hundred vertices are too few regions for the trees, and their coarse band is the curvature of the shape.
    const FEW: usize = 400;
    let is_rounding = || NoiseField::is_rounding(surface, connectivity, fine);
    // White noise is told from a surface most surely by the finest band of the whole mesh, unless the trees say that it is none: rounding
    // leaves no doubt, and the trees have seen few depth images. All other noise is told by the trees.
    let verdict = match settings.kind {
        Some(kind) if kind == white && is_white => Verdict::SurelyWhite,
        Some(_) => Verdict::Noisy,
        None if is_white && (is_depth || is_rounding()) => Verdict::SurelyWhite,
        None if is_white => Verdict::White,
        None if white == Kind::Correlated && count < FEW => Verdict::SurelyWhite,
        None if is_rounding() => Verdict::Noisy,
        None => Verdict::ByEvidence,
    };
    let mut noise = NoiseField::measured(surface, connectivity, verdict, progress)?;
    let is_white = matches!(verdict, Verdict::White | Verdict::SurelyWhite);
    if white == Kind::Uneven && is_white && is_depth {
        // The medians of the regions are too low where the noise of a depth camera is uneven, as one real frame showed; the tail of
        // the whole mesh is not.
        let typical = noise.typical() * noise.mean_edge();
        if typical > 0.0 {
            noise = noise.scaled((level.level.sigma_as(white) * level.mean_edge / typical).max(1.0));
        }
    } else {
        noise = bounded_by_lines(surface, connectivity, noise);
    }
    if noise.unmeasured == 1.0 && is_white {
        // A mesh of a few dozen vertices has no regions, but a finest band.
        let stiffness = level.level.tangential_stiffness(white);
        noise = NoiseField::uniform(count, level.level.sigma_as(white), level.mean_edge, stiffness);
    }
    if let Some(tangential) = settings.noise_across {
        let stiffness = noise_level::tangential_stiffness(noise.typical(), tangential);
        noise.stiffness.fill(stiffness);
    }
    let kind = settings.kind.unwrap_or(match white {
        _ if noise.noisy_fraction() == 0.0 => Kind::None,
        _ if noise.correlation > 0 => Kind::Correlated,
        Kind::Uneven => Kind::Uneven,
        _ => Kind::Independent,
    });
    Ok((kind, noise))
}

/// The noise, or what can be of it where it would be more than twice as rough as the surface is along its smoothest lines: what is rough
/// across folds alone is the folds. Not for depth images, whose rows have noise of their own.
fn bounded_by_lines(surface: &Surface, connectivity: &Connectivity, noise: NoiseField) -> NoiseField {
    /// Ratio below which the noise was not what was measured. On 160 meshes from `training/shapes.py` with noise of eleven kinds it was
    /// at least 0.59; on pleats in light noise it is 0.02 to 0.55.
    const CONTRADICTED: f64 = 0.5;
    let factor = lines::roughness(surface, connectivity, &noise).unwrap_or(1.0);
    if factor < CONTRADICTED { noise.scaled(factor) } else { noise }
}

#[cfg(test)]
mod tests;
