//! Normals that lean.
//!
//! At a sharp edge, in a thin triangle and where noise goes sideways, no height along the normal puts a vertex where it
//! belongs: faces around it stay turned, some of them over. A map displaces along whatever vector the carrier has, so
//! the normals of such vertices, and of no others, lean to the way that the vertex goes.

use super::{Along, Loss, Wanted, moved};
use crate::denoise::faces::Shapes;
use crate::progress::{Cancelled, Progress};
use glam::{DVec3, Vec3};

/// A face that is turned by more, degrees, shows.
const TURNED: f64 = 10.0;

/// How far normals lean, degrees. They still point out of the surface.
const STEEPEST: f64 = 80.0;

/// Normals that lean change the heights of the vertices beside them. A third round hardly finds another face.
const ROUNDS: u32 = 2;

impl Wanted<'_> {
    /// The fit along the normals of `upright`, which is the fit along these as they are, leaning where that is needed.
    pub(super) fn leaning(&self, upright: Along, progress: &dyn Progress) -> Result<Along, Cancelled> {
        let normals = upright.normals.clone();
        let mut leans = vec![false; normals.len()];
        let mut along = upright;
        for _ in 0..ROUNDS {
            let before = count(&leans);
            for f in self.turned(&along) {
                for v in self.faces.triangles[f] {
                    leans[v as usize] = self.deltas[v as usize] != DVec3::ZERO;
                }
            }
            if count(&leans) == before {
                break;
            }
            let lean = |v: usize| if leans[v] { leaning(normals[v], self.deltas[v]) } else { normals[v] };
            along = self.fitted((0..normals.len()).map(lean).collect(), progress)?;
            along.loss = Loss { leaning: count(&leans) as f64 / leans.len() as f64, ..along.loss };
        }
        Ok(along)
    }

    /// Triangles that are not turned as on the denoised surface.
    fn turned(&self, along: &Along) -> Vec<usize> {
        let held = Shapes::of(&self.faces, &moved(self.surface, &along.deltas())).normals;
        let least = TURNED.to_radians().cos();
        (0..held.len()).filter(|&f| held[f].dot(self.denoised[f]) < least).collect()
    }
}

fn count(leans: &[bool]) -> usize {
    leans.iter().filter(|leans| **leans).count()
}

/// A normal along a way or against it, as far as it may lean.
fn leaning(normal: Vec3, way: DVec3) -> Vec3 {
    let n = normal.as_dvec3();
    if n == DVec3::ZERO {
        return normal;
    }
    let outwards = if way.dot(n) < 0.0 { -way } else { way };
    let across = outwards - n * outwards.dot(n);
    let angle = across.length().atan2(outwards.dot(n)).min(STEEPEST.to_radians());
    (n * angle.cos() + across.normalize_or_zero() * angle.sin()).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::NormalField;
    use crate::noise::{self, Direction, Noise};
    use crate::progress::Silent;
    use crate::shapes;

    #[test]
    fn a_normal_leans_along_the_way_and_no_farther_than_it_may() {
        let n = Vec3::Z;
        for way in [DVec3::new(1.0, 0.0, 2.0), DVec3::new(-3.0, 0.0, -6.0)] {
            let leans = leaning(n, way).as_dvec3();
            assert!(leans.cross(way).length() < 1e-6 && leans.z > 0.0, "{way}: {leans}");
        }
        let steep = leaning(n, DVec3::new(0.0, -1.0, 1e-3)).as_dvec3();
        assert!((steep.angle_between(DVec3::Z).to_degrees() - STEEPEST).abs() < 1e-4 && steep.y < 0.0, "{steep}");
        assert_eq!(leaning(n, DVec3::Z), n);
        assert_eq!(leaning(Vec3::ZERO, DVec3::X), Vec3::ZERO, "a vertex without a normal stays");
    }

    #[test]
    fn noise_in_all_directions_is_held_by_normals_that_lean() {
        let sphere = shapes::sphere(4);
        let noise = Noise { sigma: 0.5, direction: Direction::Random, share: 1.0, seed: 3 };
        let lifted = noise::displacements(&sphere, &noise);
        let surface = sphere.at(sphere.positions().iter().zip(&lifted).map(|(p, d)| *p + *d).collect());
        let upright = Along::fitted(&surface, &lifted, super::super::single(&sphere), &Silent).unwrap();
        let leaning = Along::leaning(&surface, &lifted, &Silent).unwrap();
        assert!(leaning.loss.lost < 0.4 * upright.loss.lost, "{:?} {:?}", upright.loss, leaning.loss);
        // Most faces are not turned by more than shows, and their vertices keep their normals.
        assert!(leaning.loss.leaning > 0.02 && leaning.loss.leaning < 0.5, "{:?}", leaning.loss);
        let upright = leaning.normals.iter().zip(&upright.normals).filter(|(a, b)| a.distance(**b) < 1e-6).count();
        let leans = (leaning.loss.leaning * leaning.normals.len() as f64).round() as usize;
        assert_eq!(upright, leaning.normals.len() - leans);
        assert_eq!(Along::best(&surface, &lifted, &Silent).unwrap(), (leaning, NormalField::Tilted));
    }
}
