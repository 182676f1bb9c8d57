//! Shadow maps: the views that lights have of a scene.
//!
//! Lance Williams. Casting curved shadows on curved surfaces. SIGGRAPH 1978.

use crate::bounds::Sphere;
use crate::camera::View;
use crate::draw_parameters::reach;
use crate::ground::{self, Floor};
use crate::lights::WorldLight;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::lights::{Light, LightKind, MAX_LIGHTS};
use crate::settings::shadow::{LightProjection, Shadow};
use glam::camera::rh::proj::directx;
use glam::{Mat3, Mat4, Vec3};

/// View of a light, from which one shadow map is drawn. Distances are world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShadowView {
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
pub(crate) const MAX_SHADOW_VIEWS: usize = 6 * MAX_LIGHTS;
/// Faces of a point light's map reach over one another a little, so that filters find what lies beyond an edge.
const FACE: f32 = 1.06;
/// Distance of the nearest caster from a light that stands inside the model, in radii.
const NEAREST: f32 = 0.02;
/// A little room about the bounding sphere, so that rounding does not cut the nearest vertex off.
const SLACK: f32 = 1.05;
/// Pictures are turned about their axis by so many radians: lavapipe 22.3 loses rectangles whose sides lie along those of a
/// depth picture.
const MAP_ROTATION: f32 = 0.02;
/// Shadows of a low light that are longer than so many radii are cut off.
const LONGEST: f32 = 20.0;

/// Views of each of the lights.
pub(crate) fn shadow_views(
    scene: &Scene,
    settings: &Settings,
    view: &View,
    world_lights: &[WorldLight],
) -> Vec<Vec<ShadowView>> {
    let floor = ground::floor(scene, settings, view.up_in_world);
    let bounds = scene.displaced_bounds(reach(scene, settings));
    let views = |(light, world_light)| views_of_light(light, world_light, &settings.shadow, bounds, floor);
    settings.lights.iter().zip(world_lights).map(views).collect()
}

/// Views of a light: one, or six (+x −x +y −y +z −z).
fn views_of_light(
    light: &Light,
    world_light: &WorldLight,
    shadow: &Shadow,
    bounds: Sphere,
    floor: Option<Floor>,
) -> Vec<ShadowView> {
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
    let to_light = -world_light.axis;
    let far_away = |to_light: Vec3| {
        let eye = bounds.centre + 2.0 * radius * to_light;
        let (near, far) = ((2.0 - SLACK) * radius, 2.0 * radius + behind(to_light));
        // A little room for filters.
        let half = 1.02 * shadow.extent * radius;
        let clip_from_view = directx::orthographic(-half, half, -half, half, near, far);
        let clip_from_world = clip_from_view * view(axes(to_light), eye);
        ShadowView { clip_from_world, near, far, rays: Rays::Parallel(half), light_size: tangent }
    };
    // `slant`: the least that a distance from the eye is worth along the axis.
    let from = |eye: Vec3, axes: Mat3, half: f32, behind: f32, slant: f32| {
        let distance = eye.distance(bounds.centre);
        let near = (slant * (distance - SLACK * radius)).max(NEAREST * radius);
        let far = distance + behind;
        let clip_from_world = directx::perspective(2.0 * half.atan(), 1.0, near, far) * view(axes, eye);
        ShadowView { clip_from_world, near, far, rays: Rays::Perspective(half), light_size: tangent * distance }
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
            vec![from(world_light.position.truncate(), axes(to_light), half, behind(to_light), 1.0)]
        }
        (LightKind::Point { .. }, _) => {
            let reach = behind((world_light.position.truncate() - bounds.centre).normalize_or(to_light));
            // The corners of a cube are the furthest from the axes.
            let slant = 3.0f32.sqrt().recip();
            FACES.map(|face| from(world_light.position.truncate(), face.transpose(), FACE, reach, slant)).to_vec()
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
    let view_from_world = (world_from_view * Mat3::from_rotation_z(MAP_ROTATION)).transpose();
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

    fn seen(kind: LightKind, shadow: &Shadow, floor: Option<Floor>) -> (WorldLight, Vec<ShadowView>) {
        let light = Light {
            azimuth: 30.0,
            elevation: 50.0,
            colour: Colour::WHITE,
            intensity: 1.0,
            kind,
            anchor: Anchor::Model,
        };
        let world_light = light.world_light(&Camera::default().view(BOUNDS, 1.0), BOUNDS);
        (world_light, views_of_light(&light, &world_light, shadow, BOUNDS, floor))
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
            let (_, views) = seen(kind, &Shadow { projection, ..Shadow::default() }, None);
            for point in surface() {
                let sees = |eye: &ShadowView| {
                    let clip = eye.clip_from_world * point.extend(1.0);
                    clip.w > 0.0 && inside(clip.truncate() / clip.w)
                };
                assert!(views.iter().any(sees), "{kind:?} {projection:?} {point}");
            }
        }
    }

    #[test]
    fn what_lies_behind_one_another_has_one_place_and_rising_depth() {
        for kind in KINDS {
            let (world_light, views) = seen(kind, &Shadow::default(), None);
            for eye in views {
                let start = BOUNDS.centre + Vec3::new(0.1, 0.05, -0.2);
                let (to_light, _) = world_light.incoming(start);
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
        let (world_light, views) = seen(LightKind::Directional, &Shadow::default(), Some(floor));
        let to_light = world_light.position.truncate();
        for point in surface() {
            let drop = (point.y - (BOUNDS.centre.y - floor.height)) / to_light.y;
            let shadow = point - drop * to_light;
            assert!(inside(views[0].clip_from_world.project_point3(shadow)), "{point} {shadow}");
        }
    }

    #[test]
    fn the_six_faces_of_a_point_light_leave_no_gap() {
        let (world_light, views) = seen(KINDS[2], &Shadow::default(), None);
        for (face, axis) in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate() {
            for (right, up) in [(0.999, 0.999), (-0.999, 0.999), (0.0, 0.0)] {
                let (a, b) = axis.any_orthonormal_pair();
                let point = world_light.position.truncate() + axis + right * a + up * b;
                let clip = views[face].clip_from_world * point.extend(1.0);
                let ndc = clip.truncate() / clip.w;
                assert!(clip.w > 0.0 && ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0, "{axis} {ndc}");
            }
        }
    }
}
