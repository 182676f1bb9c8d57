//! Pictures on the surface, and their interpolation between texels.
//!
//! ```
//! use glam::{Vec2, Vec3};
//! use image::RgbaImage;
//! use planish_render::settings::Sampling;
//! use planish_render::texture::{Content, Texture};
//!
//! // Two texels, black and white.
//! let texels = RgbaImage::from_raw(2, 1, vec![0, 0, 0, 255, 255, 255, 255, 255]).unwrap();
//! let colours = Texture::new(texels, Content::Colour).unwrap();
//! let still = [Vec2::ZERO; 2];
//! assert_eq!(colours.at(Vec2::new(0.75, 0.5), still, Sampling::Nearest), Vec3::ONE);
//! // Between them is half of the light.
//! assert!((colours.at(Vec2::splat(0.5), still, Sampling::Bilinear).x - 0.5).abs() < 1e-6);
//! assert_eq!(colours.levels().len(), 2);
//! ```

use crate::colour::{linear_from_byte, srgb_from_linear};
use crate::settings::Sampling;
use glam::{IVec2, Vec2, Vec3};
use image::RgbaImage;
use rayon::prelude::*;

/// Meaning of the numbers of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Colours: sRGB, blended as light.
    Colour,
    /// Anything else: numbers as they stand.
    Data,
}

/// A texture, repeated outside the unit square.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Each half as large as the one before, down to a single texel; of data only the first.
    levels: Vec<RgbaImage>,
    content: Content,
}

/// Textures of the triangles of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    all: Vec<Texture>,
    /// Texture index of each triangle, #T; empty where all have the first texture.
    of_triangles: Vec<Option<u32>>,
}

impl Textures {
    /// Gives one texture to all triangles.
    pub fn one(texture: Texture) -> Self {
        Self { all: vec![texture], of_triangles: Vec::new() }
    }

    /// `of_triangles`: for each triangle of the mesh its index in `all`, or none. None if an index is out of range.
    pub fn by_triangle(all: Vec<Texture>, of_triangles: Vec<Option<u32>>) -> Option<Self> {
        let inside = |index: &Option<u32>| index.is_none_or(|index| (index as usize) < all.len());
        of_triangles.iter().all(inside).then_some(Self { all, of_triangles })
    }

    /// Returns all textures, each once.
    pub fn all(&self) -> &[Texture] {
        &self.all
    }

    /// Returns the index in [`Self::all`] of a triangle's texture.
    pub fn of_triangle(&self, triangle: usize) -> Option<u32> {
        match self.of_triangles.get(triangle) {
            Some(index) => *index,
            None => (!self.all.is_empty()).then_some(0),
        }
    }
}

impl Texture {
    /// Wraps an image whose row 0 is the top; none if it has no texels.
    pub fn new(texels: RgbaImage, content: Content) -> Option<Self> {
        if texels.is_empty() {
            return None;
        }
        let mut levels = vec![texels];
        while content == Content::Colour
            && let Some(coarser) = levels.last().and_then(halved)
        {
            levels.push(coarser);
        }
        Some(Self { levels, content })
    }

    /// Returns the levels of detail, finest first.
    pub fn levels(&self) -> &[RgbaImage] {
        &self.levels
    }

    /// Returns the meaning of the numbers.
    pub fn content(&self) -> Content {
        self.content
    }

    /// Linear RGB at a texture coordinate (v up) whose derivatives over the picture are `dx` and `dy`.
    ///
    /// [`Sampling::Anisotropic`] is what GPUs make of it, each in its own way; here it is trilinear.
    pub fn at(&self, uv: Vec2, [dx, dy]: [Vec2; 2], sampling: Sampling) -> Vec3 {
        if !uv.is_finite() {
            return Vec3::ZERO;
        }
        match sampling {
            Sampling::Nearest => self.texel(0, (self.texel_from_uv(0, uv) + 0.5).floor().as_ivec2()),
            Sampling::Bilinear => self.bilinear(0, uv),
            Sampling::Bicubic => self.bicubic(uv),
            Sampling::Trilinear | Sampling::Anisotropic => {
                let size = self.size(0);
                let widest = (dx * size).length().max((dy * size).length());
                let level = widest.log2().clamp(0.0, (self.levels.len() - 1) as f32);
                // Not a number where uv does not change.
                let low = if level > 0.0 { level.floor() as usize } else { 0 };
                let high = (low + 1).min(self.levels.len() - 1);
                self.bilinear(low, uv).lerp(self.bilinear(high, uv), (level - low as f32).max(0.0))
            }
        }
    }

