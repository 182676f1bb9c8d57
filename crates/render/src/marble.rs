//! Noise in three dimensions, for surfaces without texture coordinates. Twin of `shaders/noise.wgsl`.
//!
//! Ken Perlin. An image synthesizer. SIGGRAPH 1985. Improving noise. SIGGRAPH 2002. The table of permutations is a hash
//! of integers here, which has no period to show.

use glam::{IVec3, Vec3};

/// Number of octaves of the veins.
const OCTAVES: u32 = 4;

/// Strength of the veins at a point, 0..1.
pub(crate) fn vein(point: Vec3) -> f32 {
    let (mut sum, mut share, mut p) = (0.0, 1.0, point);
    for _ in 0..OCTAVES {
        sum += share * noise(p);
        share *= 0.5;
        p *= 2.0;
    }
    let near = (1.0 - 3.0 * sum.abs()).max(0.0);
    near * near
}

/// Smooth noise, about −1..1; 0 at all points with integer coordinates.
pub(crate) fn noise(point: Vec3) -> f32 {
    let cell = point.floor();
    let p = point - cell;
    let fade = p * p * p * (p * (p * 6.0 - 15.0) + 10.0);
    let corner = |x: i32, y: i32, z: i32| {
        let offset = IVec3::new(x, y, z);
        slope(cell.as_ivec3() + offset).dot(p - offset.as_vec3())
    };
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    let row = |y, z| mix(corner(0, y, z), corner(1, y, z), fade.x);
    let sheet = |z| mix(row(0, z), row(1, z), fade.y);
    mix(sheet(0), sheet(1), fade.z)
}

/// One of the twelve directions from a cube's middle to its edges.
fn slope(cell: IVec3) -> Vec3 {
    let hash = hash(cell);
    let sign = |bit: u32| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b) = (sign(0), sign(1));
    match (hash >> 2) % 3 {
        0 => Vec3::new(a, b, 0.0),
        1 => Vec3::new(a, 0.0, b),
        _ => Vec3::new(0.0, a, b),
    }
}

/// Mixes three integers: multiplications by odd numbers between shifts (as in MurmurHash3's finaliser).
fn hash(cell: IVec3) -> u32 {
    let [x, y, z] = cell.to_array().map(|i| i as u32);
    let mut h = x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_at_integers_and_smooth_between() {
        for i in -3..3 {
            assert_eq!(noise(Vec3::new(i as f32, 2.0, -i as f32)), 0.0);
        }
        let along = |t: f32| noise(Vec3::new(0.37 + t, 0.61 - 0.5 * t, 0.13 + 0.2 * t));
        let steps: Vec<f32> = (0..4000).map(|i| along(i as f32 * 1e-3)).collect();
        // No slope is steeper than the sum of a few gradients of length √2.
        assert!(steps.windows(2).all(|w| (w[1] - w[0]).abs() < 5e-3));
        let places = (0..4000).map(|i| i as f32 * Vec3::new(0.37, 0.61, 0.13));
        let (low, high) = places.map(noise).fold((0f32, 0f32), |(l, h), x| (l.min(x), h.max(x)));
        assert!(low < -0.6 && high > 0.6 && low > -1.1 && high < 1.1, "{low} {high}");
    }
}
