use super::*;
use crate::denoise::Denoiser;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::jagged::Ragged;
use crate::mesh::shapes;
use crate::mesh::topology::Topology;
use crate::progress::Silent;

fn mean_angle(a: &Surface, b: &Surface) -> f64 {
    let mesh = TriangleMesh::of(a);
    let [a, b] = [a, b].map(|surface| FaceGeometry::of(&mesh, surface.positions()).normals);
    a.iter().zip(&b).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / a.len() as f64
}

#[test]
fn the_built_in_weights_have_three_stages_and_a_fusion() {
    let weights = LearnedWeights::built_in();
    assert_eq!(weights.stages.len(), 3);
    assert!(weights.fusion.is_some());
}

#[test]
fn weights_that_are_none_are_refused_by_what_is_wrong_with_them() {
    let message = |bytes: &[u8]| LearnedWeights::parse(bytes).unwrap_err().to_string();
    assert_eq!(message(b"short"), "not a safetensors file: it is shorter than its head");
    assert_eq!(message(&[255; 16]), "not a safetensors file: its head is longer than the file");
    let good = include_bytes!("weights.safetensors");
    // The file ends in the last tensor.
    assert!(message(&good[..good.len() - 2]).ends_with(": outside of the file"));
    let mut infinite = good.to_vec();
    let head = 8 + u64::from_le_bytes(*good.first_chunk().unwrap()) as usize;
    infinite[head..head + 2].copy_from_slice(&[0, 0x7c]);
    assert_eq!(message(&infinite), "tensor `stage0.mean`: has numbers that are not finite");
}

#[test]
fn without_stages_nothing_moves() {
    let noisy = displaced(&shapes::sphere(3), &white_noise(&shapes::sphere(3), 0.2, 1));
    let settings = Learned { loaded: Some(LearnedWeights::none().into()), ..Learned::default() };
    let deltas = Denoiser::Learned(settings).deltas(&noisy, &Silent).unwrap();
    assert!(deltas.iter().all(|delta| *delta == DVec3::ZERO));
}

#[test]
fn each_stage_brings_a_noisy_box_nearer_to_the_clean_one() {
    let clean = shapes::gridded_box(16);
    let noisy = displaced(&clean, &white_noise(&clean, 0.2, 1));
    let after = |stages: usize| {
        let loaded = Some(LearnedWeights::built_in().truncated(stages).into());
        let learned = Denoiser::Learned(Learned { loaded, ..Learned::default() });
        mean_angle(&clean, &noisy.at(learned.denoised(&noisy, &Silent).unwrap()))
    };
    let [none, one, two, three] = [0, 1, 2, 3].map(after);
    assert!(one < 0.2 * none && two < one && three < 1.05 * two, "{none} {one} {two} {three}");
}

#[test]
fn samples_hold_what_the_filter_sees_and_the_true_normals() {
    let clean = shapes::sphere(3);
    let noisy = displaced(&clean, &white_noise(&clean, 0.1, 2));
    let found = samples(&clean, &noisy, &LearnedWeights::none(), None, |f| f % 7 == 0, &Silent).unwrap();
    assert_eq!(found.features.len(), found.normals.len() * feature_count(0));
    // The frame's first axis is a filtered normal, so the true normal is near to it.
    assert!(found.normals.iter().all(|n| n[0] > 0.8), "{:?}", found.normals);
}

/// Features of every third face of a noisy ball in a unit of this many mean edges, after its vertices have moved a little. #T lists
fn features_in_unit(scale: f64) -> Vec<Vec<f32>> {
    // In light noise no face is so unlike all around it that its weights are no numbers beside those that keep quotients finite.
    let noisy = displaced(&shapes::sphere(3), &white_noise(&shapes::sphere(3), 0.03, 1));
    let mesh = TriangleMesh::of(&noisy);
    let mut cascade = Cascade::new(noisy.positions(), &mesh, vec![false; noisy.positions().len()]);
    let drifted = |p: &DVec3| *p + 0.1 * DVec3::new((0.3 * p.y).sin(), (0.2 * p.z).cos(), 0.3);
    cascade.positions = cascade.input.iter().map(|p| scale * drifted(p)).collect();
    cascade.input.iter_mut().for_each(|p| *p *= scale);
    cascade.input_faces = FaceGeometry::of(&mesh, &cascade.input);
    let mean: Vec<DVec3> = cascade.input.iter().zip(&cascade.positions).map(|(p, x)| (*p + *x) / 2.0).collect();
    let between = FaceGeometry::of(&mesh, &mean);
    let [normals, centroids] =
        [between.normals, between.centroids].map(|all| all.iter().map(|x| x.as_vec3()).collect());
    cascade.with_fields(&[OtherSurface { normals, centroids }], |fields| {
        let mut scratch = Scratch::default();
        let of_face = |face: usize| {
            let mut row = vec![0.0; feature_count(1)];
            fields.write(face, &mut scratch, &mut row);
            row
        };
        (0..fields.len()).step_by(3).map(of_face).collect()
    })
}

