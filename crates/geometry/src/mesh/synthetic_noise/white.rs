//! White and impulsive noise: drawn independently for each vertex.
//!
//! dᵢ = σ ē gᵢ uᵢ with probability `share`, else 0, where gᵢ is Gaussian and uᵢ the vertex normal or a random unit vector.

use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::named;
use glam::DVec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, UnitSphere};

/// Settings of noise that is drawn independently for each vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the displacement, in mean edge lengths.
    pub sigma: f64,
    /// Direction of the displacements.
    pub direction: Direction,
    /// Fraction of the vertices that are displaced, 0..=1; below 1 the noise is impulsive.
    pub share: f64,
    /// Seed of the random numbers: the same seed gives the same noise.
    pub seed: u64,
}

named! {
    /// Direction in which noise displaces a vertex.
    #[derive(Default)]
    pub enum Direction {
        /// Along the angle-weighted vertex normal, as a depth sensor errs.
        #[default]
        Normal = "normal",
        /// In a uniformly random direction.
        Random = "random",
    }
}

/// Displacements with Gaussian lengths; zero for vertices that are not displaced. #V×3, model units
pub fn displacements(surface: &Surface, noise: &Noise) -> Vec<DVec3> {
    let length = noise.sigma * surface.mean_edge();
    with_deviations(surface, noise, |_| length)
}

/// Displacements with Gaussian lengths, whose deviation (model units) may differ from vertex to vertex; `noise.sigma` is not
/// used. #V×3, model units
pub(super) fn with_deviations(surface: &Surface, noise: &Noise, deviation: impl Fn(usize) -> f64) -> Vec<DVec3> {
    let normals = match noise.direction {
        Direction::Normal => normals::vertex_normals(surface, FaceWeight::Angle),
        Direction::Random => Vec::new(),
    };
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let vertices = 0..surface.positions().len();
    vertices.map(|v| one(&mut random, noise, deviation(v), normals.get(v).copied())).collect()
}

/// Adds noise to the vertices of a surface.
pub fn noisy(surface: &Surface, noise: &Noise) -> Surface {
    let displacements = displacements(surface, noise);
    surface.at(surface.positions().iter().zip(displacements).map(|(p, d)| *p + d).collect())
}

/// Draws the same numbers whether the vertex is displaced or not, so that the fraction changes no other vertex.
fn one(random: &mut impl Rng, noise: &Noise, length: f64, normal: Option<DVec3>) -> DVec3 {
    let gaussian: f64 = StandardNormal.sample(random);
    let anywhere: [f64; 3] = UnitSphere.sample(random);
    let hit = random.random::<f64>() < noise.share;
    if hit { normal.unwrap_or(anywhere.into()) * (gaussian * length) } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const QUIET: Noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 };

    #[test]
    fn noise_has_the_deviation_that_was_asked_for() {
        let sphere = shapes::sphere(5);
        for direction in [Direction::Normal, Direction::Random] {
            let moved = displacements(&sphere, &Noise { direction, ..QUIET });
            let variance = moved.iter().map(|d| d.length_squared()).sum::<f64>() / moved.len() as f64;
            let sigma = variance.sqrt() / sphere.mean_edge();
            // 10242 samples: the deviation is known to 0.7 %, five times that is not chance.
            assert!((sigma / 0.2 - 1.0).abs() < 0.035, "{direction:?}: {sigma}");
        }
    }

    #[test]
    fn noise_along_the_normal_stays_there() {
        let sphere = shapes::sphere(3);
        let normals = normals::vertex_normals(&sphere, FaceWeight::Angle);
        for (d, n) in displacements(&sphere, &QUIET).iter().zip(normals) {
            assert!(d.cross(n).length() < 1e-15);
        }
    }

    #[test]
    fn impulses_displace_their_fraction_and_leave_the_rest() {
        let sphere = shapes::sphere(5);
        let all = displacements(&sphere, &QUIET);
        let some = displacements(&sphere, &Noise { share: 0.3, ..QUIET });
        let hit = some.iter().filter(|d| **d != DVec3::ZERO).count();
        // Binomial with 10242 trials: σ = 46, five of them.
        assert!((hit as f64 - 3072.6).abs() < 232.0, "{hit}");
        assert!(all.iter().zip(&some).all(|(a, s)| s == a || *s == DVec3::ZERO));
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let sphere = shapes::sphere(1);
        assert_eq!(displacements(&sphere, &QUIET), displacements(&sphere, &QUIET));
        assert_ne!(displacements(&sphere, &QUIET), displacements(&sphere, &Noise { seed: 2, ..QUIET }));
    }
}
