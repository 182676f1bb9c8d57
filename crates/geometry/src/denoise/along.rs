//! What a map of heights can hold of a denoised surface: pᵢ − hᵢ nᵢ, one number for each vertex.
//!
//! The projection hᵢ = ⟨δᵢ, nᵢ⟩ comes nearest in the positions, but it leaves out sideways ways that turn faces. The fit
//! comes near in the face normals instead: it takes those of the denoised surface as given and finds the heights whose
//! faces follow them (see `vertex_update/least_squares.rs`), held lightly to the projection.
//!
//! Along which normals it is best depends on the noise: those of the noisy surface hold all of noise that lies along
//! them, those of the denoised surface are not noisy themselves, and these may lean to the ways of some vertices (see
//! `along/leaning.rs`). [`Along::best`] tries all three.

mod leaning;

use super::NormalField;
use super::faces::{Faces, Shapes};
use super::limits::{Bounds, Outcome};
use super::vertex_update::least_squares::{HALVINGS, System};
use super::vertex_update::take_folds_back;
use crate::model::NormalSource;
use crate::normals::{self, FaceWeight};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::{DVec3, Vec3};

/// Heights along one normal for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Along {
    /// Unit, or zero where there is none; in single precision, as carrier and shader have them. #V×3
    pub normals: Vec<Vec3>,
    /// hᵢ, positive where the noise lifted, model units. #V
    pub heights: Vec<f64>,
    /// What that costs.
    pub loss: Loss,
}

/// How much of the turn of the faces heights leave out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// Mean angle between face normals of the input and of the denoised surface, degrees.
    pub turned: f64,
    /// Mean angle between face normals of the denoised surface and of what the heights give, degrees.
    pub lost: f64,
    /// Root mean square over the vertices of |δ − h·n|, model units.
    pub rms: f64,
    /// Share of the vertices whose normal leans, 0..=1; see [`NormalField::Tilted`].
    pub leaning: f64,
}

/// 10⁻² of closeness for three edges of a face.
const CLOSENESS: f64 = 1e-2 / 3.0;

impl Along {
    /// pᵢ − p*ᵢ = hᵢ nᵢ. #V×3, model units
    pub fn deltas(&self) -> Vec<DVec3> {
        self.heights.iter().zip(&self.normals).map(|(h, n)| *h * n.as_dvec3()).collect()
    }

    /// The projection of δ (#V×3, model units) on the normals.
    pub fn projected(surface: &Surface, deltas: &[DVec3], normals: Vec<Vec3>) -> Self {
        Wanted::new(surface, deltas).projected(normals)
    }

    /// The heights along the normals whose faces come nearest to those that δ (#V×3, model units) gives. Vertices whose δ
    /// is zero stay.
    pub fn fitted(
        surface: &Surface,
        deltas: &[DVec3],
        normals: Vec<Vec3>,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        Wanted::new(surface, deltas).fitted(normals, progress)
    }

    /// The fit along normals of the denoised surface that lean to the ways of those vertices whose faces it would leave
    /// turned otherwise: [`NormalField::Tilted`].
    pub fn leaning(surface: &Surface, deltas: &[DVec3], progress: &dyn Progress) -> Result<Self, Cancelled> {
        let wanted = Wanted::new(surface, deltas);
        wanted.leaning(wanted.fitted(wanted.normals_of_denoised(), progress)?, progress)
    }

    /// The same within limits, and what these did; δ (#V×3, model units) is what was wanted.
    pub fn within(
        mut self,
        bounds: &Bounds,
        surface: &Surface,
        deltas: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<(Self, Option<Outcome>), Cancelled> {
        let directions: Vec<DVec3> = self.normals.iter().map(|n| n.as_dvec3()).collect();
        let mut held = self.deltas();
        let limits = bounds.apply(surface, &directions, &mut held, progress)?;
        if limits.is_some() {
            for ((height, held), n) in self.heights.iter_mut().zip(&held).zip(&directions) {
                if *held == *height * *n {
                    continue;
                }
                // In single precision normals are a little longer or shorter than one.
                *height = held.dot(*n) / n.length_squared().max(f64::MIN_POSITIVE);
                // Rounding may make the way a bit too long.
                while (*height * *n).length_squared() > held.length_squared() {
                    *height *= 1.0 - f64::EPSILON;
                }
            }
            let leaning = self.loss.leaning;
            self.loss = Loss { leaning, ..Wanted::new(surface, deltas).loss(&self.deltas()) };
        }
        Ok((self, limits))
    }

    /// The fit along the angle-weighted normals of the surface, along those of the denoised one, or along the latter leaning,
    /// whichever loses least.
    pub fn best(
        surface: &Surface,
        deltas: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<(Self, NormalField), Cancelled> {
        let wanted = Wanted::new(surface, deltas);
        let mut best = (wanted.fitted(single(surface), progress)?, NormalSource::Angle.into());
        let denoised = wanted.fitted(wanted.normals_of_denoised(), progress)?;
        let leaning = wanted.leaning(denoised.clone(), progress)?;
        for (along, source) in [(denoised, NormalField::Denoised), (leaning, NormalField::Tilted)] {
            if along.loss.lost < best.0.loss.lost {
                best = (along, source);
            }
        }
        Ok(best)
    }
}

/// Angle-weighted normals in single precision. #V×3
fn single(surface: &Surface) -> Vec<Vec3> {
    normals::vertex_normals(surface, FaceWeight::Angle).into_iter().map(DVec3::as_vec3).collect()
}

/// p − δ. #V×3, model units
fn moved(surface: &Surface, deltas: &[DVec3]) -> Vec<DVec3> {
    surface.positions().iter().zip(deltas).map(|(p, delta)| *p - *delta).collect()
}

/// The denoised surface that heights shall come near to.
struct Wanted<'a> {
    surface: &'a Surface,
    deltas: &'a [DVec3],
    faces: Faces,
    /// Of the input. #T×3
    noisy: Vec<DVec3>,
    /// Of the denoised surface. #T×3
    denoised: Vec<DVec3>,
}

impl<'a> Wanted<'a> {
    fn new(surface: &'a Surface, deltas: &'a [DVec3]) -> Self {
        let faces = Faces::of(surface);
        let noisy = Shapes::of(&faces, surface.positions()).normals;
        let denoised = Shapes::of(&faces, &moved(surface, deltas)).normals;
        Self { surface, deltas, faces, noisy, denoised }
    }

