//! The picture on the surface.

use crate::colour::Colour;
use glam::{IVec2, Vec2, Vec3};
use image::RgbaImage;

/// A base-colour texture (sRGB), repeated outside the unit square.
#[derive(Clone, Debug)]
pub struct Texture {
    texels: RgbaImage,
}

impl Texture {
    /// Wraps an image whose row 0 is the top; none if it has no texels.
    pub fn new(texels: RgbaImage) -> Option<Self> {
        (texels.width() > 0 && texels.height() > 0).then_some(Self { texels })
    }

    /// Texel coordinates (centres at integers, rows downwards) of a texture coordinate (v up).
    fn texel_from_uv(&self, uv: Vec2) -> Vec2 {
        let size = Vec2::new(self.texels.width() as f32, self.texels.height() as f32);
        let unit = uv - uv.floor();
        Vec2::new(unit.x, 1.0 - unit.y) * size - 0.5
    }

    /// Linear RGB, bilinear between texel centres. Like the GPU, it blends light and not encoded values.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        if !uv.is_finite() {
            return Vec3::ZERO;
        }
        let p = self.texel_from_uv(uv);
        let low = p.floor();
        let weight = p - low;
        let corner = |dx, dy| self.linear(low.as_ivec2() + IVec2::new(dx, dy));
        let top = corner(0, 0).lerp(corner(1, 0), weight.x);
        let bottom = corner(0, 1).lerp(corner(1, 1), weight.x);
        top.lerp(bottom, weight.y)
    }

    fn linear(&self, texel: IVec2) -> Vec3 {
        let wrap = |i: i32, n: u32| i64::from(i).rem_euclid(i64::from(n)) as u32;
        let (x, y) = (wrap(texel.x, self.texels.width()), wrap(texel.y, self.texels.height()));
        let [r, g, b, _] = self.texels.get_pixel(x, y).0;
        Colour([r, g, b]).linear()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    #[test]
    fn v_points_up_and_centres_are_exact() {
        let texture = four_colours();
        assert_eq!(texture.at(Vec2::new(0.25, 0.75)), Vec3::X);
        assert_eq!(texture.at(Vec2::new(0.75, 0.75)), Vec3::Y);
        assert_eq!(texture.at(Vec2::new(0.25, 0.25)), Vec3::Z);
        assert_eq!(texture.at(Vec2::new(0.75, 0.25)), Vec3::ONE);
    }

    #[test]
    fn light_is_blended_and_the_square_repeats() {
        let texture = four_colours();
        assert_eq!(texture.at(Vec2::new(0.5, 0.5)), Vec3::splat(0.5));
        for uv in [Vec2::new(0.1, 0.9), Vec2::new(0.6, 0.3), Vec2::ZERO] {
            let shifted = texture.at(uv + Vec2::new(3.0, -2.0));
            assert!(shifted.abs_diff_eq(texture.at(uv), 1e-5), "{uv}: {shifted}");
        }
    }
}
