//! A clear sky: sunlight scattered once in the air.
//!
//! Tomoyuki Nishita, Takao Sirai, Katsumi Tadamura, Eihachiro Nakamae. Display of the earth taking into account
//! atmospheric scattering. SIGGRAPH 1993. Coefficients at sea level: Eric Bruneton, Fabrice Neyret. Precomputed
//! atmospheric scattering. EGSR 2008.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Radius of the earth, metres.
const EARTH: f32 = 6_360e3;
const TOP: f32 = 6_420e3;
/// Per metre at sea level, red, green, blue.
const RAYLEIGH: Vec3 = Vec3::new(5.8e-6, 13.5e-6, 33.1e-6);
const MIE: f32 = 21e-6;
/// Heights in which the air gets thinner by e, metres.
const RAYLEIGH_HEIGHT: f32 = 8_000.0;
const MIE_HEIGHT: f32 = 1_200.0;
/// Asymmetry of Mie scattering: haze scatters forwards.
const ASYMMETRY: f32 = 0.76;
/// Table entries over azimuth from the sun, 0..π, and elevation, 0..π/2.
const COLUMNS: usize = 64;
const ROWS: usize = 48;

/// A sky, tabulated by azimuth from the sun and by elevation.
#[derive(Clone, Debug)]
pub(super) struct Sky {
    /// Unit direction towards the sun.
    pub(super) to_sun: Vec3,
    /// Irradiance of the sun on a surface that faces it, in the units of the sky's radiance.
    pub(super) sun: Vec3,
    table: Vec<Vec3>,
}

impl Sky {
    /// `haze` multiplies the Mie coefficient; `sun` is irradiance above the air.
    pub(super) fn new(to_sun: Vec3, haze: f32, sun: f32) -> Self {
        let air = Air { haze, sun };
        let sun_height = to_sun.y.asin();
        let entry = |i: usize| {
            let azimuth = PI * (i % COLUMNS) as f32 / (COLUMNS - 1) as f32;
            // Denser near the horizon, where the colour changes.
            let elevation = FRAC_PI_2 * ((i / COLUMNS) as f32 / (ROWS - 1) as f32).powi(2);
            let local_sun = Vec3::new(0.0, sun_height.sin(), sun_height.cos());
            let flat = elevation.cos();
            air.scattered(Vec3::new(flat * azimuth.sin(), elevation.sin(), flat * azimuth.cos()), local_sun)
        };
        let table = (0..COLUMNS * ROWS).into_par_iter().map(entry).collect();
        Self { to_sun, sun: air.sunlight(Vec3::Y * EARTH, to_sun).unwrap_or(Vec3::ZERO), table }
    }

    /// Radiance without the sun's disc. Below the horizon, that of the horizon.
    pub(super) fn at(&self, direction: Vec3) -> Vec3 {
        let azimuth = Vec2::new(direction.x, direction.z).angle_to(Vec2::new(self.to_sun.x, self.to_sun.z)).abs();
        let azimuth = if azimuth.is_finite() { azimuth } else { 0.0 };
        let elevation = direction.y.clamp(0.0, 1.0).asin();
        let x = azimuth / PI * (COLUMNS - 1) as f32;
        let y = (elevation / FRAC_PI_2).sqrt() * (ROWS - 1) as f32;
        let (column, row) = ((x as usize).min(COLUMNS - 2), (y as usize).min(ROWS - 2));
        let at = |row: usize, column: usize| self.table[row * COLUMNS + column];
        let (wx, wy) = (x - column as f32, y - row as f32);
        at(row, column).lerp(at(row, column + 1), wx).lerp(at(row + 1, column).lerp(at(row + 1, column + 1), wx), wy)
    }

    /// Irradiance over π of the sky alone on level ground.
    pub(super) fn ambient(&self) -> Vec3 {
        let positions = (0..16 * 64).map(|i| {
            // Even in the measure cos θ dω.
            let (r, azimuth) = (((i / 64) as f32 + 0.5) / 16.0, (i % 64) as f32 / 64.0 * std::f32::consts::TAU);
            let flat = r.sqrt();
            Vec3::new(flat * azimuth.sin(), (1.0 - r).sqrt(), flat * azimuth.cos())
        });
        positions.map(|d| self.at(d)).sum::<Vec3>() / (16.0 * 64.0)
    }
}

struct Air {
    haze: f32,
    sun: f32,
}

