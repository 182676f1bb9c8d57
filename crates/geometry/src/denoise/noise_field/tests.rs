//! Laws of the noise estimate.

use super::statistics::COUNT;
use super::*;
use crate::denoise::noise_level::NoiseEstimate;
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Direction, Noise};
use crate::mesh::topology::Topology;
use crate::progress::Silent;

fn white(clean: &Surface, sigma: f64) -> Surface {
    synthetic_noise::noisy(clean, &Noise { sigma, direction: Direction::Normal, share: 1.0, seed: 3 })
}

fn measured(surface: &Surface, verdict: Verdict) -> NoiseField {
    NoiseField::measured(surface, &Connectivity::of(surface), verdict, &Silent).unwrap()
}

#[test]
fn the_network_that_is_built_in_reads_statistics() {
    let network = Network::built_in();
    let reading = network.read(&[0.5; COUNT]);
    assert!(reading.correlation.is_finite() && reading.log_excess.is_finite());
}

#[test]
fn the_deviation_of_white_noise_is_found_in_every_unit() {
    let clean = shapes::sphere(4);
    for scale in [1e-3, 1.0, 1e4] {
        let noisy = white(&clean, 0.2);
        let scaled = noisy.at(noisy.positions().iter().map(|p| scale * *p).collect());
        let noise = measured(&scaled, Verdict::ByEvidence);
        // 2562 vertices: the median is known to 2 %. Edges of the smoothed mesh are a little shorter than those of the clean one.
        assert!((noise.typical() / 0.2 - 1.0).abs() < 0.12, "{scale}: {}", noise.typical());
        assert!(noise.noisy_fraction() == 1.0 && noise.correlation == 0, "{scale}");
    }
}

#[test]
fn noise_of_a_half_is_measured_there() {
    let clean = shapes::sphere(5);
    let noisy = white(&clean, 0.3);
    let half = |(p, q): (&DVec3, &DVec3)| if p.z > 0.0 { *q } else { *p + (*q - *p) * 0.2 };
    let uneven = clean.at(clean.positions().iter().zip(noisy.positions()).map(half).collect());
    let noise = measured(&uneven, Verdict::Noisy);
    let mean = |inside: &dyn Fn(f64) -> bool| {
        let all = clean.positions().iter().zip(&noise.relative).filter(|(p, _)| inside(p.z)).map(|(_, s)| *s);
        let (sum, count) = all.fold((0.0, 0.0), |(sum, count), s| (sum + s, count + 1.0));
        sum / count
    };
    let (loud, quiet) = (mean(&|z| z > 0.3), mean(&|z| z < -0.3));
    assert!((loud / 0.3 - 1.0).abs() < 0.15 && (quiet / 0.06 - 1.0).abs() < 0.3, "{loud} {quiet}");
}

#[test]
fn samples_of_shared_noise_are_alike_between_neighbours() {
    let sphere = shapes::sphere(4);
    let connectivity = Connectivity::of(&sphere);
    let alike = |correlation: usize| {
        let noise = NoiseField { correlation, ..NoiseField::uniform(sphere.positions().len(), 0.2, 1.0, 0.0) };
        let sample = noise.sample(&connectivity, 5);
        let rms = (sample.iter().map(|x| x * x).sum::<f64>() / sample.len() as f64).sqrt();
        assert!((rms / 0.2 - 1.0).abs() < 0.1, "{rms}");
        let products = sphere.topology().edges().iter().map(|e| sample[e[0] as usize] * sample[e[1] as usize]);
        products.sum::<f64>() / (sphere.topology().edges().len() as f64 * rms * rms)
    };
    assert!(alike(0).abs() < 0.05 && alike(1) > 0.2 && alike(8) > alike(1) + 0.2);
}

