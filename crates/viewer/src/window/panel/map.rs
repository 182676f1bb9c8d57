//! Section on the map: its settings, its accuracy and its picture.

use super::super::ui_state::UiState;
use super::choose;
use crate::app::App;
use crate::app::bake_config;
use crate::app::document::{self, Map};
use egui::{Color32, ColorImage, Rect, Sense, Ui, Vec2, pos2};
use planish_files::text;
use planish_geometry::bake::{BakeSettings, Carriers, CurvatureMap, LargestSide, LayoutChoice};
use planish_geometry::map::displacement::{Displacement, TexelFormat};
use planish_geometry::map::pages::PageRule;
use std::sync::Arc;

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    if let Some(map) = app.map().cloned() {
        facts(ui, &map);
        picture(ui, &map, ui_state);
        range(ui, &map, app);
    }
    ui.collapsing("What is baked", |ui| settings(ui, &mut app.choices.bake_config.settings));
}

fn facts(ui: &mut Ui, map: &Map) {
    ui.label(document::map_line(&map.manifest));
    for reason in &map.reasons {
        ui.label(reason);
    }
    let report = &map.manifest.report;
    ui.label(format!("error {}", text::errors(report, map.manifest.displacement.scale)));
    ui.label(format!("gap {} at seams", report.seam_gap));
    for warning in &map.warnings {
        ui.colored_label(ui.visuals().warn_fg_color, format!("⚠ {warning}"));
    }
}

/// Bias and scale as the shader has them, instead of those of the map.
fn range(ui: &mut Ui, map: &Map, app: &mut App) {
    let displace = &mut app.choices.view.displace;
    let Some(encoding) = map.displacement().map(Displacement::encoding) else { return };
    for (label, own, value) in
        [("bias", encoding.bias, &mut displace.bias), ("scale", encoding.scale, &mut displace.scale)]
    {
        ui.horizontal(|ui| {
            let mut number = value.unwrap_or(own);
            let speed = (encoding.scale / 200.0).max(f32::MIN_POSITIVE);
            let field = ui.add(egui::DragValue::new(&mut number).speed(speed).max_decimals(7));
            if field.changed() && number.is_finite() {
                *value = Some(number);
            }
            let label = ui.label(label);
            field.labelled_by(label.id);
            if value.is_some() && ui.small_button("⟲").on_hover_text("that of the map").clicked() {
                *value = None;
            }
        });
    }
}

/// The map, with wheel and drag to look closer, and the texel under the pointer in words.
fn picture(ui: &mut Ui, map: &Arc<Map>, ui_state: &mut UiState) {
    let of = Arc::as_ptr(map) as usize;
    let view = &mut ui_state.map;
    let texture = match &mut view.texture {
        Some((shown, texture)) if *shown == of => texture,
        slot => {
            let (width, height) = map.picture.dimensions();
            // Every texel is opaque, so that nothing has to be multiplied.
            let image = ColorImage::from_rgba_premultiplied([width as usize, height as usize], &map.picture);
            let texture = ui.ctx().load_texture("map", image, egui::TextureOptions::NEAREST);
            &mut slot.insert((of, texture)).1
        }
    };
    let side = ui.available_width().min(320.0);
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), Sense::click_and_drag());
    let seen = Rect::from_center_size(view.middle, Vec2::splat(view.share));
    let unit_at = |p: egui::Pos2| seen.min + (p - rect.min) / rect.size() * seen.size();
    ui.painter_at(rect).image(texture.id(), rect, seen, Color32::WHITE);
    if let Some(pointer) = response.hover_pos() {
        let scroll = ui.input_mut(|i| std::mem::take(&mut i.smooth_scroll_delta).y);
        if scroll != 0.0 {
            let under = unit_at(pointer);
            view.share = (view.share * (-0.004 * scroll).exp()).clamp(1.0 / 256.0, 1.0);
            let from_middle = (pointer - rect.center()) / rect.size();
            view.middle = under - from_middle * view.share;
        }
        let at = unit_at(pointer);
        if let Some(words) = texel(map, [at.x, at.y]) {
            response.clone().on_hover_text_at_pointer(words);
        }
    }
    view.middle -= response.drag_delta() / rect.size() * view.share;
    if response.double_clicked() {
        (view.share, view.middle) = (1.0, pos2(0.5, 0.5));
    }
    let half = 0.5 * view.share;
    view.middle = view.middle.clamp(pos2(half, half), pos2(1.0 - half, 1.0 - half));
    ui_state.mark("map", rect);
}

