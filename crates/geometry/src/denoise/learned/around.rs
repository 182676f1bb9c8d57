//! What is around a face, as lists of numbers for sums over vector lanes.

use super::features::MOST_FACES;
use super::simd::{LANES, exp, total};
use glam::Vec3;

/// Numbers of what is around a face.
pub(super) type List = [f32; CAPACITY];
/// Room for faces or clusters, in whole lanes.
pub(super) const CAPACITY: usize = MOST_FACES.next_multiple_of(LANES);

/// Normals and weights of what is around a face, coordinate by coordinate, filled up with zeros to whole lanes.
pub(super) struct Around {
    pub(super) count: usize,
    pub(super) normals: [List; 3],
    pub(super) guidance: [List; 3],
    pub(super) offsets: [List; 3],
    pub(super) areas: List,
    pub(super) distances: List,
    /// Squared differences of normals, of smoothed normals and of the guidance; of clusters, those of the guidance from that of the face
    /// and from its filtered normal.
    pub(super) differences: [List; 3],
    pub(super) moved: List,
    pub(super) roughness: List,
}

impl Default for Around {
    fn default() -> Self {
        const ZERO: List = [0.0; CAPACITY];
        Self {
            count: 0,
            normals: [ZERO; 3],
            guidance: [ZERO; 3],
            offsets: [ZERO; 3],
            areas: ZERO,
            distances: ZERO,
            differences: [ZERO; 3],
            moved: ZERO,
            roughness: ZERO,
        }
    }
}

impl Around {
    /// Number of whole lanes.
    pub(super) fn blocks(&self) -> usize {
        self.count.div_ceil(LANES)
    }

    /// Fills up with zeros, which have no area and so no weight.
    #[inline(always)]
    pub(super) fn close(&mut self, count: usize) {
        self.count = count;
        for k in count..count.next_multiple_of(LANES) {
            self.areas[k] = 0.0;
            self.distances[k] = 0.0;
            for axis in 0..3 {
                self.normals[axis][k] = 0.0;
                self.guidance[axis][k] = 0.0;
                self.offsets[axis][k] = 0.0;
                self.differences[axis][k] = 0.0;
            }
            self.moved[k] = 0.0;
            self.roughness[k] = 0.0;
        }
    }
}

#[inline(always)]
pub(super) fn put(to: &mut [List; 3], k: usize, x: Vec3) {
    to[0][k] = x.x;
    to[1][k] = x.y;
    to[2][k] = x.z;
}

/// Lanes of a list, at one place.
#[inline(always)]
fn lanes(list: &List, block: usize) -> &[f32; LANES] {
    &list.as_chunks().0[block]
}

/// Sums lane by lane, which [`totals`] adds up: Σ wₖ rₖ xₖ for the three coordinates of vectors x, and Σ wₖ rₖ.
pub(super) type LaneSums = [[f32; LANES]; 4];

/// Room for the sums of a filter.
pub(super) const NO_SUMS: LaneSums = [[0.0; LANES]; 4];

/// Writes Σ wₖ rₖ xₖ for vectors x, and Σ wₖ rₖ.
#[inline(always)]
pub(super) fn weighted_sum(blocks: usize, weights: &List, range: &List, x: &[List; 3], out: &mut LaneSums) {
    let [mut sx, mut sy, mut sz, mut sw] = [[0.0f32; LANES]; 4];
    for block in 0..blocks {
        let (w, r) = (lanes(weights, block), lanes(range, block));
        let (x, y, z) = (lanes(&x[0], block), lanes(&x[1], block), lanes(&x[2], block));
        let mut product = [0.0; LANES];
        for lane in 0..LANES {
            product[lane] = w[lane] * r[lane];
        }
        add_product(&mut sx, &product, x);
        add_product(&mut sy, &product, y);
        add_product(&mut sz, &product, z);
        for lane in 0..LANES {
            sw[lane] += product[lane];
        }
    }
    *out = [sx, sy, sz, sw];
}

/// Adds the lanes of sums up. A function of its own: where the compiler sees the four sums of a vector added up, it computes them side by
/// side in registers of four numbers instead of sixteen.
#[inline(never)]
pub(super) fn totals<const N: usize>(sums: &[LaneSums; N]) -> [(Vec3, f32); N] {
    std::array::from_fn(|k| {
        let [x, y, z, w] = sums[k].map(total);
        (Vec3::new(x, y, z), w)
    })
}

#[inline(always)]
fn add_product(sum: &mut [f32; LANES], x: &[f32; LANES], y: &[f32; LANES]) {
    for lane in 0..LANES {
        sum[lane] += x[lane] * y[lane];
    }
}

/// Σ wₖ xₖ yₖ.
#[inline(always)]
pub(super) fn weighted_product(blocks: usize, weights: &List, x: &List, y: &List) -> f32 {
    let mut sum = [0.0f32; LANES];
    for block in 0..blocks {
        let (w, x, y) = (lanes(weights, block), lanes(x, block), lanes(y, block));
        for lane in 0..LANES {
            sum[lane] += w[lane] * x[lane] * y[lane];
        }
    }
    total(sum)
}

/// Writes exp(−factor·x).
#[inline(always)]
pub(super) fn write_exp(blocks: usize, out: &mut List, x: &List, factor: f32) {
    for block in 0..blocks {
        let x = lanes(x, block);
        let out = &mut out.as_chunks_mut::<LANES>().0[block];
        for lane in 0..LANES {
            out[lane] = exp(-factor * x[lane]);
        }
    }
}

/// Writes the fourth powers: Gaussians of half the width.
#[inline(always)]
pub(super) fn write_fourth_power(blocks: usize, out: &mut List, x: &List) {
    for block in 0..blocks {
        let x = lanes(x, block);
        let out = &mut out.as_chunks_mut::<LANES>().0[block];
        for lane in 0..LANES {
            let square = x[lane] * x[lane];
            out[lane] = square * square;
        }
    }
}

/// Replaces weights by themselves times areas.
#[inline(always)]
pub(super) fn scale_by(blocks: usize, weights: &mut List, areas: &List) {
    for block in 0..blocks {
        let areas = lanes(areas, block);
        let weights = &mut weights.as_chunks_mut::<LANES>().0[block];
        for lane in 0..LANES {
            weights[lane] *= areas[lane];
        }
    }
}
