use super::*;
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Noise};
use crate::progress::Silent;

fn level(surface: &Surface) -> NoiseLevel {
    NoiseEstimate::of(surface, &Connectivity::of(surface), &Silent).unwrap().level
}

/// White noise smoothed over some edges, of `sigma` mean edges along the normals.
pub(in crate::denoise) fn with_correlated_noise(clean: &Surface, sigma: f64, seed: u64) -> Surface {
    let white = gaussians(clean.positions().len(), seed);
    let connectivity = Connectivity::of(clean);
    let smooth = connectivity.umbrella.smoothed(&white, 4.0, &BoundaryConstraint::default(), &Silent).unwrap();
    let rms = (smooth.iter().map(|g| g.x * g.x).sum::<f64>() / smooth.len() as f64).sqrt();
    let normals = connectivity.vertex_normals(clean.positions());
    let scale = sigma * clean.mean_edge() / rms;
    let noise: Vec<DVec3> = smooth.iter().zip(normals).map(|(g, n)| scale * g.x * n).collect();
    displaced(clean, &noise)
}

#[test]
fn sigma_is_known_to_three_standard_errors() {
    const DRAWS: u64 = 12;
    // A bias of this many mean edges is allowed beyond the errors: edges of the box are in the finest band too.
    let cases = [(shapes::sphere(3), 0.0), (shapes::bumpy_sheet(28), 0.0), (shapes::gridded_box(16), 0.03)];
    for (surface, (clean, bias)) in cases.iter().enumerate() {
        for sigma in [0.1, 0.2, 0.3] {
            let draw = |seed| level(&displaced(clean, &white_noise(clean, sigma, seed))).fine;
            let found: Vec<f64> = (0..DRAWS).map(draw).collect();
            let mean = found.iter().sum::<f64>() / DRAWS as f64;
            let variance = found.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
            let error = (variance / DRAWS as f64).sqrt();
            let too_much = mean - sigma;
            assert!(-3.0 * error < too_much && too_much < bias + 3.0 * error, "surface {surface}: {mean} ± {error}");
            // Neighbours share noise, and the median is less exact than the deviation of all; still one draw of 640 vertices
            // is known to 7 %.
            assert!(error < 0.02 * sigma, "{error}");
        }
    }
}

#[test]
fn noise_in_all_directions_is_as_large_tangentially_as_along_the_normals() {
    for clean in [shapes::sphere(4), shapes::bumpy_sheet(40)] {
        let length = 0.2 * clean.mean_edge();
        let noise: Vec<DVec3> = gaussians(clean.positions().len(), 6).iter().map(|g| length * *g).collect();
        let found = level(&displaced(&clean, &noise));
        // The unit is the mean edge of the smoothed mesh, which is not quite that of the clean one.
        for sigma in [found.fine, found.tangential] {
            assert!((sigma / 0.2 - 1.0).abs() < 0.1, "{found:?}");
        }
    }
}

#[test]
fn noise_is_what_it_was_made_as() {
    for clean in [shapes::sphere(4), shapes::gridded_box(16), shapes::bumpy_sheet(40)] {
        assert_eq!(level(&clean).kind(), Kind::None);
        let white = Noise { sigma: 0.2, direction: synthetic_noise::Direction::Normal, share: 1.0, seed: 1 };
        let found = level(&synthetic_noise::noisy(&clean, &white));
        assert_eq!(found.kind(), Kind::Independent, "{found:?}");
        // A fifth of the vertices is hit.
        let impulsive = Noise { share: 0.2, sigma: 0.4, ..white };
        let found = level(&synthetic_noise::noisy(&clean, &impulsive));
        assert_eq!(found.kind(), Kind::Uneven, "{found:?}");
        let found = level(&with_correlated_noise(&clean, 0.5, 3));
        assert_eq!(found.kind(), Kind::Correlated, "{found:?}");
    }
}

/// Statistics of white noise of a fifth of an edge.
const WHITE: NoiseLevel =
    NoiseLevel { fine: 0.2, tail: 0.2, coarse: 0.2, sign_agreement: 0.0, tangential: 0.1, skewness: 0.0 };

/// Kind of the noise by its statistics, and σ for that kind.
fn said(level: NoiseLevel) -> (Kind, f64) {
    (level.kind(), level.sigma_as(level.kind()))
}

fn assert_said(level: NoiseLevel, kind: Kind, sigma: f64) {
    let found = said(level);
    assert!(found.0 == kind && (found.1 - sigma).abs() < 1e-12, "{level:?}: {found:?} and not {kind:?} {sigma}");
}

#[test]
fn the_tail_makes_noise_uneven_and_adds_to_it_up_to_a_bound() {
    assert_said(WHITE, Kind::Independent, 0.2);
    assert_said(NoiseLevel { tail: 0.25, ..WHITE }, Kind::Independent, 0.25);
    assert_said(NoiseLevel { tail: 0.27, ..WHITE }, Kind::Uneven, 0.27);
    assert_said(NoiseLevel { tail: 0.9, ..WHITE }, Kind::Uneven, 1.6 * 0.2);
    // A tail below the median is chance.
    assert_said(NoiseLevel { tail: 0.1, ..WHITE }, Kind::Independent, 0.2);
}

