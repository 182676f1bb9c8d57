//! Coordinates that were rounded to a grid.

use glam::DVec3;

/// Step of the grid on which the coordinates of each axis lie; `None` for an axis whose coordinates lie on none.
pub(super) fn steps(positions: &[DVec3]) -> [Option<f64>; 3] {
    [0, 1, 2].map(|axis| step(positions.iter().map(|p| p[axis]).collect()))
}

/// Whether all axes were rounded to one grid, as numbers with few digits are.
pub(super) fn is_one_grid(steps: [Option<f64>; 3]) -> bool {
    let [Some(x), Some(y), Some(z)] = steps else { return false };
    (x - y).abs().max((x - z).abs()) < 0.02 * x
}

/// Standard deviation along each normal (#V×3, unit) of what rounding to these steps takes away: each coordinate is off by up to
/// half a step, all errors alike likely. #V, model units
pub(super) fn deviations(steps: [Option<f64>; 3], normals: &[DVec3]) -> Vec<f64> {
    let squares = DVec3::from_array(steps.map(|step| step.map_or(0.0, |step| step * step / 12.0)));
    normals.iter().map(|n| squares.dot(*n * *n).sqrt()).collect()
}

fn step(mut values: Vec<f64>) -> Option<f64> {
    /// Largest number of different values for a number of values: by chance hardly two are the same.
    const DIFFERENT: f64 = 0.2;
    /// Fraction of the gaps that must be whole numbers of steps, up to that fraction of a step.
    const WHOLE: [f64; 2] = [0.98, 0.02];
    let count = values.len();
    values.sort_unstable_by(f64::total_cmp);
    // Numbers in files have six digits or more; what differs by less is the same step.
    let range = values.last()? - values.first()?;
    values.dedup_by(|a, b| (*a - *b).abs() <= 1e-5 * range);
    if values.len() < 3 || values.len() as f64 > DIFFERENT * count as f64 {
        return None;
    }
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let step = gaps[gaps.len() / 20];
    let is_whole = |gap: &&f64| (*gap / step - (*gap / step).round()).abs() < WHOLE[1] && **gap > 0.5 * step;
    let whole = gaps.iter().filter(is_whole).count();
    (whole as f64 >= WHOLE[0] * gaps.len() as f64).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Direction, Noise};

    #[test]
    fn the_grid_of_rounded_coordinates_is_found_and_none_in_others() {
        let noise = Noise { sigma: 0.2, direction: Direction::Random, share: 1.0, seed: 1 };
        let sphere = synthetic_noise::noisy(&shapes::sphere(5), &noise);
        let rounded: Vec<DVec3> =
            sphere.positions().iter().map(|p| DVec3::new(p.x, (p.y / 0.03).round() * 0.03, p.z)).collect();
        assert_eq!(steps(sphere.positions()), [None; 3]);
        let [x, y, z] = steps(&rounded);
        assert!(x.is_none() && z.is_none() && (y.unwrap() - 0.03).abs() < 1e-9, "{y:?}");
    }

    #[test]
    fn coordinates_that_are_all_different_are_on_no_grid_however_even_they_are() {
        let even: Vec<DVec3> = (0..100u8).map(|k| DVec3::splat(0.1 * f64::from(k))).collect();
        assert_eq!(steps(&even), [None; 3]);
        assert!(steps(&even.repeat(10)).iter().all(|step| step.is_some_and(|step| (step - 0.1).abs() < 1e-12)));
    }
}
