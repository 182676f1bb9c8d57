//! The panel: everything that can be chosen, and everything that is known. Values and widgets only; it needs no GPU.

mod compare;
mod look;
mod map;
mod mesh;
mod method;

use super::dialog::Outcome;
use super::session::{Session, Wanted};
use super::{keys, take, view};
use crate::app::App;
use egui::{Context, Ui};

/// The whole window.
pub fn show(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let context = ui.ctx().clone();
    keys::take(&context, app, session);
    if !session.panel_hidden {
        egui::Panel::right("panel").resizable(true).default_size(330.0).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| all(ui, app, session));
        });
    }
    egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| view::show(ui, app, session));
    keys::help(&context, session);
    dialog(&context, app, session);
}

fn all(ui: &mut Ui, app: &mut App, session: &mut Session) {
    buttons(ui, app, session);
    ui.separator();
    lambda(ui, app, session);
    section(ui, "Denoise", true, |ui| method::show(ui, app, session));
    section(ui, "Compare", true, |ui| compare::show(ui, app, session));
    section(ui, "Map", true, |ui| map::show(ui, app, session));
    section(ui, "Look", false, |ui| look::show(ui, app, session));
    section(ui, "Mesh", false, |ui| mesh::show(ui, app));
}

fn section(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(open).show(ui, add);
}

fn buttons(ui: &mut Ui, app: &mut App, session: &mut Session) {
    ui.horizontal_wrapped(|ui| {
        let open = ui.button("Open …").on_hover_text("a mesh, or the manifest of a map");
        session.mark("open", open.rect);
        if open.clicked() {
            session.ask(Wanted::Open);
        }
        let recent = app.remembered.recent.clone();
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
        session.mark("save", save.rect);
        if save.clicked() {
            session.dialog = app.folder().map(|folder| super::dialog::Dialog::save(&folder));
        }
        let [undo, redo] = app.can_undo_redo();
        if ui.add_enabled(undo, egui::Button::new("⟲")).on_hover_text("undo").clicked() {
            app.undo();
        }
        if ui.add_enabled(redo, egui::Button::new("⟳")).on_hover_text("redo").clicked() {
            app.redo();
        }
        if ui.button("?").on_hover_text("keys and mouse").clicked() {
            session.help = !session.help;
        }
    });
}

fn lambda(ui: &mut Ui, app: &mut App, session: &mut Session) {
    ui.spacing_mut().slider_width = 190.0;
    let lambda = &mut app.choices.view.displace.lambda;
    let slider = egui::Slider::new(lambda, 0.0..=keys::MOST_LAMBDA).text("λ").fixed_decimals(2);
    let slider = ui.add(slider.clamping(egui::SliderClamping::Edits));
    session.mark("λ", slider.rect);
    slider.on_hover_text("strength of the map: 0 is the mesh as it is, 1 is denoised");
}

fn dialog(context: &Context, app: &mut App, session: &mut Session) {
    let Some(mut dialog) = session.dialog.take() else { return };
    match dialog.show(context, |name, rect| session.mark(name, rect)) {
        Outcome::Open => session.dialog = Some(dialog),
        Outcome::Closed => session.wanted = Wanted::Open,
        Outcome::File(path) => take(app, session, &path),
        Outcome::SaveTo(folder) => app.save(&folder),
    }
}

/// Choices in a list.
fn choose<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    value: &mut T,
    all: impl IntoIterator<Item = (String, T)>,
) -> egui::Response {
    let all: Vec<_> = all.into_iter().collect();
    let shown = all.iter().find(|(_, choice)| choice == value).map_or("", |(words, _)| words.as_str()).to_owned();
    let list = egui::ComboBox::from_label(label).selected_text(shown).width(150.0);
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

/// How the widgets look.
pub fn style(context: &Context) {
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 4.0);
        style.interaction.tooltip_delay = 0.4;
    });
}
