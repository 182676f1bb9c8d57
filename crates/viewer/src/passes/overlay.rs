//! Wires and seams over the mesh.

use super::{Blending, Drawing, module, pipeline, pipeline_layout};
use crate::gpu::{Gpu, GpuError};
use crate::gpu_types;
use crate::layouts::{self, Layouts};
use crate::render_mesh::{RenderMesh, buffer, entry, uniform};
use crate::settings::{Overlay, Settings};
use crate::shaders::Program;
use crate::wedges::Wedges;
use glam::Vec4;
use std::collections::BTreeMap;

/// Pipelines by samples of MSAA.
#[derive(Debug)]
pub(crate) struct OverlayPass {
    group: wgpu::BindGroupLayout,
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    pipelines: BTreeMap<u32, wgpu::RenderPipeline>,
}

/// What belongs to one mesh.
#[derive(Debug)]
pub(crate) struct Lines {
    bind_group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
}

impl OverlayPass {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let read = layouts::storage(true);
        let bindings = [read, read, read, layouts::uniform::<gpu_types::Overlay>()];
        let group = layouts::layout(gpu, "overlay", wgpu::ShaderStages::VERTEX_FRAGMENT, &bindings);
        let layout = pipeline_layout(gpu, &[&layouts.frame, &layouts.displacement, &layouts.pictures, &group]);
        Self { group, module: module(gpu, Program::Overlay), layout, pipelines: BTreeMap::new() }
    }

    /// Buffers for a mesh.
    pub(crate) fn prepare(&self, gpu: &Gpu, mesh: &RenderMesh, wedges: &Wedges) -> Result<Lines, GpuError> {
        let uniform = uniform(gpu, "overlay", &gpu_types::Overlay::default());
        let cuts = buffer(gpu, "cuts", &wedges.cuts(), wgpu::BufferUsages::STORAGE)?;
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("overlay"),
            layout: &self.group,
            entries: &[
                entry(0, mesh.wedges.as_entire_binding()),
                entry(1, mesh.indices.as_entire_binding()),
                entry(2, cuts.as_entire_binding()),
                entry(3, uniform.as_entire_binding()),
            ],
        });
        Ok(Lines { bind_group, uniform })
    }

    /// Draws lines, after the mesh. The frame is bound.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        mesh: &RenderMesh,
        lines: &Lines,
        settings: &Settings,
        samples: u32,
    ) {
        gpu.queue.write_buffer(&lines.uniform, 0, bytemuck::bytes_of(&overlay(settings)));
        let Self { module, layout, pipelines, .. } = self;
        let make = || {
            let (label, vertex, fragment, blending) = ("overlay", "vs_overlay", "fs_overlay", Blending::Over);
            pipeline(gpu, &Drawing { label, layout, module, vertex, fragment, buffers: &[], blending, samples })
        };
        pass.set_pipeline(pipelines.entry(samples).or_insert_with(make));
        pass.set_bind_group(1, &mesh.displacement, &[]);
        pass.set_bind_group(3, &lines.bind_group, &[]);
        for group in &mesh.groups {
            // The relief lifts the surface.
            pass.set_bind_group(2, &group.pictures, &[]);
            pass.draw(group.indices.clone(), 0..1);
        }
    }
}

fn overlay(settings: &Settings) -> gpu_types::Overlay {
    let Overlay { wireframe, seams, width } = settings.overlay;
    let colour = |line: Option<crate::colour::Colour>| line.map_or(Vec4::ZERO, |colour| colour.linear().extend(1.0));
    gpu_types::Overlay {
        wireframe: colour(wireframe),
        seams: colour(seams),
        width: width * settings.supersampling as f32,
        ..gpu_types::Overlay::default()
    }
}
