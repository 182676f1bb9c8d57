//! Pictures on the surface, and how they are sampled.

mod sampling;

use crate::colour::{Colour, linear_from_byte, pixel_from_linear};
use glam::{IVec2, Vec2, Vec3};
use image::RgbaImage;

/// An image that repeats outside the unit square, as a mip chain (Williams 1983).
#[derive(Clone, Debug)]
pub struct Texture {
    /// The image, and then each half as large as the one before, down to a single texel.
    levels: Vec<RgbaImage>,
}

/// A texture coordinate (v up), and how far it moves from one sample to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Where.
    pub uv: Vec2,
    /// To the sample on the right.
    pub dx: Vec2,
    /// To the sample below.
    pub dy: Vec2,
}

impl Texture {
    /// Wraps an sRGB image whose row 0 is the top; none if it has no texels. Smaller levels are means of light.
    pub fn new(texels: RgbaImage) -> Option<Self> {
        (texels.width() > 0 && texels.height() > 0).then(|| {
            let mut levels = vec![texels];
            while let Some(half) = levels.last().and_then(halved) {
                levels.push(half);
            }
            Self { levels }
        })
    }

    /// The image as it is stored and the smaller ones of the mip chain.
    pub fn levels(&self) -> &[RgbaImage] {
        &self.levels
    }

    /// The same normal map with green the other way: of one for which it points down, one for which it points up.
    #[must_use]
    pub fn with_green_up(mut self) -> Self {
        for level in &mut self.levels {
            level.pixels_mut().for_each(|pixel| pixel[1] = u8::MAX - pixel[1]);
        }
        self
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> Vec2 {
        size(&self.levels[0])
    }

    /// The stored numbers without sRGB, 0..1, bilinear between texel centres: for heights and normals.
    pub(crate) fn numbers_at(&self, uv: Vec2) -> Vec3 {
        sampling::bilinear(&self.levels[0], uv, |image, texel| stored(image, texel).encoded())
    }
}

fn size(image: &RgbaImage) -> Vec2 {
    Vec2::new(image.width() as f32, image.height() as f32)
}

/// The stored colour of a texel of an image that repeats.
fn stored(image: &RgbaImage, texel: IVec2) -> Colour {
    let wrap = |i: i32, n: u32| i64::from(i).rem_euclid(i64::from(n)) as u32;
    let [r, g, b, _] = image.get_pixel(wrap(texel.x, image.width()), wrap(texel.y, image.height())).0;
    Colour([r, g, b])
}

/// The next level: each texel is the mean of the light of those that it covers. None of a single texel.
fn halved(image: &RgbaImage) -> Option<RgbaImage> {
    let (width, height) = image.dimensions();
    if width == 1 && height == 1 {
        return None;
    }
    let half = |n: u32| (n / 2).max(1);
    // Of an odd number, the texels of the next level cover more than two, and share those between them.
    let span = |i: u32, n: u32| {
        let wide = f64::from(n) / f64::from(half(n));
        let (low, high) = (f64::from(i) * wide, f64::from(i + 1) * wide);
        (low as u32..(high.ceil() as u32).min(n))
            .map(move |k| (k, (f64::from(k + 1).min(high) - f64::from(k).max(low)) / wide))
    };
    Some(RgbaImage::from_fn(half(width), half(height), |x, y| {
        let (mut light, mut alpha) = (Vec3::ZERO, 0.0);
        for (row, share_of_row) in span(y, height) {
            for (column, share_of_column) in span(x, width) {
                let share = (share_of_row * share_of_column) as f32;
                let [r, g, b, a] = image.get_pixel(column, row).0;
                light += share * Vec3::from([r, g, b].map(linear_from_byte));
                alpha += share * f32::from(a);
            }
        }
        let [r, g, b] = pixel_from_linear(light);
        image::Rgba([r, g, b, alpha.round() as u8])
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Filter, Sampling};
    use image::Rgba;

    /// Red top left, green top right, blue bottom left, white bottom right.
    fn four_colours() -> Texture {
        let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
        Texture::new(RgbaImage::from_fn(2, 2, |x, y| {
            let [r, g, b] = colours[(2 * y + x) as usize];
            Rgba([r, g, b, 255])
        }))
        .unwrap()
    }

    fn at(texture: &Texture, uv: Vec2, filter: Filter) -> Vec3 {
        texture.colour_at(Footprint { uv, ..Footprint::default() }, Sampling { filter, ..Sampling::default() })
    }

    #[test]
    fn v_points_up_and_centres_are_exact() {
        let texture = four_colours();
        for filter in Filter::ALL {
            assert_eq!(at(&texture, Vec2::new(0.25, 0.75), filter), Vec3::X);
            assert_eq!(at(&texture, Vec2::new(0.75, 0.75), filter), Vec3::Y);
            assert_eq!(at(&texture, Vec2::new(0.25, 0.25), filter), Vec3::Z);
            assert_eq!(at(&texture, Vec2::new(0.75, 0.25), filter), Vec3::ONE);
        }
    }

    #[test]
    fn light_is_blended_and_the_square_repeats() {
        let texture = four_colours();
        assert_eq!(at(&texture, Vec2::new(0.5, 0.5), Filter::Bilinear), Vec3::splat(0.5));
        for uv in [Vec2::new(0.1, 0.9), Vec2::new(0.6, 0.3), Vec2::ZERO] {
            for filter in Filter::ALL {
                let shifted = at(&texture, uv + Vec2::new(3.0, -2.0), filter);
                assert!(shifted.abs_diff_eq(at(&texture, uv, filter), 1e-5), "{filter:?} {uv}: {shifted}");
            }
        }
    }

    #[test]
    fn each_level_keeps_the_mean_of_light() {
        let texture = Texture::new(RgbaImage::from_fn(7, 5, |x, y| Rgba([(36 * x) as u8, (50 * y) as u8, 90, 255])));
        let texture = texture.unwrap();
        let sizes: Vec<_> = texture.levels().iter().map(RgbaImage::dimensions).collect();
        assert_eq!(sizes, [(7, 5), (3, 2), (1, 1)]);
        let mean = |image: &RgbaImage| {
            let sum: Vec3 = image.pixels().map(|p| Colour([p[0], p[1], p[2]]).linear()).sum();
            sum / (image.width() * image.height()) as f32
        };
        let means: Vec<Vec3> = texture.levels().iter().map(mean).collect();
        // Each level is rounded to bytes: half a step in the brightest of them.
        assert!(means.iter().all(|m| m.abs_diff_eq(means[0], 0.006)), "{means:?}");
    }

    #[test]
    fn a_footprint_as_large_as_the_picture_sees_its_mean() {
        let texture = four_colours();
        let footprint = Footprint { uv: Vec2::new(0.3, 0.8), dx: Vec2::X, dy: Vec2::Y };
        let mean = Colour::linear(Colour([188, 188, 188]));
        for filter in [Filter::Trilinear, Filter::Anisotropic] {
            let found = texture.colour_at(footprint, Sampling { filter, ..Sampling::default() });
            assert!(found.abs_diff_eq(mean, 0.005), "{filter:?}: {found}");
        }
    }
}
