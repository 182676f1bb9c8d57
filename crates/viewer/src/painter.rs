//! A device, a renderer and a scene that outlive the loss of the device: drivers are updated, cards are pulled out and
//! notebooks wake up.

use crate::gpu::{Backend, Gpu, GpuError};
use crate::picture;
use crate::renderer::{Drawable, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use image::RgbaImage;

/// Draws pictures of one scene.
#[derive(Debug)]
pub struct Painter {
    backend: Backend,
    gpu: Gpu,
    renderer: Renderer,
    drawable: Drawable,
}

impl Painter {
    /// Opens a device and uploads the scene.
    pub fn new(backend: Backend, scene: Scene) -> Result<Self, GpuError> {
        Self::on(backend, Gpu::open(backend)?, scene)
    }

    /// The same on a device that is open.
    pub fn on(backend: Backend, gpu: Gpu, scene: Scene) -> Result<Self, GpuError> {
        let renderer = Renderer::new(&gpu)?;
        let drawable = renderer.upload(&gpu, scene)?;
        Ok(Self { backend, gpu, renderer, drawable })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws a picture; if the device is lost, once more on a new one.
    pub fn picture(&mut self, settings: &Settings) -> Result<RgbaImage, GpuError> {
        match picture::render(&self.gpu, &mut self.renderer, &mut self.drawable, settings) {
            Err(GpuError::Lost(_)) => {
                self.recreate()?;
                picture::render(&self.gpu, &mut self.renderer, &mut self.drawable, settings)
            }
            drawn => drawn,
        }
    }

    fn recreate(&mut self) -> Result<(), GpuError> {
        self.gpu = Gpu::open(self.backend)?;
        self.renderer = Renderer::new(&self.gpu)?;
        self.drawable = self.renderer.upload(&self.gpu, self.drawable.scene().clone())?;
        Ok(())
    }
}
