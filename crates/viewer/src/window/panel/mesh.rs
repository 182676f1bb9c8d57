//! Section on the mesh: its size and its defects, as `planish info` prints them.

use crate::app::App;
use egui::Ui;
use planish_files::text::{count, measure};

pub(super) fn show(ui: &mut Ui, app: &App) {
    let Some(document) = app.document() else {
        ui.weak("nothing is open");
        return;
    };
    let info = &document.info;
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
