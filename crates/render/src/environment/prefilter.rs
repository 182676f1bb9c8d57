//! Mirror images on rough surfaces: the environment blurred with wider and wider lobes, one level of detail each.
//!
//! Bruce Walter, Stephen Marschner, Hongsong Li, Kenneth Torrance. Microfacet models for refraction through rough
//! surfaces. EGSR 2007 (the lobe, GGX). Brian Karis. Real shading in Unreal Engine 4. SIGGRAPH courses 2013 (one lobe for
//! all views: it is looked at along the normal). Jaroslav Křivánek, Mark Colbert. Real-time shading with filtered
//! importance sampling. EGSR 2008 (few samples suffice if each takes the mean over its share of the sphere).

use super::cube::CubeMap;
use glam::{Quat, Vec3};
use std::f32::consts::{PI, TAU};

/// Number of texels along a side of the last level.
const SMALLEST: usize = 8;

/// Levels of detail of roughness 0, …, 1 in even steps, each half the size of the one before.
pub(super) fn levels(environment: CubeMap) -> Vec<CubeMap> {
    let mut means = vec![environment];
    while means[means.len() - 1].size() >= 2 * SMALLEST {
        means.push(means[means.len() - 1].halved());
    }
    let last = means.len() - 1;
    let rough = |level: usize| {
        let lobe = lobe(level as f32 / last as f32, 32 << level.min(3), means[0].size());
        blurred(&means, &lobe, means[level].size())
    };
    let blurred: Vec<CubeMap> = (1..=last).map(rough).collect();
    means.truncate(1);
    means.extend(blurred);
    means
}

/// One sample about the z axis.
struct Sample {
    direction: Vec3,
    weight: f32,
    /// Level of detail of the mean radiance that the sample is looked up in.
    level: f32,
}

/// Directions that a rough mirror gathers from, if seen along its normal z; weights sum to 1.
fn lobe(roughness: f32, count: u32, size: usize) -> Vec<Sample> {
    let alpha = (roughness * roughness).max(1e-4);
    let texel = 4.0 * PI / (6 * size * size) as f32;
    let sample = |i: u32| {
        // Hammersley's points: even in one number, bit-reversed in the other.
        let (a, b) = ((i as f32 + 0.5) / count as f32, i.reverse_bits() as f32 * 2.0f32.powi(-32));
        // Equations 35 and 36 of Walter: the slope of a microfacet.
        let tan_squared = alpha * alpha * a / (1.0 - a);
        let cos_half = (1.0 + tan_squared).sqrt().recip();
        let sin_half = (1.0 - cos_half * cos_half).max(0.0).sqrt();
        let (sin, cos) = (b * TAU).sin_cos();
        let half = Vec3::new(sin_half * cos, sin_half * sin, cos_half);
        let direction = 2.0 * half.z * half - Vec3::Z;
        let denominator = cos_half * cos_half * (alpha * alpha - 1.0) + 1.0;
        let density = alpha * alpha / (PI * denominator * denominator) / 4.0;
        let share = 1.0 / (count as f32 * density);
        Sample { direction, weight: direction.z.max(0.0), level: (0.5 * (share / texel).log2() + 1.0).max(0.0) }
    };
    let mut samples: Vec<Sample> = (0..count).map(sample).filter(|s| s.weight > 0.0).collect();
    let sum: f32 = samples.iter().map(|s| s.weight).sum();
    for sample in &mut samples {
        sample.weight /= sum;
    }
    samples
}

fn blurred(means: &[CubeMap], lobe: &[Sample], size: usize) -> CubeMap {
    let mean = |direction: Vec3, level: f32| {
        let level = level.min((means.len() - 1) as f32);
        let finer = &means[level as usize];
        let coarser = &means[(level as usize + 1).min(means.len() - 1)];
        finer.at(direction).lerp(coarser.at(direction), level.fract())
    };
    CubeMap::from_fn(size, |normal| {
        let rotation = Quat::from_rotation_arc(Vec3::Z, normal);
        lobe.iter().map(|s| s.weight * mean(rotation * s.direction, s.level)).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_environment_stays_even() {
        for level in levels(CubeMap::from_fn(64, |_| Vec3::new(0.25, 1.0, 3.0))) {
            for texel in level.texels() {
                assert!(texel.abs_diff_eq(Vec3::new(0.25, 1.0, 3.0), 1e-4), "{}: {texel}", level.size());
            }
        }
    }

    #[test]
    fn the_first_level_is_the_environment_and_sizes_halve() {
        let cube = CubeMap::from_fn(64, Vec3::abs);
        let levels = levels(cube.clone());
        assert_eq!(levels[0], cube);
        assert_eq!(levels.iter().map(CubeMap::size).collect::<Vec<_>>(), [64, 32, 16, 8]);
    }

    #[test]
    fn the_rougher_the_wider() {
        let lamp = Vec3::new(0.2, 0.9, 0.4).normalize();
        let cube = CubeMap::from_fn(128, |d| if d.dot(lamp) > 0.998 { Vec3::splat(50.0) } else { Vec3::ZERO });
        let levels = levels(cube);
        let beside = (lamp + 0.8 * lamp.any_orthonormal_vector()).normalize();
        for pair in levels.windows(2).skip(1) {
            assert!(pair[1].at(lamp).x < pair[0].at(lamp).x, "dimmer in the middle");
            let share = |level: &CubeMap| level.at(beside).x / level.at(lamp).x;
            assert!(share(&pair[1]) > share(&pair[0]), "and brighter beside, relative to it");
        }
        let share = levels[1].at(beside).x / levels[1].at(lamp).x;
        assert!(share < 0.02, "little yet at the least roughness: {share}");
    }
}
