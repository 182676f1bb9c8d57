use super::*;
use crate::denoise::Denoiser;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
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
