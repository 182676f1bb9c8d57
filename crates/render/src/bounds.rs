//! Bounding spheres of models.
//!
//! ```
//! use glam::Vec3;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::Obj};
//! use planish_render::{bounds::Sphere, input};
//!
//! // The last vertex belongs to no triangle, and does not count.
//! let text = "v 4 0 0\nv 10 0 0\nv 10 8 0\nv 4 8 0\nv 99 0 0\nf 1 2 3 4\n";
//! let scene = input::scene(&Model::new(Obj::parse(text.into())?, Welding::Exact), None)?;
//! assert_eq!(scene.bounds(), Sphere { centre: Vec3::new(7.0, 4.0, 0.0), radius: 5.0 });
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glam::Vec3;

/// A ball that contains a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Centre of the ball.
    pub centre: Vec3,
    /// Radius of the ball.
    pub radius: f32,
}
