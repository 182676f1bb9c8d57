//! Laws that hold for every method, whatever its settings.

use super::limits::{Limits, Outcome, Volume};
use super::*;
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::shapes;
use crate::mesh::synthetic_noise::{self, Noise};
use crate::mesh::topology::Topology;
use crate::mesh::weld::{Weld, Welding};
use crate::progress::Silent;
use crate::source::model::NormalSource;
use glam::DQuat;

/// Some of each; a new method is added here and nowhere else.
fn every() -> Vec<Denoiser> {
    let mut all = normal_filters();
    for weights in [EdgeWeights::Uniform, EdgeWeights::Cotangent] {
        for boundary in [Boundary::Fixed, Boundary::Free] {
            all.push(Denoiser::Laplacian(Laplacian { iterations: 5, step: 0.5, weights, boundary }));
            all.push(Denoiser::Taubin(Taubin { iterations: 3, weights, boundary, ..Taubin::default() }));
            let solver = if boundary == Boundary::Fixed { Solver::Direct } else { Solver::Iterative };
            all.push(Denoiser::Implicit(Implicit { weights, boundary, solver, ..Implicit::default() }));
        }
    }
    for boundary in [Boundary::Fixed, Boundary::Free] {
        all.push(Denoiser::Hc(Hc { boundary, alpha: 0.1, ..Hc::default() }));
        all.push(Denoiser::Bilateral(Bilateral { iterations: 2, boundary }));
        all.push(Denoiser::L0(L0 { beta_max: 1.0, boundary, ..L0::default() }));
    }
    all.extend(estimates());
    all
}

fn estimates() -> Vec<Denoiser> {
    let prior = Prior { rounds: 3, ..Prior::default() };
    let mut all = Vec::new();
    for (motion, boundary) in [(Motion::Free, Boundary::Free), (Motion::AlongNormal, Boundary::Fixed)] {
        let map = Map { prior, steps: 10, motion, boundary, ..Map::default() };
        all.push(Denoiser::Map(map));
        all.push(Denoiser::Map(Map { noise: Some(0.2), ..map }));
        all.push(Denoiser::Auto(Auto { motion, boundary, ..Auto::default() }));
    }
    all
}

/// A setting of the vertex update; none where there is no such.
fn settings_of(denoiser: &Denoiser, name: &str) -> Option<serde_json::Value> {
    serde_json::to_value(denoiser).unwrap().get("vertex_update")?.get(name).cloned()
}

/// How far results may be apart for inputs that are alike but for rounding, model units.
fn rounding(denoiser: &Denoiser) -> f64 {
    match denoiser {
        // Conjugate gradients end when 1e-8 of the pull is left, one step sooner or later.
        _ if settings_of(denoiser, "scheme").is_some_and(|scheme| scheme == "least-squares") => 1e-7,
        // Single precision rounds other digits of normals that are turned.
        _ if denoiser.motion() == Some(Motion::AlongNormal) => 1e-7,
        // Weights of the edges have a slope of up to 1/κ² = 2500, and rounds multiply what they are given.
        Denoiser::Map(_) | Denoiser::Auto(_) => 1e-8,
        // Sums of a dozen terms of size 10, five steps: a few hundred ulps.
        _ => 1e-12,
    }
}

fn normal_filters() -> Vec<Denoiser> {
    let mut all = Vec::new();
    let held = VertexUpdate::paper(5, Boundary::Fixed).held();
    let along = VertexUpdate { motion: Motion::AlongNormal, boundary: Boundary::Free, ..held };
    let fitted = VertexUpdate { scheme: VertexScheme::LeastSquares, ..held };
    for vertex_update in [VertexUpdate::paper(5, Boundary::Free), held, along, fitted] {
        all.push(Denoiser::Sun(Sun { iterations: 4, vertex_update, ..Sun::paper() }));
        for (scheme, neighbours) in [(Scheme::Local, Neighbours::Vertex), (Scheme::Global, Neighbours::Edge)] {
            let settings = BilateralNormals { iterations: 4, scheme, neighbours, vertex_update, ..<_>::default() };
            all.push(Denoiser::BilateralNormals(settings));
        }
        let guided = GuidedNormals { iterations: 3, vertex_update, ..GuidedNormals::paper() };
        all.push(Denoiser::GuidedNormals(guided));
        all.push(Denoiser::TgvNormals(TgvNormals { iterations: 3, vertex_update, ..TgvNormals::default() }));
    }
    all
}

/// What the method does at the boundary; none where it says nothing of it.
fn boundary(denoiser: &Denoiser) -> Option<Boundary> {
    let settings = serde_json::to_value(denoiser).unwrap();
    let found = settings.get("boundary").or_else(|| settings.get("vertex_update")?.get("boundary"))?;
    Some(serde_json::from_value(found.clone()).unwrap())
}

fn deltas(denoiser: &Denoiser, surface: &Surface) -> Vec<DVec3> {
    denoiser.deltas(surface, &Silent).unwrap()
}

