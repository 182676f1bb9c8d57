//! Off-screen pictures of the model in the window: with the map, and where both are compared, without it.

use super::surface::WindowSurface;
use super::ui_state::{Comparing, UiState};
use crate::app::App;
use crate::app::document::Document;
use crate::app::jobs::{self, Slot, Status, Ticket, Wake};
use crate::app::vertex_numbers::VertexNumbers;
use crate::environment;
use crate::volume;
use egui::TextureId;
use image::RgbaImage;
use planish_files::failure::Failure;
use planish_geometry::progress::Progress as _;
use planish_render::environment::Environment;
use planish_render::gpu::renderer::{GpuScene, Renderer, Smoothness, Target};
use planish_render::gpu::{FORMAT, Gpu};
use planish_render::scene::Scene;
use planish_render::settings::environment::Source;
use planish_render::settings::volume::{Placement, VolumeSource};
use planish_render::settings::{Range, Settings, Shading, Size};
use planish_render::volume::Volume;
use std::sync::Arc;

/// Off-screen targets of the viewport, their renderer, and the scene that was uploaded last.
pub(super) struct ViewportTargets {
    renderer: Arc<Renderer>,
    uploading: Slot<Uploaded>,
    /// Scene that is being uploaded, or was uploaded last.
    request: Option<UploadRequest>,
    shown: Option<Shown>,
    known: Known,
    canvases: [Option<Canvas>; 2],
    target: Option<(Size, Target)>,
    /// Numbers of the vertices of the shown scene that are on the device.
    numbers: Option<Arc<Vec<f32>>>,
}

/// Source of an environment, and its number of texels along a side.
type EnvironmentKey = (Source, u32);

/// Source of a volume, its placement, and the mesh that it is computed from or put around.
#[derive(Clone)]
struct VolumeKey {
    source: VolumeSource,
    placement: Placement,
    document: Arc<Document>,
}

impl PartialEq for VolumeKey {
    fn eq(&self, other: &Self) -> bool {
        self.source == other.source && self.placement == other.placement && Arc::ptr_eq(&self.document, &other.document)
    }
}

/// Request to upload a scene with its environment and its volume.
#[derive(Clone)]
struct UploadRequest {
    scene: Arc<Scene>,
    environment: Option<EnvironmentKey>,
    volume: Option<VolumeKey>,
}

impl PartialEq for UploadRequest {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene) && self.environment == other.environment && self.volume == other.volume
    }
}

/// Surroundings and contents of a scene that were read last, with their sources.
#[derive(Clone, Default)]
struct Known {
    environment: Option<Arc<(EnvironmentKey, Environment)>>,
    volume: Option<(VolumeKey, Arc<Volume>)>,
}

/// A scene on the device, what was read for it, and what could not be read.
type Uploaded = (Shown, Known, Vec<Failure>);

impl UploadRequest {
    /// Uploads the scene, without an environment or a volume that cannot be read.
    fn show(self, renderer: &Renderer, known: Known, ticket: &Ticket) -> Result<Uploaded, Failure> {
        let (mut scene, mut failed, mut read) = (self.scene, Vec::new(), known);
        if let Some(key) = self.environment {
            if read.environment.as_ref().is_none_or(|read| read.0 != key) {
                ticket.stage("environment");
                let loaded = environment::load(&key.0, key.1 as usize).map_err(|failure| failed.push(failure));
                read.environment = loaded.ok().map(|environment| Arc::new((key, environment)));
            }
            let mut with = (*scene).clone();
            with.environment = read.environment.as_ref().map(|read| read.1.clone());
            scene = Arc::new(with);
        }
        if let Some(key) = self.volume {
            if read.volume.as_ref().is_none_or(|read| read.0 != key) {
                let Document { model, trust, .. } = &*key.document;
                let loaded = volume::load(&key.source, key.placement, Some(model), *trust, ticket);
                read.volume = match loaded {
                    Ok(volume) => Some((key, Arc::new(volume))),
                    // The work is for a newer request.
                    Err(Failure::Interrupted) => return Err(Failure::Interrupted),
                    Err(failure) => {
                        failed.push(failure);
                        None
                    }
                };
            }
            let mut with = (*scene).clone();
            with.set_volume(read.volume.as_ref().map(|read| Arc::clone(&read.1)));
            scene = Arc::new(with);
        } else {
            // A volume may be large, and it is not seen.
            read.volume = None;
        }
        ticket.stage("to the graphics card");
        let gpu_scene = upload(renderer, &scene)?;
        Ok((Shown { scene, gpu_scene }, read, failed))
    }
}

/// Scene that is on the device.
struct Shown {
    scene: Arc<Scene>,
    gpu_scene: GpuScene,
}

