//! Tests of the automatic method.

use super::*;
use crate::denoise::Denoiser;
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::triangle_mesh::TriangleMesh;
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Noise};
use crate::mesh::topology::Topology;
use crate::progress::Silent;

fn noisy(clean: &Surface, sigma: f64) -> Surface {
    noisy_in(clean, sigma, synthetic_noise::Direction::Normal)
}

fn noisy_in(clean: &Surface, sigma: f64, direction: synthetic_noise::Direction) -> Surface {
    let noise = Noise { sigma, direction, share: 1.0, seed: 3 };
    synthetic_noise::noisy(clean, &noise)
}

/// Mean angle between the normals of two surfaces, degrees.
fn off(a: &Surface, positions: &[DVec3]) -> f64 {
    let mesh = TriangleMesh::of(a);
    let [a, b] = [a.positions(), positions].map(|x| FaceGeometry::of(&mesh, x).normals);
    a.iter().zip(&b).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / mesh.face_count() as f64
}

#[test]
fn noise_on_a_sphere_goes_and_the_choice_says_how_much_there_was() {
    let clean = shapes::sphere(3);
    let noisy = noisy(&clean, 0.2);
    let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
    let result = noisy.moved_by(&deltas);
    // From 22°. Curvature is 0.15 radians an edge, and the nearest smoothing by hand leaves 3.5°.
    assert!(off(&clean, &result) < 4.0, "{} {choice}", off(&clean, &result));
    // 642 vertices: the deviation is known to 3 %; three times that, and a tenth that the curvature may add.
    assert!((choice.sigma / 0.2 - 1.0).abs() < 0.2, "{choice}");
    let total: f64 = choice.candidates.iter().map(|share| share.share).sum();
    assert!((total - 1.0).abs() < 1e-12 && choice.kind == Kind::Independent, "{choice}");
}

#[test]
fn noise_along_the_normals_is_told_from_noise_in_all_directions() {
    // With flats and edges: where all is smooth it makes no difference.
    let ball = shapes::sphere(4);
    let clean = ball.at(ball.positions().iter().map(|p| p.clamp(DVec3::splat(-0.75), DVec3::splat(0.75))).collect());
    let left = |noisy: &Surface, across: Option<f64>| {
        // The candidates of white noise without the learned filter, which is not told what the noise is.
        let candidates = Some(Candidate::suited_to(Kind::Independent));
        let settings = Auto { noise_across: across, candidates, ..Auto::default() };
        let (deltas, choice) = choose(noisy, &settings, &Silent).unwrap();
        let result = noisy.moved_by(&deltas);
        (off(&clean, &result), choice)
    };
    let along = noisy_in(&clean, 0.2, synthetic_noise::Direction::Normal);
    let (held, choice) = left(&along, None);
    assert!(
        choice.tangential_sigma < 0.5 * choice.sigma && choice.measured.tangential_stiffness(choice.kind) > 3.0,
        "{choice:?}"
    );
    // As if noise went in all directions.
    let (free, _) = left(&along, Some(0.2));
    assert!(held < 0.97 * free, "{held} {free}");
    // Of that much in all directions a third of the square goes along the normals.
    let (_, choice) = left(&noisy_in(&clean, 0.3, synthetic_noise::Direction::Random), None);
    assert!(
        choice.tangential_sigma > 0.9 * choice.measured.fine && choice.measured.tangential_stiffness(choice.kind) < 0.3,
        "{choice:?}"
    );
}

#[test]
fn a_box_keeps_its_edges_in_much_noise() {
    let clean = shapes::gridded_box(24);
    let noisy = noisy(&clean, 0.3);
    let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
    let result = noisy.moved_by(&deltas);
    // From 33°. Judged along the normals of the smoothed mesh, half of it was linear smoothing, and 5.4° were
    // left; now 1.4°.
    assert!(off(&clean, &result) < 2.5, "{} {choice}", off(&clean, &result));
}

