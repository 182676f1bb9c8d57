//! The part of the window that shows the model: its pictures, what the mouse does there, and what is written over it.

use super::orbit::{self, ViewportCamera};
use super::paint;
use super::pointer::{bounds_of, device};
use super::ui_state::{Comparing, UiState};
use super::viewport_targets::height_range;
use crate::app::jobs::Status;
use crate::app::vertex_numbers::VertexNumbers;
use crate::app::{App, MessageKind, Work};
use egui::{Color32, CursorIcon, Pos2, Rect, Sense, Ui, Vec2, pos2, vec2};
use planish_geometry::metrics::Comparison;
use planish_geometry::source::format::Format;
use planish_render::settings::Shading;
use planish_render::settings::lights::Light;

/// Seconds between pictures that blink.
const BLINK: f64 = 0.7;

const UNIT: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

/// Draws the viewport and handles the mouse in it.
pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let rect = ui.available_rect_before_wrap();
    ui_state.view = Some(rect).filter(|r| r.width() >= 1.0 && r.height() >= 1.0);
    ui_state.mark("view", rect);
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    if response.clicked() || response.drag_started() {
        ui.memory_mut(|m| {
            if let Some(id) = m.focused() {
                m.surrender_focus(id);
            }
        });
    }
    if app.document().is_none() {
        welcome(ui, rect, app, ui_state);
    } else {
        // The ring of the brush lies above the picture.
        pictures(ui, rect, app, ui_state);
        if !paint::steer(ui, &response, app) {
            steer(ui, &response, app, ui_state);
        }
        legend(ui, rect, app);
    }
    notices(ui, rect, app, ui_state);
    if ui.input(|i| !i.raw.hovered_files.is_empty()) {
        ui.painter().rect_filled(rect, 0.0, Color32::from_black_alpha(120));
        let font = egui::FontId::proportional(24.0);
        ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, "drop to open", font, Color32::WHITE);
    }
}

