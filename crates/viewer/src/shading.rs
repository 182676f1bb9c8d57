//! From a place on the surface to its colour, in linear light and world space. Twin of `shaders/lighting.wgsl` and
//! `shaders/mesh.wgsl`.
//!
//! James F. Blinn. Models of light reflection for computer synthesized pictures. SIGGRAPH 1977.

mod clay;
mod tilt;

use crate::camera::View;
use crate::colormap::Colormap;
use crate::colour::linear_from_srgb;
use crate::heat;
use crate::lights::PlacedLight;
use crate::noise;
use crate::scene::{Scene, Sphere};
use crate::settings::{Normals, Pattern, Range, Settings, Shading};
use crate::texture::{Footprint, Texture};
use glam::{Mat3, Vec2, Vec3, Vec4};

/// What the rasteriser knows about the surface at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment<'a> {
    pub(crate) position: Vec3,
    /// Unit, of the triangle, outwards.
    pub(crate) face_normal: Vec3,
    /// Interpolated, outwards; its length is less than one between normals that differ.
    pub(crate) normal: Vec3,
    pub(crate) uv: Option<Footprint>,
    /// Tangent and the side on which the bitangent lies, interpolated.
    pub(crate) tangent: Vec4,
    /// Lengths of ∂p/∂u and ∂p/∂v.
    pub(crate) stretch: Vec2,
    pub(crate) scalar: Option<f32>,
    pub(crate) texture: Option<&'a Texture>,
    /// Light at the vertices, interpolated: in front and behind.
    pub(crate) light: [Light; 2],
}

/// Light that leaves a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Light {
    /// What is scattered evenly by a white surface.
    pub(crate) diffuse: Vec3,
    /// The highlight.
    pub(crate) specular: Vec3,
}

impl std::ops::Mul<f32> for Light {
    type Output = Self;
    fn mul(self, share: f32) -> Self {
        Self { diffuse: share * self.diffuse, specular: share * self.specular }
    }
}

impl std::ops::Add for Light {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { diffuse: self.diffuse + other.diffuse, specular: self.specular + other.specular }
    }
}

/// Everything that is the same for the whole picture.
#[derive(Debug)]
pub(crate) struct Shader<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    bounds: Sphere,
    eye: Vec4,
    up: Vec3,
    world_from_view: Mat3,
    lights: Vec<PlacedLight>,
    heat: Option<(Colormap, Range)>,
}

impl<'a> Shader<'a> {
    /// `scalars` are those of the heat map. #V
    pub(crate) fn new(scene: &'a Scene, settings: &'a Settings, view: &View, scalars: Option<&[f32]>) -> Self {
        let bounds = scene.bounds();
        Self {
            settings,
            scene,
            bounds,
            eye: view.eye_in_world,
            up: view.up_in_world,
            world_from_view: view.world_from_view,
            lights: settings.lights.iter().map(|light| light.place(view, bounds)).collect(),
            heat: heat::range(scalars, settings).map(|range| (settings.heat.map, range)),
        }
    }

