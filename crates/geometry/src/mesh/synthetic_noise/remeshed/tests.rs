//! Laws of the kinds of noise that come with a mesh of their own.

use super::depth_image::{Camera, DepthImage};
use super::surface_nets::{self, Grid};
use super::*;
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{Disturbed, disturb};
use crate::mesh::topology::EdgeKind;
use std::f64::consts::PI;

fn of(kind: SyntheticKind) -> SyntheticNoise {
    SyntheticNoise::of_kind(kind, 1)
}

fn made(surface: &Surface, noise: &SyntheticNoise) -> Remeshed {
    match disturb(surface, noise) {
        Ok(Disturbed::Remeshed(pair)) => *pair,
        other => panic!("{other:?}"),
    }
}

/// Standard deviation of the displacements between the two meshes of a pair, model units.
fn rms(pair: &Remeshed) -> f64 {
    let squares = pair.clean.positions().iter().zip(pair.noisy.positions()).map(|(p, q)| p.distance_squared(*q));
    (squares.sum::<f64>() / pair.clean.positions().len() as f64).sqrt()
}

fn is_closed(surface: &Surface) -> bool {
    let topology = surface.topology();
    (0..topology.edges().len() as Index).all(|e| topology.edge_kind(e) != EdgeKind::Boundary)
}

#[test]
fn both_meshes_of_a_pair_are_finite_and_seeds_differ_and_repeat() {
    let sphere = shapes::dented_sphere(3);
    for kind in SyntheticKind::ALL.into_iter().filter(|kind| !kind.keeps_connectivity()) {
        let pair = made(&sphere, &of(kind));
        let faces = |surface: &Surface| surface.triangles().collect::<Vec<_>>();
        assert_eq!(faces(&pair.clean), faces(&pair.noisy));
        assert!(pair.clean.positions().iter().chain(pair.noisy.positions()).all(|p| p.is_finite()));
        assert!((0..pair.clean.positions().len()).all(|v| !pair.clean.topology().is_isolated(v as Index)));
        assert_eq!(made(&sphere, &of(kind)).noisy.positions(), pair.noisy.positions(), "{kind:?}");
        let other = made(&sphere, &SyntheticNoise { seed: 2, ..of(kind) });
        assert_ne!(other.noisy.positions(), pair.noisy.positions(), "{kind:?}");
        let coarse = made(&sphere, &SyntheticNoise { step: 2.0, ..of(kind) });
        let ratio = pair.clean.positions().len() as f64 / coarse.clean.positions().len() as f64;
        // Four times as many pixels or squares; the row by which silhouettes are fattened does not grow with them.
        assert!((2.5..6.0).contains(&ratio), "{kind:?}: {ratio}");
    }
}

#[test]
fn a_lattice_point_is_in_exactly_one_of_the_triangles_of_a_square() {
    // All points of the lattice, many of which are on edges and corners.
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [2.0, 2.0]].map(glam::DVec2::from);
    let mut seen = std::collections::BTreeMap::new();
    for t in [[0, 1, 4], [2, 4, 1], [2, 3, 4], [4, 3, 0]] {
        lattice::scan(t.map(|v| corners[v as usize]), t, |pixel, weights| {
            let p: glam::DVec2 = t.iter().zip(weights).map(|(&v, weight)| corners[v as usize] * weight).sum();
            assert!(p.distance(glam::DVec2::new(pixel[0] as f64, pixel[1] as f64)) < 1e-12);
            *seen.entry(pixel).or_insert(0) += 1;
        });
    }
    let inner = |[i, j]: &[i64; 2]| (1..4).contains(i) && (1..4).contains(j);
    assert_eq!(seen.iter().filter(|(pixel, count)| inner(pixel) && **count == 1).count(), 9, "{seen:?}");
    assert!(seen.values().all(|count| *count == 1));
    assert_eq!(seen.len(), 16, "the square has 4 × 4 points, if two of its sides belong to the next one");
}

