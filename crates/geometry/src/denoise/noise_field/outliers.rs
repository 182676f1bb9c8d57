//! Vertices that are no samples of the surface: spikes and craters of a single vertex.

use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Position that the neighbours of each outlier suggest for it, in the order of the vertices. (vertex, model units)
///
/// An outlier stands off the plane through its two rings by several edges, and these lie in the plane. The tip of a cone is none,
/// since its second ring lies off the plane, too. `local_edge` is the length of the edges around each vertex (#V, model units).
pub(super) fn outliers(surface: &Surface, local_edge: &[f64]) -> Vec<(Index, DVec3)> {
    /// Least distance from the plane, local edges: noise does not reach so far.
    const LEAST: f64 = 2.5;
    /// Least ratio of the distance to that of the rings from their plane (root mean square).
    const RATIO: f64 = 8.0;
    /// Least number of neighbours: fewer say too little of the surface.
    const LEAST_RING: usize = 4;
    /// Most neighbours of a neighbour that are looked at; of more, some that stand in its ring at equal steps.
    const MOST: usize = 256;
    let rings = surface.topology().rings();
    let positions = surface.positions();
    let some = |w: Index| {
        let ring = rings.get(w);
        ring.iter().step_by(ring.len().div_ceil(MOST).max(1))
    };
    let one = |v: Index| -> Option<(Index, DVec3)> {
        let ring = rings.get(v);
        let edge = local_edge[v as usize];
        let middle = ring.iter().map(|&w| positions[w as usize]).sum::<DVec3>() / ring.len() as f64;
        if ring.len() < LEAST_RING
            || surface.topology().is_boundary(v)
            || positions[v as usize].distance(middle) < LEAST * edge
        {
            return None;
        }
        let mut around: Vec<Index> = ring.iter().flat_map(|&w| some(w)).chain(ring).copied().collect();
        around.sort_unstable();
        around.dedup();
        around.retain(|&w| w != v);
        let (centre, normal, off_plane) = plane(around.iter().map(|&w| positions[w as usize]))?;
        let distance = (positions[v as usize] - centre).dot(normal).abs();
        let stands_off = distance > LEAST * edge && distance > RATIO * off_plane;
        stands_off.then_some((v, middle))
    };
    (0..positions.len() as Index).into_par_iter().filter_map(one).collect()
}

/// Plane of least squares: a point, its unit normal, and the root mean square distance of the points from it.
fn plane(points: impl Iterator<Item = DVec3> + Clone) -> Option<(DVec3, DVec3, f64)> {
    let count = points.clone().count() as f64;
    let centre = points.clone().sum::<DVec3>() / count;
    let square = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    let covariance = points.map(|p| square(p - centre)).fold(DMat3::ZERO, |sum, m| sum + m) * (1.0 / count);
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    if !(trace.is_finite() && trace > 0.0) {
        return None;
    }
    // Inverse iteration finds the direction of the least variance; the shift makes the matrix regular.
    let inverse = (covariance + DMat3::from_diagonal(DVec3::splat(1e-9 * trace))).inverse();
    let mut normal = DVec3::new(0.577, 0.577, 0.578);
    for _ in 0..50 {
        normal = (inverse * normal).normalize_or_zero();
    }
    let variance = normal.dot(covariance * normal).max(0.0);
    normal.is_normalized().then_some((centre, normal, variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    #[test]
    fn a_spike_is_an_outlier_and_the_tip_of_a_cone_is_none() {
        let grid = shapes::grid(12);
        let edges = vec![1.0 / 12.0; grid.positions().len()];
        let middle = (0..).zip(grid.positions()).find(|(_, p)| p.distance(DVec3::new(0.5, 0.5, 0.0)) < 1e-9).unwrap().0;
        let lifted = |height: &dyn Fn(f64) -> f64| {
            let lift = |p: &DVec3| *p + DVec3::Z * height(p.distance(DVec3::new(0.5, 0.5, 0.0)));
            grid.at(grid.positions().iter().map(lift).collect())
        };
        let spike = lifted(&|r| if r < 0.01 { 0.4 } else { 0.0 });
        let found = outliers(&spike, &edges);
        assert!(found.len() == 1 && found[0].0 == middle && found[0].1.z == 0.0, "{found:?}");
        assert!(outliers(&lifted(&|r| (1.0 - 5.0 * r).max(0.0)), &edges).is_empty());
        assert!(outliers(&grid, &edges).is_empty());
    }

    #[test]
    fn at_the_boundary_and_with_few_neighbours_nothing_is_an_outlier() {
        let edges = |surface: &Surface| vec![1.0 / 12.0; surface.positions().len()];
        let grid = shapes::grid(12);
        let lifted = |surface: &Surface, v: usize| {
            let mut positions = surface.positions().to_vec();
            positions[v] += 0.4 * DVec3::Z;
            surface.at(positions)
        };
        let found = |v: usize| !outliers(&lifted(&grid, v), &edges(&grid)).is_empty();
        for (v, p) in grid.positions().iter().enumerate() {
            let is_boundary = grid.topology().is_boundary(v as Index);
            assert!(!(is_boundary && found(v)), "{p} is at the boundary");
        }
        // A vertex in the middle of one triangle has three neighbours.
        let middle = grid.positions().len() as Index;
        let mut faces: Vec<Vec<Index>> = grid.topology().faces().iter().map(<[Index]>::to_vec).collect();
        let cut = faces.remove(faces.len() / 2);
        faces.extend((0..3).map(|k| vec![cut[k], cut[(k + 1) % 3], middle]));
        let mut positions = grid.positions().to_vec();
        positions.push(cut.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 3.0);
        let split = Surface::new(Topology::new(positions.len(), faces.into_iter().collect()), positions);
        assert!(outliers(&lifted(&split, middle as usize), &edges(&split)).iter().all(|(v, _)| *v != middle));
    }
}