    /// Linear RGB towards the eye; may exceed 1. A triangle seen from behind is lit as if it were turned round.
    pub(crate) fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        let to_eye = self.to_eye(fragment.position);
        let side = if fragment.face_normal.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let face_normal = side * fragment.face_normal;
        let outwards = self.normal(fragment);
        let normal = side * outwards;
        let heat = &self.settings.heat;
        let painted = |base: Vec3, light: Light| base * light.diffuse + light.specular;
        let lit = |base: Vec3| painted(base, self.lit(fragment.position, normal, to_eye));
        match self.settings.shading {
            Shading::Flat => painted(self.base(fragment), self.lit(fragment.position, face_normal, to_eye)),
            Shading::Gouraud => painted(self.base(fragment), fragment.light[usize::from(side < 0.0)]),
            Shading::BlinnPhong => lit(self.plain(fragment.position)),
            Shading::Texture | Shading::Bump | Shading::Displacement => lit(self.base(fragment)),
            Shading::Normals => (0.5 * outwards + 0.5).map(linear_from_srgb),
            Shading::Clay => clay::colour(self.settings.material.colour.linear(), self.world_from_view.transpose() * normal),
            Shading::Checker => lit(self.checker(fragment)),
            Shading::Heat => {
                let light = self.lit(fragment.position, normal, to_eye).diffuse;
                self.heat(fragment) * Vec3::ONE.lerp(light, heat.relief)
            }
        }
    }

    /// Light in front of and behind a vertex.
    pub(crate) fn at_vertex(&self, position: Vec3, normal: Vec3) -> [Light; 2] {
        let to_eye = self.to_eye(position);
        [normal, -normal].map(|n| self.lit(position, n, to_eye))
    }

    fn to_eye(&self, position: Vec3) -> Vec3 {
        (self.eye.truncate() - self.eye.w * position).normalize_or_zero()
    }

    /// Unit, outwards, with what maps do to it.
    fn normal(&self, fragment: &Fragment<'_>) -> Vec3 {
        let smooth = fragment.normal.try_normalize().unwrap_or(fragment.face_normal);
        let Some(uv) = fragment.uv.map(|footprint| footprint.uv) else { return smooth };
        let is_relief = matches!(self.settings.shading, Shading::Bump | Shading::Displacement);
        match (&self.scene.normal_map, &self.scene.relief) {
            (Some(map), _) if self.settings.map.normals == Normals::Map => {
                tilt::by_normal_map(map.texels.numbers_at(uv), fragment, smooth)
            }
            (_, Some(picture)) if is_relief => {
                let relief = &self.settings.relief;
                let height = relief.bump * relief.lambda * self.bounds.radius * relief.scale;
                tilt::by_heights(picture, uv, height, fragment, smooth)
            }
            _ => smooth,
        }
    }

    fn lit(&self, position: Vec3, normal: Vec3, to_eye: Vec3) -> Light {
        let ambient = &self.settings.ambient;
        let above = 0.5 + 0.5 * normal.dot(self.up);
        let hemisphere = ambient.ground.linear().lerp(ambient.sky.linear(), above);
        let mut sum = Light { diffuse: ambient.intensity * hemisphere, specular: Vec3::ZERO };
        for light in &self.lights {
            let (towards, arriving) = light.at(position);
            let facing = normal.dot(towards);
            sum.diffuse += facing.max(0.0) * arriving;
            if facing > 0.0 {
                let half_way = (towards + to_eye).normalize_or_zero();
                sum.specular += normal.dot(half_way).max(0.0).powf(self.settings.material.exponent) * arriving;
            }
        }
        sum.specular *= self.settings.material.specular;
        sum
    }

    /// Base colour from the texture, or else the material's.
    fn base(&self, fragment: &Fragment<'_>) -> Vec3 {
        match (fragment.texture, fragment.uv) {
            (Some(texture), Some(footprint)) => texture.colour_at(footprint, self.settings.sampling),
            _ => self.plain(fragment.position),
        }
    }

    /// The material's, with or without veins.
    fn plain(&self, position: Vec3) -> Vec3 {
        let material = &self.settings.material;
        match material.pattern {
            Pattern::Plain => material.colour.linear(),
            Pattern::Noise { frequency, colour } => {
                let p = (0.5 * frequency / self.bounds.radius) * (position - self.bounds.centre);
                material.colour.linear().lerp(colour.linear(), noise::vein(p))
            }
        }
    }

    /// Where there are no texture coordinates there are no squares.
    fn checker(&self, fragment: &Fragment<'_>) -> Vec3 {
        let checker = &self.settings.checker;
        let Some(footprint) = fragment.uv else { return self.plain(fragment.position) };
        let square = (footprint.uv * checker.squares).floor();
        let odd = (square.x + square.y).rem_euclid(2.0) == 1.0;
        if odd { checker.dark.linear() } else { checker.light.linear() }
    }

    /// What has no number keeps the material's colour.
    fn heat(&self, fragment: &Fragment<'_>) -> Vec3 {
        match (self.heat, fragment.scalar) {
            (Some((map, Range { low, high })), Some(x)) => map.at((x - low) / (high - low)),
            _ => self.settings.material.colour.linear(),
        }
    }
}