/// A picture that egui paints with.
struct Canvas {
    size: Size,
    /// Drawn to: linear light goes in, sRGB is stored.
    colour: wgpu::Texture,
    view: wgpu::TextureView,
    /// Copy of the bytes for egui, which blends encoded values.
    plain: wgpu::Texture,
    id: TextureId,
    /// Settings and scene of the picture on the canvas.
    drawn: Option<(Settings, *const Scene)>,
}

impl ViewportTargets {
    pub(super) fn new(gpu: Gpu, wake: &Wake) -> Self {
        Self {
            renderer: Arc::new(Renderer::new(gpu)),
            uploading: Slot::new(Arc::clone(wake)),
            request: None,
            shown: None,
            known: Known::default(),
            canvases: [None, None],
            target: None,
            numbers: None,
        }
    }

    pub(super) fn largest_texture(&self) -> usize {
        self.renderer.gpu().device.limits().max_texture_dimension_2d as usize
    }

    /// Whether the device is gone.
    pub(super) fn is_lost(&self) -> bool {
        self.renderer.gpu().is_lost()
    }

    /// Returns the name of the adapter.
    pub(super) fn adapter(&self) -> String {
        self.renderer.gpu().adapter.name.clone()
    }

    pub(super) fn validation_errors(&self) -> Vec<String> {
        self.renderer.gpu().validation_errors()
    }

    /// Returns the progress of the upload.
    pub(super) fn status(&self) -> Option<Status> {
        self.uploading.status()
    }

    /// Brings what is open to the device, in the background; until it is there the last scene stays.
    pub(super) fn follow(&mut self, app: &mut App) {
        let scene = app.map().map(|map| &map.scene).or(app.document().map(|document| &document.scene));
        let surroundings = app.choices.view.environment.as_ref();
        let request = scene.map(|scene| UploadRequest {
            scene: Arc::clone(scene),
            environment: surroundings.map(|s| (s.source.clone(), s.resolution)),
            volume: wanted_volume(app),
        });
        if let Some(request) = request.filter(|request| self.request.as_ref() != Some(request)) {
            let (renderer, known) = (Arc::clone(&self.renderer), self.known.clone());
            self.request = Some(request.clone());
            self.uploading.start(move |ticket| request.show(&renderer, known, ticket));
        }
        match self.uploading.poll() {
            Some(Ok((shown, known, failed))) => {
                jobs::drop_in_background(self.shown.replace(shown));
                self.numbers = None;
                jobs::drop_in_background(std::mem::replace(&mut self.known, known));
                failed.iter().for_each(|failure| app.fail(failure));
            }
            Some(Err(failure)) => app.fail(&failure),
            None => {}
        }
    }

    /// The textures of the picture with the map and of the one without; none before there is something to see.
    pub(super) fn pictures(&self) -> [Option<TextureId>; 2] {
        self.canvases.each_ref().map(|canvas| canvas.as_ref().filter(|c| c.drawn.is_some()).map(|c| c.id))
    }

    /// Draws what has changed, and says how many pictures that were.
    pub(super) fn draw(
        &mut self,
        surface: &mut WindowSurface,
        app: &mut App,
        ui_state: &UiState,
        view: egui::Rect,
        pixels_per_point: f32,
    ) -> usize {
        let Some(shown) = &self.shown else { return 0 };
        let most = self.renderer.gpu().device.limits().max_texture_dimension_2d;
        let pixels = |points: f32| ((points * pixels_per_point).round() as u32).clamp(1, most);
        let size = Size { width: pixels(view.width()), height: pixels(view.height()) };
        app.choices.view.size = size;
        if self.target.as_ref().is_none_or(|(of, _)| *of != size) {
            self.target = Some((size, self.renderer.target(size, Smoothness::SmoothEdges)));
        }
        let Some((_, target)) = &self.target else { return 0 };
        let numbers = numbers_for(app, &shown.scene);
        if let Some(VertexNumbers { numbers, .. }) = &numbers
            && self.numbers.as_ref().is_none_or(|known| !Arc::ptr_eq(known, numbers))
            && self.renderer.set_scalars(&shown.gpu_scene, &shown.scene, numbers).is_ok()
        {
            self.numbers = Some(Arc::clone(numbers));
            self.canvases.iter_mut().flatten().for_each(|canvas| canvas.drawn = None);
        }
        let with_map = drawable(&app.shown_view(), &shown.scene, numbers.as_ref());
        let without = Settings {
            displace: planish_render::settings::Displace { lambda: 0.0, ..with_map.displace },
            ..with_map.clone()
        };
        let both = ui_state.comparing != Comparing::Off;
        let mut drawn = 0;
        for (i, settings) in [with_map, without].into_iter().enumerate() {
            if i == 1 && !both {
                continue;
            }
            let canvas = match &mut self.canvases[i] {
                Some(canvas) if canvas.size == size => canvas,
                slot => {
                    let before = slot.as_ref().map(|canvas| canvas.id);
                    slot.insert(Canvas::new(&self.renderer, surface, size, before))
                }
            };
            let of = Arc::as_ptr(&shown.scene);
            if canvas.drawn.as_ref().is_some_and(|(drawn, scene)| *drawn == settings && *scene == of) {
                continue;
            }
            self.renderer.draw(&shown.gpu_scene, &shown.scene, &settings, target, &canvas.view);
            canvas.give(self.renderer.gpu());
            canvas.drawn = Some((settings, of));
            drawn += 1;
        }
        drawn
    }