#[test]
fn a_range_image_without_noise_lies_on_the_surface_that_faces_the_eye() {
    let cube = shapes::gridded_box(20);
    let towards = DVec3::new(1.0, 1.0, 1.2);
    let noise = SyntheticNoise { sigma: 0.0, towards: Some(towards), step: 0.25, ..of(SyntheticKind::RangeImage) };
    let Remeshed { clean, noisy } = made(&cube, &noise);
    assert_eq!(clean.positions(), noisy.positions());
    // Three sides of the box can be seen: x = 1, y = 2 and z = 3.
    let gap = |p: &DVec3| (*p - DVec3::new(1.0, 2.0, 3.0)).abs().min_element();
    let count = clean.positions().iter().filter(|p| gap(p) < 1e-12).count();
    assert!(count as f64 > 0.9 * clean.positions().len() as f64, "{count} of {}", clean.positions().len());
    // The others fatten the silhouette by a pixel.
    let farthest = clean.positions().iter().map(gap).fold(0.0, f64::max);
    assert!(farthest < 2.0 * noise.step * cube.mean_edge(), "{farthest}");
    let normals = normals_of(&clean);
    let upright = normals.iter().filter(|n| n.max_element() > 1.0 - 1e-9).count();
    // All but the triangles over the three edges and at the silhouette have the normal of a side.
    assert!(upright as f64 > 0.85 * normals.len() as f64, "{upright} of {}", normals.len());
    // Visible area: two by three, one by three and one by two.
    assert!((0.97..1.1).contains(&(clean.area() / 11.0)), "{}", clean.area());
}

fn normals_of(surface: &Surface) -> Vec<DVec3> {
    crate::mesh::normals::face_normals(surface)
}

#[test]
fn depths_err_along_the_rays_by_the_deviation_and_in_steps_of_disparity() {
    let grid = shapes::grid(100);
    let towards = DVec3::new(0.1, 0.2, 1.0);
    for correlation in [0.0, 2.0] {
        let noise = SyntheticNoise { towards: Some(towards), correlation, ..of(SyntheticKind::RangeImage) };
        let pair = made(&grid, &noise);
        let eye = DVec3::new(0.5, 0.5, 0.0) + towards.normalize() * 2.5 * 0.5f64.sqrt();
        let (mut depths, unit) = (Vec::new(), towards.normalize());
        for (p, q) in pair.clean.positions().iter().zip(pair.noisy.positions()) {
            assert!((*q - eye).cross(*p - eye).length() < 1e-12);
            depths.push((eye - *q).dot(unit));
        }
        let sigma = noise.sigma * grid.mean_edge();
        // Gaussian noise of σ and rounding by up to half of σ, along rays that are at most 16° from the axis.
        let expected = sigma * (1.0f64 + 1.0 / 12.0).sqrt();
        assert!((rms(&pair) / expected - 1.0).abs() < 0.06, "{} for {expected}", rms(&pair));
        let mean = pair.clean.positions().iter().map(|p| (eye - *p).dot(unit)).sum::<f64>() / depths.len() as f64;
        let levels: Vec<f64> = depths.iter().map(|depth| mean * mean / (sigma * depth)).collect();
        let off = levels.iter().map(|x| x - levels[0]).map(|x| (x - x.round()).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{off}");
    }
}

/// A small square in front of a large one, both across z.
fn two_squares() -> Surface {
    let square = |half: f64, z: f64| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x * half, y * half, z))
    };
    let positions = [square(1.0, 1.0), square(3.0, -1.0)].concat();
    let faces = [vec![0, 1, 2], vec![0, 2, 3], vec![4, 5, 6], vec![4, 6, 7]].into_iter().collect();
    Surface::new(Topology::new(8, faces), positions)
}

#[test]
fn edges_are_fattened_by_a_pixel_and_no_triangle_bridges_a_jump() {
    let surface = two_squares();
    let camera = Camera::new(&surface, DVec3::Z, 3.0, 0.1).unwrap();
    let image = DepthImage::of(&surface, camera).unwrap();
    let front = image.depths.iter().copied().fold(f64::INFINITY, f64::min);
    let is_front = |depth: &f64| (depth - front).abs() < 1e-9;
    let columns = |image: &DepthImage| (-100..=100).filter(|i| is_front(&image.depth([*i, 0]))).count();
    let fat = image.fattened(range_image::JUMP);
    // The front square is 2 wide at its depth.
    assert!((columns(&image) as f64 - 2.0 / image.width(front)).abs() <= 1.0, "{}", columns(&image));
    assert_eq!(columns(&fat), columns(&image) + 2);
    for image in [&image, &fat] {
        let triangles = image.triangles(range_image::JUMP);
        assert!(!triangles.is_empty());
        for t in triangles {
            let fronts = t.iter().filter(|k| is_front(&image.depths[**k as usize])).count();
            assert!(fronts == 0 || fronts == 3);
        }
    }
}

