//! Scene that was uploaded to the device.

use super::bind_groups::{Layouts, bind};
use super::targets::{self, Samplers};
use crate::displaced_mesh::DisplacementBinding;
use crate::environment::cube::CubeMap;
use crate::gpu::render_mesh::{RenderMesh, Run, extras};
use crate::gpu::types::{Displacement, Frame};
use crate::gpu::{Gpu, NoGpu};
use crate::scene::Scene;
use crate::settings::Settings;
use bytemuck::Pod;
use glam::Vec3;
use planish_geometry::metrics::colormap::Colormap;
use wgpu::BufferUsages;

/// Buffers and textures of a scene on the device.
#[derive(Debug)]
pub struct GpuScene {
    pub(super) corner_count: u32,
    pub(super) vertex_count: u32,
    pub(super) frame: wgpu::Buffer,
    pub(super) displacement: wgpu::Buffer,
    pub(super) positions: wgpu::Buffer,
    extras: wgpu::Buffer,
    pub(super) map_bindings: wgpu::BindGroup,
    pub(super) surface_bindings: wgpu::BindGroup,
    /// Bind group of the surface for compute passes: it leaves out the normals that are being computed.
    pub(super) computed_surface_bindings: wgpu::BindGroup,
    pub(super) result_bindings: wgpu::BindGroup,
    pub(super) environment: wgpu::TextureView,
    pub(super) environment_sampler: wgpu::Sampler,
    /// Values of the volume; a single 0 without one.
    pub(super) volume: wgpu::TextureView,
    /// Ranges of corners that are drawn alike.
    pub(super) runs: Vec<Run>,
    textures: Vec<wgpu::TextureView>,
    /// White texel that stands in where there is no texture.
    plain: wgpu::TextureView,
    normal_maps: Vec<wgpu::TextureView>,
    occlusion_map: wgpu::TextureView,
    bytes: u64,
    /// Colour maps, in the order of [`Colormap::ALL`].
    heat_maps: Vec<wgpu::TextureView>,
}