/// Shows what can be opened at the start.
fn welcome(ui: &mut Ui, rect: Rect, app: &mut App, ui_state: &mut UiState) {
    let area = Rect::from_center_size(rect.center(), vec2(420.0_f32.min(rect.width() - 20.0), 320.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(area), |ui| {
        ui.vertical_centered(|ui| {
            ui.heading("planish");
            ui.label(format!("Drop a mesh ({}) or a map (.planish.json) here", Format::extensions()));
            let open = ui.button("Open …");
            ui_state.mark("open", open.rect);
            if open.clicked() {
                ui_state.ask(super::dialog::FilePurpose::Open);
            }
            ui.add_space(16.0);
            for path in app.window_state.recent.clone() {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                if ui.link(name).on_hover_text(path.display().to_string()).clicked() {
                    app.open(&path);
                }
            }
        });
    });
}

/// Moves the camera with the mouse.
fn steer(ui: &Ui, response: &egui::Response, app: &mut App, ui_state: &mut UiState) {
    let rect = response.rect;
    let viewport_camera = ViewportCamera { bounds: bounds_of(app), aspect: rect.width() / rect.height() };
    let (drag, at) = (response.drag_delta(), response.interact_pointer_pos());
    let camera = &mut app.choices.view.camera;
    let divider = rect.left() + rect.width() * ui_state.divider.unwrap_or(0.5);
    let on_divider = |p: Pos2| ui_state.comparing == Comparing::Split && (p.x - divider).abs() < 8.0;
    let drags_divider = ui.memory(|m| m.data.get_temp::<bool>(response.id)).unwrap_or(false);
    if response.hover_pos().is_some_and(on_divider) || drags_divider {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    if response.drag_started() {
        let on_grip = ui.input(|i| i.pointer.press_origin()).is_some_and(on_divider);
        ui.memory_mut(|m| m.data.insert_temp(response.id, on_grip));
    }
    if response.drag_stopped() {
        ui.memory_mut(|m| m.data.insert_temp(response.id, false));
    }
    if let Some(at) = at.filter(|_| response.dragged() && drag != Vec2::ZERO) {
        let (shift, light) = ui.input(|i| (i.modifiers.shift, i.key_down(egui::Key::L)));
        if drags_divider {
            ui_state.divider = Some(((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0));
        } else if !response.dragged_by(egui::PointerButton::Primary) || shift {
            viewport_camera.pan(camera, device(rect, at - drag), device(rect, at));
        } else if light {
            if let Some(light) = app.choices.view.lights.get_mut(ui_state.light) {
                drag_light(light, drag);
            }
        } else {
            let [x, y] = [drag.x, drag.y].map(|d| d / rect.height());
            orbit::orbit(camera, glam::Vec2::new(x, y));
        }
    }
    let camera = &mut app.choices.view.camera;
    if let Some(pointer) = response.hover_pos() {
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = (-0.003 * scroll).exp() / pinch;
        if factor != 1.0 {
            viewport_camera.zoom(camera, device(rect, pointer), factor);
        }
    }
    if response.double_clicked() && !app.has_brush() {
        orbit::fit(&mut app.choices.view.camera);
    }
}

/// Degrees for each point; the light goes where the mouse goes.
fn drag_light(light: &mut Light, drag: Vec2) {
    light.azimuth = (light.azimuth + 0.4 * drag.x + 180.0).rem_euclid(360.0) - 180.0;
    light.elevation = (light.elevation - 0.4 * drag.y).clamp(-90.0, 90.0);
}

fn pictures(ui: &Ui, rect: Rect, app: &App, ui_state: &mut UiState) {
    let painter = ui.painter_at(rect);
    let [with_map, without] = ui_state.pictures;
    let Some(with_map) = with_map else { return };
    match (ui_state.comparing, without) {
        (Comparing::Split, Some(without)) => {
            let share = ui_state.divider.unwrap_or(0.5);
            let x = (rect.left() + rect.width() * share).round();
            let share = (x - rect.left()) / rect.width();
            let left = Rect::from_min_max(rect.min, pos2(x, rect.bottom()));
            let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
            painter.image(without, left, Rect::from_min_max(UNIT.min, pos2(share, 1.0)), Color32::WHITE);
            painter.image(with_map, right, Rect::from_min_max(pos2(share, 0.0), UNIT.max), Color32::WHITE);
            painter.vline(x, rect.y_range(), (3.0, Color32::from_black_alpha(90)));
            painter.vline(x, rect.y_range(), (1.0, Color32::WHITE));
            let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(8.0, 36.0));
            painter.rect_filled(grip, 4.0, Color32::WHITE);
            ui_state.mark("divider", grip);
            let [noisy, with_map] = captions(app);
            tag(&painter, pos2(x - 10.0, rect.top() + 10.0), egui::Align2::RIGHT_TOP, &noisy);
            tag(&painter, pos2(x + 10.0, rect.top() + 10.0), egui::Align2::LEFT_TOP, &with_map);
        }
        (Comparing::Blink, Some(without)) => {
            let time = ui.input(|i| i.time);
            let is_noisy = ((time / BLINK) as u64).is_multiple_of(2);
            painter.image(if is_noisy { without } else { with_map }, rect, UNIT, Color32::WHITE);
            let words = &captions(app)[usize::from(!is_noisy)];
            tag(&painter, rect.min + vec2(10.0, 10.0), egui::Align2::LEFT_TOP, words);
            ui.request_repaint_after_secs((BLINK - time % BLINK) as f32);
        }
        _ => {
            painter.image(with_map, rect, UNIT, Color32::WHITE);
        }
    }
}

/// Words over the mesh as it is, and over the mesh with its map: with a clean mesh, also the errors against it, once they are measured.
pub(super) fn captions(app: &App) -> [String; 2] {
    let lambda = app.choices.view.displace.lambda;
    let errors = |comparison: &Comparison| format!("\nEa {:.2}°\nd mean {:.4}", comparison.ea, comparison.d_mean);
    let (mut noisy, mut with_map) = ("noisy".to_owned(), format!("λ = {lambda:.2}"));
    if let Some(measured) = app.measured() {
        noisy += &errors(measured.noisy());
        if let Some((_, comparison)) = measured.displaced.as_ref().filter(|(of, _)| *of == lambda) {
            with_map += &errors(comparison);
        }
    }
    [noisy, with_map]
}

fn tag(painter: &egui::Painter, at: Pos2, anchor: egui::Align2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(14.0), Color32::WHITE);
    let rect = anchor.anchor_size(at, galley.size() + vec2(12.0, 6.0));
    painter.rect_filled(rect, 4.0, Color32::from_black_alpha(140));
    painter.galley(rect.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}

/// Draws the colour bar of a heat map.
fn legend(ui: &Ui, rect: Rect, app: &App) {
    let view = &app.shown_view();
    let shown = match view.shading {
        Shading::Height => {
            let range = app.map().and_then(|map| view.heat.range.or_else(|| height_range(view, &map.scene)));
            range.map(|range| (range, view.heat.map, "height, model units"))
        }
        Shading::Heat => app.vertex_numbers().map(|shown| (shown.range, VertexNumbers::COLORMAP, shown.title)),
        _ => None,
    };
    let Some((range, colormap, title)) = shown else { return };
    let painter = ui.painter_at(rect);
    let bar = Rect::from_min_size(rect.right_bottom() - vec2(236.0, 60.0), vec2(210.0, 14.0));
    let steps = 75;
    for i in 0..steps {
        let t = (i as f32 + 0.5) / steps as f32;
        let [r, g, b] = colormap.bytes(t);
        let width = bar.width() / steps as f32;
        let cell = Rect::from_min_size(bar.min + vec2(i as f32 * width, 0.0), vec2(width + 0.5, bar.height()));
        painter.rect_filled(cell, 0.0, Color32::from_rgb(r, g, b));
    }
    let number = |x: f32| planish_files::text::measure(f64::from(x));
    tag(&painter, bar.left_bottom() + vec2(-6.0, 4.0), egui::Align2::LEFT_TOP, &number(range.low));
    tag(&painter, bar.right_bottom() + vec2(6.0, 4.0), egui::Align2::RIGHT_TOP, &number(range.high));
    tag(&painter, bar.center_top() - vec2(0.0, 4.0), egui::Align2::CENTER_BOTTOM, title);
}

/// Progress and messages, over the lower edge of the view.
fn notices(ui: &Ui, rect: Rect, app: &mut App, ui_state: &mut UiState) {
    let area = egui::Area::new(egui::Id::unique("notices")).order(egui::Order::Middle);
    let corner = rect.left_bottom() + vec2(12.0, -12.0);
    area.pivot(egui::Align2::LEFT_BOTTOM).fixed_pos(corner).constrain_to(rect).show(ui.ctx(), |ui| {
        ui.set_max_width((rect.width() - 24.0).min(640.0));
        let works = [
            (Work::Load, "Opening"),
            (Work::Bake, "Baking"),
            (Work::Save, "Saving"),
            (Work::Draw, "Drawing"),
            (Work::Prepare, "Painting"),
            (Work::BakeAll, "Baking all"),
        ];
        for (work, words) in works {
            if let Some(status) = app.status(work) {
                let stop = progress(ui, words, status);
                ui_state.mark(&format!("stop {}", words.to_lowercase()), stop.rect);
                if stop.clicked() {
                    app.cancel(work);
                }
            }
        }
        if let Some(status) = ui_state.showing {
            progress(ui, "Showing", status);
        }
        let mut dismissed = None;
        for (i, message) in app.messages().iter().enumerate() {
            let (colour, icon) = match message.kind {
                MessageKind::Done => (Color32::from_rgb(46, 110, 62), "✔"),
                MessageKind::Warning => (Color32::from_rgb(138, 98, 20), "⚠"),
                MessageKind::Error => (Color32::from_rgb(150, 40, 36), "✖"),
            };
            egui::Frame::NONE.fill(colour).corner_radius(5).inner_margin(egui::Margin::symmetric(9, 6)).show(
                ui,
                |ui| {
                    ui.horizontal_wrapped(|ui| {
                        ui.visuals_mut().override_text_color = Some(Color32::WHITE);
                        ui.label(format!("{icon} {}", message.text));
                        let away = ui.small_button("✖").on_hover_text("put away");
                        if i == 0 {
                            ui_state.mark("dismiss", away.rect);
                        }
                        if away.clicked() {
                            dismissed = Some(i);
                        }
                    });
                },
            );
        }
        if let Some(i) = dismissed {
            app.dismiss(i);
        }
    });
}

fn progress(ui: &mut Ui, words: &str, status: Status) -> egui::Response {
    let frame = egui::Frame::popup(ui.style());
    let inner = frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            let text = if status.stopping { "stopping …".to_owned() } else { format!("{words}: {}", status.stage) };
            let bar = egui::ProgressBar::new(status.done).desired_width(260.0).text(text);
            ui.add(bar);
            ui.label(format!("{:.0} s", status.running.as_secs_f32()));
            ui.add_enabled(!status.stopping, egui::Button::new("Stop"))
        })
        .inner
    });
    inner.inner
}