    fn normals_of_denoised(&self) -> Vec<Vec3> {
        single(&self.surface.at(moved(self.surface, self.deltas)))
    }

    fn projected(&self, normals: Vec<Vec3>) -> Along {
        let heights = normals::heights(self.deltas, &normals);
        let mut along = Along { normals, heights, loss: Loss::default() };
        along.loss = self.loss(&along.deltas());
        along
    }

    fn fitted(&self, normals: Vec<Vec3>, progress: &dyn Progress) -> Result<Along, Cancelled> {
        let start = self.projected(normals);
        let directions: Vec<DVec3> = start.normals.iter().map(|n| n.as_dvec3()).collect();
        let fixed: Vec<bool> = self.deltas.iter().map(|delta| *delta == DVec3::ZERO).collect();
        let system = System {
            faces: &self.faces,
            normals: &self.denoised,
            fixed: &fixed,
            along: Some(&directions),
            closeness: CLOSENESS,
        };
        let from = moved(self.surface, &start.deltas());
        let mut to = system.solve(&from, &moved(self.surface, self.deltas), progress)?;
        take_folds_back(&self.faces, &self.denoised, &from, &mut to, HALVINGS);
        let ways = from.iter().zip(&to).zip(&directions).map(|((from, to), n)| (*from - *to).dot(*n));
        let heights = start.heights.iter().zip(ways).map(|(h, way)| h + way).collect();
        let mut along = Along { heights, ..start };
        along.loss = self.loss(&along.deltas());
        Ok(along)
    }

    /// Of ways along the normals. #V×3, model units
    fn loss(&self, ways: &[DVec3]) -> Loss {
        let squares: f64 = self.deltas.iter().zip(ways).map(|(delta, way)| delta.distance_squared(*way)).sum();
        let held = Shapes::of(&self.faces, &moved(self.surface, ways)).normals;
        let mean = |normals: &[DVec3]| {
            let angles = normals.iter().zip(&self.denoised).map(|(a, b)| a.cross(*b).length().atan2(a.dot(*b)));
            angles.sum::<f64>().to_degrees() / normals.len().max(1) as f64
        };
        let rms = (squares / ways.len().max(1) as f64).sqrt();
        Loss { turned: mean(&self.noisy), lost: mean(&held), rms, leaning: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{self, Direction, Noise};
    use crate::progress::Silent;
    use crate::shapes;

    /// A noisy sphere, and the ways to the clean one.
    fn noisy(direction: Direction) -> (Surface, Vec<DVec3>) {
        let sphere = shapes::sphere(4);
        let noise = Noise { sigma: 0.2, direction, share: 1.0, seed: 3 };
        let lifted = noise::displacements(&sphere, &noise);
        (sphere.at(sphere.positions().iter().zip(&lifted).map(|(p, d)| *p + *d).collect()), lifted)
    }

    #[test]
    fn noise_along_the_normals_of_the_clean_surface_is_held_along_these() {
        let (surface, deltas) = noisy(Direction::Normal);
        let (best, source) = Along::best(&surface, &deltas, &Silent).unwrap();
        assert_eq!(source, NormalField::Denoised);
        // Noise went along these very normals, which single precision rounds.
        assert!(best.loss.turned > 15.0 && best.loss.lost < 1e-3, "{:?}", best.loss);
        assert!(best.loss.rms < 1e-7);
    }

    #[test]
    fn a_fit_loses_less_than_the_projection_and_one_cannot_hold_all_noise() {
        for (direction, share) in [(Direction::Normal, 0.1), (Direction::Random, 0.5)] {
            let (surface, deltas) = noisy(direction);
            let projected = Along::projected(&surface, &deltas, single(&surface));
            let fitted = Along::fitted(&surface, &deltas, single(&surface), &Silent).unwrap();
            assert_eq!(projected.heights, normals::heights(&deltas, &projected.normals));
            let [before, after] = [projected.loss, fitted.loss];
            assert!(after.lost < 0.7 * before.lost, "{direction:?}: {before:?} {after:?}");
            assert!(after.lost < share * after.turned && after.rms > before.rms, "{direction:?}: {after:?}");
        }
    }

    #[test]
    fn vertices_that_do_not_move_stay() {
        let (surface, mut deltas) = noisy(Direction::Random);
        deltas.iter_mut().step_by(3).for_each(|delta| *delta = DVec3::ZERO);
        let (best, _) = Along::best(&surface, &deltas, &Silent).unwrap();
        assert!(best.heights.iter().step_by(3).all(|h| *h == 0.0));
        assert!(best.heights[1] != 0.0);
    }
}
