//! Places charts into the unit square, all at one scale, without overlap and with a gap.
//!
//! Bruno Lévy et al. Least squares conformal maps for automatic texture atlas generation.
//! SIGGRAPH 2002, section 4, with the charts' full shapes in place of their horizons: small charts
//! may lie in the holes and bays of large ones.

use crate::chart::Chart;
use crate::mask::Mask;
use glam::DVec2;

/// Cells along the square's side.
const CELLS: usize = 512;
/// Empty cells between two charts and along the border: 1/128 of the side.
const GAP: usize = 4;
/// Share of the square that the charts fill, in percent: tried from the top.
const MAX_USE: u32 = 70;
const MIN_USE: u32 = 33;
/// Directions tried for the tightest upright box, over a quarter turn.
const DIRECTIONS: usize = 45;

/// Moves, turns and scales the charts into the unit square.
pub(crate) fn pack(charts: &mut [Chart]) {
    for chart in charts.iter_mut() {
        *chart = upright(chart);
    }
    let area: f64 = charts.iter().map(Chart::area).sum();
    // A larger scale may fit by luck where a smaller one does not: no bisection.
    let mut scales = (MIN_USE..MAX_USE).rev().map(|percent| f64::from(percent) / 100.0 / area);
    let packed = scales.find_map(|scale2| try_pack(charts, scale2.sqrt()));
    assert!(packed.is_some(), "charts so awkward that they cannot fill a third of a square");
    for (chart, packed) in charts.iter_mut().zip(packed.into_iter().flatten()) {
        *chart = packed;
    }
}

/// Charts at the given scale, or none if they do not fit.
fn try_pack(charts: &[Chart], scale: f64) -> Option<Vec<Chart>> {
    let mut taken = Mask::new(CELLS, CELLS);
    let mut packed = charts.to_vec();
    let mut order: Vec<usize> = (0..charts.len()).collect();
    let half_rim = |k: usize| size(&charts[k]).element_sum();
    order.sort_by(|&a, &b| half_rim(b).total_cmp(&half_rim(a)));
    for k in order {
        let mut best: Option<(usize, usize, usize, Chart, Mask)> = None;
        for turn in eighth_turns() {
            let chart = at_origin(&charts[k], turn * scale * CELLS as f64);
            let mask = Mask::touched(&chart);
            let lowest = best.as_ref().map_or(usize::MAX, |b| b.0);
            if let Some((x, y)) = first_fit(&taken, &mask, lowest) {
                best = Some((y + mask.height(), x, y, chart, mask));
            }
        }
        let (_, x, y, chart, mask) = best?;
        taken.insert(&mask, x, y);
        packed[k] = chart;
        for uv in &mut packed[k].uvs {
            *uv = (*uv + DVec2::new(x as f64, y as f64)) / CELLS as f64;
        }
    }
    Some(packed)
}

/// Unit complex numbers of the orientations that a chart is tried in.
fn eighth_turns() -> [DVec2; 8] {
    let diagonal = DVec2::splat(std::f64::consts::FRAC_1_SQRT_2);
    [0, 1, 2, 3, 4, 5, 6, 7].map(|k| {
        let quarter = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y][k / 2];
        if k % 2 == 0 { quarter } else { quarter.rotate(diagonal) }
    })
}

/// Lowest, then leftmost place of a mask that keeps the gap and stays below row `lowest`.
fn first_fit(taken: &Mask, mask: &Mask, lowest: usize) -> Option<(usize, usize)> {
    let end_x = (CELLS - GAP).checked_sub(mask.width)?;
    let end_y = (CELLS - GAP).checked_sub(mask.height())?;
    let wide = mask.dilated(GAP);
    for y in (GAP..=end_y).take_while(|y| y + mask.height() < lowest) {
        for x in GAP..=end_x {
            if !taken.meets(&wide, x - GAP, y - GAP) {
                return Some((x, y));
            }
        }
    }
    None
}

/// The chart turned so that its upright bounding box is smallest, and wider than high.
fn upright(chart: &Chart) -> Chart {
    let turned = |k: usize| {
        // Rounded, because the last bit of a sine differs between machines.
        let angle = std::f64::consts::FRAC_PI_2 * k as f64 / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        at_origin(chart, DVec2::new(cos, sin).map(|x| (x * 1e9).round() / 1e9))
    };
    let mut best = turned(0);
    for k in 1..DIRECTIONS {
        let next = turned(k);
        if size(&next).element_product() < 0.999 * size(&best).element_product() {
            best = next;
        }
    }
    best
}

/// The chart times a complex number, moved so that its bounding box starts at the origin.
fn at_origin(chart: &Chart, factor: DVec2) -> Chart {
    let mut chart = chart.clone();
    for uv in &mut chart.uvs {
        *uv = factor.rotate(*uv);
    }
    let low = chart.uvs.iter().fold(DVec2::INFINITY, |low, uv| low.min(*uv));
    for uv in &mut chart.uvs {
        *uv -= low;
    }
    chart
}

/// Size of the bounding box.
fn size(chart: &Chart) -> DVec2 {
    let low = chart.uvs.iter().fold(DVec2::INFINITY, |low, uv| low.min(*uv));
    let high = chart.uvs.iter().fold(DVec2::NEG_INFINITY, |high, uv| high.max(*uv));
    high - low
}
