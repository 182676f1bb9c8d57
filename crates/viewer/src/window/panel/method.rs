//! How the mesh is denoised: the method, its settings, and where the bake is.

use super::super::dialog::FilePurpose;
use super::super::session::{Action, Session};
use crate::app::options::{self, KNOBS, Knob, Values};
use crate::app::{App, Rebake, Work};
use egui::{Response, Ui};
use planish_geometry::denoise::Denoiser;
use planish_geometry::displacement::MapKind;
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
        chosen(ui, app);
        knobs(ui, app, session);
        ui.collapsing("Limits", |ui| limits(ui, app, session));
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
            session.ask(FilePurpose::Target);
        }
    });
}

/// What `auto` measured and chose, in words.
fn chosen(ui: &mut Ui, app: &App) {
    if app.choices.recipe.denoiser.name() == "auto"
        && let Some(choice) = app.map().and_then(|map| map.manifest.choice.as_ref())
    {
        ui.label(choice.to_string());
    }
}

fn pick(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let denoiser = &mut app.choices.recipe.denoiser;
    let list = egui::ComboBox::from_label("method").selected_text(denoiser.name()).width(150.0);
    let list = list.height(super::LONGEST_LIST).show_ui(ui, |ui| {
        for method in Denoiser::every() {
            let label = ui.selectable_label(method.name() == denoiser.name(), method.name());
            let label = label.on_hover_text(options::described(method.name()));
            session.mark(method.name(), label.rect);
            if label.clicked() && method.name() != denoiser.name() {
                *denoiser = method;
            }
        }
    });
    session.mark("method", list.response.rect);
    ui.weak(options::described(denoiser.name()));
    ui.horizontal(|ui| {
        let default = options::named(denoiser.name());
        let button = ui.add_enabled(*denoiser != default, egui::Button::new("Defaults").small());
        if button.on_hover_text("settings that work on most meshes").clicked() {
            *denoiser = default;
        }
        if let Some(paper) = denoiser.paper() {
            let button = ui.add_enabled(*denoiser != paper, egui::Button::new("As in the paper").small());
            if button.on_hover_text("settings of the method's authors").clicked() {
                *denoiser = paper;
            }
        }
    });
}

fn knobs(ui: &mut Ui, app: &mut App, session: &mut Session) {
    // Of a map of heights the motion is along normals always.
    let is_scalar = app.choices.recipe.settings.map == MapKind::Scalar;
    let denoiser = &mut app.choices.recipe.denoiser;
    let settings = options::json(denoiser);
    for knob in KNOBS {
        let Some(value) = settings.pointer(knob.place) else { continue };
        if is_scalar && knob.label == "motion" {
            continue;
        }
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

/// The widget of a knob. Left alone, a value keeps its last digit.
fn turn(ui: &mut Ui, knob: &Knob, value: &mut Value) -> Response {
    match knob.values {
        Values::Count { usual } => {
            let mut count = value.as_u64().unwrap_or(0) as u32;
            let most = usual.max(count);
            let slider = egui::Slider::new(&mut count, 0..=most).text(knob.label);
            let response = ui.add(slider.clamping(egui::SliderClamping::Never));
            *value = count.min(100_000).into();
            response
        }
        Values::Number { least, most, usual, measured } => {
            let row = |ui: &mut Ui| {
                let before = value.as_f64();
                let mut given = before.is_some();
                if measured {
                    ui.checkbox(&mut given, "").on_hover_text("given, instead of measured on the mesh");
                }
                if !given {
                    *value = Value::Null;
                    return ui.label(format!("{}: measured", knob.label));
                }
                let before = before.unwrap_or(0.2);
                let mut number = before;
                let slider = egui::Slider::new(&mut number, least..=usual.max(before)).text(knob.label);
                let response = ui.add(slider.clamping(egui::SliderClamping::Never).max_decimals(4));
                if number != before || value.is_null() {
                    *value = number.clamp(least, most).into();
                }
                response
            };
            ui.horizontal(row).inner
        }
        Values::Words { all, measured } => {
            let before = value.as_str().map(str::to_owned);
            let mut chosen = before.as_deref();
            let words = all.iter().map(|word| ((*word).to_owned(), Some(*word)));
            let nothing = measured.then(|| ("measured".to_owned(), None));
            let response = super::choose(ui, knob.label, &mut chosen, nothing.into_iter().chain(words));
            *value = chosen.into();
            response
        }
        Values::Several(all) => several(ui, knob.label, all, value),
        Values::Prior => {
            let before = options::prior_name(value);
            let mut chosen = before;
            let response = super::choose(ui, knob.label, &mut chosen, options::PRIORS.map(|(n, _)| (n.to_owned(), n)));
            if let Some((_, prior)) = options::PRIORS.iter().find(|(name, _)| *name == chosen && chosen != before) {
                *value = serde_json::to_value(prior).unwrap_or_default();
            }
            response
        }
    }
}

/// A list of words to tick; all that suit where none is ticked.
fn several(ui: &mut Ui, label: &str, all: &'static [&'static str], value: &mut Value) -> Response {
    let mut ticked: Vec<&str> = match value.as_array() {
        Some(words) => all.iter().copied().filter(|w| words.iter().any(|v| v == w)).collect(),
        None => Vec::new(),
    };
    let shown = if ticked.is_empty() { "all that suit".to_owned() } else { ticked.join(", ") };
    let list = egui::ComboBox::from_label(label).selected_text(shown).width(150.0);
    let list = list.close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let response = list.show_ui(ui, |ui| {
        for word in all {
            let mut on = ticked.contains(word);
            if ui.checkbox(&mut on, *word).changed() {
                ticked = all.iter().copied().filter(|w| if w == word { on } else { ticked.contains(w) }).collect();
            }
        }
    });
    *value = if ticked.is_empty() { Value::Null } else { ticked.into() };
    response.response
}

/// What every method is held back by.
fn limits(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let holds = &mut app.choices.recipe.limits;
    let rim = "vertices on the rim of an open mesh do not move";
    ui.checkbox(&mut holds.boundary, "the rim stays").on_hover_text(rim);
    ui.checkbox(&mut holds.preserve_volume, "the volume stays").on_hover_text("restored by an even offset");
    ui.horizontal(|ui| {
        let mut is_limited = holds.max_displacement.is_some();
        ui.checkbox(&mut is_limited, "at most").on_hover_text("how far a vertex may go");
        holds.max_displacement = is_limited.then(|| holds.max_displacement.unwrap_or(1.0));
        if let Some(most) = &mut holds.max_displacement {
            ui.add(egui::DragValue::new(most).range(0.0..=1e6).speed(0.01).suffix(" mean edges"));
        }
    });
    ui.horizontal_wrapped(|ui| {
        let mut forget = false;
        if let Some(mask) = &holds.mask {
            ui.label(format!("{} stays", mask.display()));
            forget |= ui.small_button("✖").clicked();
        } else if !holds.lines.is_empty() {
            ui.label(format!("`v` lines {} stay", String::from(holds.lines.clone())));
            forget |= ui.small_button("✖").clicked();
        } else if ui.button("Vertices that stay …").on_hover_text("a text with numbers of `v` lines").clicked() {
            session.ask(FilePurpose::Mask);
        }
        if forget {
            (holds.mask, holds.lines) = <_>::default();
        }
    });
}