/// The texel at a place of the unit square, down from the upper left corner.
fn texel(map: &Map, [x, y]: [f32; 2]) -> Option<String> {
    let displacement = map.displacement()?;
    let size = displacement.size();
    let index = |unit: f32, n: u32| (unit.max(0.0) * n as f32).min(n as f32 - 1.0) as u32;
    let (column, row) = (index(x, size.width), index(y, size.height));
    let encoding = displacement.encoding();
    let heights = displacement.planes().iter().map(|plane| {
        let texel = plane[row as usize * size.width as usize + column as usize];
        format!("{} = {}", texel, text::measure(f64::from(encoding.bias + encoding.scale * texel)))
    });
    let heights = heights.collect::<Vec<_>>().join("\n");
    Some(format!("texel ({column}, {row})\n{heights} model units"))
}

fn settings(ui: &mut Ui, settings: &mut BakeSettings) {
    choose(ui, "map", &mut settings.map, bake_config::maps());
    choose(ui, "layout", &mut settings.layout, bake_config::layouts());
    if matches!(settings.layout, LayoutChoice::Vertex | LayoutChoice::Unwrap) {
        settings.pages = PageRule::None;
    } else {
        choose(ui, "pages", &mut settings.pages, bake_config::choices());
    }
    if settings.layout == LayoutChoice::Vertex {
        // Its size follows from the number of vertices.
        settings.side = None;
    } else {
        let sides = (6..=13).map(|power| Some(1 << power));
        let words = |side: Option<u32>| side.map_or_else(|| "auto".to_owned(), |side| side.to_string());
        let given = settings.side.filter(|side| !(64..=8192).contains(side) || !side.is_power_of_two());
        let all = std::iter::once(None).chain(sides).chain(given.map(Some)).map(|side| (words(side), side));
        choose(ui, "size", &mut settings.side, all);
        if settings.side.is_none() {
            let default = LargestSide::default();
            let sides = (6..=13).map(|power| LargestSide(1 << power)).filter(|side| side.0 < default.0);
            let given =
                Some(settings.largest_side).filter(|side| *side != default && !sides.clone().any(|s| s == *side));
            let all = sides.chain(given).chain([default]).map(|side| (side.0.to_string(), side));
            choose(ui, "size at most", &mut settings.largest_side, all);
        }
    }
    choose(ui, "texels", &mut settings.texel, TexelFormat::ALL.map(|texel| (bake_config::texel_words(texel), texel)));
    choose(ui, "at vertices", &mut settings.texels, bake_config::choices());
    choose(ui, "between vertices", &mut settings.interpolation, bake_config::choices());
    choose(ui, "normals", &mut settings.normals, bake_config::normals());
    choose(ui, "normal map", &mut settings.convention, bake_config::choices());
    ui.add(egui::Slider::new(&mut settings.tolerance.0, 0.625..=10.0).text("tolerance, quanta"))
        .on_hover_text("how far off a vertex may be for the layout auto to use the mesh's own UVs");
    ui.add(egui::Slider::new(&mut settings.lambda.0, 0.0..=1.5).text("λ of the files"))
        .on_hover_text("for the normal map and the settings of other programs");
    let mut occlusion = settings.occlusion.is_some();
    ui.checkbox(&mut occlusion, "ambient occlusion").on_hover_text(
        "a picture of how much of the light from all around reaches each place of the denoised surface; takes a while",
    );
    settings.occlusion = occlusion.then(|| settings.occlusion.unwrap_or_default());
    let mut curvature = settings.curvature == CurvatureMap::Mean;
    ui.checkbox(&mut curvature, "curvature").on_hover_text("a picture of bulges, bright, and cavities, dark");
    settings.curvature = if curvature { CurvatureMap::Mean } else { CurvatureMap::None };
    let mut glb = settings.carriers == Carriers::ObjAndGlb;
    ui.checkbox(&mut glb, "glTF as well");
    settings.carriers = if glb { Carriers::ObjAndGlb } else { Carriers::Obj };
}
