//! What a pinhole camera sees: the depth at the centre of each pixel.
//!
//! The camera stands at e and looks along f; x and y are the axes of its image, and a pixel at the centre of the mesh is as wide as
//! the step. The point p is seen at pixel (F ⟨p − e, x⟩ / z, F ⟨p − e, y⟩ / z), where z = ⟨p − e, f⟩ is its depth and F the focal
//! length in pixels. The image keeps the smallest depth at each pixel centre (z-buffer); both sides of faces are seen.

use super::{RemeshError, cell_count, lattice};
use crate::mesh::surface::Surface;
use crate::mesh::synthetic_noise::{SyntheticNoise, sphere_around};
use glam::{DVec2, DVec3};

/// Pinhole camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    pub(super) eye: DVec3,
    forward: DVec3,
    axes: [DVec3; 2],
    /// Focal length, pixels.
    pub(super) focal: f64,
}

impl Camera {
    /// Places a camera in the direction `towards` from the centre of a surface, at a distance in radii, with pixels as wide as `step`
    /// (model units) there.
    pub(super) fn new(surface: &Surface, towards: DVec3, distance: f64, step: f64) -> Result<Self, RemeshError> {
        let (centre, radius) = sphere_around(surface).ok_or(RemeshError::Nothing)?;
        let distance = distance.max(SyntheticNoise::NEAREST) * radius;
        let forward = -towards;
        let x = forward.any_orthonormal_vector();
        Ok(Self { eye: centre + towards * distance, forward, axes: [x, x.cross(forward)], focal: distance / step })
    }

    /// Pixel and depth of a point.
    pub(super) fn project(&self, p: DVec3) -> (DVec2, f64) {
        let q = p - self.eye;
        let depth = q.dot(self.forward);
        (DVec2::from_array(self.axes.map(|axis| q.dot(axis))) * (self.focal / depth), depth)
    }

    /// Point that is seen at a pixel with a depth.
    pub(super) fn point(&self, [i, j]: [i64; 2], depth: f64) -> DVec3 {
        let [x, y] = self.axes;
        self.eye + (self.forward + (x * i as f64 + y * j as f64) / self.focal) * depth
    }
}

/// Depths at the pixel centres.
#[derive(Clone, Debug)]
pub(super) struct DepthImage {
    pub(super) camera: Camera,
    /// First column and row.
    low: [i64; 2],
    /// Columns and rows.
    size: [usize; 2],
    /// Depths row after row, model units; infinite where nothing is seen.
    pub(super) depths: Vec<f64>,
}

impl DepthImage {
    /// Looks at a surface.
    pub(super) fn of(surface: &Surface, camera: Camera) -> Result<Self, RemeshError> {
        let seen: Vec<(DVec2, f64)> = surface.positions().iter().map(|p| camera.project(*p)).collect();
        let corners = || surface.triangles().flatten().map(|v| seen[v as usize].0);
        let low = corners().fold(DVec2::INFINITY, DVec2::min).floor();
        let high = corners().fold(DVec2::NEG_INFINITY, DVec2::max).ceil();
        let sides = (high - low + 1.0).to_array();
        cell_count(&sides)?;
        let size = sides.map(|side| side as usize);
        let low = low.to_array().map(|x| x as i64);
        let mut image = Self { camera, low, size, depths: vec![f64::INFINITY; size[0] * size[1]] };
        for t in surface.triangles() {
            let corners = t.map(|v| seen[v as usize]);
            lattice::scan(corners.map(|corner| corner.0), t, |pixel, weights| {
                // Along a plane it is 1/z that is linear in the image.
                let inverse: f64 = corners.iter().zip(weights).map(|((_, depth), weight)| weight / depth).sum();
                if let Some(k) = image.index(pixel) {
                    image.depths[k] = image.depths[k].min(1.0 / inverse);
                }
            });
        }
        Ok(image)
    }

    /// Returns an image of the same pixels with other depths.
    ///
    /// # Panics
    /// If there is not one depth for each pixel.
    pub(super) fn with_depths(&self, depths: Vec<f64>) -> Self {
        assert_eq!(depths.len(), self.depths.len(), "one depth for each pixel");
        Self { depths, ..*self }
    }

    /// Index of a pixel in [`Self::depths`]; `None` outside of the image.
    pub(super) fn index(&self, pixel: [i64; 2]) -> Option<usize> {
        let [i, j] = [0, 1].map(|k| usize::try_from(pixel[k] - self.low[k]).ok().filter(|x| *x < self.size[k]));
        Some(j? * self.size[0] + i?)
    }

    /// Column and row of the pixel with an index.
    pub(super) fn pixel(&self, index: usize) -> [i64; 2] {
        [self.low[0] + (index % self.size[0]) as i64, self.low[1] + (index / self.size[0]) as i64]
    }

    /// Depth at a pixel; infinite where nothing is seen.
    pub(super) fn depth(&self, pixel: [i64; 2]) -> f64 {
        self.index(pixel).map_or(f64::INFINITY, |k| self.depths[k])
    }

    /// Width of a pixel at a depth, model units.
    pub(super) fn width(&self, depth: f64) -> f64 {
        depth / self.camera.focal
    }

    /// Returns the image with fattened edges: where the depth jumps, a pixel beside the jump takes the depth of the nearest of its
    /// eight neighbours, because matching windows that reach over an edge see the texture of the front. `jump` is the smallest jump,
    /// in widths of a pixel.
    pub(super) fn fattened(&self, jump: f64) -> Self {
        let fat = |k: usize| {
            let [i, j] = self.pixel(k);
            let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| [i + x, j + y]));
            let front = around.map(|pixel| self.depth(pixel)).fold(f64::INFINITY, f64::min);
            let depth = self.depths[k];
            if front.is_finite() && depth - front > jump * self.width(front) { front } else { depth }
        };
        self.with_depths((0..self.depths.len()).map(fat).collect())
    }

    /// Triangles between neighbouring pixels, as indices in [`Self::depths`], facing the eye. Squares are cut along the diagonal over
    /// which the depth changes less. There are none over pixels where nothing is seen, or over jumps of more than `jump` widths of a
    /// pixel.
    pub(super) fn triangles(&self, jump: f64) -> Vec<[u32; 3]> {
        let width = self.size[0];
        let is_whole = |t: &[usize; 3]| {
            let depths = t.map(|k| self.depths[k]);
            let (low, high) =
                (depths.iter().copied().fold(f64::INFINITY, f64::min), depths.iter().copied().fold(0.0, f64::max));
            high.is_finite() && high - low <= jump * self.width(low)
        };
        let mut out = Vec::new();
        for (i, j) in (1..self.size[1]).flat_map(|j| (1..width).map(move |i| (i, j))) {
            let d = j * width + i;
            let [a, b, c] = [d - width - 1, d - width, d - 1];
            // Infinite depths give no number, which is not smaller.
            let change = |k: usize, l: usize| (self.depths[k] - self.depths[l]).abs();
            let is_other = change(b, c) < change(a, d) || !(self.depths[a] + self.depths[d]).is_finite();
            let halves = if is_other { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
            out.extend(halves.into_iter().filter(is_whole).map(|t| t.map(|k| k as u32)));
        }
        out
    }
}