#[test]
fn a_coarse_band_beyond_the_fine_one_makes_noise_correlated() {
    let excess = |coarse: f64| (coarse * coarse - 1.21 * 0.04).sqrt();
    // Neighbours agree as they do where a surface has detail, so it is no roughness; the factor of σ is at most 5.
    let smooth = NoiseLevel { sign_agreement: 0.02, ..WHITE };
    assert_said(NoiseLevel { coarse: 0.4, ..smooth }, Kind::Correlated, 1.5 * 5.0 * 0.2);
    let factor = (excess(0.26) / 0.07).powi(2);
    assert!(factor > 2.5 && factor < 5.0);
    assert_said(NoiseLevel { coarse: 0.26, ..smooth }, Kind::Correlated, 1.5 * factor * 0.2);
    // So much is detail of common surfaces.
    assert_said(NoiseLevel { coarse: 0.24, ..smooth }, Kind::Independent, 0.2);
    // Neighbours do not agree at all.
    assert_said(NoiseLevel { coarse: 0.4, ..WHITE }, Kind::Correlated, 7.5 * excess(0.4));
}

#[test]
fn little_and_skewed_noise_is_none() {
    for skewness in [0.13, -0.13] {
        assert_eq!(NoiseLevel { skewness, ..WHITE }.kind(), Kind::None);
    }
    assert_eq!(NoiseLevel { skewness: 0.12, ..WHITE }.kind(), Kind::Independent);
    let little = NoiseLevel { fine: 0.036, tail: 0.036, coarse: 0.036, ..WHITE };
    assert_said(little, Kind::Independent, 0.036);
    assert_eq!(NoiseLevel { fine: 0.034, tail: 0.034, ..little }.kind(), Kind::None);
    // Half of the variance is detail of the surface.
    let detailed = NoiseLevel { sign_agreement: 0.01 + 0.5 * 0.045, ..little };
    assert_said(detailed, Kind::None, 0.036 * 0.5f64.sqrt());
    assert_said(NoiseLevel { sign_agreement: 0.1, ..little }, Kind::None, 0.0);
    // Roughness over many edges shows that it is no detail, so less is enough.
    let rough = NoiseLevel { fine: 0.03, tail: 0.03, coarse: 0.1, sign_agreement: 0.0, ..WHITE };
    assert_eq!(rough.kind(), Kind::Correlated);
    assert_eq!(NoiseLevel { fine: 0.019, tail: 0.019, ..rough }.kind(), Kind::None);
}

#[test]
fn tangential_stiffness_is_the_ratio_of_the_variances_less_one() {
    for kind in [Kind::Independent, Kind::Uneven] {
        assert!((WHITE.tangential_stiffness(kind) - 3.0).abs() < 1e-12);
        assert_eq!(NoiseLevel { tangential: 0.3, ..WHITE }.tangential_stiffness(kind), 0.0);
        for tangential in [0.01, 0.0] {
            assert_eq!(NoiseLevel { tangential, ..WHITE }.tangential_stiffness(kind), 15.0);
        }
    }
    for kind in [Kind::None, Kind::Correlated] {
        assert_eq!(WHITE.tangential_stiffness(kind), 0.0);
    }
}

#[test]
fn skewness_is_that_of_the_deciles() {
    let ramp = |k: usize| k as f64 / 1e4;
    let of = |f: fn(f64) -> f64| quantile_skewness((0..10_000).map(|k| f(ramp(k))).collect());
    assert!(of(|x| x).abs() < 1e-3);
    // The quotient is (0.64 + 0.04 − 2 · 0.25) / (0.64 − 0.04).
    assert!((of(|x| x * x) - 0.3).abs() < 1e-3 && (of(|x| -x * x) + 0.3).abs() < 1e-3);
    assert_eq!(quantile_skewness(vec![0.0; 10_000]), 0.0);
    // So few values tell nothing.
    assert_eq!(quantile_skewness((0..1999).map(|k| ramp(k).powi(2)).collect()), 0.0);
}

#[test]
fn heights_to_one_side_agree_on_every_edge_of_the_band_and_on_no_other() {
    // The vertices near the boundary are in no band, and their edges say nothing.
    let grid = shapes::grid(12);
    let band = FinestBand::of(&Connectivity::of(&grid));
    assert!(!band.vertices.is_empty() && band.vertices.len() < grid.positions().len());
    for side in [1.0, -1.0] {
        assert_eq!(band.sign_agreement(&grid, &vec![side * 0.3; band.vertices.len()]), 1.0);
    }
    let alone: Vec<f64> = (0..band.vertices.len()).map(|k| f64::from(u8::from(k == 0))).collect();
    assert_eq!(band.sign_agreement(&grid, &alone), 0.0);
}
