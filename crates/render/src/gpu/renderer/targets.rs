//! Textures: those that are drawn from, and those that are drawn to.

use crate::environment::MAX_RADIANCE;
use crate::environment::cube::CubeMap;
use crate::gpu::{FORMAT, Gpu};
use crate::settings::{Sampling, Size};
use crate::texture::{Content, Texture};
use half::f16;
use image::RgbaImage;
use wgpu::util::{DeviceExt as _, TextureDataOrder};

/// Creates a texture that can be drawn to, and returns a view of it.
pub(super) fn attachment(
    device: &wgpu::Device,
    size: Size,
    samples: u32,
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        sample_count: samples,
        ..flat(size.width, size.height, format, wgpu::TextureUsages::RENDER_ATTACHMENT)
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn flat(
    width: u32,
    height: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

/// Creates a picture that can be drawn to and read back.
pub(super) fn canvas(device: &wgpu::Device, size: Size) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    device.create_texture(&flat(size.width, size.height, FORMAT, usage))
}

/// Reads back the pixels of a canvas; black if the device is lost.
pub(super) fn read(gpu: &Gpu, texture: &wgpu::Texture) -> RgbaImage {
    let (width, height) = (texture.width(), texture.height());
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.mapped(&buffer);
    let rows = bytes.chunks_exact(row as usize).flat_map(|bytes| &bytes[..4 * width as usize]);
    RgbaImage::from_raw(width, height, rows.copied().collect()).unwrap_or_else(|| RgbaImage::new(width, height))
}

/// A picture with its levels of detail. The finest ones are left out that are larger than the device allows.
pub(super) fn upload_texture(gpu: &Gpu, texture: &Texture) -> wgpu::TextureView {
    let most = gpu.device.limits().max_texture_dimension_2d;
    let fits = |level: &&RgbaImage| level.width() <= most && level.height() <= most;
    let levels: Vec<&RgbaImage> = texture.levels().iter().filter(fits).collect();
    let Some(first) = levels.first() else { return plain(gpu, [u8::MAX; 4]) };
    let format = match texture.content() {
        Content::Colour => wgpu::TextureFormat::Rgba8UnormSrgb,
        Content::Data => wgpu::TextureFormat::Rgba8Unorm,
    };
    let bytes: Vec<u8> = levels.iter().flat_map(|level| level.as_raw()).copied().collect();
    let descriptor = wgpu::TextureDescriptor {
        mip_level_count: levels.len() as u32,
        ..flat(first.width(), first.height(), format, wgpu::TextureUsages::TEXTURE_BINDING)
    };
    view(gpu, &descriptor, &bytes)
}

/// Uploads a single texel, which stands in where there is no picture.
pub(super) fn plain(gpu: &Gpu, texel: [u8; 4]) -> wgpu::TextureView {
    row(gpu, &[texel])
}

/// Uploads one row of texels as plain numbers.
pub(super) fn row(gpu: &Gpu, texels: &[[u8; 4]]) -> wgpu::TextureView {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    view(gpu, &flat(texels.len() as u32, 1, format, wgpu::TextureUsages::TEXTURE_BINDING), texels.as_flattened())
}

/// Floating-point texels with one or four channels, row by row.
pub(super) fn floats(gpu: &Gpu, [width, height]: [u32; 2], channels: usize, texels: &[f32]) -> wgpu::TextureView {
    let format = if channels == 1 { wgpu::TextureFormat::R32Float } else { wgpu::TextureFormat::Rgba32Float };
    view(gpu, &flat(width, height, format, wgpu::TextureUsages::TEXTURE_BINDING), bytemuck::cast_slice(texels))
}

/// Values on a grid in space, the first axis fastest.
pub(super) fn grid(gpu: &Gpu, [width, height, depth]: [u32; 3], values: &[f32]) -> wgpu::TextureView {
    let descriptor = wgpu::TextureDescriptor {
        size: wgpu::Extent3d { width, height, depth_or_array_layers: depth },
        dimension: wgpu::TextureDimension::D3,
        ..flat(width, height, wgpu::TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING)
    };
    view(gpu, &descriptor, bytemuck::cast_slice(values))
}

fn view(gpu: &Gpu, descriptor: &wgpu::TextureDescriptor, bytes: &[u8]) -> wgpu::TextureView {
    let texture = gpu.device.create_texture_with_data(&gpu.queue, descriptor, TextureDataOrder::MipMajor, bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A cube map with its levels of detail, as half floats.
pub(super) fn cube(gpu: &Gpu, levels: &[CubeMap]) -> wgpu::TextureView {
    let half = |c: f32| f16::from_f32(c.min(MAX_RADIANCE)).to_bits();
    let face = |level: &CubeMap, face: usize| -> Vec<u16> {
        let texels = level.size() * level.size();
        let texels = &level.texels()[face * texels..(face + 1) * texels];
        texels.iter().flat_map(|t| [half(t.x), half(t.y), half(t.z), half(1.0)]).collect()
    };
    let texels: Vec<u16> = (0..6).flat_map(|f| levels.iter().flat_map(move |level| face(level, f))).collect();
    let size = levels.first().map_or(1, CubeMap::size) as u32;
    let descriptor = wgpu::TextureDescriptor {
        size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 6 },
        mip_level_count: levels.len() as u32,
        ..flat(size, size, wgpu::TextureFormat::Rgba16Float, wgpu::TextureUsages::TEXTURE_BINDING)
    };
    let texels = bytemuck::cast_slice(&texels);
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, texels);
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::Cube),
        ..wgpu::TextureViewDescriptor::default()
    })
}

/// Sampler that interpolates between texels and levels of detail.
pub(super) fn smooth_sampler(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

/// Samplers of textures.
#[derive(Debug)]
pub(super) struct Samplers {
    linear: wgpu::Sampler,
    anisotropic: wgpu::Sampler,
}

impl Samplers {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let sampler = |anisotropy_clamp| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp,
                ..wgpu::SamplerDescriptor::default()
            })
        };
        Self { linear: sampler(1), anisotropic: sampler(16) }
    }

    pub(super) fn of(&self, sampling: Sampling) -> &wgpu::Sampler {
        if sampling == Sampling::Anisotropic { &self.anisotropic } else { &self.linear }
    }
}
