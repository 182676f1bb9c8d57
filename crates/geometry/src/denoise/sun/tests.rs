use super::*;
use crate::mesh::shapes;
use crate::progress::Silent;

/// One step of the filter as the module documents it, for all pairs of triangles. #T×3
fn slow_step(surface: &Surface, threshold: f64) -> Vec<DVec3> {
    let triangles: Vec<_> = surface.triangles().collect();
    let normals = FaceGeometry::of(&TriangleMesh::of(surface), surface.positions()).normals;
    let touch = |i: usize, j: usize| triangles[i].iter().any(|v| triangles[j].contains(v));
    let step = |i: usize| {
        let weight = |j: usize| f64::max(0.0, normals[i].dot(normals[j]) - threshold).powi(2);
        let near = (0..triangles.len()).filter(|&j| touch(i, j));
        near.map(|j| normals[j] * weight(j)).sum::<DVec3>().normalize()
    };
    (0..triangles.len()).map(step).collect()
}

#[test]
fn a_step_is_that_of_the_formula() {
    let surface = shapes::dented_sphere(2);
    let mesh = TriangleMesh::of(&surface);
    // Beyond the first threshold nearly all neighbours count, beyond the second about half of them.
    for threshold in [0.5, 0.9] {
        let one = Sun { iterations: 1, threshold, ..Sun::default() };
        let fast = filtered(&mesh, surface.positions(), &one, &Silent).unwrap();
        for (fast, slow) in fast.iter().zip(slow_step(&surface, threshold)) {
            // A sum of a dozen terms of size one is rounded by a few ulps.
            assert!(fast.distance(slow) < 1e-14, "{threshold}: {fast} {slow}");
        }
    }
}

#[test]
fn normals_of_a_box_are_a_fixed_point() {
    // Sides at right angles do not count for each other.
    let surface = shapes::gridded_box(4);
    let mesh = TriangleMesh::of(&surface);
    let exact = FaceGeometry::of(&mesh, surface.positions()).normals;
    let found = filtered(&mesh, surface.positions(), &Sun::default(), &Silent).unwrap();
    for (found, exact) in found.iter().zip(exact) {
        assert!(found.distance(exact) < 1e-14, "{found} {exact}");
    }
}
