//! Shadow maps: the views that lights have of a scene.
//!
//! Lance Williams. Casting curved shadows on curved surfaces. SIGGRAPH 1978.

use crate::bounds::Sphere;
use crate::camera::View;
use crate::draw_parameters::reach;
use crate::ground::{self, Floor};
use crate::lights::Lamp;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::lights::{Light, LightKind, MAX_LIGHTS};
use crate::settings::shadow::{LightProjection, Shadow};
use glam::camera::rh::proj::directx;
use glam::{Mat3, Mat4, Vec3};

/// View of a light, from which one shadow map is drawn. Distances are world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    /// Clip space (depth 0..1, near to far) from world space.
    pub(crate) clip_from_world: Mat4,
    /// Distance of the near plane along the axis.
    pub(crate) near: f32,
    /// Distance of the far plane along the axis.
    pub(crate) far: f32,
    /// Projection of the view.
    pub(crate) rays: Rays,
    /// Radius of the light: the tangent of its angle if rays are parallel, else a length.
    pub(crate) light_size: f32,
}

/// Projection of a light's view, with half of its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rays {
    /// Parallel rays; half the width is a length.
    Parallel(f32),
    /// Rays from one point; half the width is the tangent of an angle.
    Perspective(f32),
}

/// Largest number of views that all lights have together.
pub(crate) const MAX_EYES: usize = 6 * MAX_LIGHTS;
/// Faces of a point light's map reach over one another a little, so that filters find what lies beyond an edge.
const FACE: f32 = 1.06;
/// How far the nearest caster may be from a light that stands inside the model, radii.
const NEAREST: f32 = 0.02;
/// A little room about the bounding sphere, so that rounding does not cut the nearest vertex off.
const SLACK: f32 = 1.05;
/// Pictures are turned about their axis by so many radians: lavapipe 22.3 loses rectangles whose sides lie along those of a
/// depth picture.
const TURN: f32 = 0.02;
/// Shadows of a low light that are longer than so many radii are cut off.
const LONGEST: f32 = 20.0;

/// Views of each of the lights.
pub(crate) fn eyes_of_lights(scene: &Scene, settings: &Settings, view: &View, lamps: &[Lamp]) -> Vec<Vec<Eye>> {
    let floor = ground::floor(scene, settings, view.up_in_world);
    let bounds = scene.displaced_bounds(reach(scene, settings));
    let eyes = |(light, lamp)| eyes(light, lamp, &settings.shadow, bounds, floor);
    settings.lights.iter().zip(lamps).map(eyes).collect()
}

/// Views of a light: one, or six (+x −x +y −y +z −z).
fn eyes(light: &Light, lamp: &Lamp, shadow: &Shadow, bounds: Sphere, floor: Option<Floor>) -> Vec<Eye> {
    let radius = bounds.radius.max(f32::MIN_POSITIVE.sqrt());
    let tangent = (0.5 * shadow.light_angle.to_radians()).tan();
    // Along the light, from the middle of the model to its last shadow.
    let behind = |to_light: Vec3| {
        let reach = floor.map_or(0.0, |Floor { up, height }| {
            let sine = to_light.dot(up).max(1.0 / LONGEST);
            (height + radius * (1.0 - sine * sine).max(0.0).sqrt()) / sine
        });
        reach.clamp(SLACK * radius, LONGEST * radius)
    };
    let to_light = -lamp.axis;
    let far_away = |to_light: Vec3| {
        let eye = bounds.centre + 2.0 * radius * to_light;
        let (near, far) = ((2.0 - SLACK) * radius, 2.0 * radius + behind(to_light));
        // A little room for filters.
        let half = 1.02 * shadow.extent * radius;
        let clip_from_view = directx::orthographic(-half, half, -half, half, near, far);
        let clip_from_world = clip_from_view * view(axes(to_light), eye);
        Eye { clip_from_world, near, far, rays: Rays::Parallel(half), light_size: tangent }
    };
    // `slant`: the least that a distance from the eye is worth along the axis.
    let from = |eye: Vec3, axes: Mat3, half: f32, behind: f32, slant: f32| {
        let distance = eye.distance(bounds.centre);
        let near = (slant * (distance - SLACK * radius)).max(NEAREST * radius);
        let far = distance + behind;
        let clip_from_world = directx::perspective(2.0 * half.atan(), 1.0, near, far) * view(axes, eye);
        Eye { clip_from_world, near, far, rays: Rays::Perspective(half), light_size: tangent * distance }
    };
    match (light.kind, shadow.projection) {
        (LightKind::Directional, LightProjection::Perspective) => {
            let eye = bounds.centre + 4.0 * radius * to_light;
            // The cone about the sphere.
            let half = 1.02 * shadow.extent / 15.0f32.sqrt();
            vec![from(eye, axes(to_light), half, behind(to_light), 1.0)]
        }
        (LightKind::Directional, _) | (LightKind::Spot { .. }, LightProjection::Orthographic) => {
            vec![far_away(to_light)]
        }
        (LightKind::Spot { angle, .. }, _) => {
            let half = (0.5 * angle.to_radians()).tan();
            vec![from(lamp.place.truncate(), axes(to_light), half, behind(to_light), 1.0)]
        }
        (LightKind::Point { .. }, _) => {
            let reach = behind((lamp.place.truncate() - bounds.centre).normalize_or(to_light));
            // The corners of a cube are the furthest from the axes.
            let slant = 3.0f32.sqrt().recip();
            FACES.map(|face| from(lamp.place.truncate(), face.transpose(), FACE, reach, slant)).to_vec()
        }
    }
}

