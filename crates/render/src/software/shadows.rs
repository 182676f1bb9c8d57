//! Shadow maps on the processor. Twin of `shaders/shadow.wgsl`.

use super::clip;
use super::raster::{self, Grid, ScreenTriangle};
use crate::camera::View;
use crate::draw_parameters::drawn_triangles;
use crate::lights::WorldLight;
use crate::mesh::Triangle;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settings::shadow::{Casters, Filter, Outside, Shadow};
use crate::shadow::{self, Rays, ShadowView};
use glam::{Mat4, Vec2, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Shadow maps of all lights.
pub(crate) struct ShadowMaps {
    shadow: Shadow,
    size: usize,
    /// Slope-dependent bias, world units.
    slope_bias: f32,
    least_bias: f32,
    /// Shadow maps of each light.
    lights: Vec<Vec<Map>>,
}

struct Map {
    view: ShadowView,
    world_from_clip: Mat4,
    /// Depths, 0..1, row 0 on top.
    depths: Vec<f32>,
}

impl ShadowMaps {
    /// Draws the maps of a scene with vertices at `positions` (#V×3); none where nothing casts shadows.
    pub(crate) fn new(
        scene: &Scene,
        settings: &Settings,
        view: &View,
        world_lights: &[WorldLight],
        positions: &[Vec3],
    ) -> Option<Self> {
        let shadow = settings.shadow;
        if shadow.filter == Filter::None {
            return None;
        }
        let size = shadow.size as usize;
        let map = |view: ShadowView| Map {
            world_from_clip: view.clip_from_world.inverse(),
            depths: depths(drawn_triangles(scene, settings), positions, view.clip_from_world, size, shadow.casters),
            view,
        };
        let views = shadow::shadow_views(scene, settings, view, world_lights);
        let radius = scene.bounds().radius;
        Some(Self {
            shadow,
            size,
            slope_bias: shadow.slope_bias * radius,
            least_bias: shadow.least_bias * radius,
            lights: views.into_par_iter().map(|views| views.into_par_iter().map(map).collect()).collect(),
        })
    }

    /// Fraction of a light that arrives at a position with this unit normal: 0 in the umbra, 1 in the open.
    pub(crate) fn unshadowed(&self, light: usize, position: Vec3, normal: Vec3, to_light: Vec3) -> f32 {
        let maps = &self.lights[light];
        let map = if maps.len() == 6 { &maps[cube_face(-to_light)] } else { &maps[0] };
        let bias = (self.slope_bias * (1.0 - normal.dot(to_light))).max(self.least_bias);
        let position = position + bias * to_light;
        let clip = map.view.clip_from_world * position.extend(1.0);
        if clip.w <= 0.0 {
            return 1.0;
        }
        let ndc = clip.truncate() / clip.w;
        let uv = Vec2::new(0.5, -0.5) * ndc.truncate() + 0.5;
        let outside = uv.min_element() < 0.0 || uv.max_element() > 1.0 || ndc.z > 1.0;
        if self.shadow.outside == Outside::Lit && outside {
            return 1.0;
        }
        let texel = uv * self.size as f32;
        match self.shadow.filter {
            Filter::None => 1.0,
            Filter::Hard => self.open(map, texel, ndc.z),
            Filter::Pcf => self.percentage_closer(map, texel, ndc.z),
            Filter::Pcss => {
                let plane: Vec4 = map.world_from_clip.transpose() * normal.extend(-normal.dot(position));
                let steep = if plane.z.abs() < 1e-4 { -1e-4 } else { plane.z };
                let slope = (-plane.xy() / steep).clamp(Vec2::splat(-8.0), Vec2::splat(8.0)) * Vec2::new(2.0, -2.0);
                self.soft(map, uv, ndc.z, slope)
            }
        }
    }

    fn stored(&self, map: &Map, texel: Vec2) -> f32 {
        let size = self.size as i64;
        let inside = |t: f32| match self.shadow.outside {
            Outside::Lit => (t.floor() as i64).clamp(0, size - 1) as usize,
            Outside::Repeated => (t.floor() as i64).rem_euclid(size) as usize,
        };
        map.depths[inside(texel.y) * self.size + inside(texel.x)]
    }

    fn open(&self, map: &Map, texel: Vec2, depth: f32) -> f32 {
        if self.stored(map, texel) >= depth { 1.0 } else { 0.0 }
    }

    fn percentage_closer(&self, map: &Map, texel: Vec2, depth: f32) -> f32 {
        let low = (texel - 0.5).floor();
        let w = texel - 0.5 - low;
        let half = self.shadow.kernel as i32 / 2;
        let weight = |i: i32, w: f32| match i {
            _ if i == -half => 1.0 - w,
            _ if i == half + 1 => w,
            _ => 1.0,
        };
        let across = |j: i32| (-half..=half + 1).map(move |i| (i, j));
        let lit = (-half..=half + 1).flat_map(across).map(|(i, j)| {
            let at = low + 0.5 + Vec2::new(i as f32, j as f32);
            weight(i, w.x) * weight(j, w.y) * self.open(map, at, depth)
        });
        lit.sum::<f32>() / (self.shadow.kernel * self.shadow.kernel) as f32
    }

    fn soft(&self, map: &Map, uv: Vec2, depth: f32, slope: Vec2) -> f32 {
        const SEARCHES: u32 = 24;
        const SAMPLES: u32 = 48;
        let (view, size) = (&map.view, self.size as f32);
        let receiver = distance_from_depth(view, depth);
        let texel = (uv * size).floor();
        let rotation =
            std::f32::consts::TAU * fract(52.982_918 * fract(texel.dot(Vec2::new(0.067_110_56, 0.005_837_15))));
        let search = spread(view, receiver, view.near.max(0.25 * receiver)).max(1.0 / size);
        let (mut sum, mut count) = (0.0, 0.0);
        for offset in (0..SEARCHES).map(|i| search * disc(i, SEARCHES, rotation)) {
            let stored = self.stored(map, (uv + offset) * size);
            if stored < depth + slope.dot(offset) {
                sum += distance_from_depth(view, stored);
                count += 1.0;
            }
        }
        if count == 0.0 {
            return 1.0;
        }
        let penumbra = spread(view, receiver, (sum / count).min(receiver)).max(1.0 / size);
        let samples = (0..SAMPLES).map(|i| penumbra * disc(i, SAMPLES, rotation));
        let lit = samples.map(|offset| self.open(map, (uv + offset) * size, depth + slope.dot(offset)));
        lit.sum::<f32>() / SAMPLES as f32
    }
}

fn fract(x: f32) -> f32 {
    x - x.floor()
}

/// A point of a spiral that fills the unit disc evenly.
fn disc(i: u32, count: u32, rotation: f32) -> Vec2 {
    ((i as f32 + 0.5) / count as f32).sqrt() * Vec2::from_angle(2.399_963 * i as f32 + rotation)
}

/// Distance along the axis of a view, world units, from a depth.
fn distance_from_depth(view: &ShadowView, depth: f32) -> f32 {
    match view.rays {
        Rays::Parallel(_) => view.near + (view.far - view.near) * depth,
        Rays::Perspective(_) => view.near * view.far / (view.far - depth * (view.far - view.near)),
    }
}

/// Width of a light's disc in the map as seen through a pinhole at distance `blocker` from a position at distance `receiver`.
fn spread(view: &ShadowView, receiver: f32, blocker: f32) -> f32 {
    let shift = |half: f32| view.light_size * (receiver - blocker) / (2.0 * half);
    let spread = match view.rays {
        Rays::Parallel(half) => shift(half),
        Rays::Perspective(half) => shift(half) / (receiver * blocker),
    };
    spread.clamp(0.0, 0.15)
}

/// Index of the cube face that a direction meets: +x −x +y −y +z −z.
fn cube_face(d: Vec3) -> usize {
    let a = d.abs();
    if a.x >= a.y && a.x >= a.z {
        usize::from(d.x <= 0.0)
    } else if a.y >= a.z {
        2 + usize::from(d.y <= 0.0)
    } else {
        4 + usize::from(d.z <= 0.0)
    }
}

/// Nearest depth of each texel.
fn depths(
    triangles: &[Triangle],
    positions: &[Vec3],
    clip_from_world: Mat4,
    size: usize,
    casters: Casters,
) -> Vec<f32> {
    let grid = Grid { width: size, height: size };
    let clip_positions: Vec<Vec4> = positions.iter().map(|p| clip_from_world * p.extend(1.0)).collect();
    let mut depths = vec![1.0f32; size * size];
    for (triangle, source) in triangles.iter().zip(0..) {
        let corners = triangle.positions.map(|v| clip_positions[v as usize]);
        if casters == Casters::BackFaces && raster::is_front(corners) {
            continue;
        }
        for part in clip::clip(corners).fan().filter_map(|t| ScreenTriangle::new(t, source, grid)) {
            part.rasterise(grid, 0..size, |x, y, depth| {
                let texel = &mut depths[y * size + x];
                // What lies beyond the far plane is not in the map.
                *texel = if depth <= 1.0 { texel.min(depth) } else { *texel };
            });
        }
    }
    depths
}
