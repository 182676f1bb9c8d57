//! Measurement of the time and memory that a picture takes.

use planish_geometry::progress::Progress;
use planish_render::gpu::NoGpu;
use planish_render::gpu::renderer::{Renderer, Smoothness};
use planish_render::scene::Scene;
use planish_render::settings::{Displace, Settings};
use serde::Serialize;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Frames that are drawn for a median at least and at most, and the time after which there are enough.
const FRAMES: RangeInclusive<usize> = 3..=15;
const ENOUGH: Duration = Duration::from_secs(10);

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
    /// The median of frames with both halves of the split view: with the map, and without.
    split_frame: f64,
    /// The median of frames while the mesh is baked anew in the background; absent without a mesh, or if it cannot be baked.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_while_baking: Option<f64>,
    /// Time from the start of the program until the first frame is drawn.
    start_to_picture: f64,
    /// Buffers of the scene on the device, bytes; textures come on top.
    scene_bytes: u64,
    /// Most memory that the program held, bytes; only on Linux.
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_memory: Option<u64>,
}

/// Bakes a mesh until it is cancelled, and says whether it has baked it.
pub(crate) type Bake<'a> = &'a (dyn Fn(&dyn Progress) -> bool + Sync);

/// Stops a bake once enough frames are drawn.
#[derive(Default)]
struct UntilDrawn(AtomicBool);

impl Progress for UntilDrawn {
    fn cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Draws with one sample a pixel and the GPU's own smoothing, as a window does. `bake` bakes the mesh.
pub(crate) fn measure(
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    bake: Option<Bake>,
    [opening, starting]: [Duration; 2],
) -> Result<Timings, NoGpu> {
    let gpu = renderer.gpu();
    let begun = Instant::now();
    let gpu_scene = renderer.upload(scene)?;
    gpu.wait();
    let uploading = begun.elapsed();
    let target = renderer.target(settings.size, Smoothness::SmoothEdges);
    let canvas = renderer.canvas(settings.size);
    let view = canvas.create_view(&wgpu::TextureViewDescriptor::default());
    let without_map = Settings { displace: Displace { lambda: 0.0, ..settings.displace }, ..settings.clone() };
    let frame = |halves: &[&Settings]| {
        let begun = Instant::now();
        halves.iter().for_each(|settings| renderer.draw(&gpu_scene, scene, settings, &target, &view));
        gpu.wait();
        begun.elapsed()
    };
    let median = |halves: &[&Settings]| {
        let (begun, mut frames) = (Instant::now(), Vec::new());
        while frames.len() < *FRAMES.start() || (frames.len() < *FRAMES.end() && begun.elapsed() < ENOUGH) {
            frames.push(frame(halves));
        }
        frames.sort_unstable();
        frames[frames.len() / 2].as_secs_f64()
    };
    let first_frame = frame(&[settings]);
    let usual = median(&[settings]);
    let split = median(&[settings, &without_map]);
    let while_baking = bake.and_then(|bake| {
        let until = UntilDrawn::default();
        std::thread::scope(|scope| {
            let baking = scope.spawn(|| while !until.cancelled() && bake(&until) {});
            let frame = median(&[settings]);
            // It ends by itself only where it has failed.
            let is_baked = !baking.is_finished();
            until.0.store(true, Ordering::Relaxed);
            is_baked.then_some(frame)
        })
    });
    Ok(Timings {
        adapter: gpu.adapter.name.clone(),
        triangles: scene.mesh().triangles.len(),
        width: settings.size.width,
        height: settings.size.height,
        opening: opening.as_secs_f64(),
        starting: starting.as_secs_f64(),
        uploading: uploading.as_secs_f64(),
        first_frame: first_frame.as_secs_f64(),
        frame: usual,
        split_frame: split,
        frame_while_baking: while_baking,
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
