//! Bounding spheres of models.

use glam::Vec3;

/// A ball that contains a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Centre of the ball.
    pub centre: Vec3,
    /// Radius of the ball.
    pub radius: f32,
}
