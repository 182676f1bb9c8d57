//! The window, its device, and a mesh and a map on that device.

use super::{Scan, Vertex};
use bytemuck::{bytes_of, cast_slice};
use glam::Vec3;
use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use std::error::Error;
use std::sync::Arc;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _, TextureDataOrder};
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Everything that exists once there is a window.
pub(super) struct Drawing {
    pub(super) window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    /// Bind groups 0, the camera, and 1, the map.
    groups: [wgpu::BindGroup; 2],
    camera: wgpu::Buffer,
    displacement: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    /// Bias and scale of the map.
    range: [f32; 2],
    /// Lowest and highest coordinates of the mesh.
    bounds: [Vec3; 2],
}

impl Drawing {
    pub(super) fn new(event_loop: &ActiveEventLoop, scan: &Scan) -> Result<Self, Box<dyn Error>> {
        let attributes = Window::default_attributes().with_title("planish: the pointer sets λ");
        let window = Arc::new(event_loop.create_window(attributes)?);
        let display = Box::new(event_loop.owned_display_handle());
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(display));
        let surface = instance.create_surface(Arc::clone(&window))?;
        let options = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..<_>::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        let wanted = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..<_>::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wanted))?;
        let size = window.inner_size();
        let configuration = surface.get_default_config(&adapter, size.width.max(1), size.height.max(1));
        let configuration = configuration.ok_or("the graphics adapter cannot draw to this display")?;
        surface.configure(&device, &configuration);

        let pipeline = pipeline(&device, configuration.format);
        let buffer =
            |contents: &[u8], usage| device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let (camera, displacement) = (buffer(&[0; 64], uniform), buffer(&[0; 16], uniform));
        let map = map(&device, &queue, scan);
        let group = |group: u32, resources: &[wgpu::BindingResource]| {
            let numbered = (0..).zip(resources.iter().cloned());
            let entries: Vec<_> =
                numbered.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
            let layout = &pipeline.get_bind_group_layout(group);
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        let groups = [
            group(0, &[camera.as_entire_binding()]),
            group(1, &[wgpu::BindingResource::TextureView(&map), displacement.as_entire_binding()]),
        ];
        let positions = || scan.vertices.iter().map(|v| v.position);
        let encoding = scan.map.encoding();
        Ok(Self {
            vertices: buffer(cast_slice(&scan.vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer(cast_slice(&scan.triangles), wgpu::BufferUsages::INDEX),
            index_count: scan.triangles.as_flattened().len() as u32,
            range: [encoding.bias, encoding.scale],
            bounds: [positions().fold(Vec3::MAX, Vec3::min), positions().fold(Vec3::MIN, Vec3::max)],
            window,
            surface,
            configuration,
            device,
            queue,
            pipeline,
            groups,
            camera,
            displacement,
        })
    }

    /// Width of the window, pixels.
    pub(super) fn width(&self) -> f32 {
        self.configuration.width as f32
    }

    pub(super) fn resize(&mut self, width: u32, height: u32) {
        (self.configuration.width, self.configuration.height) = (width.max(1), height.max(1));
        self.surface.configure(&self.device, &self.configuration);
        self.window.request_redraw();
    }

    pub(super) fn draw(&self, lambda: f32) {
        use wgpu::CurrentSurfaceTexture as Current;
        let (Current::Success(frame) | Current::Suboptimal(frame)) = self.surface.get_current_texture() else { return };
        let (width, height) = (self.configuration.width, self.configuration.height);
        let [low, high] = self.bounds;
        let (centre, radius) = (0.5 * (low + high), 0.5 * low.distance(high).max(f32::MIN_POSITIVE));
        let eye = centre + 2.3 * radius * Vec3::new(0.5, 0.3, 0.8);
        let clip_from_world = perspective(0.9, width as f32 / height as f32, 0.1 * radius, 10.0 * radius)
            * look_at_mat4(eye, centre, Vec3::Y);
        self.queue.write_buffer(&self.camera, 0, bytes_of(&clip_from_world));
        // All there is to do for another strength: bias, scale, λ, and the kind of the map, which is 0 for heights.
        self.queue.write_buffer(&self.displacement, 0, cast_slice(&[self.range[0], self.range[1], lambda, 0.0]));

        let depth = texture([width, height], DEPTH, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let depth = self.device.create_texture(&depth).create_view(&<_>::default());
        let colour = frame.texture.create_view(&<_>::default());
        let mut encoder = self.device.create_command_encoder(&<_>::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &colour,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), ..<_>::default() },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), ..<_>::default() }),
                    stencil_ops: None,
                }),
                ..<_>::default()
            });
            pass.set_pipeline(&self.pipeline);
            for (number, group) in (0..).zip(&self.groups) {
                pass.set_bind_group(number, group, &[]);
            }
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, 0..1);
        }
        self.queue.submit([encoder.finish()]);
        self.queue.present(frame);
    }
}

/// Compiles `displace.wgsl` with the stages of this example.
fn pipeline(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let text = [planish_shaders::DISPLACE, include_str!("stages.wgsl")].concat();
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: <_>::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: <_>::default(),
            bias: <_>::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs"),
            compilation_options: <_>::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The map as a texture, which is read texel by texel.
fn map(device: &wgpu::Device, queue: &wgpu::Queue, scan: &Scan) -> wgpu::TextureView {
    let size = scan.map.size();
    let wanted =
        texture([size.width, size.height], wgpu::TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING);
    let texels = cast_slice(&scan.map.planes()[0]);
    let texture = device.create_texture_with_data(queue, &wanted, TextureDataOrder::LayerMajor, texels);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn texture(
    [width, height]: [u32; 2],
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