impl GpuScene {
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts, scene: &Scene) -> Result<Self, NoGpu> {
        let device = &gpu.device;
        let mesh = RenderMesh::new(scene);
        let RenderMesh { vertices, extras, wedges, corners, rings, .. } = &mesh;
        let all = [contents(vertices), contents(extras), contents(wedges), contents(corners), contents(rings)];
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if let Some(bytes) = all.iter().map(|bytes| bytes.len() as u64).find(|bytes| *bytes > limit) {
            return Err(NoGpu::TooLarge { adapter: gpu.adapter.name.clone(), bytes, limit });
        }
        let volume = volume(gpu, scene)?;
        let storage = |bytes: &[u8]| gpu.filled(bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let buffer = |size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let uniform = |size: usize| buffer(size as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let [vertices, extras, wedges, corners, rings] = all.map(|bytes| storage(&bytes));
        let results = || buffer(16 * mesh.vertices.len().max(1) as u64, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let (positions, normals) = (results(), results());
        let frame = uniform(size_of::<Frame>());
        let displacement = uniform(size_of::<Displacement>());
        let height_map = scene
            .displacement
            .as_ref()
            .map_or_else(|| targets::floats(gpu, [1, 1], 1, &[0.0]), |binding| map(gpu, binding));
        let group = |layout, resources: &[wgpu::BindingResource]| bind(device, layout, resources);
        let plain = targets::plain(gpu, [u8::MAX; 4]);
        let uploaded = |texture| targets::upload_texture(gpu, texture);
        let surface = [&vertices, &extras, &wedges, &corners].map(wgpu::Buffer::as_entire_binding);
        let with = |normals: &wgpu::Buffer| {
            let [a, b, c, d] = surface.clone();
            group(&layouts.surface, &[a, b, c, d, normals.as_entire_binding()])
        };
        let buffers = [&vertices, &extras, &wedges, &corners, &rings, &positions, &normals];
        Ok(Self {
            bytes: buffers.iter().map(|buffer| buffer.size()).sum(),
            corner_count: mesh.corners.len() as u32,
            vertex_count: mesh.vertices.len() as u32,
            map_bindings: group(
                &layouts.map,
                &[wgpu::BindingResource::TextureView(&height_map), displacement.as_entire_binding()],
            ),
            surface_bindings: with(&normals),
            computed_surface_bindings: with(&vertices),
            result_bindings: group(
                &layouts.results,
                &[&positions, &normals, &rings].map(wgpu::Buffer::as_entire_binding),
            ),
            frame,
            displacement,
            positions,
            extras,
            environment: environment_map(gpu, scene),
            environment_sampler: targets::smooth_sampler(device),
            volume,
            runs: mesh.runs,
            textures: scene.textures.all().iter().map(uploaded).collect(),
            normal_maps: scene.normal_maps.all().iter().map(uploaded).collect(),
            occlusion_map: scene.occlusion_map().map_or_else(|| plain.clone(), uploaded),
            plain,
            heat_maps: Colormap::ALL.iter().map(|map| targets::row(gpu, &texels(*map))).collect(),
        })
    }

    /// Replaces the numbers of the vertices, for heat maps. `scene` is the one that was uploaded. Numbers that are not finite have no colour. #V
    pub(super) fn set_scalars(&self, gpu: &Gpu, scene: &Scene, scalars: &[f32]) {
        gpu.queue.write_buffer(&self.extras, 0, &contents(&extras(scene, Some(scalars))));
    }

    /// Returns the size of the buffers, bytes; textures come on top.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Binds the textures that a run of triangles is drawn with.
    pub(super) fn texture_bindings(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        samplers: &Samplers,
        settings: &Settings,
        run: &Run,
    ) -> wgpu::BindGroup {
        let texture = run.look.texture.map_or(&self.plain, |i| &self.textures[i as usize]);
        let normal_map = run.look.normal_map.map_or(&self.plain, |i| &self.normal_maps[i as usize]);
        let heat_map = Colormap::ALL.iter().position(|map| *map == settings.heat.map).unwrap_or(0);
        let view = wgpu::BindingResource::TextureView;
        let sampler = wgpu::BindingResource::Sampler(samplers.of(settings.sampling));
        let [normals, heat, occlusion] = [normal_map, &self.heat_maps[heat_map], &self.occlusion_map].map(view);
        let resources = [view(texture), sampler, normals, heat, occlusion];
        bind(device, &layouts.textures, &resources)
    }
}

/// Samples of a colour map: sRGB, as stored.
fn texels(map: Colormap) -> Vec<[u8; 4]> {
    let texel = |rgb: &u32| {
        let [_, r, g, b] = rgb.to_be_bytes();
        [r, g, b, u8::MAX]
    };
    map.samples().iter().map(texel).collect()
}

/// Bytes of an array, of at least one element: an empty buffer cannot be bound.
fn contents<T: Pod>(all: &[T]) -> Vec<u8> {
    if all.is_empty() { vec![0; size_of::<T>()] } else { bytemuck::cast_slice(all).to_vec() }
}

/// Uploads a displacement map: heights as one channel, vectors as three and one for the alignment.
fn map(gpu: &Gpu, binding: &DisplacementBinding) -> wgpu::TextureView {
    let (size, planes) = (binding.map.size(), binding.map.planes());
    match planes {
        [heights] => targets::floats(gpu, [size.width, size.height], 1, heights),
        planes => {
            let texel = |i: usize| [planes[0][i], planes[1][i], planes[2][i], 1.0];
            let texels: Vec<[f32; 4]> = (0..planes[0].len()).map(texel).collect();
            targets::floats(gpu, [size.width, size.height], 4, texels.as_flattened())
        }
    }
}

/// The values of a scene's volume on the device.
fn volume(gpu: &Gpu, scene: &Scene) -> Result<wgpu::TextureView, NoGpu> {
    let Some(volume) = scene.volume() else { return Ok(targets::grid(gpu, [1; 3], &[0.0])) };
    let (size, limit) = (volume.size(), gpu.device.limits().max_texture_dimension_3d);
    if size.iter().any(|n| *n > limit) {
        return Err(NoGpu::VolumeTooLarge { adapter: gpu.adapter.name.clone(), size, limit });
    }
    Ok(targets::grid(gpu, size, volume.values()))
}

/// The cube map of a scene on the device; black without one.
fn environment_map(gpu: &Gpu, scene: &Scene) -> wgpu::TextureView {
    let black = [CubeMap::from_fn(1, |_| Vec3::ZERO)];
    targets::cube(gpu, scene.environment.as_ref().map_or(&black[..], |environment| &environment.levels))
}
