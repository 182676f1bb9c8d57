//! Laws of the statistics of regions.

use super::*;
use crate::denoise::noise_field::{LEAST_REGION, RINGS};
use crate::denoise::tests::{displaced, white_noise};
use crate::mesh::shapes;
use crate::progress::Silent;

fn of_regions(surface: &Surface) -> Vec<[f64; COUNT]> {
    let connectivity = Connectivity::of(surface);
    let regions = Regions::of(surface.topology(), 0, RINGS, LEAST_REGION);
    let statistics = Statistics::of(surface, &connectivity, &Silent).unwrap();
    statistics.of_regions(&regions).into_iter().flatten().collect()
}

/// Mean of a statistic over the regions.
fn mean(of: &[[f64; COUNT]], index: usize) -> f64 {
    of.iter().map(|all| all[index]).sum::<f64>() / of.len() as f64
}

#[test]
fn statistics_are_the_same_in_every_unit() {
    let clean = shapes::bumpy_sheet(40);
    let noisy = displaced(&clean, &white_noise(&clean, 0.1, 4));
    let expected = of_regions(&noisy);
    assert!(expected.len() > 5);
    for scale in [1.0 / 512.0, 64.0] {
        // Powers of two round nothing.
        let scaled = noisy.at(noisy.positions().iter().map(|p| scale * *p).collect());
        for (found, expected) in of_regions(&scaled).iter().zip(&expected) {
            let gap = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(gap < 1e-9, "{gap} in another unit");
        }
    }
}

#[test]
fn white_noise_fills_all_bands_alike_and_has_the_quantiles_of_a_gaussian() {
    let clean = shapes::grid(60);
    let sigma: f64 = 0.05;
    let found = of_regions(&displaced(&clean, &white_noise(&clean, sigma, 4)));
    // The edges of a cell are 1, 1 and √2 of them long; a region of a hundred vertices knows its deviation to an eighth.
    for band in 0..BANDS {
        let log = mean(&found, band) - sigma.ln();
        assert!(log.abs() < 0.25, "band {band}: {log}");
    }
    // ln(Φ⁻¹(0.95) / Φ⁻¹(0.75)) and ln(Φ⁻¹(0.625) / Φ⁻¹(0.75)).
    for band in 0..SHAPED {
        let [tail, quarter] = [0, 1].map(|k| mean(&found, BANDS + 2 * band + k));
        assert!((tail - TAIL_OF_GAUSSIAN).abs() < 0.08 && (quarter + 0.7498).abs() < 0.1, "{band}: {tail} {quarter}");
    }
    // Neighbours are as alike as in white noise.
    for k in 0..CORRELATED {
        let excess = mean(&found, BANDS + 2 * SHAPED + k);
        assert!(excess.abs() < 0.08, "{k}: {excess}");
    }
}

#[test]
fn a_flat_grid_has_no_angles_and_lengths_and_valences_that_vary_as_they_do() {
    let grid = shapes::grid(60);
    let inner: Vec<[f64; COUNT]> = of_regions(&grid);
    // Of the six edges at a vertex four are 1 and two √2 long, so the deviation is (√2 − 1) √2 / 3 over a mean of (4 + 2√2) / 6.
    let root = 2f64.sqrt();
    let expected = (root - 1.0) * root / 3.0 / ((4.0 + 2.0 * root) / 6.0);
    for own in &inner {
        let [lengths, valences] = [ACROSS + 3, ACROSS + 4].map(|k| own[k]);
        assert!((lengths - expected.ln()).abs() < 1e-9, "{lengths} {}", expected.ln());
        assert_eq!(valences, 0.0);
        assert_eq!(own[ACROSS + 1], 1e-7f64.ln(), "angles");
    }
}

#[test]
fn the_spread_of_a_few_numbers_is_their_deviation_over_their_mean() {
    assert!((variation(&[1.0, 3.0]) - 0.5).abs() < 1e-15);
    assert!((variation(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]) - 0.4).abs() < 1e-15);
    assert_eq!(variation(&[]), 0.0);
    assert_eq!(variation(&[7.0; 5]), 0.0);
}

#[test]
fn local_edges_are_the_middle_one_of_those_around_a_vertex() {
    // Stretched three times along y, edges are 1, 3 and √10 cells long, two of each at a vertex.
    let cell = 1.0 / 24.0;
    let grid = shapes::grid(24);
    let stretched = grid.at(grid.positions().iter().map(|p| DVec3::new(p.x, 3.0 * p.y, p.z)).collect());
    let found = local_edges(&stretched, stretched.positions());
    for (p, edge) in stretched.positions().iter().zip(found) {
        // Evening them out brings in what is up to four rings away, and the vertices at the boundary have fewer edges.
        let inside = |x: f64, cells: f64| x > cells - 1e-9 && x < 1.0 - cells + 1e-9;
        if inside(p.x, 5.0 * cell) && inside(p.y / 3.0, 5.0 * cell) {
            assert!((edge / (3.0 * cell) - 1.0).abs() < 1e-12, "{edge} at {p}");
        }
    }
}

#[test]
fn a_vertex_whose_edges_have_no_length_has_the_local_edge_of_those_around() {
    // The whole ring of a vertex lies where it does.
    let grid = shapes::grid(16);
    let ring = grid.topology().rings().get(144).to_vec();
    let mut positions = grid.positions().to_vec();
    ring.iter().for_each(|&w| positions[w as usize] = positions[144]);
    let found = local_edges(&grid, &positions);
    assert!(found[144] > 0.5 / 16.0 && found[144] < 2.0 / 16.0, "{}", found[144] * 16.0);
    assert!(found.iter().all(|edge| edge.is_finite() && *edge > 0.0));
}