/// All limits at once; the rim is fixed because without that an open surface has no volume.
fn limits() -> Limits {
    Limits { fixed: "boundary 2-3 5".parse().unwrap(), max_displacement: Some(0.05), volume: Volume::Preserve }
}

fn limited(denoiser: &Denoiser, limits: &Limits, surface: &Surface) -> (Vec<DVec3>, Option<Outcome>) {
    let weld = Weld::new(surface.positions(), Welding::None);
    let denoising = Denoising { denoiser: denoiser.clone(), limits: limits.clone() };
    let Moved { deltas, limits, .. } = denoising.run(surface, &weld, denoising.output(), &Silent).unwrap();
    (deltas, limits)
}

/// Six times the volume between the faces and the origin, where vertices go by −δ.
fn six_volumes(surface: &Surface, deltas: &[DVec3]) -> f64 {
    let at = |v: Index| surface.positions()[v as usize] - deltas[v as usize];
    surface.triangles().map(|t| t.map(at)).map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

/// Closed, open with a boundary, of quads, and noisy.
fn families() -> [Surface; 4] {
    let bumpy = |grid: Surface| {
        let lifted = grid.positions().iter().map(|p| *p + DVec3::Z * 0.1 * (p.x * 9.0).sin() * (p.y * 7.0).cos());
        grid.at(lifted.collect())
    };
    let sphere = shapes::sphere(2);
    let noise = Noise { sigma: 0.2, direction: synthetic_noise::Direction::Normal, share: 1.0, seed: 1 };
    let lifted = synthetic_noise::displacements(&sphere, &noise);
    let noisy = sphere.at(sphere.positions().iter().zip(lifted).map(|(p, d)| *p + d).collect());
    [shapes::dented_sphere(2), bumpy(shapes::grid(8)), shapes::cube(), noisy]
}

fn largest_gap(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn deltas_follow_a_similarity_of_the_surface() {
    let (turn, scale, shift) = (DQuat::from_rotation_y(0.7), 3.0, DVec3::new(5.0, -2.0, 1.0));
    for surface in families() {
        let moved = surface.at(surface.positions().iter().map(|p| turn * *p * scale + shift).collect());
        for denoiser in every() {
            let expected: Vec<_> = deltas(&denoiser, &surface).iter().map(|d| turn * *d * scale).collect();
            let gap = largest_gap(&deltas(&denoiser, &moved), &expected);
            assert!(gap < rounding(&denoiser), "{denoiser:?}: {gap:e}");
            let [here, there] = [&surface, &moved].map(|surface| limited(&denoiser, &limits(), surface).0);
            let expected: Vec<_> = here.iter().map(|d| turn * *d * scale).collect();
            let gap = largest_gap(&there, &expected);
            // The volume is restored to 1e-13 of the sum over the triangles.
            assert!(gap < rounding(&denoiser).max(1e-11), "{denoiser:?}: {gap:e}");
        }
    }
}

#[test]
fn a_plane_stays_a_plane_and_its_fixed_boundary_stays_where_it_is() {
    let plane = shapes::grid(8);
    for denoiser in every() {
        for (v, delta) in (0..).zip(deltas(&denoiser, &plane)) {
            assert!(delta.z.abs() < 1e-14, "{denoiser:?}: {delta}");
            if boundary(&denoiser) == Some(Boundary::Fixed) && plane.topology().is_boundary(v) {
                assert_eq!(delta, DVec3::ZERO, "{denoiser:?}");
            }
        }
    }
}

#[test]
fn fixed_vertices_stay_and_none_goes_too_far_and_the_volume_is_restored() {
    let mut stopped = 0;
    for surface in families() {
        let topology = surface.topology();
        let still = vec![DVec3::ZERO; topology.vertex_count()];
        let reach = 0.05 * surface.mean_edge();
        for denoiser in every() {
            let (deltas, outcome) = limited(&denoiser, &limits(), &surface);
            for (v, (p, delta)) in (0..).zip(surface.positions().iter().zip(&deltas)) {
                if topology.is_boundary(v) || [1, 2, 4].contains(&v) {
                    assert_eq!((*p - *delta).to_array().map(f64::to_bits), p.to_array().map(f64::to_bits));
                }
                assert!(delta.length() <= reach, "{denoiser:?}: {}", delta.length() / reach);
            }
            let [before, after] = [&still, &deltas].map(|deltas| six_volumes(&surface, deltas));
            assert!((after / before - 1.0).abs() < 1e-9, "{denoiser:?}: {:e}", after / before - 1.0);
            let outcome = outcome.unwrap();
            assert!(outcome.volume.unwrap().restored, "{denoiser:?}: {outcome:?}");
            stopped += outcome.stopped_vertices;
        }
    }
    assert!(stopped > 0);
}

#[test]
fn along_the_normal_means_along_it_within_limits_too() {
    let surface = shapes::dented_sphere(2);
    let weld = Weld::new(surface.positions(), Welding::None);
    let tested: Vec<_> = every().into_iter().filter(|d| d.motion() == Some(Motion::AlongNormal)).collect();
    assert!(!tested.is_empty());
    for denoiser in tested {
        for limits in [Limits::default(), limits()] {
            let denoising = Denoising { denoiser: denoiser.clone(), limits };
            let moved = denoising.run(&surface, &weld, denoising.output(), &Silent).unwrap();
            let (along, source) = moved.along.unwrap();
            let of = match source {
                NormalField::Source(NormalSource::Angle) => surface.clone(),
                _ => surface.at(denoiser.freed().denoised(&surface, &Silent).unwrap()),
            };
            let normals = normals::vertex_normals(&of, FaceWeight::Angle);
            let mut upright = 0;
            for ((delta, n), of_surface) in moved.deltas.iter().zip(&along.normals).zip(normals) {
                assert!(delta.cross(n.as_dvec3()).length() < 1e-15, "{denoiser:?}: {delta}");
                upright += usize::from(n.as_dvec3().distance(of_surface) < 1e-7);
            }
            // Limits shorten ways before normals are taken of where these lead.
            let leaning = along.normals.len() - upright;
            let told = (along.residual.tilted * along.normals.len() as f64).round() as usize;
            assert!(leaning <= told || !denoising.limits.is_none(), "{denoiser:?}: {leaning} of {told} lean");
        }
    }
}

#[test]
fn limits_that_allow_everything_change_no_bit() {
    let surface = shapes::dented_sphere(2);
    let wide = Limits { max_displacement: Some(1e6), ..Limits::default() };
    for denoiser in every() {
        let free = deltas(&denoiser, &surface);
        assert_eq!(limited(&denoiser, &Limits::default(), &surface), (free.clone(), None));
        assert_eq!(limited(&denoiser, &wide, &surface), (free, Some(Outcome::default())));
    }
}

#[test]
fn the_same_surface_gives_the_same_bits_on_any_number_of_threads() {
    let [.., noisy] = families();
    let large = shapes::dented_sphere(4);
    for denoiser in every() {
        // A clean mesh is nothing to choose for.
        let surface = if matches!(denoiser, Denoiser::Auto(_)) { &noisy } else { &large };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (deltas(&denoiser, surface), limited(&denoiser, &limits(), surface)))
        };
        let alone = on(1);
        assert!(alone == on(2) && alone == on(7), "{denoiser:?}");
    }
}

