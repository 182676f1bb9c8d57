//! From heights at vertices to texels: triangles are rasterised, texels outside the charts are filled, and the texels that
//! vertices sample are fitted.
//!
//! Texel space has its origin at the top left corner of the image, x to the right and y down; the centre of texel
//! (i, j) is at (i + ½, j + ½). [`Size::texel_from_uv`] is the only function that flips v.
//!
//! ```
//! use glam::DVec2;
//! use planish_geometry::map::{self, Coverage, Exactness, Interpolation, Size, TextureLayout};
//! use planish_geometry::mesh::{atlas::Atlas, shapes};
//! use planish_geometry::progress::Silent;
//!
//! // A sheet in the plane z = 0 whose texture coordinates are its positions, and a height for each of its 25 vertices.
//! let sheet = shapes::grid(4);
//! let uvs: Vec<DVec2> = sheet.positions().iter().map(|p| p.truncate()).collect();
//! let atlas = Atlas::new(&sheet, &uvs, sheet.topology().faces().items().iter().map(|&v| Some(v)))?;
//! let heights: Vec<f64> = (0..25).map(|i| f64::from(i * 7 % 5)).collect();
//!
//! let coverage = Coverage::new(&sheet, &atlas, Size::square(16), &Silent)?;
//! let layout = TextureLayout { surface: &sheet, atlas: &atlas, coverage: &coverage };
//! let mut height_map = map::interpolate_heights(layout, &heights, Interpolation::Barycentric, &Silent)?;
//! assert_eq!(height_map.texels.len(), 256);
//! let exactness = Exactness { quantum: 1.0 / 65535.0, tolerance: 1.0 };
//! let unmet = map::fit(&mut height_map, &atlas, &heights, exactness, &Silent)?;
//! assert_eq!((unmet.dominant, unmet.secondary), (0, 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod displace;
pub mod displacement;
pub mod fit;
pub mod layout_issues;
pub mod manifest;
pub mod map_size;
pub mod normal_map;
pub mod occlusion;
pub mod pages;
pub mod per_vertex;
pub mod tangents;

mod gutter;
pub(crate) mod private_texels;
mod raster;
pub(crate) mod sampling;
mod scattered_interpolation;

pub use raster::Coverage;
pub use sampling::{HeightMap, Size};

use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::named;
use crate::progress::{Cancelled, Parts, Progress};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scattered_interpolation::ScatteredInterpolation;

named! {
    /// Interpolation of the heights between vertices.
    #[derive(Default)]
    pub enum Interpolation {
        /// Linear on the triangles of the mesh; between the charts on a Delaunay triangulation of their outlines.
        #[default]
        Barycentric = "barycentric",
        /// Natural neighbours of the vertices in the texture (Sibson 1981).
        Natural = "natural",
        /// Inverse squared distance to the eight nearest vertices in the texture (Shepard 1968).
        Idw = "idw",
        /// The nearest vertex in the texture.
        Nearest = "nearest",
    }
}

named! {
    /// Treatment of the texels that vertices sample.
    #[derive(Default)]
    pub enum Texels {
        /// Texels are fitted until sampling gives each vertex its exact height.
        #[default]
        Fitted = "fitted",
        /// Texels stay as interpolated.
        Interpolated = "interpolated",
    }
}

/// A surface in the texture: where its corners lie there and which texels its triangles cover.
#[derive(Clone, Copy, Debug)]
pub struct TextureLayout<'a> {
    /// Surface that is mapped to the texture.
    pub surface: &'a Surface,
    /// Texture coordinates of its corners.
    pub atlas: &'a Atlas,
    /// Triangle of each texel, for this surface and atlas.
    pub coverage: &'a Coverage,
}

/// Interpolates heights (#V, model units) over the texture; every texel gets one, inside charts and out.
///
/// All values lie between the lowest and the highest height.
pub fn interpolate_heights(
    layout: TextureLayout,
    heights: &[f64],
    interpolation: Interpolation,
    progress: &dyn Progress,
) -> Result<HeightMap, Cancelled> {
    let TextureLayout { surface, atlas, coverage } = layout;
    let size = coverage.size();
    progress.stage("interpolating");
    let wedges = match interpolation {
        Interpolation::Barycentric => atlas.outline(surface),
        _ => (0..atlas.uvs().len() as Index).collect(),
    };
    let interpolator = ScatteredInterpolation::new(atlas, heights, &wedges, interpolation);
    let texels = per_texel(size, 0.0, progress, || {
        let sampler = interpolator.sampler();
        let (interpolator, surface) = (&interpolator, &surface);
        move |column, row| {
            let uv = size.uv_from_texel(column, row);
            let height = match interpolation {
                Interpolation::Barycentric => match coverage.owner(column, row) {
                    Some(t) => in_triangle(surface, heights, coverage.weights(t, column, row)),
                    None => sampler.linear(uv),
                },
                Interpolation::Natural => sampler.natural(uv),
                Interpolation::Idw => interpolator.inverse_distance(uv),
                Interpolation::Nearest => interpolator.nearest(uv),
            };
            height as f32
        }
    })?;
    Ok(HeightMap { size, texels })
}

