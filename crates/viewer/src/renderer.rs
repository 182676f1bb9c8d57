//! The renderer on the GPU: draws a scene with some settings into any texture view, and knows no window.

use crate::frame::Frame;
use crate::gpu::{Gpu, GpuError};
use crate::heat;
use crate::layouts::Layouts;
use crate::legend;
use crate::passes::background::BackgroundPass;
use crate::passes::derive::{DerivePass, Derived};
use crate::passes::legend::LegendPass;
use crate::passes::mesh::MeshPass;
use crate::passes::overlay::{Lines, OverlayPass};
use crate::passes::resolve::ResolvePass;
use crate::render_mesh::RenderMesh;
use crate::scene::Scene;
use crate::settings::{HeatSource, Normals, Range, Sampling, Settings, Shading, Size};
use crate::targets::Targets;
use crate::wedges::Wedges;
use glam::{Vec3, Vec4};

/// A view to draw into.
#[derive(Clone, Copy, Debug)]
pub struct Canvas<'a> {
    /// Where to draw.
    pub view: &'a wgpu::TextureView,
    /// Of its texture; if it does not encode sRGB by itself, the renderer does.
    pub format: wgpu::TextureFormat,
    /// Of the view.
    pub size: Size,
}

/// A scene that was uploaded, and what of it was prepared for the last picture.
#[derive(Debug)]
pub struct Drawable {
    scene: Scene,
    wedges: Wedges,
    mesh: RenderMesh,
    /// Numbers that the wedges have now.
    scalars: Option<(HeatSource, Option<Vec<f32>>)>,
    sampling: Option<Sampling>,
    derived: Option<Derived>,
    /// What `derived` was computed with.
    derived_lambda: Option<f32>,
    lines: Option<Lines>,
}

impl Drawable {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Vertex of the surface of each wedge. #W
    pub fn vertices_of_wedges(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.wedges.wedges.iter().map(|wedge| wedge.vertex)
    }

    /// Range of the colour map, if numbers are to be shown; puts them on the wedges.
    fn heat(&mut self, gpu: &Gpu, settings: &Settings) -> Option<Range> {
        let source = Some(settings.heat.source).filter(|_| settings.shading == Shading::Heat)?;
        if self.scalars.as_ref().is_none_or(|(shown, _)| *shown != source) {
            let scalars = heat::scalars(&self.scene, source);
            self.wedges.set_scalars(scalars.as_deref());
            gpu.queue.write_buffer(&self.mesh.surfels, 0, bytemuck::cast_slice(&self.wedges.surfels));
            self.scalars = Some((source, scalars));
        }
        heat::range(self.scalars.as_ref()?.1.as_deref(), settings)
    }
}

/// Pipelines and targets, made when they are first needed.
#[derive(Debug)]
pub struct Renderer {
    layouts: Layouts,
    frame: Frame,
    derive: DerivePass,
    background: BackgroundPass,
    mesh: MeshPass,
    overlay: OverlayPass,
    resolve: ResolvePass,
    legend: LegendPass,
    targets: Option<Targets>,
}

