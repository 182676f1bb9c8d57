use super::*;
use crate::denoise::map::Net;
use crate::denoise::tests::{moved_by, white_noise};
use crate::denoise::umbrella::Freedom;
use crate::progress::Silent;
use crate::shapes;

/// What linear smoothing does to a noisy sphere, where data hold vertices so much more across the normals. #V×3
fn linear(held: f64, check: impl Fn(&Net, &[DVec3], f64, &[DVec3])) {
    let clean = shapes::sphere(3);
    let noisy = moved_by(&clean, &white_noise(&clean, 0.2, 4));
    let (net, freedom, input) = (Net::of(&noisy), Freedom::default(), noisy.positions());
    let run = Run { held, ..Run::of(&net, &freedom, 0.2, noisy.mean_edge()) };
    let ways = Candidate::Linear.ways(&run, input, input, &Silent).unwrap();
    // m σ / k with m = 100 and k = 4.
    check(&net, input, 5.0, &ways);
}

/// S with four passes.
fn smoothed(net: &Net, x: &[DVec3], mu: f64) -> Vec<DVec3> {
    let pass = |x: Vec<DVec3>, _| net.umbrella.smoothed(&x, mu, &Freedom::default(), &Silent).unwrap();
    (0..4).fold(x.to_vec(), pass)
}

#[test]
fn linear_smoothing_gives_back_what_it_flattened() {
    linear(0.0, |net, input, mu, ways| {
        let once = smoothed(net, input, mu);
        let twice = smoothed(net, &once, mu);
        let size = |of: &dyn Fn(usize) -> DVec3| (0..ways.len()).map(|v| of(v).length_squared()).sum::<f64>().sqrt();
        // S p + S (p − S p) is 2 S p − S S p.
        let gap = size(&|v| ways[v] - (2.0 * once[v] - twice[v] - input[v]));
        let given_back = size(&|v| once[v] - twice[v]);
        // Each pass is solved to 1e-4.
        assert!(gap < 0.01 * given_back && given_back > 0.0, "{gap} {given_back}");
    });
}

#[test]
fn linear_smoothing_goes_across_the_normals_as_far_as_the_data_let_it() {
    linear(0.0, |_, input, _, free| {
        linear(3.0, |net, _, _, held| {
            let smoothed: Vec<DVec3> = input.iter().zip(free).map(|(p, way)| *p + *way).collect();
            for ((n, free), held) in net.vertex_normals(&smoothed).into_iter().zip(free).zip(held) {
                let across = free.reject_from_normalized(n);
                assert!(held.distance(*free - 0.75 * across) < 1e-12, "{held} {free}");
            }
        });
    });
}
