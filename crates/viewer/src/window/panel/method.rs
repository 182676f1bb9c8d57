//! Section on denoising: the method, its settings, and the progress of the bake.

use super::super::dialog::FilePurpose;
use super::super::ui_state::{Action, UiState};
use crate::app::{App, Rebake, Work};
use egui::{Response, Ui};
use planish_geometry::denoise::{Denoiser, Parameter, Values};
use planish_geometry::map::displacement::MapKind;
use planish_geometry::named::Word;
use serde_json::Value;

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    if let Some(target) = app.choices.bake_config.target.clone() {
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("displacement to {}", target.display()));
            if ui.button("Denoise instead").clicked() {
                app.choices.bake_config.target = None;
            }
        });
    } else {
        pick(ui, app, ui_state);
        chosen(ui, app);
        parameters(ui, app, ui_state);
        ui.collapsing("Limits", |ui| limits(ui, app, ui_state));
        // Whoever paints by the key finds the brush.
        let mask = egui::CollapsingHeader::new("Mask").open(app.has_brush().then_some(true));
        mask.show(ui, |ui| super::mask::show(ui, app, ui_state));
    }
    ui.horizontal_wrapped(|ui| {
        let mut live = app.rebake == Rebake::Live;
        ui.checkbox(&mut live, "live").on_hover_text("bake as soon as a change settles");
        app.rebake = if live { Rebake::Live } else { Rebake::OnDemand };
        let baking = app.status(Work::Bake).is_some();
        let can = app.document().is_some() && !baking && !app.is_baked();
        let bake = ui.add_enabled(can, egui::Button::new("Bake"));
        ui_state.mark("bake", bake.rect);
        if bake.clicked() {
            app.bake();
        }
        let words = match (app.document().is_some(), baking, app.is_baked()) {
            (false, ..) => "",
            (_, true, _) => "the last result stays until it is done",
            (.., true) => "up to date",
            (.., false) => "out of date",
        };
        ui.weak(words);
    });
    ui.horizontal_wrapped(|ui| {
        let command = app.command();
        let copy = ui.add_enabled(command.is_some(), egui::Button::new("Copy command"));
        let command = command.unwrap_or_default();
        if copy.on_hover_text(&command).clicked() {
            ui_state.actions.push(Action::Copy(command));
        }
        if ui.button("Target …").on_hover_text("bake the displacement to the result of another denoiser").clicked() {
            ui_state.ask(FilePurpose::Target);
        }
    });
}

/// Name of the parameter that says how much of the noise a method takes off.
const STRENGTH: &str = "strength";

/// The dial for how much of the noise is taken off, for methods that have one; a change bakes again, unlike λ.
pub(super) fn strength(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let bake_config = &mut app.choices.bake_config;
    let denoiser = &mut bake_config.denoiser;
    let parameter = denoiser.options().find(|parameter| parameter.name == STRENGTH);
    let Some(parameter) = parameter.filter(|_| bake_config.target.is_none()) else { return };
    let before = denoiser.get(parameter).as_f64().unwrap_or(1.0);
    let mut number = before;
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 130.0).max(60.0);
        ui.label("strength");
        let slider = egui::Slider::new(&mut number, 0.0..=2.0_f64.max(before)).max_decimals(2);
        let slider = ui.add(slider.clamping(egui::SliderClamping::Never));
        ui_state.mark(parameter.label, slider.rect);
        slider.on_hover_text(
            "how much noise is looked for, times what was measured: 1 takes off what was found, less keeps more detail",
        );
    });
    if number != before {
        // A value that is not allowed changes nothing, and the widget goes back.
        let _ = denoiser.set_parameter(parameter, number.into());
    }
}

/// Shows what `auto` measured and chose, in words.
fn chosen(ui: &mut Ui, app: &App) {
    if app.choices.bake_config.denoiser.name() == "auto"
        && let Some(choice) = app.map().and_then(|map| map.manifest.choice.as_ref())
    {
        ui.label(choice.to_string());
    }
}

