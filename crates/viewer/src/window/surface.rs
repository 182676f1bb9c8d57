//! The surface of the window, and egui's triangles on it.

use super::no_window;
use egui::epaint::textures::TexturesDelta;
use egui::{ClippedPrimitive, TextureId};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use planish_files::failure::Failure;
use planish_render::gpu::{Backend, Gpu, NoGpu};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// Surface of the window, and the renderer of egui on it.
pub(super) struct WindowSurface {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    renderer: egui_wgpu::Renderer,
    gpu: Gpu,
    window: Arc<Window>,
}

impl WindowSurface {
    pub(super) fn new(
        window: &Arc<Window>,
        event_loop: &ActiveEventLoop,
        backend: Backend,
    ) -> Result<(Self, Gpu), Failure> {
        if backend == Backend::Auto {
            // As without a window: drivers of OpenGL are loaded only where there is nothing better.
            return Self::new(window, event_loop, Backend::Vulkan)
                .or_else(|_| Self::new(window, event_loop, Backend::Gl));
        }
        let descriptor = wgpu::InstanceDescriptor {
            backends: backend.apis(),
            ..wgpu::InstanceDescriptor::new_with_display_handle(Box::new(event_loop.owned_display_handle()))
        };
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(Arc::clone(window)).map_err(no_window)?;
        let descriptor = wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&descriptor));
        let adapter = adapter.map_err(|_| Failure::internal(NoGpu::NoAdapter { backend }))?;
        let gpu = Gpu::on(&adapter).map_err(Failure::internal)?;
        let size = window.inner_size();
        let mut configuration = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_window("the graphics adapter cannot draw to this display"))?;
        // egui blends encoded colours.
        let plain = [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Bgra8Unorm];
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format =
            formats.iter().copied().find(|format| plain.contains(format)).unwrap_or(configuration.format);
        configuration.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &configuration);
        let renderer = egui_wgpu::Renderer::new(&gpu.device, configuration.format, RendererOptions::default());
        Ok((Self { surface, configuration, renderer, gpu: gpu.clone(), window: Arc::clone(window) }, gpu))
    }

    pub(super) fn resize(&mut self, size: PhysicalSize<u32>) {
        if size.width > 0 && size.height > 0 {
            (self.configuration.width, self.configuration.height) = (size.width, size.height);
            self.surface.configure(&self.gpu.device, &self.configuration);
            self.window.request_redraw();
        }
    }

    /// Lets egui paint with a texture, under the name that it had before if it had one.
    pub(super) fn register(&mut self, view: &wgpu::TextureView, before: Option<TextureId>) -> TextureId {
        let (device, filter) = (&self.gpu.device, wgpu::FilterMode::Linear);
        match before {
            Some(id) => {
                self.renderer.update_egui_texture_from_wgpu_texture(device, view, filter, id);
                id
            }
            None => self.renderer.register_native_texture(device, view, filter),
        }
    }

    /// Paints, and says how long it waited for the display.
    pub(super) fn paint(
        &mut self,
        triangles: &[ClippedPrimitive],
        mut textures: TexturesDelta,
        pixels_per_point: f32,
    ) -> Duration {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        // Whatever becomes of this frame, the next ones need the textures.
        for (id, deltas) in std::mem::take(&mut textures.set) {
            for delta in &deltas {
                self.renderer.update_texture(device, queue, id, delta);
            }
        }
        let before = Instant::now();
        let frame = self.frame();
        let waited = before.elapsed();
        if let Some(frame) = frame {
            let screen = ScreenDescriptor {
                size_in_pixels: [self.configuration.width, self.configuration.height],
                pixels_per_point,
            };
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut commands = self.renderer.update_buffers(device, queue, &mut encoder, triangles, &screen);
            let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let attachment = wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            };
            {
                let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("window"),
                    color_attachments: &[Some(attachment)],
                    ..wgpu::RenderPassDescriptor::default()
                });
                self.renderer.render(&mut pass.forget_lifetime(), triangles, &screen);
            }
            commands.push(encoder.finish());
            queue.submit(commands);
            self.window.pre_present_notify();
            queue.present(frame);
        }
        for id in std::mem::take(&mut textures.free) {
            self.renderer.free_texture(&id);
        }
        waited
    }

    /// The next picture of the surface; none while there is nothing to see.
    fn frame(&self) -> Option<wgpu::SurfaceTexture> {
        use wgpu::CurrentSurfaceTexture as Current;
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                Current::Success(frame) => return Some(frame),
                Current::Suboptimal(frame) => {
                    self.window.request_redraw();
                    return Some(frame);
                }
                Current::Outdated | Current::Lost => self.surface.configure(&self.gpu.device, &self.configuration),
                Current::Timeout | Current::Occluded | Current::Validation => return None,
            }
        }
        None
    }
}
