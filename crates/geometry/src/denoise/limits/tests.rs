//! Tests of what limits refuse, and of what they do to displacements.

use super::*;
use crate::denoise::{Denoiser, Denoising, DenoisingError, Laplacian, Moved};
use crate::mesh::shapes;
use crate::mesh::weld::Welding;
use crate::progress::Silent;

fn on(limits: &Limits, surface: &Surface) -> Result<Bounds, LimitsError> {
    limits.on(surface, &Weld::new(surface.positions(), Welding::None))
}

#[test]
fn limits_that_do_not_fit_are_refused() {
    let grid = shapes::grid(2);
    let fixed = |text: &str| Limits { fixed: text.parse().unwrap(), ..Limits::default() };
    assert!(on(&fixed("9"), &grid).is_ok());
    let error = on(&fixed("9-10"), &grid).unwrap_err();
    assert_eq!(error, LimitsError::NoSuchLine { line: 10, v_lines: 9 });
    for d in [-1.0, f64::NAN, f64::INFINITY] {
        let limits = Limits { max_displacement: Some(d), ..Limits::default() };
        assert!(matches!(on(&limits, &grid), Err(LimitsError::NotALength(_))));
    }
}

#[test]
fn no_displacement_is_a_limit_too() {
    let (_, deltas, outcome) = limited(Limits { max_displacement: Some(0.0), ..Limits::default() });
    assert!(deltas.iter().all(|delta| *delta == DVec3::ZERO));
    assert_eq!((outcome.fixed_vertices, outcome.stopped_vertices), (0, deltas.len()));
}

#[test]
fn an_open_surface_has_a_volume_as_long_as_its_boundary_stays() {
    let grid = shapes::grid(2);
    let keep = |fixed: &str| Limits { fixed: fixed.parse().unwrap(), volume: Volume::Preserve, ..Limits::default() };
    assert!(on(&keep("boundary"), &grid).is_ok());
    // All around, but for the third vertex of the lower row, which has two boundary edges.
    let error = on(&keep("1-2 4 6-9"), &grid).unwrap_err();
    assert_eq!(error, LimitsError::Open { edges: 2, first: [2, 3] });
    // A face that is turned over makes a wall of its edges.
    let cube = shapes::cube();
    let mut faces: Vec<Vec<Index>> = cube.topology().faces().iter().map(Vec::from).collect();
    assert!(on(&keep(""), &cube).is_ok());
    faces[0].reverse();
    let turned = Surface::new(Topology::new(8, faces.into_iter().collect()), cube.positions().to_vec());
    assert!(matches!(on(&keep(""), &turned), Err(LimitsError::Open { edges: 4, .. })));
}

#[test]
fn a_sphere_that_was_smoothed_keeps_its_volume_and_becomes_no_rougher() {
    let sphere = shapes::dented_sphere(3);
    let denoiser = Denoiser::Laplacian(Laplacian { iterations: 30, ..Laplacian::default() });
    let weld = Weld::new(sphere.positions(), Welding::None);
    let after = |volume| {
        let denoising = Denoising { denoiser: denoiser.clone(), limits: Limits { volume, ..Limits::default() } };
        let Moved { deltas, limits: outcome, .. } = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
        (sphere.at(sphere.moved_by(&deltas)), outcome)
    };
    let [(shrunk, _), (restored, outcome)] = [Volume::Free, Volume::Preserve].map(after);
    let change = outcome.unwrap().volume.unwrap();
    assert!((change.by_method - (shrunk.volume() - sphere.volume())).abs() < 1e-12);
    assert!(change.by_method < -0.1 * sphere.volume());
    // Spread of the radii, against their mean.
    let roughness = |surface: &Surface| {
        let radii: Vec<f64> = surface.positions().iter().map(|p| p.length()).collect();
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        (radii.iter().map(|r| (r / mean - 1.0).powi(2)).sum::<f64>() / radii.len() as f64).sqrt()
    };
    assert!(roughness(&restored) < 1.1 * roughness(&shrunk));
}