#[test]
fn a_clean_surface_stays_as_it_is() {
    // Not the dented sphere: its dents differ from vertex to vertex, which is what noise does.
    for clean in [shapes::sphere(3), shapes::sphere(4), shapes::cube(), shapes::grid(8)] {
        let (deltas, choice) = choose(&clean, &Auto::default(), &Silent).unwrap();
        assert!(deltas.iter().all(|d| *d == DVec3::ZERO), "{} vertices: {choice:?}", deltas.len());
        assert_eq!(choice.kind, Kind::None);
    }
}

#[test]
fn roughness_with_more_bumps_than_pits_stays() {
    let clean = shapes::sphere(4);
    let noisy = noisy(&clean, 0.2);
    let lift = |(p, q): (&DVec3, &DVec3)| *p + p.normalize() * (*q - *p).length();
    let rough = clean.at(clean.positions().iter().zip(noisy.positions()).map(lift).collect());
    let (deltas, choice) = choose(&rough, &Auto::default(), &Silent).unwrap();
    assert!(deltas.iter().all(|d| *d == DVec3::ZERO) && choice.measured.skewness > 0.125, "{choice:?}");
}

#[test]
fn each_kind_of_noise_has_its_candidates() {
    let clean = shapes::sphere(4);
    let correlated = noise_level::tests::with_correlated_noise(&clean, 0.5, 3);
    let (deltas, choice) = choose(&correlated, &Auto::default(), &Silent).unwrap();
    assert_eq!(choice.kind, Kind::Correlated);
    assert!(choice.candidates.iter().any(|of| of.candidate == Candidate::FlatStrong), "{choice}");
    assert!(deltas.iter().any(|d| *d != DVec3::ZERO));
    let white = noisy(&shapes::sphere(2), 0.2);
    for kind in [Kind::Independent, Kind::Uneven] {
        let (_, choice) = choose(&white, &Auto { kind: Some(kind), ..Auto::default() }, &Silent).unwrap();
        assert_eq!((choice.kind, choice.candidates.len()), (kind, Candidate::suited_to(kind).len()));
    }
}

#[test]
fn every_choice_can_be_overruled() {
    let noisy = noisy(&shapes::sphere(3), 0.2);
    let chosen = |settings: Auto| choose(&noisy, &settings, &Silent).unwrap();
    let (_, told) = chosen(Auto { noise: Some(0.1), ..Auto::default() });
    assert_eq!((told.sigma, told.kind), (0.1, Kind::Independent));
    for stays in [
        Auto { noise: Some(0.0), ..Auto::default() },
        Auto { kind: Some(Kind::None), ..Auto::default() },
        Auto { candidates: Some(vec![Candidate::Stay]), ..Auto::default() },
        Auto { candidates: Some(Vec::new()), ..Auto::default() },
    ] {
        let (deltas, choice) = chosen(stays);
        assert!(deltas.iter().all(|d| *d == DVec3::ZERO), "{choice}");
    }
    let (_, two) = chosen(Auto { candidates: Some(vec![Candidate::Smooth, Candidate::Linear]), ..Auto::default() });
    assert_eq!(two.candidates.len(), 2);
    let clean = shapes::sphere(3);
    let (deltas, _) = choose(&clean, &Auto { noise: Some(0.2), ..Auto::default() }, &Silent).unwrap();
    assert!(deltas.iter().any(|d| *d != DVec3::ZERO));
}

#[test]
fn patches_give_about_the_shares_of_the_whole() {
    let noisy = noisy(&shapes::sphere(4), 0.2);
    let connectivity = Connectivity::of(&noisy);
    let noise = NoiseEstimate::of(&noisy, &connectivity, &Silent).unwrap();
    let sizes = PatchSizes { whole: 0, patches: 3, triangles: 600, margin: 4 };
    let part = subsample(&noisy, &connectivity, sizes).unwrap();
    let evaluated = part.evaluated.iter().filter(|evaluated| **evaluated).count();
    assert!(evaluated == 1800 && part.connectivity.mesh.face_count() < noisy.triangles().len(), "{evaluated}");
    let constraint = BoundaryConstraint::default();
    use Candidate as C;
    let candidates = &[C::Detail, C::Smooth, C::LinearFaint, C::LinearLight, C::Linear, C::LinearStrong, C::Stay];
    let mean = |connectivity: &Connectivity, input: &[DVec3], evaluated: &[bool]| {
        let sigma = noise.level.sigma_as(noise.level.kind());
        let field = NoiseField::uniform(input.len(), sigma, noise.mean_edge, 0.0);
        let problem = Problem::new(connectivity, &constraint, &field);
        let evaluation = Evaluation { problem, input, evaluated };
        let shares = evaluation.best_mixture(candidates, false, &Silent).unwrap().shares;
        shares.iter().zip(0u32..).map(|(share, k)| share.share * f64::from(k)).sum::<f64>()
    };
    let of_part = mean(&part.connectivity, part.surface.positions(), &part.evaluated);
    let of_whole = mean(&connectivity, noisy.positions(), &[]);
    // Both lie among the smoothest of five; one place apart is what a third of the faces may cost.
    assert!((of_part - of_whole).abs() < 1.0, "{of_part} {of_whole}");
}

