//! Desert scene: dunes of sand.

use super::{cirrus, smoothstep, to_sun};
use crate::environment::gradient_noise::{fractal, gradient};
use crate::environment::sky::Sky;
use crate::environment::terrain::{Landscape, normal, sunlit};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Linear RGB of dry quartz sand with a little iron.
const SAND: Vec3 = Vec3::new(0.62, 0.41, 0.235);

pub(super) struct Desert {
    pub(super) sky: Sky,
    ambient: Vec3,
}

impl Desert {
    pub(super) fn new() -> Self {
        let sky = Sky::new(to_sun(-100.0, 26.0), 1.3, 5.0);
        let ambient = sky.ambient();
        Self { sky, ambient }
    }

    /// Small waves across the wind. They wander with the ground, and fade where a pixel cannot show them.
    fn ripples(position: Vec2, footprint: f32) -> f32 {
        let wave = |length: f32, height: f32, seed: u32| {
            let seen = (1.6 - 4.0 * footprint / length).clamp(0.0, 1.0);
            if seen == 0.0 {
                return 0.0;
            }
            let bent = position.x
                + 0.3 * position.y
                + 5.0 * length * fractal(position / (26.0 * length), 2, 0.0, seed)
                + 0.8 * length * gradient(position / (2.2 * length), seed + 1);
            let phase = (bent / length).rem_euclid(1.0);
            // Windward sides are long, lee sides short.
            let profile = if phase < 0.7 { phase / 0.7 } else { (1.0 - phase) / 0.3 };
            let strength = 0.6 + 0.8 * gradient(position / (14.0 * length), seed + 2);
            seen * strength * height * smoothstep(0.0, 1.0, profile)
        };
        wave(0.19, 0.014, 40) + wave(1.1, 0.022, 50)
    }
}

/// Ridges where noise is zero, with a long windward and a steep lee side.
fn ridges(position: Vec2, seed: u32) -> f32 {
    let n = gradient(position, seed);
    let crest = 1.0 - (n * n + 2e-4).sqrt();
    let side = if n > 0.0 { crest.powf(3.2) } else { crest.powf(1.7) };
    side.max(0.0)
}

impl Landscape for Desert {
    fn eye(&self) -> f32 {
        2.6
    }

    fn height(&self, position: Vec2, footprint: f32) -> f32 {
        let warp = Vec2::new(fractal(position / 160.0, 2, 0.0, 3), fractal(position / 160.0 + 40.0, 2, 0.0, 4));
        let p = position + 55.0 * warp;
        let distance = position.length();
        // The eye is on a plain between the dunes.
        let open = smoothstep(8.0, 90.0, distance);
        let high = 0.35 + 0.65 * smoothstep(-0.35, 0.45, gradient(position / 420.0 + 7.7, 5));
        let large = 27.0 * ridges(Vec2::new(p.x / 92.0, p.y / 170.0) + 3.1, 6) * high;
        let middle = 3.6 * ridges(Vec2::new(p.x / 25.0, p.y / 46.0) + 1.7, 7) * smoothstep(4.0, 60.0, distance);
        let swell = 0.9 * fractal(position / 14.0, 3, footprint / 14.0, 8);
        let ground = open * (large + middle - 3.0) + swell - 0.2;
        if footprint < 0.3 { ground + Self::ripples(position, footprint) } else { ground }
    }

    fn ground(&self, position: Vec2, footprint: f32, direction: Vec3) -> Vec3 {
        let n = normal(self, position, footprint);
        let sun = self.sky.sun * n.dot(self.sky.to_sun).max(0.0) * sunlit(self, position, self.sky.to_sun, footprint);
        // Grains of different kinds gather in streaks.
        let streak = 1.0
            + 0.16 * fractal(Vec2::new(position.x / 0.7, position.y / 2.4), 5, footprint / 0.7, 9)
            + 0.10 * fractal(position / 30.0, 3, footprint / 30.0, 10);
        let sand = SAND * streak * Vec3::new(1.0, 1.0 - 0.05 * (streak - 1.0), 1.0 - 0.1 * (streak - 1.0));
        let bounce = 0.35 * SAND * self.sky.sun * self.sky.to_sun.y / PI;
        let radiance = sand * (sun / PI + (0.5 + 0.5 * n.y) * self.ambient + (0.5 - 0.5 * n.y + 0.06) * bounce);
        let horizon = self.sky.at(Vec3::new(direction.x, 0.012, direction.z).normalize());
        radiance.lerp(horizon, 1.0 - (-position.length() / 2_600.0).exp())
    }

    fn sky(&self, direction: Vec3) -> Vec3 {
        let cloud = 0.35 * cirrus(direction, 0.05, 60);
        self.sky.at(direction).lerp(0.16 * self.sky.sun + 0.8 * self.ambient, cloud)
    }
}
