//! The search for what is around a face: faces near it, and clusters farther off.

use super::fields::FaceFields;
use super::{FILTERS, MOST_CLUSTERS, MOST_FACES, REACH, SCALES, WIDE, WIDE_REACH, WIDEST};
use crate::denoise::learned::around::{Around, CAPACITY, List, put, scale_by, write_exp, write_fourth_power};
use crate::mesh::jagged::Index;
use glam::Vec3;

/// Room for what is around one face.
pub(in crate::denoise::learned) struct Scratch {
    /// Number of the last search that reached each face and each cluster.
    pub(super) reached: [Vec<u32>; 3],
    /// Number of the search.
    pub(super) search: u32,
    pub(super) queue: Vec<Index>,
    pub(super) around: Box<Around>,
    pub(super) weights: Box<[List; SCALES]>,
    pub(super) range: Box<[List; FILTERS]>,
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

impl FaceFields<'_> {
    /// Finds the faces around a face: its neighbours over vertices, and what is reached from them over edges.
    #[inline(always)]
    pub(super) fn gather_faces(&self, face: usize, scratch: &mut Scratch) {
        let Scratch { reached: [reached, ..], search, queue, around, .. } = scratch;
        reached.resize(self.len(), 0);
        *search += 1;
        let row = self.rows[face];
        let own = row.centroid;
        let reach = (REACH * WIDEST * self.scales[face]).powi(2);
        let adjacency = self.of.adjacency;
        let near = |order: usize, f: Index| (if order == 0 { &adjacency.by_vertex } else { &adjacency.by_edge }).get(f);
        let is_in_reach = |f: Index| self.rows[f as usize].centroid.distance_squared(own) < reach;
        let found = breadth_first(face as Index, MOST_FACES, reached, *search, queue, near, is_in_reach);
        for (k, &g) in found.iter().enumerate() {
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
        around.close(found.len());
    }

    /// Weights of the faces around a face at each scale: area times a Gaussian of the distance.
    #[inline(always)]
    pub(super) fn weigh_faces(&self, face: usize, scratch: &mut Scratch) {
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
    pub(super) fn gather_clusters(&self, face: usize, index: usize, filtered: Vec3, scratch: &mut Scratch) {
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
        let near = |_: usize, cluster: Index| level.neighbours.get(cluster);
        let is_in_reach = |cluster: Index| level.centroids[cluster as usize].distance_squared(own) < reach;
        let found = breadth_first(start, MOST_CLUSTERS, reached, *search, queue, near, is_in_reach);
        let guidance = self.rows[face].guidance;
        for (k, &g) in found.iter().enumerate() {
            let g = g as usize;
            put(&mut around.normals, k, level.normals[g]);
            let offset = level.centroids[g] - own;
            put(&mut around.offsets, k, offset);
            around.areas[k] = level.areas[g];
            around.distances[k] = offset.length_squared();
            around.differences[0][k] = level.guidance[g].distance_squared(guidance);
            around.differences[1][k] = level.guidance[g].distance_squared(filtered);
        }
        around.close(found.len());
        let blocks = around.blocks();
        write_exp(blocks, &mut weights[0], &around.distances, 1.0 / (2.0 * deviation * deviation));
        scale_by(blocks, &mut weights[0], &around.areas);
    }
}

/// Searches from `start` over what is `near` the n-th that was found, and takes what is in reach until there are `most`, the nearest in
/// steps first. `reached` holds the number of the last search that came by. Returns what was found, in `room`.
///
/// Whether a neighbour is new is as good as random, so nothing branches on it.
#[inline(always)]
fn breadth_first<'a>(
    start: Index,
    most: usize,
    reached: &mut [u32],
    search: u32,
    room: &'a mut Vec<Index>,
    near: impl Fn(usize, Index) -> &'a [Index],
    is_in_reach: impl Fn(Index) -> bool,
) -> &'a [Index] {
    reached[start as usize] = search;
    room.resize(room.len().max(2 * most), 0);
    room[0] = start;
    let (mut count, mut next) = (1, 0);
    while next < count && count < most {
        let candidates = near(next, room[next]);
        if room.len() < count + candidates.len() {
            room.resize(count + candidates.len(), 0);
        }
        let free = &mut room[count..count + candidates.len()];
        let mut taken = 0;
        for &g in candidates {
            let is_new = std::mem::replace(&mut reached[g as usize], search) != search;
            free[taken] = g;
            taken += usize::from(is_new & is_in_reach(g));
        }
        count += taken;
        next += 1;
    }
    let found = &room[..count.min(most)];
    // What the compiler then knows of every index of a list.
    assert!(found.len() <= CAPACITY, "a list has room for all");
    found
}