/// Rows: right, up and back of each face.
const FACES: [Mat3; 6] = {
    const fn face(right: [f32; 3], up: [f32; 3], back: [f32; 3]) -> Mat3 {
        Mat3::from_cols_array(&[right[0], up[0], back[0], right[1], up[1], back[1], right[2], up[2], back[2]])
    }
    const X: [f32; 3] = [1.0, 0.0, 0.0];
    const Y: [f32; 3] = [0.0, 1.0, 0.0];
    const Z: [f32; 3] = [0.0, 0.0, 1.0];
    const NX: [f32; 3] = [-1.0, 0.0, 0.0];
    const NY: [f32; 3] = [0.0, -1.0, 0.0];
    const NZ: [f32; 3] = [0.0, 0.0, -1.0];
    [face(Z, Y, NX), face(NZ, Y, X), face(X, Z, NY), face(X, NZ, Y), face(NX, Y, NZ), face(X, Y, Z)]
};

/// Columns: right, up and back of an eye that looks along a light.
fn axes(to_light: Vec3) -> Mat3 {
    let (right, up) = to_light.any_orthonormal_pair();
    // The pair and the light are right-handed in this order.
    Mat3::from_cols(right, up, to_light)
}

fn view(world_from_view: Mat3, eye: Vec3) -> Mat4 {
    let view_from_world = (world_from_view * Mat3::from_rotation_z(TURN)).transpose();
    Mat4::from_mat3_translation(view_from_world, view_from_world * -eye)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::Colour;
    use crate::settings::camera::Camera;
    use crate::settings::lights::Anchor;

    const BOUNDS: Sphere = Sphere { centre: Vec3::new(0.3, -2.0, 1.0), radius: 0.7 };
    const KINDS: [LightKind; 3] =
        [LightKind::Directional, LightKind::Spot { distance: 4.0, angle: 40.0 }, LightKind::Point { distance: 3.0 }];

    fn seen(kind: LightKind, shadow: &Shadow, floor: Option<Floor>) -> (Lamp, Vec<Eye>) {
        let light = Light {
            azimuth: 30.0,
            elevation: 50.0,
            colour: Colour::WHITE,
            intensity: 1.0,
            kind,
            anchor: Anchor::Model,
        };
        let lamp = light.lamp(&Camera::default().view(BOUNDS, 1.0), BOUNDS);
        (lamp, eyes(&light, &lamp, shadow, BOUNDS, floor))
    }

    /// Points of the bounding sphere.
    fn surface() -> impl Iterator<Item = Vec3> {
        let on = |i: u32| {
            let (z, turn) = (1.0 - (2 * i + 1) as f32 / 400.0, i as f32 * 2.399_963);
            let flat = (1.0 - z * z).sqrt();
            BOUNDS.centre + BOUNDS.radius * Vec3::new(flat * turn.cos(), flat * turn.sin(), z)
        };
        (0..400).map(on)
    }

    fn inside(ndc: Vec3) -> bool {
        ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0 && (0.0..=1.0).contains(&ndc.z)
    }

    #[test]
    fn every_light_sees_the_whole_model() {
        for (kind, projection) in KINDS.into_iter().flat_map(|k| LightProjection::ALL.iter().map(move |p| (k, *p))) {
            let (_, eyes) = seen(kind, &Shadow { projection, ..Shadow::default() }, None);
            for point in surface() {
                let sees = |eye: &Eye| {
                    let clip = eye.clip_from_world * point.extend(1.0);
                    clip.w > 0.0 && inside(clip.truncate() / clip.w)
                };
                assert!(eyes.iter().any(sees), "{kind:?} {projection:?} {point}");
            }
        }
    }

    #[test]
    fn what_lies_behind_one_another_has_one_place_and_rising_depth() {
        for kind in KINDS {
            let (lamp, eyes) = seen(kind, &Shadow::default(), None);
            for eye in eyes {
                let start = BOUNDS.centre + Vec3::new(0.1, 0.05, -0.2);
                let (to_light, _) = lamp.incoming(start);
                let [near, far] = [0.2, -0.2].map(|step| eye.clip_from_world * (start + step * to_light).extend(1.0));
                if near.w <= 0.0 || far.w <= 0.0 {
                    continue;
                }
                let [near, far] = [near, far].map(|clip| clip.truncate() / clip.w);
                assert!(near.truncate().abs_diff_eq(far.truncate(), 1e-4), "{kind:?} {near} {far}");
                assert!(near.z < far.z, "{kind:?} {near} {far}");
            }
        }
    }

    #[test]
    fn the_floor_lies_in_view_where_shadows_fall() {
        let floor = Floor { up: Vec3::Y, height: 1.1 };
        let (lamp, eyes) = seen(LightKind::Directional, &Shadow::default(), Some(floor));
        let to_light = lamp.place.truncate();
        for point in surface() {
            let drop = (point.y - (BOUNDS.centre.y - floor.height)) / to_light.y;
            let shadow = point - drop * to_light;
            assert!(inside(eyes[0].clip_from_world.project_point3(shadow)), "{point} {shadow}");
        }
    }

    #[test]
    fn the_six_faces_of_a_point_light_leave_no_gap() {
        let (lamp, eyes) = seen(KINDS[2], &Shadow::default(), None);
        for (face, axis) in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate() {
            for (right, up) in [(0.999, 0.999), (-0.999, 0.999), (0.0, 0.0)] {
                let (a, b) = axis.any_orthonormal_pair();
                let place = lamp.place.truncate() + axis + right * a + up * b;
                let clip = eyes[face].clip_from_world * place.extend(1.0);
                let ndc = clip.truncate() / clip.w;
                assert!(clip.w > 0.0 && ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0, "{axis} {ndc}");
            }
        }
    }
}
