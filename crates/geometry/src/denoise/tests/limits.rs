//! Laws of the limits: every method keeps within them.

use super::*;

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
