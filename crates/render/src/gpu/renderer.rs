//! Draws a [`Scene`] with [`Settings`] on a GPU, to any texture view; it knows no window.
//!
//! ```no_run
//! # fn f(scene: planish_render::scene::Scene) -> Result<(), planish_render::gpu::NoGpu> {
//! use planish_render::gpu::{Backend, Gpu};
//! use planish_render::gpu::renderer::Renderer;
//! use planish_render::settings::Settings;
//!
//! let renderer = Renderer::new(Gpu::open(Backend::Auto)?);
//! let picture = renderer.image(&scene, &Settings::default())?;
//! # Ok(()) }
//! ```

mod bind_groups;
mod frame;
mod gpu_scene;
mod lighting;
mod pipelines;
mod targets;

pub use gpu_scene::GpuScene;

use crate::colour::{linear_from_byte, pixel_from_linear};
use crate::draw_parameters::{derives_normals, mesh_visibility};
use crate::gpu::{DEPTH, FORMAT, Gpu, NoGpu};
use crate::legend;
use crate::scene::{Scene, SceneError};
use crate::settings::environment::Part;
use crate::settings::{Displace, Settings, Size};
use bind_groups::Layouts;
use frame::Picture;
use glam::{Vec3, Vec4};
use image::RgbaImage;
use lighting::Lighting;
use pipelines::Pipelines;
use rayon::prelude::*;
use targets::Samplers;

/// Renderer on a GPU: device, layouts and compiled programs, which all scenes share.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    layouts: Layouts,
    samplers: Samplers,
    /// Pipelines for targets with one sample per pixel, and with several.
    pipelines: [Pipelines; 2],
    compute: pipelines::Compute,
    casting: pipelines::Casting,
    shadow_maps: lighting::Cache,
}

/// Buffers that a picture of some size is drawn in.
#[derive(Debug)]
pub struct Target {
    size: Size,
    samples: u32,
    depth: wgpu::TextureView,
    /// Multisampled colour that is resolved in the end; none with one sample per pixel.
    colour: Option<wgpu::TextureView>,
}

impl Target {
    /// Begins a pass that draws to a view of the target's size.
    fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder, view: &wgpu::TextureView) -> wgpu::RenderPass<'a> {
        let (attachment, resolve_target) = match &self.colour {
            Some(colour) => (colour, Some(view)),
            None => (view, None),
        };
        let colour = wgpu::RenderPassColorAttachment {
            view: attachment,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(colour)],
            depth_stencil_attachment: Some(depth),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}

