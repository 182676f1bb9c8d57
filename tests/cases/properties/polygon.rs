//! Cutting polygons up.

use super::{cases, coarse, finite};
use glam::{DQuat, DVec3};
use planish_geometry::mesh::polygon;
use proptest::collection::vec;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A simple polygon around a point from which all of it can be seen, somewhere in space, of about unit size.
fn star() -> impl Strategy<Value = Vec<DVec3>> {
    let spokes = vec((0.0..0.4, 0.1..1.0), 3..14);
    let place = [-10.0..10.0, -10.0..10.0, -10.0..10.0].prop_map(DVec3::from);
    (spokes, [0.0..TAU, 0.0..TAU, 0.0..TAU], place).prop_map(|(spokes, [x, y, z], place)| {
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, x, y, z);
        let count = spokes.len() as f64;
        // Of three spokes two are 1.4/3 of a turn apart at most: less than a half, as it must be.
        let point = |(k, (jitter, radius)): (usize, (f64, f64))| {
            let angle = (k as f64 + jitter) / count * TAU;
            turn * DVec3::new(angle.cos(), angle.sin(), 0.0) * radius + place
        };
        spokes.into_iter().enumerate().map(point).collect()
    })
}

fn triangles(points: &[DVec3]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    polygon::triangulate(points, |t| triangles.push(t));
    triangles
}

fn uses_each_corner(triangles: &[[usize; 3]], corners: usize) -> bool {
    triangles.len() == corners - 2 && (0..corners).all(|k| triangles.as_flattened().contains(&k))
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_star_falls_into_triangles_that_turn_as_it_does(points in star()) {
        let triangles = triangles(&points);
        prop_assert!(uses_each_corner(&triangles, points.len()));
        let newell = polygon::newell(points.iter().copied());
        let normal = newell.normalize();
        let doubled = |[a, b, c]: &[usize; 3]| {
            (points[*b] - points[*a]).cross(points[*c] - points[*a]).dot(normal)
        };
        let areas: Vec<f64> = triangles.iter().map(doubled).collect();
        prop_assert!(areas.iter().all(|a| *a > 0.0), "{:?}", areas);
        // Coordinates near 10 are good to 2e-15, and so are sums of a dozen areas below one, a few times over.
        prop_assert!((areas.iter().sum::<f64>() - newell.length()).abs() < 1e-13);
    }

    #[test]
    fn any_corners_fall_into_triangles(points in vec((coarse(), coarse(), finite()), 3..9)) {
        let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
        prop_assert!(uses_each_corner(&triangles(&points), points.len()));
    }
}
