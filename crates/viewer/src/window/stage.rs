//! The pictures of the model in the window: with the map, and where both are wanted without it.

use super::screen::Screen;
use super::session::{Comparing, Session};
use crate::app::App;
use crate::app::jobs::{Slot, Status, Wake};
use crate::gpu::{FORMAT, Gpu};
use crate::renderer::{Renderer, Smoothness, Target, Uploaded};
use crate::scene::Scene;
use crate::settings::{Range, Settings, Shading, Size};
use egui::TextureId;
use image::RgbaImage;
use std::sync::Arc;

/// What draws, and what it drew last.
pub(super) struct Stage {
    renderer: Arc<Renderer>,
    uploading: Slot<Shown>,
    /// What is being uploaded, or was last.
    wanted: Option<Arc<Scene>>,
    shown: Option<Shown>,
    canvases: [Option<Canvas>; 2],
    target: Option<(Size, Target)>,
}

/// A scene on the device.
struct Shown {
    scene: Arc<Scene>,
    uploaded: Uploaded,
}

/// A picture that egui paints with.
struct Canvas {
    size: Size,
    /// Drawn to: linear light goes in, sRGB is stored.
    colour: wgpu::Texture,
    view: wgpu::TextureView,
    /// The same bytes as egui wants them: as they are.
    plain: wgpu::Texture,
    id: TextureId,
    /// What is on it.
    drawn: Option<(Settings, *const Scene)>,
}

impl Stage {
    pub(super) fn new(gpu: Gpu, wake: &Wake) -> Self {
        Self {
            renderer: Arc::new(Renderer::new(gpu)),
            uploading: Slot::new(Arc::clone(wake)),
            wanted: None,
            shown: None,
            canvases: [None, None],
            target: None,
        }
    }

    pub(super) fn largest_texture(&self) -> usize {
        self.renderer.gpu().device.limits().max_texture_dimension_2d as usize
    }

    pub(super) fn complaints(&self) -> Vec<String> {
        self.renderer.gpu().complaints()
    }

    /// Where the upload is.
    pub(super) fn status(&self) -> Option<Status> {
        self.uploading.status()
    }

    /// Brings what is open to the device, in the background; until it is there the last scene stays.
    pub(super) fn follow(&mut self, app: &App) {
        let scene = app.map().map(|map| &map.scene).or(app.document().map(|document| &document.scene));
        let same = |a: &Option<Arc<Scene>>, b: &Arc<Scene>| a.as_ref().is_some_and(|a| Arc::ptr_eq(a, b));
        if let Some(scene) = scene.filter(|scene| !same(&self.wanted, scene)) {
            self.wanted = Some(Arc::clone(scene));
            let (scene, renderer) = (Arc::clone(scene), Arc::clone(&self.renderer));
            self.uploading.start(move |_| {
                let uploaded = renderer.upload(&scene);
                Ok(Shown { scene, uploaded })
            });
        }
        if let Some(Ok(shown)) = self.uploading.poll() {
            self.shown = Some(shown);
        }
    }

    /// The textures of the picture with the map and of the one without; none before there is something to see.
    pub(super) fn pictures(&self) -> [Option<TextureId>; 2] {
        self.canvases.each_ref().map(|canvas| canvas.as_ref().filter(|c| c.drawn.is_some()).map(|c| c.id))
    }

    /// Draws what has changed.
    pub(super) fn draw(
        &mut self,
        screen: &mut Screen,
        app: &mut App,
        session: &Session,
        view: egui::Rect,
        pixels_per_point: f32,
    ) {
        let Some(shown) = &self.shown else { return };
        let most = self.renderer.gpu().device.limits().max_texture_dimension_2d;
        let pixels = |points: f32| ((points * pixels_per_point).round() as u32).clamp(1, most);
        let size = Size { width: pixels(view.width()), height: pixels(view.height()) };
        app.choices.view.size = size;
        if self.target.as_ref().is_none_or(|(of, _)| *of != size) {
            self.target = Some((size, self.renderer.target(size, Smoothness::SmoothEdges)));
        }
        let Some((_, target)) = &self.target else { return };
        let with_map = drawable(&app.choices.view, &shown.scene);
        let without = Settings { displace: crate::settings::Displace { lambda: 0.0, ..with_map.displace }, ..with_map.clone() };
        let both = session.comparing != Comparing::Off;
        for (i, settings) in [with_map, without].into_iter().enumerate() {
            if i == 1 && !both {
                continue;
            }
            let canvas = match &mut self.canvases[i] {
                Some(canvas) if canvas.size == size => canvas,
                slot => {
                    let before = slot.as_ref().map(|canvas| canvas.id);
                    slot.insert(Canvas::new(self.renderer.gpu(), screen, size, before))
                }
            };
            let of = Arc::as_ptr(&shown.scene);
            if canvas.drawn.as_ref().is_some_and(|(drawn, scene)| *drawn == settings && *scene == of) {
                continue;
            }
            self.renderer.draw(&shown.uploaded, &shown.scene, &settings, target, &canvas.view);
            canvas.give(self.renderer.gpu());
            canvas.drawn = Some((settings, of));
        }
    }

    /// Draws pictures for files, from any thread, with buffers of its own.
    pub(super) fn drawer(&self, app: &App) -> Option<impl Fn(&Settings) -> RgbaImage + Send + 'static> {
        let scene = app.map().map(|map| &map.scene).or(app.document().map(|document| &document.scene))?;
        let (renderer, scene) = (Arc::clone(&self.renderer), Arc::clone(scene));
        let uploaded = std::sync::OnceLock::new();
        Some(move |settings: &Settings| {
            let uploaded = uploaded.get_or_init(|| renderer.upload(&scene));
            renderer.image_of(uploaded, &scene, &drawable(settings, &scene))
        })
    }
}

/// Settings with what only the scene knows: a heat map of heights needs their range, and finding it takes too long for a
/// frame.
fn drawable(view: &Settings, scene: &Scene) -> Settings {
    let mut settings = view.clone();
    if settings.shading == Shading::Heat && scene.mesh().scalars.is_none() {
        settings.shading = Shading::Phong;
    }
    if settings.shading == Shading::Height && settings.heat.range.is_none() {
        settings.heat.range = height_range(view, scene);
    }
    settings
}

/// The heights that a map can hold, with zero in the middle.
pub(super) fn height_range(view: &Settings, scene: &Scene) -> Option<Range> {
    let encoding = scene.relief.as_ref()?.map.encoding();
    let bias = view.displace.bias.unwrap_or(encoding.bias);
    let end = bias + view.displace.scale.unwrap_or(encoding.scale);
    let most = bias.abs().max(end.abs());
    Some(if most > 0.0 { Range { low: -most, high: most } } else { Range { low: -1.0, high: 1.0 } })
}

impl Canvas {
    fn new(gpu: &Gpu, screen: &mut Screen, size: Size, before: Option<TextureId>) -> Self {
        let texture = |format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("view"),
                size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let colour = texture(FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC);
        let plain = texture(
            FORMAT.remove_srgb_suffix(),
            wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        );
        let seen = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let id = screen.register(&seen(&plain), before);
        Self { size, view: seen(&colour), colour, plain, id, drawn: None }
    }

    /// A view of another format would do without a copy, but not every driver has those.
    fn give(&self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_texture(self.colour.as_image_copy(), self.plain.as_image_copy(), self.colour.size());
        gpu.queue.submit([encoder.finish()]);
    }
}
