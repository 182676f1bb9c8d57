//! Bilateral filter of the face normals, then vertices that follow.
//!
//! Youyi Zheng, Hongbo Fu, Oscar Kin-Chung Au, Chiew-Lan Tai. Bilateral normal filtering for mesh denoising. TVCG 17 (10),
//! 2011.
//!
//! The weight of face j for face i is wᵢⱼ = Aⱼ exp(−|cᵢ − cⱼ|² / 2σ_c²) exp(−|nᵢ − nⱼ|² / 2σ_s²): its area, how near it
//! is, how much it looks the same way. The local scheme takes nᵢ ← normalise Σⱼ wᵢⱼ nⱼ again and again (eq. 3); the
//! global one solves once for normals that equal the mean of their neighbours and stay near the input,
//! min (1 − λ) Σᵢ Aᵢ |nᵢ − Σⱼ wᵢⱼ nⱼ / Σⱼ wᵢⱼ|² + λ Σᵢ Aᵢ |nᵢ − nᵢ⁰|² (eq. 5), here with all Aᵢ of that sum alike as in
//! the code that the figures in the literature come from.

use super::Boundary;
use super::conjugate_gradients::{Solve, by_rows, solve};
use super::faces::{Faces, Shapes, filter};
use super::vertex_update::{Updater, VertexUpdate};
use crate::progress::{Cancelled, Progress};
use crate::ragged::{Index, Ragged};
use crate::sparse::Csr;
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::BilateralNormals`](super::Denoiser::BilateralNormals).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BilateralNormals {
    /// Steps of the local scheme; the global one takes none.
    pub iterations: u32,
    /// How normals are found.
    pub scheme: Scheme,
    /// λ of the global scheme, above 0 and at most 1: how near normals stay to the input.
    pub smoothness: f64,
    /// σ_c, in mean distances of the centroids of faces that share an edge.
    pub sigma_spatial: f64,
    /// σ_s: how far unit normals may differ and still be averaged.
    pub sigma_range: f64,
    /// Which faces are averaged.
    pub neighbours: Neighbours,
    /// How vertices follow.
    pub vertex_update: VertexUpdate,
}

/// How normals are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Step by step.
    #[default]
    Local,
    /// As the solution of one linear system.
    Global,
}

/// Which faces are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Neighbours {
    /// Those that share a vertex.
    #[default]
    Vertex,
    /// Those that share an edge.
    Edge,
}

impl BilateralNormals {
    /// σ_c one mean distance, σ_s = 0.35, 20 steps of the normals and 10 of the vertices.
    pub fn paper() -> Self {
        Self {
            iterations: 20,
            scheme: Scheme::Local,
            smoothness: 0.01,
            sigma_spatial: 1.0,
            sigma_range: 0.35,
            neighbours: Neighbours::Vertex,
            vertex_update: VertexUpdate::paper(10, Boundary::Fixed),
        }
    }
}

impl Default for BilateralNormals {
    /// As in the paper, with vertices that are held.
    fn default() -> Self {
        let paper = Self::paper();
        Self { vertex_update: paper.vertex_update.held(), ..paper }
    }
}

/// δ of the vertices that follow the filtered normals. #V×3, model units.
pub(super) fn deltas(
    surface: &Surface,
    settings: &BilateralNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let faces = Faces::of(surface);
    let mut updater = Updater::new(surface, &faces, settings.vertex_update);
    let shapes = Shapes::of(&faces, surface.positions());
    let normals = filtered(&faces, shapes, settings, progress)?;
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// The filtered normals. #T×3
fn filtered(
    faces: &Faces,
    shapes: Shapes,
    settings: &BilateralNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let neighbours = match settings.neighbours {
        Neighbours::Vertex => faces.by_vertex(),
        Neighbours::Edge => faces.by_edge(),
    };
    let near = spatial_weights(&neighbours, &shapes, settings.sigma_spatial * faces.spacing(&shapes));
    let falloff = -0.5 / (settings.sigma_range * settings.sigma_range);
    let mut normals = shapes.normals;
    let alike = |normals: &[DVec3], f: usize, g: usize| (normals[f].distance_squared(normals[g]) * falloff).exp();
    if settings.scheme == Scheme::Global {
        let weight = |f, place: usize, g| near[place] * alike(&normals, f, g);
        return global(&neighbours, &normals, weight, settings.smoothness, progress);
    }
    let mut next = normals.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        filter(&neighbours, &normals, &mut next, |f, place, g| near[place] * alike(&normals, f, g));
        std::mem::swap(&mut normals, &mut next);
        progress.done(f64::from(done) / f64::from(settings.iterations) / 2.0);
    }
    Ok(normals)
}

/// What does not change while the normals do: area and nearness of each neighbour of each face.
fn spatial_weights(neighbours: &Ragged<Index>, shapes: &Shapes, sigma: f64) -> Vec<f64> {
    let falloff = -0.5 / (sigma * sigma);
    let of_face = |f: usize| {
        neighbours.get(f as Index).iter().map(move |&g| {
            let distance = shapes.centroids[f].distance_squared(shapes.centroids[g as usize]);
            shapes.areas[g as usize] * (distance * falloff).exp()
        })
    };
    (0..neighbours.len()).into_par_iter().flat_map_iter(of_face).collect()
}

/// Solves ((1 − λ) MᵀM + λ) n = λ n⁰ with M = 1 − D⁻¹ W.
fn global(
    neighbours: &Ragged<Index>,
    normals: &[DVec3],
    weight: impl Fn(usize, usize, usize) -> f64,
    smoothness: f64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let mut triplets = Vec::with_capacity(neighbours.items().len() + normals.len());
    for f in 0..normals.len() {
        triplets.push((f as Index, f as Index, 1.0));
        let weights: Vec<f64> =
            neighbours.range(f as Index).map(|k| weight(f, k, neighbours.items()[k] as usize)).collect();
        let total: f64 = weights.iter().sum();
        if total > 0.0 {
            let row = neighbours.get(f as Index).iter().zip(weights);
            triplets.extend(row.map(|(&g, w)| (f as Index, g, -w / total)));
        }
    }
    let count = normals.len();
    let matrix = Csr::from_triplets(count, triplets.iter().copied());
    let transposed = Csr::from_triplets(count, triplets.iter().map(|&(f, g, w)| (g, f, w)));
    let squares = |f: usize| transposed.row(f as Index).iter().map(|e| e.1 * e.1).sum::<f64>();
    let diagonal: Vec<f64> = (0..count).map(|f| (1.0 - smoothness) * squares(f) + smoothness).collect();
    let system = |x: &[DVec3], out: &mut [DVec3]| {
        let away = matrix.times(x);
        by_rows(x, out, |f| (1.0 - smoothness) * transposed.row_times(f, &away) + smoothness * x[f])
    };
    let right: Vec<DVec3> = normals.iter().map(|n| smoothness * *n).collect();
    let solution = solve(system, &diagonal, &right, normals.to_vec(), Solve::default(), progress)?;
    Ok(solution.iter().zip(normals).map(|(x, n)| x.try_normalize().unwrap_or(*n)).collect())
}

#[cfg(test)]
mod tests;
