//! What the networks see of a face: filtered normals of many scales, and what the noise around it is like.
//!
//! All is in a frame of the face's own, in lengths of the edges around it, so that the features of a mesh that was moved, turned,
//! scaled or mirrored are the same. Most of them are means of normals with Gaussian weights of the distance and of the difference of
//! normals, as in bilateral filters. The means over 25 of them follow Wang et al. 2016, *Mesh Denoising via Cascaded Normal
//! Regression*; wide scales look at clusters of faces instead of faces.

use super::around::{
    Around, CAPACITY, List, put, scale_by, weighted_product, weighted_sum, write_exp, write_fourth_power,
};
use super::clusters::{Fine, Level};
use super::simd::{exp, vectorised};
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::{Index, Ragged};
use glam::{DVec3, Mat3, Vec3};
use rayon::prelude::*;

/// Deviation of the widest Gaussian over faces, in scales of the face; the other two are a half and a quarter of it.
const WIDEST: f32 = 2.8;
/// Reach of the search for faces, in deviations of the widest Gaussian.
const REACH: f32 = 1.7;
/// Largest number of faces that are looked at around a face.
pub(super) const MOST_FACES: usize = 180;
/// Largest number of clusters of each level that are looked at.
const MOST_CLUSTERS: usize = 96;
/// Deviations of the Gaussians over the two levels of clusters, in scales of the face.
const WIDE: [f32; 2] = [5.0, 10.0];
/// Reach of the search for clusters, in deviations.
const WIDE_REACH: f32 = 1.6;
/// Radii of the clusters of the two levels, in scales.
const RADII: [f32; 2] = [1.3, 3.0];
/// Filters over faces at each scale: without regard for normals, or with a Gaussian of the difference of the normals (three widths), of
/// the smoothed normals (three) or of the guidance (four).
const FILTERS: usize = 11;
/// Filters over clusters: without regard for normals, by the guidance (three widths), by the filtered normal of the face (four).
const WIDE_FILTERS: usize = 8;
/// Number of scales over faces.
const SCALES: usize = 3;
/// Number of candidate normals without those that are handed in.
const OWN_CANDIDATES: usize = SCALES * FILTERS + 3 + 2 * WIDE_FILTERS;
/// Differences of normals between scales.
const BANDS: usize = 5;
/// Number of features without those of normals that are handed in.
const OWN_FEATURES: usize =
    3 * OWN_CANDIDATES + SCALES * (FILTERS - 1) + 2 * (WIDE_FILTERS - 1) + 4 + SCALARS + 2 * BANDS;
const SCALARS: usize = 21;
/// Features that come with each further surface: its normal, and how far off it is.
const PER_SURFACE: usize = 4;
/// Fraction of the faces on which the differences between scales are measured: one in so many.
const STRIDE: usize = 4;

/// Number of features if `surfaces` further ones are handed in.
pub(super) fn feature_count(surfaces: usize) -> usize {
    OWN_FEATURES + PER_SURFACE * surfaces
}

/// Number of candidate normals if `surfaces` further ones are handed in.
pub(super) fn candidate_count(surfaces: usize) -> usize {
    OWN_CANDIDATES + surfaces
}

/// Candidate `k` among the `features` of a face, in its frame.
pub(super) fn candidate(features: &[f32], k: usize) -> Vec3 {
    let start = if k < OWN_CANDIDATES { 3 * k } else { OWN_FEATURES + PER_SURFACE * (k - OWN_CANDIDATES) };
    Vec3::from_slice(&features[start..])
}

/// Faces beside each face.
pub(super) struct Adjacency {
    /// Faces that share a vertex, without the face itself. #T lists
    pub(super) by_vertex: Ragged<Index>,
    /// Faces that share an edge. #T lists
    pub(super) by_edge: Ragged<Index>,
}

impl Adjacency {
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        Self { by_vertex: mesh.vertex_neighbours(), by_edge: mesh.edge_neighbours() }
    }
}

