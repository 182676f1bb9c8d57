use super::*;
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use crate::progress::Silent;

/// Strength μ of each pass of [`Candidate::Linear`] in noise of 0.2 mean edges: 100 · 0.2 over four passes.
const MU: f64 = 5.0;

/// A noisy sphere, and the offsets (#V×3, model units) of linear smoothing on it with a tangential stiffness.
fn linear(tangential_stiffness: f64) -> (Connectivity, Vec<DVec3>, Vec<DVec3>) {
    let clean = shapes::sphere(3);
    let noisy = displaced(&clean, &white_noise(&clean, 0.2, 4));
    let (connectivity, constraint) = (Connectivity::of(&noisy), BoundaryConstraint::default());
    let noise = NoiseField::uniform(noisy.positions().len(), 0.2, noisy.mean_edge(), tangential_stiffness);
    let problem = Problem::new(&connectivity, &constraint, &noise);
    let input = noisy.positions().to_vec();
    let offsets = Candidate::Linear.offsets(&problem, &input, &input, &Silent).unwrap();
    (connectivity, input, offsets)
}

/// Smoothing S by four passes.
fn smoothed(connectivity: &Connectivity, x: &[DVec3]) -> Vec<DVec3> {
    let free = BoundaryConstraint::default();
    let pass = |x: Vec<DVec3>, _| connectivity.umbrella.smoothed(&x, MU, &free, &Silent).unwrap();
    (0..4).fold(x.to_vec(), pass)
}

#[test]
fn linear_smoothing_gives_back_what_it_flattened() {
    let (connectivity, input, offsets) = linear(0.0);
    let once = smoothed(&connectivity, &input);
    let twice = smoothed(&connectivity, &once);
    let size = |of: &dyn Fn(usize) -> DVec3| (0..input.len()).map(|v| of(v).length_squared()).sum::<f64>().sqrt();
    // The result S p + S (p − S p) is 2 S p − S S p.
    let gap = size(&|v| offsets[v] - (2.0 * once[v] - twice[v] - input[v]));
    let given_back = size(&|v| once[v] - twice[v]);
    // Each pass is solved to 1e-4.
    assert!(gap < 0.01 * given_back && given_back > 0.0, "{gap} {given_back}");
}

#[test]
fn linear_smoothing_goes_tangentially_as_far_as_the_data_let_it() {
    let (connectivity, input, free) = linear(0.0);
    let (_, _, stiff) = linear(3.0);
    let smoothed: Vec<DVec3> = input.iter().zip(&free).map(|(p, offset)| *p + *offset).collect();
    for ((n, free), stiff) in connectivity.vertex_normals(&smoothed).into_iter().zip(free).zip(stiff) {
        // A stiffness of 3 leaves a quarter of the tangential part.
        let expected = free - 0.75 * free.reject_from_normalized(n);
        assert!(stiff.distance(expected) < 1e-12, "{stiff} {expected}");
    }
}
