//! Laws of the kinds of noise.

use super::*;
use crate::mesh::jagged::Index;
use crate::mesh::laplacian;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::shapes;

/// Kinds that move vertices, with their usual settings.
fn every() -> impl Iterator<Item = SyntheticNoise> {
    SyntheticKind::ALL.into_iter().filter(|kind| kind.keeps_connectivity()).map(|kind| SyntheticNoise::of_kind(kind, 1))
}

fn of(kind: SyntheticKind) -> SyntheticNoise {
    SyntheticNoise::of_kind(kind, 1)
}

fn rms(displacements: &[DVec3]) -> f64 {
    (displacements.iter().map(|d| d.length_squared()).sum::<f64>() / displacements.len() as f64).sqrt()
}

/// Mean correlation of a quantity with mean 0 at the two ends of an edge.
fn lag_one(surface: &Surface, values: &[f64]) -> f64 {
    let edges = surface.topology().edges();
    let products = edges.iter().map(|&[a, b]| values[a as usize] * values[b as usize]).sum::<f64>();
    let squares = values.iter().map(|x| x * x).sum::<f64>();
    (products / edges.len() as f64) / (squares / values.len() as f64)
}

#[test]
fn seeds_differ_and_repeat_for_every_kind() {
    let sphere = shapes::dented_sphere(3);
    for noise in every() {
        let first = moved(&sphere, &noise);
        let bits = |all: &[DVec3]| all.iter().map(|d| d.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(&first), bits(&moved(&sphere, &noise)), "{:?}", noise.kind);
        let other = moved(&sphere, &SyntheticNoise { seed: 2, ..noise });
        assert_ne!(first, other, "{:?}", noise.kind);
    }
}

#[test]
fn settings_that_a_kind_does_not_have_change_nothing_and_the_others_do() {
    let surface = shapes::bumpy_sheet(20);
    for noise in every() {
        let first = moved(&surface, &noise);
        for setting in NoiseSetting::ALL {
            let changed = match setting {
                NoiseSetting::Sigma => SyntheticNoise { sigma: 0.27, ..noise },
                NoiseSetting::Direction => SyntheticNoise { direction: Direction::Random, ..noise },
                NoiseSetting::Share => SyntheticNoise { share: 0.31, ..noise },
                NoiseSetting::Length => SyntheticNoise { length: 3.1, ..noise },
                NoiseSetting::Correlation => SyntheticNoise { correlation: 2.0, ..noise },
                NoiseSetting::Towards => SyntheticNoise { towards: Some(DVec3::new(0.3, 1.0, 0.2)), ..noise },
                NoiseSetting::Distance => SyntheticNoise { distance: 4.0, ..noise },
                NoiseSetting::Step => SyntheticNoise { step: 2.0, ..noise },
            };
            let is_other = moved(&surface, &changed) != first;
            assert_eq!(is_other, noise.kind.settings().contains(&setting), "{:?} {setting:?}", noise.kind);
        }
    }
}

#[test]
fn the_deviation_is_the_one_that_was_asked_for() {
    let sphere = shapes::sphere(5);
    let edge = sphere.mean_edge();
    for kind in [SyntheticKind::White, SyntheticKind::Correlated, SyntheticKind::Camera] {
        for sigma in [0.1, 0.4] {
            let found = rms(&moved(&sphere, &SyntheticNoise { sigma, ..of(kind) })) / edge;
            // 10242 samples, of which a patch of some tens moves together with correlated noise.
            assert!((found / sigma - 1.0).abs() < 0.05, "{kind:?}: {found} for {sigma}");
        }
    }
    // Rounding errs along three axes.
    let found = rms(&moved(&sphere, &SyntheticNoise { sigma: 0.1, ..of(SyntheticKind::Rounded) }));
    assert!((found / (3f64.sqrt() * 0.1 * edge) - 1.0).abs() < 0.03, "{found}");
}

#[test]
fn correlated_noise_is_correlated_as_its_formula_says() {
    let sphere = shapes::sphere(5);
    let normals = normals::vertex_normals(&sphere, FaceWeight::Angle);
    let heights = |noise: &SyntheticNoise| -> Vec<f64> {
        moved(&sphere, noise).iter().zip(&normals).map(|(d, n)| d.dot(*n)).collect()
    };
    for correlation in [2.0, 3.0, 5.0] {
        let noise = SyntheticNoise { correlation, ..of(SyntheticKind::Correlated) };
        let smooth_part = 1.0 - correlated::WHITE_PART * correlated::WHITE_PART;
        let expected = smooth_part * (-1.0 / (correlation * correlation)).exp();
        let found = lag_one(&sphere, &heights(&noise));
        // The formula takes the mesh for a plane of small steps; 10242 samples know the correlation to 1 %.
        assert!((found - expected).abs() < 0.03, "{correlation}: {found}, not {expected}");
    }
    // Edges: 30720, so that the correlation of white noise is known to 0.006.
    assert!(lag_one(&sphere, &heights(&of(SyntheticKind::White))).abs() < 0.03);
}

