//! A renderer and a scene that outlive the loss of the device: drivers are updated, cards are pulled out and notebooks wake
//! up.
//!
//! ```no_run
//! use planish_render::gpu::{Backend, Gpu, painter::Painter, renderer::Renderer};
//! use planish_render::settings::{Settings, camera::Camera};
//!
//! # fn f(scene: planish_render::scene::Scene) -> Result<(), planish_render::gpu::NoGpu> {
//! // Pictures from all around, even if the driver is updated meanwhile.
//! let renderer = Renderer::new(Gpu::open(Backend::Auto)?);
//! let mut painter = Painter::new(Backend::Auto, renderer, &scene)?;
//! for step in 0..36 {
//!     let camera = Camera { yaw: 10.0 * step as f32, ..Camera::default() };
//!     let picture = painter.picture(&Settings { camera, ..Settings::default() })?;
//!     assert_eq!(picture.dimensions(), (1200, 900));
//! }
//! # Ok(()) }
//! ```

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
