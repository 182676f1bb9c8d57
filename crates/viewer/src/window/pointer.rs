//! What the pointer needs of the viewport: its coordinates there, and the bounds of the mesh.

use crate::app::App;
use egui::{Pos2, Rect};
use planish_render::bounds::Sphere;

/// Normalised device coordinates, y up.
pub(super) fn device(rect: Rect, p: Pos2) -> glam::Vec2 {
    let unit = (p - rect.min) / rect.size();
    glam::Vec2::new(2.0 * unit.x - 1.0, 1.0 - 2.0 * unit.y)
}

/// Bounding sphere of the open mesh.
pub(super) fn bounds_of(app: &App) -> Sphere {
    app.document().map_or_else(Sphere::default, |document| document.scene.bounds())
}