/// Required accuracy of a fitted map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exactness {
    /// Step between two values of the encoding, as a fraction of its range.
    pub quantum: f64,
    /// Largest error of a vertex after encoding, quanta; encoding alone takes half a quantum.
    pub tolerance: f64,
}

impl Exactness {
    /// Error at which the solver takes a sample as met, as a fraction of the range. Texels are in single precision whatever
    /// they are encoded in.
    fn residual(self) -> f64 {
        self.quantum.max(f64::from(f32::EPSILON)) / 8.0
    }
    /// Largest error of a sample before encoding, as a fraction of the range.
    fn allowed(self) -> f64 {
        ((self.tolerance - 0.5) * self.quantum).max(self.residual())
    }
}

/// Fits the texels of a map until each wedge samples the height of its vertex (#V, model units) to an eighth of a quantum, as
/// far as the layout allows; texels may leave the range of the heights by a quarter of it.
pub fn fit(
    map: &mut HeightMap,
    atlas: &Atlas,
    heights: &[f64],
    exactness: Exactness,
    progress: &dyn Progress,
) -> Result<fit::UnmetSamples, Cancelled> {
    let (_, samples) = samples(atlas, heights);
    fit::fit(&mut map.texels, map.size, &samples, exactness, progress)
}

/// Samples of all wedges with the heights of their vertices (#V), and the vertex of each sample.
fn samples(atlas: &Atlas, heights: &[f64]) -> (Vec<Index>, Vec<fit::Sample>) {
    let of_vertex = |(vertex, wedges): (Index, &'_ [Index])| {
        let sample = move |&uv: &Index| fit::Sample {
            uv: atlas.uvs()[uv as usize].as_vec2(),
            height: heights[vertex as usize],
            rank: if atlas.dominant(vertex) == Some(uv) { fit::Rank::Dominant } else { fit::Rank::Secondary },
            on_seam: wedges.len() > 1,
        };
        wedges.iter().map(sample).map(|sample| (vertex, sample)).collect::<Vec<_>>()
    };
    (0..).zip(atlas.wedges().iter()).flat_map(of_vertex).unzip()
}

/// Interpolates numbers (#V, 0..=1) over the triangles of a surface; texels outside the charts are filled from their surroundings.
/// The result is row by row from the top. #rows·#columns
pub fn interpolate_greys(
    layout: TextureLayout,
    numbers: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<f32>, Cancelled> {
    let TextureLayout { surface, coverage, .. } = layout;
    let mut texels = per_texel(coverage.size(), Vec3::ZERO, progress, || {
        |column, row| match coverage.owner(column, row) {
            Some(owner) => Vec3::splat(in_triangle(surface, numbers, coverage.weights(owner, column, row)) as f32),
            None => Vec3::ZERO,
        }
    })?;
    gutter::pull_push(&mut texels, coverage);
    Ok(texels.into_iter().map(|t| t.x.clamp(0.0, 1.0)).collect())
}

/// Interpolated height at barycentric coordinates of a triangle; rounding never takes it outside the heights at the corners.
fn in_triangle(surface: &Surface, heights: &[f64], (triangle, weights): (Index, DVec3)) -> f64 {
    let corners = surface.triangle_corners()[triangle as usize];
    let h = DVec3::from(corners.map(|c| heights[surface.topology().vertex(c) as usize]));
    h.dot(weights).clamp(h.min_element(), h.max_element())
}

/// Fills an image on all threads, row by row; `row_worker` makes the function that gives the texels of a row.
fn per_texel<T, F>(
    size: Size,
    empty: T,
    progress: &dyn Progress,
    row_worker: impl Fn() -> F + Sync,
) -> Result<Vec<T>, Cancelled>
where
    T: Copy + Send + Sync,
    F: Fn(usize, usize) -> T,
{
    let mut texels = vec![empty; size.texels()];
    let parts = Parts::new(progress, size.height as usize);
    texels.par_chunks_mut(size.width as usize).enumerate().try_for_each(|(row, texels)| {
        parts.run(|| {
            let value = row_worker();
            for (column, texel) in texels.iter_mut().enumerate() {
                *texel = value(column, row);
            }
        })
    })?;
    Ok(texels)
}

#[cfg(test)]
mod tests;
