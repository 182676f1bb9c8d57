//! How the model is drawn. Nothing here changes what is baked.

use super::super::controls::{self, Standard};
use super::super::session::Session;
use super::{choose, name};
use crate::app::App;
use crate::camera::{Projection, UpAxis};
use crate::colour::Colour;
use crate::lights::{Anchor, Light, LightKind, MAX_LIGHTS};
use crate::settings::{Normals, Overlay, Sampling, Settings, Shading};
use egui::Ui;

pub(super) fn show(ui: &mut Ui, app: &mut App, session: &mut Session) {
    let view = &mut app.choices.view;
    let shading = choose(ui, "shading", &mut view.shading, Shading::ALL.iter().map(|s| (name(s), *s)));
    session.mark("shading", shading.rect);
    choose(ui, "overlay", &mut view.overlay, Overlay::ALL.iter().map(|o| (name(o), *o)));
    choose(ui, "normals", &mut view.displace.normals, Normals::ALL.iter().map(|n| (name(n), *n)));
    choose(ui, "sampling", &mut view.sampling, Sampling::ALL.iter().map(|s| (name(s), *s)));
    camera(ui, view);
    lights(ui, view, session);
    material(ui, view);
    pictures(ui, session);
    if ui.button("Look as at first").clicked() {
        let Settings { camera, displace, size, .. } = *view;
        *view = Settings { camera, displace, size, ..Settings::default() };
    }
}

fn camera(ui: &mut Ui, view: &mut Settings) {
    let camera = &mut view.camera;
    ui.horizontal_wrapped(|ui| {
        for standard in Standard::ALL {
            if ui.small_button(format!("{standard:?}")).clicked() {
                standard.show(camera);
            }
        }
        if ui.small_button("Fit").clicked() {
            controls::fit(camera);
        }
    });
    ui.horizontal(|ui| {
        let mut parallel = camera.projection == Projection::Orthographic;
        if ui.checkbox(&mut parallel, "parallel rays").changed() {
            controls::switch_projection(camera);
        }
        ui.label("up");
        for (words, up) in [("y", UpAxis::Y), ("z", UpAxis::Z)] {
            ui.selectable_value(&mut camera.up, up, words);
        }
    });
    if let Projection::Perspective { field_of_view } = &mut camera.projection {
        ui.add(egui::Slider::new(field_of_view, 5.0..=100.0).text("field of view").suffix("°"));
    }
}

fn lights(ui: &mut Ui, view: &mut Settings, session: &mut Session) {
    session.light = session.light.min(view.lights.len().saturating_sub(1));
    ui.horizontal(|ui| {
        ui.label("lights").on_hover_text("hold L and drag in the view to move the chosen one");
        for i in 0..view.lights.len() {
            ui.selectable_value(&mut session.light, i, format!("{}", i + 1));
        }
        if ui.add_enabled(view.lights.len() < MAX_LIGHTS, egui::Button::new("+").small()).clicked() {
            let new = view.lights.last().copied().or_else(|| Settings::default().lights.first().copied());
            view.lights.extend(new.map(|light| Light { azimuth: -light.azimuth, ..light }));
            session.light = view.lights.len() - 1;
        }
        if ui.add_enabled(!view.lights.is_empty(), egui::Button::new("−").small()).clicked() {
            view.lights.remove(session.light);
        }
    });
    if let Some(light) = view.lights.get_mut(session.light) {
        ui.add(egui::Slider::new(&mut light.azimuth, -180.0..=180.0).text("azimuth").suffix("°"));
        ui.add(egui::Slider::new(&mut light.elevation, -90.0..=90.0).text("elevation").suffix("°"));
        ui.add(egui::Slider::new(&mut light.intensity, 0.0..=3.0).text("intensity"));
        ui.horizontal(|ui| {
            colour(ui, &mut light.colour);
            let mut with_model = light.anchor == Anchor::Model;
            ui.checkbox(&mut with_model, "stays with the model");
            light.anchor = if with_model { Anchor::Model } else { Anchor::Camera };
        });
        let kinds = [
            ("sun", LightKind::Directional),
            ("spot", LightKind::Spot { distance: 3.0, angle: 40.0 }),
            ("lamp", LightKind::Point { distance: 2.0 }),
        ];
        ui.horizontal(|ui| {
            for (words, kind) in kinds {
                let chosen = std::mem::discriminant(&light.kind) == std::mem::discriminant(&kind);
                if ui.selectable_label(chosen, words).clicked() && !chosen {
                    light.kind = kind;
                }
            }
        });
        if let LightKind::Spot { distance, .. } | LightKind::Point { distance } = &mut light.kind {
            ui.add(egui::Slider::new(distance, 0.5..=10.0).text("distance"));
        }
        if let LightKind::Spot { angle, .. } = &mut light.kind {
            ui.add(egui::Slider::new(angle, 5.0..=120.0).text("angle").suffix("°"));
        }
    }
    ui.add(egui::Slider::new(&mut view.ambient.intensity, 0.0..=1.0).text("light from everywhere"));
}

fn material(ui: &mut Ui, view: &mut Settings) {
    let material = &mut view.material;
    ui.horizontal(|ui| {
        colour(ui, &mut material.colour);
        ui.label("material");
        colour(ui, &mut view.background.top);
        colour(ui, &mut view.background.bottom);
        ui.label("background");
    });
    ui.add(egui::Slider::new(&mut material.specular, 0.0..=1.0).text("highlight"));
    ui.add(egui::Slider::new(&mut material.exponent, 1.0..=200.0).logarithmic(true).text("sharpness"));
}

fn pictures(ui: &mut Ui, session: &mut Session) {
    use super::super::session::Action;
    ui.horizontal(|ui| {
        let shot = ui.button("Screenshot").on_hover_text("beside the mesh");
        session.mark("screenshot", shot.rect);
        if shot.clicked() {
            session.actions.push(Action::Screenshot);
        }
        if ui.button("Turntable").on_hover_text("120 pictures once around, in a folder beside the mesh").clicked() {
            session.actions.push(Action::Turntable(120));
        }
    });
}

fn colour(ui: &mut Ui, colour: &mut Colour) {
    ui.color_edit_button_srgb(&mut colour.0);
}
