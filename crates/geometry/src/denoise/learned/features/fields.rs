//! What the features of a mesh are made of: fields on its faces, and clusters of them.

use super::{BANDS, RADII};
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::learned::clusters::{Fine, Level};
use crate::denoise::learned::simd::exp;
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::{Index, Ragged};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Faces beside each face.
pub(in crate::denoise::learned) struct Adjacency {
    /// Faces that share a vertex, without the face itself. #T lists
    pub(in crate::denoise::learned) by_vertex: Ragged<Index>,
    /// Faces that share an edge. #T lists
    pub(in crate::denoise::learned) by_edge: Ragged<Index>,
}

impl Adjacency {
    /// Neighbours in a mesh whose faces have these centroids. #T×3
    pub(in crate::denoise::learned) fn of(mesh: &TriangleMesh, centroids: &[DVec3]) -> Self {
        Self { by_vertex: mesh.vertex_neighbours(centroids), by_edge: mesh.edge_neighbours() }
    }
}

/// A surface that was denoised in another way, for the network to compare with.
pub(in crate::denoise::learned) struct OtherSurface {
    /// Unit normals of its faces. #T×3
    pub(in crate::denoise::learned) normals: Vec<Vec3>,
    /// Centroids of its faces. #T×3
    pub(in crate::denoise::learned) centroids: Vec<Vec3>,
}

/// Parts that the features of a mesh are made of. All lengths are in mean edges of the mesh.
pub(in crate::denoise::learned) struct MeshFields<'a> {
    pub(in crate::denoise::learned) triangles: &'a [[Index; 3]],
    pub(in crate::denoise::learned) adjacency: &'a Adjacency,
    /// Current positions. #V×3
    pub(in crate::denoise::learned) positions: &'a [DVec3],
    /// Faces at the current positions.
    pub(in crate::denoise::learned) geometry: &'a FaceGeometry,
    /// Faces of the input.
    pub(in crate::denoise::learned) input: &'a FaceGeometry,
    /// Guidance normals, unit vectors. #T×3
    pub(in crate::denoise::learned) guidance: &'a [Vec3],
    /// Inconsistency of the patch at each face, and the least of those it belongs to. #T×2
    pub(in crate::denoise::learned) patch_scores: &'a [[f32; 2]],
    /// Surfaces to compare with.
    pub(in crate::denoise::learned) others: &'a [OtherSurface],
}

/// Numbers of a face that the search around another face reads, together in memory.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct FaceRow {
    pub(super) centroid: Vec3,
    /// Area, at least a thousandth of the mean.
    pub(super) area: f32,
    pub(super) normal: Vec3,
    /// Distance from the input along the normal.
    pub(super) moved: f32,
    /// Mean of the normals around the face.
    pub(super) smoothed: Vec3,
    /// |n − smoothed n|.
    pub(super) roughness: f32,
    pub(super) guidance: Vec3,
}

/// Fields on the faces of a mesh, ready to give features.
pub(in crate::denoise::learned) struct FaceFields<'a> {
    pub(super) of: MeshFields<'a>,
    pub(super) rows: Vec<FaceRow>,
    /// Length of the edges around each face, between a quarter and twice that of the mesh counting less.
    pub(super) scales: Vec<f32>,
    /// Doubled area over the square of the longest edge.
    pub(super) qualities: Vec<f32>,
    pub(super) smoothed_qualities: Vec<f32>,
    pub(super) median_roughness: f32,
    pub(super) input_normals: Vec<Vec3>,
    pub(super) input_centroids: Vec<Vec3>,
    pub(super) rms_moved: f32,
    pub(super) levels: [Level; 2],
    /// Median over the mesh of the difference of each face's normal between two scales.
    pub(super) median_bands: [f32; BANDS],
    /// Mean of them around each cluster of the upper level.
    pub(super) cluster_bands: Vec<[f32; BANDS]>,
}

/// Median of some numbers; 0 without any.
pub(super) fn median(mut values: Vec<f32>) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Means of some values over each face's neighbours, three times over. #T
fn smoothed_thrice(mut values: Vec<f32>, neighbours: &Ragged<Index>) -> Vec<f32> {
    for _ in 0..3 {
        let mean = |f: usize| {
            let near = neighbours.get(f as Index);
            let sum = near.iter().map(|&g| values[g as usize]).sum::<f32>();
            if near.is_empty() { values[f] } else { sum / near.len() as f32 }
        };
        values = (0..values.len()).into_par_iter().with_min_len(2048).map(mean).collect();
    }
    values
}

