//! What is the same for a whole picture, as the shaders have it.

use crate::camera::View;
use crate::gpu::Gpu;
use crate::gpu_types;
use crate::layouts::Layouts;
use crate::lights::Light;
use crate::render_mesh::{entry, uniform};
use crate::scene::Scene;
use crate::settings::{Pattern, Range, Settings, Size};
use glam::{Mat4, Vec2, Vec4};

/// Bind group 0 and its uniforms.
#[derive(Debug)]
pub(crate) struct Frame {
    /// The group.
    pub(crate) bind_group: wgpu::BindGroup,
    frame: wgpu::Buffer,
    lights: wgpu::Buffer,
    material: wgpu::Buffer,
}

impl Frame {
    pub(crate) fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        let frame = uniform(gpu, "frame", &gpu_types::Frame::default());
        let lights = uniform(gpu, "lights", &gpu_types::Lights::default());
        let material = uniform(gpu, "material", &gpu_types::Material::default());
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &layouts.frame,
            entries: &[
                entry(0, frame.as_entire_binding()),
                entry(1, lights.as_entire_binding()),
                entry(2, material.as_entire_binding()),
            ],
        });
        Self { bind_group, frame, lights, material }
    }

    /// Writes the uniforms of a picture of this size.
    /// `heat` is the range of the colour map.
    pub(crate) fn write(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        settings: &Settings,
        view: &View,
        size: Size,
        heat: Option<Range>,
    ) {
        let write = |buffer, bytes: &[u8]| gpu.queue.write_buffer(buffer, 0, bytes);
        write(&self.frame, bytemuck::bytes_of(&frame(scene, settings, view, size)));
        write(&self.lights, bytemuck::bytes_of(&lights(scene, settings, view)));
        write(&self.material, bytemuck::bytes_of(&material(scene, settings, heat)));
    }
}

fn frame(scene: &Scene, settings: &Settings, view: &View, size: Size) -> gpu_types::Frame {
    let bounds = scene.bounds();
    gpu_types::Frame {
        clip_from_world: view.clip_from_world,
        world_from_clip: view.clip_from_world.as_dmat4().inverse().as_mat4(),
        world_from_view: Mat4::from_mat3(view.world_from_view),
        eye: view.eye_in_world,
        up: view.up_in_world,
        radius: bounds.radius,
        centre: bounds.centre,
        shading: settings.shading as u32,
        viewport: (settings.supersampling * glam::UVec2::new(size.width, size.height)).as_vec2(),
        supersampling: settings.supersampling as f32,
        normals: settings.map.normals as u32,
    }
}

fn lights(scene: &Scene, settings: &Settings, view: &View) -> gpu_types::Lights {
    let mut lights = gpu_types::Lights {
        sky: settings.ambient.intensity * settings.ambient.sky.linear(),
        ground: settings.ambient.intensity * settings.ambient.ground.linear(),
        count: settings.lights.len() as u32,
        ..gpu_types::Lights::default()
    };
    let placed = settings.lights.iter().map(|light: &Light| light.place(view, scene.bounds()));
    for (light, placed) in lights.lights.iter_mut().zip(placed) {
        *light = gpu_types::Light {
            place: placed.place,
            radiance: placed.radiance,
            nominal: placed.nominal,
            axis: placed.axis,
            cone_inner: placed.cone[0],
            cone_outer: placed.cone[1],
            shadow: -1,
            _pad: Vec2::ZERO,
        };
    }
    lights
}

fn material(scene: &Scene, settings: &Settings, range: Option<Range>) -> gpu_types::Material {
    let Settings { material, checker, relief, heat, .. } = settings;
    let (noise_frequency, vein) = match material.pattern {
        Pattern::Plain => (0.0, material.colour),
        Pattern::Noise { frequency, colour } => (frequency, colour),
    };
    let radius = scene.bounds().radius;
    let samples = heat.map.samples();
    let mut heat_colours = [Vec4::ZERO; 17];
    for (colour, sample) in heat_colours.iter_mut().zip(samples) {
        *colour = sample.encoded().extend(1.0);
    }
    gpu_types::Material {
        colour: material.colour.linear(),
        specular: material.specular,
        vein: vein.linear(),
        exponent: material.exponent,
        checker_light: checker.light.linear(),
        checker_squares: checker.squares,
        checker_dark: checker.dark.linear(),
        noise_frequency,
        relief_lambda: relief.lambda,
        relief_bias: radius * relief.bias,
        relief_scale: radius * relief.scale,
        relief_bump: relief.bump,
        heat_low: range.map_or(0.0, |range| range.low),
        heat_high: range.map_or(1.0, |range| range.high),
        heat_relief: heat.relief,
        heat_samples: samples.len() as u32,
        heat_colours,
    }
}
