//! Layouts of the bind groups; groups and binding numbers are those in `shaders/`.

use crate::gpu::types::Caster;
use wgpu::ShaderStages;

/// Layouts of the bind groups.
#[derive(Debug)]
pub(super) struct Layouts {
    /// Group 0: the frame, and what lights it.
    pub(super) frame: wgpu::BindGroupLayout,
    /// Group 0 of the shadow map pass: the view of a light.
    pub(super) caster: wgpu::BindGroupLayout,
    /// Group 1: the displacement map.
    pub(super) map: wgpu::BindGroupLayout,
    /// Group 2: the mesh.
    pub(super) surface: wgpu::BindGroupLayout,
    /// Group 3 of the colour pass: textures.
    pub(super) textures: wgpu::BindGroupLayout,
    /// Group 3 of compute passes: results.
    pub(super) results: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let all = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let group = |label, kinds: &[(ShaderStages, wgpu::BindingType)]| {
            let entry = |(binding, &(visibility, ty)): (u32, &(ShaderStages, wgpu::BindingType))| {
                wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
            };
            let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let vertex = ShaderStages::VERTEX | ShaderStages::COMPUTE;
        let fragment = ShaderStages::FRAGMENT;
        Self {
            frame: group(
                "frame",
                &[UNIFORM, UNIFORM, LAYERS, UNIFORM, CUBE, SAMPLER, UNIFORM, NEAREST, UNIFORM, GRID]
                    .map(|kind| (ShaderStages::VERTEX_FRAGMENT, kind)),
            ),
            caster: group("caster", &[(ShaderStages::VERTEX, ONE_OF_MANY)]),
            map: group("map", &[(all, EXACT), (all, UNIFORM)]),
            surface: group(
                "surface",
                &[(vertex, READ), (vertex, READ), (vertex, READ), (vertex, READ), (ShaderStages::VERTEX, READ)],
            ),
            textures: group(
                "textures",
                &[
                    (fragment, FILTERED),
                    (fragment, SAMPLER),
                    (fragment, EXACT),
                    (fragment, EXACT),
                    (ShaderStages::VERTEX_FRAGMENT, EXACT),
                ],
            ),
            results: group("results", &[WRITE, WRITE, READ].map(|kind| (ShaderStages::COMPUTE, kind))),
        }
    }
}

const UNIFORM: wgpu::BindingType = buffer(wgpu::BufferBindingType::Uniform);
const READ: wgpu::BindingType = buffer(wgpu::BufferBindingType::Storage { read_only: true });
const WRITE: wgpu::BindingType = buffer(wgpu::BufferBindingType::Storage { read_only: false });
const SAMPLER: wgpu::BindingType = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
const NEAREST: wgpu::BindingType = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
/// Texture that is only ever read texel by texel.
const EXACT: wgpu::BindingType = texture(wgpu::TextureSampleType::Float { filterable: false });
const FILTERED: wgpu::BindingType = texture(wgpu::TextureSampleType::Float { filterable: true });

const ONE_OF_MANY: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: true,
    min_binding_size: wgpu::BufferSize::new(size_of::<Caster>() as u64),
};
/// Layers of depth that are read texel by texel.
const LAYERS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2Array,
    multisampled: false,
};
/// Values on a grid in space that are read one by one.
const GRID: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D3,
    multisampled: false,
};
const CUBE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: true },
    view_dimension: wgpu::TextureViewDimension::Cube,
    multisampled: false,
};

const fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

const fn texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2, multisampled: false }
}

/// Binds resources in the order of their binding numbers.
pub(super) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let numbered = (0..).zip(resources);
    let entries: Vec<_> =
        numbered.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
