//! Uniforms and bindings of the light of a picture: shadow maps, the environment and the ground.

use super::bind_groups::{Layouts, bind};
use super::frame::{self, Picture};
use super::gpu_scene::GpuScene;
use crate::environment::sample::EnvironmentSampler;
use crate::gpu::types::{Caster, Environment, Eye, Ground, Shadows};
use crate::gpu::{DEPTH, Gpu};
use crate::ground::Disc;
use crate::lights::world_lights;
use crate::settings::Shading;
use crate::settings::environment::Part;
use crate::settings::ground::Show;
use crate::settings::shadow::Filter;
use crate::shadow::{self, Rays};
use bytemuck::Zeroable as _;
use glam::Mat4;
use std::sync::{Mutex, PoisonError};
use wgpu::BufferUsages;

/// Shadow maps, one layer for each view of the lights.
#[derive(Clone, Debug)]
pub(super) struct Maps {
    size: u32,
    all: wgpu::TextureView,
    pub(super) each: Vec<wgpu::TextureView>,
}

impl Maps {
    fn new(gpu: &Gpu, size: u32, count: u32) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow maps"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: layers(count) },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let layer = |layer| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let all = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        });
        Self { size, all, each: (0..count).map(layer).collect() }
    }
}

/// wgpu's OpenGL takes a single layer for no array, and multiples of six for cubes.
fn layers(count: u32) -> u32 {
    if count <= 1 { 2 } else { count + u32::from(count.is_multiple_of(6)) }
}

/// The maps of the last picture: most pictures want the same ones again.
#[derive(Debug, Default)]
pub(super) struct Cache(Mutex<Option<Maps>>);

impl Cache {
    /// Returns maps for this many views. There is always one, because something has to be bound.
    fn maps(&self, gpu: &Gpu, size: u32, eyes: u32) -> Maps {
        let size = if eyes == 0 { 1 } else { size.min(gpu.device.limits().max_texture_dimension_2d) };
        let count = eyes.max(1);
        let mut cache = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*cache {
            Some(maps) if maps.size == size && maps.each.len() == count as usize => maps.clone(),
            _ => cache.insert(Maps::new(gpu, size, count)).clone(),
        }
    }
}

/// Bindings for one picture.
pub(super) struct Lighting {
    pub(super) frame_bindings: wgpu::BindGroup,
    pub(super) caster_bindings: wgpu::BindGroup,
    /// Bytes from the uniforms of one view to those of the next.
    pub(super) caster_stride: u32,
    /// Number of shadow maps that are drawn.
    pub(super) eyes: usize,
    pub(super) maps: Maps,
    /// Whether the ground is drawn.
    pub(super) has_ground: bool,
    /// Whether a map is shown instead of the picture.
    pub(super) shows_map: bool,
}

impl Lighting {
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts, cache: &Cache, gpu_scene: &GpuScene, picture: &Picture) -> Self {
        let (shadows, count) = shadows(picture);
        let maps = cache.maps(gpu, picture.settings.shadow.size, count as u32);
        let ground = ground(picture);
        let uniform = |bytes: &[u8]| gpu.filled(bytes, BufferUsages::UNIFORM);
        let buffers = [
            uniform(bytemuck::bytes_of(&shadows)),
            uniform(bytemuck::bytes_of(&environment(picture))),
            uniform(bytemuck::bytes_of(&ground.unwrap_or_default())),
            uniform(bytemuck::bytes_of(&frame::volume(picture))),
        ];
        let [shadow_buffer, environment, ground_buffer, volume] =
            buffers.each_ref().map(wgpu::Buffer::as_entire_binding);
        let nearest = gpu.device.create_sampler(&wgpu::SamplerDescriptor::default());
        let resources = [
            gpu_scene.frame.as_entire_binding(),
            shadow_buffer,
            wgpu::BindingResource::TextureView(&maps.all),
            environment,
            wgpu::BindingResource::TextureView(&gpu_scene.environment),
            wgpu::BindingResource::Sampler(&gpu_scene.environment_sampler),
            ground_buffer,
            wgpu::BindingResource::Sampler(&nearest),
            volume,
            wgpu::BindingResource::TextureView(&gpu_scene.volume),
        ];
        let (caster_bindings, caster_stride) = casters(gpu, layouts, &shadows.eyes[..count], picture.settings.shading);
        Self {
            frame_bindings: bind(&gpu.device, &layouts.frame, &resources),
            caster_bindings,
            caster_stride,
            eyes: count,
            has_ground: ground.is_some(),
            shows_map: picture.settings.shadow.show_map.is_some_and(|shown| (shown as usize) < count),
            maps,
        }
    }
}

