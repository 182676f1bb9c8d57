//! Light that an environment sends to a picture: background, ambient light, mirror images and its sun.

use super::Environment;
use crate::camera::View;
use crate::settings::Settings;
use crate::settings::camera::{Camera, Projection};
use crate::settings::environment::{Part, Surroundings};
use glam::{Mat3, Vec2, Vec3};

impl Surroundings {
    /// The environment's axes (right, up, ahead: left-handed) from those of the world.
    fn environment_from_world(&self, camera: &Camera) -> Mat3 {
        let (up, front) = camera.axes();
        let axes = Mat3::from_cols(up.cross(front), up, -front).transpose();
        Mat3::from_rotation_y(-self.rotation.to_radians()) * axes
    }
}

/// An environment turned to the camera of a picture. Twin of `shaders/environment.wgsl`.
#[derive(Clone, Debug)]
pub(crate) struct EnvironmentSampler<'a> {
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) environment: &'a Environment,
    pub(crate) environment_from_world: Mat3,
    /// Columns: directions to the right rim, the upper rim and the middle of the picture, in the environment.
    pub(crate) rays: Mat3,
}

impl<'a> EnvironmentSampler<'a> {
    /// Turns an environment; `None` where there is none, or the settings want none.
    pub(crate) fn new(
        environment: Option<&'a Environment>,
        settings: &'a Settings,
        view: &View,
        aspect: f32,
    ) -> Option<Self> {
        let (surroundings, environment) = (settings.environment.as_ref()?, environment?);
        let environment_from_world = surroundings.environment_from_world(&settings.camera);
        // With parallel rays the whole background would be one point of the environment.
        let field_of_view = match settings.camera.projection {
            Projection::Perspective { field_of_view } => field_of_view,
            Projection::Orthographic => 28.0,
        };
        let half = (0.5 * field_of_view.to_radians()).tan() / aspect.min(1.0);
        let Mat3 { x_axis: right, y_axis: up, z_axis: back } = view.world_from_view;
        let rays = environment_from_world * Mat3::from_cols(aspect * half * right, half * up, -back);
        Some(Self { surroundings, environment, environment_from_world, rays })
    }

    /// Radiance from a direction of the environment, as a mirror of this roughness shows it.
    fn radiance(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let levels = &self.environment.levels;
        let level = roughness * (levels.len() - 1) as f32;
        let (finer, coarser) = (level as usize, (level as usize + 1).min(levels.len() - 1));
        self.surroundings.intensity * levels[finer].at(direction).lerp(levels[coarser].at(direction), level.fract())
    }

    /// Diffuse light from everywhere, in units of what makes a white surface white; `None` where it does not shine.
    pub(crate) fn ambient(&self, normal: Vec3) -> Option<Vec3> {
        (self.surroundings.ambient == Part::Shown)
            .then(|| self.surroundings.intensity * self.environment.irradiance.at(self.environment_from_world * normal))
    }

    /// Radiance behind the model at a position of the picture, −1..1 right and up; `None` where it is not seen.
    pub(crate) fn background(&self, at: Vec2) -> Option<Vec3> {
        let direction = self.rays * at.extend(1.0);
        (self.surroundings.background == Part::Shown).then(|| self.radiance(direction, self.surroundings.blur))
    }

    /// Light that a surface sends to the eye if it also mirrors the environment (Schlick 1994; rough surfaces shine less at grazing
    /// angles).
    pub(crate) fn mirroring(&self, colour: Vec3, normal: Vec3, to_eye: Vec3) -> Vec3 {
        let Surroundings { reflectance: r, roughness, .. } = *self.surroundings;
        if r == 0.0 {
            return colour;
        }
        let grazing = (1.0 - normal.dot(to_eye).clamp(0.0, 1.0)).powi(5);
        let share = r + ((1.0 - roughness).max(r) - r) * grazing;
        let direction = self.environment_from_world * (-to_eye).reflect(normal);
        colour.lerp(self.radiance(direction, roughness), share)
    }
}

/// Direction to the sun of a generated environment, world space, and the light that a surface which faces it sends back.
pub(crate) fn sun(environment: Option<&Environment>, settings: &Settings) -> Option<(Vec3, Vec3)> {
    let (surroundings, sun) = (settings.environment.as_ref()?, environment?.sun?);
    let world_from_environment = surroundings.environment_from_world(&settings.camera).transpose();
    let radiance = surroundings.intensity / std::f32::consts::PI * sun.irradiance;
    Some((world_from_environment * sun.direction, radiance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Sphere;
    use crate::environment::cube::CubeMap;
    use crate::settings::camera::UpAxis;

    /// An environment whose radiance is the direction that it comes from.
    fn directions() -> Environment {
        Environment::new(CubeMap::from_fn(64, |d| 0.5 + 0.5 * d))
    }

    fn at_yaw_0(up: UpAxis, rotation: f32) -> Settings {
        Settings {
            camera: Camera { yaw: 0.0, pitch: 0.0, up, ..Camera::default() },
            environment: Some(Surroundings { rotation, reflectance: 1.0, roughness: 0.0, ..Surroundings::default() }),
            ..Settings::default()
        }
    }

    #[test]
    fn at_yaw_0_the_eye_looks_ahead_and_turns_go_to_the_right() {
        for up in [UpAxis::Y, UpAxis::Z] {
            for (rotation, expected) in [(0.0, Vec3::Z), (90.0, Vec3::NEG_X)] {
                let (environment, settings) = (directions(), at_yaw_0(up, rotation));
                let view = settings.camera.view(Sphere::default(), 1.5);
                let sampler = EnvironmentSampler::new(Some(&environment), &settings, &view, 1.5).unwrap();
                let found = sampler.background(Vec2::ZERO).unwrap();
                assert!(found.abs_diff_eq(0.5 + 0.5 * expected, 0.01), "{up:?} {rotation}: {found}");
                let (above, _) = settings.camera.axes();
                let found = sampler.background(Vec2::Y).unwrap();
                assert!(found.y > 0.6, "{up:?}: what is above is above: {found}");
                let lit = sampler.ambient(above).unwrap();
                assert!(lit.abs_diff_eq(Vec3::new(0.5, 0.5 + 1.0 / 3.0, 0.5), 0.01), "{up:?}: {lit}");
            }
        }
    }

    #[test]
    fn a_mirror_that_faces_the_eye_shows_what_is_behind_it() {
        let (environment, settings) = (directions(), at_yaw_0(UpAxis::Y, 0.0));
        let view = settings.camera.view(Sphere::default(), 1.0);
        let sampler = EnvironmentSampler::new(Some(&environment), &settings, &view, 1.0).unwrap();
        let seen = sampler.mirroring(Vec3::ZERO, Vec3::Z, Vec3::Z);
        assert!(seen.abs_diff_eq(Vec3::new(0.5, 0.5, 0.0), 0.01), "{seen}");
        let tilted = Vec3::new(1.0, 0.0, 1.0).normalize();
        let seen = sampler.mirroring(Vec3::ZERO, tilted, Vec3::Z);
        assert!(seen.abs_diff_eq(Vec3::new(1.0, 0.5, 0.5), 0.01), "{seen}");
    }
}