/// Surfaces side by side, as the components of one.
fn together(parts: &[&Surface]) -> Surface {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for part in parts {
        let first = positions.len() as u32;
        faces.extend(part.triangles().map(|t| t.map(|v| v + first).to_vec()));
        positions.extend_from_slice(part.positions());
    }
    Surface::new(Topology::new(positions.len(), faces.into_iter().collect()), positions)
}

fn moved(surface: &Surface, by: impl Fn(DVec3) -> DVec3) -> Surface {
    surface.at(surface.positions().iter().map(|p| by(*p)).collect())
}

#[test]
fn a_clean_box_beside_a_noisy_ball_stays() {
    let ball = noisy(&shapes::sphere(3), 0.2);
    let slab = moved(&shapes::cube(), |p| p * DVec3::new(20.0, 20.0, 1.0) + DVec3::new(0.0, 0.0, -5.0));
    let (deltas, choice) = choose(&together(&[&ball, &slab]), &Auto::default(), &Silent).unwrap();
    let (of_ball, of_slab) = deltas.split_at(ball.positions().len());
    assert!(of_slab.iter().all(|d| *d == DVec3::ZERO), "{choice}");
    // Edges are 0.15 long: five deviations of the noise are as much.
    assert!(of_ball.iter().all(|d| d.length() < 0.2) && of_ball.iter().any(|d| *d != DVec3::ZERO));
}

#[test]
fn components_of_unlike_size_are_denoised_as_if_they_were_alone() {
    let clean = shapes::sphere(3);
    let large = noisy(&clean, 0.2);
    let small = moved(&large, |p| 0.05 * p + DVec3::new(3.0, 0.0, 0.0));
    let count = clean.positions().len();
    let both = together(&[&large, &small]);
    let (deltas, choice) = choose(&both, &Auto::default(), &Silent).unwrap();
    let result = both.moved_by(&deltas);
    let of_small: Vec<DVec3> = result[count..].iter().map(|p| 20.0 * (*p - DVec3::new(3.0, 0.0, 0.0))).collect();
    // From 22°; one alone comes to below 4°.
    assert!(off(&clean, &result[..count]) < 4.0 && off(&clean, &of_small) < 4.0, "{choice}");
}

#[test]
fn noise_that_grows_across_the_surface_goes_everywhere() {
    let clean = shapes::sphere(4);
    let all = noisy(&clean, 0.4);
    let fade = |(p, q): (&DVec3, &DVec3)| *p + (*q - *p) * (0.5 * (1.0 + p.z));
    let fading = clean.at(clean.positions().iter().zip(all.positions()).map(fade).collect());
    let (deltas, choice) = choose(&fading, &Auto::default(), &Silent).unwrap();
    // From 21°. By one deviation for all, 7° were left.
    assert!(off(&clean, &fading.moved_by(&deltas)) < 2.5, "{choice}");
}

#[test]
fn a_spike_goes_to_its_neighbours_and_these_stay() {
    let clean = shapes::sphere(4);
    let spiked = |v: usize, p: &DVec3| if v == 77 { *p * 1.3 } else { *p };
    let spiky = clean.at(clean.positions().iter().enumerate().map(|(v, p)| spiked(v, p)).collect());
    let (deltas, choice) = choose(&spiky, &Auto::default(), &Silent).unwrap();
    let moved: Vec<usize> = (0..deltas.len()).filter(|&v| deltas[v] != DVec3::ZERO).collect();
    assert!(moved == [77] && choice.outliers == 1, "{moved:?} {choice}");
    assert!(choice.to_string().ends_with(": one spike removed, all else left alone"), "{choice}");
    let (none, _) = choose(&spiky, &Auto { strength: 0.0, ..Auto::default() }, &Silent).unwrap();
    assert!(none.iter().all(|d| *d == DVec3::ZERO));
    assert!((spiky.positions()[77] - deltas[77]).distance(clean.positions()[77]) < 0.2 * clean.mean_edge());
}

