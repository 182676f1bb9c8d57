//! A camera in front of a model: from world space to the picture.
//!
//! ```
//! use glam::Vec3;
//! use planish_render::bounds::Sphere;
//! use planish_render::settings::camera::Camera;
//!
//! // From the front, x points to the right. The middle of the model is in the middle of the picture.
//! let bounds = Sphere { centre: Vec3::new(5.0, 6.0, 7.0), radius: 2.0 };
//! let view = Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() }.view(bounds, 4.0 / 3.0);
//! let [middle, right] = [Vec3::ZERO, Vec3::X].map(|p| view.clip_from_world.project_point3(bounds.centre + p));
//! assert!(middle.truncate().length() < 1e-5, "{middle}");
//! assert!(right.x > 0.1 && right.y.abs() < 1e-5, "{right}");
//! assert!((0.0..=1.0).contains(&middle.z));
//! ```

use crate::bounds::Sphere;
use crate::settings::camera::{Camera, Projection, UpAxis};
use glam::camera::rh::proj::directx;
use glam::{Mat3, Mat4, Vec3, Vec4};

/// A camera in front of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Clip space (depth 0..1, near to far) from world space.
    pub clip_from_world: Mat4,
    /// Columns: right, up and back (towards the eye), in world space.
    pub world_from_view: Mat3,
    /// The eye, homogeneous: a point in perspective, a direction (w = 0) if rays are parallel.
    pub eye_in_world: Vec4,
    /// The model's up axis, in world space.
    pub up_in_world: Vec3,
    /// Columns: right, up and back of an eye right in front of the model, at yaw 0 and pitch 0, in world space.
    pub world_from_front: Mat3,
}

impl Camera {
    /// Unit vectors upwards and to the eye at yaw 0 and pitch 0, world space.
    pub fn axes(&self) -> (Vec3, Vec3) {
        match self.up {
            UpAxis::Y => (Vec3::Y, Vec3::Z),
            UpAxis::Z => (Vec3::Z, Vec3::NEG_Y),
        }
    }

    /// This camera before a model with these bounds. `aspect` = width / height.
    pub fn view(&self, bounds: Sphere, aspect: f32) -> View {
        self.view_reaching(bounds, aspect, bounds.radius)
    }

    /// This camera before a model with these bounds, where something is to be seen up to `reach` from its middle.
    /// `aspect` = width / height.
    pub fn view_reaching(&self, bounds: Sphere, aspect: f32, reach: f32) -> View {
        let (up, front) = self.axes();
        let world_from_front = Mat3::from_cols(up.cross(front), up, front);
        let world_from_view = world_from_front
            * Mat3::from_rotation_y(self.yaw.to_radians())
            * Mat3::from_rotation_x(-self.pitch.to_radians());
        let back = world_from_view.z_axis;

        // A model that is a single point still has a picture.
        let radius = bounds.radius.max(f32::MIN_POSITIVE.sqrt());
        let distance = match self.projection {
            Projection::Perspective { field_of_view } => {
                self.distance * radius / (0.5 * field_of_view.to_radians()).sin()
            }
            // Anywhere outside does.
            Projection::Orthographic => 2.0 * reach.max(radius) + self.target.length() * radius,
        };
        let eye = bounds.centre + radius * self.target + distance * back;
        // A little room, so that rounding does not cut the nearest vertex off.
        let reach = 1.01 * reach.max(radius);
        let middle = distance + radius * self.target.dot(back);
        let near = (middle - reach).max(1e-3 * radius);
        let far = (middle + reach).max(2.0 * near);
        let (clip_from_view, eye_in_world) = match self.projection {
            Projection::Perspective { field_of_view } => {
                let half = (0.5 * field_of_view.to_radians()).tan();
                let vertical = 2.0 * (half / aspect.min(1.0)).atan();
                (directx::perspective(vertical, aspect, near, far), eye.extend(1.0))
            }
            Projection::Orthographic => {
                let y = self.distance * radius / aspect.min(1.0);
                let x = y * aspect;
                (directx::orthographic(-x, x, -y, y, near, far), back.extend(0.0))
            }
        };
        let view_from_world = world_from_view.transpose();
        View {
            clip_from_world: clip_from_view * Mat4::from_mat3_translation(view_from_world, view_from_world * -eye),
            world_from_view,
            eye_in_world,
            up_in_world: up,
            world_from_front,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Sphere = Sphere { centre: Vec3::new(1.0, -2.0, 3.0), radius: 0.5 };
    const PROJECTIONS: [Projection; 2] = [Projection::Perspective { field_of_view: 40.0 }, Projection::Orthographic];

    #[test]
    fn bounding_sphere_fits_the_shorter_side_exactly() {
        for (projection, aspect) in PROJECTIONS.into_iter().flat_map(|p| [0.5, 1.0, 2.0].map(|a| (p, a))) {
            let camera = Camera { projection, ..Camera::default() };
            let View { clip_from_world, world_from_view, .. } = camera.view(BOUNDS, aspect);
            // The points of the sphere furthest up and right in the picture lie on the cone of tangents.
            let tilt = match projection {
                Projection::Perspective { field_of_view } => 0.5 * field_of_view.to_radians(),
                Projection::Orthographic => 0.0,
            };
            let extreme = |side: Vec3| {
                let out = tilt.cos() * side + tilt.sin() * Vec3::Z;
                clip_from_world.project_point3(BOUNDS.centre + BOUNDS.radius * (world_from_view * out))
            };
            let (x, y) = (extreme(Vec3::X).x, extreme(Vec3::Y).y);
            assert!((x.max(y) - 1.0).abs() < 1e-4, "{projection:?} {aspect}: {x} {y}");
            assert!((y / x - aspect).abs() < 1e-3, "{projection:?} {aspect}: {x} {y}");
        }
    }

    #[test]
    fn yaw_shows_the_side_and_pitch_the_top() {
        for (up, front, top) in [(UpAxis::Y, Vec3::Z, Vec3::Y), (UpAxis::Z, Vec3::NEG_Y, Vec3::Z)] {
            let back = |yaw, pitch| {
                let camera = Camera { yaw, pitch, up, projection: Projection::Orthographic, ..Camera::default() };
                camera.view(BOUNDS, 1.0).eye_in_world.truncate()
            };
            for (found, expected) in [(back(0.0, 0.0), front), (back(90.0, 0.0), Vec3::X), (back(0.0, 90.0), top)] {
                assert!(found.distance(expected) < 1e-6, "{up:?}: {found} {expected}");
            }
        }
    }
}
