//! Noise that the automatic method assumes: that of the settings, or else as measured.

use super::Auto;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::{NoiseField, Verdict};
use crate::denoise::noise_level::{self, Kind, NoiseEstimate};
use crate::mesh::jagged::Index;
use crate::mesh::normals;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// True for a triangulated depth image: nearly all vertices have six neighbours, and nearly all faces look to one side. There the
/// two bands of the whole mesh tell shared noise from a surface; on other meshes the second one is mostly surface.
fn is_range_image(surface: &Surface) -> bool {
    /// Largest standard deviation of the valence.
    const LARGEST: f64 = 0.72;
    /// Least fraction of the faces that look to the side of their mean. On closed surfaces it is a half; noise turns some of any.
    const FACING: f64 = 0.75;
    let topology = surface.topology();
    let inner = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_boundary(v) && !topology.is_isolated(v));
    let (count, sum, squares) = inner
        .map(|v| topology.rings().get(v).len() as f64)
        .fold((0.0, 0.0, 0.0), |(n, s, q), x| (n + 1.0, s + x, q + x * x));
    let is_grid = count > 0.0 && squares / count - (sum / count).powi(2) < LARGEST * LARGEST;
    let normals: Vec<DVec3> = normals::face_normals(surface);
    let mean: DVec3 = normals.iter().sum();
    let facing = normals.iter().filter(|n| n.dot(mean) > 0.0).count();
    is_grid && facing as f64 > FACING * normals.len() as f64
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
    // White noise is told from a surface most surely by the finest band of the whole mesh, all other noise by the networks.
    let is_white = matches!(white, Kind::Independent | Kind::Uneven);
    if white == Kind::Correlated && settings.kind.is_none() && is_range_image(surface) {
        if let Some(noise) = NoiseField::terraces(surface, connectivity, fine) {
            return Ok((white, noise));
        }
        let sigma = level.level.sigma_as(white);
        return Ok((white, NoiseField::uniform(count, sigma, level.mean_edge, 0.0)));
    }
    // A few hundred vertices are too few regions for the networks, and their coarse band is the curvature of the shape.
    const FEW: usize = 400;
    let is_white = is_white || white == Kind::Correlated && settings.kind.is_none() && count < FEW;
    let verdict = if is_white && settings.kind.is_none_or(|kind| kind == white) {
        Verdict::White
    } else if settings.kind.is_some() || NoiseField::is_rounding(surface, connectivity, fine) {
        Verdict::Noisy
    } else {
        Verdict::ByEvidence
    };
    let mut noise = NoiseField::measured(surface, connectivity, verdict, progress)?;
    if white == Kind::Uneven && verdict == Verdict::White && is_range_image(surface) {
        // The medians of the regions are too low where the noise of a depth camera is uneven, as one real frame showed; the tail of
        // the whole mesh is not.
        let typical = noise.typical() * noise.mean_edge();
        if typical > 0.0 {
            noise = noise.scaled((level.level.sigma_as(white) * level.mean_edge / typical).max(1.0));
        }
    }
    if noise.unmeasured == 1.0 && verdict == Verdict::White {
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
