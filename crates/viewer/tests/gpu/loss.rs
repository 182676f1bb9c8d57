//! What goes wrong on a device is noticed, and a lost one is replaced.

use crate::support::{gpu, painter, settings};
use glam::Vec3;
use planish_viewer::gpu::{Backend, GpuError};
use planish_viewer::scene::{Mesh, Scene, Triangle};
use planish_viewer::settings::{Settings, Shading, Size};

fn triangle() -> Scene {
    Scene::new(Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z],
        triangles: vec![Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: None }],
        ..Mesh::default()
    })
    .unwrap()
}

#[test]
fn the_picture_after_a_loss_is_the_one_before() {
    let mut painter = painter(Backend::Vulkan, &triangle());
    let settings = settings(Shading::BlinnPhong);
    let before = painter.picture(&settings).unwrap();
    painter.gpu().device.destroy();
    assert_eq!(painter.picture(&settings).unwrap(), before);
}

#[test]
fn what_the_gpu_refuses_is_reported() {
    let gpu = gpu(Backend::Vulkan);
    gpu.check().unwrap();
    let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        // A buffer for reading back cannot be a vertex buffer.
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    assert!(matches!(gpu.check(), Err(GpuError::Refused(_))));
    gpu.check().unwrap();
}

#[test]
fn a_picture_that_is_too_large_is_an_error_and_not_a_crash() {
    let mut painter = painter(Backend::Vulkan, &triangle());
    let size = Size { width: 16_384, height: 16 };
    let settings = Settings { size, supersampling: 8, ..settings(Shading::Flat) };
    assert!(matches!(painter.picture(&settings), Err(GpuError::TooLarge { .. })));
}

#[test]
fn a_scene_without_triangles_is_the_background() {
    let mut painter = painter(Backend::Vulkan, &Scene::new(Mesh::default()).unwrap());
    for shading in Shading::ALL {
        let picture = painter.picture(&settings(shading)).unwrap();
        let columns = picture.rows().all(|mut row| {
            let first = row.next();
            row.all(|pixel| Some(pixel) == first)
        });
        assert!(columns, "{shading:?}");
    }
}
