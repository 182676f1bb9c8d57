//! Colour of a position on the surface, in linear light and world space. Twin of `shaders/light.wgsl` and
//! `shaders/mesh.wgsl`.
//!
//! James F. Blinn. Models of light reflection for computer synthesized pictures. SIGGRAPH 1977.

use super::shadows::ShadowMaps;
use crate::camera::View;
use crate::colour::linear_from_srgb;
use crate::displaced_mesh::DisplacementBinding;
use crate::draw_parameters::{LINE_WIDTH, heat_range, marble_frequency, normal_map_strength};
use crate::environment::sample::EnvironmentSampler;
use crate::ground::Disc;
use crate::lights::{WorldLight, world_lights};
use crate::marble::vein;
use crate::mesh::Side;
use crate::scene::Scene;
use crate::settings::ground::Show;
use crate::settings::{Overlay, Range, Sampling, Settings, Shading};
use crate::volume_rays::VolumeRays;
use glam::{Mat3, Vec2, Vec3, Vec4};
use planish_geometry::map::displacement::{SampleAt, Weights};
use planish_geometry::map::tangents::Tangent;
use planish_geometry::metrics::colormap::Colormap;

/// Attributes of the surface at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fragment {
    pub(crate) position: Vec3,
    /// Index of the triangle.
    pub(crate) triangle: u32,
    /// Unit normal of the triangle, outwards.
    pub(crate) face_normal: Vec3,
    /// Interpolated normal, outwards, not normalised.
    pub(crate) normal: Vec3,
    /// Interpolated tangent.
    pub(crate) tangent: Tangent,
    pub(crate) uv: Option<Vec2>,
    /// Change of uv from this sample to its neighbours.
    pub(crate) uv_steps: [Vec2; 2],
    /// ∂p/∂u and ∂p/∂v.
    pub(crate) along_uv: [Vec3; 2],
    /// Interpolated number of the scene's heat map.
    pub(crate) scalar: Option<f32>,
    /// Height of the map, model units.
    pub(crate) height: f32,
    /// Linear RGB blended between the corners, for Gouraud shading.
    pub(crate) lit: Vec3,
    /// Distances to the sides opposite the corners, samples.
    pub(crate) distances: Vec3,
    pub(crate) sides: [Side; 3],
    /// Fraction of the ambient light that arrives.
    pub(crate) open: f32,
}

/// Shader of a picture: everything that all its samples share.
pub(crate) struct Shader<'a> {
    scene: &'a Scene,
    pub(super) settings: &'a Settings,
    pub(super) eye: Vec4,
    up: Vec3,
    view_from_world: Mat3,
    pub(super) world_lights: Vec<WorldLight>,
    pub(super) volume: Option<VolumeRays<'a>>,
    sampler: Option<EnvironmentSampler<'a>>,
    shadows: Option<ShadowMaps>,
    heat: Option<(Colormap, Range)>,
    /// Map whose slope tilts the normals, and its lift in model units; none where the map is not sampled by texture coordinates.
    bumps: Option<(&'a DisplacementBinding, f32)>,
}

impl<'a> Shader<'a> {
    /// `positions`: #V×3, displaced.
    pub(crate) fn new(scene: &'a Scene, settings: &'a Settings, view: &View, aspect: f32, positions: &[Vec3]) -> Self {
        let world_lights = world_lights(scene, settings, view);
        let bumps = scene.displacement.as_ref().filter(|binding| binding.in_uv());
        Self {
            scene,
            settings,
            eye: view.eye_in_world,
            up: view.up_in_world,
            view_from_world: view.world_from_view.transpose(),
            shadows: ShadowMaps::new(scene, settings, view, &world_lights, positions),
            world_lights,
            volume: VolumeRays::new(scene, settings, view),
            sampler: EnvironmentSampler::new(scene.environment.as_ref(), settings, view, aspect),
            heat: heat_range(scene, settings).map(|range| (settings.heat.map, range)),
            bumps: bumps.map(|binding| (binding, binding.lift(&settings.displace))),
        }
    }