fn pick(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let denoiser = &mut app.choices.bake_config.denoiser;
    let list = egui::ComboBox::from_label("method").selected_text(denoiser.name()).width(150.0);
    let list = list.height(super::LONGEST_LIST).show_ui(ui, |ui| {
        for method in Denoiser::every() {
            let label = ui.selectable_label(method.name() == denoiser.name(), method.name());
            let label = label.on_hover_text(method.summary());
            ui_state.mark(method.name(), label.rect);
            if label.clicked() && method.name() != denoiser.name() {
                *denoiser = method;
            }
        }
    });
    ui_state.mark("method", list.response.rect);
    ui.weak(denoiser.summary());
    ui.horizontal(|ui| {
        let default = Denoiser::named(denoiser.name()).unwrap_or_default();
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

fn parameters(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    // Of a map of heights the motion is along normals always.
    let is_scalar = app.choices.bake_config.settings.map == MapKind::Scalar;
    let denoiser = &mut app.choices.bake_config.denoiser;
    for parameter in denoiser.options() {
        // The strength stands beside λ.
        if (is_scalar && parameter.name == "motion") || parameter.name == STRENGTH {
            continue;
        }
        let before = denoiser.get(parameter);
        let mut value = before.clone();
        let response = widget(ui, parameter, &mut value).on_hover_text(help(parameter));
        ui_state.mark(parameter.label, response.rect);
        if value != before {
            // A value that is not allowed changes nothing, and the widget goes back.
            let _ = denoiser.set_parameter(parameter, value);
        }
    }
}

/// Help text of a parameter, with its unit.
fn help(parameter: &Parameter) -> String {
    let unit = parameter.unit.map(|unit| format!(", in {unit}")).unwrap_or_default();
    format!("{}{unit}", parameter.help)
}

/// The widget of a parameter. Left alone, a value keeps its last digit.
fn widget(ui: &mut Ui, parameter: &Parameter, value: &mut Value) -> Response {
    let label = parameter.label;
    match parameter.values {
        Values::Count { max, slider_max } => {
            let mut count = value.as_u64().unwrap_or(0) as u32;
            let end = slider_max.max(count);
            let slider = egui::Slider::new(&mut count, 0..=end).text(label);
            let response = ui.add(slider.clamping(egui::SliderClamping::Never));
            *value = count.min(max).into();
            response
        }
        Values::Number { min, max, slider_max } => {
            ui.horizontal(|ui| number(ui, parameter, value, [min, slider_max, max])).inner
        }
        Values::Word(_) | Values::Preset(_) => {
            let before = value.as_str().map(str::to_owned);
            let mut chosen = before.as_deref();
            let nothing = parameter.is_optional.then(|| ("measured".to_owned(), None));
            let all = parameter.choices().iter().map(|word| (word.name.to_owned(), Some(word.name)));
            let response = super::choose(ui, label, &mut chosen, nothing.into_iter().chain(all));
            *value = chosen.into();
            response
        }
        Values::Words(words) => several(ui, label, words, value),
        // Names of files are given on the command line.
        Values::Text(_) => ui.label(format!("{label}: {}", value.as_str().unwrap_or("built in"))),
    }
}

/// A slider for a number, and a tick where the number may also be measured.
fn number(ui: &mut Ui, parameter: &Parameter, value: &mut Value, [min, slider_max, max]: [f64; 3]) -> Response {
    let before = value.as_f64();
    let mut given = before.is_some();
    if parameter.is_optional {
        ui.checkbox(&mut given, "").on_hover_text("given, instead of measured on the mesh");
    }
    if !given {
        *value = Value::Null;
        return ui.label(format!("{}: measured", parameter.label));
    }
    let before = before.unwrap_or(0.2);
    let mut number = before;
    let slider = egui::Slider::new(&mut number, min..=slider_max.max(before)).text(parameter.label);
    let response = ui.add(slider.clamping(egui::SliderClamping::Never).max_decimals(4));
    if number != before || value.is_null() {
        *value = number.clamp(min, max).into();
    }
    response
}

/// A list of words to tick; all that suit where none is ticked.
fn several(ui: &mut Ui, label: &str, words: &'static [Word], value: &mut Value) -> Response {
    let is_ticked = |name: &str| value.as_array().is_some_and(|all| all.iter().any(|word| word == name));
    let mut ticked: Vec<&str> = words.iter().map(|word| word.name).filter(|name| is_ticked(name)).collect();
    let shown = if ticked.is_empty() { "all that suit".to_owned() } else { ticked.join(", ") };
    let list = egui::ComboBox::from_label(label).selected_text(shown).width(150.0);
    let list = list.close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let response = list.show_ui(ui, |ui| {
        for Word { name, help, .. } in words {
            let mut on = ticked.contains(name);
            if ui.checkbox(&mut on, *name).on_hover_text(*help).changed() {
                let stays = |other: &&str| if other == name { on } else { ticked.contains(other) };
                ticked = words.iter().map(|word| word.name).filter(stays).collect();
            }
        }
    });
    *value = if ticked.is_empty() { Value::Null } else { ticked.into() };
    response.response
}

/// Widgets of the limits, which every method obeys.
fn limits(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let limits = &mut app.choices.bake_config.limits;
    let boundary = "vertices on the boundary of an open mesh do not move";
    ui.checkbox(&mut limits.boundary, "keep boundary").on_hover_text(boundary);
    ui.checkbox(&mut limits.preserve_volume, "keep volume").on_hover_text("restored by an even offset");
    ui.horizontal(|ui| {
        let mut is_limited = limits.max_displacement.is_some();
        ui.checkbox(&mut is_limited, "at most").on_hover_text("how far a vertex may go");
        limits.max_displacement = is_limited.then(|| limits.max_displacement.unwrap_or(1.0));
        if let Some(most) = &mut limits.max_displacement {
            ui.add(egui::DragValue::new(most).range(0.0..=1e6).speed(0.01).suffix(" mean edges"));
        }
    });
    ui.horizontal_wrapped(|ui| {
        let mut forget = false;
        if let Some(path) = &limits.fixed_file {
            ui.label(format!("{} stays", path.display()));
            forget |= ui.small_button("✖").clicked();
        } else if !limits.fixed.is_empty() {
            ui.label(format!("`v` lines {} stay", String::from(limits.fixed.clone())));
            forget |= ui.small_button("✖").clicked();
        } else if ui.button("Vertices that stay …").on_hover_text("a text with numbers of `v` lines").clicked() {
            ui_state.ask(FilePurpose::FixedVertices);
        }
        if forget {
            (limits.fixed_file, limits.fixed) = <_>::default();
        }
    });
}
