//! A scene on the GPU: its wedges as buffers, its maps as textures.

use crate::gpu::{Gpu, GpuError};
use crate::gpu_types;
use crate::layouts::Layouts;
use crate::scene::{FrameNormals, Group, NormalMap, Scene};
use crate::settings::Sampling;
use crate::textures::{self, MapFormat};
use crate::wedges::{self, Wedges};
use bytemuck::{Pod, cast_slice};
use std::ops::Range;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _};

/// Everything of a scene that does not change from picture to picture.
#[derive(Debug)]
pub(crate) struct RenderMesh {
    /// For displacing: [`gpu_types::Wedge`].
    pub(crate) wedges: wgpu::Buffer,
    /// Normals of the mesh as it is.
    pub(crate) base_normals: wgpu::Buffer,
    /// For shading: [`gpu_types::Surfel`].
    pub(crate) surfels: wgpu::Buffer,
    /// Three for each triangle.
    pub(crate) indices: wgpu::Buffer,
    /// Triangles by material.
    pub(crate) groups: Vec<DrawGroup>,
    normal_map: wgpu::TextureView,
    relief: wgpu::TextureView,
    /// Bind group 1.
    pub(crate) displacement: wgpu::BindGroup,
    /// Its uniform, which holds λ.
    pub(crate) displacement_uniform: wgpu::Buffer,
    /// What of the uniform does not change.
    pub(crate) encoding: gpu_types::Displacement,
}

/// Indices of a material, and its pictures.
#[derive(Debug)]
pub(crate) struct DrawGroup {
    pub(crate) indices: Range<u32>,
    /// Bind group 2.
    pub(crate) pictures: wgpu::BindGroup,
    colour: wgpu::TextureView,
    present: gpu_types::Pictures,
}

impl RenderMesh {
    /// Uploads a scene. `wedges` are the scene's.
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts, scene: &Scene, wedges: &Wedges) -> Result<Self, GpuError> {
        let both = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE;
        let index = wgpu::BufferUsages::INDEX | wgpu::BufferUsages::STORAGE;
        let encoding = scene.carried().map_or(gpu_types::Displacement::default(), |carried| {
            let encoding = carried.map.encoding();
            let kind = wedges::kind(scene);
            gpu_types::Displacement { bias: encoding.bias, scale: encoding.scale, lambda: 0.0, kind }
        });
        let map = textures::displacement(gpu, scene.carried().map(|carried| &carried.map))?;
        let displacement_uniform = uniform(gpu, "displacement", &encoding);
        let displacement = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("displacement"),
            layout: &layouts.displacement,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&map)),
                entry(1, displacement_uniform.as_entire_binding()),
            ],
        });
        let normal_map = scene.normal_map.as_ref().map(|map| &map.texels);
        let normal_map = textures::picture(gpu, normal_map, MapFormat::Linear)?;
        let relief = textures::picture(gpu, scene.relief.as_ref(), MapFormat::Linear)?;
        let maps = [&normal_map, &relief];
        let draw_group = |group: &Group| DrawGroup::new(gpu, layouts, scene, group, maps);
        Ok(Self {
            wedges: buffer(gpu, "wedges", &wedges.wedges, both)?,
            base_normals: buffer(gpu, "base normals", &wedges.normals, both)?,
            surfels: buffer(
                gpu,
                "surfels",
                &wedges.surfels,
                wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            )?,
            indices: buffer(gpu, "indices", &wedges.triangles, index)?,
            groups: scene.groups().iter().map(draw_group).collect::<Result<_, _>>()?,
            normal_map,
            relief,
            displacement,
            displacement_uniform,
            encoding,
        })
    }

    /// Binds the pictures with another way to sample them.
    pub(crate) fn bind_pictures(&mut self, gpu: &Gpu, layouts: &Layouts, sampling: Sampling) {
        for group in &mut self.groups {
            group.present.filter_mode = sampling.filter as u32;
            let maps = [&self.normal_map, &self.relief];
            group.pictures = pictures(gpu, layouts, &group.colour, maps, &group.present, sampling);
        }
    }

    /// Sets λ for all that is submitted from now on.
    pub(crate) fn set_lambda(&self, gpu: &Gpu, lambda: f32) {
        let uniform = gpu_types::Displacement { lambda, ..self.encoding };
        gpu.queue.write_buffer(&self.displacement_uniform, 0, bytemuck::bytes_of(&uniform));
    }
}

impl DrawGroup {
    /// `maps` are the normal map and the relief.
    fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        scene: &Scene,
        group: &Group,
        maps: [&wgpu::TextureView; 2],
    ) -> Result<Self, GpuError> {
        let texture = scene.texture(group);
        let colour = textures::picture(gpu, texture, MapFormat::Srgb)?;
        let sampling = Sampling::default();
        let present = gpu_types::Pictures {
            has_colour: u32::from(texture.is_some()),
            has_normals: match scene.normal_map.as_ref().filter(|_| scene.mesh().tangents.is_some()) {
                None => 0,
                Some(NormalMap { frames: FrameNormals::Corner, .. }) => 1,
                Some(NormalMap { frames: FrameNormals::Carrier, .. }) => 2,
            },
            has_relief: u32::from(scene.relief.is_some()),
            filter_mode: sampling.filter as u32,
        };
        let indices = 3 * group.triangles.start as u32..3 * group.triangles.end as u32;
        let pictures = pictures(gpu, layouts, &colour, maps, &present, sampling);
        Ok(Self { indices, pictures, colour, present })
    }
}

/// Bind group 2; `maps` are the normal map and the relief.
fn pictures(
    gpu: &Gpu,
    layouts: &Layouts,
    colour: &wgpu::TextureView,
    [normal_map, relief]: [&wgpu::TextureView; 2],
    present: &gpu_types::Pictures,
    sampling: Sampling,
) -> wgpu::BindGroup {
    let sampler = textures::sampler(gpu, sampling);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("pictures"),
        layout: &layouts.pictures,
        entries: &[
            entry(0, wgpu::BindingResource::TextureView(colour)),
            entry(1, wgpu::BindingResource::Sampler(&sampler)),
            entry(2, wgpu::BindingResource::TextureView(normal_map)),
            entry(3, wgpu::BindingResource::TextureView(relief)),
            entry(4, uniform(gpu, "pictures", present).as_entire_binding()),
        ],
    })
}

/// A buffer with this content; never an empty one, which could not be bound.
pub(crate) fn buffer<T: Pod>(
    gpu: &Gpu,
    label: &'static str,
    content: &[T],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let padding = [T::zeroed()];
    let bytes: &[u8] = if content.is_empty() { cast_slice(&padding) } else { cast_slice(content) };
    let limits = gpu.device.limits();
    let bound = usage.contains(wgpu::BufferUsages::STORAGE).then_some(limits.max_storage_buffer_binding_size);
    let limit = bound.map_or(limits.max_buffer_size, |b| b.min(limits.max_buffer_size));
    gpu.ensure("a mesh buffer in bytes", bytes.len() as u64, limit)?;
    Ok(gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents: bytes, usage }))
}

/// A uniform buffer that can be written again.
pub(crate) fn uniform<T: Pod>(gpu: &Gpu, label: &'static str, content: &T) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let contents = bytemuck::bytes_of(content);
    gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
}

/// One line of a bind group.
pub(crate) fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}
