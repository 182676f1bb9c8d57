use super::*;
use crate::denoise::noise_level::gaussians;
use crate::shapes;

#[test]
fn the_change_of_normals_is_their_derivative() {
    let surface = shapes::dented_sphere(2);
    let net = Net::of(&surface);
    let way = gaussians(surface.positions().len(), 1);
    const STEP: f64 = 1e-5;
    let at = |step: f64| {
        let mut linear = Linear::default();
        let moved: Vec<DVec3> = surface.positions().iter().zip(&way).map(|(p, way)| *p + step * *way).collect();
        linear.measure(&net, &moved, f64::INFINITY);
        linear
    };
    let mut change = vec![DVec3::ZERO; net.faces.len()];
    at(0.0).change(&net, &way, &mut change);
    for ((forth, back), change) in at(STEP).normals.iter().zip(at(-STEP).normals).zip(change) {
        // Of the order of the step over an edge, squared.
        assert!(((*forth - back) / (2.0 * STEP)).distance(change) < 1e-5 * change.length().max(1.0), "{change}");
    }
}

#[test]
fn slivers_turn_no_faster_than_allowed() {
    let surface = shapes::dented_sphere(2);
    let net = Net::of(&surface);
    let mut linear = Linear::default();
    let steepest = |linear: &Linear| linear.gradients.iter().flatten().map(|g| g.length()).fold(0.0, f64::max);
    linear.measure(&net, surface.positions(), f64::INFINITY);
    let free = steepest(&linear);
    linear.measure(&net, surface.positions(), 0.5 * free);
    assert!((steepest(&linear) / free - 0.5).abs() < 1e-12);
}

#[test]
fn kappa_falls_from_the_first_to_that_of_the_settings() {
    let prior = Prior { rounds: 11, threshold: 0.02, ..Prior::default() };
    let kappa = |round| Weighing::at(&prior, round).sharpness.powf(-0.5);
    assert!((kappa(0) - 0.4).abs() < 1e-12);
    assert!((1..=8).all(|round| kappa(round) < kappa(round - 1)));
    // The last fifth of the rounds.
    assert!((8..=10).all(|round| (kappa(round) - 0.02).abs() < 1e-12));
    let alone = Weighing::at(&Prior { rounds: 1, ..prior }, 0);
    assert!((alone.sharpness.powf(-0.5) - 0.02).abs() < 1e-12);
}

#[test]
fn weights_are_those_of_the_robust_residuals() {
    // In mean edges, with edges of about 1, so that no length is clamped.
    let unit = shapes::dented_sphere(2);
    let unit = unit.at(unit.positions().iter().map(|p| *p / unit.mean_edge()).collect());
    let net = Net::of(&unit);
    let (x, faces) = (unit.positions(), &net.faces);
    let shapes: Vec<Symmetric> = vec![Symmetric::default(); faces.len()];
    let mut linear = Linear::default();
    linear.measure(&net, x, f64::INFINITY);
    let mut sides = Sides::of(&net);
    let prior = Prior { rounds: 1, ..Prior::CREASES };
    sides.weigh(&net, &linear, x, &shapes, &Weighing::at(&prior, 0));
    let kappa = prior.threshold;
    let centroid = |f: usize| faces.triangles[f].iter().map(|&v| x[v as usize]).sum::<DVec3>() / 3.0;
    for f in 0..faces.len() {
        for k in net.sides.range(f as u32) {
            let (e, g) = net.sides.items()[k];
            let side = sides.all[k];
            let [a, b] = faces.pair_edges[e as usize].map(|v| x[v as usize]);
            let bend = linear.normals[f].distance_squared(linear.normals[g as usize]);
            let phi = (1.0 + bend / (kappa * kappa)).powf(-prior.exponent);
            let turn = prior.strength * kappa.powf(-2.0 * prior.exponent) * a.distance(b) * phi;
            assert!((side.turn / turn - 1.0).abs() < 1e-12);
            // Shape operators that do not jump keep the weight of the turn.
            assert!((side.jump / (prior.curvature * turn) - 1.0).abs() < 1e-12);
            assert!(side.way.distance(centroid(f) - centroid(g as usize)) < 1e-14);
        }
    }
}
