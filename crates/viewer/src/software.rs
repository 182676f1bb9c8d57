//! The renderer on the CPU: the twin that every GPU picture is compared with, and what draws where there is no GPU.
//!
//! Two passes, as in a GPU's pipeline: the first finds the nearest triangle for every sample, the second
//! shades each sample once. Both run over bands of rows, and no sample depends on how bands are shared
//! out, so that the picture has the same bits on any number of threads.

mod clip;
mod legend;
mod raster;

use crate::camera::View;
use crate::colour::{linear_from_srgb, pixel_from_linear};
use crate::scene::{Mesh, Scene, Triangle};
use crate::settings::{Settings, Shading};
use crate::shading::{Fragment, Shader, heat_range};
use glam::{DVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use image::RgbaImage;
use raster::{Grid, ScreenTriangle};
use rayon::prelude::*;

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
    if let (Shading::Heat, Some(range)) = (settings.shading, heat_range(scene, settings)) {
        legend::draw(&mut image, settings.heat.map, range);
    }
    image
}

/// What lies nearest at a sample.
#[derive(Clone, Copy)]
struct Nearest {
    depth: f32,
    /// Into [`Mesh::triangles`].
    triangle: u32,
}

struct Picture<'a> {
    mesh: &'a Mesh,
    settings: &'a Settings,
    shader: Shader<'a>,
    grid: Grid,
    /// #V
    clip_positions: Vec<Vec4>,
    triangles: Vec<ScreenTriangle>,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene, settings: &'a Settings) -> Self {
        let aspect = settings.size.width as f32 / settings.size.height as f32;
        let view: View = settings.camera.view(scene.bounds(), aspect);
        let samples = |pixels: u32| pixels as usize * settings.supersampling.max(1) as usize;
        let grid = Grid { width: samples(settings.size.width), height: samples(settings.size.height) };
        let mesh = scene.mesh();
        let clip_positions: Vec<Vec4> =
            mesh.positions.par_iter().map(|p| view.clip_from_world * p.extend(1.0)).collect();
        let triangles = mesh
            .triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, t)| {
                let corners = t.positions.map(|v| clip_positions[v as usize]);
                clip::clip(corners).fan().filter_map(move |t| ScreenTriangle::new(t, i as u32, grid))
            })
            .collect();
        let shader = Shader::new(scene, settings, &view);
        Self { mesh, settings, shader, grid, clip_positions, triangles }
    }

    /// Samples along a side of a pixel.
    fn supersampling(&self) -> usize {
        self.settings.supersampling.max(1) as usize
    }

    /// For each band the triangles that touch it, in the mesh's order.
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
        let Some(triangle) = self.mesh.triangles.get(nearest.triangle as usize) else {
            let background = &self.settings.background;
            let down = (y as f32 + 0.5) / self.grid.height as f32;
            // Encoded values, because a gradient should be even to the eye.
            return background.top.encoded().lerp(background.bottom.encoded(), down).map(linear_from_srgb);
        };
        self.shader.shade(&self.fragment(triangle, self.grid.ndc_from_sample(x, y)))
    }

    fn fragment(&self, triangle: &Triangle, ndc: DVec2) -> Fragment {
        let weights = barycentric(triangle.positions.map(|v| self.clip_positions[v as usize]), ndc);
        let corners = triangle.positions.map(|v| self.mesh.positions[v as usize]);
        let normals = triangle.normals.map(|n| self.mesh.normals[n as usize]);
        // In f32 the squared area of a small triangle underflows.
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let face_normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        Fragment {
            position: blend(corners, weights),
            face_normal,
            normal: blend(normals, weights).try_normalize().unwrap_or(face_normal),
            uv: triangle.uvs.map(|uvs| blend::<Vec2>(uvs.map(|uv| self.mesh.uvs[uv as usize]), weights)),
            scalar: self
                .mesh
                .scalars
                .as_ref()
                .map(|scalars| blend(triangle.positions.map(|v| scalars[v as usize]), weights)),
        }
    }
}

/// Σ wᵢ xᵢ
fn blend<T>([a, b, c]: [T; 3], weights: Vec3) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    a * weights.x + b * weights.y + c * weights.z
}

/// Weights of the corners at the surface point that is seen at `ndc` (perspective-correct).
///
/// Marc Olano, Trey Greer. Triangle scan conversion using 2D homogeneous coordinates. 1997. With the
/// sample moved to the origin, Σ wᵢ (xᵢ, yᵢ) = 0 in clip space: each weight is a cross product of the other
/// two corners, and no corner needs to be in front of the eye.
fn barycentric(clip_corners: [Vec4; 3], ndc: DVec2) -> Vec3 {
    let [a, b, c] = clip_corners.map(|p| p.xy().as_dvec2() - f64::from(p.w) * ndc);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let sum: f64 = weights.iter().sum();
    // Corners are rounded to the raster's grid, so a sample may lie outside by a hair.
    let weights = Vec3::from(weights.map(|w| (w / sum).max(0.0) as f32));
    let sum = weights.element_sum();
    if sum.is_finite() && sum > 0.0 { weights / sum } else { Vec3::splat(1.0 / 3.0) }
}

#[cfg(test)]
mod tests;
