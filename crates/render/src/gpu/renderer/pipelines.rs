//! Compiled pipelines of the renderer.

use super::bind_groups::Layouts;
use super::gpu_scene::GpuScene;
use super::lighting::Lighting;
use crate::gpu::shaders::{Program, Variant, source};
use crate::gpu::{DEPTH, FORMAT};
use crate::settings::environment::Part;
use crate::settings::shadow::Casters;
use crate::settings::volume::VolumeDisplay;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Pipelines that draw to targets with one number of samples per pixel.
#[derive(Debug)]
pub(super) struct Pipelines {
    samples: u32,
    pub(super) shadow_view: wgpu::RenderPipeline,
    backgrounds: Mutex<HashMap<VolumeDisplay, wgpu::RenderPipeline>>,
    surfaces: Mutex<HashMap<Variant, Surface>>,
    /// Pipelines of triangles whose outer side alone is drawn.
    outer_sides: Mutex<HashMap<Variant, wgpu::RenderPipeline>>,
}

/// Pipelines that draw the surface and the ground under it, compiled for one variant of the settings.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) mesh: wgpu::RenderPipeline,
    pub(super) ground: wgpu::RenderPipeline,
}

/// Parts of a render pipeline in which the pipelines differ.
struct Special<'a> {
    program: Program,
    variant: Variant,
    vertex: &'a str,
    /// Entry point of the fragment stage; `None` draws depth alone.
    fragment: Option<&'a str>,
    groups: &'a [&'a wgpu::BindGroupLayout],
    samples: u32,
    depth_compare: wgpu::CompareFunction,
    depth_write: bool,
    primitive: wgpu::PrimitiveState,
    blend: Option<wgpu::BlendState>,
}

fn pipeline(device: &wgpu::Device, special: &Special) -> wgpu::RenderPipeline {
    let module = module(device, special.program, special.variant);
    let groups: Vec<_> = special.groups.iter().map(|group| Some(*group)).collect();
    let targets =
        [Some(wgpu::ColorTargetState { format: FORMAT, blend: special.blend, write_mask: wgpu::ColorWrites::ALL })];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(special.vertex),
        layout: Some(&layout(device, &groups)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(special.vertex),
            compilation_options: <_>::default(),
            buffers: &[],
        },
        primitive: special.primitive,
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(special.depth_write),
            depth_compare: Some(special.depth_compare),
            stencil: <_>::default(),
            bias: <_>::default(),
        }),
        multisample: wgpu::MultisampleState { count: special.samples, ..<_>::default() },
        fragment: special.fragment.map(|entry_point| wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: <_>::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Scans have holes, through which their insides are seen.
const BOTH_SIDES: wgpu::PrimitiveState = sides(wgpu::PrimitiveTopology::TriangleList, None);

const fn sides(topology: wgpu::PrimitiveTopology, cull_mode: Option<wgpu::Face>) -> wgpu::PrimitiveState {
    wgpu::PrimitiveState {
        topology,
        strip_index_format: None,
        front_face: wgpu::FrontFace::Ccw,
        cull_mode,
        unclipped_depth: false,
        polygon_mode: wgpu::PolygonMode::Fill,
        conservative: false,
    }
}

/// Pipeline of a triangle that fills the whole picture.
fn screen<'a>(groups: &'a [&'a wgpu::BindGroupLayout], samples: u32, volume: VolumeDisplay) -> Special<'a> {
    Special {
        program: Program::Background,
        variant: Variant { volume, ..Variant::default() },
        vertex: "vs_background",
        fragment: Some("fs_background"),
        groups,
        samples,
        depth_compare: wgpu::CompareFunction::Always,
        depth_write: false,
        primitive: BOTH_SIDES,
        blend: None,
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let groups = [&layouts.frame];
        let shadow_view = Special {
            program: Program::ShadowView,
            vertex: "vs_shadow_view",
            fragment: Some("fs_shadow_view"),
            ..screen(&groups, samples, VolumeDisplay::Hidden)
        };
        let shadow_view = pipeline(device, &shadow_view);
        Self {
            samples,
            shadow_view,
            backgrounds: <_>::default(),
            surfaces: <_>::default(),
            outer_sides: <_>::default(),
        }
    }

    /// Compiles the background for what is drawn of a volume before it, unless it was needed before.
    pub(super) fn background(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        volume: VolumeDisplay,
    ) -> wgpu::RenderPipeline {
        let mut backgrounds = self.backgrounds.lock().unwrap_or_else(PoisonError::into_inner);
        let new = || pipeline(device, &screen(&[&layouts.frame], self.samples, volume));
        backgrounds.entry(volume).or_insert_with(new).clone()
    }

    /// Compiles the variant unless it was needed before.
    pub(super) fn surface(&self, device: &wgpu::Device, layouts: &Layouts, variant: Variant) -> Surface {
        let mut surfaces = self.surfaces.lock().unwrap_or_else(PoisonError::into_inner);
        surfaces.entry(variant).or_insert_with(|| Surface::new(device, layouts, self.samples, variant)).clone()
    }

    /// Compiles the variant for triangles whose outer side alone is drawn, unless it was needed before.
    pub(super) fn outer_side(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        variant: Variant,
    ) -> wgpu::RenderPipeline {
        let mut all = self.outer_sides.lock().unwrap_or_else(PoisonError::into_inner);
        let primitive = sides(wgpu::PrimitiveTopology::TriangleList, Some(wgpu::Face::Back));
        let Layouts { frame, map, surface, textures, .. } = layouts;
        let groups = [frame, map, surface, textures];
        let new = || pipeline(device, &Special { primitive, ..mesh(&groups, self.samples, variant) });
        all.entry(variant).or_insert_with(new).clone()
    }
}

/// Pipeline of the surface.
fn mesh<'a>(groups: &'a [&'a wgpu::BindGroupLayout], samples: u32, variant: Variant) -> Special<'a> {
    Special {
        program: Program::Mesh,
        variant,
        vertex: "vs_mesh",
        fragment: Some("fs_mesh"),
        depth_compare: wgpu::CompareFunction::Less,
        depth_write: true,
        ..screen(groups, samples, variant.volume)
    }
}

impl Surface {
    fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32, variant: Variant) -> Self {
        let Layouts { frame, map, surface, textures, .. } = layouts;
        let groups = [frame, map, surface, textures];
        let mesh = mesh(&groups, samples, variant);
        let ground = Special {
            program: Program::Ground,
            vertex: "vs_ground",
            fragment: Some("fs_ground"),
            groups: &[frame],
            primitive: sides(wgpu::PrimitiveTopology::TriangleStrip, Some(wgpu::Face::Back)),
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            ..mesh
        };
        let [mesh, ground] = [&mesh, &ground].map(|special| pipeline(device, special));
        Self { mesh, ground }
    }
}

/// Pipelines that draw shadow maps.
#[derive(Debug)]
pub(super) struct Casting {
    all: wgpu::RenderPipeline,
    back_faces: wgpu::RenderPipeline,
}

impl Casting {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let Layouts { caster, map, surface, .. } = layouts;
        let all = Special {
            program: Program::Shadow,
            variant: Variant::default(),
            vertex: "vs_shadow",
            fragment: None,
            groups: &[caster, map, surface],
            samples: 1,
            depth_compare: wgpu::CompareFunction::Less,
            depth_write: true,
            primitive: BOTH_SIDES,
            blend: None,
        };
        let culled = sides(wgpu::PrimitiveTopology::TriangleList, Some(wgpu::Face::Front));
        let back_faces = Special { primitive: culled, ..all };
        Self { all: pipeline(device, &all), back_faces: pipeline(device, &back_faces) }
    }

    /// Draws the shadow maps of all lights.
    pub(super) fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        gpu_scene: &GpuScene,
        lighting: &Lighting,
        casters: Casters,
        mesh: Part,
    ) {
        let corners = if mesh == Part::Shown { gpu_scene.corner_count } else { 0 };
        let pipeline = match casters {
            Casters::All => &self.all,
            Casters::BackFaces => &self.back_faces,
        };
        for (view, i) in lighting.maps.each.iter().zip(0..lighting.eyes as u32) {
            let depth = wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow"),
                depth_stencil_attachment: Some(depth),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &lighting.caster_bindings, &[i * lighting.caster_stride]);
            pass.set_bind_group(1, &gpu_scene.map_bindings, &[]);
            pass.set_bind_group(2, &gpu_scene.surface_bindings, &[]);
            pass.draw(0..corners, 0..1);
        }
    }
}

