//! Gradient noise, the raw material of landscapes.
//!
//! Ken Perlin. Improving noise. SIGGRAPH 2002: a fifth-order blend of ramps at the corners of a grid. A hash of integers
//! takes the position of the table, so that nothing repeats.

use glam::{IVec2, Vec2};

/// Mixes the bits of a position; the constants are those of the finaliser of MurmurHash3.
fn hash(cell: IVec2, seed: u32) -> u32 {
    let mut h = (cell.x as u32).wrapping_mul(0x9e37_79b1) ^ (cell.y as u32).wrapping_mul(0x85eb_ca77) ^ seed;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// About −1..1, zero at the corners of the unit grid.
pub(super) fn gradient(p: Vec2, seed: u32) -> f32 {
    const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
    const RAMPS: [Vec2; 8] = [
        Vec2::X,
        Vec2::Y,
        Vec2::NEG_X,
        Vec2::NEG_Y,
        Vec2::splat(DIAGONAL),
        Vec2::splat(-DIAGONAL),
        Vec2::new(DIAGONAL, -DIAGONAL),
        Vec2::new(-DIAGONAL, DIAGONAL),
    ];
    let low = p.floor();
    let w = p - low;
    let cell = low.as_ivec2();
    let ramp = |x, y| {
        let corner = IVec2::new(x, y);
        RAMPS[(hash(cell + corner, seed) & 7) as usize].dot(w - corner.as_vec2())
    };
    let blend = w * w * w * (w * (6.0 * w - 15.0) + 10.0);
    let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
    1.5 * mix(mix(ramp(0, 0), ramp(1, 0), blend.x), mix(ramp(0, 1), ramp(1, 1), blend.x), blend.y)
}

/// Octaves of noise, each half as large and half as strong; those finer than `footprint` are left out, softly.
pub(super) fn fractal(p: Vec2, octaves: u32, footprint: f32, seed: u32) -> f32 {
    let mut sum = 0.0;
    let (mut frequency, mut strength) = (1.0, 0.5);
    for octave in 0..octaves {
        // Half a wave per footprint is the most that a picture can show.
        let seen = (2.0 - 2.0 * footprint * frequency).clamp(0.0, 1.0);
        if seen == 0.0 {
            break;
        }
        // Turned each time, so that the axes of the grids do not show.
        let turned = Vec2::from_angle(0.65 * octave as f32).rotate(p) * frequency;
        sum += seen * strength * gradient(turned, seed.wrapping_add(octave));
        frequency *= 2.0;
        strength *= 0.5;
    }
    sum
}

/// Distances to the nearest and the second nearest of points scattered one to a cell.
///
/// Steven Worley. A cellular texture basis function. SIGGRAPH 1996.
pub(super) fn cells(p: Vec2, seed: u32) -> (f32, f32, u32) {
    let cell = p.floor().as_ivec2();
    let (mut first, mut second, mut id) = (f32::INFINITY, f32::INFINITY, 0);
    for (x, y) in (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y))) {
        let corner = cell + IVec2::new(x, y);
        let h = hash(corner, seed);
        let jitter = Vec2::new((h & 0xffff) as f32, (h >> 16) as f32) / 65_536.0;
        let distance = p.distance(corner.as_vec2() + 0.1 + 0.8 * jitter);
        if distance < first {
            (second, first, id) = (first, distance, h);
        } else {
            second = second.min(distance);
        }
    }
    (first, second, id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_continuous_bounded_and_about_zero() {
        let positions = (0..40_000).map(|i| Vec2::new((i % 200) as f32, (i / 200) as f32) * 0.173 - 17.0);
        let (mut sum, mut most) = (0.0f64, 0.0f32);
        for p in positions {
            let n = gradient(p, 7);
            let step = (gradient(p + Vec2::splat(1e-3), 7) - n).abs();
            assert!(step < 0.02, "{p}: {step}");
            sum += f64::from(n);
            most = most.max(n.abs());
        }
        assert!((sum / 40_000.0).abs() < 0.02 && (0.5..1.5).contains(&most), "{sum} {most}");
    }

    #[test]
    fn what_is_finer_than_the_footprint_is_left_out() {
        let p = Vec2::new(3.3, -8.1);
        assert_eq!(fractal(p, 8, 1.0, 1), 0.0);
        assert_eq!(fractal(p, 8, 0.25, 1), fractal(p, 3, 0.25, 1), "octave 2 is the last that 0.25 shows");
    }
}
