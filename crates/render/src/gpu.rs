//! The graphics device, or one clear message where there is none; and what draws on it.
//!
//! ```no_run
//! use planish_render::gpu::{Backend, Gpu, renderer::Renderer};
//! use planish_render::settings::Settings;
//! use planish_render::software;
//!
//! # fn f(scene: planish_render::scene::Scene) -> Result<(), planish_render::gpu::NoGpu> {
//! let settings = Settings::default();
//! let picture = match Gpu::open(Backend::Auto) {
//!     Ok(gpu) => Renderer::new(gpu).image(&scene, &settings)?,
//!     Err(reason) => {
//!         assert!(reason.to_string().contains("install a driver"));
//!         software::render(&scene, &settings)
//!     }
//! };
//! assert_eq!(picture.dimensions(), (1200, 900));
//! # Ok(()) }
//! ```

pub mod painter;
mod render_mesh;
pub mod renderer;
mod shaders;
mod types;

use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use thiserror::Error;

/// Device and driver interface that draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Backend {
    /// A GPU where there is one, the processor elsewhere.
    #[default]
    Auto,
    /// A GPU through Vulkan (or Metal or Direct3D, where that is what there is).
    Vulkan,
    /// A GPU through OpenGL.
    Gl,
    /// The renderer on the processor.
    Software,
}

impl Backend {
    /// Returns the driver interfaces that are tried.
    pub fn apis(self) -> wgpu::Backends {
        match self {
            Self::Auto => wgpu::Backends::all(),
            Self::Vulkan => wgpu::Backends::PRIMARY,
            Self::Gl => wgpu::Backends::GL,
            Self::Software => wgpu::Backends::empty(),
        }
    }
}

/// Reason why nothing can be drawn on a GPU.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoGpu {
    /// No driver offers one.
    #[error(
        "no graphics adapter ({backend:?}): install a driver (on Debian mesa-vulkan-drivers has one that needs no GPU), or draw with --backend software"
    )]
    NoAdapter {
        /// Backend that was asked for.
        backend: Backend,
    },
    /// The driver refuses to open the device.
    #[error("the graphics adapter {adapter} cannot be used: {reason}")]
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        reason: String,
    },
    /// The mesh does not fit into a buffer of the adapter.
    #[error(
        "the mesh needs a buffer of {bytes} bytes, and the graphics adapter {adapter} takes {limit}; draw with --backend software"
    )]
    TooLarge {
        /// Name of the adapter.
        adapter: String,
        /// Size of the largest buffer that the mesh needs, bytes.
        bytes: u64,
        /// Size of the largest buffer that the adapter allows, bytes.
        limit: u64,
    },
    /// The volume does not fit into a texture of the adapter.
    #[error(
        "the volume has {} × {} × {} values, and the graphics adapter {adapter} takes {limit} along an axis; draw with --backend software",
        size[0], size[1], size[2]
    )]
    VolumeTooLarge {
        /// Name of the adapter.
        adapter: String,
        /// Number of values along each axis.
        size: [u32; 3],
        /// Largest number of values along an axis that the adapter allows.
        limit: u32,
    },
    /// The device was lost twice in a row.
    #[error("the graphics adapter {adapter} was lost twice in a row")]
    Lost {
        /// Name of the adapter.
        adapter: String,
    },
}

/// Open graphics device with its queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Device that creates resources.
    pub device: wgpu::Device,
    /// Queue that commands are submitted to.
    pub queue: wgpu::Queue,
    /// Name and driver of the adapter.
    pub adapter: wgpu::AdapterInfo,
    /// Number of samples per pixel that targets of this format can have: 4 or 1.
    pub samples: u32,
    validation_errors: Arc<Mutex<Vec<String>>>,
    lost: Arc<AtomicBool>,
}

/// Format of every picture: linear light goes in, sRGB is stored.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Format of every depth buffer.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl Gpu {
    /// Opens a device without a window.
    pub fn open(backend: Backend) -> Result<Self, NoGpu> {
        if backend == Backend::Auto {
            // Drivers of OpenGL are loaded only where there is nothing better.
            return Self::open(Backend::Vulkan).or_else(|_| Self::open(Backend::Gl));
        }
        let instance = instance(backend);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        Self::on(&adapter.map_err(|_| NoGpu::NoAdapter { backend })?)
    }

    /// Opens a device on an adapter, with the limits of that adapter.
    pub fn on(adapter: &wgpu::Adapter) -> Result<Self, NoGpu> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("planish"),
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let info = adapter.get_info();
        let refused =
            |e: wgpu::RequestDeviceError| NoGpu::Refused { adapter: info.name.clone(), reason: e.to_string() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).map_err(refused)?;
        let validation_errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&validation_errors);
        // The default handler ends the program; a picture that is wrong somewhere is better than none.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
        }));
        let lost = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, _| flag.store(true, Ordering::Relaxed));
        let both = [FORMAT, DEPTH].map(|f| adapter.get_texture_format_features(f).flags);
        let four = both.iter().all(|flags| flags.sample_count_supported(4));
        Ok(Self { device, queue, adapter: info, samples: if four { 4 } else { 1 }, validation_errors, lost })
    }

    /// Takes the errors that the driver or its validation has reported since the last call.
    pub fn validation_errors(&self) -> Vec<String> {
        std::mem::take(&mut *self.validation_errors.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Whether the device is gone: nothing that is drawn with it arrives any more.
    pub fn is_lost(&self) -> bool {
        // What happened meanwhile is told when somebody asks.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.lost.load(Ordering::Relaxed)
    }

    /// Waits until all that was submitted is done.
    pub fn wait(&self) {
        // Only a lost device cannot be waited for, and then there is nothing to wait for.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }

    /// A buffer with these bytes. Unlike wgpu's own `create_buffer_init` it does not panic if the device is lost.
    pub(crate) fn filled(&self, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Reads back the bytes of a buffer that can be copied from.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.mapped(&copy)
    }

    /// Reads the bytes of a buffer that can be mapped; empty if the device is lost.
    pub(crate) fn mapped(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        self.wait();
        let bytes = buffer.get_mapped_range(..).map(|range| range.to_vec()).unwrap_or_default();
        buffer.unmap();
        bytes
    }
}

/// Creates the entry point to the drivers of a backend.
pub fn instance(backend: Backend) -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: backend.apis(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}
