//! Noisy against denoised, and both against a clean mesh.

use super::super::dialog::FilePurpose;
use super::super::keys;
use super::super::ui_state::{Comparing, UiState};
use crate::app::App;
use crate::app::vertex_numbers::Quantity;
use egui::Ui;
use planish_geometry::metrics::Comparison;
use planish_render::settings::Shading;

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    ui.horizontal_wrapped(|ui| {
        let mut button = |ui: &mut Ui, words: &str, how, help: &str| {
            let chosen = ui.selectable_label(ui_state.comparing == how, words).on_hover_text(help);
            ui_state.mark(words, chosen.rect);
            if chosen.clicked() {
                ui_state.compare(how);
            }
        };
        button(ui, "Split", Comparing::Split, "noisy on the left, with the map on the right; drag the line");
        button(ui, "Blink", Comparing::Blink, "one after the other");
        let view = &mut app.choices.view;
        let heat = ui.selectable_label(view.shading == Shading::Height, "Heights");
        ui_state.mark("Heights", heat.rect);
        if heat.on_hover_text("how far the map moves each vertex").clicked() {
            view.shading = if view.shading == Shading::Height { Shading::default() } else { Shading::Height };
        }
        let has_noise = app.map().is_some_and(|map| map.noise.is_some());
        if !app.has_brush() {
            numbers(ui, app, ui_state, Quantity::Noise, has_noise);
            let has_clean = app.clean().is_some();
            numbers(ui, app, ui_state, Quantity::Error, has_clean);
        }
    });
    match app.clean().map(|clean| clean.path.clone()) {
        None => {
            let button = ui.button("Clean mesh …").on_hover_text("measure against it while λ moves");
            ui_state.mark("clean", button.rect);
            if button.clicked() {
                ui_state.ask(FilePurpose::Clean);
            }
        }
        Some(path) => {
            ui.horizontal_wrapped(|ui| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                ui.label(format!("against {name}")).on_hover_text(path.display().to_string());
                if ui.small_button("✖").on_hover_text("compare no more").clicked() {
                    app.forget_clean();
                }
            });
            table(ui, app);
        }
    }
}

/// Button that colours the model by numbers of its vertices.
fn numbers(ui: &mut Ui, app: &mut App, ui_state: &mut UiState, quantity: Quantity, is_known: bool) {
    let (words, help, missing) = match quantity {
        Quantity::Noise => (
            "Noise",
            "where the noise is, and how much (N); the darkest colour is no noise, or a place where none could be measured",
            "only auto measures the noise, and only where a mesh is baked here",
        ),
        Quantity::Error => ("Error", "how far the faces are turned away from the clean mesh", "needs a clean mesh"),
        Quantity::Mask => ("Mask", "how far each vertex may go", "needs a mask"),
    };
    let is_shown = app.choices.view.shading == Shading::Heat && app.quantity == quantity;
    let button = ui.add_enabled(is_known, egui::Button::selectable(is_shown, words));
    ui_state.mark(words, button.rect);
    if button.on_hover_text(help).on_disabled_hover_text(missing).clicked() {
        keys::show_numbers(app, quantity);
    }
}

/// Rows of the table: what, how it reads, and where it is.
type Row = (&'static str, &'static str, fn(&Comparison) -> String);

const ROWS: [Row; 5] = [
    ("Ea", "mean angle between face normals, degrees", |c| format!("{:.3}°", c.ea)),
    ("d mean", "mean distance to the clean surface, mean edge lengths", |c| format!("{:.4}", c.d_mean)),
    ("d max", "largest distance to the clean surface, mean edge lengths", |c| format!("{:.4}", c.d_max)),
    ("volume", "against the clean mesh; of closed meshes", |c| {
        c.vol_change_pct.map_or_else(|| "open".to_owned(), |v| format!("{v:+.3} %"))
    }),
    ("flipped", "faces that look to the other side", |c| c.flipped.to_string()),
];

fn table(ui: &mut Ui, app: &App) {
    let Some(measured) = app.measured() else {
        ui.spinner();
        return;
    };
    egui::Grid::new("measured").num_columns(3).striped(true).show(ui, |ui| {
        ui.label("");
        ui.strong("noisy");
        if let Some((lambda, _)) = measured.displaced {
            ui.strong(format!("λ = {lambda:.2}"));
        }
        ui.end_row();
        for (what, help, value) in ROWS {
            ui.label(what).on_hover_text(help);
            ui.monospace(value(measured.noisy()));
            if let Some((_, displaced)) = &measured.displaced {
                ui.monospace(value(displaced));
            }
            ui.end_row();
        }
    });
}
