//! Painting of masks in the viewport: what the mouse does to the brush, and the ring that shows it.

use super::orbit::ViewportCamera;
use super::pointer::{bounds_of, device};
use crate::app::App;
use crate::app::mask_painter::Effect;
use egui::{Color32, PointerButton, Pos2, Ui};
use planish_geometry::mesh::ray_tree::Hit;
use planish_render::input;

/// Paints with the primary button where it is pressed on the mesh. Returns true if the mouse belongs to the brush.
pub(super) fn steer(ui: &Ui, response: &egui::Response, app: &mut App) -> bool {
    if !app.has_brush() {
        return false;
    }
    let (pressed, down, inverted) = ui.input(|i| {
        let pressed = i.pointer.button_pressed(PointerButton::Primary) && !i.modifiers.shift;
        (pressed, i.pointer.button_down(PointerButton::Primary), i.modifiers.command)
    });
    if app.is_painting() && !down {
        app.end_stroke();
    }
    let pointer = response.hover_pos().or(response.interact_pointer_pos());
    let Some(pointer) = pointer.filter(|p| response.rect.contains(*p)) else { return app.is_painting() };
    let Some(hit) = pick(app, response.rect, pointer) else { return app.is_painting() };
    if (pressed && response.contains_pointer()) || app.is_painting() {
        let effect = if inverted { app.brush.effect.opposite() } else { app.brush.effect };
        for pointer in path(ui, pointer, app.is_painting()) {
            if let Some(hit) = pick(app, response.rect, pointer) {
                app.paint(&hit, effect);
            }
        }
        ui.ctx().request_repaint();
    }
    ring(ui, response.rect, app, &hit, pointer, inverted);
    app.is_painting()
}

/// Longest step between points of a stroke, and the most of them in a frame: between two points a stroke is straight, and the mesh is not.
const STEP: f32 = 12.0;
const MOST_STEPS: usize = 32;

/// Places of the pointer since the last frame, the latest last; only the latest where a stroke begins.
fn path(ui: &Ui, pointer: Pos2, goes_on: bool) -> impl Iterator<Item = Pos2> {
    let way = if goes_on { ui.input(|i| i.pointer.delta()) } else { egui::Vec2::ZERO };
    let steps = ((way.length() / STEP).ceil() as usize).clamp(1, MOST_STEPS);
    (0..steps).rev().map(move |left| pointer - way * (left as f32 / steps as f32))
}

/// The point of the mesh under the pointer. The mesh is taken as it was read: noise is lower than a brush is wide.
fn pick(app: &App, rect: egui::Rect, pointer: Pos2) -> Option<Hit> {
    let document = app.document()?;
    let camera = ViewportCamera { bounds: bounds_of(app), aspect: rect.width() / rect.height() };
    let [start, direction] = camera.ray(&app.choices.view.camera, device(rect, pointer));
    app.pick(start.as_dvec3() + input::origin(&document.model), direction.as_dvec3())
}

/// Draws the outline of the brush about the pointer.
fn ring(ui: &Ui, rect: egui::Rect, app: &App, hit: &Hit, pointer: Pos2, inverted: bool) {
    let Some(document) = app.document() else { return };
    let camera = ViewportCamera { bounds: bounds_of(app), aspect: rect.width() / rect.height() };
    let middle = (hit.point - input::origin(&document.model)).as_vec3();
    let length = camera.length_at(&app.choices.view.camera, middle, app.brush.radius_on(document) as f32);
    let effect = if inverted { app.brush.effect.opposite() } else { app.brush.effect };
    let colour = match effect {
        Effect::Protect => Color32::from_rgb(255, 196, 92),
        Effect::Release => Color32::from_rgb(150, 230, 160),
    };
    let (painter, radius) = (ui.painter_at(rect), 0.5 * rect.width() * length);
    painter.circle_stroke(pointer, radius, (3.0, Color32::from_black_alpha(110)));
    painter.circle_stroke(pointer, radius, (1.5, colour));
}
