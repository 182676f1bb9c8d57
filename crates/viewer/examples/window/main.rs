//! A window that displaces a mesh by its map in the vertex shader. The pointer sets the strength: λ = 0 at the left rim,
//! where the mesh is drawn as it was scanned, and 1 at the right one, where it is denoised.
//!
//! ```text
//! planish bake scan.obj -o baked
//! cargo run -p planish-viewer --example window -- baked/scan.planish.json
//! ```

mod drawing;

use bytemuck::{Pod, Zeroable};
use drawing::Drawing;
use glam::{Vec2, Vec3};
use planish_geometry::map::displace::baked_vertices;
use planish_geometry::map::displacement::{Displacement, MapKind, SampleAt};
use planish_geometry::map::manifest::Manifest;
use planish_geometry::metrics::Triangles;
use planish_geometry::source::Source;
use planish_geometry::source::obj::Obj;
use std::error::Error;
use std::fs::read;
use std::path::Path;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::WindowId;

/// A vertex as the vertex stage gets it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    /// Number of the texel that it samples, or `u32::MAX` where it samples at `uv`.
    texel: u32,
}

/// A mesh with its map, as read from the files of a bake.
struct Scan {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    map: Displacement,
}

fn open(path: &Path) -> Result<Scan, Box<dyn Error>> {
    let manifest = Manifest::from_json(&read(path)?)?;
    let entry = &manifest.displacement;
    if entry.map != MapKind::Scalar {
        return Err("this example draws maps of heights; bake with --map scalar".into());
    }
    let image = read(path.with_file_name(&entry.file))?;
    let map = Displacement::decode(&image, entry.map, entry.size(), entry.encoding())?;
    // The carrier is the mesh with the normals that the map displaces along.
    let carrier: Source = Obj::parse(read(path.with_file_name(&manifest.carrier.obj))?)?.into();
    let vertices = baked_vertices(&carrier, &manifest, &|| None)?.into_iter().map(|v| {
        let (normal, uv, texel) = match v.sample_at {
            Some(SampleAt::Uv(uv)) => (v.normal, uv, u32::MAX),
            Some(SampleAt::Texel(texel)) => (v.normal, Vec2::ZERO, texel),
            // A vertex that samples nowhere stays.
            None => (Vec3::ZERO, Vec2::ZERO, u32::MAX),
        };
        Vertex { position: v.position, normal, uv, texel }
    });
    Ok(Scan { vertices: vertices.collect(), triangles: Triangles::from(carrier.data()).triangles().to_vec(), map })
}

/// The program: a scan, and its drawing once there is a window.
struct Program {
    scan: Scan,
    drawing: Option<Drawing>,
    lambda: f32,
    /// Reason why there is no drawing.
    failure: Option<Box<dyn Error>>,
}

impl ApplicationHandler for Program {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        match Drawing::new(event_loop, &self.scan) {
            Ok(drawing) => self.drawing = Some(drawing),
            Err(e) => {
                self.failure = Some(e);
                event_loop.exit();
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(drawing) = &mut self.drawing else { return };
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => drawing.resize(size.width, size.height),
            WindowEvent::CursorMoved { position, .. } => {
                self.lambda = position.x as f32 / drawing.width();
                drawing.window.request_redraw();
            }
            WindowEvent::RedrawRequested => drawing.draw(self.lambda),
            _ => {}
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: window MAP.planish.json")?;
    let mut program = Program { scan: open(Path::new(&path))?, drawing: None, lambda: 1.0, failure: None };
    EventLoop::new()?.run_app(&mut program)?;
    program.failure.map_or(Ok(()), Err)
}
