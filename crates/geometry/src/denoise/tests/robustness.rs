//! Laws for meshes that are not as they should be, and for work that is stopped.

use super::*;
use std::sync::Mutex;

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
fn faces_that_were_turned_around_change_no_result() {
    let sphere = shapes::dented_sphere(2);
    let noisy = displaced(&sphere, &white_noise(&sphere, 0.2, 1));
    let every_third: Vec<bool> = (0..noisy.topology().faces().len()).map(|f| f % 3 == 1).collect();
    let turned = Surface::new(orientation::with_turned(noisy.topology(), &every_third), noisy.positions().to_vec());
    for denoiser in every() {
        assert!(deltas(&denoiser, &turned) == deltas(&denoiser, &noisy), "{denoiser:?}");
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
fn progress_is_a_fraction_of_each_stage_that_ends_at_one_at_most() {
    #[derive(Default)]
    struct Reports(Mutex<Vec<f64>>);
    impl Progress for Reports {
        fn done(&self, fraction: f64) {
            self.0.lock().unwrap().push(fraction);
        }
    }
    let surface = displaced(&shapes::sphere(2), &white_noise(&shapes::sphere(2), 0.2, 1));
    let mut count = 0;
    for denoiser in every() {
        let reports = Reports::default();
        denoiser.deltas(&surface, &reports).unwrap();
        let reports = reports.0.into_inner().unwrap();
        count += reports.len();
        assert!(reports.iter().all(|x| (0.0..=1.0).contains(x)), "{denoiser:?}: {reports:?}");
    }
    assert!(count > 0);
}
