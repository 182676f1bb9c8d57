//! Compiled programs.

use super::bindings::Layouts;
use super::uploaded::Uploaded;
use crate::gpu::{DEPTH, FORMAT};
use crate::shaders::{Program, source};

/// What draws to targets with some number of samples per pixel.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) background: wgpu::RenderPipeline,
    pub(super) mesh: wgpu::RenderPipeline,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, samples: u32) -> Self {
        let pipeline =
            |program, [vertex, fragment]: [&str; 2], groups: &[&wgpu::BindGroupLayout], depth_compare, write| {
                let module = module(device, program);
                let layout = layout(device, groups);
                device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(vertex),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some(vertex),
                        compilation_options: <_>::default(),
                        buffers: &[],
                    },
                    // Scans have holes, through which their insides are seen.
                    primitive: wgpu::PrimitiveState { cull_mode: None, ..<_>::default() },
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH,
                        depth_write_enabled: Some(write),
                        depth_compare: Some(depth_compare),
                        stencil: <_>::default(),
                        bias: <_>::default(),
                    }),
                    multisample: wgpu::MultisampleState { count: samples, ..<_>::default() },
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(fragment),
                        compilation_options: <_>::default(),
                        targets: &[Some(FORMAT.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
        let Layouts { frame, map, surface, textures, .. } = layouts;
        let mesh = [frame, map, surface, textures];
        let (always, less) = (wgpu::CompareFunction::Always, wgpu::CompareFunction::Less);
        Self {
            background: pipeline(Program::Background, ["vs_background", "fs_background"], &[frame], always, false),
            mesh: pipeline(Program::Mesh, ["vs_mesh", "fs_mesh"], &mesh, less, true),
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
        // The frame is not needed, but groups are counted from 0.
        let layout = layout(device, &[&layouts.frame, &layouts.map, &layouts.surface, &layouts.results]);
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
        pass.set_bind_group(0, &uploaded.frame_bindings, &[]);
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

fn layout(device: &wgpu::Device, groups: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}