/// Uniforms of the views, one after the other, and the bytes from one to the next.
fn casters(gpu: &Gpu, layouts: &Layouts, eyes: &[Eye], shading: Shading) -> (wgpu::BindGroup, u32) {
    let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment as usize;
    let stride = size_of::<Caster>().next_multiple_of(alignment);
    // There is always one, because something has to be bound.
    let mut casters = vec![0; stride * eyes.len().max(1)];
    for (bytes, eye) in casters.chunks_exact_mut(stride).zip(eyes) {
        let moves = u32::from(shading != Shading::Bump);
        let caster = Caster { clip_from_world: eye.clip_from_world, moves, ..Caster::zeroed() };
        bytes[..size_of::<Caster>()].copy_from_slice(bytemuck::bytes_of(&caster));
    }
    let buffer = &gpu.filled(&casters, BufferUsages::UNIFORM);
    let size = wgpu::BufferSize::new(size_of::<Caster>() as u64);
    let resource = wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size });
    (bind(&gpu.device, &layouts.caster, &[resource]), stride as u32)
}

/// Uniforms of the shadows, and the number of views that the lights have.
fn shadows(picture: &Picture) -> (Shadows, usize) {
    let Picture { scene, settings, ref view, .. } = *picture;
    let shadow = &settings.shadow;
    let bounds = scene.bounds();
    let mut all = Shadows {
        kernel: shadow.kernel as i32,
        slope_bias: shadow.slope_bias * bounds.radius,
        least_bias: shadow.least_bias * bounds.radius,
        shown: shadow.show_map.unwrap_or(0),
        ..Shadows::zeroed()
    };
    let mut count = 0;
    if shadow.filter == Filter::None && shadow.show_map.is_none() {
        return (all, count);
    }
    let eyes = shadow::shadow_views(scene, settings, view, &world_lights(scene, settings, view));
    for (i, eyes) in eyes.into_iter().enumerate() {
        (all.first_eye[i], all.eye_count[i]) = (count as u32, eyes.len() as u32);
        for eye in eyes {
            let (parallel, half_width) = match eye.rays {
                Rays::Parallel(half) => (1.0, half),
                Rays::Perspective(half) => (0.0, half),
            };
            let shadow::ShadowView { clip_from_world, near, far, light_size, .. } = eye;
            let world_from_clip = clip_from_world.inverse();
            all.eyes[count] =
                Eye { clip_from_world, world_from_clip, near, far, half_width, light_size, parallel, ..Eye::zeroed() };
            count += 1;
        }
    }
    (all, count)
}

/// Uniforms of the environment; zero without one.
fn environment(picture: &Picture) -> Environment {
    let Picture { scene, settings, ref view, aspect } = *picture;
    let Some(sampler) = EnvironmentSampler::new(scene.environment.as_ref(), settings, view, aspect) else {
        return Environment::zeroed();
    };
    let EnvironmentSampler { surroundings, environment, environment_from_world, rays } = sampler;
    let shown = |part| f32::from(u8::from(part == Part::Shown));
    Environment {
        environment_from_world: Mat4::from_mat3(environment_from_world),
        rays: Mat4::from_mat3(rays),
        irradiance: environment.irradiance.coefficients.map(|c| (surroundings.intensity * c).extend(0.0)),
        intensity: surroundings.intensity,
        reflectance: surroundings.reflectance,
        roughness: surroundings.roughness,
        roughest: (environment.levels.len() - 1) as f32,
        background: shown(surroundings.background),
        blur: surroundings.blur,
        ambient: shown(surroundings.ambient),
        ..Environment::zeroed()
    }
}

/// Uniforms of the ground; `None` without one.
fn ground(picture: &Picture) -> Option<Ground> {
    let Picture { scene, settings, ref view, .. } = *picture;
    let Disc { centre, radius, up, colour, show, .. } = Disc::new(scene, settings, view)?;
    let (_, front) = settings.camera.axes();
    let catches = f32::from(u8::from(show == Show::Shadows));
    Some(Ground { centre, radius, right: up.cross(front), catches, ahead: -front, colour, ..Ground::zeroed() })
}
