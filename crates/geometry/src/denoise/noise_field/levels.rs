//! Levels of the noise: from one figure for each region to a deviation at each vertex.

use super::regions::Regions;
use crate::denoise::noise_level::median;
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use rayon::prelude::*;

/// Mean of the logarithms of the positive values at these vertices; 0 without any.
pub(super) fn log_mean(members: &[Index], values: &[f64]) -> f64 {
    let logs = members.iter().map(|&v| values[v as usize]).filter(|x| *x > 0.0).map(f64::ln);
    let (sum, count) = logs.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Deviation of the noise in a region: its logarithm, and what it is the logarithm of.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {
    /// A length, model units, the same for short and long edges.
    Absolute(f64),
    /// A part of the local edges.
    Relative(f64),
}

/// Deviation in each region that has noise. `relative` are their logarithms as they were measured, local edges, and `edges` the
/// logarithms of these edges.
///
/// A region alone tells its deviation to an eighth, and creases add to it. So what differs little from the median of the component
/// is taken to be the same there: either the same length or the same part of the local edges, whichever varies less.
pub(super) fn shrunken(relative: &[Option<f64>], edges: &[f64], regions: &Regions) -> Vec<Option<Level>> {
    /// Differences of logarithms up to which regions are alike, and from which they certainly differ.
    const ALIKE: [f64; 2] = [0.25, 0.6];
    let components = regions.component.iter().max().map_or(0, |c| *c as usize + 1);
    let mut members = vec![Vec::new(); components];
    for (region, (relative, component)) in relative.iter().zip(&regions.component).enumerate() {
        members[*component as usize].extend(relative.map(|_| region));
    }
    let mut out = vec![None; relative.len()];
    for members in members.iter().filter(|members| !members.is_empty()) {
        let of_edges: Vec<f64> = members.iter().filter_map(|&r| relative[r]).collect();
        let lengths: Vec<f64> = members.iter().zip(&of_edges).map(|(&r, x)| x + edges[r]).collect();
        let (middle_of_edges, spread_of_edges) = middle_and_spread(&of_edges);
        let (middle, spread) = middle_and_spread(&lengths);
        for ((&region, x), length) in members.iter().zip(&of_edges).zip(&lengths) {
            let is_length = spread <= spread_of_edges;
            let difference = if is_length { length - middle } else { x - middle_of_edges };
            let certain = difference.abs().max(2.0 * spread.min(spread_of_edges));
            let kept = ((certain - ALIKE[0]) / (ALIKE[1] - ALIKE[0])).clamp(0.0, 1.0);
            let lost = (1.0 - kept) * difference;
            out[region] = Some(if is_length { Level::Absolute(length - lost) } else { Level::Relative(x - lost) });
        }
    }
    out
}

/// Median, and median of the absolute differences from it.
fn middle_and_spread(values: &[f64]) -> (f64, f64) {
    let middle = median(values.to_vec());
    (middle, median(values.iter().map(|x| (x - middle).abs()).collect()))
}

/// Deviation at each vertex over its local edges, from the levels of the regions, evened out over a few rings; 0 where a region
/// has none. #V
pub(super) fn spread(surface: &Surface, regions: &Regions, levels: &[Option<Level>], local_edge: &[f64]) -> Vec<f64> {
    const ROUNDS: usize = 12;
    let rings = surface.topology().rings();
    let at = |region: &Index| match levels[*region as usize] {
        Some(Level::Absolute(log) | Level::Relative(log)) => log,
        None => f64::NEG_INFINITY,
    };
    let mut logs: Vec<f64> = regions.of_vertex.iter().map(at).collect();
    for _ in 0..ROUNDS {
        let even = |v: usize| {
            if !logs[v].is_finite() {
                return logs[v];
            }
            let around = rings.get(v as Index).iter().map(|&w| logs[w as usize]).filter(|l| l.is_finite());
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), l| (sum + l, count + 1.0));
            if count == 0.0 { logs[v] } else { 0.5 * (logs[v] + sum / count) }
        };
        logs = (0..logs.len()).into_par_iter().map(even).collect();
    }
    let relative = |v: usize| match levels[regions.of_vertex[v] as usize] {
        Some(Level::Absolute(_)) if local_edge[v] > 0.0 => logs[v].exp() / local_edge[v],
        Some(Level::Relative(_)) => logs[v].exp(),
        _ => 0.0,
    };
    (0..logs.len()).map(relative).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::noise_field::{LEAST_REGION, RINGS};
    use crate::mesh::shapes;

    fn regions(surface: &Surface) -> Regions {
        Regions::of(surface.topology(), 0, RINGS, LEAST_REGION)
    }

    #[test]
    fn regions_that_differ_little_are_alike_and_those_that_differ_much_stay_as_they_are() {
        let regions = regions(&shapes::sphere(5));
        let count = regions.vertices.len();
        assert!(count > 20);
        // A deviation of a twentieth of the edges in most regions, of a little more in one and of much more in another.
        let mut relative = vec![Some(0.05f64.ln()); count];
        relative[3] = Some(0.05f64.ln() + 0.2);
        relative[7] = Some(0.05f64.ln() + 2.0);
        relative[9] = None;
        // Edges that differ say that it is a part of the edges, and edges that are alike leave the length.
        for edges in [vec![0.0; count], (0..count).map(|k| 0.3 * k as f64).collect()] {
            let found = shrunken(&relative, &edges, &regions);
            for (k, (level, relative)) in found.iter().zip(&relative).enumerate() {
                let expected = relative.map(|x| if k == 3 { 0.05f64.ln() } else { x });
                let found = level.map(|level| match level {
                    Level::Absolute(log) => log - edges[k],
                    Level::Relative(log) => log,
                });
                assert!(
                    found.zip(expected).is_some_and(|(a, b)| (a - b).abs() < 1e-12) || found == expected,
                    "{k}: {found:?} and not {expected:?}"
                );
            }
        }
    }

    #[test]
    fn a_level_is_kept_where_all_have_it_and_a_jump_becomes_a_slope() {
        let ball = shapes::sphere(4);
        let regions = regions(&ball);
        let edge = vec![1.0; ball.positions().len()];
        let alike = spread(&ball, &regions, &vec![Some(Level::Relative(-2.0)); regions.vertices.len()], &edge);
        assert!(alike.iter().all(|x| (x.ln() + 2.0).abs() < 1e-12));
        let halves: Vec<_> = (0..regions.vertices.len())
            .map(|r| Some(Level::Relative(if r < regions.vertices.len() / 2 { -2.0 } else { -1.0 })))
            .collect();
        let logs: Vec<f64> = spread(&ball, &regions, &halves, &edge).into_iter().map(f64::ln).collect();
        assert!(logs.iter().all(|log| (-2.0..=-1.0).contains(log)));
        // Twelve rounds of half a step spread a jump like a Gaussian of √6 edges and a little more: 0.17 an edge where it is steepest.
        let jumps = ball.topology().edges().iter().map(|e| (logs[e[0] as usize] - logs[e[1] as usize]).abs());
        let steepest = jumps.fold(0.0, f64::max);
        assert!(steepest > 0.05 && steepest < 0.25, "{steepest}");
    }
}
