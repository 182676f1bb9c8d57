//! The renderer on the CPU: the twin that every GPU picture is compared with, and what draws where there is no GPU.
//!
//! Two passes, as in a GPU's pipeline: the first finds the nearest triangle for every sample, the second
//! shades each sample once. Both run over bands of rows, and no sample depends on how bands are shared
//! out, so that the picture has the same bits on any number of threads.

mod clip;
mod lines;
mod raster;

use crate::camera::View;
use crate::colour::{linear_from_srgb, pixel_from_linear};
use crate::displaced::Displaced;
use crate::heat;
use crate::legend;
use crate::scene::Scene;
use crate::settings::{Settings, Shading};
use crate::shading::{Fragment, Light, Shader};
use crate::texture::{Footprint, Texture};
use crate::wedges::Wedges;
use glam::{DVec2, Vec2, Vec3, Vec4, Vec4Swizzles};
use image::RgbaImage;
use lines::Lines;
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
    let scalars = (settings.shading == Shading::Heat).then(|| heat::scalars(scene, settings.heat.source)).flatten();
    let picture = Picture::new(scene, settings, scalars.as_deref());
    let bands = picture.bands();
    let band_bytes = BAND_ROWS * settings.size.width as usize * 4;
    image.par_chunks_mut(band_bytes).zip(&bands).enumerate().for_each(|(band, (pixels, triangles))| {
        picture.draw(band * BAND_ROWS, triangles, pixels);
    });
    if let Some(range) = heat::range(scalars.as_deref(), settings) {
        let bar = legend::rectangles(settings.size, settings.heat.map, range, &settings.background);
        legend::draw(&mut image, &bar);
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
    settings: &'a Settings,
    shader: Shader<'a>,
    grid: Grid,
    wedges: Wedges,
    displaced: Displaced,
    /// Light at the wedges, in front and behind; for Gouraud shading only. #W
    light: Vec<[Light; 2]>,
    /// #W
    clip_positions: Vec<Vec4>,
    lines: Option<Lines>,
    /// Textures by the first triangle that has them.
    textures: Vec<(usize, Option<&'a Texture>)>,
    triangles: Vec<ScreenTriangle>,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene, settings: &'a Settings, scalars: Option<&[f32]>) -> Self {
        let view: View = settings.camera.view(scene.bounds(), settings.size.aspect());
        let samples = |pixels: u32| pixels as usize * settings.supersampling.max(1) as usize;
        let grid = Grid { width: samples(settings.size.width), height: samples(settings.size.height) };
        let mut wedges = Wedges::new(scene);
        wedges.set_scalars(scalars);
        let displaced = Displaced::new(scene, &wedges, settings);
        let clip_positions: Vec<Vec4> =
            displaced.positions.par_iter().map(|p| view.clip_from_world * p.extend(1.0)).collect();
        let triangles = wedges
            .triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, t)| {
                let corners = t.map(|w| clip_positions[w as usize]);
                clip::clip(corners).fan().filter_map(move |t| ScreenTriangle::new(t, i as u32, grid))
            })
            .collect();
        let shader = Shader::new(scene, settings, &view, scalars);
        let light = match settings.shading {
            Shading::Gouraud => {
                let vertices = displaced.positions.par_iter().zip(&displaced.normals);
                vertices.map(|(p, n)| shader.at_vertex(*p, n.normalize_or_zero())).collect()
            }
            _ => Vec::new(),
        };
        let textures = scene.groups().iter().map(|g| (g.triangles.start, scene.texture(g))).collect();
        let lines = Lines::new(settings, &wedges);
        Self { settings, shader, grid, wedges, displaced, light, clip_positions, lines, textures, triangles }
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
        if nearest.triangle as usize >= self.wedges.triangles.len() {
            let background = &self.settings.background;
            let down = (y as f32 + 0.5) / self.grid.height as f32;
            // Encoded values, because a gradient should be even to the eye.
            return background.top.encoded().lerp(background.bottom.encoded(), down).map(linear_from_srgb);
        }
        let triangle = nearest.triangle as usize;
        let colour = self.shader.shade(&self.fragment(triangle, x, y));
        let Some(lines) = &self.lines else { return colour };
        let clip_corners = self.wedges.triangles[triangle].map(|w| self.clip_positions[w as usize]);
        let weights = barycentric(clip_corners, self.grid.ndc_from_sample(x, y));
        let [dx, dy] = self.differences(x, y, |ndc| extrapolated(clip_corners, ndc).unwrap_or(weights));
        lines.over(colour, triangle, weights, dx, dy)
    }

    /// How a value changes to the sample on the right and to the one below: within a block of two by two samples, as
    /// GPUs take differences.
    fn differences<T: std::ops::Sub<Output = T>>(&self, x: usize, y: usize, at: impl Fn(DVec2) -> T) -> [T; 2] {
        let at = |x, y| at(self.grid.ndc_from_sample(x, y));
        [at(x | 1, y) - at(x & !1, y), at(x, y | 1) - at(x, y & !1)]
    }

    fn fragment(&self, triangle: usize, x: usize, y: usize) -> Fragment<'a> {
        let corners = self.wedges.triangles[triangle].map(|w| w as usize);
        let clip_corners = corners.map(|w| self.clip_positions[w]);
        let weights = barycentric(clip_corners, self.grid.ndc_from_sample(x, y));
        let positions = corners.map(|w| self.displaced.positions[w]);
        // In f32 the squared area of a small triangle underflows.
        let [a, b, c] = positions.map(Vec3::as_dvec3);
        let surfels = corners.map(|w| &self.wedges.surfels[w]);
        let stretch = blend(surfels.map(|s| s.stretch), weights);
        let uv_at = |weights| blend::<Vec2>(corners.map(|w| self.wedges.wedges[w].uv), weights);
        let group = self.textures.partition_point(|(first, _)| *first <= triangle) - 1;
        let texture = self.textures[group].1;
        let uv = (stretch.x >= 0.0).then(|| {
            let still = Footprint { uv: uv_at(weights), ..Footprint::default() };
            if texture.is_none() {
                return still;
            }
            let [dx, dy] =
                self.differences(x, y, |ndc| uv_at(extrapolated(clip_corners, ndc).unwrap_or(weights)));
            Footprint { dx, dy, ..still }
        });
        let scalar = blend(surfels.map(|s| s.scalar), weights);
        Fragment {
            position: blend(positions, weights),
            face_normal: (b - a).cross(c - a).normalize_or_zero().as_vec3(),
            normal: blend(corners.map(|w| self.displaced.normals[w]), weights),
            uv,
            tangent: blend(surfels.map(|s| s.tangent), weights),
            stretch,
            // Between numbers and none there is none.
            scalar: (scalar.y > 0.999).then_some(scalar.x),
            texture,
            light: match self.light.as_slice() {
                [] => [Light::default(); 2],
                light => [0, 1].map(|side| blend(corners.map(|w| light[w][side]), weights)),
            },
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

/// Weights of the corners at the surface point that is seen at `ndc` (perspective-correct); they add up to one.
fn barycentric(clip_corners: [Vec4; 3], ndc: DVec2) -> Vec3 {
    // Corners are rounded to the raster's grid, so a sample may lie outside by a hair.
    let inside = extrapolated(clip_corners, ndc).map(|weights| weights.max(Vec3::ZERO));
    let sum = inside.map_or(0.0, Vec3::element_sum);
    inside.filter(|_| sum.is_finite() && sum > 0.0).map_or(Vec3::splat(1.0 / 3.0), |weights| weights / sum)
}

/// The same for a point of the triangle's plane, inside or not; none where it is seen edge-on.
///
/// Marc Olano, Trey Greer. Triangle scan conversion using 2D homogeneous coordinates. 1997. With the
/// sample moved to the origin, Σ wᵢ (xᵢ, yᵢ) = 0 in clip space: each weight is a cross product of the other
/// two corners, and no corner needs to be in front of the eye.
fn extrapolated(clip_corners: [Vec4; 3], ndc: DVec2) -> Option<Vec3> {
    let [a, b, c] = clip_corners.map(|p| p.xy().as_dvec2() - f64::from(p.w) * ndc);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let sum: f64 = weights.iter().sum();
    Some(Vec3::from(weights.map(|w| (w / sum) as f32))).filter(|weights| weights.is_finite())
}

#[cfg(test)]
mod tests;