#[test]
fn no_offset_is_longer_than_five_deviations() {
    let noise = NoiseField { relative: vec![0.0, 0.1, 0.1], ..NoiseField::uniform(3, 0.1, 2.0, 0.0) };
    let mut offsets = vec![DVec3::X, DVec3::new(0.0, 0.9, 0.0), DVec3::new(0.0, 0.0, 30.0)];
    assert_eq!(noise.bound(&mut offsets), 2);
    assert!(offsets[0] == DVec3::ZERO && offsets[1].y == 0.9 && (offsets[2].z - 1.0).abs() < 1e-12);
}

#[test]
fn every_vertex_has_a_region_of_the_least_size_or_more() {
    for surface in [shapes::sphere(4), shapes::bumpy_sheet(30)] {
        // Few rings make many regions that are too small at first.
        for (rings, start) in [(RINGS, 0), (2, 0), (2, 300), (1, 100)] {
            let regions = Regions::of(surface.topology(), start, rings, LEAST_REGION);
            assert_eq!(regions.vertices.items().len(), surface.positions().len());
            for (region, members) in regions.vertices.iter().enumerate() {
                assert!(members.len() >= LEAST_REGION, "{} vertices with {rings} rings", members.len());
                assert!(members.iter().all(|&v| regions.of_vertex[v as usize] as usize == region));
            }
        }
    }
}

#[test]
fn rounding_bounds_offsets_and_counts() {
    let noise =
        NoiseField { half_step: DVec3::new(0.01, f64::INFINITY, 0.01), ..NoiseField::uniform(2, 0.1, 1.0, 0.0) };
    let mut offsets = vec![DVec3::new(0.02, 0.2, 0.0), DVec3::new(0.0, 0.2, 0.0)];
    assert_eq!(noise.bound(&mut offsets), 1);
    assert_eq!(offsets, [DVec3::new(0.01, 0.2, 0.0), DVec3::new(0.0, 0.2, 0.0)]);
}

#[test]
fn rounding_to_one_grid_is_noise_and_a_grid_of_samples_is_none() {
    let ball = shapes::sphere(5);
    let edge = ball.mean_edge();
    let rounded = |steps: [f64; 3]| {
        let round = |p: &DVec3| DVec3::from_array([0, 1, 2].map(|k| (p[k] / steps[k]).round() * steps[k]));
        ball.at(ball.positions().iter().map(round).collect())
    };
    let is_rounding = |surface: &Surface| {
        let connectivity = Connectivity::of(surface);
        let level = NoiseEstimate::of(surface, &connectivity, &Silent).unwrap();
        NoiseField::is_rounding(surface, &connectivity, level.level.fine * level.mean_edge)
    };
    assert!(is_rounding(&rounded([0.3 * edge; 3])));
    assert!(!is_rounding(&rounded([0.3 * edge, 0.3 * edge, 0.6 * edge])) && !is_rounding(&ball));
    assert!(!is_rounding(&shapes::grid(40)));
}

#[test]
fn little_white_noise_beside_much_that_neighbours_share_is_shared() {
    let ball = shapes::sphere(5);
    let connectivity = Connectivity::of(&ball);
    let edge = ball.mean_edge();
    let shared = NoiseField { correlation: 8, ..NoiseField::uniform(ball.positions().len(), 0.3, edge, 0.0) };
    let (shared, white) = (shared.sample(&connectivity, 5), gaussians(ball.positions().len(), 6));
    let lifted =
        (0..).zip(ball.positions()).map(|(v, p): (usize, _)| *p * (1.0 + shared[v] + 0.05 * edge * white[v].x));
    let found = measured(&ball.at(lifted.collect()), Verdict::White);
    assert!(found.correlation > 0 && found.typical() > 0.1, "{} {}", found.correlation, found.typical());
}