    /// Linear RGB towards the eye; may exceed 1. A triangle seen from behind is lit as if it were turned round.
    pub(crate) fn shade(&self, fragment: &Fragment) -> Vec3 {
        let to_eye = self.to_eye(fragment.position);
        let side = if fragment.face_normal.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let outwards = self.normal(fragment);
        let normal = side * outwards;
        let (position, open) = (fragment.position, fragment.open);
        let plain = self.settings.material.colour.linear();
        let colour = match self.settings.shading {
            Shading::Flat | Shading::Phong | Shading::Bump | Shading::NormalMap => {
                self.lit(plain, position, normal, open)
            }
            Shading::Gouraud => fragment.lit,
            Shading::Texture => self.lit(self.textured(fragment), position, normal, open),
            Shading::Clay => self.clay(plain, normal),
            Shading::Normals => (0.5 * outwards + 0.5).map(linear_from_srgb),
            Shading::Marble => {
                let vein = vein(marble_frequency(self.scene, self.settings) * position);
                self.lit(plain.lerp(self.settings.marble.colour.linear(), vein), position, normal, open)
            }
            Shading::Solid => {
                let solid = self.volume.as_ref().map_or(plain, |volume| volume.solid_colour(position));
                self.lit(solid, position, normal, open)
            }
            Shading::Checker => self.lit(self.checker(fragment), position, normal, open),
            Shading::Height | Shading::Heat => {
                let relief = self.settings.heat.relief;
                self.heat(fragment) * Vec3::ONE.lerp(self.irradiance(position, normal, open), relief)
            }
        };
        match self.settings.overlay {
            Overlay::None => colour,
            Overlay::Wireframe => colour.lerp(Vec3::new(0.02, 0.02, 0.025), self.line_cover(fragment)),
            Overlay::Seams => colour.lerp(Vec3::new(0.9, 0.2, 0.02), self.line_cover(fragment)),
        }
    }

    /// Linear RGB behind the model at a position of the picture, −1..1 right and up.
    pub(crate) fn background(&self, at: Vec2) -> Vec3 {
        let gradient = || {
            let background = &self.settings.background;
            // Encoded values, because a gradient should be even to the eye.
            background.top.encoded().lerp(background.bottom.encoded(), 0.5 - 0.5 * at.y).map(linear_from_srgb)
        };
        self.sampler.as_ref().and_then(|sampler| sampler.background(at)).unwrap_or_else(gradient)
    }

    pub(crate) fn to_eye(&self, position: Vec3) -> Vec3 {
        (self.eye.truncate() - self.eye.w * position).normalize_or_zero()
    }

    /// Unit normal of a fragment, outwards.
    fn normal(&self, fragment: &Fragment) -> Vec3 {
        let shading = self.settings.shading;
        if shading == Shading::Flat {
            return fragment.face_normal;
        }
        let strength = normal_map_strength(self.scene, self.settings);
        let normal_maps = &self.scene.normal_maps;
        let map = normal_maps.of_triangle(fragment.triangle as usize);
        if let (Some(map), Some(strength), Some(uv)) = (map, strength, fragment.uv) {
            let texel = 2.0 * normal_maps.all()[map as usize].at(uv, fragment.uv_steps, Sampling::Bilinear) - 1.0;
            let n = Vec3::Z.lerp(texel, strength);
            let [tangent, bitangent, normal] = fragment.tangent.frame(fragment.normal);
            return (n.x * tangent + n.y * bitangent + n.z * normal).normalize_or_zero();
        }
        let normal = fragment.normal.try_normalize().unwrap_or(fragment.face_normal);
        match (self.bumps, fragment.uv) {
            (Some((binding, lift)), Some(uv)) if shading == Shading::Bump => {
                bumped(binding, lift, uv, fragment.along_uv, normal)
            }
            _ => normal,
        }
    }

