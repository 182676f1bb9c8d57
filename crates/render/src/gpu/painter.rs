//! A renderer and a scene that outlive the loss of the device: drivers are updated, cards are pulled out and notebooks wake
//! up.

use crate::gpu::renderer::{GpuScene, Renderer};
use crate::gpu::{Backend, Gpu, NoGpu};
use crate::scene::Scene;
use crate::settings::Settings;
use image::RgbaImage;

/// Draws pictures of one scene.
#[derive(Debug)]
pub struct Painter<'a> {
    backend: Backend,
    renderer: Renderer,
    scene: &'a Scene,
    gpu_scene: GpuScene,
}

impl<'a> Painter<'a> {
    /// Copies the scene to the renderer's device; `backend` is where another one is looked for if that is lost.
    pub fn new(backend: Backend, renderer: Renderer, scene: &'a Scene) -> Result<Self, NoGpu> {
        let gpu_scene = renderer.upload(scene)?;
        Ok(Self { backend, renderer, scene, gpu_scene })
    }

    /// Returns the renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Draws a picture; if the device is lost, once more on a new one.
    pub fn picture(&mut self, settings: &Settings) -> Result<RgbaImage, NoGpu> {
        for _ in 0..2 {
            let picture = self.renderer.image_of(&self.gpu_scene, self.scene, settings);
            if !self.renderer.gpu().is_lost() {
                return Ok(picture);
            }
            self.renderer = Renderer::new(Gpu::open(self.backend)?);
            self.gpu_scene = self.renderer.upload(self.scene)?;
        }
        Err(NoGpu::Lost { adapter: self.renderer.gpu().adapter.name.clone() })
    }
}
