//! The renderer on the CPU: the twin that every GPU picture is compared with, and what draws where there is no GPU.
//!
//! Two passes, as in a GPU's pipeline: the first finds the nearest triangle for every sample, the second
//! shades each sample once. Both run over bands of rows, and no sample depends on how bands are shared
//! out, so that the picture has the same bits on any number of threads.
//!
//! ```
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::Obj};
//! use planish_render::settings::{Background, Settings, Size, camera::Camera};
//! use planish_render::{colour::Colour, input, software};
//!
//! // A square from the front, before black.
//! let model = Model::new(Obj::parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n".to_vec())?, Welding::Exact);
//! let scene = input::scene(&model, None)?;
//! let black = Colour::hex(0x00_00_00);
//! let settings = Settings {
//!     size: Size { width: 32, height: 24 },
//!     camera: Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() },
//!     background: Background { top: black, bottom: black },
//!     ..Settings::default()
//! };
//! let picture = software::render(&scene, &settings);
//! assert_eq!(picture.get_pixel(0, 0).0, [0, 0, 0, 255]);
//! assert!(picture.get_pixel(16, 12).0[0] > 100);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clip;
mod raster;
mod shading;
mod shadows;
mod volume;

use crate::camera::View;
use crate::colour::pixel_from_linear;
use crate::draw_parameters::{drawn_triangles, normal_map_strength};
use crate::ground::{self, Disc};
use crate::legend;
use crate::mesh::{Facing, Mesh, Triangle};
use crate::scene::Scene;
use crate::settings::{Normals, Settings, Shading};
use glam::{DVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use image::RgbaImage;
use planish_geometry::map::tangents::Tangent;
use raster::{Grid, ScreenTriangle};
use rayon::prelude::*;
use shading::{Fragment, Shader};
use std::borrow::Cow;

/// Rows of pixels that one task draws: enough to share out evenly, not so few that triangles are met often.
const BAND_ROWS: usize = 16;

/// Draws the scene. Settings that pass [`Settings::check`] are expected; others give a useless picture.
pub fn render(scene: &Scene, settings: &Settings) -> RgbaImage {
    let mut image = RgbaImage::new(settings.size.width, settings.size.height);
    if image.is_empty() {
        return image;
    }
    let picture = Picture::new(scene, settings);
    let bands = picture.bands();
    let band_bytes = BAND_ROWS * settings.size.width as usize * 4;
    image.par_chunks_mut(band_bytes).zip(&bands).enumerate().for_each(|(band, (pixels, triangles))| {
        picture.draw(band * BAND_ROWS, triangles, pixels);
    });
    legend::add(&mut image, scene, settings);
    image
}

/// Nearest triangle at a sample, and its depth.
#[derive(Clone, Copy)]
struct Nearest {
    depth: f32,
    /// Index into [`Mesh::triangles`]; out of range where there is none.
    triangle: u32,
}

struct Picture<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    settings: &'a Settings,
    shader: Shader<'a>,
    ground: Option<Disc>,
    grid: Grid,
    /// Displaced positions, #V×3.
    positions: Cow<'a, [Vec3]>,
    /// Vertex normals that replace those of the mesh, #V×3.
    vertex_normals: Option<Vec<Vec3>>,
    /// Heights of the map at the vertices, #V, model units; empty without a map.
    heights: Vec<f32>,
    /// Positions in clip space, #V×4.
    clip_positions: Vec<Vec4>,
    triangles: Vec<ScreenTriangle>,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene, settings: &'a Settings) -> Self {
        let aspect = settings.size.width as f32 / settings.size.height as f32;
        let view: View = ground::view(scene, settings, aspect);
        let samples = |pixels: u32| pixels as usize * settings.supersampling.max(1) as usize;
        let grid = Grid { width: samples(settings.size.width), height: samples(settings.size.height) };
        let mesh = scene.mesh();
        let displace = &settings.displace;
        // With bumps the slope of the heights is seen, and so the vertices stay.
        let moves = scene.displacement.as_ref().filter(|_| settings.shading != Shading::Bump);
        let positions = moves.map_or(Cow::Borrowed(&mesh.positions[..]), |binding| binding.displaced(displace).into());
        let vertex_normals = match &scene.displacement {
            Some(binding) if normal_map_strength(scene, settings).is_some() => {
                Some(binding.vertices.iter().map(|v| v.normal).collect())
            }
            _ => moves.filter(|_| displace.normals == Normals::Derived).map(|binding| binding.normals(&positions)),
        };
        let heights = scene.displacement.as_ref().map_or_else(Vec::new, |binding| binding.heights(displace));
        let clip_positions: Vec<Vec4> = positions.par_iter().map(|p| view.clip_from_world * p.extend(1.0)).collect();
        let triangles = drawn_triangles(scene, settings)
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, t)| {
                let corners = t.positions.map(|v| clip_positions[v as usize]);
                let is_drawn = t.facing == Facing::Both || raster::is_front(corners);
                let seen = is_drawn.then(|| clip::clip(corners).fan());
                seen.into_iter().flatten().filter_map(move |t| ScreenTriangle::new(t, i as u32, grid))
            })
            .collect();
        let shader = Shader::new(scene, settings, &view, aspect, &positions);
        let ground = Disc::new(scene, settings, &view);
        Self {
            scene,
            mesh,
            settings,
            shader,
            ground,
            grid,
            positions,
            vertex_normals,
            heights,
            clip_positions,
            triangles,
        }
    }

    /// Number of samples along a side of a pixel.
    fn supersampling(&self) -> usize {
        self.settings.supersampling.max(1) as usize
    }

    /// Lists, for each band, the triangles that touch it, in the order of the mesh.
    fn bands(&self) -> Vec<Vec<u32>> {
        let band_samples = BAND_ROWS * self.supersampling();
        let mut bands = vec![Vec::new(); self.grid.height.div_ceil(band_samples)];
        for (i, triangle) in self.triangles.iter().enumerate() {
            let rows = triangle.rows(self.grid);
            if !rows.is_empty() {
                for band in &mut bands[rows.start / band_samples..=(rows.end - 1) / band_samples] {
                    band.push(i as u32);
                }
            }
        }
        bands
    }

    /// Draws whole rows of pixels, from `first_row` on.
    fn draw(&self, first_row: usize, triangles: &[u32], pixels: &mut [u8]) {
        let per_side = self.supersampling();
        let pixel_rows = pixels.len() / (4 * self.settings.size.width as usize);
        let rows = first_row * per_side..(first_row + pixel_rows) * per_side;
        let nothing = Nearest { depth: f32::INFINITY, triangle: u32::MAX };
        let mut samples = vec![nothing; rows.len() * self.grid.width];
        for &i in triangles {
            let triangle = &self.triangles[i as usize];
            triangle.rasterise(self.grid, rows.clone(), |x, y, depth| {
                let sample = &mut samples[(y - rows.start) * self.grid.width + x];
                if depth < sample.depth {
                    *sample = Nearest { depth, triangle: triangle.source };
                }
            });
        }

        let width = self.settings.size.width as usize;
        let share = 1.0 / (per_side * per_side) as f32;
        for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
            let (column, row) = (i % width, i / width);
            let mut sum = Vec3::ZERO;
            for y in row * per_side..(row + 1) * per_side {
                for x in column * per_side..(column + 1) * per_side {
                    let nearest = samples[y * self.grid.width + x];
                    sum += self.colour(nearest, x, rows.start + y);
                }
            }
            let [r, g, b] = pixel_from_linear(share * sum);
            pixel.copy_from_slice(&[r, g, b, u8::MAX]);
        }
    }

    /// Linear RGB of a sample.
    fn colour(&self, nearest: Nearest, x: usize, y: usize) -> Vec3 {
        let ndc = self.grid.ndc_from_sample(x, y).as_vec2();
        let surface = match self.mesh.triangles.get(nearest.triangle as usize) {
            Some(triangle) => {
                let fragment = self.fragment(nearest.triangle, triangle, x, y);
                self.shader.over_volume_to(self.shader.shade(&fragment), fragment.position)
            }
            None => self.shader.over_volume_behind(self.shader.background(ndc), ndc),
        };
        let met = self.ground.as_ref().and_then(|ground| Some((ground, ground.meet(ndc, nearest.depth)?)));
        met.map_or(surface, |(ground, point)| self.shader.over_ground(surface, point, ground))
    }

    fn fragment(&self, index: u32, triangle: &Triangle, x: usize, y: usize) -> Fragment {
        let clip_corners = triangle.positions.map(|v| self.clip_positions[v as usize]);
        let weights_at = |x, y| plane_weights(clip_corners, self.grid.ndc_from_sample(x, y));
        let here = weights_at(x, y);
        let steps = [weights_at(x + 1, y) - here, weights_at(x, y + 1) - here];
        let weights = inside(here);
        let corners = triangle.positions.map(|v| self.positions[v as usize]);
        let normals = [0, 1, 2].map(|k| self.corner_normal(triangle, k));
        let uvs = triangle.uvs.map(|uvs| uvs.map(|uv| self.mesh.uvs[uv as usize]));
        // In f32 the squared area of a small triangle underflows.
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let face_normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let numbers = |numbers: &[f32]| blend(triangle.positions.map(|v| numbers[v as usize]), weights);
        let frames = self.mesh.tangents.get(index as usize);
        let opens = triangle.positions.map(|v| self.scene.open_at_vertex(v));
        let uv = uvs.map(|uvs| blend(uvs, weights));
        Fragment {
            position: blend(corners, weights),
            triangle: index,
            face_normal,
            normal: blend(normals, weights),
            tangent: frames.map_or(Tangent::default(), |frames| Tangent {
                tangent: blend(frames.map(|f| f.tangent), weights),
                sign: blend(frames.map(|f| f.sign), weights),
            }),
            uv,
            uv_steps: uvs.map_or([Vec2::ZERO; 2], |uvs| steps.map(|step| blend(uvs, step))),
            along_uv: uvs.map_or([Vec3::ZERO; 2], |uvs| along_uv(corners, uvs)),
            scalar: self.mesh.scalars.as_deref().map(numbers),
            height: if self.heights.is_empty() { 0.0 } else { numbers(&self.heights) },
            lit: self.gouraud(corners, normals, face_normal, (uvs, opens), weights),
            distances: weights / (steps[0].abs() + steps[1].abs()),
            sides: triangle.sides,
            open: self.shader.open_at(uv, blend(opens, weights)),
        }
    }

    /// Normal of a corner: of the displaced surface, or the one that a normal map is relative to, where the settings ask for it.
    fn corner_normal(&self, triangle: &Triangle, k: usize) -> Vec3 {
        let turned = if triangle.facing == Facing::Back { -1.0 } else { 1.0 };
        let special = self.vertex_normals.as_ref().map(|normals| turned * normals[triangle.positions[k] as usize]);
        special.filter(|n| *n != Vec3::ZERO).unwrap_or_else(|| self.mesh.normals[triangle.normals[k] as usize])
    }

    /// Colour of the lit corners, blended, linear RGB; zero unless the shading is Gouraud.
    fn gouraud(
        &self,
        corners: [Vec3; 3],
        normals: [Vec3; 3],
        face_normal: Vec3,
        (uvs, opens): (Option<[Vec2; 3]>, [f32; 3]),
        weights: Vec3,
    ) -> Vec3 {
        if self.settings.shading != Shading::Gouraud {
            return Vec3::ZERO;
        }
        let base = self.settings.material.colour.linear();
        let lit = |k: usize| {
            let side = if face_normal.dot(self.shader.to_eye(corners[k])) < 0.0 { -1.0 } else { 1.0 };
            let open = self.shader.open_at(uvs.map(|uvs| uvs[k]), opens[k]);
            self.shader.lit(base, corners[k], side * normals[k], open)
        };
        blend([0, 1, 2].map(lit), weights)
    }
}