#[test]
fn rounded_coordinates_stay_within_half_a_step() {
    let clean = shapes::sphere(5);
    let step = 0.5 * clean.mean_edge();
    let rounded = moved(&clean, |p| (p / step).round() * step);
    let (deltas, choice) = choose(&rounded, &Auto::default(), &Silent).unwrap();
    assert!(deltas.iter().all(|d| d.abs().max_element() <= 0.5 * step * (1.0 + 1e-9)), "{choice}");
    assert!(off(&clean, &rounded.moved_by(&deltas)) < 0.5 * off(&clean, rounded.positions()), "{choice}");
}

#[test]
fn what_cannot_be_measured_is_not_called_clean() {
    let ball = noisy(&shapes::sphere(3), 0.2);
    let corners = ball.triangles().flatten().map(|v| ball.positions()[v as usize]).collect::<Vec<_>>();
    let faces = (0..corners.len() as u32 / 3).map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let soup = Surface::new(Topology::new(corners.len(), faces), corners);
    let (deltas, choice) = choose(&soup, &Auto::default(), &Silent).unwrap();
    assert!(deltas.iter().all(|d| *d == DVec3::ZERO) && choice.unmeasured == 1.0);
    assert!(choice.to_string().starts_with("noise that cannot be measured"), "{choice}");
}

#[test]
fn strength_scales_the_noise_and_none_leaves_the_mesh_alone() {
    let clean = shapes::sphere(3);
    let noisy = noisy(&clean, 0.2);
    let moved = |strength: f64| {
        let (deltas, choice) = choose(&noisy, &Auto { strength, ..Auto::default() }, &Silent).unwrap();
        (deltas.iter().map(|d| d.length()).sum::<f64>(), choice.sigma)
    };
    let (usual, sigma) = moved(1.0);
    assert_eq!(moved(0.0), (0.0, 0.0));
    assert!(moved(0.3).0 < usual && (moved(2.0).1 / sigma - 2.0).abs() < 1e-9);
}

#[test]
fn noise_that_hits_few_vertices_goes_and_the_others_stay_where_they_are() {
    let clean = shapes::sphere(4);
    let noise = Noise { sigma: 0.5, direction: synthetic_noise::Direction::Normal, share: 0.2, seed: 5 };
    let hit = synthetic_noise::noisy(&clean, &noise);
    let (deltas, choice) = choose(&hit, &Auto::default(), &Silent).unwrap();
    let result = hit.moved_by(&deltas);
    let sigma = Some(noise.sigma * noise.share.sqrt());
    let (deltas, _) = choose(&hit, &Auto { noise: sigma, ..Auto::default() }, &Silent).unwrap();
    let by_one_deviation = hit.moved_by(&deltas);
    let [each, one] = [&result, &by_one_deviation].map(|positions| off(&clean, positions));
    assert!(choice.hit > 0.1 && choice.hit < 0.3 && each < 0.6 * one, "{each} {one} {choice}");
}

#[test]
fn terraces_of_rounded_heights_become_a_slope() {
    let grid = shapes::grid(40);
    let step = 1.0 / 40.0;
    let height = |p: &DVec3| 0.1 * (3.0 * p.x).sin() * (2.0 * p.y).cos();
    let with =
        |z: &dyn Fn(f64) -> f64| grid.at(grid.positions().iter().map(|p| DVec3::new(p.x, p.y, z(height(p)))).collect());
    let (clean, terraces) = (with(&|z| z), with(&|z| (z / step).round() * step));
    let (deltas, choice) = choose(&terraces, &Auto::default(), &Silent).unwrap();
    let result = terraces.moved_by(&deltas);
    assert!(deltas.iter().all(|delta| delta.z.abs() <= 0.5 * step + 1e-9), "{choice}");
    let [before, after] = [terraces.positions(), &result].map(|positions| off(&clean, positions));
    assert!(after < 0.5 * before, "{before} {after} {choice}");
}