#[test]
fn diffusion_keeps_constants_and_the_scale_of_the_correlation() {
    let grid = shapes::grid(40);
    let flat = correlated::diffused(grid.topology(), vec![1.0; grid.positions().len()], 9);
    assert!(flat.iter().all(|x| (x - 1.0).abs() < 1e-14));
    // An impulse spreads by a quarter of a squared edge a step along each direction of the sphere's lattice of triangles.
    let sphere = shapes::sphere(5);
    let middle = 100;
    let mut impulse = vec![0.0; sphere.positions().len()];
    impulse[middle] = 1.0;
    let spread = correlated::diffused(sphere.topology(), impulse, 9);
    let centre = sphere.positions()[middle];
    let variance: f64 = spread.iter().zip(sphere.positions()).map(|(w, p)| w * p.distance_squared(centre)).sum();
    let edge = uneven::mean_edge_at(&sphere, middle as Index);
    let steps = variance / (2.0 * edge * edge / 4.0);
    assert!((steps / 9.0 - 1.0).abs() < 0.1, "{steps}");
}

#[test]
fn rounded_coordinates_lie_on_a_grid_and_move_by_half_a_step_at_most() {
    let sphere = shapes::dented_sphere(3);
    let far = sphere.at(sphere.positions().iter().map(|p| *p + 1e5).collect());
    for surface in [sphere, far] {
        let noise = of(SyntheticKind::Rounded);
        let step = 12f64.sqrt() * noise.sigma * surface.mean_edge();
        let lifted = moved(&surface, &noise);
        let rounded: Vec<DVec3> = surface.positions().iter().zip(&lifted).map(|(p, d)| *p + *d).collect();
        for (p, d) in rounded.iter().zip(&lifted) {
            assert!(d.abs().max_element() <= step / 2.0 * (1.0 + 1e-9));
            let cells = (*p - rounded[0]) / step;
            // Coordinates near 1e5 are good to 1e-11, and a step is about 0.05.
            assert!((cells - cells.round()).abs().max_element() < 1e-8, "{cells}");
        }
    }
}

#[test]
fn the_camera_moves_vertices_along_its_rays_and_more_where_it_is_far() {
    let sphere = shapes::sphere(5);
    let noise = SyntheticNoise { towards: Some(DVec3::Z * 3.0), correlation: 0.0, ..of(SyntheticKind::Camera) };
    let eye = camera::eye(&sphere, &noise).unwrap();
    // The box around a sphere of radius 1 has a half diagonal of √3.
    assert!(eye.distance(DVec3::Z * 2.5 * 3f64.sqrt()) < 1e-12, "{eye}");
    let lifted = moved(&sphere, &noise);
    for (p, d) in sphere.positions().iter().zip(&lifted) {
        assert!(d.cross((eye - *p).normalize()).length() < 1e-12 * d.length().max(1e-12));
    }
    let part = |keep: &dyn Fn(f64) -> bool| {
        let chosen = sphere.positions().iter().zip(&lifted).filter(|(p, _)| keep(p.z));
        rms(&chosen.map(|(_, d)| *d).collect::<Vec<_>>())
    };
    // Caps at depths of about 4.33 ∓ 0.9: the deviation grows with the square of the depth.
    let (near, far) = (part(&|z| z > 0.8), part(&|z| z < -0.8));
    assert!((far / near / (5.23f64 / 3.43).powi(2) - 1.0).abs() < 0.1, "{near} {far}");
}

#[test]
fn fading_noise_is_nothing_at_one_end_and_twice_sigma_at_the_other() {
    let grid = shapes::grid(100);
    let noise = SyntheticNoise { towards: Some(DVec3::X), ..of(SyntheticKind::Fade) };
    let lifted = moved(&grid, &noise);
    let at_end = |x: f64| {
        let chosen = grid.positions().iter().zip(&lifted).filter(|(p, _)| (p.x - x).abs() < 0.05);
        rms(&chosen.map(|(_, d)| *d).collect::<Vec<_>>()) / grid.mean_edge()
    };
    for (p, d) in grid.positions().iter().zip(&lifted) {
        assert!(p.x != 0.0 || *d == DVec3::ZERO);
    }
    // 500 samples or more, so the deviation is known to 3 %; the last strip has 0.95 < t ≤ 1.
    assert!((at_end(0.5) / 0.2 - 1.0).abs() < 0.1, "{}", at_end(0.5));
    assert!((at_end(1.0) / (2.0 * 0.975 * 0.2) - 1.0).abs() < 0.12, "{}", at_end(1.0));
}

