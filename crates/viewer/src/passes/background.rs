//! What is behind the model.

use super::{Blending, Drawing, module, pipeline, pipeline_layout};
use crate::gpu::Gpu;
use crate::gpu_types;
use crate::layouts::{self, Layouts};
use crate::render_mesh::{entry, uniform};
use crate::settings::Background;
use crate::shaders::Program;
use std::collections::BTreeMap;

/// Pipelines of the gradient.
#[derive(Debug)]
pub(crate) struct BackgroundPass {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    colours: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    pipelines: BTreeMap<u32, wgpu::RenderPipeline>,
}

impl BackgroundPass {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let bindings = [layouts::uniform::<gpu_types::Background>()];
        let own = layouts::layout(gpu, "background", wgpu::ShaderStages::FRAGMENT, &bindings);
        let colours = uniform(gpu, "background", &gpu_types::Background::default());
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("background"),
            layout: &own,
            entries: &[entry(0, colours.as_entire_binding())],
        });
        let layout = pipeline_layout(gpu, &[&layouts.frame, &own]);
        Self { module: module(gpu, Program::Background), layout, colours, bind_group, pipelines: BTreeMap::new() }
    }

    /// Fills the picture. The frame is bound.
    pub(crate) fn draw(&mut self, gpu: &Gpu, pass: &mut wgpu::RenderPass<'_>, colours: &Background, samples: u32) {
        let [top, bottom] = [colours.top, colours.bottom].map(|colour| colour.encoded().extend(1.0));
        gpu.queue.write_buffer(&self.colours, 0, bytemuck::bytes_of(&gpu_types::Background { top, bottom }));
        let Self { module, layout, pipelines, .. } = self;
        let make = || {
            let (label, vertex, fragment, blending) = ("background", "vs_screen", "fs_background", Blending::Behind);
            pipeline(gpu, &Drawing { label, layout, module, vertex, fragment, buffers: &[], blending, samples })
        };
        pass.set_pipeline(pipelines.entry(samples).or_insert_with(make));
        pass.set_bind_group(1, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}
