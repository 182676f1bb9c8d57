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

#[test]
fn every_candidate_leaves_vertices_without_noise_where_they_are_and_moves_others() {
    let clean = shapes::sphere(3);
    let noisy = displaced(&clean, &white_noise(&clean, 0.2, 4));
    let connectivity = Connectivity::of(&noisy);
    let mut noise = NoiseField::uniform(noisy.positions().len(), 0.2, noisy.mean_edge(), 0.0);
    let is_clean = |v: usize| clean.positions()[v].z > 0.3;
    (0..clean.positions().len()).filter(|&v| is_clean(v)).for_each(|v| noise.relative[v] = 0.0);
    let constraint = BoundaryConstraint::default().and_fixed(noise.relative.iter().map(|sigma| *sigma == 0.0));
    let problem = Problem::new(&connectivity, &constraint, &noise);
    let input = noisy.positions();
    let guess = problem.guess(input, &Silent).unwrap();
    for candidate in Candidate::ALL {
        let offsets = candidate.offsets(&problem, input, &guess, &Silent).unwrap();
        assert_eq!(offsets.len(), input.len());
        let moved = |v: &usize| offsets[*v].length() > 1e-3 * noisy.mean_edge();
        let [kept, others]: [Vec<usize>; 2] =
            [true, false].map(|clean| (0..input.len()).filter(|&v| is_clean(v) == clean).collect());
        assert!(kept.iter().all(|&v| offsets[v] == DVec3::ZERO), "{candidate}");
        let share = others.iter().filter(|v| moved(v)).count() as f64 / others.len() as f64;
        assert!(if candidate == Candidate::Stay { share == 0.0 } else { share > 0.8 }, "{candidate}: {share}");
    }
}

#[test]
fn candidates_suit_noise_or_they_do_not_and_mix_with_each_other_alike() {
    use Candidate as C;
    for kind in Kind::ALL {
        let suited = C::suited_to(kind);
        // Nothing to do, and the learned filter, are no parts of a mixture.
        assert_eq!(suited.contains(&C::Stay), kind == Kind::None);
        assert!(!suited.contains(&C::Learned));
        // What smooths more than white noise calls for is for noise that neighbours share.
        for strong in [C::FlatStrong, C::CreasesStrong, C::SmoothStrong, C::LinearWide, C::Bilateral] {
            assert_eq!(suited.contains(&strong), kind == Kind::Correlated, "{strong}");
        }
        for fine in [C::Sharp, C::Detail, C::LinearFaint] {
            assert_eq!(suited.contains(&fine), matches!(kind, Kind::Independent | Kind::Uneven), "{fine}");
        }
    }
    for a in C::ALL {
        assert!(a.mixes_with(a), "{a}");
        assert!(C::ALL.into_iter().all(|b| a.mixes_with(b) == b.mixes_with(a)), "{a}");
    }
    // Linear smoothing blurs creases, and nothing else is in the way.
    for linear in [C::LinearFaint, C::LinearLight, C::Linear, C::LinearStrong, C::LinearWide] {
        assert!([C::Flat, C::Sharp, C::Creases, C::FlatStrong, C::CreasesStrong].iter().all(|c| !c.mixes_with(linear)));
        assert!([C::Smooth, C::Detail, C::SmoothStrong].iter().all(|c| c.mixes_with(linear)));
    }
    assert!(C::Flat.mixes_with(C::Creases) && C::Flat.mixes_with(C::Smooth));
}
