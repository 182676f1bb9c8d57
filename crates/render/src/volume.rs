//! A volume: values on a grid in space, and their interpolation. Twin of `volume_at` in `shaders/volume.wgsl`.
//!
//! Texel coordinates run along the axes of the grid; value (i, j, k) lies in the middle of its voxel, at (i + ½, j + ½, k + ½), and the
//! box of the volume is that of all voxels, from 0 to the number of values.
//!
//! ```
//! use glam::{Affine3A, Vec3};
//! use planish_render::volume::{Volume, VolumeError};
//!
//! // Two voxels beside each other, with sides of length 1.
//! let volume = Volume::new([2, 1, 1], vec![10.0, 20.0], Affine3A::IDENTITY)?;
//! assert_eq!(volume.at(Vec3::new(0.5, 0.5, 0.5)), 10.0);
//! assert_eq!(volume.at(Vec3::new(1.0, 0.5, 0.5)), 15.0);
//! assert_eq!((volume.range().low, volume.range().high), (10.0, 20.0));
//! let short = Volume::new([2, 2, 1], vec![10.0, 20.0], Affine3A::IDENTITY);
//! assert_eq!(short, Err(VolumeError::Count { found: 2, expected: 4 }));
//! # Ok::<(), VolumeError>(())
//! ```

use crate::bounds::Sphere;
use crate::settings::Range;
use crate::settings::volume::MAX_VALUES;
use glam::{Affine3A, DVec3, Mat3A, UVec3, Vec3, Vec3A};
use rayon::prelude::*;
use thiserror::Error;

/// Values on a grid in space, in the coordinates of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    size: UVec3,
    /// The first axis is the fastest.
    values: Vec<f32>,
    world_from_texel: Affine3A,
    texel_from_world: Affine3A,
    range: Range,
}

/// Reason why numbers are not a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The volume has no values, or too many.
    #[error("{0} × {1} × {2} values, but a volume has 1 to 2^28")]
    Size(u32, u32, u32),
    /// The number of values is not that of the grid.
    #[error("{found} values for a grid of {expected}")]
    Count {
        /// Number of values.
        found: usize,
        /// Number of grid points.
        expected: usize,
    },
    /// A value is not finite.
    #[error("value {0} (counted from 0) is not finite in single precision")]
    NotFinite(usize),
    /// The axes are not finite, or lie in a plane.
    #[error("the axes of its grid do not span space")]
    Axes,
}

impl Volume {
    /// Wraps values, the first axis fastest. `world_from_texel` gives the position in the scene of texel coordinates.
    pub fn new(size: [u32; 3], values: Vec<f32>, world_from_texel: Affine3A) -> Result<Self, VolumeError> {
        let expected = size.iter().map(|n| u128::from(*n)).product::<u128>();
        if !(1..=u128::from(MAX_VALUES)).contains(&expected) {
            return Err(VolumeError::Size(size[0], size[1], size[2]));
        }
        let (found, expected) = (values.len(), expected as usize);
        if found != expected {
            return Err(VolumeError::Count { found, expected });
        }
        if let Some(i) = values.par_iter().position_first(|v| !v.is_finite()) {
            return Err(VolumeError::NotFinite(i));
        }
        let texel_from_world = world_from_texel.inverse();
        if !world_from_texel.is_finite() || !texel_from_world.is_finite() {
            return Err(VolumeError::Axes);
        }
        let ends = || (f32::INFINITY, f32::NEG_INFINITY);
        let (low, high) = values
            .par_iter()
            .fold(ends, |(low, high), v| (low.min(*v), high.max(*v)))
            .reduce(ends, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        Ok(Self { size: size.into(), values, world_from_texel, texel_from_world, range: widened(low, high) })
    }

    /// Placement as small as it can be around the box from `low` to `high`, with the same middle and voxels of this shape.
    pub fn fitted(size: [u32; 3], spacing: Vec3, low: Vec3, high: Vec3) -> Affine3A {
        let extent = UVec3::from(size).as_dvec3() * spacing.as_dvec3();
        let scale = ((high - low).as_dvec3() / extent).max_element();
        // Around nothing, or a point, the longest side is one unit long.
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 / extent.max_element() };
        let middle = 0.5 * (low.as_dvec3() + high.as_dvec3());
        let voxel = scale * spacing.as_dvec3();
        Affine3A {
            matrix3: Mat3A::from_diagonal(voxel.as_vec3()),
            translation: Vec3A::from((middle - 0.5 * scale * extent).as_vec3()),
        }
    }

