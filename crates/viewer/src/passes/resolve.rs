//! From samples in linear light to the pixels of a view.

use super::{module, pipeline_layout};
use crate::gpu::Gpu;
use crate::gpu_types;
use crate::layouts;
use crate::render_mesh::{entry, uniform};
use crate::shaders::Program;
use crate::targets::Targets;
use std::collections::BTreeMap;

/// Pipelines by the view's format.
#[derive(Debug)]
pub(crate) struct ResolvePass {
    module: wgpu::ShaderModule,
    group: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    uniform: wgpu::Buffer,
    pipelines: BTreeMap<String, wgpu::RenderPipeline>,
}

impl ResolvePass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let samples = layouts::texture(wgpu::TextureSampleType::Float { filterable: false });
        let bindings = [samples, layouts::uniform::<gpu_types::Resolve>()];
        let group = layouts::layout(gpu, "resolve", wgpu::ShaderStages::FRAGMENT, &bindings);
        let layout = pipeline_layout(gpu, &[&group]);
        let uniform = uniform(gpu, "resolve", &gpu_types::Resolve::default());
        Self { module: module(gpu, Program::Resolve), group, layout, uniform, pipelines: BTreeMap::new() }
    }

    /// Averages the samples of each pixel into a view of this format.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        view: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        supersampling: u32,
    ) {
        let encode = u32::from(!format.is_srgb());
        let resolve = gpu_types::Resolve { supersampling, encode, ..gpu_types::Resolve::default() };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&resolve));
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("resolve"),
            layout: &self.group,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&targets.colour)),
                entry(1, self.uniform.as_entire_binding()),
            ],
        });
        let Self { module, layout, pipelines, .. } = self;
        let pipeline = pipelines.entry(format!("{format:?}")).or_insert_with(|| {
            flat_pipeline(gpu, "resolve", layout, module, ["vs_screen", "fs_resolve"], &[], format)
        });
        let mut pass = begin(encoder, view, wgpu::LoadOp::Clear(wgpu::Color::BLACK));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A pass that draws into a view, without depth.
pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("view"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// A pipeline of such a pass; the entry points are those of the vertex and of the fragment stage.
pub(crate) fn flat_pipeline(
    gpu: &Gpu,
    label: &'static str,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    [vertex, fragment]: [&str; 2],
    buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let compilation_options = wgpu::PipelineCompilationOptions::default();
    let target = wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: compilation_options.clone(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options,
            targets: &[Some(target)],
        }),
        multiview_mask: None,
        cache: None,
    })
}
