//! Section on view and light. Nothing here changes what is baked.

use super::super::dialog::FilePurpose;
use super::super::orbit::{self, Standard};
use super::super::ui_state::UiState;
use super::{choose, name, volume};
use crate::app::App;
use egui::Ui;
use planish_render::colour::Colour;
use planish_render::settings::camera::{Projection, UpAxis};
use planish_render::settings::environment::{Part, Scene, Source};
use planish_render::settings::ground::Show;
use planish_render::settings::lights::{Anchor, Light, LightKind, MAX_LIGHTS};
use planish_render::settings::shadow::Filter;
use planish_render::settings::{Normals, Overlay, Sampling, Settings, Shading};

/// Shading of the surface, which is always shown.
pub(super) fn shading(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    // Numbers of the vertices are shown by the buttons that say which; solid colours need a volume.
    let (shown, has_volume) = (app.choices.view.shading, app.choices.view.volume.is_some());
    let is_offered = |s: &&Shading| match s {
        Shading::Heat => shown == Shading::Heat,
        Shading::Solid => has_volume,
        _ => true,
    };
    let all = Shading::ALL.iter().filter(is_offered);
    let list = choose(ui, "shading", &mut app.choices.view.shading, all.map(|s| (name(s), *s)));
    ui_state.mark("shading", list.rect);
}

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let is_occluded = app.map().is_some_and(|map| map.scene.occlusion.is_some());
    let view = &mut app.choices.view;
    choose(ui, "overlay", &mut view.overlay, Overlay::ALL.iter().map(|o| (name(o), *o)));
    choose(ui, "normals", &mut view.displace.normals, Normals::ALL.iter().map(|n| (name(n), *n)));
    choose(ui, "sampling", &mut view.sampling, Sampling::ALL.iter().map(|s| (name(s), *s)));
    camera(ui, view);
    lights(ui, view, ui_state);
    if is_occluded {
        let slider = ui.add(egui::Slider::new(&mut view.ambient.occlusion, 0.0..=1.0).text("occlusion"));
        slider.on_hover_text("how much the map of ambient occlusion takes off the ambient light");
    }
    shadows(ui, view);
    material(ui, view);
    surroundings(ui, view, ui_state);
    volume::show(ui, view, ui_state);
    if ui.button("Reset").clicked() {
        let Settings { size, camera, displace, .. } = *view;
        *view = Settings { size, camera, displace, ..Settings::default() };
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
            orbit::fit(camera);
        }
    });
    ui.horizontal(|ui| {
        let mut parallel = camera.projection == Projection::Orthographic;
        if ui.checkbox(&mut parallel, "parallel rays").changed() {
            orbit::switch_projection(camera);
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

fn lights(ui: &mut Ui, view: &mut Settings, ui_state: &mut UiState) {
    ui_state.light = ui_state.light.min(view.lights.len().saturating_sub(1));
    ui.horizontal(|ui| {
        ui.label("lights").on_hover_text("hold L and drag in the view to move the chosen one");
        for i in 0..view.lights.len() {
            ui.selectable_value(&mut ui_state.light, i, format!("{}", i + 1));
        }
        if ui.add_enabled(view.lights.len() < MAX_LIGHTS, egui::Button::new("+").small()).clicked() {
            let new = view.lights.last().copied().or_else(|| Settings::default().lights.first().copied());
            view.lights.extend(new.map(|light| Light { azimuth: -light.azimuth, ..light }));
            ui_state.light = view.lights.len() - 1;
        }
        if ui.add_enabled(!view.lights.is_empty(), egui::Button::new("−").small()).clicked() {
            view.lights.remove(ui_state.light);
        }
    });
    if let Some(light) = view.lights.get_mut(ui_state.light) {
        ui.add(egui::Slider::new(&mut light.azimuth, -180.0..=180.0).text("azimuth").suffix("°"));
        ui.add(egui::Slider::new(&mut light.elevation, -90.0..=90.0).text("elevation").suffix("°"));
        ui.add(egui::Slider::new(&mut light.intensity, 0.0..=3.0).text("intensity"));
        ui.horizontal(|ui| {
            colour(ui, &mut light.colour);
            let anchors = [("camera", Anchor::Camera), ("model", Anchor::Model), ("sun", Anchor::Sun)];
            choose(ui, "attached to", &mut light.anchor, anchors.map(|(words, anchor)| (words.to_owned(), anchor)));
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
    ui.add(egui::Slider::new(&mut view.ambient.intensity, 0.0..=1.0).text("ambient"));
}

fn shadows(ui: &mut Ui, view: &mut Settings) {
    let shadow = &mut view.shadow;
    choose(ui, "shadows", &mut shadow.filter, Filter::ALL.iter().map(|f| (name(f), *f)));
    if shadow.filter == Filter::Pcss {
        ui.add(egui::Slider::new(&mut shadow.light_angle, 0.5..=30.0).text("softness").suffix("°"));
    }
    choose(ui, "ground", &mut view.ground.show, Show::ALL.iter().map(|s| (name(s), *s)));
}

/// The environment, which comes from this program or from a file.
fn surroundings(ui: &mut Ui, view: &mut Settings, ui_state: &mut UiState) {
    let mut source = view.environment.as_ref().map(|s| s.source.clone());
    let scenes = [("none", None), ("desert", Some(Scene::Desert)), ("ice", Some(Scene::Ice))];
    let mut all: Vec<(String, Option<Source>)> =
        scenes.into_iter().map(|(words, scene)| (words.to_owned(), scene.map(Source::Scene))).collect();
    if let Some(Source::Equirect(path) | Source::Cube(path)) = &source {
        all.push((path.file_name().unwrap_or_default().to_string_lossy().into_owned(), source.clone()));
    }
    ui.horizontal(|ui| {
        choose(ui, "environment", &mut source, all);
        if ui.small_button("…").on_hover_text("a picture twice as wide as high, or a folder with six faces").clicked()
        {
            ui_state.ask(FilePurpose::Environment);
        }
    });
    match source {
        None => view.environment = None,
        Some(source) => view.environment.get_or_insert_default().source = source,
    }
    let Some(around) = &mut view.environment else { return };
    ui.add(egui::Slider::new(&mut around.rotation, -180.0..=180.0).text("rotation").suffix("°"));
    ui.add(egui::Slider::new(&mut around.intensity, 0.0..=4.0).text("brightness"));
    ui.add(egui::Slider::new(&mut around.blur, 0.0..=1.0).text("blur"));
    ui.add(egui::Slider::new(&mut around.reflectance, 0.0..=1.0).text("reflectance"));
    ui.add(egui::Slider::new(&mut around.roughness, 0.0..=1.0).text("roughness"));
    choose(ui, "behind the model", &mut around.background, Part::ALL.iter().map(|p| (name(p), *p)));
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

fn colour(ui: &mut Ui, colour: &mut Colour) {
    ui.color_edit_button_srgb(&mut colour.0);
}
