//! Bilateral normal filter: face normals are averaged over near neighbours with similar normals, then vertices follow.
//!
//! Youyi Zheng, Hongbo Fu, Oscar Kin-Chung Au, Chiew-Lan Tai. Bilateral normal filtering for mesh denoising. TVCG 17 (10),
//! 2011.
//!
//! The weight of face j for face i is wᵢⱼ = Aⱼ exp(−|cᵢ − cⱼ|² / 2σ_c²) exp(−|nᵢ − nⱼ|² / 2σ_s²): its area, its nearness,
//! and the similarity of its normal. The local scheme iterates nᵢ ← normalise Σⱼ wᵢⱼ nⱼ (eq. 3). The global scheme solves
//! once for normals that equal the mean of their neighbours and stay near the input,
//! min (1 − λ) Σᵢ Aᵢ |nᵢ − Σⱼ wᵢⱼ nⱼ / Σⱼ wᵢⱼ|² + λ Σᵢ Aᵢ |nᵢ − nᵢ⁰|² (eq. 5). The areas Aᵢ of that sum are all taken as
//! equal, as in the code that produced the figures in the literature.

use super::boundary::Boundary;
use super::conjugate_gradients::{ConjugateGradients, Stop, multiply};
use super::face_geometry::{FaceGeometry, filter_normals};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::motion::Motion;
use super::parameters::{HUGE, Parameter, TINY};
use super::triangle_mesh::TriangleMesh;
use super::vertex_update::{self, Updater, VertexUpdate};
use crate::mesh::csr::Csr;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Progress};
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

named! {
    /// How filtered normals are found.
    #[derive(Default)]
    pub enum Scheme {
        /// In a number of steps.
        #[default]
        Local = "local",
        /// As the solution of one linear system.
        Global = "global",
    }
}

named! {
    /// Which faces are averaged.
    #[derive(Default)]
    pub enum Neighbours {
        /// Faces that share a vertex.
        #[default]
        Vertex = "vertex",
        /// Faces that share an edge.
        Edge = "edge",
    }
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

/// Parameters of the filter; those of the vertex update come on top.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of steps of the normals, with the local scheme"),
    Parameter::word::<Scheme>("scheme", "/scheme", "how filtered normals are found"),
    Parameter::number(
        "smoothness",
        "/smoothness",
        [TINY, 1.0],
        "how near normals stay to the input, with the global scheme",
    ),
    Parameter::word::<Neighbours>("neighbours", "/neighbours", "which faces are averaged").alias("neighbors"),
    SIGMA_SPATIAL,
    SIGMA_RANGE,
];

/// Parameter of the filters with a Gaussian of the distance.
pub(super) const SIGMA_SPATIAL: Parameter =
    Parameter::number("sigma-spatial", "/sigma_spatial", [TINY, HUGE], "reach of the filter")
        .label("σ spatial")
        .slider(4.0)
        .unit("mean distances of neighbouring faces");

/// Parameter of the filters with a Gaussian of the difference of normals.
pub(super) const SIGMA_RANGE: Parameter = Parameter::number(
    "sigma-range",
    "/sigma_range",
    [TINY, HUGE],
    "how far unit normals may differ and still be averaged",
)
.label("σ range")
.slider(1.5);

impl DenoiseMethod for BilateralNormals {
    const INFO: MethodInfo = MethodInfo {
        name: "bilateral-normals",
        summary: "Bilateral filter of the face normals: for sharp edges",
        reference: Some(Reference {
            cite: "Zheng et al. 2011",
            title: "Bilateral normal filtering for mesh denoising. TVCG 17 (10)",
        }),
        parameters: &[PARAMETERS, vertex_update::PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::paper())
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.vertex_update.motion)
    }
}

/// Filters the normals, lets the vertices follow and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(
    surface: &Surface,
    settings: &BilateralNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    progress.check()?;
    let mesh = TriangleMesh::of(surface);
    let mut updater = Updater::new(surface, &mesh, settings.vertex_update);
    let geometry = FaceGeometry::of(&mesh, surface.positions());
    let normals = filtered(&mesh, geometry, settings, progress)?;
    updater.follow(&normals, progress)?;
    Ok(updater.deltas())
}

/// Filters the face normals. #T×3
pub(super) fn filtered(
    mesh: &TriangleMesh,
    geometry: FaceGeometry,
    settings: &BilateralNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let neighbours = match settings.neighbours {
        Neighbours::Vertex => mesh.vertex_neighbours(&geometry.centroids),
        Neighbours::Edge => mesh.edge_neighbours(),
    };
    let sigma_spatial = settings.sigma_spatial * geometry.mean_centroid_distance(mesh);
    let spatial = spatial_weights(&neighbours, &geometry, sigma_spatial);
    let falloff = -0.5 / (settings.sigma_range * settings.sigma_range);
    let mut normals = geometry.normals;
    let range = |normals: &[DVec3], f: usize, g: usize| (normals[f].distance_squared(normals[g]) * falloff).exp();
    if settings.scheme == Scheme::Global {
        let weight = |f, k: usize, g| spatial[k] * range(&normals, f, g);
        return global(&neighbours, &normals, weight, settings.smoothness, progress);
    }
    let mut next = normals.clone();
    for done in 1..=settings.iterations {
        progress.check()?;
        filter_normals(&neighbours, &normals, &mut next, |f, k, g| spatial[k] * range(&normals, f, g));
        std::mem::swap(&mut normals, &mut next);
        progress.done(f64::from(done) / f64::from(settings.iterations) / 2.0);
    }
    Ok(normals)
}

/// Spatial weight of each neighbour of each face, its area times a Gaussian of its distance, in the order of the lists.
fn spatial_weights(neighbours: &Ragged<Index>, geometry: &FaceGeometry, sigma: f64) -> Vec<f64> {
    let falloff = -0.5 / (sigma * sigma);
    let of_face = |f: usize| {
        neighbours.get(f as Index).iter().map(move |&g| {
            let distance = geometry.centroids[f].distance_squared(geometry.centroids[g as usize]);
            geometry.areas[g as usize] * (distance * falloff).exp()
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
    let operator = |x: &[DVec3], out: &mut [DVec3]| {
        let differences = matrix.times(x);
        multiply(x, out, |f| (1.0 - smoothness) * transposed.row_times(f, &differences) + smoothness * x[f])
    };
    let right: Vec<DVec3> = normals.iter().map(|n| smoothness * *n).collect();
    let mut solver = ConjugateGradients::new(&diagonal);
    let solution = solver.solve_from(operator, normals.to_vec(), &right, Stop::default(), progress)?;
    Ok(solution.iter().zip(normals).map(|(x, n)| x.try_normalize().unwrap_or(*n)).collect())
}

#[cfg(test)]
mod tests;