    fn size(&self, level: usize) -> Vec2 {
        let (width, height) = self.levels[level].dimensions();
        Vec2::new(width as f32, height as f32)
    }

    /// Texel coordinates (centres at integers, rows downwards) of a texture coordinate (v up).
    fn texel_from_uv(&self, level: usize, uv: Vec2) -> Vec2 {
        let flipped = Vec2::new(uv.x, 1.0 - uv.y);
        (flipped - flipped.floor()) * self.size(level) - 0.5
    }

    /// Interpolates bilinearly. Like the GPU, this blends light and not encoded values.
    fn bilinear(&self, level: usize, uv: Vec2) -> Vec3 {
        let p = self.texel_from_uv(level, uv);
        let low = p.floor();
        let weight = p - low;
        let corner = |dx, dy| self.texel(level, low.as_ivec2() + IVec2::new(dx, dy));
        let top = corner(0, 0).lerp(corner(1, 0), weight.x);
        let bottom = corner(0, 1).lerp(corner(1, 1), weight.x);
        top.lerp(bottom, weight.y)
    }

    fn bicubic(&self, uv: Vec2) -> Vec3 {
        let p = self.texel_from_uv(0, uv);
        let low = p.floor();
        let (across, down) = (b_spline(p.x - low.x), b_spline(p.y - low.y));
        let row = |j: usize| -> Vec3 {
            let texel = |i: usize| self.texel(0, low.as_ivec2() + IVec2::new(i as i32 - 1, j as i32 - 1));
            (0..4).map(|i| across[i] * down[j] * texel(i)).sum()
        };
        (0..4).map(row).sum()
    }

    fn texel(&self, level: usize, texel: IVec2) -> Vec3 {
        let image = &self.levels[level];
        let wrap = |i: i32, n: u32| i64::from(i).rem_euclid(i64::from(n)) as u32;
        let [r, g, b, _] = image.get_pixel(wrap(texel.x, image.width()), wrap(texel.y, image.height())).0;
        Vec3::from([r, g, b].map(|c| match self.content {
            Content::Colour => linear_from_byte(c),
            Content::Data => f32::from(c) / 255.0,
        }))
    }
}

/// Weights of a uniform cubic B-spline for the texels at −1, 0, 1 and 2.
fn b_spline(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    let middle = |t: f32, s: f32| 4.0 - 3.0 * t * t * (1.0 + s);
    [s * s * s, middle(t, s), middle(s, t), t * t * t].map(|w| w / 6.0)
}

/// Half the size, rounded down: each texel is the mean light of the area that it covers. None of a single texel.
fn halved(fine: &RgbaImage) -> Option<RgbaImage> {
    let (width, height) = fine.dimensions();
    if (width, height) == (1, 1) {
        return None;
    }
    let (columns, rows) = (shares(width), shares(height));
    let mut coarse = RgbaImage::new(columns.len() as u32, rows.len() as u32);
    let row_bytes = 4 * columns.len();
    coarse.par_chunks_mut(row_bytes).zip(&rows).for_each(|(pixels, row)| {
        for (pixel, column) in pixels.chunks_exact_mut(4).zip(&columns) {
            let mut sum = [0.0; 4];
            for &(y, down) in row {
                for &(x, across) in column {
                    let [r, g, b, a] = fine.get_pixel(x, y).0;
                    let light = [linear_from_byte(r), linear_from_byte(g), linear_from_byte(b), f32::from(a) / 255.0];
                    sum.iter_mut().zip(light).for_each(|(sum, c)| *sum += across * down * c);
                }
            }
            let [r, g, b, a] = sum;
            let bytes = [srgb_from_linear(r), srgb_from_linear(g), srgb_from_linear(b), a];
            pixel.copy_from_slice(&bytes.map(|c| (c * 255.0).round() as u8));
        }
    });
    Some(coarse)
}

