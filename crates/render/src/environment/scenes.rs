//! Two landscapes that are made and not photographed, so that there is something to mirror without any file.

mod desert;
mod ice;

use super::equirect::Equirect;
use super::gradient_noise::fractal;
use super::sky::Sky;
use super::terrain::{Landscape, panorama};
use crate::settings::environment::Scene;
use glam::{Vec2, Vec3};

/// A disc of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction towards the sun.
    pub direction: Vec3,
    /// Irradiance of a surface that faces the sun, linear RGB.
    pub irradiance: Vec3,
}

/// Radius of the disc that stands for the sun, radians: twice the true one, so that half floats hold its radiance.
const RADIUS: f32 = 0.0093;

impl Sun {
    /// Radiance from a direction.
    pub fn at(&self, direction: Vec3) -> Vec3 {
        let angle = direction.cross(self.direction).length().atan2(direction.dot(self.direction));
        // A soft rim, half of it inside.
        let seen = (0.5 + 2.0 * (RADIUS - angle) / RADIUS).clamp(0.0, 1.0);
        seen * self.irradiance / (std::f32::consts::PI * RADIUS * RADIUS)
    }
}

impl Scene {
    /// Draws the panorama without the sun's disc, and returns the sun beside it.
    pub fn draw(self, height: usize) -> (Equirect, Sun) {
        match self {
            Self::Desert => draw(&desert::Desert::new(), height, |d| &d.sky),
            Self::Ice => draw(&ice::Ice::new(), height, |i| &i.sky),
        }
    }
}

fn draw<L: Landscape>(landscape: &L, height: usize, sky: impl Fn(&L) -> &Sky) -> (Equirect, Sun) {
    let sky = sky(landscape);
    (panorama(landscape, height), Sun { direction: sky.to_sun, irradiance: sky.sun })
}

/// Unit direction to the sun: azimuth to the right of ahead, degrees.
fn to_sun(azimuth: f32, elevation: f32) -> Vec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos())
}

/// Fraction of the sky that thin clouds cover in a direction, 0..1.
fn cirrus(direction: Vec3, amount: f32, seed: u32) -> f32 {
    // On a flat layer of cloud, far away near the horizon.
    let height = direction.y.max(0.0) + 0.06;
    let position = Vec2::new(direction.x, direction.z) / height;
    let drift = position
        + 0.7
            * Vec2::new(
                fractal(0.6 * position, 3, 0.02 / height, seed),
                fractal(0.6 * position + 9.0, 3, 0.02 / height, seed),
            );
    let strands = fractal(Vec2::new(0.5 * drift.x, 1.6 * drift.y), 6, 0.02 / height, seed + 17);
    let patches = 0.5 + fractal(0.35 * position, 2, 0.0, seed + 31);
    smoothstep(0.05, 0.75, strands + patches - 0.65 + amount) * smoothstep(0.01, 0.2, direction.y)
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let x = ((x - low) / (high - low)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENES: [Scene; 2] = [Scene::Desert, Scene::Ice];

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        for scene in SCENES {
            let on = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| scene.draw(24))
            };
            assert!(on(1) == on(3), "{scene:?}");
        }
    }

    #[test]
    fn radiance_is_finite_and_the_sky_is_above() {
        for scene in SCENES {
            let (map, _) = scene.draw(64);
            assert!(map.texels().iter().all(|t| t.is_finite() && t.min_element() >= 0.0), "{scene:?}");
            let blue = |d: Vec3| map.at(d).z / map.at(d).x;
            assert!(blue(Vec3::Y) > 1.3 && blue(Vec3::Y) > blue(Vec3::NEG_Y), "{scene:?}");
        }
    }

    #[test]
    fn there_is_no_seam_behind() {
        // The picture's left and right edge are neighbours: no more different than other neighbours.
        for scene in SCENES {
            let (map, _) = scene.draw(96);
            let step = |a: usize, b: usize| -> f32 {
                let row = |row: usize| (map.texels()[row * 192 + a] - map.texels()[row * 192 + b]).length();
                (0..96).map(row).sum()
            };
            let typical = (0..191).map(|c| step(c, c + 1)).sum::<f32>() / 191.0;
            assert!(step(191, 0) < 3.0 * typical, "{scene:?}: {} {typical}", step(191, 0));
        }
    }

    #[test]
    fn the_disc_of_the_sun_has_its_irradiance() {
        let sun = Sun { direction: to_sun(30.0, 40.0), irradiance: Vec3::new(3.0, 2.0, 1.0) };
        let side = sun.direction.any_orthonormal_vector();
        let steps = 1000;
        let sum: f32 = (0..steps)
            .map(|i| {
                let (angle, step) = ((i as f32 + 0.5) / steps as f32 * 0.02, 0.02 / steps as f32);
                sun.at(angle.cos() * sun.direction + angle.sin() * side).x * std::f32::consts::TAU * angle.sin() * step
            })
            .sum();
        assert!((sum / 3.0 - 1.0).abs() < 0.05, "{sum}: the soft rim adds 1/48");
    }
}
