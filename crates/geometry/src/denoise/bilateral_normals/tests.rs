use super::*;
use crate::mesh::shapes;
use crate::progress::Silent;

/// Weights wᵢⱼ as the module documents them for all pairs of triangles; 0 for pairs that are not neighbours. #T×T
fn slow_weights(surface: &Surface, settings: &BilateralNormals) -> Vec<Vec<f64>> {
    let triangles: Vec<_> = surface.triangles().collect();
    let FaceGeometry { normals, areas, centroids } = FaceGeometry::of(&TriangleMesh::of(surface), surface.positions());
    let count = triangles.len();
    let shared = |i: usize, j: usize| triangles[i].iter().filter(|v| triangles[j].contains(v)).count();
    let all_pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
    let beside: Vec<_> = all_pairs.filter(|&(i, j)| shared(i, j) == 2).collect();
    let spacing = beside.iter().map(|&(i, j)| centroids[i].distance(centroids[j])).sum::<f64>() / beside.len() as f64;
    let gaussian = |distance: f64, sigma: f64| (-distance.powi(2) / (2.0 * sigma.powi(2))).exp();
    let least = if settings.neighbours == Neighbours::Edge { 2 } else { 1 };
    let weight = |i: usize, j: usize| {
        if i == j || shared(i, j) < least {
            return 0.0;
        }
        let near = gaussian(centroids[i].distance(centroids[j]), settings.sigma_spatial * spacing);
        areas[j] * near * gaussian(normals[i].distance(normals[j]), settings.sigma_range)
    };
    (0..count).map(|i| (0..count).map(|j| weight(i, j)).collect()).collect()
}

/// Settings with other numbers in each place, so that none can be taken for another.
fn kinds() -> [BilateralNormals; 2] {
    let vertex = BilateralNormals { iterations: 1, sigma_spatial: 0.8, sigma_range: 0.3, ..<_>::default() };
    [vertex, BilateralNormals { neighbours: Neighbours::Edge, sigma_spatial: 1.3, ..vertex }]
}

#[test]
fn a_step_is_that_of_the_formula() {
    let surface = shapes::dented_sphere(2);
    let mesh = TriangleMesh::of(&surface);
    let geometry = FaceGeometry::of(&mesh, surface.positions());
    for settings in kinds() {
        let fast = filtered(&mesh, geometry.clone(), &settings, &Silent).unwrap();
        for (weights, fast) in slow_weights(&surface, &settings).iter().zip(fast) {
            let slow = weights.iter().zip(&geometry.normals).map(|(w, n)| *n * *w).sum::<DVec3>().normalize();
            assert!(fast.distance(slow) < 1e-13, "{settings:?}: {fast} {slow}");
        }
    }
}

#[test]
fn the_global_scheme_solves_its_system() {
    let surface = shapes::dented_sphere(1);
    let mesh = TriangleMesh::of(&surface);
    let geometry = FaceGeometry::of(&mesh, surface.positions());
    for settings in kinds() {
        let settings = BilateralNormals { scheme: Scheme::Global, smoothness: 0.1, ..settings };
        let found = filtered(&mesh, geometry.clone(), &settings, &Silent).unwrap();
        let solution = slow_global(&slow_weights(&surface, &settings), &geometry.normals, settings.smoothness);
        for (found, slow) in found.iter().zip(solution) {
            // Conjugate gradients leave 1e-10 of the right-hand side; λ is the least eigenvalue.
            assert!(found.distance(slow.normalize()) < 1e-8, "{settings:?}: {found} {slow}");
        }
    }
}

/// Solves ((1 − λ) MᵀM + λ) n = λ n⁰ with M = 1 − D⁻¹ W by elimination.
fn slow_global(weights: &[Vec<f64>], input: &[DVec3], smoothness: f64) -> Vec<DVec3> {
    let count = input.len();
    let one = |i: usize, j: usize| f64::from(u8::from(i == j));
    let total: Vec<f64> = weights.iter().map(|row| row.iter().sum()).collect();
    let m = |i: usize, j: usize| one(i, j) - weights[i][j] / total[i];
    let entry = |i: usize, j: usize| {
        (1.0 - smoothness) * (0..count).map(|k| m(k, i) * m(k, j)).sum::<f64>() + smoothness * one(i, j)
    };
    let mut rows: Vec<Vec<f64>> = (0..count).map(|i| (0..count).map(|j| entry(i, j)).collect()).collect();
    let mut x: Vec<DVec3> = input.iter().map(|n| *n * smoothness).collect();
    // The matrix is positive definite, so no pivots have to be looked for.
    for k in 0..count {
        let pivot = rows[k].clone();
        for i in (0..count).filter(|&i| i != k) {
            let factor = rows[i][k] / pivot[k];
            rows[i].iter_mut().zip(&pivot).for_each(|(entry, pivot)| *entry -= factor * pivot);
            x[i] = x[i] - factor * x[k];
        }
    }
    (0..count).map(|k| x[k] / rows[k][k]).collect()
}

#[test]
fn normals_of_a_box_are_a_fixed_point() {
    let surface = shapes::gridded_box(4);
    let mesh = TriangleMesh::of(&surface);
    let geometry = FaceGeometry::of(&mesh, surface.positions());
    // Normals at right angles are √2 apart, which is 14 σ_s, where the weight is e⁻¹⁰⁰.
    let settings = BilateralNormals { sigma_range: 0.1, ..<_>::default() };
    for scheme in [Scheme::Local, Scheme::Global] {
        let settings = BilateralNormals { scheme, ..settings };
        let found = filtered(&mesh, geometry.clone(), &settings, &Silent).unwrap();
        for (found, exact) in found.iter().zip(&geometry.normals) {
            // The global scheme is solved to 1e-10 of its right-hand side.
            assert!(found.distance(*exact) < 1e-9, "{scheme:?}: {found} {exact}");
        }
    }
}
