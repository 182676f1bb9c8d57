//! Filling of the texels outside the charts.

use super::{Coverage, Size};
use glam::{Vec3, Vec4};

/// Fills the texels that no triangle owns from their surroundings, smoothly: averages down to a single texel, then
/// comes back (pull-push: Gortler, Grzeszczuk, Szeliski, Cohen. The lumigraph. SIGGRAPH 1996).
pub(super) fn pull_push(texels: &mut [Vec3], coverage: &Coverage) {
    let size = coverage.size();
    let width = size.width as usize;
    let owned = |i: usize| coverage.owner(i % width, i / width).is_some();
    let known = |(i, texel): (usize, &Vec3)| if owned(i) { texel.extend(1.0) } else { Vec4::ZERO };
    let mut weighted: Vec<Vec4> = texels.iter().enumerate().map(known).collect();
    fill(&mut weighted, size);
    for (texel, filled) in texels.iter_mut().zip(weighted) {
        *texel = filled.truncate();
    }
}

/// Values times their weight, and the weight, 0..=1; all weights are 1 afterwards if any was above 0.
fn fill(texels: &mut [Vec4], size: Size) {
    if size.texels() <= 1 {
        for texel in texels.iter_mut().filter(|t| t.w > 0.0) {
            *texel /= texel.w;
        }
        return;
    }
    let half = Size { width: size.width.div_ceil(2), height: size.height.div_ceil(2) };
    let (width, coarse_width) = (size.width as usize, half.width as usize);
    let mut coarse = vec![Vec4::ZERO; half.texels()];
    for (i, texel) in texels.iter().enumerate() {
        coarse[(i / width / 2) * coarse_width + i % width / 2] += *texel;
    }
    // Four known texels are not better than one: what is known at a level must not be thinned out by far values.
    for texel in coarse.iter_mut().filter(|t| t.w > 1.0) {
        *texel /= texel.w;
    }
    fill(&mut coarse, half);
    let last = [half.width as usize - 1, half.height as usize - 1];
    for (i, texel) in texels.iter_mut().enumerate().filter(|(_, t)| t.w < 1.0) {
        // Bilinear: of the two nearest coarse texels in each direction the near one counts three quarters.
        let [x, y] = [i % width, i / width];
        let near = [(x / 2).min(last[0]), (y / 2).min(last[1])];
        let neighbour =
            |near: usize, odd: bool, last: usize| if odd { (near + 1).min(last) } else { near.saturating_sub(1) };
        let far = [neighbour(near[0], x % 2 == 1, last[0]), neighbour(near[1], y % 2 == 1, last[1])];
        let at = |x: usize, y: usize| coarse[y * coarse_width + x];
        let row = |y: usize| at(near[0], y) * 0.75 + at(far[0], y) * 0.25;
        *texel += (row(near[1]) * 0.75 + row(far[1]) * 0.25) * (1.0 - texel.w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_texels_stay_and_unknown_ones_lie_between_them() {
        let size = Size { width: 7, height: 5 };
        let mut texels = vec![Vec4::ZERO; 35];
        texels[0] = Vec4::new(1.0, 0.0, 0.0, 1.0);
        texels[34] = Vec4::new(0.0, 1.0, 0.0, 1.0);
        fill(&mut texels, size);
        assert_eq!((texels[0], texels[34]), (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0)));
        for t in &texels {
            assert!((t.w - 1.0).abs() < 1e-6 && (t.x + t.y - 1.0).abs() < 1e-6 && t.x >= 0.0 && t.y >= 0.0, "{t}");
        }
        assert!(texels[1].x > 0.5 && texels[33].y > 0.5, "near texels count more");
    }

    #[test]
    fn nothing_known_stays_nothing() {
        let mut texels = vec![Vec4::ZERO; 12];
        fill(&mut texels, Size { width: 4, height: 3 });
        assert!(texels.iter().all(|t| *t == Vec4::ZERO));
    }
}
