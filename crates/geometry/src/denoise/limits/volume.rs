//! Restores the volume that denoising has taken from a surface.
//!
//! Mathieu Desbrun, Mark Meyer, Peter Schröder, Alan H. Barr. Implicit fairing of irregular meshes using diffusion and
//! curvature flow. SIGGRAPH 1999, section 5.1, restore the exact volume after smoothing by scaling the mesh about its
//! centre. That moves every vertex, and those far from the centre most. Here the denoised surface is offset by the same
//! distance t everywhere instead, which changes the volume most for a given motion of the vertices: dV = ∫ t dA.
//!
//! Vertices are offset along their input normals, so that a height map can still represent the result. The offset is divided
//! by the cosine between input normal and denoised normal.

use super::{Bounds, VolumeChange};
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// Number of triangles that are summed at a time, whatever the number of threads.
const CHUNK: usize = 4096;

/// Largest number of steps of the search; a dozen is usual.
const MAX_STEPS: usize = 200;

/// Smallest cosine between input normal and denoised normal that an offset is divided by.
const MIN_COSINE: f64 = 0.5;

/// Offsets the denoised surface until it encloses the volume of the input, as far as the other limits allow.
pub(super) fn restore(
    bounds: &Bounds,
    surface: &Surface,
    directions: &[DVec3],
    deltas: &mut Vec<DVec3>,
    progress: &dyn Progress,
) -> Result<VolumeChange, Cancelled> {
    let volume = Volume::of(surface);
    let denoised = surface.at(surface.moved_by(deltas));
    let lift = |(n, denoised): (&DVec3, DVec3)| *n / n.dot(denoised).max(MIN_COSINE);
    let lifts: Vec<DVec3> =
        directions.iter().zip(normals::vertex_normals(&denoised, FaceWeight::Angle)).map(lift).collect();
    let offset = |t: f64| -> Vec<DVec3> {
        let slots = deltas.par_iter().zip(&lifts).enumerate().with_min_len(CHUNK);
        slots.map(|(v, (delta, lift))| bounds.allowed(v, *delta - t * *lift)).collect()
    };
    let by_method = volume.change(deltas);
    // The sums have about as many digits that count as their largest terms.
    let rounding = 1e-13 * volume.magnitude;
    let change = |t: f64| progress.check().map(|()| volume.change(&offset(t)));
    let [mut t, mut left] = [0.0, by_method];
    if by_method.abs() > rounding {
        let first = -by_method / surface.area().max(f64::MIN_POSITIVE);
        [t, left] = root(change, first, by_method, rounding)?;
    }
    *deltas = offset(t);
    Ok(VolumeChange { by_method, left, restored: left.abs() <= rounding })
}

/// Finds a root of a function and returns it with the value there; `at_zero` is the value at 0 and `first` a step in the right
/// direction. This is regula falsi that halves the value of an end that stays (Illinois method, Dowell & Jarratt 1971). If no
/// value of at most `small` is found, the argument with the smallest one is returned.
fn root(
    f: impl Fn(f64) -> Result<f64, Cancelled>,
    first: f64,
    at_zero: f64,
    small: f64,
) -> Result<[f64; 2], Cancelled> {
    let mut best = [0.0, at_zero];
    let ([mut a, mut fa], mut b) = ([0.0, at_zero], first);
    let mut fb = f(b)?;
    let mut between = false;
    for _ in 0..MAX_STEPS {
        if fb.abs() < best[1].abs() {
            best = [b, fb];
        }
        if best[1].abs() <= small || !fb.is_finite() || a == b {
            break;
        }
        // The latest argument is b; a is on the other side of the root as soon as there is one.
        let next = if fa * fb > 0.0 && !between {
            2.0 * b
        } else {
            between = true;
            b - fb * (b - a) / (fb - fa)
        };
        let value = f(next)?;
        if value == fb && !between {
            // Nothing moves any more.
            break;
        }
        if value * fb < 0.0 {
            [a, fa] = [b, fb];
        } else if between {
            fa /= 2.0;
        }
        [b, fb] = [next, value];
    }
    Ok(best)
}

/// Volume between a surface and others with the same triangles.
struct Volume<'a> {
    positions: &'a [DVec3],
    triangles: Vec<[Index; 3]>,
    centre: DVec3,
    /// Sum of the absolute volumes of the tetrahedra, cubic model units.
    magnitude: f64,
}

impl<'a> Volume<'a> {
    fn of(surface: &'a Surface) -> Self {
        let (positions, centre) = (surface.positions(), surface.centroid());
        let mut volume = Self { positions, triangles: surface.triangles().collect(), centre, magnitude: 0.0 };
        volume.magnitude = volume.sum(|t| volume.tetrahedron(t, |v| positions[v]).abs());
        volume
    }

    /// Change of the volume if vertices move by −δ.
    fn change(&self, deltas: &[DVec3]) -> f64 {
        let moved = |v: usize| self.positions[v] - deltas[v];
        self.sum(|t| self.tetrahedron(t, moved) - self.tetrahedron(t, |v| self.positions[v]))
    }

    fn tetrahedron(&self, triangle: [Index; 3], at: impl Fn(usize) -> DVec3) -> f64 {
        let [a, b, c] = triangle.map(|v| at(v as usize) - self.centre);
        a.dot(b.cross(c)) / 6.0
    }

    fn sum(&self, of_triangle: impl Fn([Index; 3]) -> f64 + Sync) -> f64 {
        let runs = self.triangles.par_chunks(CHUNK).map(|run| run.iter().map(|t| of_triangle(*t)).sum());
        runs.collect::<Vec<f64>>().iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_found_far_away_and_where_the_function_is_flat() {
        type Case = (&'static str, fn(f64) -> f64, f64);
        let shapes: [Case; 4] = [
            ("line", |t| t - 3.0, 3.0),
            ("far", |t| t * t * t - 1e6, 100.0),
            ("flat", |t| (t - 2.0).powi(3), 2.0),
            ("cut off", |t| t.clamp(-1.0, 0.5) - 0.25, 0.25),
        ];
        for (name, f, expected) in shapes {
            let [t, left] = root(|t| Ok(f(t)), 0.01, f(0.0), 1e-12).unwrap();
            assert!(left.abs() <= 1e-12, "{name}: {left:e} at {t}");
            // The third root of 1e-12.
            assert!((t - expected).abs() < 1.1e-4, "{name}: {t}");
        }
    }

    #[test]
    fn without_a_root_the_nearest_value_is_taken() {
        assert_eq!(root(|t| Ok(1.0 - t.min(0.5)), 0.01, 1.0, 1e-12).unwrap()[1], 0.5);
        assert_eq!(root(|_| Ok(f64::NAN), 0.01, 1.0, 1e-12).unwrap(), [0.0, 1.0]);
    }
}