impl Renderer {
    /// Compiles the shaders on a device.
    pub fn new(gpu: Gpu) -> Self {
        let layouts = Layouts::new(&gpu.device);
        let pipelines = [1, gpu.samples].map(|samples| Pipelines::new(&gpu.device, &layouts, samples));
        let compute = pipelines::Compute::new(&gpu.device, &layouts);
        let casting = pipelines::Casting::new(&gpu.device, &layouts);
        let samplers = Samplers::new(&gpu.device);
        Self { samplers, layouts, pipelines, compute, casting, shadow_maps: <_>::default(), gpu }
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Copies a scene to the device.
    pub fn upload(&self, scene: &Scene) -> Result<GpuScene, NoGpu> {
        GpuScene::new(&self.gpu, &self.layouts, scene)
    }

    /// Replaces the numbers of the vertices of a scene that was uploaded, for heat maps, while the scene itself stays as it is.
    pub fn set_scalars(&self, gpu_scene: &GpuScene, scene: &Scene, scalars: &[f32]) -> Result<(), SceneError> {
        let (found, expected) = (scalars.len(), scene.mesh().positions.len());
        if found != expected {
            return Err(SceneError::ScalarCount { found, expected });
        }
        gpu_scene.set_scalars(&self.gpu, scene, scalars);
        Ok(())
    }

    /// Buffers for pictures of a size, with as many samples per pixel as `smooth` edges take, or with one.
    pub fn target(&self, size: Size, smooth: Smoothness) -> Target {
        let samples = if smooth == Smoothness::OneSample { 1 } else { self.gpu.samples };
        let texture = |format| targets::attachment(&self.gpu.device, size, samples, format);
        Target { size, samples, depth: texture(DEPTH), colour: (samples > 1).then(|| texture(FORMAT)) }
    }

    /// A texture of format [`FORMAT`] that can be drawn to and copied from.
    pub fn canvas(&self, size: Size) -> wgpu::Texture {
        targets::canvas(&self.gpu.device, size)
    }

    /// Draws to a view of format [`FORMAT`] and of the target's size; `settings.size` does not matter.
    pub fn draw(
        &self,
        gpu_scene: &GpuScene,
        scene: &Scene,
        settings: &Settings,
        target: &Target,
        view: &wgpu::TextureView,
    ) {
        let picture = Picture::new(scene, settings, target.size);
        let frame = frame::frame(&picture, self.scale(settings, target));
        self.gpu.queue.write_buffer(&gpu_scene.frame, 0, bytemuck::bytes_of(&frame));
        self.write_displacement(gpu_scene, scene, &settings.displace);
        let lighting = Lighting::new(&self.gpu, &self.layouts, &self.shadow_maps, gpu_scene, &picture);
        let mesh = mesh_visibility(scene, settings);
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if derives_normals(scene, settings) {
            self.compute.run(&mut encoder, gpu_scene, pipelines::Result::Normals);
        }
        self.casting.run(&mut encoder, gpu_scene, &lighting, settings.shadow.casters, mesh);
        let mut pass = target.begin(&mut encoder, view);
        let pipelines = &self.pipelines[usize::from(target.samples > 1)];
        pass.set_bind_group(0, &lighting.frame_bindings, &[]);
        if lighting.shows_map {
            pass.set_pipeline(&pipelines.shadow_view);
            pass.draw(0..3, 0..1);
        } else {
            let volume = frame::volume_display(scene, settings);
            pass.set_pipeline(&pipelines.background(&self.gpu.device, &self.layouts, volume));
            pass.draw(0..3, 0..1);
            let variant = frame::variant(scene, settings);
            let surface = pipelines.surface(&self.gpu.device, &self.layouts, variant);
            if mesh == Part::Shown {
                let outer_side = gpu_scene.runs.iter().any(|run| run.look.one_sided);
                let outer_side = outer_side.then(|| pipelines.outer_side(&self.gpu.device, &self.layouts, variant));
                let outer_side = outer_side.as_ref().unwrap_or(&surface.mesh);
                self.draw_surface(&mut pass, [&surface.mesh, outer_side], gpu_scene, settings);
            }
            // Last, because its rim lets the background through.
            if lighting.has_ground {
                pass.set_pipeline(&surface.ground);
                pass.draw(0..4, 0..1);
            }
        }
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Draws the mesh, look by look, with the pipelines for triangles of which both sides or the outer one alone are drawn.
    fn draw_surface(
        &self,
        pass: &mut wgpu::RenderPass,
        pipelines: [&wgpu::RenderPipeline; 2],
        gpu_scene: &GpuScene,
        settings: &Settings,
    ) {
        pass.set_bind_group(1, &gpu_scene.map_bindings, &[]);
        pass.set_bind_group(2, &gpu_scene.surface_bindings, &[]);
        for run in &gpu_scene.runs {
            let textures = gpu_scene.texture_bindings(&self.gpu.device, &self.layouts, &self.samplers, settings, run);
            pass.set_pipeline(pipelines[usize::from(run.look.one_sided)]);
            pass.set_bind_group(3, &textures, &[]);
            pass.draw(run.corners.clone(), 0..1);
        }
    }

    /// Pixels of the target that a pixel of the settings takes up.
    fn scale(&self, settings: &Settings, target: &Target) -> f32 {
        target.size.height as f32 / settings.size.height as f32
    }

    /// The picture that the settings describe: with one sample per pixel edges are smoothed by the GPU's own samples, with
    /// more a larger picture is averaged in linear light, as the renderer on the processor does.
    pub fn image(&self, scene: &Scene, settings: &Settings) -> Result<RgbaImage, NoGpu> {
        Ok(self.image_of(&self.upload(scene)?, scene, settings))
    }

    /// Draws the picture that the settings describe of a scene that was uploaded before.
    pub fn image_of(&self, gpu_scene: &GpuScene, scene: &Scene, settings: &Settings) -> RgbaImage {
        let longest = settings.size.width.max(settings.size.height);
        let most = (self.gpu.device.limits().max_texture_dimension_2d / longest).max(1);
        let scale = settings.supersampling.clamp(1, most);
        let size = Size { width: settings.size.width * scale, height: settings.size.height * scale };
        let smooth = if scale > 1 { Smoothness::OneSample } else { Smoothness::SmoothEdges };
        let target = self.target(size, smooth);
        let canvas = self.canvas(size);
        let view = canvas.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw(gpu_scene, scene, settings, &target, &view);
        let mut image = shrunk(targets::read(&self.gpu, &canvas), scale);
        legend::add(&mut image, scene, settings);
        image
    }

    /// Returns the positions to which the vertex stage moves the vertices of the mesh, #V×3, model units.
    pub fn positions(&self, gpu_scene: &GpuScene, scene: &Scene, displace: &Displace) -> Vec<Vec3> {
        self.write_displacement(gpu_scene, scene, displace);
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.compute.run(&mut encoder, gpu_scene, pipelines::Result::Positions);
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = self.gpu.read(&gpu_scene.positions);
        let positions: &[Vec4] = &bytemuck::pod_collect_to_vec::<u8, Vec4>(&bytes);
        positions.iter().take(scene.mesh().positions.len()).map(|p| p.truncate()).collect()
    }

    fn write_displacement(&self, gpu_scene: &GpuScene, scene: &Scene, displace: &Displace) {
        let displacement = frame::displacement(scene, displace);
        self.gpu.queue.write_buffer(&gpu_scene.displacement, 0, bytemuck::bytes_of(&displacement));
    }
}

/// Antialiasing of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothness {
    /// Each pixel is what its centre shows.
    OneSample,
    /// Several samples are averaged where there is an edge.
    SmoothEdges,
}

/// Shrinks a picture by averaging squares of pixels in linear light.
fn shrunk(large: RgbaImage, scale: u32) -> RgbaImage {
    if scale == 1 {
        return large;
    }
    let mut small = RgbaImage::new(large.width() / scale, large.height() / scale);
    let row_bytes = 4 * small.width() as usize;
    let share = 1.0 / (scale * scale) as f32;
    small.par_chunks_mut(row_bytes).enumerate().for_each(|(y, row)| {
        for (pixel, x) in row.chunks_exact_mut(4).zip(0..) {
            let y = y as u32;
            let square = (0..scale * scale).map(|i| large.get_pixel(x * scale + i % scale, y * scale + i / scale).0);
            let sum: Vec3 = square.map(|[r, g, b, _]| Vec3::from([r, g, b].map(linear_from_byte))).sum();
            let [r, g, b] = pixel_from_linear(share * sum);
            pixel.copy_from_slice(&[r, g, b, u8::MAX]);
        }
    });
    small
}