impl Renderer {
    /// A renderer on a device; it must be given the same one in every call.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = Layouts::new(gpu);
        let renderer = Self {
            frame: Frame::new(gpu, &layouts),
            derive: DerivePass::new(gpu, &layouts),
            background: BackgroundPass::new(gpu, &layouts),
            mesh: MeshPass::new(gpu, &layouts),
            overlay: OverlayPass::new(gpu, &layouts),
            resolve: ResolvePass::new(gpu),
            legend: LegendPass::new(gpu),
            layouts,
            targets: None,
        };
        gpu.check()?;
        Ok(renderer)
    }

    /// Uploads a scene.
    pub fn upload(&self, gpu: &Gpu, scene: Scene) -> Result<Drawable, GpuError> {
        let wedges = Wedges::new(&scene);
        let mesh = RenderMesh::new(gpu, &self.layouts, &scene, &wedges)?;
        gpu.check()?;
        Ok(Drawable {
            scene,
            wedges,
            mesh,
            scalars: None,
            sampling: None,
            derived: None,
            derived_lambda: None,
            lines: None,
        })
    }

    /// Draws. Settings that pass [`Settings::check`] are expected; the size is that of the canvas.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        drawable: &mut Drawable,
        settings: &Settings,
        canvas: Canvas<'_>,
    ) -> Result<(), GpuError> {
        let view = settings.camera.view(drawable.scene.bounds(), canvas.size.aspect());
        self.fit_targets(gpu, settings, canvas.size)?;
        let heat = drawable.heat(gpu, settings);
        self.frame.write(gpu, &drawable.scene, settings, &view, canvas.size, heat);
        drawable.mesh.set_lambda(gpu, settings.map.lambda);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.prepare(gpu, &mut encoder, drawable, settings)?;
        let Drawable { mesh, derived, lines, .. } = drawable;
        let normals = match (settings.map.normals, derived) {
            (Normals::Derived, Some(derived)) => &derived.normals,
            _ => &mesh.base_normals,
        };

        let Some(targets) = &self.targets else { return Ok(()) };
        let mut pass = targets.begin(&mut encoder);
        pass.set_bind_group(0, &self.frame.bind_group, &[]);
        self.background.draw(gpu, &mut pass, &settings.background, targets.samples);
        self.mesh.draw(gpu, &mut pass, mesh, normals, settings.shading, targets.samples);
        if let (Some(lines), true) = (lines, has_lines(settings)) {
            self.overlay.draw(gpu, &mut pass, mesh, lines, settings, targets.samples);
        }
        drop(pass);
        self.resolve.draw(gpu, &mut encoder, targets, canvas.view, canvas.format, settings.supersampling);
        if let Some(range) = heat {
            let bar = legend::rectangles(canvas.size, settings.heat.map, range, &settings.background);
            self.legend.draw(gpu, &mut encoder, canvas.view, canvas.format, canvas.size, &bar)?;
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.check()
    }

    /// Where the displacement map takes each wedge, as the GPU computes it. #W×3, relative to the map's origin
    pub fn displaced_positions(
        &self,
        gpu: &Gpu,
        drawable: &mut Drawable,
        lambda: f32,
    ) -> Result<Vec<Vec3>, GpuError> {
        drawable.mesh.set_lambda(gpu, lambda);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let derived = self.derive(gpu, &mut encoder, drawable, lambda)?;
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read_buffer(&derived.places)?;
        let places: Vec<Vec4> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(places[..drawable.wedges.wedges.len()].iter().map(|place| place.truncate()).collect())
    }

    /// Brings what a picture needs of a scene up to date.
    fn prepare(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        drawable: &mut Drawable,
        settings: &Settings,
    ) -> Result<(), GpuError> {
        if drawable.sampling != Some(settings.sampling) {
            drawable.mesh.bind_pictures(gpu, &self.layouts, settings.sampling);
            drawable.sampling = Some(settings.sampling);
        }
        if settings.map.normals == Normals::Derived {
            self.derive(gpu, encoder, drawable, settings.map.lambda)?;
        }
        if has_lines(settings) && drawable.lines.is_none() {
            drawable.lines = Some(self.overlay.prepare(gpu, &drawable.mesh, &drawable.wedges)?);
        }
        Ok(())
    }

    /// Displaced positions and normals for this λ, which was written.
    fn derive<'a>(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        drawable: &'a mut Drawable,
        lambda: f32,
    ) -> Result<&'a Derived, GpuError> {
        let Drawable { mesh, wedges, derived, derived_lambda, .. } = drawable;
        let derived = match derived {
            Some(derived) => derived,
            none => none.insert(self.derive.prepare(gpu, mesh, wedges)?),
        };
        if *derived_lambda != Some(lambda) {
            self.derive.run(encoder, mesh, derived);
            *derived_lambda = Some(lambda);
        }
        Ok(derived)
    }

    /// Makes new targets where those of the last picture do not fit.
    fn fit_targets(&mut self, gpu: &Gpu, settings: &Settings, size: Size) -> Result<(), GpuError> {
        let (size, samples) = (Targets::size_of(size, settings), Targets::samples_of(gpu, settings));
        if self.targets.as_ref().is_none_or(|targets| targets.size != size || targets.samples != samples) {
            self.targets = None;
            self.targets = Some(Targets::new(gpu, size, samples)?);
        }
        Ok(())
    }
}

fn has_lines(settings: &Settings) -> bool {
    settings.overlay.wireframe.is_some() || settings.overlay.seams.is_some()
}
