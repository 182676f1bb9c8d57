//! The command `planish info`.

use super::{count, measure, one_line};
use crate::args::InfoArgs;
use crate::console::Console;
use crate::failure::Failure;
use planish_files::info::{self, Info, Layout, Material};
use planish_geometry::progress::Progress as _;
use std::fmt::Write as _;

pub(crate) fn run(args: &InfoArgs, console: &Console) -> Result<(), Failure> {
    let model = super::model(&args.input, args.welding.weld, args.trust.rule(), console)?;
    console.stage("looking");
    let info = info::inspect(&args.input, &model, args.trust.rule(), console)?;
    console.report(&info, || text(&info))
}

/// Formats the report for people.
fn text(info: &Info) -> String {
    let mut out = String::new();
    let mut line = |head: &str, text: String| {
        let _ = writeln!(out, "{head:10} {text}");
    };
    line("file", format!("{} ({} bytes)", one_line(&info.file), info.bytes));
    line(
        "contains",
        format!(
            "{} v, {} vt, {} vn, {} f ({} with more than three corners)",
            info.vertex_lines, info.uv_lines, info.normal_lines, info.faces, info.polygons
        ),
    );
    if !info.contents.is_empty() {
        line("also", info.contents.join(", "));
    }
    if info.vertices_with_colour_or_w > 0 {
        line("", format!("{} with colours or w", count(info.vertices_with_colour_or_w, "vertex", "vertices")));
    }
    let pieces = count(info.components, "piece", "pieces");
    let closed = if info.closed { "closed" } else { "open" };
    line(
        "surface",
        format!("{} vertices, {} edges, {} triangles, {pieces}, {closed}", info.vertices, info.edges, info.triangles),
    );
    let volume = info.volume.map(|v| format!(", volume {}", measure(v))).unwrap_or_default();
    line("size", format!("mean edge {}, area {}{volume}", measure(info.mean_edge), measure(info.area)));
    let [low, high] = info.bounds.map(|p| p.map(|x| x + 0.0));
    line("", format!("from ({}, {}, {}) to ({}, {}, {})", low[0], low[1], low[2], high[0], high[1], high[2]));
    for (head, text) in info.layout.iter().flat_map(layout_text) {
        line(head, text);
    }
    for m in &info.materials {
        line("material", material_text(m));
    }
    for note in &info.notes {
        line("note", note.clone());
    }
    out
}

/// Formats the lines about the UV layout.
fn layout_text(l: &Layout) -> Vec<(&'static str, String)> {
    let c = &l.charts;
    let charts = format!(
        "{}, {} along seams, {} on seams",
        count(c.charts, "chart", "charts"),
        count(c.seam_edges, "edge", "edges"),
        count(c.seam_vertices, "vertex", "vertices")
    );
    let mut lines = vec![("layout", charts)];
    if l.findings.mirrored_faces + c.unmapped_faces + l.findings.out_of_range_vertices > 0 {
        let defects = format!(
            "{} mirrored, {} without texture coordinates, {} outside [0, 1]",
            count(l.findings.mirrored_faces, "face", "faces"),
            count(c.unmapped_faces, "face", "faces"),
            count(l.findings.out_of_range_vertices, "vertex", "vertices")
        );
        lines.push(("", defects));
    }
    lines.push(("map size", l.size_reason.clone()));
    lines
}

/// Formats a material with its library and its texture.
fn material_text(m: &Material) -> String {
    let texture = match (&m.diffuse_texture, m.texture_found) {
        (Some(t), Some(true)) => format!(" with {t}"),
        (Some(t), _) => format!(" with {t}, which is missing"),
        (None, _) => String::new(),
    };
    let library = m.library.as_ref().map_or(", which no library defines".to_owned(), |l| format!(" from {l}"));
    format!("{}{library}{texture}", m.name)
}
