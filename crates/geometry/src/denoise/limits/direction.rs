//! Motion along one direction only: that of an axis, or of the rays of a camera.

use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Direction along which vertices move, in either sense. As text: `0,0,1` is an axis, and `ray:1,2,3` are the rays from a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Direction {
    /// All vertices move along one vector; finite and not zero.
    Axis(DVec3),
    /// Each vertex moves along the ray to it from a point, model units. A vertex at the point itself stays.
    Rays(DVec3),
}

/// The text is no direction.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no direction, like 0,0,1 for an axis or ray:0,0,0 for the rays from a point")]
pub struct DirectionError(String);

/// Cosine between direction and normal down to which a vertex moves as far as the surface needs. Below it the motion shrinks with
/// the square, because a surface along the direction cannot be moved across it.
const LEAST_COSINE: f64 = 0.5;

impl Direction {
    /// Unit direction of each vertex; zero where there is none. #V×3
    pub(super) fn of(self, surface: &Surface) -> Vec<DVec3> {
        let direction = |p: &DVec3| match self {
            Self::Axis(axis) => unit(axis),
            Self::Rays(origin) => unit(*p - origin),
        };
        surface.positions().iter().map(direction).collect()
    }
}

/// Unit vector; zero for zero. Large and small vectors are scaled first, so that no square overflows.
fn unit(v: DVec3) -> DVec3 {
    (v / v.abs().max_element()).normalize_or_zero()
}

/// Displacements (#V×3, model units) along unit directions (#V×3) that move the surface by the same distance along its normals as
/// the given ones, at angles of up to 60° between direction and normal, and by less beyond. The normals are those of the denoised surface.
pub(super) fn along(surface: &Surface, directions: &[DVec3], deltas: &[DVec3]) -> Vec<DVec3> {
    let denoised = normals::vertex_normals(&surface.at(surface.moved_by(deltas)), FaceWeight::Angle);
    let moved = |((d, n), delta): ((&DVec3, DVec3), &DVec3)| {
        let cosine = d.dot(n);
        let distance = delta.dot(n) * cosine / (cosine * cosine).max(LEAST_COSINE * LEAST_COSINE);
        // Adding zero makes −0 a 0, which leaves the coordinate as it is.
        *d * distance + DVec3::ZERO
    };
    directions.iter().zip(denoised).zip(deltas).map(moved).collect()
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (head, DVec3 { x, y, z }) = match self {
            Self::Axis(axis) => ("", axis),
            Self::Rays(origin) => ("ray:", origin),
        };
        write!(f, "{head}{x},{y},{z}")
    }
}

impl FromStr for Direction {
    type Err = DirectionError;

    fn from_str(text: &str) -> Result<Self, DirectionError> {
        let numbers = |text: &str| -> Option<DVec3> {
            let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
            let vector = DVec3::from_array(numbers?.try_into().ok()?);
            vector.is_finite().then_some(vector)
        };
        let direction = match text.strip_prefix("ray:") {
            Some(origin) => numbers(origin).map(Self::Rays),
            None => numbers(text).filter(|axis| *axis != DVec3::ZERO).map(Self::Axis),
        };
        direction.ok_or_else(|| DirectionError(text.to_owned()))
    }
}

impl TryFrom<String> for Direction {
    type Error = DirectionError;

    fn try_from(text: String) -> Result<Self, DirectionError> {
        text.parse()
    }
}

impl From<Direction> for String {
    fn from(direction: Direction) -> Self {
        direction.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn directions_survive_their_text() {
        for text in ["0,0,1", "-0.1,2e-300,3", "ray:0,0,0", "ray:1,-2.5,1e50"] {
            let direction: Direction = text.parse().unwrap();
            assert_eq!(direction.to_string().parse(), Ok(direction), "{text}");
        }
        for text in ["", "0,0", "0,0,0", "1,2,3,4", "nan,0,1", "inf,0,0", "ray:", "ray:1,2", "z", "beam:1,2,3"] {
            assert!(text.parse::<Direction>().unwrap_err().to_string().contains(&format!("`{text}`")));
        }
    }

    #[test]
    fn huge_and_tiny_axes_have_a_direction() {
        for scale in [1e-300, 1.0, 1e300] {
            let direction = Direction::Axis(DVec3::new(3.0, 0.0, 4.0) * scale).of(&shapes::grid(1))[0];
            assert!(direction.distance(DVec3::new(0.6, 0.0, 0.8)) < 1e-15, "{scale}");
        }
        assert_eq!(Direction::Rays(DVec3::ZERO).of(&shapes::grid(1))[0], DVec3::ZERO);
    }

    #[test]
    fn a_tilted_plane_moves_by_the_same_distance() {
        // Two in z for one in x, as steep as 63°, and a plane of 45°.
        for (slope, share) in [(1.0, 1.0), (2.0, 0.8)] {
            let grid = shapes::grid(4);
            let tilted: Vec<DVec3> = grid.positions().iter().map(|p| DVec3::new(p.x, p.y, slope * p.x)).collect();
            let plane = grid.at(tilted);
            let normal = DVec3::new(-slope, 0.0, 1.0).normalize();
            let deltas = vec![0.1 * normal; plane.positions().len()];
            let moved = along(&plane, &Direction::Axis(DVec3::Z).of(&plane), &deltas);
            for delta in moved {
                assert_eq!((delta.x, delta.y), (0.0, 0.0));
                assert!((delta.dot(normal) - 0.1 * share).abs() < 1e-12, "{delta} {slope}");
            }
        }
    }

    #[test]
    fn a_plane_along_the_direction_stays() {
        let grid = shapes::grid(4);
        let deltas = vec![DVec3::Z; grid.positions().len()];
        let moved = along(&grid, &Direction::Axis(DVec3::X).of(&grid), &deltas);
        assert!(moved.iter().all(|delta| *delta == DVec3::ZERO));
    }
}
