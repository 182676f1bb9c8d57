//! Compute passes: displaced positions of the wedges, and the normals of the displaced surface.

use super::{module, pipeline_layout};
use crate::gpu::{Gpu, GpuError};
use crate::layouts::{self, Layouts};
use crate::render_mesh::{RenderMesh, buffer, entry};
use crate::shaders::Program;
use crate::wedges::Wedges;
use glam::Vec4;

/// Invocations of a work group, as `GROUP` in `shaders/derive.wgsl`.
const GROUP: u32 = 256;

/// The pipelines.
#[derive(Debug)]
pub(crate) struct DerivePass {
    group: wgpu::BindGroupLayout,
    places: wgpu::ComputePipeline,
    normals: wgpu::ComputePipeline,
}

/// What belongs to one mesh.
#[derive(Debug)]
pub(crate) struct Derived {
    bind_group: wgpu::BindGroup,
    /// Displaced positions of the wedges; the fourth number means nothing. #W
    pub(crate) places: wgpu::Buffer,
    /// Normals of the displaced surface, likewise. #W
    pub(crate) normals: wgpu::Buffer,
    work_groups: [u32; 2],
}

impl DerivePass {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let [read, write] = [true, false].map(layouts::storage);
        let bindings = [read, write, read, read, write];
        let group = layouts::layout(gpu, "derive", wgpu::ShaderStages::COMPUTE, &bindings);
        let layout = pipeline_layout(gpu, &[&group, &layouts.displacement]);
        let module = module(gpu, Program::Derive);
        let pipeline = |entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { places: pipeline("cs_places"), normals: pipeline("cs_normals"), group }
    }

    /// Buffers for a mesh.
    pub(crate) fn prepare(&self, gpu: &Gpu, mesh: &RenderMesh, wedges: &Wedges) -> Result<Derived, GpuError> {
        let (firsts, corners) = rings(wedges);
        let storage = wgpu::BufferUsages::STORAGE;
        let zeros = vec![Vec4::ZERO; wedges.wedges.len()];
        let readable = storage | wgpu::BufferUsages::COPY_SRC;
        let places = buffer(gpu, "places", &zeros, readable)?;
        let normals = buffer(gpu, "derived normals", &zeros, readable | wgpu::BufferUsages::VERTEX)?;
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("derive"),
            layout: &self.group,
            entries: &[
                entry(0, mesh.wedges.as_entire_binding()),
                entry(1, places.as_entire_binding()),
                entry(2, buffer(gpu, "firsts", &firsts, storage)?.as_entire_binding()),
                entry(3, buffer(gpu, "corners", &corners, storage)?.as_entire_binding()),
                entry(4, normals.as_entire_binding()),
            ],
        });
        let groups = (wedges.wedges.len() as u32).div_ceil(GROUP);
        let in_a_row = groups.clamp(1, gpu.device.limits().max_compute_workgroups_per_dimension);
        Ok(Derived { bind_group, places, normals, work_groups: [in_a_row, groups.div_ceil(in_a_row)] })
    }

    /// Computes both with the λ that was written.
    pub(crate) fn run(&self, encoder: &mut wgpu::CommandEncoder, mesh: &RenderMesh, derived: &Derived) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, &derived.bind_group, &[]);
        pass.set_bind_group(1, &mesh.displacement, &[]);
        let [x, y] = derived.work_groups;
        for pipeline in [&self.places, &self.normals] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(x, y, 1);
        }
    }
}

/// For each vertex (#V + 1) where its corners begin, and for each corner the wedges at the other two of its triangle.
/// Corners of a vertex come in the order of the triangles.
fn rings(wedges: &Wedges) -> (Vec<u32>, Vec<[u32; 2]>) {
    let vertex = |wedge: u32| wedges.wedges[wedge as usize].vertex as usize;
    let mut firsts = vec![0u32; wedges.vertices + 1];
    for &wedge in wedges.triangles.iter().flatten() {
        firsts[vertex(wedge) + 1] += 1;
    }
    for v in 0..wedges.vertices {
        firsts[v + 1] += firsts[v];
    }
    let mut next = firsts.clone();
    let mut corners = vec![[0; 2]; 3 * wedges.triangles.len()];
    for &[a, b, c] in &wedges.triangles {
        for [own, following, previous] in [[a, b, c], [b, c, a], [c, a, b]] {
            let place = &mut next[vertex(own)];
            corners[*place as usize] = [following, previous];
            *place += 1;
        }
    }
    (firsts, corners)
}
