//! The list of meshes that were opened or dropped.

use super::super::ui_state::UiState;
use crate::app::mesh_list::{BakeState, ListedMesh};
use crate::app::{App, Work};
use egui::{Color32, Ui};

/// Shows the list where there is more than the mesh that is open.
pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let meshes = app.meshes();
    if meshes.len() < 2 {
        return;
    }
    let open = app.document().map(|document| document.mesh.clone());
    let is_baking = app.status(Work::BakeAll).is_some();
    for (number, ListedMesh { path, state }) in meshes.iter().enumerate() {
        ui.horizontal(|ui| {
            let (icon, colour, words) = match state {
                BakeState::Untouched => ("  ", ui.visuals().text_color(), path.display().to_string()),
                BakeState::Waiting => ("…", ui.visuals().weak_text_color(), "waits for its turn".to_owned()),
                BakeState::Baking => ("⏳", ui.visuals().text_color(), "is being baked".to_owned()),
                BakeState::Done(folder) => ("✔", Color32::from_rgb(70, 160, 90), format!("in {}", folder.display())),
                BakeState::Failed(reason) => ("✖", ui.visuals().error_fg_color, reason.clone()),
            };
            ui.colored_label(colour, icon).on_hover_text(&words);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let label = ui.selectable_label(open.as_deref() == Some(path), name).on_hover_text(words);
            ui_state.mark(&format!("mesh {number}"), label.rect);
            if label.clicked() {
                app.open(path);
            }
            if !is_baking && ui.small_button("✖").on_hover_text("take off the list").clicked() {
                app.unlist(path);
            }
        });
    }
    let all = ui.add_enabled(!is_baking, egui::Button::new("Bake and save all"));
    ui_state.mark("bake all", all.rect);
    if all.on_hover_text("with these settings, each into a folder beside it").clicked() {
        app.bake_all();
    }
    ui.separator();
}