impl<'a> FaceFields<'a> {
    pub(in crate::denoise::learned) fn new(of: MeshFields<'a>) -> Self {
        let MeshFields { triangles, adjacency, positions, geometry, input, .. } = of;
        let single = |list: &[DVec3]| list.iter().map(|x| x.as_vec3()).collect::<Vec<Vec3>>();
        let (normals, centroids) = (single(&geometry.normals), single(&geometry.centroids));
        let (input_normals, input_centroids) = (single(&input.normals), single(&input.centroids));
        let areas: Vec<f32> = geometry.areas.iter().map(|area| *area as f32).collect();
        let (edges, qualities): (Vec<f32>, Vec<f32>) = triangles
            .par_iter()
            .zip(&geometry.areas)
            .with_min_len(2048)
            .map(|(t, area)| {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                let sides = [a.distance(b), b.distance(c), c.distance(a)];
                let longest = sides.into_iter().fold(0.0, f64::max);
                let quality = 2.0 * area / (longest * longest + 1e-30);
                ((sides.iter().sum::<f64>() / 3.0) as f32, quality as f32)
            })
            .unzip();
        let count = triangles.len().max(1) as f32;
        let mean_edge = (edges.iter().map(|e| f64::from(*e)).sum::<f64>() / f64::from(count)) as f32;
        let edges = smoothed_thrice(edges, &adjacency.by_vertex);
        let scale = |e: &f32| (e * e.clamp(0.25 * mean_edge, 2.0 * mean_edge)).sqrt().max(1e-6);
        let scales: Vec<f32> = edges.iter().map(scale).collect();
        let smoothed_qualities = smoothed_thrice(qualities.clone(), &adjacency.by_vertex);
        let mean_area = (areas.iter().map(|a| f64::from(*a)).sum::<f64>() / f64::from(count)) as f32;
        let areas: Vec<f32> = areas.iter().map(|a| a.max(1e-3 * mean_area).max(1e-12)).collect();
        let smooth = |f: usize| {
            let factor = 1.0 / (2.0 * scales[f] * scales[f]);
            let near = adjacency.by_vertex.get(f as Index).iter().map(|&g| g as usize);
            let weight = |g: usize| areas[g] * exp(-factor * centroids[g].distance_squared(centroids[f]));
            near.map(|g| normals[g] * weight(g)).sum::<Vec3>().normalize_or_zero()
        };
        let smoothed: Vec<Vec3> = (0..triangles.len()).into_par_iter().with_min_len(1024).map(smooth).collect();
        let roughness: Vec<f32> = normals.iter().zip(&smoothed).map(|(n, s)| n.distance(*s)).collect();
        let median_roughness = median(roughness.clone());
        let offset = |f: usize| (centroids[f] - input_centroids[f]).dot(normals[f]) / mean_edge;
        let moved: Vec<f32> = (0..triangles.len()).map(offset).collect();
        let squares = moved.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
        let rms_moved = (squares / f64::from(count)).sqrt() as f32;
        let guidance = of.guidance;
        let faces = Fine {
            areas: &areas,
            centroids: &centroids,
            normals: &normals,
            guidance,
            scales: &scales,
            neighbours: &adjacency.by_vertex,
        };
        let lower = Level::above(&faces, RADII[0]);
        let upper = Level::above(&lower.as_fine(), RADII[1]);
        let row = |f: usize| FaceRow {
            centroid: centroids[f],
            area: areas[f],
            normal: normals[f],
            moved: moved[f],
            smoothed: smoothed[f],
            roughness: roughness[f],
            guidance: guidance[f],
        };
        let mut fields = Self {
            of,
            rows: (0..triangles.len()).map(row).collect(),
            scales,
            qualities,
            smoothed_qualities,
            median_roughness,
            input_normals,
            input_centroids,
            rms_moved,
            levels: [lower, upper],
            median_bands: [0.0; BANDS],
            cluster_bands: Vec::new(),
        };
        fields.measure_bands();
        fields
    }

    /// Number of faces.
    pub(in crate::denoise::learned) fn len(&self) -> usize {
        self.of.triangles.len()
    }

    /// Unit normal of a face in the input; zero if it has no area.
    pub(in crate::denoise::learned) fn input_normal(&self, face: usize) -> Vec3 {
        self.input_normals[face]
    }

    /// Cluster of the upper level that a face belongs to.
    pub(super) fn wide_cluster(&self, face: usize) -> usize {
        self.levels[1].cluster_of[self.levels[0].cluster_of[face] as usize] as usize
    }
}
