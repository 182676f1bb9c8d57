//! A lost device is replaced, and what the driver complains about is told.

use crate::support::{duck, own_renderer, small};
use planish_render::gpu::Backend;
use planish_render::gpu::painter::Painter;

#[test]
fn the_picture_after_a_loss_is_the_one_before() {
    let (scene, settings) = (duck(), small([80, 60]));
    for backend in [Backend::Vulkan, Backend::Gl] {
        let mut painter = Painter::new(backend, own_renderer(backend), &scene).unwrap();
        let before = painter.picture(&settings).unwrap();
        painter.renderer().gpu().device.destroy();
        assert!(painter.picture(&settings).unwrap() == before, "{backend:?}");
        assert!(before.pixels().any(|p| p.0[0] > 0));
        assert_eq!(painter.renderer().gpu().validation_errors(), Vec::<String>::new());
    }
}

#[test]
fn what_the_driver_refuses_is_told_once() {
    let scene = duck();
    let painter = Painter::new(Backend::Vulkan, own_renderer(Backend::Vulkan), &scene).unwrap();
    let gpu = painter.renderer().gpu();
    let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        // What is mapped cannot be drawn from.
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    assert_eq!(gpu.validation_errors().len(), 1);
    assert_eq!(gpu.validation_errors(), Vec::<String>::new());
}