    /// Draws pictures for files, from any thread, with buffers of its own.
    pub(super) fn drawer(
        &self,
        app: &App,
    ) -> Option<impl Fn(&Settings) -> Result<RgbaImage, Failure> + Send + 'static> {
        let (renderer, scene) = (Arc::clone(&self.renderer), Arc::clone(&self.shown.as_ref()?.scene));
        let numbers = numbers_for(app, &scene);
        let uploaded = std::sync::OnceLock::new();
        let upload = move |renderer: &Renderer, scene: &Scene, numbers: Option<&VertexNumbers>| {
            let gpu_scene = upload(renderer, scene)?;
            if let Some(VertexNumbers { numbers, .. }) = numbers {
                renderer.set_scalars(&gpu_scene, scene, numbers).map_err(Failure::internal)?;
            }
            Ok(gpu_scene)
        };
        Some(move |settings: &Settings| {
            let gpu_scene = uploaded.get_or_init(|| upload(&renderer, &scene, numbers.as_ref()));
            let gpu_scene = gpu_scene.as_ref().map_err(|failure: &Failure| failure.clone())?;
            Ok(renderer.image_of(gpu_scene, &scene, &drawable(settings, &scene, numbers.as_ref())))
        })
    }
}

/// The volume of the view, with the mesh that is open.
fn wanted_volume(app: &App) -> Option<VolumeKey> {
    let view = app.choices.view.volume.as_ref()?;
    let document = Arc::clone(app.document()?);
    Some(VolumeKey { source: view.source.clone(), placement: view.placement, document })
}

fn upload(renderer: &Renderer, scene: &Scene) -> Result<GpuScene, Failure> {
    renderer.upload(scene).map_err(Failure::internal)
}

/// Numbers of the vertices of a scene, if it is to be coloured by them.
fn numbers_for(app: &App, scene: &Scene) -> Option<VertexNumbers> {
    let is_shown = app.shown_view().shading == Shading::Heat;
    let numbers = if is_shown { app.vertex_numbers() } else { None };
    // Until a mesh is uploaded, the one before it is drawn.
    numbers.filter(|numbers| numbers.numbers.len() == scene.mesh().positions.len())
}

/// Settings with what only the scene knows: a heat map of heights needs their range, and finding it takes too long for a
/// frame.
fn drawable(view: &Settings, scene: &Scene, numbers: Option<&VertexNumbers>) -> Settings {
    let mut settings = view.clone();
    if settings.shading == Shading::Heat {
        match numbers {
            Some(numbers) => (settings.heat.map, settings.heat.range) = (VertexNumbers::COLORMAP, Some(numbers.range)),
            None => settings.shading = Shading::Phong,
        }
    }
    if settings.shading == Shading::Height && settings.heat.range.is_none() {
        settings.heat.range = height_range(view, scene);
    }
    settings
}

/// The heights that a map can hold, with zero in the middle.
pub(super) fn height_range(view: &Settings, scene: &Scene) -> Option<Range> {
    let encoding = scene.displacement.as_ref()?.map.encoding();
    let bias = view.displace.bias.unwrap_or(encoding.bias);
    let end = bias + view.displace.scale.unwrap_or(encoding.scale);
    let most = bias.abs().max(end.abs());
    Some(if most > 0.0 { Range { low: -most, high: most } } else { Range { low: -1.0, high: 1.0 } })
}

impl Canvas {
    fn new(renderer: &Renderer, surface: &mut WindowSurface, size: Size, before: Option<TextureId>) -> Self {
        let colour = renderer.canvas(size);
        let plain = renderer.gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: Some("view"),
            size: colour.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT.remove_srgb_suffix(),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let seen = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let id = surface.register(&seen(&plain), before);
        Self { size, view: seen(&colour), colour, plain, id, drawn: None }
    }

    /// A view of another format would do without a copy, but not every driver has those.
    fn give(&self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_texture(self.colour.as_image_copy(), self.plain.as_image_copy(), self.colour.size());
        gpu.queue.submit([encoder.finish()]);
    }
}