#[test]
fn an_isolated_vertex_stays() {
    let sphere = shapes::dented_sphere(1);
    let faces = sphere.topology().faces().clone();
    let mut positions = sphere.positions().to_vec();
    positions.push(DVec3::splat(3.0));
    let surface = Surface::new(Topology::new(positions.len(), faces), positions);
    for denoiser in every() {
        assert_eq!(deltas(&denoiser, &surface).pop(), Some(DVec3::ZERO), "{denoiser:?}");
    }
}

#[test]
fn non_manifold_and_flat_faces_give_finite_numbers() {
    let faces: [[Index; 3]; 5] = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 6, 7], [2, 5, 6]];
    let mut positions: Vec<_> = (0..8u32).map(|i| DVec3::new(f64::from(i % 3), f64::from(i % 5), 1.0)).collect();
    positions[6] = positions[5];
    positions[7] = positions[5];
    let topology = Topology::new(8, faces.into_iter().map(Vec::from).collect());
    let surface = Surface::new(topology, positions);
    for denoiser in every() {
        assert!(deltas(&denoiser, &surface).iter().all(|d| d.is_finite()), "{denoiser:?}");
    }
}

#[test]
fn work_can_be_stopped() {
    struct Impatient;
    impl Progress for Impatient {
        fn cancelled(&self) -> bool {
            true
        }
    }
    for denoiser in every() {
        assert_eq!(denoiser.deltas(&shapes::sphere(1), &Impatient), Err(Cancelled));
    }
}

#[test]
fn settings_survive_json() {
    for denoiser in every() {
        let json = serde_json::to_string(&denoiser).unwrap();
        assert_eq!(serde_json::from_str::<Denoiser>(&json).unwrap(), denoiser, "{json}");
        // Settings without limits are the same text, and an unknown one is refused beside them too.
        let free = Denoising::from(denoiser.clone());
        assert_eq!(serde_json::to_string(&free).unwrap(), json);
        let denoising = Denoising { limits: limits(), ..free };
        let mut json = serde_json::to_value(&denoising).unwrap();
        assert_eq!(serde_json::from_value::<Denoising>(json.clone()).unwrap(), denoising, "{json}");
        json["no_such_setting"] = 1.into();
        assert!(serde_json::from_value::<Denoising>(json).is_err());
    }
}

#[test]
fn names_are_those_of_the_json_and_every_method_is_in_the_battery() {
    for denoiser in Denoiser::every() {
        assert_eq!(serde_json::to_value(&denoiser).unwrap()["name"], denoiser.name());
        assert!(every().iter().any(|tested| tested.name() == denoiser.name()), "{}", denoiser.name());
        let along = denoiser.clone().with_motion(Motion::AlongNormal);
        assert_eq!(along.motion(), denoiser.motion().map(|_| Motion::AlongNormal));
        assert!(denoiser.paper().is_none_or(|paper| paper.name() == denoiser.name()));
    }
}
