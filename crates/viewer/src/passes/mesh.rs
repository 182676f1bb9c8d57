//! The displaced mesh, shaded.

use super::{Blending, Drawing, module, pipeline, pipeline_layout};
use crate::gpu::Gpu;
use crate::gpu_types::{Surfel, Wedge};
use crate::layouts::Layouts;
use crate::render_mesh::RenderMesh;
use crate::settings::Shading;
use crate::shaders::Program;
use std::collections::BTreeMap;

/// Pipelines of the mesh, made when they are first needed.
#[derive(Debug)]
pub(crate) struct MeshPass {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    pipelines: BTreeMap<(&'static str, u32), wgpu::RenderPipeline>,
}

/// What displacing needs of a wedge: all passes that draw the mesh have it as their first buffer.
pub(crate) const WEDGE: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Wedge>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Uint32, 2 => Float32x3, 3 => Uint32, 4 => Float32x2, 5 => Float32x2, 6 => Float32x4
    ],
};

const NORMAL: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 16,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![7 => Float32x3],
};

const SURFEL: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Surfel>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![8 => Float32x4, 9 => Float32x2, 10 => Float32x2],
};

/// The entry points of a way to shade: vertex and fragment stage.
fn entry_points(shading: Shading) -> (&'static str, &'static str) {
    match shading {
        Shading::Flat => ("vs_mesh", "fs_flat"),
        Shading::Gouraud => ("vs_gouraud", "fs_gouraud"),
        Shading::BlinnPhong => ("vs_mesh", "fs_blinn_phong"),
        Shading::Texture | Shading::Bump | Shading::Displacement => ("vs_mesh", "fs_texture"),
        Shading::Normals => ("vs_mesh", "fs_normals"),
        Shading::Clay => ("vs_mesh", "fs_clay"),
        Shading::Checker => ("vs_mesh", "fs_checker"),
        Shading::Heat => ("vs_mesh", "fs_heat"),
    }
}

impl MeshPass {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let layout = pipeline_layout(gpu, &[&layouts.frame, &layouts.displacement, &layouts.pictures]);
        Self { module: module(gpu, Program::Mesh), layout, pipelines: BTreeMap::new() }
    }

    /// Draws the mesh with these normals. The frame is bound.
    pub(crate) fn draw(
        &mut self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        mesh: &RenderMesh,
        normals: &wgpu::Buffer,
        shading: Shading,
        samples: u32,
    ) {
        let (vertex, fragment) = entry_points(shading);
        let Self { module, layout, pipelines } = self;
        let make = || {
            let buffers = &[Some(WEDGE), Some(NORMAL), Some(SURFEL)];
            let (label, blending) = ("mesh", Blending::Opaque);
            pipeline(gpu, &Drawing { label, layout, module, vertex, fragment, buffers, blending, samples })
        };
        pass.set_pipeline(pipelines.entry((fragment, samples)).or_insert_with(make));
        pass.set_bind_group(1, &mesh.displacement, &[]);
        pass.set_vertex_buffer(0, mesh.wedges.slice(..));
        pass.set_vertex_buffer(1, normals.slice(..));
        pass.set_vertex_buffer(2, mesh.surfels.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        for group in &mesh.groups {
            pass.set_bind_group(2, &group.pictures, &[]);
            pass.draw_indexed(group.indices.clone(), 0, 0..1);
        }
    }
}
