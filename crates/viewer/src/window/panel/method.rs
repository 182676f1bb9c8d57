//! How the mesh is denoised: the method, its settings, and where the bake is.

use super::super::session::{Action, Session, Wanted};
use crate::app::options::{self, KNOBS, Knob, Values};
use crate::app::{App, Rebake, Work};
use egui::Ui;
use planish_geometry::denoise::Denoiser;
use serde_json::Value;

pub(super) fn show(ui: &mut Ui, app: &mut App, session: &mut Session) {
    if let Some(target) = app.choices.recipe.target.clone() {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("the way to {}", target.display()));
            if ui.button("Denoise instead").clicked() {
                app.choices.recipe.target = None;
            }
        });
    } else {
        pick(ui, app, session);
        knobs(ui, app, session);
    }
    ui.horizontal_wrapped(|ui| {
        let mut live = app.rebake == Rebake::Live;
        ui.checkbox(&mut live, "live").on_hover_text("bake as soon as a change settles");
        app.rebake = if live { Rebake::Live } else { Rebake::OnDemand };
        let baking = app.status(Work::Bake).is_some();
        let can = app.document().is_some() && !baking && !app.is_baked();
        let bake = ui.add_enabled(can, egui::Button::new("Bake"));
        session.mark("bake", bake.rect);
        if bake.clicked() {
            app.bake();
        }
        let words = match (app.document().is_some(), baking, app.is_baked()) {
            (false, ..) => "",
            (_, true, _) => "the last result stays until it is done",
            (.., true) => "up to date",
            (.., false) => "not what is chosen",
        };
        ui.weak(words);
    });
    ui.horizontal_wrapped(|ui| {
        let command = app.command();
        let copy = ui.add_enabled(command.is_some(), egui::Button::new("Copy command"));
        let command = command.unwrap_or_default();
        if copy.on_hover_text(&command).clicked() {
            session.actions.push(Action::Copy(command));
        }
        if ui.button("Target …").on_hover_text("bake the way to the result of another denoiser").clicked() {
            session.ask(Wanted::Target);
        }
    });
}

fn pick(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let denoiser = &mut app.choices.recipe.denoiser;
    ui.horizontal(|ui| {
        let list = egui::ComboBox::from_id_salt("method").selected_text(denoiser.name()).width(150.0);
        let list = list.show_ui(ui, |ui| {
            for method in Denoiser::every() {
                let label = ui.selectable_label(method.name() == denoiser.name(), method.name());
                session.mark(method.name(), label.rect);
                if label.clicked() && method.name() != denoiser.name() {
                    *denoiser = method;
                }
            }
        });
        session.mark("method", list.response.rect);
        if ui.button("Default").on_hover_text("what works on most meshes").clicked() {
            let name = denoiser.name();
            *denoiser = Denoiser::every().into_iter().find(|d| d.name() == name).unwrap_or_default();
        }
        if let Some(paper) = denoiser.paper()
            && ui.button("Paper").on_hover_text("what the method's authors used").clicked()
        {
            *denoiser = paper;
        }
    });
}

fn knobs(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let denoiser = &mut app.choices.recipe.denoiser;
    let settings = options::json(denoiser);
    for knob in &KNOBS {
        let Some(value) = settings.pointer(knob.place) else { continue };
        let mut changed = value.clone();
        let response = turn(ui, knob, &mut changed).on_hover_text(knob.help);
        session.mark(knob.label, response.rect);
        if changed != *value
            && let Some(with) = options::with(denoiser, knob.place, changed)
        {
            *denoiser = with;
        }
    }
}

fn turn(ui: &mut Ui, knob: &Knob, value: &mut Value) -> egui::Response {
    match knob.values {
        Values::Count { usual } => {
            let mut count = value.as_u64().unwrap_or(0) as u32;
            let most = usual.max(count);
            let slider = egui::Slider::new(&mut count, 0..=most).text(knob.label);
            let response = ui.add(slider.clamping(egui::SliderClamping::Never));
            *value = count.min(100_000).into();
            response
        }
        Values::Number { least, most, usual } => {
            let before = value.as_f64().unwrap_or(0.0);
            let mut number = before;
            let slider = egui::Slider::new(&mut number, least..=usual.max(before)).text(knob.label);
            let response = ui.add(slider.clamping(egui::SliderClamping::Never).max_decimals(4));
            // Left alone, a number keeps its last digit.
            if number != before {
                *value = number.clamp(least, most).into();
            }
            response
        }
        Values::Words(words) => {
            let before = value.as_str().unwrap_or_default().to_owned();
            let mut chosen = before.as_str();
            let all = words.iter().map(|word| ((*word).to_owned(), *word));
            let response = super::choose(ui, knob.label, &mut chosen, all);
            *value = chosen.into();
            response
        }
    }
}
