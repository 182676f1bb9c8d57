//! Images of heights, and the formula by which they are sampled.
//!
//! Texels are fitted to this formula when a map is baked, and displacement evaluates it when the map is applied.

use glam::{DVec2, Vec2};

/// Size of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Number of texels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Size {
    /// Size of a square image.
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
    /// Converts a texture coordinate, whose v points up, to texel space, whose y points down.
    pub fn texel_from_uv(self, uv: DVec2) -> DVec2 {
        DVec2::new(uv.x, 1.0 - uv.y) * self.scale()
    }
    /// Texture coordinate of the centre of a texel.
    pub fn uv_from_texel(self, column: usize, row: usize) -> DVec2 {
        let p = (DVec2::new(column as f64, row as f64) + 0.5) / self.scale();
        DVec2::new(p.x, 1.0 - p.y)
    }
}

/// Image of heights.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Size of the image.
    pub size: Size,
    /// Heights, row by row from the top, model units. #rows·#columns
    pub texels: Vec<f32>,
}

impl HeightMap {
    /// Lowest and highest texel, model units.
    pub fn range(&self) -> [f32; 2] {
        self.texels.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], t| [low.min(*t), high.max(*t)])
    }
}

/// Accuracy of the weights of bilinear sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// Weights in single precision, as the shader computes them.
    #[default]
    Exact,
    /// Weights rounded to 8 bits, as in the samplers of many GPUs.
    EightBits,
}

/// The four texels that bilinear sampling blends at a texture coordinate, computed as the shader does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Indices in the image: upper left, upper right, lower left, lower right.
    texels: [usize; 4],
    /// Weights of the right and of the lower texels.
    w: Vec2,
}

impl Footprint {
    pub(crate) fn new(uv: Vec2, size: Size) -> Self {
        let p = Vec2::new(uv.x, 1.0 - uv.y) * Vec2::new(size.width as f32, size.height as f32) - 0.5;
        let low = p.floor();
        // `as` saturates, as the clamp in the shader does.
        let column = |x: f32| (x as i64).clamp(0, i64::from(size.width) - 1) as usize;
        let row = |y: f32| (y as i64).clamp(0, i64::from(size.height) - 1) as usize;
        let texel = |x: f32, y: f32| row(y) * size.width as usize + column(x);
        let (right, below) = (low.x + 1.0, low.y + 1.0);
        let texels = [texel(low.x, low.y), texel(right, low.y), texel(low.x, below), texel(right, below)];
        Self { texels, w: p - low }
    }
    pub(crate) fn with(self, weights: Weights) -> Self {
        match weights {
            Weights::Exact => self,
            Weights::EightBits => Self { w: (self.w * 256.0).round() / 256.0, ..self },
        }
    }
    /// Bilinear interpolation of the texels of an image, in single precision.
    pub(crate) fn sample(&self, image: &[f32]) -> f32 {
        // In this form equal texels give exactly their value, whatever the weight.
        let blend = |a: f32, b: f32, w: f32| a + (b - a) * w;
        let [a, b, c, d] = self.texels.map(|texel| image[texel]);
        blend(blend(a, b, self.w.x), blend(c, d, self.w.x), self.w.y)
    }
    /// Distinct texels with their weights, which add up to one.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (usize, f64)> {
        let (x, y) = (f64::from(self.w.x), f64::from(self.w.y));
        let mut weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let texels = self.texels;
        // At the border of the image two or four of them are the same one.
        for k in 1..4 {
            if let Some(first) = (0..k).find(|&j| texels[j] == texels[k]) {
                weights[first] += weights[k];
                weights[k] = 0.0;
            }
        }
        texels.into_iter().zip(weights).filter(|(_, w)| *w > 0.0)
    }
}
