//! xatlas on a thread of its own, because its callback must own what it touches, and because a long step of it must
//! not keep the caller from stopping.

use super::UnwrapError;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use glam::Vec2;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;
use xatlas_rs_v2::{ChartOptions, IndexData, MeshData, MeshDecl, PackOptions, Xatlas};

/// How often the caller is asked whether to stop.
const TICK: Duration = Duration::from_millis(20);

/// Triangles to lay out.
pub(super) struct Triangles {
    /// x, y and z of each vertex.
    pub(super) positions: Vec<f32>,
    /// Vertices of the triangles, three each.
    pub(super) indices: Vec<Index>,
    /// No chart has triangles of two regions. #T
    pub(super) regions: Vec<u32>,
}

/// How fine charts are packed.
#[derive(Clone, Copy)]
pub(super) enum Scale {
    /// Such that they fill a square of about this side.
    About(u32),
    /// Texels in the length of one.
    TexelsPerUnit(f32),
}

/// A vertex in one chart.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    /// Texels.
    pub(super) at: Vec2,
    /// None where no chart takes its triangle, which has no area then.
    pub(super) chart: Option<Index>,
}

/// Charts side by side.
pub(super) struct Packing {
    /// Longer side of what they take, texels.
    pub(super) extent: u32,
    pub(super) texels_per_unit: f32,
    pub(super) vertices: Vec<Placed>,
    /// In `vertices`, of each triangle's corners.
    pub(super) corners: Vec<Index>,
}

#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    percent: AtomicU32,
}

/// Charts that wait to be packed.
pub(super) struct Session {
    orders: Sender<Scale>,
    ready: Receiver<()>,
    packings: Receiver<Packing>,
    shared: Arc<Shared>,
}

impl Session {
    /// Cuts triangles into charts.
    pub(super) fn cut(triangles: Triangles, gutter: u32, progress: &dyn Progress) -> Result<Self, UnwrapError> {
        let (orders, incoming) = channel();
        let (say_ready, ready) = channel();
        let (answers, packings) = channel();
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        std::thread::spawn(move || work(&triangles, gutter, &of_thread, &say_ready, &incoming, &answers));
        let session = Self { orders, ready, packings, shared };
        progress.stage("cutting charts");
        session.wait(&session.ready, progress)?;
        Ok(session)
    }

    pub(super) fn pack(&self, scale: Scale, progress: &dyn Progress) -> Result<Packing, UnwrapError> {
        progress.stage("packing charts");
        self.orders.send(scale).map_err(|_| UnwrapError::Failed)?;
        self.wait(&self.packings, progress)
    }

    fn wait<T>(&self, answer: &Receiver<T>, progress: &dyn Progress) -> Result<T, UnwrapError> {
        loop {
            if progress.cancelled() {
                // The thread ends when it next looks; nobody waits for it.
                self.shared.cancelled.store(true, Ordering::Relaxed);
                return Err(Cancelled.into());
            }
            match answer.recv_timeout(TICK) {
                Ok(answer) => return Ok(answer),
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

/// The thread: charts once, then a packing for each order, until nobody asks any more.
fn work(
    triangles: &Triangles,
    gutter: u32,
    shared: &Arc<Shared>,
    ready: &Sender<()>,
    orders: &Receiver<Scale>,
    packings: &Sender<Packing>,
) {
    let mesh = MeshDecl {
        vertex_position_data: MeshData::Contiguous(&triangles.positions),
        index_data: Some(IndexData::U32(&triangles.indices)),
        face_material_data: Some(&triangles.regions),
        ..MeshDecl::default()
    };
    let mut xatlas = Xatlas::new();
    // Called from any of its threads: atomics only.
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
    for scale in orders {
        let (resolution, texels_per_unit) = match scale {
            Scale::About(side) => (side, 0.0),
            Scale::TexelsPerUnit(texels) => (0, texels),
        };
        // What it calls rotation swaps u and v, and so turns charts over.
        let rotate_charts = false;
        let options =
            PackOptions { resolution, texels_per_unit, rotate_charts, padding: gutter, ..PackOptions::default() };
        xatlas.pack_charts(&options);
        // Without charts there are no arrays to look at.
        if shared.cancelled.load(Ordering::Relaxed) || xatlas.chart_count() == 0 {
            return;
        }
        let packing = read(&xatlas);
        if packings.send(packing).is_err() {
            return;
        }
    }
}

fn read(xatlas: &Xatlas) -> Packing {
    let mut packing = Packing {
        extent: xatlas.width().max(xatlas.height()),
        texels_per_unit: xatlas.texels_per_unit(),
        vertices: Vec::new(),
        corners: Vec::new(),
    };
    for mesh in xatlas.meshes() {
        let place = |v: &xatlas_rs_v2::Vertex| Placed { at: v.uv.into(), chart: Index::try_from(v.chart_index).ok() };
        packing.vertices.extend(mesh.vertex_array.iter().map(place));
        packing.corners.extend_from_slice(mesh.index_array);
    }
    packing
}