/// ∂p/∂u and ∂p/∂v over a triangle, by Cramer's rule; zero where the texture has no area.
fn along_uv([a, b, c]: [Vec3; 3], uvs: [Vec2; 3]) -> [Vec3; 2] {
    let (b, c) = (b - a, c - a);
    let (s, t) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let area = s.perp_dot(t);
    let unit = if area == 0.0 { 0.0 } else { 1.0 / area };
    [(t.y * b - s.y * c) * unit, (s.x * c - t.x * b) * unit]
}

/// Σ wᵢ xᵢ
fn blend<T>([a, b, c]: [T; 3], weights: Vec3) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * weights.x + b * weights.y + c * weights.z
}

/// Weights of the corners at the point of a triangle's plane that is seen at `ndc` (perspective-correct).
///
/// Marc Olano, Trey Greer. Triangle scan conversion using 2D homogeneous coordinates. 1997. With the
/// sample moved to the origin, Σ wᵢ (xᵢ, yᵢ) = 0 in clip space: each weight is a cross product of the other
/// two corners, and no corner needs to be in front of the eye.
fn plane_weights(clip_corners: [Vec4; 3], ndc: DVec2) -> Vec3 {
    let [a, b, c] = clip_corners.map(|p| p.xy().as_dvec2() - f64::from(p.w) * ndc);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let sum: f64 = weights.iter().sum();
    Vec3::from(weights.map(|w| (w / sum) as f32))
}

/// Clamps the weights of a sample to its triangle: corners are rounded to the raster's grid, so it may lie outside by a hair.
fn inside(weights: Vec3) -> Vec3 {
    let weights = weights.max(Vec3::ZERO);
    let sum = weights.element_sum();
    if sum.is_finite() && sum > 0.0 { weights / sum } else { Vec3::splat(1.0 / 3.0) }
}

#[cfg(test)]
mod tests;
