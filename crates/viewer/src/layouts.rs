//! Bind group layouts, which all pipelines share: 0 the picture, 1 the displacement map, 2 pictures on the surface. Group 3
//! belongs to what only some passes need.

use crate::gpu::Gpu;
use crate::gpu_types;

/// The layouts.
#[derive(Debug)]
pub(crate) struct Layouts {
    /// Group 0: `shaders/frame.wgsl`.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Group 1: `shaders/displace.wgsl`.
    pub(crate) displacement: wgpu::BindGroupLayout,
    /// Group 2: `shaders/pictures.wgsl`.
    pub(crate) pictures: wgpu::BindGroupLayout,
}

const DRAWING: wgpu::ShaderStages = wgpu::ShaderStages::VERTEX_FRAGMENT;

impl Layouts {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let any = || texture(wgpu::TextureSampleType::Float { filterable: true });
        let exact = texture(wgpu::TextureSampleType::Float { filterable: false });
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            frame: layout(
                gpu,
                "frame",
                DRAWING | wgpu::ShaderStages::COMPUTE,
                &[uniform::<gpu_types::Frame>(), uniform::<gpu_types::Lights>(), uniform::<gpu_types::Material>()],
            ),
            displacement: layout(
                gpu,
                "displacement",
                DRAWING | wgpu::ShaderStages::COMPUTE,
                &[exact, uniform::<gpu_types::Displacement>()],
            ),
            pictures: layout(
                gpu,
                "pictures",
                DRAWING | wgpu::ShaderStages::COMPUTE,
                &[any(), sampler, any(), any(), uniform::<gpu_types::Pictures>()],
            ),
        }
    }
}

/// A layout with these bindings, from 0.
pub(crate) fn layout(
    gpu: &Gpu,
    label: &'static str,
    visibility: wgpu::ShaderStages,
    bindings: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: *ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(bindings).map(entry).collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A uniform of this type.
pub(crate) fn uniform<T>() -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: wgpu::BufferSize::new(size_of::<T>() as u64),
    }
}

/// A storage buffer.
pub(crate) fn storage(read_only: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only },
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

/// A flat texture.
pub(crate) fn texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2, multisampled: false }
}
