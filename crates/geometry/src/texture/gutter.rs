//! Values for texels outside the charts.

use super::{Coverage, Size};
use glam::Vec3;

/// Fills the texels that no triangle owns from their surroundings, near ones from near, by averaging down to a single
/// texel and coming back (pull-push: Gortler, Grzeszczuk, Szeliski, Cohen. The lumigraph. SIGGRAPH 1996). For vectors
/// whose length means nothing.
pub(super) fn pull_push(texels: &mut [Vec3], coverage: &Coverage) {
    let size = coverage.size();
    let width = size.width as usize;
    for (i, texel) in texels.iter_mut().enumerate() {
        if coverage.owner(i % width, i / width).is_none() {
            *texel = Vec3::ZERO;
        }
    }
    fill(texels, size);
}

/// Zero stands for "no value".
fn fill(texels: &mut [Vec3], size: Size) {
    if size.texels() <= 1 {
        return;
    }
    let half = Size { width: size.width.div_ceil(2), height: size.height.div_ceil(2) };
    let (width, coarse_width) = (size.width as usize, half.width as usize);
    let mut coarse = vec![Vec3::ZERO; half.texels()];
    for (i, texel) in texels.iter().enumerate() {
        coarse[(i / width / 2) * coarse_width + i % width / 2] += *texel;
    }
    for texel in &mut coarse {
        *texel = texel.normalize_or_zero();
    }
    fill(&mut coarse, half);
    for (i, texel) in texels.iter_mut().enumerate() {
        if *texel == Vec3::ZERO {
            *texel = coarse[(i / width / 2) * coarse_width + i % width / 2];
        }
    }
}