#[test]
fn terraces_are_as_uncertain_as_rounding_makes_them() {
    let grid = shapes::grid(48);
    let edge = 1.0 / 48.0;
    let hill = |p: &DVec3| {
        let z = 0.04 * (3.0 * p.x).sin() * (2.0 * p.y).cos();
        DVec3::new(p.x, p.y, (z / edge).round() * edge)
    };
    let terraces = grid.at(grid.positions().iter().map(hill).collect());
    let found = NoiseField::terraces(&terraces, &Connectivity::of(&terraces), 0.0).unwrap();
    // The coordinates across are where it was sampled.
    let sampled = found.half_step.x.is_infinite() && found.half_step.y.is_infinite();
    assert!(sampled && found.half_step.z < 0.51 * edge && found.correlation > 0, "{}", found.half_step);
    assert!(NoiseField::terraces(&grid, &Connectivity::of(&grid), 0.0).is_none());
    assert!((found.typical() / 0.29 - 1.0).abs() < 0.3, "{}", found.typical());
}

#[test]
fn a_vertex_without_faces_has_finite_noise_on_terraces() {
    let grid = shapes::grid(24);
    let mut positions: Vec<DVec3> =
        grid.positions().iter().map(|p| DVec3::new(p.x, p.y, (0.1 * p.x * 24.0).round() / 24.0)).collect();
    positions.push(DVec3::ZERO);
    let topology = Topology::new(positions.len(), grid.topology().faces().clone());
    let terraces = Surface::new(topology, positions);
    let found = NoiseField::terraces(&terraces, &Connectivity::of(&terraces), 0.0).unwrap();
    assert!(found.sigma().all(|sigma| sigma.is_finite() && sigma > 0.0));
}

#[test]
fn a_field_that_is_the_same_everywhere_has_the_edge_of_the_mesh_at_every_triangle() {
    let noise = NoiseField::uniform(3, 0.1, 0.7, 0.0);
    assert!((noise.edge_of(&[0, 1, 2]) - 0.7).abs() < 1e-15 && (noise.mean_edge() - 0.7).abs() < 1e-15);
    let uneven = NoiseField { edge: vec![1.0, 2.0, 6.0], ..noise };
    assert!((uneven.edge_of(&[0, 1, 2]) - 3.0).abs() < 1e-15);
}

#[test]
fn terraces_are_alike_between_neighbours_where_these_are_on_one_step() {
    let grid = shapes::grid(40);
    let found = |share: f64| {
        // Neighbours are apart by this share of a step, in both directions.
        let step = 0.01;
        let round = |z: f64| (z / step).round() * step;
        let slope = |p: &DVec3| DVec3::new(p.x, p.y, round(40.0 * share * step * (p.x + 0.618 * p.y)));
        let terraces = grid.at(grid.positions().iter().map(slope).collect());
        NoiseField::terraces(&terraces, &Connectivity::of(&terraces), 0.0).unwrap().correlation
    };
    // The correlation 1 − 6 t (1 − t) falls from 0.7 at a twentieth of a step to −½ at a half.
    let [wide, narrow, single] = [0.03, 0.12, 0.5].map(found);
    assert!(wide > narrow && narrow > 0 && single == 0, "{wide} {narrow} {single}");
}

#[test]
fn samples_of_a_surface_that_was_lifted_everywhere_alike_are_wholly_correlated() {
    for scale in [0.01, 1.0, 100.0] {
        let clean = shapes::sphere(4);
        let clean = clean.at(clean.positions().iter().map(|p| scale * *p).collect());
        let height = 0.3 * clean.mean_edge();
        let normals = Connectivity::of(&clean).vertex_normals(clean.positions());
        let lifted = clean.at(clean.positions().iter().zip(normals).map(|(p, n)| *p + height * n).collect());
        let found = samples(&clean, &lifted, &Silent).unwrap();
        assert!(!found.is_empty());
        for sample in found {
            assert!((sample.correlation - 1.0).abs() < 1e-9, "{}", sample.correlation);
            // Edges of a sphere from an icosahedron differ by a tenth.
            assert!((sample.sigma / 0.3 - 1.0).abs() < 0.15, "{}", sample.sigma);
        }
        let still = samples(&clean, &clean, &Silent).unwrap();
        assert!(still.iter().all(|sample| sample.sigma == 0.0 && sample.correlation == 0.0));
    }
}