#[test]
fn where_nothing_is_free_nothing_is_done() {
    let sphere = shapes::dented_sphere(1);
    let weld = Weld::new(sphere.positions(), Welding::None);
    let limits = Limits { fixed: "1-42".parse().unwrap(), volume: Volume::Preserve, ..Limits::default() };
    let denoising = Denoising { limits, ..Denoising::default() };
    let Moved { deltas, limits: outcome, .. } = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
    assert_eq!(deltas, [DVec3::ZERO; 42]);
    let change = VolumeChange { by_method: 0.0, left: 0.0, restored: true };
    assert_eq!(
        outcome,
        Some(Outcome { fixed_vertices: 42, stopped_vertices: 0, weighted_vertices: 0, volume: Some(change) })
    );
    let limits = Limits { fixed: "43".parse().unwrap(), ..Limits::default() };
    let denoising = Denoising { limits, ..Denoising::default() };
    let error = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap_err();
    assert!(matches!(error, DenoisingError::Limits(LimitsError::NoSuchLine { line: 43, v_lines: 42 })));
}

#[test]
fn numbers_that_are_none_end_the_search() {
    let sphere = shapes::dented_sphere(1);
    let bounds = on(&Limits { volume: Volume::Preserve, ..Limits::default() }, &sphere).unwrap();
    let mut deltas = vec![DVec3::splat(f64::INFINITY); 42];
    let along = vec![DVec3::X; 42];
    let outcome = bounds.apply(&sphere, &along, &mut deltas, &Silent).unwrap().unwrap();
    assert!(!outcome.volume.unwrap().restored);
}

/// A dented sphere, its displacements within limits, and what the limits did.
fn limited(limits: Limits) -> (Surface, Vec<DVec3>, Outcome) {
    let sphere = shapes::dented_sphere(3);
    let denoiser = Denoiser::Laplacian(Laplacian { iterations: 5, ..Laplacian::default() });
    let weld = Weld::new(sphere.positions(), Welding::None);
    let denoising = Denoising { denoiser, limits };
    let moved = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
    (sphere, moved.deltas, moved.limits.unwrap_or_default())
}

fn mask(weights: &[f32]) -> Limits {
    let mask = WeightMask { from: "test".to_owned(), weights: Weights::new(weights) };
    Limits { mask: Some(mask), ..Limits::default() }
}

#[test]
fn vertices_go_as_far_as_their_weight_says() {
    let (sphere, free, _) = limited(Limits::default());
    let weights: Vec<f32> = (0..sphere.positions().len()).map(|v| (v % 4) as f32 / 3.0).collect();
    let (_, deltas, outcome) = limited(mask(&weights));
    for ((delta, free), weight) in deltas.iter().zip(&free).zip(&weights) {
        assert!(delta.distance(*free * f64::from(*weight)) <= 1e-7 * free.length());
        assert!(*weight > 0.0 || *delta == DVec3::ZERO);
    }
    let count = |picked: &dyn Fn(f32) -> bool| weights.iter().filter(|weight| picked(**weight)).count();
    assert_eq!((outcome.fixed_vertices, outcome.weighted_vertices), (count(&|w| w == 0.0), count(&|w| w < 1.0)));
    // The manifest names the vertices that were held back.
    let json = serde_json::to_value(outcome).unwrap();
    assert_eq!(json["weighted_vertices"], outcome.weighted_vertices);
}

#[test]
fn vertices_move_along_their_direction_alone() {
    for (direction, volume) in [("0,0,1", Volume::Free), ("0,0,-2", Volume::Preserve), ("ray:3,0,0", Volume::Preserve)]
    {
        let direction: Direction = direction.parse().unwrap();
        let (sphere, deltas, outcome) =
            limited(Limits { direction: Some(direction), volume, max_displacement: Some(0.3), ..Limits::default() });
        for (delta, along) in deltas.iter().zip(direction.of(&sphere)) {
            assert!(delta.cross(along).length() <= 1e-12 * sphere.mean_edge(), "{delta} {along}");
            assert!(delta.length() <= 0.3 * sphere.mean_edge());
        }
        assert!(deltas.iter().any(|delta| delta.length() > 0.01 * sphere.mean_edge()));
        assert!(outcome.volume.is_none_or(|change| change.left.abs() < change.by_method.abs()), "{outcome:?}");
    }
}

#[test]
fn heights_along_normals_are_no_motion_along_a_direction() {
    let sphere = shapes::dented_sphere(2);
    let direction = Direction::Axis(DVec3::Z);
    let limits = Limits { direction: Some(direction), ..Limits::default() };
    let denoising = Denoising { denoiser: Denoiser::Laplacian(Laplacian::default()), limits };
    let weld = Weld::new(sphere.positions(), Welding::None);
    let error = denoising.run(&sphere, &weld, crate::denoise::Output::Heights(None), &Silent).unwrap_err();
    assert_eq!(error, DenoisingError::Limits(LimitsError::NotAlongNormals(direction)));
}
