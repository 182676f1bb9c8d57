//! One file for each thing that is drawn. A pass owns its pipelines and what only it binds; the renderer owns the order.

pub(crate) mod background;
pub(crate) mod derive;
pub(crate) mod legend;
pub(crate) mod mesh;
pub(crate) mod overlay;
pub(crate) mod resolve;

use crate::gpu::Gpu;
use crate::shaders::{Program, source};
use crate::targets;

/// The module of a program.
pub(crate) fn module(gpu: &Gpu, program: Program) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("planish"),
        source: wgpu::ShaderSource::Wgsl(source(program).into()),
    })
}

/// A pipeline layout of these bind groups, from 0.
pub(crate) fn pipeline_layout(gpu: &Gpu, groups: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().copied().map(Some).collect();
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &groups,
        ..wgpu::PipelineLayoutDescriptor::default()
    })
}

/// How a pipeline of the picture's pass treats depth and colour.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Blending {
    /// What is nearer replaces what is there.
    Opaque,
    /// Blends over what is there; depth is compared and stays.
    Over,
    /// Replaces what is there, whatever its depth.
    Behind,
}

/// What tells pipelines of the picture's pass apart.
pub(crate) struct Drawing<'a> {
    pub(crate) label: &'static str,
    pub(crate) layout: &'a wgpu::PipelineLayout,
    pub(crate) module: &'a wgpu::ShaderModule,
    pub(crate) vertex: &'a str,
    pub(crate) fragment: &'a str,
    pub(crate) buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub(crate) blending: Blending,
    /// Of MSAA.
    pub(crate) samples: u32,
}

/// A pipeline of the picture's pass.
pub(crate) fn pipeline(gpu: &Gpu, drawing: &Drawing<'_>) -> wgpu::RenderPipeline {
    let (depth_write, compare, blend) = match drawing.blending {
        Blending::Opaque => (true, wgpu::CompareFunction::Less, None),
        Blending::Over => (false, wgpu::CompareFunction::LessEqual, Some(wgpu::BlendState::ALPHA_BLENDING)),
        Blending::Behind => (false, wgpu::CompareFunction::Always, None),
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(drawing.label),
        layout: Some(drawing.layout),
        vertex: wgpu::VertexState {
            module: drawing.module,
            entry_point: Some(drawing.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: drawing.buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: targets::DEPTH,
            depth_write_enabled: Some(depth_write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: drawing.samples, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: drawing.module,
            entry_point: Some(drawing.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: targets::COLOUR,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