#[test]
fn features_are_the_same_in_every_unit_but_for_the_one_that_tells_it() {
    let expected = features_in_unit(1.0);
    assert!(expected.iter().flatten().all(|x| x.is_finite()));
    // A power of two rounds nothing; what keeps quotients finite is far below the numbers beside it.
    let scale: f32 = 4.0;
    let mut differ = Vec::new();
    for (found, expected) in features_in_unit(f64::from(scale)).iter().zip(&expected) {
        for (k, (a, b)) in found.iter().zip(expected).enumerate().filter(|(_, (a, b))| (*a - *b).abs() > 1e-4) {
            assert!((a - b - scale.ln()).abs() < 1e-4, "feature {k}: {a} and {b}");
            differ.push(k);
        }
    }
    assert!(differ.len() == expected.len() && differ.iter().all(|k| *k == differ[0]), "{differ:?}");
}

#[test]
fn the_surface_of_another_method_has_the_normals_of_its_result() {
    let noisy = displaced(&shapes::sphere(2), &white_noise(&shapes::sphere(2), 0.2, 1));
    let mesh = TriangleMesh::of(&noisy);
    let deltas = white_noise(&noisy, 0.3, 8);
    let result = noisy.moved_by(&deltas);
    let cascade = Cascade::new(noisy.positions(), &mesh, vec![false; noisy.positions().len()]);
    let other = cascade.other(&deltas);
    let expected = FaceGeometry::of(&mesh, &result);
    for f in 0..mesh.face_count() {
        assert!(other.normals[f].distance(expected.normals[f].as_vec3()) < 1e-6);
        // In mean edges around the centre, which is the same for all.
        let step = expected.centroids[f] - cascade.units[0] * other.centroids[f].as_dvec3();
        let first = expected.centroids[0] - cascade.units[0] * other.centroids[0].as_dvec3();
        assert!(step.distance(first) < 1e-6, "{f}");
    }
}

#[test]
fn each_component_has_the_frame_that_it_has_alone() {
    let small = shapes::dented_sphere(1);
    let count = small.positions().len();
    let large: Vec<DVec3> = small.positions().iter().map(|p| 7.0 * *p + DVec3::new(20.0, -3.0, 5.0)).collect();
    let both = [small.positions(), &large].concat();
    let second = |t: [Index; 3]| t.map(|v| v + count as Index).to_vec();
    let faces = small.triangles().map(Vec::from).chain(small.triangles().map(second)).collect();
    let surface = Surface::new(Topology::new(both.len() + 1, faces), [both, vec![DVec3::ONE]].concat());
    let frames = own_frames(&TriangleMesh::of(&surface), surface.positions());
    let triangles: Vec<[DVec3; 3]> = small.triangles().map(|t| t.map(|v| small.positions()[v as usize])).collect();
    let corners = 3.0 * triangles.len() as f64;
    let centre = triangles.iter().flatten().sum::<DVec3>() / corners;
    let sides = triangles.iter().flat_map(|[a, b, c]| [a.distance(*b), b.distance(*c), c.distance(*a)]);
    let side = sides.sum::<f64>() / corners;
    for (v, (found, unit)) in frames.iter().enumerate() {
        let (expected, length) = match v {
            _ if v < count => (centre, side),
            _ if v < 2 * count => (7.0 * centre + DVec3::new(20.0, -3.0, 5.0), 7.0 * side),
            // A vertex without faces has itself.
            _ => (DVec3::ONE, 1.0),
        };
        assert!(found.distance(expected) < 1e-12 && (unit - length).abs() < 1e-12, "{v}: {found} {unit}");
    }
}

#[test]
fn the_logistic_function_of_opposite_numbers_adds_up_to_one_and_rises() {
    let steps: Vec<f32> = (-60..=60).map(|k| 0.25 * k as f32).collect();
    assert!(steps.iter().all(|x| (logistic(*x) + logistic(-*x) - 1.0).abs() < 1e-6));
    assert!(steps.windows(2).all(|x| logistic(x[0]) <= logistic(x[1])) && logistic(0.0) == 0.5);
    assert!((logistic(1.0) - 1.0 / (1.0 + (-1.0f32).exp())).abs() < 1e-6);
}

#[test]
fn a_face_is_between_what_is_found_and_its_own_normal_by_the_share_that_it_keeps() {
    // One candidate, no correction; the gate is 2 · 0.
    let mut outputs = [0.0; 1 + FURTHER_OUTPUTS];
    let of = |outputs: &mut [f32], others| mixed(outputs, &[Vec3::X], others, Mat3::IDENTITY, Vec3::Y);
    let half = of(&mut outputs, 1);
    assert!(half.normal.unwrap().distance(Vec3::new(1.0, 1.0, 0.0).normalize()) < 1e-6);
    assert_eq!(half.others_share, 1.0);
    let mut sure = [0.0, 0.0, 0.0, 0.0, -20.0];
    let found = of(&mut sure, 0);
    assert!(found.normal.unwrap().distance(Vec3::X) < 1e-6 && found.others_share == 0.0);
    let mut kept = [0.0, 0.0, 0.0, 0.0, 20.0];
    assert!(of(&mut kept, 0).normal.is_none());
}

#[test]
fn a_mesh_without_faces_has_all_of_the_other_method() {
    let mesh = TriangleMesh::of(&Surface::new(Topology::new(2, Ragged::default()), vec![DVec3::X; 2]));
    let found = fused(&[DVec3::X; 2], &mesh, vec![false; 2], &[DVec3::ZERO; 2], &Silent).unwrap().unwrap();
    assert!(found.deltas == [DVec3::ZERO; 2] && found.others_share == 1.0);
}