    /// Blinn-Phong: what is scattered evenly, plus highlights.
    pub(crate) fn lit(&self, base: Vec3, position: Vec3, normal: Vec3, open: f32) -> Vec3 {
        let material = &self.settings.material;
        let to_eye = self.to_eye(position);
        let highlight = |light: usize| {
            let (to_light, radiance) = self.incoming(light, position, normal);
            let half = (to_light + to_eye).normalize_or_zero();
            let facing = if normal.dot(to_light) > 0.0 { 1.0 } else { 0.0 };
            facing * normal.dot(half).max(0.0).powf(material.exponent) * radiance
        };
        let specular: Vec3 = (0..self.world_lights.len()).map(highlight).sum();
        let scattered = base * self.irradiance(position, normal, open);
        let mirroring = |sampler: &EnvironmentSampler| sampler.mirroring(scattered, normal, to_eye);
        self.sampler.as_ref().map_or(scattered, mirroring) + material.specular * specular
    }

    /// Unit vector to a light, and the part of it that arrives at a position on a surface.
    fn incoming(&self, light: usize, position: Vec3, normal: Vec3) -> (Vec3, Vec3) {
        let (to_light, radiance) = self.world_lights[light].incoming(position);
        match &self.shadows {
            Some(maps) if normal.dot(to_light) > 0.0 => {
                (to_light, radiance * maps.unshadowed(light, position, normal, to_light))
            }
            _ => (to_light, radiance),
        }
    }

    /// Light that arrives, in units of what makes a white surface white; `open` is the fraction of the ambient light that arrives.
    fn irradiance(&self, position: Vec3, normal: Vec3, open: f32) -> Vec3 {
        let lambert = |light: usize| {
            let (to_light, radiance) = self.incoming(light, position, normal);
            normal.dot(to_light).max(0.0) * radiance
        };
        open * self.ambient(normal) + (0..self.world_lights.len()).map(lambert).sum::<Vec3>()
    }

    /// Fraction of the ambient light that arrives, by the picture where there is one, else by the number of the vertices.
    pub(crate) fn open_at(&self, uv: Option<Vec2>, at_vertex: f32) -> f32 {
        let open = match (self.scene.occlusion_map(), uv) {
            (Some(map), Some(uv)) => map.at(uv, [Vec2::ZERO; 2], Sampling::Bilinear).x,
            _ => at_vertex,
        };
        1.0 + (open - 1.0) * self.settings.ambient.occlusion
    }

    /// Diffuse light from everywhere.
    pub(super) fn ambient(&self, normal: Vec3) -> Vec3 {
        let hemisphere = || {
            let ambient = &self.settings.ambient;
            let above = 0.5 + 0.5 * normal.dot(self.up);
            ambient.intensity * ambient.ground.linear().lerp(ambient.sky.linear(), above)
        };
        self.sampler.as_ref().and_then(|sampler| sampler.ambient(normal)).unwrap_or_else(hemisphere)
    }

    /// Blends the ground at `point` over the colour behind it.
    pub(crate) fn over_ground(&self, behind: Vec3, point: Vec3, ground: &Disc) -> Vec3 {
        let cover = ground.cover(point);
        let light = self.irradiance(point, ground.up, 1.0);
        if ground.show == Show::Plane {
            return behind.lerp(self.over_volume_to(ground.colour * light, point), cover);
        }
        let luma = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let open = |world_light: &WorldLight| {
            let (to_light, radiance) = world_light.incoming(point);
            ground.up.dot(to_light).max(0.0) * radiance
        };
        let open = self.ambient(ground.up) + self.world_lights.iter().map(open).sum::<Vec3>();
        let dark = cover * (1.0 - luma(light) / luma(open).max(1e-6));
        // What of the volume lies before the shadow is not darkened by it.
        behind.lerp(self.over_volume_to(Vec3::ZERO, point), dark)
    }