/// A surface that was denoised in another way, for the network to compare with.
pub(super) struct OtherSurface {
    /// Unit normals of its faces. #T×3
    pub(super) normals: Vec<Vec3>,
    /// Centroids of its faces. #T×3
    pub(super) centroids: Vec<Vec3>,
}

/// What the features of a mesh are made of. All lengths are in mean edges of the mesh.
pub(super) struct MeshFields<'a> {
    pub(super) triangles: &'a [[Index; 3]],
    pub(super) adjacency: &'a Adjacency,
    /// Current positions. #V×3
    pub(super) positions: &'a [DVec3],
    /// Faces at the current positions.
    pub(super) geometry: &'a FaceGeometry,
    /// Faces of the input.
    pub(super) input: &'a FaceGeometry,
    /// Guidance normals, unit vectors. #T×3
    pub(super) guidance: &'a [Vec3],
    /// Inconsistency of the patch at each face, and the least of those it belongs to. #T×2
    pub(super) patch_scores: &'a [[f32; 2]],
    /// Surfaces to compare with.
    pub(super) others: &'a [OtherSurface],
}

/// What the search around a face reads of each other face, together in memory.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct FaceRow {
    centroid: Vec3,
    /// Area, at least a thousandth of the mean.
    area: f32,
    normal: Vec3,
    /// Distance from the input along the normal.
    moved: f32,
    /// Mean of the normals around the face.
    smoothed: Vec3,
    /// |n − smoothed n|.
    roughness: f32,
    guidance: Vec3,
}

/// Fields on the faces of a mesh, ready to give features.
pub(super) struct FaceFields<'a> {
    of: MeshFields<'a>,
    rows: Vec<FaceRow>,
    /// Length of the edges around each face, between a quarter and twice that of the mesh counting less.
    scales: Vec<f32>,
    /// Doubled area over the square of the longest edge.
    qualities: Vec<f32>,
    smoothed_qualities: Vec<f32>,
    median_roughness: f32,
    input_normals: Vec<Vec3>,
    input_centroids: Vec<Vec3>,
    rms_moved: f32,
    levels: [Level; 2],
    /// Median over the mesh of the difference of each face's normal between two scales.
    median_bands: [f32; BANDS],
    /// Mean of them around each cluster of the upper level.
    cluster_bands: Vec<[f32; BANDS]>,
}

/// Room for what is around one face.
pub(super) struct Scratch {
    /// Number of the last search that reached each face and each cluster.
    reached: [Vec<u32>; 3],
    /// Number of the search.
    search: u32,
    queue: Vec<Index>,
    around: Box<Around>,
    weights: Box<[List; SCALES]>,
    range: Box<[List; FILTERS]>,
}

impl Default for Scratch {
    fn default() -> Self {
        let ones = [1.0; CAPACITY];
        Self {
            reached: Default::default(),
            search: 0,
            queue: Vec::new(),
            around: Box::new(Around::default()),
            weights: Box::new([[0.0; CAPACITY]; SCALES]),
            // The first one stays: it has no regard for normals.
            range: Box::new([ones; FILTERS]),
        }
    }
}

