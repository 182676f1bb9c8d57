//! Height fields: denoised surfaces pᵢ − hᵢ nᵢ, with one number for each vertex, that come nearest to a given one.
//!
//! The projection hᵢ = ⟨δᵢ, nᵢ⟩ comes nearest in the positions, but it leaves out sideways motion, which turns faces. The
//! fit comes near in the face normals instead: it takes the face normals of the denoised surface as given and finds the
//! heights whose faces follow them (see `vertex_update/least_squares.rs`), with a small weight on the distance from the
//! projection.
//!
//! Which vertex normals are best depends on the noise. Those of the noisy surface represent noise along them exactly. Those
//! of the denoised surface are not noisy themselves, and they may be tilted at single vertices towards the motion there (see
//! `heights/tilted_normals.rs`). [`HeightField::best`] tries all three.

mod tilted_normals;

use super::NormalField;
use super::face_geometry::FaceGeometry;
use super::limits::{Bounds, Outcome};
use super::triangle_mesh::TriangleMesh;
use super::vertex_update::least_squares::{MAX_HALVINGS, System};
use super::vertex_update::undo_flips;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use crate::source::model::NormalSource;
use glam::{DVec3, Vec3};

/// Heights along one normal for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Unit normals, or zero where a vertex has none; in single precision, as carrier and shader have them. #V×3
    pub normals: Vec<Vec3>,
    /// Heights hᵢ, positive where the noise lifted the vertex, model units. #V
    pub heights: Vec<f64>,
    /// Part of the denoised surface that the height field does not represent.
    pub residual: HeightResidual,
}

/// Part of a denoised surface that a height field cannot represent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeightResidual {
    /// Mean angle by which denoising rotates the face normals of the input, degrees.
    pub rotation: f64,
    /// Mean angle between the face normals of the denoised surface and those of the height field, degrees.
    pub angle: f64,
    /// Root mean square over the vertices of |δ − h·n|, model units.
    pub rms: f64,
    /// Fraction of the vertices whose normal is tilted, 0..=1; see [`NormalField::Tilted`].
    pub tilted: f64,
}

/// Weight that keeps vertices near the projection: 0.01, divided by the three edges per face that the least-squares system
/// counts.
const CLOSENESS: f64 = 1e-2 / 3.0;

impl HeightField {
    /// Displacements δᵢ = hᵢ nᵢ. #V×3, model units
    pub fn deltas(&self) -> Vec<DVec3> {
        self.heights.iter().zip(&self.normals).map(|(h, n)| *h * n.as_dvec3()).collect()
    }

    /// Projects δ (#V×3, model units) on the normals.
    pub fn projected(surface: &Surface, deltas: &[DVec3], normals: Vec<Vec3>) -> Self {
        TargetSurface::new(surface, deltas).projected(normals)
    }

    /// Fits heights along the normals so that the faces come nearest to those that δ (#V×3, model units) gives. Vertices
    /// whose δ is zero stay.
    pub fn fitted(
        surface: &Surface,
        deltas: &[DVec3],
        normals: Vec<Vec3>,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        TargetSurface::new(surface, deltas).fitted(normals, progress)
    }

    /// Fits heights along the normals of the denoised surface, which are tilted at vertices whose faces would remain turned
    /// otherwise: [`NormalField::Tilted`].
    pub fn tilted(surface: &Surface, deltas: &[DVec3], progress: &dyn Progress) -> Result<Self, Cancelled> {
        let target = TargetSurface::new(surface, deltas);
        target.tilted(target.fitted(target.denoised_vertex_normals(), progress)?, progress)
    }

