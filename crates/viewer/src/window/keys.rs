//! The keyboard, and the list of what it does.

use super::dialog::{Dialog, FilePurpose};
use super::orbit::{self, Standard};
use super::ui_state::{Action, Comparing, UiState};
use crate::app::vertex_numbers::Quantity;
use crate::app::{App, Work};
use egui::{Key, Modifiers};
use planish_render::settings::{Overlay, Shading};

/// Effect of a key.
type Effect = fn(&mut App, &mut UiState);

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const COMMAND_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// A key with what it does, in words and in effect.
struct Binding {
    modifiers: Modifiers,
    key: Key,
    words: &'static str,
    effect: Effect,
}

const fn on(modifiers: Modifiers, key: Key, words: &'static str, effect: Effect) -> Binding {
    Binding { modifiers, key, words, effect }
}

/// A step of λ.
const STEP: f32 = 0.05;

/// The largest λ of slider and keys.
pub(super) const MOST_LAMBDA: f32 = 1.5;

fn step_lambda(app: &mut App, by: f32) {
    let lambda = &mut app.choices.view.displace.lambda;
    // Steps land on round numbers, wherever the slider was.
    *lambda = (((*lambda + by) / STEP).round() * STEP).clamp(0.0, MOST_LAMBDA);
}

fn show(app: &mut App, shading: Shading) {
    let view = &mut app.choices.view;
    view.shading = if view.shading == shading { Shading::default() } else { shading };
}

/// Colours the model by numbers of its vertices, or no more.
pub(super) fn show_numbers(app: &mut App, quantity: Quantity) {
    let is_shown = app.choices.view.shading == Shading::Heat && app.quantity == quantity;
    app.choices.view.shading = if is_shown { Shading::default() } else { Shading::Heat };
    app.quantity = quantity;
}

fn bindings() -> [Binding; 31] {
    [
        on(COMMAND, Key::O, "open a mesh or a map", |_, s| s.ask(FilePurpose::Open)),
        on(COMMAND, Key::S, "save the map", |a, s| s.dialog = a.folder().map(|folder| Dialog::save(&folder))),
        on(COMMAND, Key::R, "read the file again", |a, _| a.reload()),
        on(COMMAND_SHIFT, Key::Z, "redo", |a, _| a.redo()),
        on(COMMAND, Key::Z, "undo", |a, _| a.undo()),
        on(COMMAND, Key::Y, "redo", |a, _| a.redo()),
        on(COMMAND_SHIFT, Key::C, "copy the command line that bakes the same", |a, s| {
            s.actions.extend(a.command().map(Action::Copy));
        }),
        on(COMMAND, Key::Q, "quit", |_, s| s.actions.push(Action::Quit)),
        on(NONE, Key::ArrowUp, "more λ", |a, _| step_lambda(a, STEP)),
        on(NONE, Key::ArrowDown, "less λ", |a, _| step_lambda(a, -STEP)),
        on(NONE, Key::Num0, "λ = 0: the mesh as it is", |a, _| a.choices.view.displace.lambda = 0.0),
        on(NONE, Key::Num1, "λ = 1: denoised", |a, _| a.choices.view.displace.lambda = 1.0),
        on(NONE, Key::Space, "split view: noisy | denoised", |_, s| s.compare(Comparing::Split)),
        on(NONE, Key::B, "blink between noisy and denoised", |_, s| s.compare(Comparing::Blink)),
        on(NONE, Key::H, "heat map of the heights", |a, _| show(a, Shading::Height)),
        on(NONE, Key::N, "where the noise is", |a, _| show_numbers(a, Quantity::Noise)),
        on(NONE, Key::T, "triangles shaded flat", |a, _| show(a, Shading::Flat)),
        on(NONE, Key::C, "clay", |a, _| show(a, Shading::Clay)),
        on(NONE, Key::W, "edges of the mesh", |a, _| {
            let overlay = &mut a.choices.view.overlay;
            *overlay = if *overlay == Overlay::Wireframe { Overlay::None } else { Overlay::Wireframe };
        }),
        on(NONE, Key::M, "paint a mask", |a, _| a.switch_brush()),
        on(NONE, Key::OpenBracket, "smaller brush", |a, _| a.brush.scale(0.8)),
        on(NONE, Key::CloseBracket, "larger brush", |a, _| a.brush.scale(1.25)),
        on(NONE, Key::F, "fit the model", |a, _| orbit::fit(&mut a.choices.view.camera)),
        on(NONE, Key::P, "perspective or parallel rays", |a, _| {
            orbit::switch_projection(&mut a.choices.view.camera);
        }),
        on(NONE, Key::Num5, "from the front", |a, _| Standard::Front.show(&mut a.choices.view.camera)),
        on(NONE, Key::Num6, "from the side", |a, _| Standard::Right.show(&mut a.choices.view.camera)),
        on(NONE, Key::Num7, "from above", |a, _| Standard::Top.show(&mut a.choices.view.camera)),
        on(NONE, Key::S, "screenshot beside the mesh", |_, s| s.actions.push(Action::Screenshot)),
        on(NONE, Key::Tab, "panel", |_, s| s.panel_hidden = !s.panel_hidden),
        on(NONE, Key::F1, "this list", |_, s| s.help = !s.help),
        on(NONE, Key::Escape, "close this list, stop what is going on", |a, s| {
            if s.help {
                s.help = false;
            } else if s.dialog.is_none() && a.has_brush() {
                a.switch_brush();
            } else if s.dialog.take().is_none() {
                [Work::Load, Work::Bake, Work::Draw, Work::Prepare, Work::BakeAll]
                    .into_iter()
                    .for_each(|work| a.cancel(work));
            }
        }),
    ]
}

