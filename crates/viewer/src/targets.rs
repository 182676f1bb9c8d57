//! What pictures are drawn into before they become pixels: linear light, several samples a pixel, depth.

use crate::gpu::{Gpu, GpuError};
use crate::settings::{Multisampling, Settings, Size};
use crate::textures::extent;

/// Of the colour target: light may exceed 1, and averages are taken of light.
pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Of the depth target.
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The textures of a picture.
#[derive(Debug)]
pub(crate) struct Targets {
    /// In samples.
    pub(crate) size: [u32; 2],
    /// Samples of MSAA.
    pub(crate) samples: u32,
    /// One colour per sample of the supersampling.
    pub(crate) colour: wgpu::TextureView,
    /// As MSAA has it.
    multisampled: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl Targets {
    /// Targets for a picture of this size.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], samples: u32) -> Result<Self, GpuError> {
        let limit = u64::from(gpu.device.limits().max_texture_dimension_2d);
        gpu.ensure("a side of the picture in samples", size[0].max(size[1]).into(), limit)?;
        let texture = |label, format, sample_count, usage| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(size),
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        Ok(Self {
            size,
            samples,
            colour: texture("colour", COLOUR, 1, drawn | wgpu::TextureUsages::TEXTURE_BINDING),
            multisampled: (samples > 1).then(|| texture("multisampled colour", COLOUR, samples, drawn)),
            depth: texture("depth", DEPTH, samples, drawn),
        })
    }

    /// Samples along both sides of a picture.
    pub(crate) fn size_of(size: Size, settings: &Settings) -> [u32; 2] {
        [size.width, size.height].map(|pixels| pixels.saturating_mul(settings.supersampling))
    }

    /// Samples of MSAA that the GPU has, of those that are asked for.
    pub(crate) fn samples_of(gpu: &Gpu, settings: &Settings) -> u32 {
        let four = |format: wgpu::TextureFormat| {
            gpu.adapter.get_texture_format_features(format).flags.sample_count_supported(4)
        };
        match settings.multisampling {
            Multisampling::Four if four(COLOUR) && four(DEPTH) => 4,
            Multisampling::Four | Multisampling::Off => 1,
        }
    }

    /// Begins the pass that draws everything.
    pub(crate) fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let (view, resolve_target) = match &self.multisampled {
            Some(multisampled) => (multisampled, Some(&self.colour)),
            None => (&self.colour, None),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}