/// Distance along a ray to the sphere of this radius about the earth's centre, from inside of it, metres.
fn to_sphere(origin: Vec3, direction: Vec3, radius: f32) -> f32 {
    // In units of the radius: squares of metres would lose what matters.
    let (o, b) = (origin / radius, origin.dot(direction) / radius);
    radius * (-b + (b * b - o.length_squared() + 1.0).max(0.0).sqrt())
}

impl Air {
    /// Density of both kinds of air at a position, relative to sea level.
    fn density(position: Vec3) -> Vec2 {
        let height = (position.length() - EARTH).max(0.0);
        Vec2::new((-height / RAYLEIGH_HEIGHT).exp(), (-height / MIE_HEIGHT).exp())
    }

    /// Transmittance of an optical depth of air.
    fn transmittance(&self, depth: Vec2) -> Vec3 {
        // Haze absorbs a tenth of what it scatters.
        (-(RAYLEIGH * depth.x + 1.1 * MIE * self.haze * depth.y)).exp()
    }

    /// Irradiance of the sun at a position; none in the earth's shadow.
    fn sunlight(&self, position: Vec3, to_sun: Vec3) -> Option<Vec3> {
        const STEPS: usize = 16;
        let step = to_sphere(position, to_sun, TOP) / STEPS as f32;
        let mut depth = Vec2::ZERO;
        for i in 0..STEPS {
            let p = position + (i as f32 + 0.5) * step * to_sun;
            if p.length() < EARTH - 1.0 {
                return None;
            }
            depth += step * Self::density(p);
        }
        Some(self.sun * self.transmittance(depth))
    }

    fn scattered(&self, direction: Vec3, to_sun: Vec3) -> Vec3 {
        const STEPS: usize = 48;
        let eye = Vec3::Y * (EARTH + 2.0);
        let reach = to_sphere(eye, direction, TOP);
        let (mut depth, mut rayleigh, mut mie) = (Vec2::ZERO, Vec3::ZERO, Vec3::ZERO);
        for i in 0..STEPS {
            // Short steps near the eye, where the air is dense.
            let bound = |i: usize| reach * (i as f32 / STEPS as f32).powi(2);
            let (step, middle) = (bound(i + 1) - bound(i), 0.5 * (bound(i) + bound(i + 1)));
            let position = eye + middle * direction;
            let amount = step * Self::density(position);
            if let Some(sun) = self.sunlight(position, to_sun) {
                let light = sun * self.transmittance(depth + 0.5 * amount);
                rayleigh += amount.x * light;
                mie += amount.y * light;
            }
            depth += amount;
        }
        let cos = direction.dot(to_sun);
        let g = ASYMMETRY;
        let rayleigh_phase = 3.0 / (16.0 * PI) * (1.0 + cos * cos);
        let mie_phase = 3.0 / (8.0 * PI) * (1.0 - g * g) * (1.0 + cos * cos)
            / ((2.0 + g * g) * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
        // Light that is scattered more than once is nearly even over the sky; so much of an isotropic phase stands for it.
        let again = 1.5 / (4.0 * PI);
        (rayleigh_phase + again) * RAYLEIGH * rayleigh + (mie_phase + again) * MIE * self.haze * mie
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_zenith_is_blue_and_a_low_sun_red() {
        let low = Sky::new(Vec3::new(0.0, 0.05, 1.0).normalize(), 1.0, 20.0);
        let high = Sky::new(Vec3::new(0.0, 1.0, 0.5).normalize(), 1.0, 20.0);
        let zenith = high.at(Vec3::Y);
        assert!(zenith.z > 1.5 * zenith.x, "{zenith}");
        assert!(low.sun.x > 2.0 * low.sun.z, "{}", low.sun);
        assert!(high.sun.x < 1.5 * high.sun.z, "{}", high.sun);
    }

    #[test]
    fn brighter_towards_the_sun_and_the_same_on_both_sides_of_it() {
        let sky = Sky::new(Vec3::new(0.6, 0.3, 0.8).normalize(), 1.0, 20.0);
        let sun = sky.to_sun;
        assert!(sky.at(sun).x > 2.0 * sky.at(Vec3::new(-sun.x, sun.y, -sun.z)).x);
        let ahead = Vec3::new(sun.x, 0.0, sun.z).normalize();
        let side = Vec3::new(-ahead.z, 0.0, ahead.x);
        let (left, right) = ((ahead + side + Vec3::Y).normalize(), (ahead - side + Vec3::Y).normalize());
        assert!(sky.at(left).abs_diff_eq(sky.at(right), 1e-5));
    }
}