/// Median of some numbers; 0 without any.
fn median(mut values: Vec<f32>) -> f32 {
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

/// Number of faces that a thread treats at a time.
const CHUNK: usize = 512;

impl<'a> FaceFields<'a> {
    pub(super) fn new(of: MeshFields<'a>) -> Self {
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
    pub(super) fn len(&self) -> usize {
        self.of.triangles.len()
    }

    /// Unit normal of a face in the input; zero if it has no area.
    pub(super) fn input_normal(&self, face: usize) -> Vec3 {
        self.input_normals[face]
    }

    /// Cluster of the upper level that a face belongs to.
    fn wide_cluster(&self, face: usize) -> usize {
        self.levels[1].cluster_of[self.levels[0].cluster_of[face] as usize] as usize
    }

    /// Measures how much the normals change from each scale to the next.
    fn measure_bands(&mut self) {
        let stride = if self.len() < 2000 { 1 } else { STRIDE };
        let sampled: Vec<usize> = (0..self.len()).step_by(stride).collect();
        let bands: Vec<[f32; BANDS]> = sampled
            .par_iter()
            .with_min_len(CHUNK)
            .map_init(Scratch::default, |scratch, &face| {
                vectorised(
                    #[inline(always)]
                    || self.bands(face, scratch),
                )
            })
            .collect();
        self.median_bands = std::array::from_fn(|k| median(bands.iter().map(|band| band[k]).collect()));
        let upper = &self.levels[1];
        let mut sums = vec![([0.0f32; BANDS], 0.0f32); upper.areas.len()];
        for (&face, band) in sampled.iter().zip(&bands) {
            let (sum, count) = &mut sums[self.wide_cluster(face)];
            sum.iter_mut().zip(band).for_each(|(sum, x)| *sum += x);
            *count += 1.0;
        }
        let mean = |cluster: usize| {
            let (mut sum, mut count) = sums[cluster];
            for &beside in upper.neighbours.get(cluster as Index) {
                let (other, members) = &sums[beside as usize];
                sum.iter_mut().zip(other).for_each(|(sum, x)| *sum += 0.5 * x);
                count += 0.5 * members;
            }
            // A cluster so small that no face of it was sampled is like the mesh.
            if count > 0.0 { sum.map(|x| x / count) } else { self.median_bands }
        };
        self.cluster_bands = (0..sums.len()).map(mean).collect();
    }

    /// Differences of a face's normal between one scale and the next.
    #[inline(always)]
    fn bands(&self, face: usize, scratch: &mut Scratch) -> [f32; BANDS] {
        self.gather_faces(face, scratch);
        self.weigh_faces(face, scratch);
        let Scratch { around, weights, range, .. } = &*scratch;
        let mut scales = [self.rows[face].normal; BANDS + 1];
        for scale in 0..SCALES {
            let sum = weighted_sum(around.blocks(), &weights[scale], &range[0], &around.normals).0;
            scales[1 + scale] = sum.normalize_or_zero();
        }
        for level in 0..2 {
            self.gather_clusters(face, level, Vec3::ZERO, scratch);
            let Scratch { around, weights, range, .. } = &*scratch;
            let sum = weighted_sum(around.blocks(), &weights[0], &range[0], &around.normals).0;
            scales[1 + SCALES + level] = sum.normalize_or_zero();
        }
        let mut bands = [0.0; BANDS];
        for (k, band) in bands.iter_mut().enumerate() {
            *band = scales[k].distance(scales[k + 1]);
        }
        bands
    }

    /// Finds the faces around a face: its neighbours over vertices, and what is reached from them over edges.
    #[inline(always)]
    fn gather_faces(&self, face: usize, scratch: &mut Scratch) {
        let Scratch { reached: [reached, ..], search, queue, around, .. } = scratch;
        reached.resize(self.len(), 0);
        *search += 1;
        let row = self.rows[face];
        let own = row.centroid;
        let reach = (REACH * WIDEST * self.scales[face]).powi(2);
        queue.clear();
        queue.push(face as Index);
        reached[face] = *search;
        let mut next = 0;
        while next < queue.len() && queue.len() < MOST_FACES {
            let lists = if next == 0 { &self.of.adjacency.by_vertex } else { &self.of.adjacency.by_edge };
            for &g in lists.get(queue[next]) {
                let is_new = std::mem::replace(&mut reached[g as usize], *search) != *search;
                if is_new && self.rows[g as usize].centroid.distance_squared(own) < reach {
                    queue.push(g);
                }
            }
            next += 1;
        }
        queue.truncate(MOST_FACES);
        for (k, &g) in queue.iter().enumerate() {
            let other = &self.rows[g as usize];
            put(&mut around.normals, k, other.normal);
            put(&mut around.guidance, k, other.guidance);
            let offset = other.centroid - own;
            put(&mut around.offsets, k, offset);
            around.areas[k] = other.area;
            around.distances[k] = offset.length_squared();
            around.differences[0][k] = other.normal.distance_squared(row.normal);
            around.differences[1][k] = other.smoothed.distance_squared(row.smoothed);
            around.differences[2][k] = other.guidance.distance_squared(row.guidance);
            around.moved[k] = other.moved;
            around.roughness[k] = other.roughness;
        }
        around.close(queue.len());
    }

    /// Weights of the faces around a face at each scale: area times a Gaussian of the distance.
    #[inline(always)]
    fn weigh_faces(&self, face: usize, scratch: &mut Scratch) {
        let Scratch { around, weights, .. } = scratch;
        let [narrow, middle, wide] = &mut **weights;
        let blocks = around.blocks();
        let widest = WIDEST * self.scales[face];
        write_exp(blocks, wide, &around.distances, 1.0 / (2.0 * widest * widest));
        write_fourth_power(blocks, middle, wide);
        write_fourth_power(blocks, narrow, middle);
        scale_by(blocks, wide, &around.areas);
        scale_by(blocks, middle, &around.areas);
        scale_by(blocks, narrow, &around.areas);
    }

    /// Finds the clusters of a level around a face, with weights of area times a Gaussian of the distance. Differences are those of the
    /// guidance from that of the face and from `filtered`.
    #[inline(always)]
    fn gather_clusters(&self, face: usize, index: usize, filtered: Vec3, scratch: &mut Scratch) {
        let Scratch { reached, search, queue, around, weights, .. } = scratch;
        let level = &self.levels[index];
        let reached = &mut reached[1 + index];
        reached.resize(level.areas.len(), 0);
        *search += 1;
        let lower = self.levels[0].cluster_of[face];
        let start = if index == 0 { lower } else { self.levels[1].cluster_of[lower as usize] };
        let own = self.rows[face].centroid;
        let deviation = WIDE[index] * self.scales[face];
        let reach = (WIDE_REACH * deviation).powi(2);
        queue.clear();
        queue.push(start);
        reached[start as usize] = *search;
        let mut next = 0;
        while next < queue.len() && queue.len() < MOST_CLUSTERS {
            for &g in level.neighbours.get(queue[next]) {
                let is_new = std::mem::replace(&mut reached[g as usize], *search) != *search;
                if is_new && level.centroids[g as usize].distance_squared(own) < reach {
                    queue.push(g);
                }
            }
            next += 1;
        }
        queue.truncate(MOST_CLUSTERS);
        let guidance = self.rows[face].guidance;
        for (k, &g) in queue.iter().enumerate() {
            let g = g as usize;
            put(&mut around.normals, k, level.normals[g]);
            let offset = level.centroids[g] - own;
            put(&mut around.offsets, k, offset);
            around.areas[k] = level.areas[g];
            around.distances[k] = offset.length_squared();
            around.differences[0][k] = level.guidance[g].distance_squared(guidance);
            around.differences[1][k] = level.guidance[g].distance_squared(filtered);
        }
        around.close(queue.len());
        let blocks = around.blocks();
        write_exp(blocks, &mut weights[0], &around.distances, 1.0 / (2.0 * deviation * deviation));
        scale_by(blocks, &mut weights[0], &around.areas);
    }

    /// Writes the features of a face, and returns its frame: unit vectors as columns, possibly left-handed.
    pub(super) fn write(&self, face: usize, scratch: &mut Scratch, out: &mut [f32]) -> Mat3 {
        vectorised(
            #[inline(always)]
            || self.write_inlined(face, scratch, out),
        )
    }

    #[inline(always)]
    fn write_inlined(&self, face: usize, scratch: &mut Scratch, out: &mut [f32]) -> Mat3 {
        /// Factor of the squared difference of normals for a Gaussian of deviation 0.64 and of 0.5.
        const RANGES: [f32; 3] = [1.0 / (2.0 * 0.64 * 0.64), 1.0 / (2.0 * 0.5 * 0.5), 1.0 / (2.0 * 0.64 * 0.64)];
        const TINY: f32 = 1e-20;
        let scale = self.scales[face];
        self.gather_faces(face, scratch);
        self.weigh_faces(face, scratch);
        let Scratch { around, weights, range, .. } = &mut *scratch;
        let blocks = around.blocks();
        for (first, last, differences) in [(1, 3, 0), (4, 6, 1), (7, 10, 2)] {
            write_exp(blocks, &mut range[first], &around.differences[differences], RANGES[differences]);
            for k in first..last {
                let [from, to] = range.get_disjoint_mut([k, k + 1]).expect("two different filters");
                write_fourth_power(blocks, to, from);
            }
        }
        // Closures that are handed to library functions would not be compiled for the widest vectors.
        let mut sums = [[(Vec3::ZERO, 0.0); FILTERS]; SCALES];
        for s in 0..SCALES {
            for k in 0..FILTERS {
                sums[s][k] = weighted_sum(blocks, &weights[s], &range[k], &around.normals);
            }
        }
        let by_guidance = 8;
        let usable = |n: Vec3| (n.length_squared() > 0.5).then_some(n);
        let unit = |(sum, _): (Vec3, f32)| usable(sum.normalize_or_zero());
        let first = unit(sums[1][by_guidance]).or(unit(sums[2][0])).unwrap_or(Vec3::Z);
        let filtered = unit(sums[2][by_guidance]).unwrap_or(first);
        let ones = &range[0];
        let [x, y, z] = &around.guidance;
        let [xx, xy, xz] = [
            weighted_product(blocks, &weights[2], x, x),
            weighted_product(blocks, &weights[2], x, y),
            weighted_product(blocks, &weights[2], x, z),
        ];
        let [yy, yz, zz] = [
            weighted_product(blocks, &weights[2], y, y),
            weighted_product(blocks, &weights[2], y, z),
            weighted_product(blocks, &weights[2], z, z),
        ];
        let tensor = Mat3::from_cols(Vec3::new(xx, xy, xz), Vec3::new(xy, yy, yz), Vec3::new(xz, yz, zz));
        let offsets = [
            weighted_sum(blocks, &weights[2], ones, &around.offsets).0,
            weighted_sum(blocks, &weights[2], &range[by_guidance], &around.offsets).0,
        ];
        let moved = weighted_product(blocks, &weights[1], &around.moved, &around.moved);
        let rough = [
            weighted_product(blocks, &weights[1], ones, &around.roughness),
            weighted_product(blocks, &weights[2], ones, &around.roughness),
        ];
        let count = around.count as f32;
        let mut wide = [([(Vec3::ZERO, 0.0); WIDE_FILTERS], Vec3::ZERO); 2];
        for (level, (sums, offset)) in wide.iter_mut().enumerate() {
            self.gather_clusters(face, level, filtered, scratch);
            let Scratch { around, weights, range, .. } = &mut *scratch;
            let blocks = around.blocks();
            for (first, last, differences) in [(1, 3, 0), (4, 7, 1)] {
                write_exp(blocks, &mut range[first], &around.differences[differences], RANGES[0]);
                for k in first..last {
                    let [from, to] = range.get_disjoint_mut([k, k + 1]).expect("two different filters");
                    write_fourth_power(blocks, to, from);
                }
            }
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum = weighted_sum(blocks, &weights[0], &range[k], &around.normals);
            }
            *offset = weighted_sum(blocks, &weights[0], &range[5], &around.offsets).0;
        }
        let frame = frame(first, tensor, sums[2][0].0, sums[0][0].0);
        let local = frame.transpose();
        let mut writer = Writer { out, next: 0 };
        let mean = |(sum, weight): (Vec3, f32)| sum / (weight + TINY);
        for filter in sums.iter().flatten() {
            writer.vector(local * mean(*filter));
        }
        let own = self.rows[face];
        for n in [own.normal, own.smoothed, own.guidance] {
            writer.vector(local * n);
        }
        for filter in wide.iter().flat_map(|(sums, _)| sums) {
            writer.vector(local * mean(*filter));
        }
        for filters in &sums {
            filters[1..].iter().for_each(|filter| writer.number(filter.1 / (filters[0].1 + TINY)));
        }
        for (filters, _) in &wide {
            filters[1..].iter().for_each(|filter| writer.number(filter.1 / (filters[0].1 + TINY)));
        }
        writer.number(offsets[0].dot(first) / (sums[2][0].1 * scale + TINY));
        writer.number(offsets[1].dot(first) / (sums[2][by_guidance].1 * scale + TINY));
        for (filters, offset) in &wide {
            writer.number(offset.dot(first) / (filters[5].1 * scale + TINY));
        }
        let total = sums[2][0].1 + TINY;
        for axis in [frame.x_axis, frame.y_axis, frame.z_axis] {
            writer.number((axis.dot(tensor * axis) / total).max(0.0).sqrt());
        }
        writer.number((scale + 1e-9).ln());
        writer.number((own.area / (scale * scale) + 1e-4).ln());
        writer.number(self.qualities[face]);
        writer.number(self.smoothed_qualities[face]);
        writer.number(self.median_roughness);
        writer.number((self.median_roughness + 1e-2).ln());
        writer.number(rough[0] / (sums[1][0].1 + TINY));
        writer.number(rough[1] / total);
        writer.number(own.roughness);
        let [own_score, best_score] = self.of.patch_scores[face];
        writer.number(best_score.sqrt());
        writer.number(own_score.sqrt());
        writer.number((moved / (sums[1][0].1 + TINY)).sqrt());
        writer.number(self.rms_moved);
        writer.number((own.centroid - self.input_centroids[face]).dot(first) / scale);
        writer.vector(local * self.input_normals[face]);
        writer.number(count.ln());
        self.median_bands.iter().for_each(|band| writer.number((band + 3e-3).ln()));
        self.cluster_bands[self.wide_cluster(face)].iter().for_each(|band| writer.number((band + 3e-3).ln()));
        for other in self.of.others {
            writer.vector(local * other.normals[face]);
            writer.number((other.centroids[face] - own.centroid).dot(first) / scale);
        }
        frame
    }
}

/// The frame of a face: its filtered normal, and the main axis of the normals around it. Signs are those for which `wide` and `narrow`
/// means of normals have no negative part.
#[inline(always)]
fn frame(first: Vec3, tensor: Mat3, wide: Vec3, narrow: Vec3) -> Mat3 {
    let across = if first.x.abs() < 0.6 { Vec3::X } else { Vec3::Y };
    let u = first.cross(across).normalize_or_zero();
    let v = first.cross(u);
    let (uu, uv, vv) = (u.dot(tensor * u), u.dot(tensor * v), v.dot(tensor * v));
    // Half the angle of (uu − vv, 2uv), without trigonometric functions, which differ between systems.
    let (x, y) = (uu - vv, 2.0 * uv);
    let length = (x * x + y * y).sqrt();
    let cosine = if length > 0.0 { ((1.0 + x / length) / 2.0).max(0.0).sqrt() } else { 1.0 };
    let sine = if length > 0.0 { ((1.0 - x / length) / 2.0).max(0.0).sqrt().copysign(y) } else { 0.0 };
    let second = u * cosine + v * sine;
    let third = first.cross(second);
    let second = if wide.dot(second) < 0.0 { -second } else { second };
    let third = if narrow.dot(third) < 0.0 { -third } else { third };
    Mat3::from_cols(first, second, third)
}

/// Writes features one after the other.
struct Writer<'a> {
    out: &'a mut [f32],
    next: usize,
}

impl Writer<'_> {
    #[inline(always)]
    fn number(&mut self, x: f32) {
        self.out[self.next] = x;
        self.next += 1;
    }

    #[inline(always)]
    fn vector(&mut self, x: Vec3) {
        self.number(x.x);
        self.number(x.y);
        self.number(x.z);
    }
}
