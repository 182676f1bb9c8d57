//! From a place on the surface to its colour, in linear light and world space.
//!
//! James F. Blinn. Models of light reflection for computer synthesized pictures. SIGGRAPH 1977.

use crate::camera::View;
use crate::colour::linear_from_srgb;
use crate::lights::Light;
use crate::scene::Scene;
use crate::settings::{Range, Settings, Shading};
use crate::texture::Texture;
use glam::{Vec2, Vec3, Vec4};
use planish_geometry::colormap::Colormap;

/// What the rasteriser knows about the surface at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment {
    pub(crate) position: Vec3,
    /// Unit, of the triangle, outwards.
    pub(crate) face_normal: Vec3,
    /// Unit, interpolated, outwards.
    pub(crate) normal: Vec3,
    pub(crate) uv: Option<Vec2>,
    pub(crate) scalar: Option<f32>,
}

/// Everything that is the same for the whole picture.
#[derive(Debug)]
pub(crate) struct Shader<'a> {
    settings: &'a Settings,
    texture: Option<&'a Texture>,
    eye: Vec4,
    up: Vec3,
    /// Direction to the light and its radiance.
    lights: Vec<(Vec3, Vec3)>,
    heat: Option<(Colormap, Range)>,
}

impl<'a> Shader<'a> {
    pub(crate) fn new(scene: &'a Scene, settings: &'a Settings, view: &View) -> Self {
        let light = |l: &Light| (l.direction_in_world(view), l.radiance());
        Self {
            settings,
            texture: scene.texture.as_ref(),
            eye: view.eye_in_world,
            up: view.up_in_world,
            lights: settings.lights.iter().map(light).collect(),
            heat: heat_range(scene, settings).map(|range| (settings.heat.map, range)),
        }
    }

    /// Linear RGB towards the eye; may exceed 1. A triangle seen from behind is lit as if it were turned round.
    pub(crate) fn shade(&self, fragment: &Fragment) -> Vec3 {
        let to_eye = (self.eye.truncate() - self.eye.w * fragment.position).normalize_or_zero();
        let side = if fragment.face_normal.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let (face_normal, normal) = (side * fragment.face_normal, side * fragment.normal);
        let heat = &self.settings.heat;
        match self.settings.shading {
            Shading::Flat => self.lit(self.base(fragment), face_normal, to_eye),
            Shading::Smooth => self.lit(self.base(fragment), normal, to_eye),
            Shading::Normals => (0.5 * fragment.normal + 0.5).map(linear_from_srgb),
            Shading::Checker => self.lit(self.checker(fragment), normal, to_eye),
            Shading::Heat => self.heat(fragment) * Vec3::ONE.lerp(self.irradiance(normal), heat.relief),
        }
    }

    /// Blinn-Phong: what is scattered evenly, plus highlights.
    fn lit(&self, base: Vec3, normal: Vec3, to_eye: Vec3) -> Vec3 {
        let material = &self.settings.material;
        let highlight = |&(to_light, radiance): &(Vec3, Vec3)| {
            let half = (to_light + to_eye).normalize_or_zero();
            let facing = if normal.dot(to_light) > 0.0 { 1.0 } else { 0.0 };
            facing * normal.dot(half).max(0.0).powf(material.exponent) * radiance
        };
        let specular: Vec3 = self.lights.iter().map(highlight).sum();
        base * self.irradiance(normal) + material.specular * specular
    }

    /// Light that arrives, in units of what makes a white surface white.
    fn irradiance(&self, normal: Vec3) -> Vec3 {
        let ambient = &self.settings.ambient;
        let above = 0.5 + 0.5 * normal.dot(self.up);
        let hemisphere = ambient.ground.linear().lerp(ambient.sky.linear(), above);
        let lambert = |&(to_light, radiance): &(Vec3, Vec3)| normal.dot(to_light).max(0.0) * radiance;
        ambient.intensity * hemisphere + self.lights.iter().map(lambert).sum::<Vec3>()
    }

    fn base(&self, fragment: &Fragment) -> Vec3 {
        match (self.texture, fragment.uv) {
            (Some(texture), Some(uv)) => texture.at(uv),
            _ => self.settings.material.colour.linear(),
        }
    }

    /// Where there are no texture coordinates there are no squares.
    fn checker(&self, fragment: &Fragment) -> Vec3 {
        let checker = &self.settings.checker;
        let Some(uv) = fragment.uv else { return self.settings.material.colour.linear() };
        let square = (uv * checker.squares).floor();
        let odd = (square.x + square.y).rem_euclid(2.0) == 1.0;
        if odd { checker.dark.linear() } else { checker.light.linear() }
    }

    /// What has no number keeps the material's colour.
    fn heat(&self, fragment: &Fragment) -> Vec3 {
        match (self.heat, fragment.scalar) {
            (Some((map, Range { low, high })), Some(x)) if x.is_finite() => {
                map.encoded((x - low) / (high - low)).map(linear_from_srgb)
            }
            _ => self.settings.material.colour.linear(),
        }
    }
}

/// Which numbers the ends of the colour map stand for; none if the scene has no numbers.
pub(crate) fn heat_range(scene: &Scene, settings: &Settings) -> Option<Range> {
    let scalars = scene.mesh().scalars.as_ref()?;
    if settings.heat.range.is_some() {
        return settings.heat.range;
    }
    let finite = || scalars.iter().copied().filter(|x| x.is_finite());
    let low = finite().reduce(f32::min)?;
    let high = finite().reduce(f32::max)?;
    let range = match settings.heat.map {
        Colormap::Diverging => {
            let most = high.abs().max(low.abs());
            Range { low: -most, high: most }
        }
        Colormap::Sequential => Range { low, high },
    };
    // Numbers that are all the same still need a range with some width.
    let slack = if range.low < range.high { 0.0 } else { range.high.abs().max(1.0) };
    Some(Range { low: range.low - slack, high: range.high + slack })
}
