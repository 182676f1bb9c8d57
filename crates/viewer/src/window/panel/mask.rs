//! Widgets of the mask: how far each vertex may go, painted or from a file.

use super::super::dialog::FilePurpose;
use super::super::ui_state::UiState;
use crate::app::App;
use crate::app::mask_painter::{Brush, Effect};
use egui::Ui;
use planish_files::text::count;

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let is_open = app.document().is_some();
    ui.horizontal_wrapped(|ui| {
        let paint = ui.add_enabled(is_open, egui::Button::new("Paint").selected(app.has_brush()));
        ui_state.mark("paint", paint.rect);
        if paint.on_hover_text("paint on the model what stays as it is (M)").clicked() {
            app.switch_brush();
        }
        let open = ui.add_enabled(is_open, egui::Button::new("Open mask …"));
        if open
            .on_hover_text("a grey picture in the texture coordinates, or a text with a weight for each vertex")
            .clicked()
        {
            ui_state.ask(FilePurpose::Mask);
        }
        let has_mask = app.choices.bake_config.limits.mask.is_some();
        let save = ui.add_enabled(has_mask, egui::Button::new("Save mask"));
        ui_state.mark("save mask", save.rect);
        if save.on_hover_text("beside the mesh, where the copied command looks for it").clicked() {
            app.save_mask();
        }
    });
    if app.has_brush() {
        brush(ui, app);
        ui.horizontal_wrapped(|ui| {
            if ui.button("Protect all").clicked() {
                app.change_mask(|_| 0.0);
            }
            if ui.button("Invert").clicked() {
                app.change_mask(|weight| 1.0 - weight);
            }
            if ui.button("Clear").on_hover_text("every vertex is denoised").clicked() {
                app.change_mask(|_| 1.0);
            }
        });
    }
    let Some(mask) = &app.choices.bake_config.limits.mask else { return };
    let words = match app.mask_weights() {
        Some(weights) => {
            let held = weights.iter().filter(|weight| **weight < 1.0).count();
            format!("{} held back", count(held, "vertex is", "vertices are"))
        }
        None => "a mask holds vertices back".to_owned(),
    };
    ui.label(words).on_hover_text(&mask.from);
}

fn brush(ui: &mut Ui, app: &mut App) {
    let brush = &mut app.brush;
    // Indented, there is less room than in the section.
    ui.spacing_mut().slider_width = (ui.available_width() - 145.0).max(40.0);
    ui.horizontal(|ui| {
        ui.selectable_value(&mut brush.effect, Effect::Protect, "protect").on_hover_text("these vertices stay");
        ui.selectable_value(&mut brush.effect, Effect::Release, "release").on_hover_text("these vertices are denoised");
        ui.weak("Ctrl does the other");
    });
    ui.add(egui::Slider::new(&mut brush.radius, Brush::RADII).logarithmic(true).max_decimals(3).text("radius"))
        .on_hover_text("in radii of the model ([ and ])");
    ui.add(egui::Slider::new(&mut brush.strength, 0.05..=1.0).max_decimals(2).text("strength"))
        .on_hover_text("how far one stroke goes");
}
