//! A picture from the GPU, in memory.

use crate::gpu::{Gpu, GpuError};
use crate::renderer::{Canvas, Drawable, Renderer};
use crate::settings::Settings;
use crate::textures::extent;
use image::RgbaImage;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Draws a picture of the size that the settings say.
pub fn render(
    gpu: &Gpu,
    renderer: &mut Renderer,
    drawable: &mut Drawable,
    settings: &Settings,
) -> Result<RgbaImage, GpuError> {
    let size = settings.size;
    let limit = u64::from(gpu.device.limits().max_texture_dimension_2d);
    gpu.ensure("a side of the picture", size.width.max(size.height).into(), limit)?;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: extent([size.width, size.height]),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    renderer.draw(gpu, drawable, settings, Canvas { view: &view, format: FORMAT, size })?;
    read(gpu, &texture, size.width, size.height)
}

/// The texels of a texture of four bytes each.
fn read(gpu: &Gpu, texture: &wgpu::Texture, width: u32, height: u32) -> Result<RgbaImage, GpuError> {
    // Rows of a copy begin at multiples of this.
    let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(stride) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: Some(height) };
    let target = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), target, extent([width, height]));
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.map(&staging)?;
    let rows = bytes.chunks_exact(stride as usize).flat_map(|row| &row[..4 * width as usize]);
    Ok(RgbaImage::from_raw(width, height, rows.copied().collect()).unwrap_or_default())
}
