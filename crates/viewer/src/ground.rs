//! A plane under the model, for shadows to fall on.

use crate::camera::View;
use crate::colour::Colour;
use crate::lights::smoothstep;
use crate::scene::Scene;
use crate::settings::{Settings, SettingsError, named, require};
use crate::shadow::Floor;
use clap::ValueEnum;
use glam::{Mat4, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// A level disc under the model. It is not seen from below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ground {
    /// What is seen of it.
    pub show: Show,
    /// Its colour.
    pub colour: Colour,
    /// Below the lowest vertex of the mesh, in radii of the model's bounding sphere.
    pub gap: f32,
    /// Its radius, in radii of the bounding sphere; it fades out towards its rim.
    pub size: f32,
}

impl Default for Ground {
    fn default() -> Self {
        Self { show: Show::default(), colour: Colour::hex(0xc9c5bf), gap: 0.0, size: 4.0 }
    }
}

named! {
/// What is seen of the ground.
pub enum Show {
    /// Nothing; there is none.
    #[default]
    Nothing,
    /// A matte plane.
    Plane,
    /// The shadows alone, over the background.
    Shadows,
}
}

impl Ground {
    /// Refuses numbers that no ground can be drawn with.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(&[
            ((0.0..=10.0).contains(&self.gap), "ground.gap", "0..10"),
            ((0.1..=100.0).contains(&self.size), "ground.size", "0.1..100"),
        ])
    }
}

/// The ground of a picture. Twin of `Ground` in `shaders/ground.wgsl`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub(crate) centre: Vec3,
    pub(crate) radius: f32,
    /// Unit.
    pub(crate) up: Vec3,
    pub(crate) colour: Vec3,
    pub(crate) show: Show,
    clip_from_world: Mat4,
    world_from_clip: Mat4,
}

impl Disc {
    /// None where the settings want none.
    pub(crate) fn new(scene: &Scene, settings: &Settings, view: &View) -> Option<Self> {
        let Floor { up, height } = floor(scene, settings, view.up_in_world)?;
        let bounds = scene.bounds();
        Some(Self {
            centre: bounds.centre - height * up,
            radius: settings.ground.size * bounds.radius,
            up,
            colour: settings.ground.colour.linear(),
            show: settings.ground.show,
            clip_from_world: view.clip_from_world,
            world_from_clip: view.clip_from_world.inverse(),
        })
    }

    /// Where it is seen at a place of the picture, from above and nearer than `depth`.
    pub(crate) fn meet(&self, ndc: Vec2, depth: f32) -> Option<Vec3> {
        let [near, far] = [0.0, 1.0].map(|z| self.world_from_clip.project_point3(ndc.extend(z)));
        let (above, below) = ((near - self.centre).dot(self.up), (far - self.centre).dot(self.up));
        if above <= 0.0 || below >= 0.0 {
            return None;
        }
        let place = near.lerp(far, above / (above - below));
        (self.clip_from_world.project_point3(place).z < depth).then_some(place)
    }

    /// How much of it covers what lies behind; nothing from its rim on.
    pub(crate) fn cover(&self, place: Vec3) -> f32 {
        1.0 - smoothstep(0.45, 1.0, place.distance(self.centre) / self.radius)
    }
}

/// The eye of a picture: its view reaches around the displaced surface and to the rim of the ground.
pub(crate) fn view(scene: &Scene, settings: &Settings, aspect: f32) -> View {
    let (up, _) = settings.camera.axes();
    let bounds = scene.bounds();
    let rim = floor(scene, settings, up).map_or(0.0, |floor| floor.height.hypot(settings.ground.size * bounds.radius));
    settings.camera.view_reaching(bounds, aspect, rim.max(scene.displaced_bounds(settings).radius))
}

/// The plane on which the model stands; none where the settings want none.
pub(crate) fn floor(scene: &Scene, settings: &Settings, up: Vec3) -> Option<Floor> {
    let ground = settings.ground;
    let bounds = scene.bounds();
    let height = bounds.centre.dot(up) - scene.lowest(up) + ground.gap * bounds.radius;
    (ground.show != Show::Nothing).then_some(Floor { up, height })
}