    /// Grid of cubes around the box from `low` to `high` with a margin of a tenth of its longest side, along which there are `size` values:
    /// the numbers of values, the lower corner of the grid and the side of a voxel.
    pub fn grid_around(size: u32, low: DVec3, high: DVec3) -> ([u32; 3], DVec3, f64) {
        let longest = (high - low).max_element();
        let longest = if longest > 0.0 && longest.is_finite() { longest } else { 1.0 };
        let voxel = 1.2 * longest / f64::from(size.max(1));
        let counts = ((high - low + 0.2 * longest) / voxel - 1e-6).ceil().max(DVec3::ONE);
        let corner = 0.5 * (low + high) - 0.5 * voxel * counts;
        (counts.as_uvec3().to_array(), corner, voxel)
    }

    /// Says which values the ends of a transfer function stand for where the settings do not.
    pub fn with_range(self, range: Range) -> Self {
        Self { range: widened(range.low, range.high), ..self }
    }

    /// Returns the values that the ends of a transfer function stand for: the least and the greatest one, or those of
    /// [`Self::with_range`].
    pub fn range(&self) -> Range {
        self.range
    }

    /// Returns the number of values along each axis.
    pub fn size(&self) -> [u32; 3] {
        self.size.to_array()
    }

    /// Returns the values, the first axis fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    pub(crate) fn texel_from_world(&self) -> Affine3A {
        self.texel_from_world
    }

    /// The corner of the box with the least coordinates of the scene, and the opposite one.
    pub(crate) fn corners(&self) -> [Vec3; 2] {
        let corner = |i: u32| {
            let share = UVec3::new(i & 1, i >> 1 & 1, i >> 2);
            self.world_from_texel.transform_point3((share * self.size).as_vec3())
        };
        let first = corner(0);
        (1..8).map(corner).fold([first; 2], |[low, high], p| [low.min(p), high.max(p)])
    }

    /// A sphere about the box.
    pub fn bounds(&self) -> Sphere {
        let centre = self.world_from_texel.transform_point3(0.5 * self.size.as_vec3());
        Sphere { centre, radius: 0.5 * self.diagonal() }
    }

    /// The longest diagonal of the box, world units.
    pub(crate) fn diagonal(&self) -> f32 {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 1.0) * self.size.as_vec3();
        let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
        corners.map(|c| self.world_from_texel.transform_vector3(c).length()).into_iter().fold(0.0, f32::max)
    }

    /// The shortest side of a voxel, world units.
    pub(crate) fn shortest_side(&self) -> f32 {
        let Mat3A { x_axis, y_axis, z_axis } = self.world_from_texel.matrix3;
        [x_axis, y_axis, z_axis].map(Vec3A::length).into_iter().fold(f32::INFINITY, f32::min)
    }

    /// Value at a position in the scene: trilinear between the values, and constant beyond the outermost ones.
    pub fn at(&self, world: Vec3) -> f32 {
        self.at_texel(self.texel_from_world.transform_point3(world))
    }

    /// Value at texel coordinates.
    pub(crate) fn at_texel(&self, texel: Vec3) -> f32 {
        let last = self.size - 1;
        let p = (texel - 0.5).clamp(Vec3::ZERO, last.as_vec3());
        let low = p.floor();
        let w = p - low;
        let near = low.as_uvec3();
        let far = (near + 1).min(last);
        let value = |x, y, z| self.values[((z * self.size.y + y) * self.size.x + x) as usize];
        let mix = |a: f32, b: f32, w: f32| a + (b - a) * w;
        let row = |y, z| mix(value(near.x, y, z), value(far.x, y, z), w.x);
        let sheet = |z| mix(row(near.y, z), row(far.y, z), w.y);
        mix(sheet(near.z), sheet(far.z), w.z)
    }
}

