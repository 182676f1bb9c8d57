//! The device: which one, what it can do, and what went wrong on it.

use clap::ValueEnum;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use thiserror::Error;

/// What draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// A GPU, or where there is none the software renderer.
    #[default]
    Auto,
    /// The software renderer.
    Software,
    /// A GPU through Vulkan.
    Vulkan,
    /// A GPU through OpenGL.
    Gl,
}

/// Why there is no device.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum GpuError {
    /// No adapter of the kind that was asked for.
    #[error(
        "no GPU and no driver that computes like one was found for {0}; on Debian: apt install mesa-vulkan-drivers \
         (Vulkan), libegl1 libegl-mesa0 libgl1-mesa-dri libgbm1 (OpenGL)"
    )]
    NoAdapter(&'static str),
    /// It lacks something that planish needs.
    #[error("{adapter} cannot be used: {reason}")]
    Unusable {
        /// Its name.
        adapter: String,
        /// What it lacks, or what the driver says.
        reason: String,
    },
    /// Something in this program that the GPU's interface refuses, or that the GPU has no memory for.
    #[error("the GPU refused: {0}")]
    Refused(String),
    /// The driver gave up or the card went away.
    #[error("the GPU was lost: {0}")]
    Lost(String),
    /// A picture or a mesh that is larger than the GPU takes.
    #[error("{what} of {size} is more than the {limit} that this GPU takes")]
    TooLarge {
        /// What.
        what: &'static str,
        /// How large it is.
        size: u64,
        /// How large it may be.
        limit: u64,
    },
}

/// A device with its queue.
#[derive(Debug)]
pub struct Gpu {
    /// Makes things.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// What it can do.
    pub adapter: wgpu::Adapter,
    trouble: Arc<Trouble>,
}

/// What was reported by callbacks.
#[derive(Debug, Default)]
struct Trouble {
    first_error: Mutex<Option<String>>,
    is_lost: AtomicBool,
    why_lost: Mutex<String>,
}

impl Gpu {
    /// Opens the best device of this kind; there is none for [`Backend::Software`].
    pub fn open(backend: Backend) -> Result<Self, GpuError> {
        let (backends, name) = match backend {
            Backend::Auto => (wgpu::Backends::VULKAN | wgpu::Backends::GL, "Vulkan or OpenGL"),
            Backend::Vulkan => (wgpu::Backends::VULKAN, "Vulkan"),
            Backend::Gl => (wgpu::Backends::GL, "OpenGL"),
            Backend::Software => return Err(GpuError::NoAdapter("the software renderer")),
        };
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|_| GpuError::NoAdapter(name))?;
        Self::from_adapter(adapter)
    }

    /// Opens the device of an adapter, which may be one that a window can show.
    pub fn from_adapter(adapter: wgpu::Adapter) -> Result<Self, GpuError> {
        let unusable = |reason: String| GpuError::Unusable { adapter: adapter.get_info().name, reason };
        let needed = wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::VERTEX_STORAGE;
        let missing = needed - adapter.get_downlevel_capabilities().flags;
        if !missing.is_empty() {
            return Err(unusable(format!("it lacks {missing:?}")));
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("planish"),
            // All that there is: meshes of millions of triangles need buffers beyond the guaranteed sizes.
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| unusable(e.to_string()))?;
        let trouble = Arc::new(Trouble::default());
        let of_errors = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error| {
            // The first error is the cause, others follow from it.
            lock(&of_errors.first_error).get_or_insert(error.to_string());
        }));
        let of_loss = Arc::clone(&trouble);
        device.set_device_lost_callback(move |reason, message| {
            // Dropping the device is reported, too.
            if reason != wgpu::DeviceLostReason::Destroyed || !message.is_empty() {
                *lock(&of_loss.why_lost) = message;
            }
            of_loss.is_lost.store(true, Ordering::Release);
        });
        Ok(Self { device, queue, adapter, trouble })
    }

    /// What was refused since the last call, or whether the device was lost.
    pub fn check(&self) -> Result<(), GpuError> {
        if self.trouble.is_lost.load(Ordering::Acquire) {
            return Err(GpuError::Lost(lock(&self.trouble.why_lost).clone()));
        }
        match lock(&self.trouble.first_error).take() {
            Some(error) => Err(GpuError::Refused(error)),
            None => Ok(()),
        }
    }

    /// Waits until all that was submitted is done.
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.check()?;
        waited.map(drop).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Refuses what is too large.
    pub(crate) fn ensure(&self, what: &'static str, size: u64, limit: u64) -> Result<(), GpuError> {
        if size > limit { Err(GpuError::TooLarge { what, size, limit }) } else { Ok(()) }
    }

    /// The bytes of a buffer that can be copied from.
    pub fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.map(&staging)
    }

    /// The bytes of a staging buffer, when all that was submitted is done.
    pub(crate) fn map(&self, staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        staging.map_async(wgpu::MapMode::Read, .., |_| ());
        self.wait()?;
        let view = staging.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(view.to_vec())
    }
}

/// The content, even if a thread panicked that held it: all there is are words.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
