//! What a bake tells about its result, in words.
//!
//! ```
//! use planish_files::{bake_files, bake_report};
//! use planish_geometry::bake::BakeSettings;
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let settings = BakeSettings { target: Denoiser::named("laplacian").unwrap().into(), ..BakeSettings::default() };
//! let baked = bake_files::bake_arrays(&model, "tent", &settings, &Silent)?;
//! let report = bake_report::text("tent.obj", &baked.bundle, &["out/tent.planish.json".to_owned()]);
//! assert!(report.starts_with("source    tent.obj: 5 vertices, 4 faces\n"), "{report}");
//! assert!(report.contains("\nerror     max "), "{report}");
//! assert!(report.ends_with("\nwrote     out/tent.planish.json\n"), "{report}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::text::{self, count, measure, one_line};
use planish_geometry::bake::Bundle;
use planish_geometry::map::displacement::MapKind;
use planish_geometry::map::manifest::{Layout, Manifest, PageEntry, ShadingMapEntry, UvSource};
use std::fmt::Write as _;

/// Report of a bake for people, of the mesh at `source`. `files` are the paths of the files that were written.
pub fn text(source: &str, bundle: &Bundle, files: &[String]) -> String {
    let m = &bundle.manifest;
    let (map, r) = (&m.displacement, &m.report);
    let mut out = String::new();
    let mut line = |head: &str, text: String| {
        let _ = writeln!(out, "{head:9} {text}");
    };
    line(
        "source",
        format!(
            "{}: {}, {}",
            one_line(source),
            count(m.source.vertices, "vertex", "vertices"),
            count(m.source.faces, "face", "faces")
        ),
    );
    if let Some(choice) = &m.choice {
        line("auto", choice.to_string());
    }
    line(
        "map",
        format!(
            "{}, {}: {} = {} + {} · texel",
            sizes(m),
            map.texel,
            if map.map == MapKind::Scalar { "height" } else { "offset" },
            measure(map.bias),
            measure(map.scale)
        ),
    );
    if let Some(choice) = bundle.choice {
        line("size", choice.to_string());
    }
    if let Some(limits) = &r.limits {
        line("limits", text::limits(limits));
    }
    if let Some(heights) = &r.heights {
        line("normals", format!("{}; {heights}", text::along(m.normals)));
    }
    line("error", text::errors(r, map.scale));
    for (head, text) in layout_text(m) {
        line(head, text);
    }
    if let Some(occlusion) = &m.occlusion {
        let reach = occlusion.distance.map_or("any length".to_owned(), |d| format!("at most {}", measure(d)));
        line(
            "occlusion",
            format!("{}, {} of {reach}", shading(&occlusion.map), count(occlusion.rays as usize, "ray", "rays")),
        );
    }
    if let Some(curvature) = &m.curvature {
        line("curvature", format!("{}, white is {} per model unit", shading(&curvature.map), measure(curvature.range)));
    }
    for file in files {
        line("wrote", one_line(file));
    }
    out
}

/// Describes the size of the map, or those of its pages.
fn sizes(m: &Manifest) -> String {
    let size = |width, height| format!("{width} × {height}");
    let of_page = |page: &PageEntry| format!("page {} {}", page.part, size(page.width, page.height));
    match m.page_entries() {
        [] => size(m.displacement.width, m.displacement.height),
        pages => one_line(&pages.iter().map(of_page).collect::<Vec<_>>().join(", ")),
    }
}

/// Describes the layout of a map of shading.
fn shading(map: &ShadingMapEntry) -> String {
    let layout = match map.layout {
        Layout::Uv => "in the texture coordinates",
        Layout::Vertex => "one texel for each vertex",
    };
    format!("{} × {}, {layout}", map.width, map.height)
}

/// Formats the lines about seams and layout.
fn layout_text(m: &Manifest) -> [(&'static str, String); 2] {
    let r = &m.report;
    let gap = format!("gap {} between the wedges of a vertex", r.seam_gap);
    let Some(own) = &r.own_uvs else {
        return [("seams", gap), ("layout", "one texel for each vertex".to_owned())];
    };
    let n = count(own.seam_vertices, "vertex", "vertices");
    let private = match r.private_vertices {
        0 => String::new(),
        n => format!(", {} with private texels", count(n, "vertex", "vertices")),
    };
    let layout = format!(
        "{}, {:.1} % covered{private}, {} unresolved",
        if m.displacement.uvs == UvSource::Mesh { "the mesh's own" } else { "a new atlas, in the carrier" },
        100.0 * r.layout.coverage,
        count(r.unresolved_vertices, "vertex", "vertices")
    );
    [("seams", format!("{gap}, {n} with several")), ("layout", layout)]
}