/// Lists, for each of half as many texels along a side, the fine texels that it covers with their weights, which add up to one.
fn shares(fine: u32) -> Vec<Vec<(u32, f32)>> {
    let coarse = (fine / 2).max(1);
    let step = f64::from(fine) / f64::from(coarse);
    let covered = |i: u32| {
        let (from, to) = (f64::from(i) * step, f64::from(i + 1) * step);
        let share = |x: u32| (to.min(f64::from(x + 1)) - from.max(f64::from(x))) / step;
        (from as u32..(to.ceil() as u32).min(fine)).map(|x| (x, share(x) as f32)).filter(|s| s.1 > 0.0).collect()
    };
    (0..coarse).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    const STILL: [Vec2; 2] = [Vec2::ZERO; 2];

    /// Red top left, green top right, blue bottom left, white bottom right.
    fn four_colours() -> Texture {
        let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
        let image = RgbaImage::from_fn(2, 2, |x, y| {
            let [r, g, b] = colours[(2 * y + x) as usize];
            Rgba([r, g, b, 255])
        });
        Texture::new(image, Content::Colour).unwrap()
    }

    #[test]
    fn v_points_up_and_centres_are_exact() {
        let texture = four_colours();
        for sampling in [Sampling::Nearest, Sampling::Bilinear, Sampling::Trilinear] {
            let at = |x, y| texture.at(Vec2::new(x, y), STILL, sampling);
            assert_eq!([at(0.25, 0.75), at(0.75, 0.75), at(0.25, 0.25)], [Vec3::X, Vec3::Y, Vec3::Z], "{sampling:?}");
            assert_eq!(at(0.75, 0.25), Vec3::ONE, "{sampling:?}");
        }
    }

    #[test]
    fn light_is_blended_and_the_square_repeats() {
        let texture = four_colours();
        let at = |uv| texture.at(uv, STILL, Sampling::Bilinear);
        assert_eq!(at(Vec2::new(0.5, 0.5)), Vec3::splat(0.5));
        for uv in [Vec2::new(0.1, 0.9), Vec2::new(0.6, 0.3), Vec2::ZERO] {
            let shifted = at(uv + Vec2::new(3.0, -2.0));
            assert!(shifted.abs_diff_eq(at(uv), 1e-5), "{uv}: {shifted}");
        }
    }

    #[test]
    fn every_level_has_the_same_light() {
        // Sides that do not halve evenly.
        let image =
            RgbaImage::from_fn(13, 6, |x, y| Rgba([(x * 19) as u8, (y * 50) as u8, ((x + y) % 2 * 255) as u8, 255]));
        let texture = Texture::new(image, Content::Colour).unwrap();
        let sizes: Vec<_> = texture.levels().iter().map(RgbaImage::dimensions).collect();
        assert_eq!(sizes, [(13, 6), (6, 3), (3, 1), (1, 1)]);
        let mean = |image: &RgbaImage| {
            let sum: Vec3 = image
                .pixels()
                .map(|p| Vec3::new(p[0].into(), p[1].into(), p[2].into()).map(|c| linear_from_byte(c as u8)))
                .sum();
            sum / image.pixels().len() as f32
        };
        let first = mean(&texture.levels()[0]);
        // Each level rounds to a byte, which at these colours is 1 % of the light at most.
        texture.levels().iter().for_each(|l| assert!(mean(l).abs_diff_eq(first, 0.012), "{:?}", mean(l)));
    }

    #[test]
    fn far_away_a_texture_is_its_mean() {
        let texture = four_colours();
        let wide = [Vec2::new(4.0, 0.0), Vec2::ZERO];
        let mean = texture.at(Vec2::new(0.25, 0.75), wide, Sampling::Trilinear);
        assert!(mean.abs_diff_eq(Vec3::splat(0.5), 0.005), "{mean}");
    }

    #[test]
    fn splines_keep_a_constant() {
        for i in 0..=10 {
            let weights = b_spline(i as f32 / 10.0);
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6 && weights.iter().all(|w| *w >= 0.0));
        }
    }
}
