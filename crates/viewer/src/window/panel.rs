//! The panel: everything that can be chosen, and everything that is known. Values and widgets only; it needs no GPU.

mod compare;
mod map;
mod mask;
mod mesh;
mod mesh_list;
mod method;
mod view_settings;
mod volume;

use super::dialog::{Dialog, FilePurpose, Outcome};
use super::ui_state::{Action, UiState};
use super::{keys, take, viewport};
use crate::app::App;
use egui::{Context, Ui};

/// Draws the whole window.
pub fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let context = ui.ctx().clone();
    keys::take(&context, app, ui_state);
    if !ui_state.panel_hidden {
        egui::Panel::right("panel").resizable(true).default_size(330.0).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| all(ui, app, ui_state));
        });
    }
    egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| viewport::show(ui, app, ui_state));
    keys::help(&context, ui_state);
    dialog(&context, app, ui_state);
}

fn all(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    ui.add_space(4.0);
    buttons(ui, app, ui_state);
    ui.separator();
    mesh_list::show(ui, app, ui_state);
    lambda(ui, app, ui_state);
    if app.document().is_some() {
        method::strength(ui, app, ui_state);
    }
    // Of other methods than `auto` there is nothing to say that their settings do not.
    if let Some(map) = app.map().filter(|map| map.manifest.choice.is_some()) {
        ui.label(&map.summary);
    }
    view_settings::shading(ui, app, ui_state);
    section(ui, "Denoise", true, |ui| method::show(ui, app, ui_state));
    section(ui, "Compare", true, |ui| compare::show(ui, app, ui_state));
    section(ui, "Map", true, |ui| map::show(ui, app, ui_state));
    section(ui, "View and light", false, |ui| view_settings::show(ui, app, ui_state));
    section(ui, "Mesh", true, |ui| mesh::show(ui, app, ui_state));
}

fn section(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    let header = egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(open);
    header.show(ui, |ui| {
        // With its number and its label a slider is no wider than the panel, which must not change with what it holds.
        ui.spacing_mut().slider_width = (ui.available_width() - 175.0).max(40.0);
        add(ui);
    });
}

fn buttons(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    ui.horizontal_wrapped(|ui| {
        let open = ui.button("Open …").on_hover_text("a mesh, or the manifest of a map");
        ui_state.mark("open", open.rect);
        if open.clicked() {
            ui_state.ask(FilePurpose::Open);
        }
        let recent = app.window_state.recent.clone();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("⏷", |ui| {
                for path in recent {
                    if ui.button(path.display().to_string()).clicked() {
                        app.open(&path);
                    }
                }
            });
        });
        let save = ui.add_enabled(app.map().is_some(), egui::Button::new("Save map …"));
        let save = save.on_hover_text("the files that the command line would write");
        ui_state.mark("save", save.rect);
        if save.clicked() {
            ui_state.dialog = app.folder().map(|folder| Dialog::save(&folder));
        }
        let [undo, redo] = app.can_undo_redo();
        if ui.add_enabled(undo, egui::Button::new("⟲")).on_hover_text("undo").clicked() {
            app.undo();
        }
        if ui.add_enabled(redo, egui::Button::new("⟳")).on_hover_text("redo").clicked() {
            app.redo();
        }
        if ui.button("?").on_hover_text("keys and mouse (F1)").clicked() {
            ui_state.help = !ui_state.help;
        }
    });
    ui.horizontal_wrapped(|ui| {
        let is_open = app.document().is_some();
        let shot = ui.add_enabled(is_open, egui::Button::new("Screenshot")).on_hover_text("beside the mesh (S)");
        ui_state.mark("screenshot", shot.rect);
        if shot.clicked() {
            ui_state.actions.push(Action::Screenshot);
        }
        let has_map = app.map().is_some();
        let both = ui.add_enabled(has_map, egui::Button::new("Before | after"));
        ui_state.mark("before after", both.rect);
        if both.on_hover_text("one picture with both halves, beside the mesh").clicked() {
            ui_state.actions.push(Action::BeforeAfter);
        }
        let animation = ui.add_enabled(has_map, egui::Button::new("Animation"));
        ui_state.mark("animation", animation.rect);
        if animation.on_hover_text("λ goes up and down in an animated PNG, beside the mesh").clicked() {
            ui_state.actions.push(Action::Animation);
        }
        let turn = ui.add_enabled(is_open, egui::Button::new("Turntable"));
        ui_state.mark("turntable", turn.rect);
        let pictures = &mut ui_state.turntable;
        if turn.on_hover_text("pictures once around, in a folder beside the mesh").clicked() {
            ui_state.actions.push(Action::Turntable(*pictures));
        }
        ui.add_enabled(is_open, egui::DragValue::new(pictures).range(1..=3600).suffix(" pictures"));
    });
}

fn lambda(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let lambda = &mut app.choices.view.displace.lambda;
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 90.0).max(60.0);
        ui.label(egui::RichText::new("λ").size(18.0).strong());
        let slider = egui::Slider::new(lambda, 0.0..=keys::MOST_LAMBDA).fixed_decimals(2);
        let slider = ui.add(slider.clamping(egui::SliderClamping::Edits));
        ui_state.mark("λ", slider.rect);
        slider.on_hover_text("strength of the map: 0 is the mesh as it is, 1 is denoised (arrow keys, 0, 1)");
    });
}

fn dialog(context: &Context, app: &mut App, ui_state: &mut UiState) {
    let Some(mut dialog) = ui_state.dialog.take() else { return };
    match dialog.show(context, |name, rect| ui_state.mark(name, rect)) {
        Outcome::Open => ui_state.dialog = Some(dialog),
        Outcome::Closed => {}
        Outcome::File(purpose, path) => take(app, purpose, &path),
        Outcome::SaveTo(folder) => app.save(&folder),
    }
}

/// So that no list of this panel has to be scrolled, points.
const LONGEST_LIST: f32 = 420.0;

/// Choices in a list.
fn choose<T: Clone + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    all: impl IntoIterator<Item = (String, T)>,
) -> egui::Response {
    let all: Vec<_> = all.into_iter().collect();
    let shown = all.iter().find(|(_, choice)| *choice == *value).map_or("", |(words, _)| words.as_str()).to_owned();
    let list = egui::ComboBox::from_label(label).selected_text(shown).width(150.0).height(LONGEST_LIST);
    list.show_ui(ui, |ui| {
        for (words, choice) in all {
            ui.selectable_value(value, choice, words);
        }
    })
    .response
}

/// The name of a value as it stands in files of settings.
fn name<T: serde::Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name.replace('-', " "),
        _ => String::new(),
    }
}

/// Sets the style of the widgets.
pub fn style(context: &Context) {
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.interaction.tooltip_delay = 0.4;
        // Facts are for reading: the grey of egui's labels is too faint for its thin letters.
        let text = if style.visuals.dark_mode { 205 } else { 45 };
        style.visuals.widgets.noninteractive.fg_stroke.color = egui::Color32::from_gray(text);
    });
}