#[test]
fn partial_noise_owns_its_share_and_leaves_the_rest_bit_for_bit() {
    let sphere = shapes::sphere(5);
    // Zeros with a sign show whether something was added.
    let signed = sphere.at(sphere.positions().iter().map(|p| DVec3::new(p.x, p.y, -0.0)).collect());
    for share in [0.2, 0.5, 0.9] {
        let noise = SyntheticNoise { share, ..of(SyntheticKind::Partial) };
        let lifted = moved(&sphere, &noise);
        let areas = laplacian::mass(&sphere);
        let noisy: f64 = areas.iter().zip(&lifted).filter(|(_, d)| **d != DVec3::ZERO).map(|(a, _)| a).sum();
        assert!((noisy / sphere.area() - share).abs() < 1e-3, "{noisy}");
        for (p, d) in signed.positions().iter().zip(&lifted).filter(|(_, d)| **d == DVec3::ZERO) {
            assert_eq!((*p + *d).to_array().map(f64::to_bits), p.to_array().map(f64::to_bits));
        }
        let white = moved(&sphere, &SyntheticNoise { sigma: noise.sigma, ..of(SyntheticKind::White) });
        assert!(lifted.iter().zip(&white).all(|(d, w)| d == w || *d == DVec3::ZERO), "the noisy part is white");
    }
}

#[test]
fn the_noisy_part_is_in_one_piece() {
    let sphere = shapes::sphere(5);
    let lifted = moved(&sphere, &of(SyntheticKind::Partial));
    let crossing = |&&[a, b]: &&[Index; 2]| (lifted[a as usize] == DVec3::ZERO) != (lifted[b as usize] == DVec3::ZERO);
    // A great circle of 2π crosses about two edges for each edge length; scattered vertices would cross half of all 30720.
    let count = sphere.topology().edges().iter().filter(crossing).count() as f64;
    assert!(count < 2.0 * 2.5 * std::f64::consts::TAU / sphere.mean_edge(), "{count}");
}

#[test]
fn local_noise_scales_with_the_edges_around_a_vertex() {
    // A sheet whose rows and columns get wider.
    let grid = shapes::grid(60);
    let surface = grid.at(grid.positions().iter().map(|p| DVec3::new(p.x * p.x, p.y * p.y, 0.0)).collect());
    let local = moved(&surface, &of(SyntheticKind::Local));
    let white = moved(&surface, &of(SyntheticKind::White));
    for (v, (l, w)) in (0..).zip(local.iter().zip(&white)) {
        let expected = *w * (uneven::mean_edge_at(&surface, v) / surface.mean_edge());
        assert!(l.distance(expected) <= 1e-12 * w.length());
    }
    let corner = |keep: &dyn Fn(&DVec3) -> bool| {
        let chosen = surface.positions().iter().zip(&local).filter(|(p, _)| keep(p));
        rms(&chosen.map(|(_, d)| *d).collect::<Vec<_>>())
    };
    // Edges near the fine corner are about a fifth of those near the coarse one.
    assert!(corner(&|p| p.max_element() < 0.04) * 3.0 < corner(&|p| p.x.min(p.y) > 0.64));
}

#[test]
fn spikes_hit_their_count_by_their_length() {
    let sphere = shapes::sphere(5);
    let normals = normals::vertex_normals(&sphere, FaceWeight::Angle);
    for (share, count) in [(0.002, 20), (0.1, 1024), (1e-9, 1), (1.0, 10242), (0.0, 0)] {
        let lifted = moved(&sphere, &SyntheticNoise { share, ..of(SyntheticKind::Spikes) });
        assert_eq!(lifted.iter().filter(|d| **d != DVec3::ZERO).count(), count);
        for (d, n) in lifted.iter().zip(&normals).filter(|(d, _)| **d != DVec3::ZERO) {
            assert!((d.dot(*n).abs() / (4.0 * sphere.mean_edge()) - 1.0).abs() < 1e-12 && d.cross(*n).length() < 1e-12);
        }
        if count > 1000 {
            let outwards = lifted.iter().zip(&normals).filter(|(d, n)| d.dot(**n) > 0.0).count();
            // Binomial: five deviations.
            assert!((outwards as f64 - count as f64 / 2.0).abs() < 2.5 * (count as f64).sqrt());
        }
    }
}

#[test]
fn odd_meshes_get_finite_noise() {
    let soup = |points: Vec<DVec3>| {
        let faces = [vec![0, 1, 2]].into_iter().collect();
        Surface::new(crate::mesh::topology::Topology::new(points.len(), faces), points)
    };
    let isolated = soup(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(1e9)]);
    let point = soup(vec![DVec3::ONE; 3]);
    let needle = soup(vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0]);
    for surface in [&isolated, &point, &needle] {
        for noise in every() {
            let lifted = moved(surface, &noise);
            assert!(lifted.iter().all(|d| d.is_finite()), "{:?}: {lifted:?}", noise.kind);
        }
    }
}
