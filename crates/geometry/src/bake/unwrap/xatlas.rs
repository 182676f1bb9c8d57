//! xatlas on a thread of its own: its callback must own the values that it uses, and its long steps must not keep the
//! caller from stopping.

use super::UnwrapError;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::Vec2;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;
use xatlas_rs_v2::{ChartOptions, IndexData, MeshData, MeshDecl, PackOptions, Xatlas};

/// Time between two questions to the caller whether to stop.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Triangles to lay out.
pub(super) struct Triangles {
    /// Coordinates x, y and z of each vertex, one after the other.
    pub(super) positions: Vec<f32>,
    /// Vertices of the triangles, three for each.
    pub(super) indices: Vec<Index>,
    /// Region of each triangle; no chart contains triangles of two regions. #T
    pub(super) regions: Vec<u32>,
}

/// Scale at which charts are packed.
#[derive(Clone, Copy)]
pub(super) enum Scale {
    /// Scale at which the charts fill a square of about this side, texels.
    About(u32),
    /// Texels for each unit of length.
    TexelsPerUnit(f32),
}

/// Packed vertex of one chart.
#[derive(Clone, Copy)]
pub(super) struct PackedVertex {
    /// Position in the packing, texels.
    pub(super) position: Vec2,
    /// Chart of the vertex; `None` if its triangles have no area.
    pub(super) chart: Option<Index>,
}

/// Charts side by side in one square.
pub(super) struct Packing {
    /// Longer side of the bounding box of all charts, texels.
    pub(super) extent: u32,
    /// Scale of the charts, texels for each unit of length.
    pub(super) texels_per_unit: f32,
    /// Vertices of all charts.
    pub(super) vertices: Vec<PackedVertex>,
    /// Index into `vertices` of each corner of the triangles, three for each.
    pub(super) corners: Vec<Index>,
}

/// Values that the caller, the thread and the callback of xatlas share.
#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    percent: AtomicU32,
}

/// Thread that has cut charts and packs them on request.
pub(super) struct Session {
    requests: Sender<Scale>,
    ready: Receiver<()>,
    packings: Receiver<Packing>,
    shared: Arc<Shared>,
}

impl Session {
    /// Starts a thread, and waits until it has cut the triangles into charts.
    pub(super) fn cut(triangles: Triangles, gutter: u32, progress: &dyn Progress) -> Result<Self, UnwrapError> {
        let (requests, incoming) = channel();
        let (send_ready, ready) = channel();
        let (results, packings) = channel();
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        std::thread::spawn(move || work(&triangles, gutter, &of_thread, &send_ready, &incoming, &results));
        let session = Self { requests, ready, packings, shared };
        progress.stage("cutting charts");
        session.wait(&session.ready, progress)?;
        Ok(session)
    }

    /// Packs the charts at a scale and waits for the result.
    pub(super) fn pack(&self, scale: Scale, progress: &dyn Progress) -> Result<Packing, UnwrapError> {
        progress.stage("packing charts");
        self.requests.send(scale).map_err(|_| UnwrapError::Failed)?;
        self.wait(&self.packings, progress)
    }

    /// Waits for a message of the thread, passes progress on, and stops when the caller cancels.
    fn wait<T>(&self, message: &Receiver<T>, progress: &dyn Progress) -> Result<T, UnwrapError> {
        loop {
            if progress.cancelled() {
                // The thread reads this flag from time to time and ends by itself.
                self.shared.cancelled.store(true, Ordering::Relaxed);
                return Err(Cancelled.into());
            }
            match message.recv_timeout(POLL_INTERVAL) {
                Ok(message) => return Ok(message),
                Err(RecvTimeoutError::Timeout) => {
                    progress.done(f64::from(self.shared.percent.load(Ordering::Relaxed)) / 100.0);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(UnwrapError::Failed),
            }
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }
}

/// Work of the thread: cuts charts once, then packs them for each request until the session is dropped.
fn work(
    triangles: &Triangles,
    gutter: u32,
    shared: &Arc<Shared>,
    ready: &Sender<()>,
    requests: &Receiver<Scale>,
    packings: &Sender<Packing>,
) {
    let mesh = MeshDecl {
        vertex_position_data: MeshData::Contiguous(&triangles.positions),
        index_data: Some(IndexData::U32(&triangles.indices)),
        face_material_data: Some(&triangles.regions),
        ..MeshDecl::default()
    };
    let mut xatlas = Xatlas::new();
    // Any thread of xatlas may call this function, so it uses atomics only.
    let of_callback = Arc::clone(shared);
    xatlas.set_progress_callback(move |_, percent| {
        of_callback.percent.store(percent.clamp(0, 100).unsigned_abs(), Ordering::Relaxed);
        !of_callback.cancelled.load(Ordering::Relaxed)
    });
    if xatlas.add_mesh(&mesh).is_err() {
        return;
    }
    xatlas.compute_charts(&ChartOptions { fix_winding: true, ..ChartOptions::default() });
    if shared.cancelled.load(Ordering::Relaxed) || ready.send(()).is_err() {
        return;
    }
    for scale in requests {
        let (resolution, texels_per_unit) = match scale {
            Scale::About(side) => (side, 0.0),
            Scale::TexelsPerUnit(texels) => (0, texels),
        };
        // The rotation of xatlas swaps u and v, which mirrors charts.
        let rotate_charts = false;
        let options =
            PackOptions { resolution, texels_per_unit, rotate_charts, padding: gutter, ..PackOptions::default() };
        xatlas.pack_charts(&options);
        // Without charts xatlas has no arrays to read.
        if shared.cancelled.load(Ordering::Relaxed) || xatlas.chart_count() == 0 {
            return;
        }
        let packing = read(&xatlas);
        if packings.send(packing).is_err() {
            return;
        }
    }
}

/// Copies the packed charts out of xatlas.
fn read(xatlas: &Xatlas) -> Packing {
    let mut packing = Packing {
        extent: xatlas.width().max(xatlas.height()),
        texels_per_unit: xatlas.texels_per_unit(),
        vertices: Vec::new(),
        corners: Vec::new(),
    };
    for mesh in xatlas.meshes() {
        let packed = |v: &xatlas_rs_v2::Vertex| PackedVertex {
            position: v.uv.into(),
            chart: Index::try_from(v.chart_index).ok(),
        };
        packing.vertices.extend(mesh.vertex_array.iter().map(packed));
        packing.corners.extend_from_slice(mesh.index_array);
    }
    packing
}
