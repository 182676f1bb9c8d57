//! Reading a texture between and beyond its texels. Twin of `shaders/pictures.wgsl` and of the samplers of GPUs.

use super::{Footprint, Texture, size, stored};
use crate::settings::{Filter, Sampling};
use glam::{IVec2, Vec2, Vec3};
use image::RgbaImage;

impl Texture {
    /// Linear RGB. Like the GPU, it blends light and not encoded values.
    pub fn colour_at(&self, footprint: Footprint, sampling: Sampling) -> Vec3 {
        let uv = footprint.uv;
        if !uv.is_finite() {
            return Vec3::ZERO;
        }
        match sampling.filter {
            Filter::Nearest => {
                let texel = (texel_from_uv(&self.levels[0], uv) + 0.5).floor();
                light(&self.levels[0], texel.as_ivec2())
            }
            Filter::Bilinear => bilinear(&self.levels[0], uv, light),
            Filter::Bicubic => bicubic(&self.levels[0], uv),
            Filter::Trilinear => {
                let longest = [footprint.dx, footprint.dy].map(|d| (d * self.size()).length());
                self.trilinear(uv, longest[0].max(longest[1]))
            }
            Filter::Anisotropic => self.anisotropic(footprint, sampling.anisotropy),
        }
    }

    /// Between the two levels on which a pixel is about one texel wide; it is `width` texels wide on the first.
    fn trilinear(&self, uv: Vec2, width: f32) -> Vec3 {
        let last = (self.levels.len() - 1) as f32;
        let level = width.max(1.0).log2().min(last);
        let (fine, share) = (level.floor(), level - level.floor());
        let at = |level: f32| bilinear(&self.levels[level.min(last) as usize], uv, light);
        if share == 0.0 { at(fine) } else { at(fine).lerp(at(fine + 1.0), share) }
    }

    /// The mean of several of these along the longer side of the footprint, each as wide as the shorter one.
    fn anisotropic(&self, footprint: Footprint, most: u16) -> Vec3 {
        let [dx, dy] = [footprint.dx, footprint.dy].map(|d| (d * self.size()).length());
        let (longer, long, short) = if dx > dy { (footprint.dx, dx, dy) } else { (footprint.dy, dy, dx) };
        let count = (long / short.max(1e-6)).min(f32::from(most)).ceil().max(1.0);
        let width = long / count;
        let at = |i: u32| {
            let along = (i as f32 + 0.5) / count - 0.5;
            self.trilinear(footprint.uv + along * longer, width)
        };
        (0..count as u32).map(at).sum::<Vec3>() / count
    }
}

/// Texel coordinates (centres at integers, rows downwards) of a texture coordinate (v up).
fn texel_from_uv(image: &RgbaImage, uv: Vec2) -> Vec2 {
    let unit = uv - uv.floor();
    Vec2::new(unit.x, 1.0 - unit.y) * size(image) - 0.5
}

fn light(image: &RgbaImage, texel: IVec2) -> Vec3 {
    stored(image, texel).linear()
}

/// Between the nearest four texels, read by `read`.
pub(super) fn bilinear(image: &RgbaImage, uv: Vec2, read: impl Fn(&RgbaImage, IVec2) -> Vec3) -> Vec3 {
    let p = texel_from_uv(image, uv);
    let low = p.floor();
    let w = p - low;
    let corner = |dx, dy| read(image, low.as_ivec2() + IVec2::new(dx, dy));
    // As the shader does it: equal texels give just that value.
    let blend = |a: Vec3, b: Vec3, w: f32| a + (b - a) * w;
    blend(blend(corner(0, 0), corner(1, 0), w.x), blend(corner(0, 1), corner(1, 1), w.x), w.y)
}

/// Between the nearest sixteen texels.
///
/// Robert G. Keys. Cubic convolution interpolation for digital image processing. 1981, with a = −½ (Catmull-Rom).
fn bicubic(image: &RgbaImage, uv: Vec2) -> Vec3 {
    let p = texel_from_uv(image, uv);
    let low = p.floor();
    let (wx, wy) = (cubic_weights(p.x - low.x), cubic_weights(p.y - low.y));
    let mut sum = Vec3::ZERO;
    for (y, wy) in (-1..).zip(wy) {
        for (x, wx) in (-1..).zip(wx) {
            sum += wy * wx * light(image, low.as_ivec2() + IVec2::new(x, y));
        }
    }
    // The kernel has negative lobes.
    sum.clamp(Vec3::ZERO, Vec3::ONE)
}

fn cubic_weights(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}