    /// Clay in a studio: depends on the normal as the eye sees it alone.
    fn clay(&self, base: Vec3, normal: Vec3) -> Vec3 {
        let n = self.view_from_world * normal;
        let key = n.dot(Vec3::new(-0.5, 0.6, 0.62).normalize()).max(0.0);
        let fill = n.dot(Vec3::new(0.8, 0.1, 0.6).normalize()).max(0.0);
        let top = 0.5 + 0.5 * n.y;
        let rim = (1.0 - n.z.clamp(0.0, 1.0)).powi(3);
        base * (0.05 + 0.75 * key + 0.16 * fill + 0.12 * top) + 0.06 * rim
    }

    fn textured(&self, fragment: &Fragment) -> Vec3 {
        let textures = &self.scene.textures;
        match (textures.of_triangle(fragment.triangle as usize), fragment.uv) {
            (Some(i), Some(uv)) => textures.all()[i as usize].at(uv, fragment.uv_steps, self.settings.sampling),
            _ => self.settings.material.colour.linear(),
        }
    }

    /// Colour of the chequered texture; the material's colour where there are no texture coordinates.
    fn checker(&self, fragment: &Fragment) -> Vec3 {
        let checker = &self.settings.checker;
        let Some(uv) = fragment.uv else { return self.settings.material.colour.linear() };
        let square = (uv * checker.squares).floor();
        let odd = (square.x + square.y).rem_euclid(2.0) == 1.0;
        if odd { checker.dark.linear() } else { checker.light.linear() }
    }

    /// Colour of a number in a heat map; the material's colour where there is none.
    fn heat(&self, fragment: &Fragment) -> Vec3 {
        let number = if self.settings.shading == Shading::Height { Some(fragment.height) } else { fragment.scalar };
        match (self.heat, number) {
            (Some((map, Range { low, high })), Some(x)) if x.is_finite() => {
                map.encoded((x - low) / (high - low)).map(linear_from_srgb)
            }
            _ => self.settings.material.colour.linear(),
        }
    }

    /// Fraction of a sample that a line along the sides of one kind covers.
    fn line_cover(&self, fragment: &Fragment) -> f32 {
        let drawn = |side: Side| match self.settings.overlay {
            Overlay::None => false,
            Overlay::Wireframe => side != Side::Diagonal,
            Overlay::Seams => side == Side::Seam,
        };
        // The side from corner k lies opposite the corner before it.
        let cover = |k: usize| {
            let width = LINE_WIDTH * self.settings.supersampling.max(1) as f32;
            (0.5 * width + 0.5 - fragment.distances[(k + 2) % 3]).clamp(0.0, 1.0)
        };
        (0..3).filter(|&k| drawn(fragment.sides[k])).map(cover).fold(0.0, f32::max)
    }
}

/// Normal under a height d over the surface: ∂p'/∂u × ∂p'/∂v with ∂p'/∂u = ∂p/∂u + ∂d/∂u n (Pharr, Jakob, Humphreys,
/// Physically Based Rendering, 3rd edition, section 9.3; the change of n itself is left out). `lift` is d at texel 1,
/// model units.
fn bumped(binding: &DisplacementBinding, lift: f32, uv: Vec2, [dp_du, dp_dv]: [Vec3; 2], normal: Vec3) -> Vec3 {
    let size = binding.map.size();
    let texel = 1.0 / Vec2::new(size.width as f32, size.height as f32);
    let at = |uv: Vec2| binding.map.texel_at(0, SampleAt::Uv(uv), Weights::Exact);
    let (across, up) = (Vec2::new(texel.x, 0.0), Vec2::new(0.0, texel.y));
    let slope = lift * 0.5 * Vec2::new(at(uv + across) - at(uv - across), at(uv + up) - at(uv - up)) / texel;
    let det = normal.dot(dp_du.cross(dp_dv));
    let n = det * normal + slope.x * normal.cross(dp_dv) + slope.y * dp_du.cross(normal);
    if det == 0.0 { normal } else { n.normalize_or_zero() * det.signum() }
}
