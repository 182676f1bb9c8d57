//! Orbit control of the camera by the mouse. Angles are in degrees, pointer positions in normalised device coordinates, y up.

use glam::{Vec2, Vec3};
use planish_render::bounds::Sphere;
use planish_render::settings::camera::{Camera, Projection};

/// Degrees that a drag over the height of the view turns the model.
const DEGREES_PER_HEIGHT: f32 = 200.0;

/// Model and shape of the viewport that a camera is moved in.
#[derive(Clone, Copy, Debug)]
pub(super) struct ViewportCamera {
    /// Bounding sphere of the model.
    pub(super) bounds: Sphere,
    /// Aspect ratio of the viewport, width / height.
    pub(super) aspect: f32,
}

impl ViewportCamera {
    /// The point under the pointer, as far away as what the camera looks at. World space.
    fn under(&self, camera: &Camera, pointer: Vec2) -> Vec3 {
        let view = camera.view(self.bounds, self.aspect);
        let target = self.bounds.centre + self.radius() * camera.target;
        let depth = view.clip_from_world.project_point3(target).z;
        view.clip_from_world.inverse().project_point3(pointer.extend(depth))
    }

    /// Start and unit direction of the ray under the pointer, world space.
    pub(super) fn ray(&self, camera: &Camera, pointer: Vec2) -> [Vec3; 2] {
        let world_from_clip = camera.view(self.bounds, self.aspect).clip_from_world.inverse();
        let [near, far] = [0.0, 1.0].map(|depth| world_from_clip.project_point3(pointer.extend(depth)));
        [near, (far - near).normalize_or_zero()]
    }

    /// Length on the screen, in halves of its width, of a length that faces the camera at a point (world space).
    pub(super) fn length_at(&self, camera: &Camera, point: Vec3, length: f32) -> f32 {
        let view = camera.view(self.bounds, self.aspect);
        let place = |p: Vec3| view.clip_from_world.project_point3(p).x;
        (place(point + length * view.world_from_view.x_axis) - place(point)).abs()
    }

    fn radius(&self) -> f32 {
        self.bounds.radius.max(f32::MIN_POSITIVE.sqrt())
    }

    fn shift(&self, camera: &mut Camera, offset: Vec3) {
        let moved = camera.target + offset / self.radius();
        // Beyond that nothing of the model can be seen.
        camera.target = moved.clamp_length_max(100.0);
    }

    /// Moves the model with the pointer.
    pub(super) fn pan(&self, camera: &mut Camera, from: Vec2, to: Vec2) {
        let offset = self.under(camera, from) - self.under(camera, to);
        self.shift(camera, offset);
    }

    /// Goes nearer (factor below 1) or away; what is under the pointer stays there.
    pub(super) fn zoom(&self, camera: &mut Camera, pointer: Vec2, factor: f32) {
        let before = self.under(camera, pointer);
        camera.distance = (camera.distance * factor).clamp(0.01, 50.0);
        let offset = before - self.under(camera, pointer);
        self.shift(camera, offset);
    }
}

/// Turns the model with the pointer; `drag` in heights of the view.
pub(super) fn orbit(camera: &mut Camera, drag: Vec2) {
    camera.yaw = (camera.yaw - DEGREES_PER_HEIGHT * drag.x).rem_euclid(360.0);
    camera.pitch = (camera.pitch + DEGREES_PER_HEIGHT * drag.y).clamp(-90.0, 90.0);
}

/// Fits the model into the view without turning the camera.
pub(super) fn fit(camera: &mut Camera) {
    (camera.distance, camera.target) = (1.0, Vec3::ZERO);
}

/// A view along an axis of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standard {
    /// View from the front.
    Front,
    /// View from behind.
    Back,
    /// View from the model's left.
    Right,
    /// View from the model's right.
    Left,
    /// View from above.
    Top,
    /// View from below.
    Bottom,
}

impl Standard {
    /// All standard views, in the order of the buttons.
    pub(super) const ALL: [Self; 6] = [Self::Front, Self::Right, Self::Top, Self::Back, Self::Left, Self::Bottom];

    /// Turns the camera to the view and fits the model into it.
    pub(super) fn show(self, camera: &mut Camera) {
        (camera.yaw, camera.pitch) = match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::Left => (270.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
        };
        fit(camera);
    }
}

/// Switches between perspective and parallel rays.
pub(super) fn switch_projection(camera: &mut Camera) {
    camera.projection = match camera.projection {
        Projection::Perspective { .. } => Projection::Orthographic,
        Projection::Orthographic => Projection::default(),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: ViewportCamera =
        ViewportCamera { bounds: Sphere { centre: Vec3::new(3.0, -1.0, 2.0), radius: 0.5 }, aspect: 1.6 };

    fn cameras() -> [Camera; 2] {
        [Projection::default(), Projection::Orthographic].map(|projection| Camera {
            projection,
            distance: 0.7,
            target: Vec3::new(0.2, 0.1, -0.3),
            ..<_>::default()
        })
    }

    #[test]
    fn zoom_keeps_what_is_under_the_pointer() {
        for mut camera in cameras() {
            let pointer = Vec2::new(0.6, -0.3);
            let point = CAMERA.under(&camera, pointer);
            for factor in [0.5, 3.0, 0.9] {
                CAMERA.zoom(&mut camera, pointer, factor);
                let found = camera.view(CAMERA.bounds, CAMERA.aspect).clip_from_world.project_point3(point);
                assert!(found.truncate().distance(pointer) < 1e-3, "{camera:?}: {found}");
            }
        }
    }

    #[test]
    fn a_point_follows_the_pointer_that_pans() {
        for mut camera in cameras() {
            let [from, to] = [Vec2::new(-0.2, 0.4), Vec2::new(0.5, -0.1)];
            let point = CAMERA.under(&camera, from);
            CAMERA.pan(&mut camera, from, to);
            let found = camera.view(CAMERA.bounds, CAMERA.aspect).clip_from_world.project_point3(point);
            assert!(found.truncate().distance(to) < 1e-3, "{found}");
        }
    }

    #[test]
    fn a_ray_meets_what_is_drawn_under_the_pointer() {
        for camera in cameras() {
            let pointer = Vec2::new(0.3, -0.6);
            let [start, direction] = CAMERA.ray(&camera, pointer);
            let view = camera.view(CAMERA.bounds, CAMERA.aspect).clip_from_world;
            for distance in [0.0, 0.3, 1.0] {
                let seen = view.project_point3(start + distance * direction);
                assert!(seen.truncate().distance(pointer) < 1e-3, "{seen}");
            }
            let deep = |distance: f32| view.project_point3(start + distance * direction).z;
            assert!(deep(0.1) < deep(0.2), "away from the camera");
            let [point, side] = [start + direction, camera.view(CAMERA.bounds, CAMERA.aspect).world_from_view.x_axis];
            let offset = view.project_point3(point + 0.2 * side) - view.project_point3(point);
            assert!((CAMERA.length_at(&camera, point, 0.2) - offset.x.abs()).abs() < 1e-6);
        }
    }

    #[test]
    fn the_model_is_never_cut_off_in_front_or_behind() {
        for mut camera in cameras() {
            camera.distance = 2.0;
            let view = camera.view(CAMERA.bounds, CAMERA.aspect);
            for side in [view.world_from_view.z_axis, -view.world_from_view.z_axis] {
                let depth = view.clip_from_world.project_point3(CAMERA.bounds.centre + CAMERA.bounds.radius * side).z;
                assert!((0.0..=1.0).contains(&depth), "{depth}");
            }
        }
    }
}
