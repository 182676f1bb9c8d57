//! How much the normals of a mesh change from each scale to the next.

use super::fields::{FaceFields, median};
use super::search::Scratch;
use super::{BANDS, SCALES, STRIDE};
use crate::denoise::learned::around::{NO_SUMS, totals, weighted_sum};
use crate::denoise::learned::simd::vectorised;
use crate::mesh::jagged::Index;
use glam::Vec3;
use rayon::prelude::*;

/// Number of faces that a thread treats at a time.
const CHUNK: usize = 512;

impl FaceFields<'_> {
    /// Measures how much the normals change from each scale to the next.
    pub(super) fn measure_bands(&mut self) {
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
        let mut sums = [NO_SUMS; BANDS];
        for scale in 0..SCALES {
            weighted_sum(around.blocks(), &weights[scale], &range[0], &around.normals, &mut sums[scale]);
        }
        for level in 0..2 {
            self.gather_clusters(face, level, Vec3::ZERO, scratch);
            let Scratch { around, weights, range, .. } = &*scratch;
            weighted_sum(around.blocks(), &weights[0], &range[0], &around.normals, &mut sums[SCALES + level]);
        }
        let mut scales = [self.rows[face].normal; BANDS + 1];
        for (scale, (sum, _)) in scales[1..].iter_mut().zip(totals(&sums)) {
            *scale = sum.normalize_or_zero();
        }
        let mut bands = [0.0; BANDS];
        for (k, band) in bands.iter_mut().enumerate() {
            *band = scales[k].distance(scales[k + 1]);
        }
        bands
    }
}
