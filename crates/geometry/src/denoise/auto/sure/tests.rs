use super::*;
use crate::denoise::noise_level::gaussians;
use crate::mesh::shapes;
use crate::mesh::surface::Surface;

/// A surface without noise, at which the estimator linearises the normals.
struct Bench {
    clean: Surface,
    connectivity: Connectivity,
    normals: Vec<DVec3>,
    /// Standard deviation σ of the noise, model units.
    sigma: f64,
}

/// Estimate and truth for a linear smoother in one draw of the noise, both summed over the faces, square unit length.
struct Draw {
    /// Sum of the estimated risks.
    estimate: f64,
    /// Sum of the true squared errors.
    truth: f64,
}

impl Bench {
    fn new() -> Self {
        let clean = shapes::dented_sphere(2);
        let connectivity = Connectivity::of(&clean);
        let normals = connectivity.vertex_normals(clean.positions());
        let sigma = 0.2 * clean.mean_edge();
        Self { clean, connectivity, normals, sigma }
    }

    fn estimator(&self) -> SureEstimator<'_> {
        let mut linear = LinearisedNormals::default();
        linear.update(&self.connectivity, self.clean.positions(), |_| f64::INFINITY);
        let weights = vec![1.0; linear.areas.len()];
        SureEstimator { connectivity: &self.connectivity, linear, weights, evaluated: &[] }
    }

    /// White noise along the normals. #V×3, model units
    fn white(&self, seed: u64) -> Vec<DVec3> {
        gaussians(self.normals.len(), seed).iter().zip(&self.normals).map(|(g, n)| self.sigma * g.x * *n).collect()
    }

    /// Half steps towards the mean of the neighbours.
    fn smooth(&self, x: &[DVec3], steps: usize) -> Vec<DVec3> {
        let umbrella = &self.connectivity.umbrella;
        let step = |x: Vec<DVec3>, _| (0..x.len()).map(|v| x[v] - 0.5 * umbrella.at(&x, v)).collect();
        (0..steps).fold(x.to_vec(), step)
    }

    /// Response of a smoother with so many steps in the noise of a seed, by so many probes, and the error of its result
    /// (#V×3, model units).
    fn response(&self, steps: usize, seed: u64, probes: u64) -> (Response, Vec<DVec3>) {
        let noise = self.white(seed);
        let noisy: Vec<DVec3> = self.clean.positions().iter().zip(&noise).map(|(p, e)| *p + *e).collect();
        let result = self.smooth(&noisy, steps);
        let offsets: Vec<DVec3> = result.iter().zip(&noisy).map(|(y, p)| *y - *p).collect();
        let probes: Vec<_> = (1..=probes).map(|k| self.white(10_000 * k + seed)).collect();
        let derivatives: Vec<_> = probes.iter().map(|b| self.smooth(b, steps)).collect();
        let errors = result.iter().zip(self.clean.positions()).map(|(y, p)| *y - *p).collect();
        (self.estimator().response(&offsets, &derivatives, &probes), errors)
    }

    /// Σ |A x|², smoothed as the estimator smooths residuals.
    fn squares(&self, x: &[DVec3]) -> f64 {
        self.estimator().response(x, &[], &[]).residuals.iter().map(|r| r.length_squared()).sum()
    }

    fn draw(&self, steps: usize, seed: u64, probes: u64) -> Draw {
        let (response, errors) = self.response(steps, seed, probes);
        // The constant that is the same for all results is the square of the noise.
        let noise = self.white(seed);
        Draw { estimate: response.risks().iter().sum::<f64>() - self.squares(&noise), truth: self.squares(&errors) }
    }
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

#[test]
fn the_estimate_for_a_linear_smoother_is_the_true_error_on_average() {
    let bench = Bench::new();
    let noise: f64 = (0..100).map(|seed| bench.draw(0, seed, 1).truth).sum::<f64>() / 100.0;
    for steps in [0, 1, 4] {
        for probes in [1, 3] {
            let draws: Vec<Draw> = (0..100).map(|seed| bench.draw(steps, seed, probes)).collect();
            let (gap, error) = mean(&draws.iter().map(|draw| draw.estimate - draw.truth).collect::<Vec<_>>());
            assert!(gap.abs() < 3.0 * error, "{steps} steps: {gap} ± {error}");
            // With a larger error the test would show nothing: the divergence is of the size of the noise.
            assert!(error < 0.04 * noise, "{steps} steps: {error} of {noise}");
        }
    }
}

#[test]
fn differences_of_the_risk_are_those_of_the_true_error() {
    let bench = Bench::new();
    let estimator = bench.estimator();
    let square_degrees = 1f64.to_degrees().powi(2) / bench.connectivity.mesh.face_count() as f64;
    let gaps: Vec<[f64; 2]> = (0..100)
        .map(|seed| {
            let [(little, a), (much, b)] = [1, 4].map(|steps| bench.response(steps, seed, 2));
            let estimate = estimator.risk_difference([&much, &much], &little.risks());
            [estimate, square_degrees * (bench.squares(&b) - bench.squares(&a))]
        })
        .collect();
    let [(estimate, error), (truth, _)] = [0, 1].map(|k| mean(&gaps.iter().map(|gap| gap[k]).collect::<Vec<_>>()));
    // Trimming leaves out some of the largest values.
    assert!((estimate - truth).abs() < 0.1 * truth.abs() + 3.0 * error, "{estimate} ± {error}, in truth {truth}");
}

#[test]
fn the_risk_of_a_pair_is_that_of_its_mean() {
    let bench = Bench::new();
    let estimator = bench.estimator();
    let [(a, _), (b, _)] = [1, 4].map(|steps| bench.response(steps, 7, 1));
    let half = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect::<Vec<f64>>();
    let residuals = a.residuals.iter().zip(&b.residuals).map(|(a, b)| 0.5 * (*a + *b)).collect();
    let mixed = Response { residuals, divergences: vec![half(&a.divergences[0], &b.divergences[0])] };
    let reference = a.risks();
    let [pair, alone] = [[&a, &b], [&mixed, &mixed]].map(|pair| estimator.risk_difference(pair, &reference));
    assert!((pair - alone).abs() < 1e-9 * alone.abs(), "{pair} {alone}");
    assert!(estimator.risk_difference([&a, &a], &reference).abs() < 1e-9);
}

#[test]
fn the_risk_over_several_probes_is_the_mean_over_each() {
    let bench = Bench::new();
    let estimator = bench.estimator();
    let [(a, _), (b, _)] = [1, 4].map(|steps| bench.response(steps, 7, 3));
    let reference = a.risks();
    let one = |response: &Response, probe: usize| Response {
        residuals: response.residuals.clone(),
        divergences: vec![response.divergences[probe].clone()],
    };
    let each = |probe: usize| estimator.risk_difference([&one(&a, probe), &one(&b, probe)], &reference);
    let all = estimator.risk_difference([&a, &b], &reference);
    assert!((all - (0..3).map(each).sum::<f64>() / 3.0).abs() < 1e-9 * all.abs(), "{all}");
    // A result with one probe reuses it.
    let few = estimator.risk_difference([&one(&a, 0), &b], &reference);
    let each = |probe: usize| estimator.risk_difference([&one(&a, 0), &one(&b, probe)], &reference);
    assert!((few - (0..3).map(each).sum::<f64>() / 3.0).abs() < 1e-9 * few.abs(), "{few}");
}
