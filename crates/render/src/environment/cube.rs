//! The sphere of directions as six square pictures.
//!
//! Faces are those of every GPU interface, +x −x +y −y +z −z, each as seen from inside with x to the right, y up and z
//! *ahead*. That is a left-handed system, and so are all directions in this module.
//!
//! ```
//! use glam::Vec3;
//! use planish_render::environment::cube::CubeMap;
//!
//! // Light from the right only.
//! let map = CubeMap::from_fn(16, |direction| Vec3::splat(direction.x.max(0.0)));
//! assert!((map.at(Vec3::new(3.0, 0.0, 0.0)).x - 1.0).abs() < 0.01);
//! assert_eq!(map.at(Vec3::NEG_X), Vec3::ZERO);
//! // Its mean over the sphere is a quarter.
//! let sum: f64 = map.parts().map(|(_, radiance, solid_angle)| f64::from(radiance.x) * solid_angle).sum();
//! assert!((sum / (4.0 * std::f64::consts::PI) - 0.25).abs() < 1e-3);
//! ```

use super::equirect::Equirect;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Radiance on the faces of a cube.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    size: usize,
    /// Linear RGB: face by face, row by row, row 0 on top.
    texels: Vec<Vec3>,
}

/// Direction (not of unit length) of a position on a face: s right, t down, both −1..1; beyond that on its plane.
fn direction_from_face(face: usize, Vec2 { x: s, y: t }: Vec2) -> Vec3 {
    match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    }
}

/// Face and position of a direction of any length, the inverse of [`direction_from_face`].
fn face_from_direction(d: Vec3) -> (usize, Vec2) {
    let size = d.abs();
    let (face, right, down, ahead) = if size.x >= size.y && size.x >= size.z {
        if d.x > 0.0 { (0, -d.z, -d.y, size.x) } else { (1, d.z, -d.y, size.x) }
    } else if size.y >= size.z {
        if d.y > 0.0 { (2, d.x, d.z, size.y) } else { (3, d.x, -d.z, size.y) }
    } else if d.z > 0.0 {
        (4, d.x, -d.y, size.z)
    } else {
        (5, -d.x, -d.y, size.z)
    };
    (face, Vec2::new(right, down) / ahead)
}

/// Error of six pictures that are not the faces of a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the faces of a cube must be squares of one size, and not empty")]
pub struct FaceError;

impl CubeMap {
    /// Joins six faces of size² texels each, row by row.
    pub fn from_faces(size: usize, faces: &[Vec<Vec3>; 6]) -> Result<Self, FaceError> {
        if size == 0 || faces.iter().any(|face| face.len() != size * size) {
            return Err(FaceError);
        }
        Ok(Self { size, texels: faces.concat() })
    }

    /// Asks for the radiance at the middle of each texel, with a unit direction.
    pub fn from_fn(size: usize, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let texels =
            (0..6 * size * size).into_par_iter().map(|i| radiance(texel_direction(size, i).normalize())).collect();
        Self { size, texels }
    }

    /// Another radiance for each texel, of its unit direction and its radiance.
    pub fn map(mut self, radiance: impl Fn(Vec3, Vec3) -> Vec3 + Sync) -> Self {
        let size = self.size;
        self.texels.par_iter_mut().enumerate().for_each(|(i, texel)| {
            *texel = radiance(texel_direction(size, i).normalize(), *texel);
        });
        self
    }

    /// The sphere of a picture by longitude and latitude. Its texels are averaged where they are finer.
    pub fn from_equirect(map: &Equirect, size: usize) -> Self {
        // Along the equator, where both are alike: a face spans a quarter of the picture.
        let finer = map.width().div_ceil(4 * size).clamp(1, 8);
        Self::averaged(size, finer, |d| map.at(d))
    }

    /// Mean of `per_side`² positions in each texel.
    fn averaged(size: usize, per_side: usize, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let fine = size * per_side;
        let share = 1.0 / (per_side * per_side) as f32;
        let texel = |i: usize| {
            let (face, row, column) = (i / (size * size), i / size % size, i % size);
            let positions =
                (0..per_side * per_side).map(|k| (row * per_side + k / per_side, column * per_side + k % per_side));
            let sum: Vec3 = positions
                .map(|(row, column)| radiance(texel_direction(fine, (face * fine + row) * fine + column).normalize()))
                .sum();
            share * sum
        };
        Self { size, texels: (0..6 * size * size).into_par_iter().map(texel).collect() }
    }

    /// Resamples the cube map to faces of another size; texels are averaged where the faces get smaller.
    pub fn resized(&self, size: usize) -> Self {
        Self::averaged(size, self.size.div_ceil(size).clamp(1, 8), |d| self.at(d))
    }

    /// Halves the size of the faces; each texel is the mean of four.
    pub fn halved(&self) -> Self {
        let half = (self.size / 2).max(1);
        if half == self.size { self.clone() } else { self.resized(half) }
    }

    /// Returns the number of texels along a side of a face.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Returns all texels, linear RGB: face by face, row by row.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// Iterates over the texels: unit direction to the centre, radiance and solid angle in steradians.
    pub fn parts(&self) -> impl Iterator<Item = (Vec3, Vec3, f64)> {
        let size = self.size;
        self.texels.iter().enumerate().map(move |(i, &radiance)| {
            let solid_angle = solid_angle(size, i / size % size, i % size);
            (texel_direction(size, i).normalize(), radiance, solid_angle)
        })
    }

