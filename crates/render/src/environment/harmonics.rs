//! Light on a surface from all around, in nine numbers a colour.
//!
//! Ravi Ramamoorthi, Pat Hanrahan. An efficient representation for irradiance environment maps. SIGGRAPH 2001.
//! Spherical harmonics of order 2 hold irradiance to 1 % on average, because the cosine lobe is smooth.

use super::cube::CubeMap;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Irradiance over π as a polynomial in the normal, which is what a white surface sends back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// Linear RGB for each of `basis`.
    pub coefficients: [Vec3; 9],
}

/// The real spherical harmonics of orders 0 to 2 (equation 3).
fn basis(d: DVec3) -> [f64; 9] {
    [
        0.282_094_791_773_878_14,
        0.488_602_511_902_919_9 * d.y,
        0.488_602_511_902_919_9 * d.z,
        0.488_602_511_902_919_9 * d.x,
        1.092_548_430_592_079_2 * d.x * d.y,
        1.092_548_430_592_079_2 * d.y * d.z,
        0.315_391_565_252_520_05 * (3.0 * d.z * d.z - 1.0),
        1.092_548_430_592_079_2 * d.x * d.z,
        0.546_274_215_296_039_6 * (d.x * d.x - d.y * d.y),
    ]
}

/// Factors by which the cosine lobe attenuates orders 0 to 2 (equation 8).
const LOBE: [f64; 9] = {
    let (first, second) = (2.0 * PI / 3.0, PI / 4.0);
    [PI, first, first, first, second, second, second, second, second]
};

impl Irradiance {
    /// Integrates an environment (equation 10).
    pub fn new(environment: &CubeMap) -> Self {
        let mut sums = [DVec3::ZERO; 9];
        for (direction, radiance, solid_angle) in environment.parts() {
            let light = solid_angle * radiance.as_dvec3();
            for (sum, basis) in sums.iter_mut().zip(basis(direction.as_dvec3())) {
                *sum += basis * light;
            }
        }
        Self { coefficients: std::array::from_fn(|i| (LOBE[i] / PI * sums[i]).as_vec3()) }
    }

    /// Irradiance over π on a surface with this unit normal (equation 5). Never negative, which the polynomial may be.
    pub fn at(&self, normal: Vec3) -> Vec3 {
        let terms = basis(normal.as_dvec3());
        let sum: Vec3 = self.coefficients.iter().zip(terms).map(|(&c, basis)| c * basis as f32).sum();
        sum.max(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NORMALS: [Vec3; 4] = [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::new(0.48, -0.6, 0.64)];

    #[test]
    fn an_even_environment_lights_evenly() {
        // Irradiance of radiance L from everywhere is π L.
        let light = Irradiance::new(&CubeMap::from_fn(16, |_| Vec3::new(1.0, 2.0, 0.5)));
        for normal in NORMALS {
            assert!(light.at(normal).abs_diff_eq(Vec3::new(1.0, 2.0, 0.5), 1e-5), "{normal}: {}", light.at(normal));
        }
    }

    #[test]
    fn a_linear_environment_is_exact() {
        // Radiance 1 + y: the cosine lobe leaves two thirds of the first order.
        let light = Irradiance::new(&CubeMap::from_fn(64, |d| Vec3::splat(1.0 + d.y)));
        for normal in NORMALS {
            let expected = 1.0 + 2.0 / 3.0 * normal.y;
            assert!((light.at(normal).x - expected).abs() < 1e-4, "{normal}: {} {expected}", light.at(normal).x);
        }
    }

    #[test]
    fn a_half_sky_lights_as_the_integral_says() {
        let cube = CubeMap::from_fn(32, |d| if d.y > 0.0 { Vec3::ONE } else { Vec3::ZERO });
        let light = Irradiance::new(&cube);
        for normal in NORMALS {
            let direct: f64 = cube
                .parts()
                .map(|(d, radiance, angle)| f64::from(radiance.x * normal.dot(d).max(0.0)) * angle / PI)
                .sum();
            // Order 2 leaves out what the paper's figure 3 shows: a few per cent of the brightest.
            assert!((f64::from(light.at(normal).x) - direct).abs() < 0.04, "{normal}: {} {direct}", light.at(normal).x);
        }
    }
}