    /// Changes the heights until they satisfy limits, and says what these did; δ (#V×3, model units) are the displacements
    /// that the height field was made for.
    pub fn constrained(
        mut self,
        bounds: &Bounds,
        surface: &Surface,
        deltas: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<(Self, Option<Outcome>), Cancelled> {
        let directions: Vec<DVec3> = self.normals.iter().map(|n| n.as_dvec3()).collect();
        let mut allowed = self.deltas();
        let limits = bounds.apply(surface, &directions, &mut allowed, progress)?;
        if limits.is_some() {
            for ((height, allowed), n) in self.heights.iter_mut().zip(&allowed).zip(&directions) {
                if *allowed == *height * *n {
                    continue;
                }
                // In single precision normals are a little longer or shorter than one.
                *height = allowed.dot(*n) / n.length_squared().max(f64::MIN_POSITIVE);
                // Rounding may make the product a bit too long.
                while (*height * *n).length_squared() > allowed.length_squared() {
                    *height *= 1.0 - f64::EPSILON;
                }
            }
            let tilted = self.residual.tilted;
            let target = TargetSurface::new(surface, deltas);
            self.residual = HeightResidual { tilted, ..target.residual(&self.deltas()) };
        }
        Ok((self, limits))
    }

    /// Fits heights along the angle-weighted normals of the surface, along those of the denoised one, and along the latter
    /// tilted; returns the fit whose faces are nearest to the denoised ones.
    pub fn best(
        surface: &Surface,
        deltas: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<(Self, NormalField), Cancelled> {
        let target = TargetSurface::new(surface, deltas);
        let mut best = (target.fitted(single_precision_normals(surface), progress)?, NormalSource::Angle.into());
        let denoised = target.fitted(target.denoised_vertex_normals(), progress)?;
        let tilted = target.tilted(denoised.clone(), progress)?;
        for (field, source) in [(denoised, NormalField::Denoised), (tilted, NormalField::Tilted)] {
            if field.residual.angle < best.0.residual.angle {
                best = (field, source);
            }
        }
        Ok(best)
    }
}

/// Angle-weighted vertex normals in single precision. #V×3
fn single_precision_normals(surface: &Surface) -> Vec<Vec3> {
    normals::vertex_normals(surface, FaceWeight::Angle).into_iter().map(DVec3::as_vec3).collect()
}

/// The denoised surface that a height field shall come near to.
struct TargetSurface<'a> {
    /// Noisy surface.
    surface: &'a Surface,
    /// Displacements δ from it to the target. #V×3, model units
    deltas: &'a [DVec3],
    mesh: TriangleMesh,
    /// Face normals of the noisy surface. #T×3
    noisy_normals: Vec<DVec3>,
    /// Face normals of the target. #T×3
    denoised_normals: Vec<DVec3>,
}

impl<'a> TargetSurface<'a> {
    fn new(surface: &'a Surface, deltas: &'a [DVec3]) -> Self {
        let mesh = TriangleMesh::of(surface);
        let noisy_normals = FaceGeometry::of(&mesh, surface.positions()).normals;
        let denoised_normals = FaceGeometry::of(&mesh, &surface.moved_by(deltas)).normals;
        Self { surface, deltas, mesh, noisy_normals, denoised_normals }
    }

    fn denoised_vertex_normals(&self) -> Vec<Vec3> {
        single_precision_normals(&self.surface.at(self.surface.moved_by(self.deltas)))
    }

    /// Face normals of the surface after these displacements (#V×3, model units). #T×3
    fn face_normals_after(&self, deltas: &[DVec3]) -> Vec<DVec3> {
        FaceGeometry::of(&self.mesh, &self.surface.moved_by(deltas)).normals
    }

    fn projected(&self, normals: Vec<Vec3>) -> HeightField {
        let heights = normals::heights(self.deltas, &normals);
        let mut field = HeightField { normals, heights, residual: HeightResidual::default() };
        field.residual = self.residual(&field.deltas());
        field
    }

