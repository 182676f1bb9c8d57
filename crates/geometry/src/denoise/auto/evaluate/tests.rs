//! Laws of the parts of an evaluation that a result hides: what the probes are, and where the risk is linearised.

use super::*;
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use glam::Vec3A;

const SIGMA: f64 = 0.2;

/// Does something with the evaluation of a noisy sphere, whose clean positions are handed over as well.
fn on_a_sphere(check: impl Fn(&Evaluation, &[DVec3])) {
    let clean = shapes::sphere(3);
    let noisy = displaced(&clean, &white_noise(&clean, SIGMA, 4));
    let (connectivity, constraint) = (Connectivity::of(&noisy), BoundaryConstraint::default());
    let noise = NoiseField::uniform(noisy.positions().len(), SIGMA, noisy.mean_edge(), 0.0);
    let problem = Problem::new(&connectivity, &constraint, &noise);
    check(&Evaluation { problem, input: noisy.positions(), evaluated: &[] }, clean.positions());
}

#[test]
fn probes_are_noise_along_the_normals_of_the_result() {
    on_a_sphere(|evaluation, clean| {
        let offsets: Vec<DVec3> = clean.iter().zip(evaluation.input).map(|(q, p)| *q - *p).collect();
        let probes = evaluation.probes(3, &offsets);
        let Problem { connectivity, noise, .. } = evaluation.problem;
        let normals = connectivity.vertex_normals(clean);
        let lengths: Vec<Vec<f64>> =
            probes.iter().map(|b| b.iter().zip(&normals).map(|(b, n)| b.dot(*n)).collect()).collect();
        for (probe, lengths) in probes.iter().zip(&lengths) {
            let tangential = probe.iter().zip(&normals).map(|(b, n)| b.reject_from_normalized(*n).length());
            assert!(tangential.fold(0.0, f64::max) < 1e-12);
            let rms = (lengths.iter().map(|x| x * x).sum::<f64>() / lengths.len() as f64).sqrt();
            // The deviation of 642 numbers is known to 2.8 %; four times that.
            assert!((rms / (SIGMA * noise.mean_edge()) - 1.0).abs() < 0.12, "{rms}");
        }
        // Independent samples have a correlation of 0 to 0.04; four times that.
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let [a, b, c] = &lengths[..] else { panic!("{} probes", lengths.len()) };
        for (a, b) in [(a, b), (b, c), (a, c)] {
            assert!(product(a, b).abs() < 0.16 * (product(a, a) * product(b, b)).sqrt());
        }
    });
}

#[test]
fn the_risk_is_linearised_at_the_mean_of_the_denoised_results() {
    on_a_sphere(|evaluation, clean| {
        let input = evaluation.input;
        let to = |share: f64| clean.iter().zip(input).map(|(q, p)| share * (*q - *p)).collect::<Vec<DVec3>>();
        // The noisy mesh itself is one of the candidates, and no estimate of the surface.
        let candidates = [Candidate::Stay, Candidate::Smooth, Candidate::Linear];
        let results = [0.0, 1.2, 0.8].map(|share| CandidateResult { offsets: to(share), derivatives: Vec::new() });
        let estimator = evaluation.estimator(&candidates, &results);
        let mut expected = LinearisedNormals::default();
        expected.update(evaluation.problem.connectivity, clean, |_| f64::INFINITY);
        let off = |a: &[Vec3A]| a.iter().zip(&expected.normals).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(off(&estimator.linear.normals) < 1e-5, "{}", off(&estimator.linear.normals));
    });
}