#[test]
fn surface_nets_mesh_a_sphere_closed_outwards_and_near_to_it() {
    let step = 0.1;
    let grid = Grid::around([DVec3::splat(-1.0), DVec3::ONE], step, 1.0, DVec3::new(0.3, 0.6, 0.1)).unwrap();
    let values: Vec<f32> =
        (0..grid.len()).map(|index| (grid.position(grid.node(index)).length() - 1.0) as f32).collect();
    let (positions, faces) = surface_nets::surface(&grid, &values);
    let Remeshed { clean, .. } = pair(&positions, &positions, &faces).unwrap();
    assert!(is_closed(&clean));
    // Means of zeros lie inside of the sphere by the sagitta of a cell, at most (step √3)²/8.
    let off = clean.positions().iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 3.0 * step * step / 8.0, "{off}");
    assert!((clean.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 0.02, "{}", clean.volume());
    // Where values are missing there is a hole.
    let holed: Vec<f32> =
        values.iter().enumerate().map(|(k, x)| if k == grid.len() / 2 { f32::NAN } else { *x }).collect();
    assert_eq!(surface_nets::surface(&grid, &holed).1.len(), faces.len(), "the middle is far from the surface");
    let half: Vec<f32> =
        (0..grid.len()).map(|k| if grid.node(k)[2] < grid.size[2] / 2 { f32::NAN } else { values[k] }).collect();
    let (positions, faces) = surface_nets::surface(&grid, &half);
    assert!(!is_closed(&pair(&positions, &positions, &faces).unwrap().clean));
}

#[test]
fn voxels_are_a_closed_surface_within_a_step_of_the_true_one() {
    let sphere = shapes::sphere(4);
    let pair = made(&sphere, &of(SyntheticKind::Voxels));
    let step = sphere.mean_edge();
    assert!(is_closed(&pair.noisy));
    assert!((pair.noisy.volume() / sphere.volume() - 1.0).abs() < 0.02, "{}", pair.noisy.volume());
    let off = pair.clean.positions().iter().zip(pair.noisy.positions()).map(|(p, q)| p.distance(*q) / step);
    // A zero is within half a step of the surface along its edge, and a vertex is the mean of zeros in its cell.
    assert!(off.fold(0.0, f64::max) < 1.0);
    // The error is that of steps: neither nothing nor a whole step.
    assert!((0.1..0.5).contains(&(rms(&pair) / step)), "{}", rms(&pair) / step);
    assert!(pair.clean.positions().iter().all(|p| (p.length() - 1.0).abs() < 1e-2), "clean vertices are on the sphere");
    let open = shapes::grid(5);
    assert_eq!(disturb(&open, &of(SyntheticKind::Voxels)).unwrap_err(), RemeshError::Open);
}

#[test]
fn a_fusion_covers_the_surface_and_averages_the_noise() {
    let sphere = shapes::sphere(4);
    let step = sphere.mean_edge();
    let of_sigma = |sigma: f64| made(&sphere, &SyntheticNoise { sigma, correlation: 0.0, ..of(SyntheticKind::Fusion) });
    let (exact, noisy) = (of_sigma(0.0), of_sigma(0.6));
    // Noise makes the surface rough, and so larger.
    for (pair, rough) in [(&exact, 0.05), (&noisy, 0.2)] {
        assert!((pair.noisy.area() / sphere.area() - 1.0).abs() < rough, "{}", pair.noisy.area());
        assert!(pair.clean.positions().iter().all(|p| (p.length() - 1.0).abs() < 1e-2));
        let normals = normals_of(&pair.clean);
        let outwards = normals
            .iter()
            .zip(pair.clean.triangles())
            .filter(|(n, t)| n.dot(pair.clean.positions()[t[0] as usize]) > 0.0);
        assert!(outwards.count() as f64 > 0.9 * pair.clean.topology().faces().len() as f64);
    }
    let [exact, noisy] = [&exact, &noisy].map(|pair| rms(pair) / step);
    assert!(exact < 0.2, "{exact}");
    // Less than the noise of one image, and more than nothing.
    assert!(noisy > exact + 0.1 && noisy < 0.6, "{noisy} {exact}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let point = Surface::new(Topology::new(3, [vec![0, 1, 2]].into_iter().collect()), vec![DVec3::ONE; 3]);
    let sphere = shapes::sphere(2);
    for kind in [SyntheticKind::RangeImage, SyntheticKind::Fusion, SyntheticKind::Voxels] {
        assert!(disturb(&point, &of(kind)).is_err(), "{kind:?}");
        let fine = disturb(&sphere, &SyntheticNoise { step: 1e-5, ..of(kind) }).unwrap_err();
        assert!(matches!(fine, RemeshError::TooLarge { .. }), "{kind:?}: {fine}");
        assert!(fine.to_string().contains("e1"), "{fine}");
        let finest = disturb(&sphere, &SyntheticNoise { step: 1e-300, ..of(kind) }).unwrap_err();
        assert!(matches!(finest, RemeshError::TooLarge { .. } | RemeshError::Nothing), "{kind:?}: {finest}");
    }
    let huge = SyntheticNoise { step: 1e3, ..of(SyntheticKind::Voxels) };
    assert_eq!(disturb(&sphere, &huge).unwrap_err(), RemeshError::Nothing);
}
