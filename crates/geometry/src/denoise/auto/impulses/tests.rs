//! Noise that hits single vertices is told from noise that differs from place to place.

use super::*;
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::denoise::noise_level::{gaussians, median};
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use crate::progress::Silent;

/// Noise of the vertices of a sphere, each of which moves by `factor` (of its number and position) times white noise of half an edge.
fn found_on_a_sphere(factor: impl Fn(usize, DVec3) -> f64) -> Option<Impulses> {
    const SIGMA: f64 = 0.5;
    let clean = shapes::sphere(4);
    let factors: Vec<f64> = clean.positions().iter().enumerate().map(|(v, p)| factor(v, *p)).collect();
    let noise = white_noise(&clean, SIGMA, 6);
    let noisy = displaced(&clean, &noise.iter().zip(&factors).map(|(d, factor)| *factor * *d).collect::<Vec<_>>());
    let rms = (factors.iter().map(|x| x * x).sum::<f64>() / factors.len() as f64).sqrt();
    let (connectivity, constraint) = (Connectivity::of(&noisy), BoundaryConstraint::default());
    let field = NoiseField::uniform(factors.len(), SIGMA * rms, noisy.mean_edge(), 0.0);
    by_vertex(&Problem::new(&connectivity, &constraint, &field), noisy.positions(), &Silent).unwrap()
}

#[test]
fn vertices_that_were_hit_are_told_from_their_neighbours() {
    let is_hit = |v: usize| v.is_multiple_of(5);
    let found = found_on_a_sphere(|v, _| if is_hit(v) { 1.0 } else { 0.1 }).unwrap();
    assert!((found.share - 0.2).abs() < 0.1, "{}", found.share);
    let [hit, others] = [true, false].map(|hit| {
        median((0..found.relative.len()).filter(|&v| is_hit(v) == hit).map(|v| found.relative[v]).collect())
    });
    // Some that were hit have moved by little, which nobody can tell.
    assert!(hit > 4.0 * others, "{hit} {others}");
}

#[test]
fn noise_that_is_more_in_some_places_hits_no_single_vertices() {
    // A tenth of the noise below, all of it above, and a slope of nine edges between them.
    let slope = |p: DVec3| ((p.z - 0.1) / 0.6).clamp(0.0, 1.0);
    assert!(found_on_a_sphere(|_, p| 0.1 + 0.9 * slope(p)).is_none());
}

#[test]
fn few_values_with_much_noise_are_told_from_the_others() {
    let values: Vec<f64> =
        gaussians(4000, 3).iter().enumerate().map(|(i, g)| if i % 5 == 0 { 5.0 * g.x } else { 0.2 * g.y }).collect();
    let found = TwoGaussians::of(&values).unwrap();
    let [little, much] = found.variances.map(f64::sqrt);
    assert!((little / 0.2 - 1.0).abs() < 0.05 && (much / 5.0 - 1.0).abs() < 0.1, "{found:?}");
    assert!((found.share - 0.2).abs() < 0.03, "{found:?}");
    assert!(found.variance(0.1).sqrt() < 0.25 && found.variance(8.0).sqrt() > 4.5);
    for same in [1e-8, 1.0, 1e8] {
        let white: Vec<f64> = gaussians(4000, 4).iter().map(|g| same * g.x).collect();
        assert!(TwoGaussians::of(&white).is_none());
    }
    assert!(TwoGaussians::of(&[]).is_none() && TwoGaussians::of(&[0.0; 9]).is_none());
}
