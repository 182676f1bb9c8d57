//! Laws of the noise that is assumed.

use super::*;
use crate::denoise::noise_level::NoiseEstimate;
use crate::denoise::noise_level::tests::with_correlated_noise;
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Direction, Noise};
use crate::mesh::topology::Topology;
use crate::progress::Silent;

fn assumed(surface: &Surface) -> (Kind, NoiseField) {
    let connectivity = Connectivity::of(surface);
    let level = NoiseEstimate::of(surface, &connectivity, &Silent).unwrap();
    assumed_noise(surface, &connectivity, &Auto::default(), &level, &Silent).unwrap()
}

fn white(clean: &Surface, sigma: f64, share: f64) -> Surface {
    synthetic_noise::noisy(clean, &Noise { sigma, direction: Direction::Normal, share, seed: 3 })
}

/// Coordinates rounded to whole multiples of the steps, where these are above zero.
fn rounded(surface: &Surface, steps: DVec3) -> Surface {
    let round = |x: f64, step: f64| if step > 0.0 { (x / step).round() * step } else { x };
    let all = |p: &DVec3| DVec3::from_array([0, 1, 2].map(|k| round(p[k], steps[k])));
    surface.at(surface.positions().iter().map(all).collect())
}

fn scaled(surface: &Surface, scale: f64) -> Surface {
    surface.at(surface.positions().iter().map(|p| scale * *p).collect())
}

#[test]
fn a_depth_image_is_a_regular_sheet_that_faces_one_side() {
    let sheet = shapes::bumpy_sheet(20);
    assert!(is_range_image(&sheet) && is_range_image(&white(&sheet, 0.2, 1.0)) && is_range_image(&shapes::grid(5)));
    // Closed surfaces face all sides, though a sphere from an icosahedron is as regular.
    assert!(!is_range_image(&shapes::sphere(4)) && !is_range_image(&shapes::gridded_box(8)));
    // A sheet that is wound up faces all sides, too.
    let wound = |p: &DVec3| DVec3::new((6.0 * p.x).cos(), (6.0 * p.x).sin(), 6.0 * p.y);
    assert!(!is_range_image(&sheet.at(sheet.positions().iter().map(wound).collect())));
    // In one half of a sheet, diagonals that run to and fro leave vertices of four and of eight neighbours.
    let flipped = |(f, pair): (usize, &[[Index; 3]])| -> [Vec<Index>; 2] {
        let ([a, b], shared) = ([pair[0], pair[1]], |v: &Index| pair[0].contains(v) && pair[1].contains(v));
        let own = |t: [Index; 3]| t.into_iter().find(|v| !shared(v)).unwrap();
        if (f + f / 20) % 2 == 0 || f / 20 < 10 {
            return [a.to_vec(), b.to_vec()];
        }
        let k = a.iter().position(|v| *v == own(a)).unwrap();
        [vec![a[k], a[(k + 1) % 3], own(b)], vec![own(b), a[(k + 2) % 3], a[k]]]
    };
    let triangles: Vec<[Index; 3]> = sheet.triangles().collect();
    let faces = triangles.chunks_exact(2).enumerate().flat_map(flipped).collect();
    let other = Surface::new(Topology::new(sheet.positions().len(), faces), sheet.positions().to_vec());
    assert!((other.area() / sheet.area() - 1.0).abs() < 0.01 && !is_range_image(&other));
    // Nothing is no image.
    assert!(!is_range_image(&Surface::new(
        Topology::new(3, Vec::<Vec<Index>>::new().into_iter().collect()),
        vec![DVec3::ZERO; 3]
    )));
}

#[test]
fn what_is_assumed_is_the_same_in_every_unit() {
    let (sheet, ball) = (shapes::bumpy_sheet(40), shapes::sphere(4));
    let step = 1.0 / 40.0;
    let surfaces = [
        ("white depth image", white(&sheet, 0.2, 1.0)),
        ("uneven depth image", white(&sheet, 0.4, 0.2)),
        ("depth image with shared noise", with_correlated_noise(&sheet, 0.5, 3)),
        ("terraces", rounded(&sheet, DVec3::new(0.0, 0.0, step))),
        ("white ball", white(&ball, 0.2, 1.0)),
        ("ball with shared noise", with_correlated_noise(&ball, 0.5, 3)),
        ("rounded ball", rounded(&ball, DVec3::splat(0.3 * ball.mean_edge()))),
        ("small ball", white(&shapes::sphere(2), 0.2, 1.0)),
        ("tiny ball", white(&shapes::sphere(1), 0.2, 1.0)),
    ];
    for (name, surface) in surfaces {
        // In a unit of about a mean edge, and in far smaller and larger ones; powers of two round nothing.
        let [expected, others @ ..] = [32.0, 1.0 / 256.0, 1024.0].map(|scale| assumed(&scaled(&surface, scale)));
        for (kind, noise) in others {
            assert_eq!((kind, noise.correlation), (expected.0, expected.1.correlation), "{name}");
            let gap = noise.relative.iter().zip(&expected.1.relative).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(gap < 1e-6, "{name}: {gap}");
        }
    }
}

#[test]
fn the_noise_of_a_depth_image_is_at_least_what_the_tail_of_the_whole_says() {
    let image = scaled(&white(&shapes::bumpy_sheet(40), 0.4, 0.2), 0.01);
    let connectivity = Connectivity::of(&image);
    let level = NoiseEstimate::of(&image, &connectivity, &Silent).unwrap();
    assert_eq!(level.level.kind(), Kind::Uneven);
    let (_, noise) = assumed_noise(&image, &connectivity, &Auto::default(), &level, &Silent).unwrap();
    let [found, tail] = [noise.typical() * noise.mean_edge(), level.level.sigma_as(Kind::Uneven) * level.mean_edge];
    assert!(found > 0.999 * tail && found < 1.5 * tail, "{found} {tail}");
}

#[test]
fn noise_is_measured_region_by_region_but_for_a_depth_image_with_shared_noise() {
    let (sheet, ball) = (shapes::bumpy_sheet(40), shapes::sphere(4));
    for (surface, kind, is_measured) in [
        (white(&sheet, 0.2, 1.0), Kind::Independent, true),
        (white(&ball, 0.2, 1.0), Kind::Independent, true),
        (with_correlated_noise(&ball, 0.5, 3), Kind::Correlated, true),
        (with_correlated_noise(&sheet, 0.5, 3), Kind::Correlated, false),
    ] {
        let (found, noise) = assumed(&surface);
        assert_eq!((found, noise.is_measured), (kind, is_measured), "{} vertices", surface.positions().len());
        assert!(noise.typical() > 0.05);
        assert_eq!(noise.correlation > 0, kind == Kind::Correlated && is_measured);
    }
    assert_eq!(assumed(&ball).0, Kind::None);
}
