//! The sphere of directions as one picture: longitude to the right, latitude upwards.
//!
//! Directions here are those of the environment: x right, y up, z ahead, so that the middle of the picture is ahead.
//!
//! ```
//! use glam::Vec3;
//! use planish_render::environment::cube::CubeMap;
//! use planish_render::environment::equirect::Equirect;
//!
//! // A picture of four texels by two: only the top row, which is above the horizon, has light.
//! let texels = [[Vec3::ONE; 4], [Vec3::ZERO; 4]].concat();
//! let picture = Equirect::new(4, texels).unwrap();
//! assert_eq!([Vec3::Y, Vec3::NEG_Y].map(|direction| picture.at(direction)), [Vec3::ONE, Vec3::ZERO]);
//! assert!((picture.at(Vec3::Z).x - 0.5).abs() < 1e-3);
//! // Renderers take it as a cube map.
//! assert_eq!(CubeMap::from_equirect(&picture, 8).at(Vec3::Y), Vec3::ONE);
//! ```

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Radiance by longitude and latitude; row 0 is the zenith.
#[derive(Clone, Debug, PartialEq)]
pub struct Equirect {
    width: usize,
    height: usize,
    /// Linear RGB, row by row.
    texels: Vec<Vec3>,
}

/// Position of a unit direction in the picture: u right, v *down*, both 0..1.
pub fn uv_from_direction(direction: Vec3) -> Vec2 {
    let longitude = direction.x.atan2(direction.z);
    // acos(y) loses half of the digits near the poles; this form does not.
    let from_zenith = direction.x.hypot(direction.z).atan2(direction.y);
    Vec2::new(0.5 + longitude / TAU, from_zenith / PI)
}

/// Unit direction of a position in the picture; inverse of [`uv_from_direction`].
pub fn direction_from_uv(uv: Vec2) -> Vec3 {
    let (sin_longitude, cos_longitude) = ((uv.x - 0.5) * TAU).sin_cos();
    let (sin, cos) = (uv.y * PI).sin_cos();
    Vec3::new(sin * sin_longitude, cos, sin * cos_longitude)
}

impl Equirect {
    /// Wraps #rows × #columns texels; none if there are no texels or their number is wrong.
    pub fn new(width: usize, texels: Vec<Vec3>) -> Option<Self> {
        let height = texels.len().checked_div(width)?;
        (height > 0 && width * height == texels.len()).then_some(Self { width, height, texels })
    }

    /// Asks for the radiance at the middle of each texel of a picture twice as wide as high.
    pub fn from_fn(height: usize, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let width = 2 * height;
        let texels = (0..width * height)
            .into_par_iter()
            .map(|i| radiance(direction_from_uv(Self::centre(i % width, i / width, width, height))))
            .collect();
        Self { width, height, texels }
    }

    fn centre(column: usize, row: usize, width: usize, height: usize) -> Vec2 {
        Vec2::new((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32)
    }

    /// Returns the number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Linear RGB, row by row.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// Returns the radiance from a direction: bilinear between texel centres, and wrapped around at the left and right edge.
    pub fn at(&self, direction: Vec3) -> Vec3 {
        let p = uv_from_direction(direction) * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let low = p.floor();
        let weight = p - low;
        let columns = [0.0, 1.0].map(|d| (low.x + d).rem_euclid(self.width as f32) as usize % self.width);
        let rows = [0.0, 1.0].map(|d| (low.y + d).clamp(0.0, (self.height - 1) as f32) as usize);
        let [top, bottom] = rows.map(|row| {
            let [left, right] = columns.map(|column| self.texels[row * self.width + column]);
            left.lerp(right, weight.x)
        });
        top.lerp(bottom, weight.y)
    }

    /// Returns the solid angle of one texel in a row, steradians: 2π/W · (cos θ₀ − cos θ₁), θ from the zenith.
    pub fn solid_angle(&self, row: usize) -> f64 {
        let cos = |row: usize| (row as f64 / self.height as f64 * std::f64::consts::PI).cos();
        std::f64::consts::TAU / self.width as f64 * (cos(row) - cos(row + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64;

    #[test]
    fn directions_and_places_are_inverse() {
        for (u, v) in (0..40).flat_map(|i| (0..20).map(move |j| (i, j))) {
            let uv = Vec2::new((u as f32 + 0.5) / 40.0, (v as f32 + 0.5) / 20.0);
            let found = uv_from_direction(direction_from_uv(uv));
            assert!(found.abs_diff_eq(uv, 1e-6), "{uv} {found}");
        }
    }

    #[test]
    fn the_middle_is_ahead_and_the_right_is_right() {
        for (direction, uv) in [
            (Vec3::Z, Vec2::new(0.5, 0.5)),
            (Vec3::X, Vec2::new(0.75, 0.5)),
            (Vec3::NEG_X, Vec2::new(0.25, 0.5)),
            (Vec3::Y, Vec2::new(0.5, 0.0)),
        ] {
            assert!(uv_from_direction(direction).abs_diff_eq(uv, 1e-6), "{direction}");
        }
    }

    #[test]
    fn solid_angles_make_a_sphere() {
        let map = Equirect::from_fn(37, |_| Vec3::ZERO);
        let sum: f64 = (0..37).map(|row| map.solid_angle(row) * 74.0).sum();
        assert!((sum - 4.0 * f64::consts::PI).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn a_smooth_sky_is_given_back_even_at_the_edge() {
        let map = Equirect::from_fn(256, |d| 0.5 + 0.5 * d);
        for direction in
            [Vec3::NEG_Z, Vec3::new(1e-4, 0.2, -1.0), Vec3::new(-1e-4, 0.2, -1.0), Vec3::new(0.3, 1.0, 0.1)]
        {
            let direction = direction.normalize();
            assert!(map.at(direction).abs_diff_eq(0.5 + 0.5 * direction, 1e-3), "{direction}");
        }
    }

    #[test]
    fn a_count_that_makes_no_rectangle_is_refused() {
        assert_eq!(Equirect::new(3, vec![Vec3::ZERO; 7]), None);
        assert_eq!(Equirect::new(0, vec![]), None);
        assert_eq!(Equirect::new(2, vec![]), None);
    }
}
