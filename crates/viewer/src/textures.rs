//! Images as textures of the GPU.

use crate::gpu::{Gpu, GpuError};
use crate::settings::{Filter, Sampling};
use crate::texture::Texture;
use bytemuck::cast_slice;
use image::RgbaImage;
use planish_geometry::displacement::Displacement;

/// What the bytes of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MapFormat {
    /// Colours.
    Srgb,
    /// Numbers.
    Linear,
}

/// One level of a texture: its columns, rows and bytes.
pub(crate) struct Level<'a> {
    pub(crate) size: [u32; 2],
    pub(crate) bytes: &'a [u8],
}

/// A texture with these levels, the largest first.
pub(crate) fn upload(
    gpu: &Gpu,
    label: &'static str,
    format: wgpu::TextureFormat,
    levels: &[Level<'_>],
) -> Result<wgpu::TextureView, GpuError> {
    let [width, height] = levels[0].size;
    let limit = u64::from(gpu.device.limits().max_texture_dimension_2d);
    gpu.ensure("a side of a texture", width.max(height).into(), limit)?;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: extent([width, height]),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(levels) {
        let place = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let rows = level.size[1];
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(level.bytes.len() as u32 / rows),
            rows_per_image: Some(rows),
        };
        gpu.queue.write_texture(place, level.bytes, layout, extent(level.size));
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// An image; a single texel where there is none.
pub(crate) fn picture(gpu: &Gpu, picture: Option<&Texture>, format: MapFormat) -> Result<wgpu::TextureView, GpuError> {
    let format = match format {
        MapFormat::Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
        MapFormat::Linear => wgpu::TextureFormat::Rgba8Unorm,
    };
    let Some(picture) = picture else {
        return upload(gpu, "no picture", format, &[Level { size: [1, 1], bytes: &[0; 4] }]);
    };
    // Numbers are read from the image itself.
    let count = if format.is_srgb() { picture.levels().len() } else { 1 };
    let levels: Vec<Level<'_>> =
        picture.levels()[..count].iter().map(|image: &RgbaImage| Level { size: image.dimensions().into(), bytes: image.as_raw() }).collect();
    upload(gpu, "picture", format, &levels)
}

/// A sampler for colours that repeat; the cubic filter needs none.
pub(crate) fn sampler(gpu: &Gpu, sampling: Sampling) -> wgpu::Sampler {
    let (within, between) = match sampling.filter {
        Filter::Nearest => (wgpu::FilterMode::Nearest, None),
        Filter::Bilinear | Filter::Bicubic => (wgpu::FilterMode::Linear, None),
        Filter::Trilinear | Filter::Anisotropic => (wgpu::FilterMode::Linear, Some(wgpu::MipmapFilterMode::Linear)),
    };
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("colours"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: within,
        min_filter: within,
        mipmap_filter: between.unwrap_or(wgpu::MipmapFilterMode::Nearest),
        lod_max_clamp: if between.is_some() { 32.0 } else { 0.0 },
        anisotropy_clamp: if sampling.filter == Filter::Anisotropic { sampling.anisotropy } else { 1 },
        ..wgpu::SamplerDescriptor::default()
    })
}

/// A displacement map: one channel of heights or three of vectors, in single precision, to be read without a sampler.
pub(crate) fn displacement(gpu: &Gpu, map: Option<&Displacement>) -> Result<wgpu::TextureView, GpuError> {
    let Some(map) = map else {
        let level = Level { size: [1, 1], bytes: &[0; 4] };
        return upload(gpu, "no displacement", wgpu::TextureFormat::R32Float, &[level]);
    };
    let size = [map.size().width, map.size().height];
    match map.planes() {
        [heights] => {
            let level = Level { size, bytes: cast_slice(heights) };
            upload(gpu, "heights", wgpu::TextureFormat::R32Float, &[level])
        }
        planes => {
            let channel = |k: usize, i: usize| planes.get(k).map_or(0.0, |plane| plane[i]);
            let texels: Vec<[f32; 4]> =
                (0..map.size().texels()).map(|i| std::array::from_fn(|k| channel(k, i))).collect();
            let level = Level { size, bytes: cast_slice(&texels) };
            upload(gpu, "vectors", wgpu::TextureFormat::Rgba32Float, &[level])
        }
    }
}

/// Of a flat image.
pub(crate) fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}
