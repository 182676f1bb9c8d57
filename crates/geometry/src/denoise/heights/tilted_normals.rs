//! Normals that are tilted towards the motion of their vertices.
//!
//! At a sharp edge, in a thin triangle and where noise is tangential, no height along the normal puts a vertex where it
//! belongs: faces around it remain turned, some of them flipped. A displacement map displaces along whatever vector the
//! carrier has, so the normals of such vertices, and of no others, are tilted towards the displacement of the vertex.

use super::{HeightField, HeightResidual, TargetSurface};
use crate::progress::{Cancelled, Progress};
use glam::{DVec3, Vec3};

/// Angle from which a turned face is seen, degrees.
const VISIBLE_ANGLE_DEG: f64 = 10.0;

/// Largest tilt, degrees. Tilted normals still point out of the surface.
const MAX_TILT_DEG: f64 = 80.0;

/// Number of rounds. Tilting changes the heights of neighbouring vertices; a third round hardly finds another face.
const ROUNDS: u32 = 2;

impl TargetSurface<'_> {
    /// Fits heights along the normals of `upright`, a fit without tilt, after tilting them at the vertices of turned faces.
    pub(super) fn tilted(&self, upright: HeightField, progress: &dyn Progress) -> Result<HeightField, Cancelled> {
        let normals = upright.normals.clone();
        let mut is_tilted = vec![false; normals.len()];
        let mut field = upright;
        for _ in 0..ROUNDS {
            let before = count(&is_tilted);
            for f in self.turned_faces(&field) {
                for v in self.mesh.triangles[f] {
                    is_tilted[v as usize] = self.deltas[v as usize] != DVec3::ZERO;
                }
            }
            if count(&is_tilted) == before {
                break;
            }
            let normal = |v: usize| if is_tilted[v] { tilt(normals[v], self.deltas[v]) } else { normals[v] };
            field = self.fitted((0..normals.len()).map(normal).collect(), progress)?;
            let tilted = count(&is_tilted) as f64 / is_tilted.len() as f64;
            field.residual = HeightResidual { tilted, ..field.residual };
        }
        Ok(field)
    }

    /// Faces of the height field that are visibly turned against those of the denoised surface.
    fn turned_faces(&self, field: &HeightField) -> Vec<usize> {
        let normals = self.face_normals_after(&field.deltas());
        let least = VISIBLE_ANGLE_DEG.to_radians().cos();
        (0..normals.len()).filter(|&f| normals[f].dot(self.denoised_normals[f]) < least).collect()
    }
}

fn count(flags: &[bool]) -> usize {
    flags.iter().filter(|flag| **flag).count()
}

/// Tilts a unit normal to the axis of a displacement, by [`MAX_TILT_DEG`] at most; a zero normal stays.
fn tilt(normal: Vec3, delta: DVec3) -> Vec3 {
    let n = normal.as_dvec3();
    if n == DVec3::ZERO {
        return normal;
    }
    let outwards = if delta.dot(n) < 0.0 { -delta } else { delta };
    let tangential = outwards - n * outwards.dot(n);
    let angle = tangential.length().atan2(outwards.dot(n)).min(MAX_TILT_DEG.to_radians());
    (n * angle.cos() + tangential.normalize_or_zero() * angle.sin()).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::super::single_precision_normals;
    use super::*;
    use crate::denoise::NormalField;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};
    use crate::progress::Silent;

    #[test]
    fn a_normal_is_tilted_to_the_displacement_and_no_farther_than_it_may() {
        let n = Vec3::Z;
        for delta in [DVec3::new(1.0, 0.0, 2.0), DVec3::new(-3.0, 0.0, -6.0)] {
            let tilted = tilt(n, delta).as_dvec3();
            assert!(tilted.cross(delta).length() < 1e-6 && tilted.z > 0.0, "{delta}: {tilted}");
        }
        let steep = tilt(n, DVec3::new(0.0, -1.0, 1e-3)).as_dvec3();
        assert!((steep.angle_between(DVec3::Z).to_degrees() - MAX_TILT_DEG).abs() < 1e-4 && steep.y < 0.0, "{steep}");
        assert_eq!(tilt(n, DVec3::Z), n);
        assert_eq!(tilt(Vec3::ZERO, DVec3::X), Vec3::ZERO, "a vertex without a normal stays");
    }

    #[test]
    fn noise_in_all_directions_is_represented_by_tilted_normals() {
        let sphere = shapes::sphere(4);
        let noise = Noise { sigma: 0.5, direction: Direction::Random, share: 1.0, seed: 3 };
        let deltas = synthetic_noise::displacements(&sphere, &noise);
        let surface = synthetic_noise::noisy(&sphere, &noise);
        let upright = HeightField::fitted(&surface, &deltas, single_precision_normals(&sphere), &Silent).unwrap();
        let tilted = HeightField::tilted(&surface, &deltas, &Silent).unwrap();
        let residuals = [upright.residual, tilted.residual];
        assert!(tilted.residual.angle < 0.4 * upright.residual.angle, "{residuals:?}");
        // Most faces are not visibly turned, and their vertices keep their normals.
        assert!(tilted.residual.tilted > 0.02 && tilted.residual.tilted < 0.5, "{residuals:?}");
        let kept = tilted.normals.iter().zip(&upright.normals).filter(|(a, b)| a.distance(**b) < 1e-6).count();
        let told = (tilted.residual.tilted * tilted.normals.len() as f64).round() as usize;
        assert_eq!(kept, tilted.normals.len() - told);
        assert_eq!(HeightField::best(&surface, &deltas, &Silent).unwrap(), (tilted, NormalField::Tilted));
    }
}
