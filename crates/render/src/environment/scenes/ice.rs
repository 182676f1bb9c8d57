//! Floes on a polar sea.

use super::{cirrus, smoothstep, to_sun};
use crate::environment::gradient_noise::{cells, fractal, gradient};
use crate::environment::sky::Sky;
use crate::environment::terrain::{Landscape, normal, sunlit};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Reflectance of snow, linear RGB.
const SNOW: Vec3 = Vec3::new(0.90, 0.93, 0.96);
/// Reflectance of deep water, linear RGB.
const WATER: Vec3 = Vec3::new(0.004, 0.018, 0.028);
const BARE_ICE: Vec3 = Vec3::new(0.30, 0.58, 0.68);
/// Diameter of a floe, metres.
const FLOE: f32 = 16.0;

pub(super) struct Ice {
    pub(super) sky: Sky,
    ambient: Vec3,
}

impl Ice {
    pub(super) fn new() -> Self {
        let sky = Sky::new(to_sun(75.0, 14.0), 0.6, 5.6);
        let ambient = sky.ambient();
        Self { sky, ambient }
    }

    /// Distance to the edge of the floe that a position is on, metres; negative on water.
    fn inside(position: Vec2, footprint: f32) -> (f32, u32) {
        let warp = Vec2::new(
            fractal(position / 7.0, 4, footprint / 7.0, 20),
            fractal(position / 7.0 + 30.0, 4, footprint / 7.0, 21),
        );
        let (first, second, id) = cells(position / FLOE + 0.16 * warp + 0.45, 22);
        // Leads open and close.
        let lead = 0.30 + 0.55 * smoothstep(-0.25, 0.5, gradient(position / 60.0, 23));
        (0.5 * FLOE * (second - first) - lead, id)
    }

    /// Table icebergs and the coast, far off.
    fn far(position: Vec2, footprint: f32) -> f32 {
        let distance = position.length();
        if distance < 150.0 {
            return 0.0;
        }
        let warp = Vec2::new(
            fractal(position / 90.0, 3, footprint / 90.0, 24),
            fractal(position / 90.0 + 8.0, 3, footprint / 90.0, 25),
        );
        let (first, _, id) = cells(position / 330.0 + 0.12 * warp, 26);
        let mut height = 0.0;
        if id % 7 == 0 {
            let rough = 1.0 + 0.25 * fractal(position / 40.0, 4, footprint / 40.0, 27);
            height = (12.0 + (id / 7 % 15) as f32)
                * rough
                * smoothstep(0.20, 0.16, first)
                * smoothstep(150.0, 200.0, distance);
        }
        if distance > 3_000.0 {
            let ridge = 1.0 - 1.9 * fractal(position / 2_600.0, 5, 0.01, 28).abs();
            let coast = smoothstep(3_400.0, 7_000.0, distance)
                * smoothstep(-0.30, 0.35, gradient(position / 5_000.0 + 3.3, 29));
            height += 800.0 * coast * ridge.max(0.0).powi(2);
        }
        height
    }
}

impl Landscape for Ice {
    fn eye(&self) -> f32 {
        2.4
    }

    fn height(&self, position: Vec2, footprint: f32) -> f32 {
        let far = Self::far(position, footprint);
        if far > 1.0 {
            return far;
        }
        let (inside, id) = Self::inside(position, footprint);
        let freeboard = (0.25 + 0.2 * ((id >> 8) & 0xff) as f32 / 255.0) * smoothstep(-0.02, 0.14, inside);
        // Where floes are pushed together, blocks pile up along the edge.
        let pushed = smoothstep(0.1, 0.45, gradient(position / 23.0, 30))
            * smoothstep(1.6, 0.2, inside)
            * smoothstep(0.0, 0.2, inside);
        let blocks = 0.75 * pushed * (0.4 + fractal(position / 0.9, 4, footprint / 0.9, 31)).max(0.0);
        // Wind draws snow into long drifts.
        let wind = Vec2::from_angle(0.5).rotate(position);
        let warp = 0.5 * fractal(position / 3.0, 3, footprint / 3.0, 32);
        let drift = 0.30 * fractal(Vec2::new(wind.x / 5.5, wind.y / 1.5 + warp), 5, footprint / 1.5, 33)
            + 0.035 * fractal(Vec2::new(wind.x / 0.8, wind.y / 0.22), 4, footprint / 0.22, 34);
        freeboard + far + smoothstep(0.0, 1.2, inside) * (drift + 0.04) + blocks
    }

    fn ground(&self, position: Vec2, footprint: f32, direction: Vec3) -> Vec3 {
        let (inside, _) = Self::inside(position, footprint);
        let far = Self::far(position, footprint);
        let horizon = self.sky(Vec3::new(direction.x, 0.015, direction.z).normalize());
        let n = normal(self, position, footprint);
        let solid = smoothstep(-0.03 - footprint, 0.03 + footprint, inside).max(smoothstep(0.5, 1.0, far));
        let sun = self.sky.sun * n.dot(self.sky.to_sun).max(0.0) * sunlit(self, position, self.sky.to_sun, footprint);
        let bounce = 0.5 * SNOW * (self.ambient + self.sky.sun * self.sky.to_sun.y / PI);
        let light = sun / PI + (0.5 + 0.5 * n.y) * self.ambient + (0.5 - 0.5 * n.y + 0.05) * bounce;
        // Steep sides are bare and blue.
        let steep = smoothstep(0.80, 0.45, n.y);
        let snow = SNOW.lerp(BARE_ICE, 0.75 * steep) * light;

        let wave = |seed| 0.05 * fractal(position / 0.35, 3, footprint / 0.35, seed);
        let water_normal = Vec3::new(wave(35), 1.0, wave(36)).normalize();
        let mirrored = direction - 2.0 * direction.dot(water_normal) * water_normal;
        let fresnel = 0.02 + 0.98 * (1.0 - (-direction.dot(water_normal)).clamp(0.0, 1.0)).powi(5);
        let mirrored = self.sky(Vec3::new(mirrored.x, mirrored.y.abs(), mirrored.z));
        let water = WATER.lerp(mirrored, fresnel);

        let air = 1.0 - (-position.length() / 9_000.0).exp();
        water.lerp(snow, solid).lerp(horizon, air)
    }

    fn sky(&self, direction: Vec3) -> Vec3 {
        let cloud = 0.8 * cirrus(direction, 0.22, 70);
        self.sky.at(direction).lerp(0.17 * self.sky.sun + 0.9 * self.ambient, cloud)
    }
}
