//! A plane under the model, for shadows to fall on.

use crate::camera::View;
use crate::draw_parameters::reach;
use crate::lights::smoothstep;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::ground::Show;
use glam::{Mat4, Vec2, Vec3};

/// A level plane under the model, for shadows to fall on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Floor {
    /// Unit normal, away from the model's bottom.
    pub(crate) up: Vec3,
    /// Distance from the plane to the middle of the model.
    pub(crate) height: f32,
}

/// The ground of a picture. Twin of `Ground` in `shaders/ground.wgsl`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    /// Centre of the disc, world space.
    pub(crate) centre: Vec3,
    /// Radius of the disc, world units.
    pub(crate) radius: f32,
    /// Unit normal of the disc.
    pub(crate) up: Vec3,
    /// Colour of the disc, linear RGB.
    pub(crate) colour: Vec3,
    /// Part of the ground that is drawn.
    pub(crate) show: Show,
    clip_from_world: Mat4,
    world_from_clip: Mat4,
}

impl Disc {
    /// The disc of a scene; `None` where the settings want none.
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

    /// Point of the disc's plane that is seen at a position of the picture, from above and nearer than `depth`.
    pub(crate) fn meet(&self, ndc: Vec2, depth: f32) -> Option<Vec3> {
        let [near, far] = [0.0, 1.0].map(|z| self.world_from_clip.project_point3(ndc.extend(z)));
        let (above, below) = ((near - self.centre).dot(self.up), (far - self.centre).dot(self.up));
        if above <= 0.0 || below >= 0.0 {
            return None;
        }
        let point = near.lerp(far, above / (above - below));
        (self.clip_from_world.project_point3(point).z < depth).then_some(point)
    }

    /// Opacity of the disc at a point of its plane, 0..1; it is 0 from the edge on.
    pub(crate) fn cover(&self, point: Vec3) -> f32 {
        1.0 - smoothstep(0.45, 1.0, point.distance(self.centre) / self.radius)
    }
}

/// The eye of a picture: its view reaches around the displaced surface and to the edge of the ground.
pub(crate) fn view(scene: &Scene, settings: &Settings, aspect: f32) -> View {
    let (up, _) = settings.camera.axes();
    let bounds = scene.bounds();
    let edge = floor(scene, settings, up).map_or(0.0, |floor| floor.height.hypot(settings.ground.size * bounds.radius));
    settings.camera.view_reaching(bounds, aspect, edge.max(scene.displaced_bounds(reach(scene, settings)).radius))
}

/// The plane on which the model stands; `None` where the settings want none.
pub(crate) fn floor(scene: &Scene, settings: &Settings, up: Vec3) -> Option<Floor> {
    let ground = settings.ground;
    let bounds = scene.bounds();
    let height = bounds.centre.dot(up) - scene.lowest(up) + ground.gap * bounds.radius;
    (ground.show != Show::Nothing).then_some(Floor { up, height })
}
