//! The colour bar beside a heat map: rectangles over the finished picture.

use super::{module, pipeline_layout};
use crate::gpu::{Gpu, GpuError};
use crate::layouts;
use crate::legend::Rectangle;
use crate::passes::resolve;
use crate::render_mesh::{buffer, entry, uniform};
use crate::settings::Size;
use crate::shaders::Program;
use glam::Vec4;
use std::collections::BTreeMap;

/// Pipelines by the view's format.
#[derive(Debug)]
pub(crate) struct LegendPass {
    group: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    pipelines: BTreeMap<String, wgpu::RenderPipeline>,
}

const RECTANGLE: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 32,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4],
};

impl LegendPass {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let group = layouts::layout(
            gpu,
            "legend",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[layouts::uniform::<crate::gpu_types::Legend>()],
        );
        let layout = pipeline_layout(gpu, &[&group]);
        Self { group, layout, module: module(gpu, Program::Legend), pipelines: BTreeMap::new() }
    }

    /// Draws rectangles over a view of this format.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        size: Size,
        rectangles: &[Rectangle],
    ) -> Result<(), GpuError> {
        if rectangles.is_empty() {
            return Ok(());
        }
        let instance = |r: &Rectangle| {
            let [[x, y], [w, h]] = [r.place, r.size].map(|pair| pair.map(|pixels| pixels as f32));
            [Vec4::new(x, y, w, h), r.colour.encoded().extend(1.0)]
        };
        let instances: Vec<[Vec4; 2]> = rectangles.iter().map(instance).collect();
        let instances = buffer(gpu, "legend", &instances, wgpu::BufferUsages::VERTEX)?;
        let legend = crate::gpu_types::Legend {
            width: size.width as f32,
            height: size.height as f32,
            decode: u32::from(format.is_srgb()),
            _pad: 0,
        };
        let uniform = uniform(gpu, "legend", &legend);
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("legend"),
            layout: &self.group,
            entries: &[entry(0, uniform.as_entire_binding())],
        });
        let Self { layout, module, pipelines, .. } = self;
        let make = || {
            let stages = ["vs_legend", "fs_legend"];
            resolve::flat_pipeline(gpu, "legend", layout, module, stages, &[Some(RECTANGLE)], format)
        };
        let pipeline = pipelines.entry(format!("{format:?}")).or_insert_with(make);
        let mut pass = resolve::begin(encoder, view, wgpu::LoadOp::Load);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.set_vertex_buffer(0, instances.slice(..));
        pass.draw(0..6, 0..rectangles.len() as u32);
        Ok(())
    }
}
