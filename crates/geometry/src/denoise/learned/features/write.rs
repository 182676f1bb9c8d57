//! The features of a face, written in its frame.

use super::fields::FaceFields;
use super::search::Scratch;
use super::{FILTERS, SCALES, WIDE_FILTERS};
use crate::denoise::learned::around::{NO_SUMS, totals, weighted_product, weighted_sum, write_exp, write_fourth_power};
use crate::denoise::learned::simd::vectorised;
use glam::{Mat3, Vec3};

impl FaceFields<'_> {
    /// Writes the features of a face, and returns its frame: unit vectors as columns, possibly left-handed.
    pub(in crate::denoise::learned) fn write(&self, face: usize, scratch: &mut Scratch, out: &mut [f32]) -> Mat3 {
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
        let mut sums = [[NO_SUMS; FILTERS]; SCALES];
        for s in 0..SCALES {
            for k in 0..FILTERS {
                weighted_sum(blocks, &weights[s], &range[k], &around.normals, &mut sums[s][k]);
            }
        }
        let sums = sums.map(|filters| totals(&filters));
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
        let mut offsets = [NO_SUMS; 2];
        for (filter, sum) in [ones, &range[by_guidance]].into_iter().zip(&mut offsets) {
            weighted_sum(blocks, &weights[2], filter, &around.offsets, sum);
        }
        let offsets = totals(&offsets).map(|(sum, _)| sum);
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
            let mut lane_sums = [NO_SUMS; WIDE_FILTERS + 1];
            for k in 0..WIDE_FILTERS {
                weighted_sum(blocks, &weights[0], &range[k], &around.normals, &mut lane_sums[k]);
            }
            weighted_sum(blocks, &weights[0], &range[5], &around.offsets, &mut lane_sums[WIDE_FILTERS]);
            let totals = totals(&lane_sums);
            sums.copy_from_slice(&totals[..WIDE_FILTERS]);
            *offset = totals[WIDE_FILTERS].0;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_a_frame_are_those_of_the_normals_around_the_face() {
        for (k, first) in
            [Vec3::X, Vec3::Z, Vec3::new(0.6, -0.48, 0.64), Vec3::new(-0.1, 0.7, 0.7)].into_iter().enumerate()
        {
            let first = first.normalize();
            let spread = [Vec3::new(0.9, 0.1, 0.4), Vec3::new(0.2, -0.8, 0.3), Vec3::new(0.5, 0.1 * k as f32, -0.6)];
            let tensor = spread.iter().fold(Mat3::ZERO, |sum, n| sum + Mat3::from_cols(*n * n.x, *n * n.y, *n * n.z));
            let (wide, narrow) = (Vec3::new(0.3, 0.9, -0.2), Vec3::new(-0.8, 0.1, 0.4));
            let frame = frame(first, tensor, wide, narrow);
            let gap = frame.transpose() * frame - Mat3::IDENTITY;
            assert!(gap.to_cols_array().iter().all(|x| x.abs() < 1e-5), "{frame}");
            assert_eq!(frame.x_axis, first);
            // Across the normal, the second axis is that of most variance and the third that of least.
            let [second, third] = [frame.y_axis, frame.z_axis];
            assert!(second.dot(tensor * third).abs() < 1e-5, "{frame}");
            assert!(second.dot(tensor * second) > third.dot(tensor * third), "{frame}");
            assert!(second.dot(wide) >= 0.0 && third.dot(narrow) >= 0.0, "{frame}");
        }
    }
}
