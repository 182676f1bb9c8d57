//! Compiled programs.

use super::bindings::Layouts;
use super::lighting::Lighting;
use super::uploaded::Uploaded;
use crate::gpu::{DEPTH, FORMAT};
use crate::shaders::{Program, source};
use crate::shadow::Casters;

/// What draws to targets with some number of samples per pixel.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) background: wgpu::RenderPipeline,
    pub(super) ground: wgpu::RenderPipeline,
    pub(super) mesh: wgpu::RenderPipeline,
    pub(super) shadow_view: wgpu::RenderPipeline,
}

/// What is special of a pipeline.
struct Special<'a> {
    program: Program,
    vertex: &'a str,
    /// None draws depth alone.
    fragment: Option<&'a str>,
    groups: &'a [&'a wgpu::BindGroupLayout],
    samples: u32,
    depth_compare: wgpu::CompareFunction,
    depth_write: bool,
    primitive: wgpu::PrimitiveState,
    blend: Option<wgpu::BlendState>,
}

fn pipeline(device: &wgpu::Device, special: &Special) -> wgpu::RenderPipeline {
    let module = module(device, special.program);
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

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let Layouts { frame, map, surface, textures, .. } = layouts;
        let screen = Special {
            program: Program::Background,
            vertex: "vs_background",
            fragment: Some("fs_background"),
            groups: &[frame],
            samples,
            depth_compare: wgpu::CompareFunction::Always,
            depth_write: false,
            primitive: BOTH_SIDES,
            blend: None,
        };
        let surface = Special {
            program: Program::Mesh,
            vertex: "vs_mesh",
            fragment: Some("fs_mesh"),
            groups: &[frame, map, surface, textures],
            depth_compare: wgpu::CompareFunction::Less,
            depth_write: true,
            ..screen
        };
        let ground = Special {
            program: Program::Ground,
            vertex: "vs_ground",
            fragment: Some("fs_ground"),
            groups: &[frame],
            primitive: sides(wgpu::PrimitiveTopology::TriangleStrip, Some(wgpu::Face::Back)),
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            ..surface
        };
        let shadow_view = Special {
            program: Program::ShadowView,
            vertex: "vs_shadow_view",
            fragment: Some("fs_shadow_view"),
            ..screen
        };
        let [background, mesh, ground, shadow_view] =
            [&screen, &surface, &ground, &shadow_view].map(|special| pipeline(device, special));
        Self { background, ground, mesh, shadow_view }
    }
}

/// What draws the maps of lights.
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

    /// Draws what the lights see.
    pub(super) fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        uploaded: &Uploaded,
        lighting: &Lighting,
        casters: Casters,
    ) {
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
            pass.set_bind_group(1, &uploaded.map_bindings, &[]);
            pass.set_bind_group(2, &uploaded.surface_bindings, &[]);
            pass.draw(0..uploaded.corner_count, 0..1);
        }
    }
}

/// What is computed of the displaced surface.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Result {
    Positions,
    /// And positions.
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
        let module = module(device, Program::Normals);
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

    pub(super) fn run(&self, encoder: &mut wgpu::CommandEncoder, uploaded: &Uploaded, result: Result) {
        let groups = uploaded.vertex_count.div_ceil(64);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(1, &uploaded.map_bindings, &[]);
        pass.set_bind_group(2, &uploaded.computed_surface_bindings, &[]);
        pass.set_bind_group(3, &uploaded.result_bindings, &[]);
        pass.set_pipeline(&self.positions);
        pass.dispatch_workgroups(groups.min(GROUPS_IN_ROW), groups.div_ceil(GROUPS_IN_ROW), 1);
        if result == Result::Normals {
            pass.set_pipeline(&self.normals);
            pass.dispatch_workgroups(groups.min(GROUPS_IN_ROW), groups.div_ceil(GROUPS_IN_ROW), 1);
        }
    }
}

fn module(device: &wgpu::Device, program: Program) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(source(program).into()),
    })
}

fn layout(device: &wgpu::Device, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}
