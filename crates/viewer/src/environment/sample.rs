//! What the settings say about an environment.

use super::Environment;
use super::file::Source;
use super::scenes;
use crate::camera::{Camera, Projection, View};
use crate::scene::Scene;
use crate::settings::{Settings, SettingsError, named, require};
use clap::ValueEnum;
use glam::{Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// An environment and what is seen of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Surroundings {
    /// Where it comes from.
    pub source: Source,
    /// Texels along a side of its cube map.
    pub resolution: u32,
    /// Turns it to the right about the up axis, degrees; at 0 its middle lies ahead of the eye at yaw 0.
    pub rotation: f32,
    /// Multiplies its light.
    pub intensity: f32,
    /// Behind the model; hidden, [`Settings::background`] is there.
    pub background: Part,
    /// How blurred the background is, 0..1.
    pub blur: f32,
    /// Its diffuse light; hidden, [`Settings::ambient`] shines.
    pub ambient: Part,
    /// How much the surface mirrors if looked at along its normal, 0..1; more at grazing angles (Schlick 1994).
    pub reflectance: f32,
    /// How blurred mirror images are, 0..1.
    pub roughness: f32,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self {
            source: Source::Scene(scenes::Scene::Desert),
            resolution: 512,
            rotation: 0.0,
            intensity: 1.0,
            background: Part::default(),
            blur: 0.0,
            ambient: Part::default(),
            reflectance: 0.0,
            roughness: 0.3,
        }
    }
}

named! {
/// Whether some part of an environment is there.
pub enum Part {
    /// It is.
    #[default]
    Shown,
    /// It is not.
    Hidden,
}
}

impl Surroundings {
    /// Refuses numbers that no picture can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        let share = |x: f32| (0.0..=1.0).contains(&x);
        require(&[
            ((16..=2048).contains(&self.resolution), "environment.resolution", "16..2048"),
            (self.rotation.is_finite(), "environment.rotation", "finite"),
            ((0.0..=1e3).contains(&self.intensity), "environment.intensity", "0..1000"),
            (share(self.blur), "environment.blur", "0..1"),
            (share(self.reflectance), "environment.reflectance", "0..1"),
            (share(self.roughness), "environment.roughness", "0..1"),
        ])
    }

    /// The environment's axes (right, up, ahead: left-handed) from those of the world.
    fn environment_from_world(&self, camera: &Camera) -> Mat3 {
        let (up, front) = camera.axes();
        let axes = Mat3::from_cols(up.cross(front), up, -front).transpose();
        Mat3::from_rotation_y(-self.rotation.to_radians()) * axes
    }
}

/// An environment as a picture asks it. Twin of `shaders/environment.wgsl`.
#[derive(Clone, Debug)]
pub(crate) struct Around<'a> {
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) environment: &'a Environment,
    pub(crate) environment_from_world: Mat3,
    /// Columns: to the right rim, the upper rim and the middle of the picture; in the environment.
    pub(crate) rays: Mat3,
}

impl<'a> Around<'a> {
    /// None where the settings want none, or the scene has none.
    pub(crate) fn new(scene: &'a Scene, settings: &'a Settings, view: &View, aspect: f32) -> Option<Self> {
        let (surroundings, environment) = (settings.environment.as_ref()?, scene.environment.as_ref()?);
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

    /// Diffuse light from everywhere, in units of what makes a white surface white; none where it does not shine.
    pub(crate) fn ambient(&self, normal: Vec3) -> Option<Vec3> {
        (self.surroundings.ambient == Part::Shown)
            .then(|| self.surroundings.intensity * self.environment.irradiance.at(self.environment_from_world * normal))
    }

    /// What is behind the model at a place of the picture, −1..1 right and up; none where it is not seen.
    pub(crate) fn background(&self, at: Vec2) -> Option<Vec3> {
        let direction = self.rays * at.extend(1.0);
        (self.surroundings.background == Part::Shown).then(|| self.radiance(direction, self.surroundings.blur))
    }

    /// What a surface sends to the eye if it also mirrors the environment (Schlick 1994; rough surfaces shine less at grazing
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

/// Direction to the sun of a scene's environment and the light that a surface which faces it sends back, world space.
pub(crate) fn sun(scene: &Scene, settings: &Settings) -> Option<(Vec3, Vec3)> {
    let (surroundings, sun) = (settings.environment.as_ref()?, scene.environment.as_ref()?.sun?);
    let world_from_environment = surroundings.environment_from_world(&settings.camera).transpose();
    let radiance = surroundings.intensity / std::f32::consts::PI * sun.irradiance;
    Some((world_from_environment * sun.direction, radiance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::UpAxis;
    use crate::environment::cube::CubeMap;
    use crate::scene::Mesh;

    /// Radiance is where it comes from.
    fn scene() -> Scene {
        let mut scene = Scene::new(Mesh::default()).unwrap();
        scene.environment = Some(Environment::new(CubeMap::from_fn(64, |d| 0.5 + 0.5 * d)));
        scene
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
                let (scene, settings) = (scene(), at_yaw_0(up, rotation));
                let view = settings.camera.view(scene.bounds(), 1.5);
                let around = Around::new(&scene, &settings, &view, 1.5).unwrap();
                let found = around.background(Vec2::ZERO).unwrap();
                assert!(found.abs_diff_eq(0.5 + 0.5 * expected, 0.01), "{up:?} {rotation}: {found}");
                let (above, _) = settings.camera.axes();
                let found = around.background(Vec2::Y).unwrap();
                assert!(found.y > 0.6, "{up:?}: what is above is above: {found}");
                let lit = around.ambient(above).unwrap();
                assert!(lit.abs_diff_eq(Vec3::new(0.5, 0.5 + 1.0 / 3.0, 0.5), 0.01), "{up:?}: {lit}");
            }
        }
    }

    #[test]
    fn a_mirror_that_faces_the_eye_shows_what_is_behind_it() {
        let (scene, settings) = (scene(), at_yaw_0(UpAxis::Y, 0.0));
        let view = settings.camera.view(scene.bounds(), 1.0);
        let around = Around::new(&scene, &settings, &view, 1.0).unwrap();
        let seen = around.mirroring(Vec3::ZERO, Vec3::Z, Vec3::Z);
        assert!(seen.abs_diff_eq(Vec3::new(0.5, 0.5, 0.0), 0.01), "{seen}");
        let tilted = Vec3::new(1.0, 0.0, 1.0).normalize();
        let seen = around.mirroring(Vec3::ZERO, tilted, Vec3::Z);
        assert!(seen.abs_diff_eq(Vec3::new(1.0, 0.5, 0.5), 0.01), "{seen}");
    }
}
