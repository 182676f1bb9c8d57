//! From heights at vertices to texels: raster → gutter (or scattered samples everywhere) → fit.
//!
//! Texel space has its origin at the top left corner of the image, x to the right and y down; the centre of texel
//! (i, j) is at (i + ½, j + ½). [`Size::texel_from_uv`] is the only place that turns v over.

pub mod findings;
pub mod fit;
pub mod normal_map;
pub mod resolution;
pub mod tangents;

pub mod per_vertex;

mod gutter;
mod raster;
mod scatter;

pub use raster::Coverage;

use crate::atlas::Atlas;
use crate::named;
use crate::progress::{Cancelled, Parts, Progress};
use crate::ragged::Index;
use crate::surface::Surface;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use scatter::Scatter;

/// Width and height of an image, texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// As many rows as columns.
    pub fn square(side: u32) -> Self {
        Self { width: side, height: side }
    }
    /// Number of texels.
    pub fn texels(self) -> usize {
        self.width as usize * self.height as usize
    }
    fn scale(self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height))
    }
    /// Texel space from a texture coordinate, whose v points up.
    pub fn texel_from_uv(self, uv: DVec2) -> DVec2 {
        DVec2::new(uv.x, 1.0 - uv.y) * self.scale()
    }
    /// Texture coordinate of the centre of a texel.
    pub fn uv_from_texel(self, column: usize, row: usize) -> DVec2 {
        let p = (DVec2::new(column as f64, row as f64) + 0.5) / self.scale();
        DVec2::new(p.x, 1.0 - p.y)
    }
}

named! {
    /// How texels between vertices are filled.
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
    /// What is done to the texels that vertices sample.
    #[derive(Default)]
    pub enum Texels {
        /// Texels are fitted until sampling gives each vertex its exact height.
        #[default]
        Fitted = "fitted",
        /// Texels stay as interpolated.
        Interpolated = "interpolated",
    }
}

/// Heights on texels.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Of the image.
    pub size: Size,
    /// Row by row from the top, model units. #rows·#columns
    pub texels: Vec<f32>,
}

impl HeightMap {
    /// The lowest and the highest texel, model units.
    pub fn range(&self) -> [f32; 2] {
        self.texels.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], t| [low.min(*t), high.max(*t)])
    }
}

/// Spreads heights (#V, model units) over the texture; every texel gets one, inside charts and out.
///
/// All values lie between the lowest and the highest height.
pub fn bake(
    surface: &Surface,
    atlas: &Atlas,
    heights: &[f64],
    coverage: &Coverage,
    interpolation: Interpolation,
    progress: &dyn Progress,
) -> Result<HeightMap, Cancelled> {
    let size = coverage.size();
    progress.stage("interpolating");
    let wedges = match interpolation {
        Interpolation::Barycentric => atlas.outline(surface),
        _ => (0..atlas.uvs().len() as Index).collect(),
    };
    let scatter = Scatter::new(atlas, heights, &wedges, interpolation);
    let texels = per_texel(size, 0.0, progress, || {
        let sampler = scatter.sampler();
        let (scatter, surface) = (&scatter, &surface);
        move |column, row| {
            let uv = size.uv_from_texel(column, row);
            let height = match interpolation {
                Interpolation::Barycentric => match coverage.owner(column, row) {
                    Some(t) => in_triangle(surface, heights, coverage.weights(t, column, row)),
                    None => sampler.linear(uv),
                },
                Interpolation::Natural => sampler.natural(uv),
                Interpolation::Idw => scatter.inverse_distance(uv),
                Interpolation::Nearest => scatter.nearest(uv),
            };
            height as f32
        }
    })?;
    Ok(HeightMap { size, texels })
}

/// How exact a fitted map shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exactness {
    /// Step between two values of what the map will be encoded in, as a share of its range.
    pub quantum: f64,
    /// How far a vertex may be off after encoding, quanta; half of one is lost to encoding itself.
    pub tolerance: f64,
}

impl Exactness {
    /// Share of the range at which a sample counts as met by the solver. Texels are in single precision whatever they
    /// are encoded in.
    fn residual(self) -> f64 {
        self.quantum.max(f64::from(f32::EPSILON)) / 8.0
    }
    /// Share of the range that a sample may be off before encoding.
    fn allowed(self) -> f64 {
        ((self.tolerance - 0.5) * self.quantum).max(self.residual())
    }
}

/// Moves the texels of a map until each wedge samples the height of its vertex (#V, model units), as far as the layout
/// allows, to an eighth of a quantum; texels may leave the range of the heights by a quarter of it.
pub fn fit(
    map: &mut HeightMap,
    atlas: &Atlas,
    heights: &[f64],
    exactness: Exactness,
    progress: &dyn Progress,
) -> Result<fit::Missed, Cancelled> {
    let mut samples = Vec::new();
    for (vertex, wedges) in (0..).zip(atlas.wedges().iter()) {
        samples.extend(wedges.iter().map(|&uv| fit::Sample {
            uv: atlas.uvs()[uv as usize].as_vec2(),
            height: heights[vertex as usize],
            rank: if atlas.dominant(vertex) == Some(uv) { fit::Rank::Dominant } else { fit::Rank::Other },
            on_seam: wedges.len() > 1,
        }));
    }
    fit::fit(&mut map.texels, map.size, &samples, exactness, progress)
}

/// Value at a place in a triangle; never outside the values at its corners, whatever the rounding.
fn in_triangle(surface: &Surface, heights: &[f64], (triangle, weights): (Index, DVec3)) -> f64 {
    let corners = surface.triangle_corners()[triangle as usize];
    let h = DVec3::from(corners.map(|c| heights[surface.topology().vertex(c) as usize]));
    h.dot(weights).clamp(h.min_element(), h.max_element())
}

/// Fills an image row by row on all threads. Each row gets a function of its own from `row_worker`.
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
