use super::*;
use crate::denoise::noise_level::gaussians;
use crate::mesh::shapes;

#[test]
fn the_jacobian_is_the_derivative_of_the_normals() {
    let surface = shapes::dented_sphere(2);
    let connectivity = Connectivity::of(&surface);
    let offsets = gaussians(surface.positions().len(), 1);
    const STEP: f64 = 1e-3;
    let at = |step: f64| {
        let mut linear = LinearisedNormals::default();
        let moved: Vec<DVec3> = surface.positions().iter().zip(&offsets).map(|(p, d)| *p + step * *d).collect();
        linear.update(&connectivity, &moved, |_| f64::INFINITY);
        linear
    };
    let mut changes = vec![Vec3A::ZERO; connectivity.mesh.face_count()];
    let offsets: Vec<Vec3A> = offsets.iter().map(|offset| offset.as_vec3a()).collect();
    at(0.0).apply_jacobian(&connectivity, &offsets, &mut changes);
    for ((forth, back), change) in at(STEP).normals.iter().zip(at(-STEP).normals).zip(changes) {
        // The error of central differences is of the order of the step over an edge, squared, and that of normals 1e-7 over the step.
        let difference = (*forth - back) / (2.0 * STEP as f32);
        assert!(difference.distance(change) < 1e-3 * change.length().max(1.0), "{change} {difference}");
    }
}

#[test]
fn no_gradient_is_longer_than_allowed() {
    let surface = shapes::dented_sphere(2);
    let connectivity = Connectivity::of(&surface);
    let mut linear = LinearisedNormals::default();
    let longest =
        |linear: &LinearisedNormals| linear.gradients.iter().flatten().map(|g| g.length()).fold(0.0, f32::max);
    linear.update(&connectivity, surface.positions(), |_| f64::INFINITY);
    let free = longest(&linear);
    linear.update(&connectivity, surface.positions(), |_| 0.5 * f64::from(free));
    assert!((longest(&linear) / free - 0.5).abs() < 1e-6);
}
