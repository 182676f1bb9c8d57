use super::*;
use crate::mesh::shapes;

#[test]
fn kappa_falls_from_the_first_to_that_of_the_prior() {
    let prior = Prior { rounds: 11, threshold: 0.02, ..Prior::default() };
    let kappa = |round| RobustWeights::at_round(&prior, round).sharpness.powf(-0.5);
    assert!((kappa(0) - 0.4).abs() < 1e-12);
    assert!((1..=8).all(|round| kappa(round) < kappa(round - 1)));
    // The last fifth of the rounds has the threshold itself.
    assert!((8..=10).all(|round| (kappa(round) - 0.02).abs() < 1e-12));
    let alone = RobustWeights::at_round(&Prior { rounds: 1, ..prior }, 0);
    assert!((alone.sharpness.powf(-0.5) - 0.02).abs() < 1e-12);
}

#[test]
fn weights_are_those_of_the_robust_residuals() {
    // Edges have a mean length of 1, so that no length is clamped.
    let unit = shapes::dented_sphere(2);
    let unit = unit.at(unit.positions().iter().map(|p| *p / unit.mean_edge()).collect());
    let connectivity = Connectivity::of(&unit);
    let (x, mesh) = (unit.positions(), &connectivity.mesh);
    let shape_operators = vec![Symmetric::default(); mesh.face_count()];
    let mut linear = LinearisedNormals::default();
    linear.update(&connectivity, x, |_| f64::INFINITY);
    let mut weights = HalfEdgeWeights::new(&connectivity);
    let prior = Prior { rounds: 1, ..Prior::CREASES };
    let at = Configuration { normals: &linear, positions: x, edges: &vec![1.0; mesh.face_count()] };
    weights.update(&connectivity, &at, &shape_operators, &RobustWeights::at_round(&prior, 0));
    let kappa = prior.threshold;
    let centroid = |f: usize| mesh.triangles[f].iter().map(|&v| x[v as usize]).sum::<DVec3>() / 3.0;
    for f in 0..mesh.face_count() {
        for k in connectivity.half_edges.range(f as u32) {
            let (e, g) = connectivity.half_edges.items()[k];
            let found = weights.all[k];
            let [a, b] = mesh.edge_vertices[e as usize].map(|v| x[v as usize]);
            let jump = f64::from(linear.normals[f].distance_squared(linear.normals[g as usize]));
            let phi = (1.0 + jump / (kappa * kappa)).powf(-prior.exponent);
            let expected = prior.strength * kappa.powf(-2.0 * prior.exponent) * a.distance(b) * phi;
            assert_eq!(found.other, g);
            assert!((f64::from(found.normal_weight) / expected - 1.0).abs() < 1e-6);
            // Shape operators that do not jump keep the weight of the normals.
            assert!((f64::from(found.shape_operator_weight) / (prior.curvature * expected) - 1.0).abs() < 1e-6);
            assert!(found.centroid_offset.as_dvec3().distance(centroid(f) - centroid(g as usize)) < 1e-6);
        }
    }
}
