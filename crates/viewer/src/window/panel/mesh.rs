//! Section on the mesh: how it is welded, its size and its defects, as `planish info` prints them.

use super::super::ui_state::UiState;
use super::choose;
use crate::app::App;
use egui::Ui;
use planish_files::text::{count, measure};
use planish_geometry::mesh::weld::Welding;

pub(super) fn show(ui: &mut Ui, app: &mut App, ui_state: &mut UiState) {
    let Some(document) = app.document().cloned() else {
        ui.weak("nothing is open");
        return;
    };
    let info = &document.info;
    welding(ui, &mut app.choices.bake_config.settings.welding, info.mean_edge, ui_state);
    let mut line = |text: String| drop(ui.label(text));
    line(info.file.clone());
    line(format!("{} v, {} vt, {} vn, {} f", info.vertex_lines, info.uv_lines, info.normal_lines, info.faces));
    let pieces = count(info.components, "piece", "pieces");
    let closed = if info.closed { "closed" } else { "open" };
    line(format!("{} vertices, {} edges, {pieces}, {closed}", info.vertices, info.edges));
    let volume = info.volume.map(|v| format!(", volume {}", measure(v))).unwrap_or_default();
    line(format!("mean edge {}, area {}{volume}", measure(info.mean_edge), measure(info.area)));
    if let Some(layout) = &info.layout {
        let charts = &layout.charts;
        line(format!(
            "{}, {} and {} on seams",
            count(charts.charts, "chart", "charts"),
            count(charts.seam_edges, "edge", "edges"),
            count(charts.seam_vertices, "vertex", "vertices")
        ));
    }
    for note in &info.notes {
        ui.colored_label(ui.visuals().warn_fg_color, format!("⚠ {note}"));
    }
}

/// Rule by which vertices become one. Another rule reads the mesh again.
fn welding(ui: &mut Ui, welding: &mut Welding, mean_edge: f64, ui_state: &mut UiState) {
    // A gap that nobody sees, where the rule had no distance yet.
    let distance = if let Welding::Epsilon(distance) = welding { *distance } else { 1e-3 * mean_edge };
    let rules = [
        ("vertices at equal positions", Welding::Exact),
        ("vertices within a distance", Welding::Epsilon(distance)),
        ("no vertices", Welding::None),
    ];
    let list = choose(ui, "welded", welding, rules.map(|(words, rule)| (words.to_owned(), rule)));
    ui_state.mark("welded", list.rect);
    list.on_hover_text("which vertices of the file are one vertex of the surface: noise tears what is not welded");
    if let Welding::Epsilon(distance) = welding {
        ui.horizontal(|ui| {
            let field = egui::DragValue::new(distance).speed(1e-4 * mean_edge).max_decimals(9);
            let field = ui.add(field.range(f64::MIN_POSITIVE..=f64::MAX));
            let label = ui.label("distance, model units");
            field.labelled_by(label.id);
        });
    }
}