/// Quantities of the displaced surface that a compute pass gives.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Result {
    Positions,
    /// Positions and normals.
    Normals,
}

#[derive(Debug)]
pub(super) struct Compute {
    positions: wgpu::ComputePipeline,
    normals: wgpu::ComputePipeline,
}

/// Groups of 64 vertices in a row; `vertex_index` in `shaders/normals.wgsl`.
const GROUPS_IN_ROW: u32 = 65_535;

impl Compute {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let module = module(device, Program::Normals, Variant::default());
        // Group 0, the frame, is not needed.
        let layout = layout(device, &[None, Some(&layouts.map), Some(&layouts.surface), Some(&layouts.results)]);
        let pipeline = |entry_point| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: <_>::default(),
                cache: None,
            })
        };
        Self { positions: pipeline("cs_positions"), normals: pipeline("cs_normals") }
    }

    pub(super) fn run(&self, encoder: &mut wgpu::CommandEncoder, gpu_scene: &GpuScene, result: Result) {
        let groups = gpu_scene.vertex_count.div_ceil(64);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(1, &gpu_scene.map_bindings, &[]);
        pass.set_bind_group(2, &gpu_scene.computed_surface_bindings, &[]);
        pass.set_bind_group(3, &gpu_scene.result_bindings, &[]);
        pass.set_pipeline(&self.positions);
        pass.dispatch_workgroups(groups.min(GROUPS_IN_ROW), groups.div_ceil(GROUPS_IN_ROW), 1);
        if result == Result::Normals {
            pass.set_pipeline(&self.normals);
            pass.dispatch_workgroups(groups.min(GROUPS_IN_ROW), groups.div_ceil(GROUPS_IN_ROW), 1);
        }
    }
}

fn module(device: &wgpu::Device, program: Program, variant: Variant) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source(program, variant).into()),
    })
}

fn layout(device: &wgpu::Device, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}
