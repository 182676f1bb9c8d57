//! Measurement of the time and memory that a picture takes.

use planish_render::gpu::NoGpu;
use planish_render::gpu::renderer::{Renderer, Smoothness};
use planish_render::scene::Scene;
use planish_render::settings::Settings;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Frames that are drawn for the median.
const FRAMES: usize = 15;

/// Report of `--timings`; times in seconds.
#[derive(Debug, Serialize)]
pub(crate) struct Timings {
    adapter: String,
    triangles: usize,
    width: u32,
    height: u32,
    /// Time from the start of the program until the scene is in memory: reading, and baking where there is no map.
    opening: f64,
    /// Finding the device and compiling the shaders.
    starting: f64,
    /// Copying the scene to it.
    uploading: f64,
    /// Drawing the first frame, as a window would.
    first_frame: f64,
    /// The median of the frames that follow.
    frame: f64,
    /// All of these but the last.
    start_to_picture: f64,
    /// Buffers of the scene on the device, bytes; textures come on top.
    scene_bytes: u64,
    /// Most memory that the program held, bytes; only on Linux.
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_memory: Option<u64>,
}

/// Draws with one sample a pixel and the GPU's own smoothing, as a window does.
pub(crate) fn measure(
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    opening: Duration,
    starting: Duration,
) -> Result<Timings, NoGpu> {
    let gpu = renderer.gpu();
    let begun = Instant::now();
    let gpu_scene = renderer.upload(scene)?;
    gpu.wait();
    let uploading = begun.elapsed();
    let target = renderer.target(settings.size, Smoothness::SmoothEdges);
    let canvas = renderer.canvas(settings.size);
    let view = canvas.create_view(&wgpu::TextureViewDescriptor::default());
    let frame = || {
        let begun = Instant::now();
        renderer.draw(&gpu_scene, scene, settings, &target, &view);
        gpu.wait();
        begun.elapsed()
    };
    let first_frame = frame();
    let mut frames: Vec<Duration> = (0..FRAMES).map(|_| frame()).collect();
    frames.sort_unstable();
    Ok(Timings {
        adapter: gpu.adapter.name.clone(),
        triangles: scene.mesh().triangles.len(),
        width: settings.size.width,
        height: settings.size.height,
        opening: opening.as_secs_f64(),
        starting: starting.as_secs_f64(),
        uploading: uploading.as_secs_f64(),
        first_frame: first_frame.as_secs_f64(),
        frame: frames[FRAMES / 2].as_secs_f64(),
        start_to_picture: (opening + starting + uploading + first_frame).as_secs_f64(),
        scene_bytes: gpu_scene.bytes(),
        peak_memory: peak_memory(),
    })
}

fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| 1024 * kib)
}