#[test]
fn the_learned_filter_has_a_say_unless_noise_or_candidates_are_told() {
    let clean = shapes::gridded_box(16);
    let noisy = noisy(&clean, 0.2);
    let share = |settings: &Auto| {
        let (_, choice) = choose(&noisy, settings, &Silent).unwrap();
        assert!((choice.candidates.iter().map(|c| c.share).sum::<f64>() - 1.0).abs() < 1e-9, "{choice}");
        choice.candidates.iter().find(|c| c.candidate == Candidate::Learned).map_or(0.0, |c| c.share)
    };
    let usual = share(&Auto::default());
    assert!(usual > 0.1, "{usual}");
    let half = share(&Auto { strength: 0.5, ..Auto::default() });
    assert!(half < usual, "{half} {usual}");
    let nearly = share(&Auto { strength: 0.9, ..Auto::default() });
    assert!(nearly > 0.0 && nearly < usual, "{nearly} {usual}");
    assert_eq!(share(&Auto { noise: Some(0.2), ..Auto::default() }), 0.0);
    assert_eq!(share(&Auto { candidates: Some(vec![Candidate::Flat, Candidate::Smooth]), ..Auto::default() }), 0.0);
}

#[test]
fn the_learned_filter_told_by_name_is_the_method() {
    let clean = shapes::gridded_box(16);
    let noisy = noisy(&clean, 0.2);
    let alone = Auto { noise: Some(0.2), candidates: Some(vec![Candidate::Learned]), ..Auto::default() };
    let [by_name, method] = [alone.deltas(&noisy, &Silent), Denoiser::Learned(<_>::default()).deltas(&noisy, &Silent)]
        .map(|deltas| off(&clean, &noisy.moved_by(&deltas.unwrap())));
    assert!((by_name - method).abs() < 0.05 * method, "{by_name} {method}");
}

#[test]
fn regular_pleats_are_no_noise() {
    let sheet = shapes::grid(40);
    for (count, depth) in [(10.0, 0.12), (13.0, 0.08)] {
        let pleat = |x: f64| depth * (count * x - (count * x).round()).abs();
        let clean = sheet.at(sheet.positions().iter().map(|p| DVec3::new(p.x, p.y, pleat(p.x))).collect());
        let left = |sigma: f64| {
            let noisy = if sigma > 0.0 { noisy(&clean, sigma) } else { clean.clone() };
            let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
            [off(&clean, noisy.positions()), off(&clean, &noisy.moved_by(&deltas))].map(|angle| (angle, choice.clone()))
        };
        let [_, (after, choice)] = left(0.0);
        assert_eq!(after, 0.0, "{count} clean pleats: {choice}");
        // Taken for noise, they would be flattened: 32° with thirteen of them, 48° with ten of them in more noise.
        let [(before, _), (after, choice)] = left(0.1);
        assert!(after <= 1.01 * before, "{count} pleats: {before} {after} {choice}");
        if count == 10.0 {
            let [(before, _), (after, choice)] = left(0.2);
            assert!(after < 0.5 * before, "{count} pleats: {before} {after} {choice}");
        }
    }
}

#[test]
fn small_shares_go_to_the_others_and_equal_ones_stay() {
    let shares = |all: &[f64]| -> Vec<f64> {
        let of = |(share, candidate): (&f64, Candidate)| CandidateShare {
            share: *share,
            ..CandidateShare::all_of(candidate)
        };
        let kept = without_small_shares(all.iter().zip(Candidate::ALL).map(of).collect());
        kept.iter().map(|share| share.share).collect()
    };
    assert_eq!(shares(&[0.5, 0.25, 0.125, 0.125]), [2.0 / 3.0, 1.0 / 3.0, 0.0, 0.0]);
    // More candidates than there is room for in large shares.
    let equal = shares(&[0.1; 10]);
    assert!(equal.iter().all(|share| (share - 0.1).abs() < 1e-12), "{equal:?}");
}