/// Values that are all the same still need a range with some width.
fn widened(low: f32, high: f32) -> Range {
    if low < high {
        Range { low, high }
    } else {
        Range { low: low - low.abs().max(1.0), high: low + low.abs().max(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a function at the grid points of a volume.
    fn volume(size: [u32; 3], world_from_texel: Affine3A, f: impl Fn(Vec3) -> f32) -> Volume {
        let [nx, ny, nz] = size;
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| UVec3::new(x, y, z))));
        let values = all.map(|i| f(world_from_texel.transform_point3(i.as_vec3() + 0.5))).collect();
        Volume::new(size, values, world_from_texel).unwrap()
    }

    #[test]
    fn a_linear_function_is_exact_between_the_values_and_constant_outside() {
        let axes = Mat3A::from_cols(Vec3A::new(0.5, 0.1, 0.0), Vec3A::new(-0.2, 0.4, 0.1), Vec3A::new(0.0, 0.0, -0.7));
        let world_from_texel = Affine3A { matrix3: axes, translation: Vec3A::new(3.0, -2.0, 1.0) };
        let linear = |p: Vec3| 2.0 * p.x - 3.0 * p.y + 0.5 * p.z + 1.0;
        let volume = volume([5, 4, 3], world_from_texel, linear);
        for i in 0..200 {
            let share = Vec3::new(0.37, 0.61, 0.83) * i as f32 % 1.0;
            let texel = 0.5 + share * Vec3::new(4.0, 3.0, 2.0);
            let world = world_from_texel.transform_point3(texel);
            assert!((volume.at(world) - linear(world)).abs() < 2e-5, "{texel}: {} {}", volume.at(world), linear(world));
        }
        let corner = linear(world_from_texel.transform_point3(Vec3::splat(0.5)));
        for texel in [Vec3::ZERO, Vec3::splat(-1e9), Vec3::new(0.2, -3.0, 0.5)] {
            assert_eq!(volume.at_texel(texel), corner);
        }
    }

    #[test]
    fn a_fitted_box_touches_what_it_is_around() {
        let (low, high) = (Vec3::new(-1.0, 2.0, 0.0), Vec3::new(3.0, 3.0, 1.0));
        let spacing = Vec3::new(1.0, 1.0, 2.0);
        let world_from_texel = Volume::fitted([8, 4, 4], spacing, low, high);
        let volume = Volume::new([8, 4, 4], vec![0.0; 128], world_from_texel).unwrap();
        assert_eq!(volume.corners(), [Vec3::new(-1.0, 1.5, -1.5), Vec3::new(3.0, 3.5, 2.5)]);
        assert_eq!((volume.shortest_side(), volume.diagonal()), (0.5, 6.0));
    }

    #[test]
    fn a_grid_around_a_box_has_cubes_and_room() {
        let (low, high) = (DVec3::new(1.0, 0.0, 0.0), DVec3::new(3.0, 1.0, 0.5));
        let (size, corner, voxel) = Volume::grid_around(48, low, high);
        assert_eq!(size, [48, 28, 18]);
        assert!(
            (voxel - 0.05).abs() < 1e-12 && (corner - DVec3::new(0.8, -0.2, -0.2)).abs().max_element() < 1e-12,
            "{corner}"
        );
    }

    #[test]
    fn what_is_no_volume_is_refused() {
        let world_from_texel = Affine3A::IDENTITY;
        let new = |size, values| Volume::new(size, values, world_from_texel).unwrap_err();
        assert_eq!(new([0, 1, 1], Vec::new()), VolumeError::Size(0, 1, 1));
        assert_eq!(new([1 << 20, 1 << 20, 1 << 24], Vec::new()), VolumeError::Size(1 << 20, 1 << 20, 1 << 24));
        assert_eq!(new([2, 1, 1], vec![0.0]), VolumeError::Count { found: 1, expected: 2 });
        assert_eq!(new([2, 1, 1], vec![0.0, f32::NAN]), VolumeError::NotFinite(1));
        let flat = Affine3A { matrix3: Mat3A::from_diagonal(Vec3::new(1.0, 0.0, 1.0)), ..world_from_texel };
        assert_eq!(Volume::new([1, 1, 1], vec![0.0], flat).unwrap_err(), VolumeError::Axes);
    }
}