    /// Returns the radiance from a direction of any length: bilinear between texel centres, across edges too.
    pub fn at(&self, direction: Vec3) -> Vec3 {
        let (face, position) = face_from_direction(direction);
        let p = (0.5 * position + 0.5) * self.size as f32 - 0.5;
        let low = p.floor();
        let weight = p - low;
        let corner = |dx: f32, dy: f32| self.texel(face, low + Vec2::new(dx, dy));
        let top = corner(0.0, 0.0).lerp(corner(1.0, 0.0), weight.x);
        let bottom = corner(0.0, 1.0).lerp(corner(1.0, 1.0), weight.x);
        top.lerp(bottom, weight.y)
    }

    /// A texel, on the neighbouring face where its number is beyond the edge.
    fn texel(&self, face: usize, texel: Vec2) -> Vec3 {
        let last = (self.size - 1) as f32;
        let index = |face: usize, p: Vec2| (face * self.size + p.y as usize) * self.size + p.x as usize;
        if texel.min_element() >= 0.0 && texel.max_element() <= last {
            return self.texels[index(face, texel)];
        }
        let position = (texel + 0.5) / self.size as f32 * 2.0 - 1.0;
        let (face, position) = face_from_direction(direction_from_face(face, position));
        let nearest = ((0.5 * position + 0.5) * self.size as f32).floor().clamp(Vec2::ZERO, Vec2::splat(last));
        self.texels[index(face, nearest)]
    }
}

/// Direction (not of unit length) to the middle of a texel.
fn texel_direction(size: usize, texel: usize) -> Vec3 {
    let position = |i: usize| (i as f32 + 0.5) / size as f32 * 2.0 - 1.0;
    direction_from_face(texel / (size * size), Vec2::new(position(texel % size), position(texel / size % size)))
}

/// Steradians of a texel: differences of the angle atan(xy/√(x² + y² + 1)) of the rectangle from the middle to (x, y).
fn solid_angle(size: usize, row: usize, column: usize) -> f64 {
    let corner = |row: usize, column: usize| {
        let position = |i: usize| 2.0 * i as f64 / size as f64 - 1.0;
        let (x, y) = (position(column), position(row));
        (x * y).atan2((x * x + y * y + 1.0).sqrt())
    };
    corner(row, column) - corner(row, column + 1) - corner(row + 1, column) + corner(row + 1, column + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn places_on_faces_and_directions_are_inverse() {
        for face in 0..6 {
            for position in [Vec2::ZERO, Vec2::new(0.9, -0.3), Vec2::new(-0.2, 0.7)] {
                let (found_face, found) = face_from_direction(3.0 * direction_from_face(face, position));
                assert!(
                    found_face == face && found.abs_diff_eq(position, 1e-6),
                    "{face} {position}: {found_face} {found}"
                );
            }
        }
    }

    #[test]
    fn solid_angles_make_a_sphere() {
        for size in [1, 2, 7, 64] {
            let sum: f64 = CubeMap::from_fn(size, |_| Vec3::ZERO).parts().map(|(.., angle)| angle).sum();
            assert!((sum - 4.0 * PI).abs() < 1e-10, "{size}: {sum}");
        }
    }

    #[test]
    fn a_smooth_sky_is_given_back_across_edges_and_corners() {
        let map = CubeMap::from_fn(128, |d| 0.5 + 0.5 * d);
        for direction in [Vec3::Z, Vec3::new(1.0, 0.2, 1.001), Vec3::ONE, Vec3::new(-0.4, 1.0, -1.0), Vec3::NEG_ONE] {
            let found = map.at(direction);
            assert!(found.abs_diff_eq(0.5 + 0.5 * direction.normalize(), 0.01), "{direction}: {found}");
        }
    }

    #[test]
    fn the_two_pictures_of_a_sphere_agree() {
        let sky = |d: Vec3| Vec3::new(0.5 + 0.5 * (3.0 * d.x).sin(), 0.5 + 0.5 * d.y, 0.5 + 0.25 * (d.z + d.x));
        let cube = CubeMap::from_equirect(&Equirect::from_fn(256, sky), 64);
        for (found, expected) in cube.texels().iter().zip(CubeMap::from_fn(64, sky).texels()) {
            assert!(found.abs_diff_eq(*expected, 2e-3), "{found} {expected}");
        }
    }

    #[test]
    fn averaging_loses_no_light() {
        // One bright texel: what is left after halving three times is as much light, up to the bend of the face.
        let bright = Vec3::new(0.3, 0.2, 1.0).normalize();
        let cube = CubeMap::from_fn(64, |d| if d.dot(bright) > 0.99 { Vec3::splat(100.0) } else { Vec3::ZERO });
        let flux = |cube: &CubeMap| cube.parts().map(|(_, radiance, angle)| f64::from(radiance.x) * angle).sum::<f64>();
        let less = flux(&cube.halved().halved().halved()) / flux(&cube);
        assert!((less - 1.0).abs() < 0.02, "{less}");
    }
}