    fn fitted(&self, normals: Vec<Vec3>, progress: &dyn Progress) -> Result<HeightField, Cancelled> {
        let projection = self.projected(normals);
        let directions: Vec<DVec3> = projection.normals.iter().map(|n| n.as_dvec3()).collect();
        let fixed: Vec<bool> = self.deltas.iter().map(|delta| *delta == DVec3::ZERO).collect();
        let system = System {
            mesh: &self.mesh,
            normals: &self.denoised_normals,
            fixed: &fixed,
            directions: Some(&directions),
            closeness: CLOSENESS,
        };
        let from = self.surface.moved_by(&projection.deltas());
        let mut to = system.solve(&from, &self.surface.moved_by(self.deltas), progress)?;
        undo_flips(&self.mesh, &self.denoised_normals, &from, &mut to, MAX_HALVINGS);
        let changes = from.iter().zip(&to).zip(&directions).map(|((from, to), n)| (*from - *to).dot(*n));
        let heights = projection.heights.iter().zip(changes).map(|(h, change)| h + change).collect();
        let mut field = HeightField { heights, ..projection };
        field.residual = self.residual(&field.deltas());
        Ok(field)
    }

    /// Residual of displacements along the normals. #V×3, model units
    fn residual(&self, deltas: &[DVec3]) -> HeightResidual {
        let squares: f64 = self.deltas.iter().zip(deltas).map(|(delta, own)| delta.distance_squared(*own)).sum();
        let mean_angle = |normals: &[DVec3]| {
            let angles = normals.iter().zip(&self.denoised_normals);
            let angles = angles.map(|(a, b)| a.cross(*b).length().atan2(a.dot(*b)));
            angles.sum::<f64>().to_degrees() / normals.len().max(1) as f64
        };
        HeightResidual {
            rotation: mean_angle(&self.noisy_normals),
            angle: mean_angle(&self.face_normals_after(deltas)),
            rms: (squares / deltas.len().max(1) as f64).sqrt(),
            tilted: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};
    use crate::progress::Silent;

    /// A noisy sphere, and the displacements to the clean one.
    fn noisy(direction: Direction) -> (Surface, Vec<DVec3>) {
        let sphere = shapes::sphere(4);
        let noise = Noise { sigma: 0.2, direction, share: 1.0, seed: 3 };
        (synthetic_noise::noisy(&sphere, &noise), synthetic_noise::displacements(&sphere, &noise))
    }

    #[test]
    fn noise_along_the_normals_of_the_clean_surface_is_represented_along_these() {
        let (surface, deltas) = noisy(Direction::Normal);
        let (best, source) = HeightField::best(&surface, &deltas, &Silent).unwrap();
        assert_eq!(source, NormalField::Denoised);
        // Noise went along these very normals, which single precision rounds.
        assert!(best.residual.rotation > 15.0 && best.residual.angle < 1e-3, "{:?}", best.residual);
        assert!(best.residual.rms < 1e-7);
    }

    #[test]
    fn a_fit_loses_less_than_the_projection_and_one_cannot_represent_all_noise() {
        for (direction, share) in [(Direction::Normal, 0.1), (Direction::Random, 0.5)] {
            let (surface, deltas) = noisy(direction);
            let normals = single_precision_normals(&surface);
            let projected = HeightField::projected(&surface, &deltas, normals.clone());
            let fitted = HeightField::fitted(&surface, &deltas, normals, &Silent).unwrap();
            assert_eq!(projected.heights, normals::heights(&deltas, &projected.normals));
            let [before, after] = [projected.residual, fitted.residual];
            assert!(after.angle < 0.7 * before.angle, "{direction:?}: {before:?} {after:?}");
            assert!(after.angle < share * after.rotation && after.rms > before.rms, "{direction:?}: {after:?}");
        }
    }

    #[test]
    fn vertices_that_do_not_move_stay() {
        let (surface, mut deltas) = noisy(Direction::Random);
        deltas.iter_mut().step_by(3).for_each(|delta| *delta = DVec3::ZERO);
        let (best, _) = HeightField::best(&surface, &deltas, &Silent).unwrap();
        assert!(best.heights.iter().step_by(3).all(|h| *h == 0.0));
        assert!(best.heights[1] != 0.0);
    }
}
