//! Pictures of a scene, on a GPU or on the processor.

use image::RgbaImage;
use planish_files::failure::Failure;
use planish_files::terminal::Terminal;
use planish_render::gpu::painter::Painter;
use planish_render::gpu::renderer::Renderer;
use planish_render::gpu::{Backend, Gpu, NoGpu};
use planish_render::scene::Scene;
use planish_render::settings::Settings;
use planish_render::software;

/// Draws pictures of one scene, on a GPU or on the processor.
pub(crate) enum Drawer<'a> {
    Gpu(Box<Painter<'a>>),
    Software(&'a Scene),
}

impl<'a> Drawer<'a> {
    /// Opens the backend; where it may choose, it takes the processor if no GPU can be used.
    pub(crate) fn open(scene: &'a Scene, backend: Backend, terminal: &Terminal) -> Result<Self, Failure> {
        let renderer = match backend {
            Backend::Software => return Ok(Self::Software(scene)),
            _ => match Gpu::open(backend) {
                Ok(gpu) => Renderer::new(gpu),
                Err(NoGpu::NoAdapter { .. }) if backend == Backend::Auto => return Ok(Self::Software(scene)),
                Err(e) => return Err(Failure::internal(e)),
            },
        };
        match Painter::new(backend, renderer, scene) {
            Err(e @ (NoGpu::TooLarge { .. } | NoGpu::VolumeTooLarge { .. })) if backend == Backend::Auto => {
                terminal.warn(&e.to_string());
                Ok(Self::Software(scene))
            }
            painter => Ok(Self::Gpu(Box::new(painter.map_err(Failure::internal)?))),
        }
    }

    pub(crate) fn draw(&mut self, settings: &Settings) -> Result<RgbaImage, Failure> {
        match self {
            Self::Gpu(painter) => painter.picture(settings).map_err(Failure::internal),
            Self::Software(scene) => Ok(software::render(scene, settings)),
        }
    }

    /// Warns of what the driver complained about.
    pub(crate) fn warn(&self, terminal: &Terminal) {
        if let Self::Gpu(painter) = self {
            painter.renderer().gpu().validation_errors().iter().for_each(|error| terminal.warn(error));
        }
    }
}

/// Draws one picture of a scene.
pub(crate) fn draw(
    scene: &Scene,
    settings: &Settings,
    backend: Backend,
    terminal: &Terminal,
) -> Result<RgbaImage, Failure> {
    let mut drawer = Drawer::open(scene, backend, terminal)?;
    let picture = drawer.draw(settings)?;
    drawer.warn(terminal);
    Ok(picture)
}