/// Does what was typed, unless it was typed into a field.
pub(super) fn take(context: &egui::Context, app: &mut App, ui_state: &mut UiState) {
    if context.text_edit_focused() {
        return;
    }
    if context.input(|i| i.events.iter().any(|e| matches!(e, egui::Event::Text(text) if text == "?"))) {
        ui_state.help = !ui_state.help;
    }
    // Moving the focus with arrows is for those who use no mouse, and a focused widget needs the arrows and the space bar.
    let focused = context.memory(|m| m.focused().is_some());
    for binding in bindings() {
        let for_widget = matches!(binding.key, Key::ArrowUp | Key::ArrowDown | Key::Space);
        if focused && for_widget && binding.modifiers == NONE {
            continue;
        }
        if context.input_mut(|i| i.consume_key(binding.modifiers, binding.key)) {
            (binding.effect)(app, ui_state);
        }
    }
}

/// List of what the mouse does.
const MOUSE: [(&str, &str); 7] = [
    ("drag", "turn"),
    ("right or middle drag, Shift drag", "move"),
    ("wheel", "zoom to the pointer"),
    ("double click", "fit the model"),
    ("L drag", "move the chosen light"),
    ("drag on the model, while painting", "paint; Ctrl does the opposite"),
    ("drop a file", "open it"),
];

/// The list of keys.
pub(super) fn help(context: &egui::Context, ui_state: &mut UiState) {
    let mut shown = ui_state.help;
    let window = egui::Window::new("Keys and mouse").open(&mut shown).collapsible(false).resizable(false);
    let keys = bindings().map(|Binding { modifiers, key, words, .. }| {
        (context.format_shortcut(&egui::KeyboardShortcut::new(modifiers, key)), words)
    });
    let mouse = MOUSE.map(|(what, words)| (what.to_owned(), words));
    let all: Vec<(String, &str)> = mouse.into_iter().chain(keys).collect();
    window.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).show(context, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.horizontal_top(|ui| {
                for (i, part) in all.chunks(all.len().div_ceil(2)).enumerate() {
                    egui::Grid::new(("keys", i)).num_columns(2).spacing([14.0, 3.0]).show(ui, |ui| {
                        for (what, words) in part {
                            ui.strong(what);
                            ui.label(*words);
                            ui.end_row();
                        }
                    });
                    ui.add_space(18.0);
                }
            });
        });
    });
    ui_state.help = shown;
}

impl UiState {
    /// Compares this way, or no more.
    pub(super) fn compare(&mut self, how: Comparing) {
        self.comparing = if self.comparing == how { Comparing::Off } else { how };
    }

    /// Asks for a file.
    pub(super) fn ask(&mut self, purpose: FilePurpose) {
        self.dialog = Some(Dialog::open(purpose));
    }
}
