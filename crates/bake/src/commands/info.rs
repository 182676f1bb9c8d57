//! `planish info`

use super::{count, measure};
use crate::args::InfoArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;
use planish_geometry::atlas::{AtlasError, Charts};
use planish_geometry::materials;
use planish_geometry::model::{Defects, Model};
use planish_geometry::progress::Progress as _;
use planish_geometry::texture::findings::Findings;
use planish_geometry::texture::resolution::{self, Spacing};
use planish_geometry::texture::{Coverage, Size};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// Side of the map in which overlaps are looked for, texels.
const PROBE: u32 = 1024;

#[derive(Serialize)]
struct Info {
    file: String,
    bytes: usize,
    vertex_lines: usize,
    uv_lines: usize,
    normal_lines: usize,
    faces: usize,
    triangles: usize,
    polygons: usize,
    objects: usize,
    groups: usize,
    smoothing_groups: usize,
    lines: usize,
    points: usize,
    vertices_with_colour_or_w: usize,
    other_statements: usize,
    /// After welding.
    vertices: usize,
    edges: usize,
    components: usize,
    closed: bool,
    area: f64,
    volume: Option<f64>,
    mean_edge: f64,
    bounds: [[f64; 3]; 2],
    defects: Defects,
    layout: Option<Layout>,
    materials: Vec<Material>,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct Layout {
    #[serde(flatten)]
    charts: Charts,
    /// Size of the map that the following numbers are about.
    probe: u32,
    #[serde(flatten)]
    findings: Findings,
    size: u32,
    size_reason: String,
}

#[derive(Serialize)]
struct Material {
    name: String,
    library: Option<String>,
    diffuse_texture: Option<String>,
    texture_found: Option<bool>,
}

pub(crate) fn run(args: &InfoArgs, console: &Console) -> Result<(), Failure> {
    let model = super::model(&args.input, args.weld, console)?;
    console.stage("looking");
    let info = look(&args.input, &model, console)?;
    console.report(&info, || text(&info));
    Ok(())
}

fn look(path: &Path, model: &Model, console: &Console) -> Result<Info, Failure> {
    let (obj, surface) = (model.obj(), model.surface());
    let topology = surface.topology();
    let defects = model.defects();
    let mut notes = notes(model, &defects);
    let layout = match model.atlas() {
        Ok(atlas) => {
            let spacing = Spacing::new(&atlas);
            let choice = spacing.choose(&resolution::sides(resolution::LARGEST_SIDE));
            let coverage = Coverage::new(surface, &atlas, Size::square(PROBE), console)?;
            let findings = Findings::of(surface, &atlas, &spacing, &coverage);
            notes.extend(findings.problems());
            Some(Layout {
                charts: atlas.charts(surface),
                probe: PROBE,
                findings,
                size: choice.side,
                size_reason: choice.to_string(),
            })
        }
        Err(AtlasError::NoUvs) => {
            notes.push("no texture coordinates: `bake` gives each vertex a texel of its own".to_owned());
            None
        }
        Err(AtlasError::NonFinite { .. }) => None,
    };
    if let Some(&(_, line)) = obj.non_finite_uvs().first() {
        let n = count(obj.non_finite_uvs().len(), "`vt` line is", "`vt` lines are");
        notes.push(format!("{n} not finite, the first in line {line}: `bake` cannot use them"));
    }
    let materials = find_materials(path, model, &mut notes);
    let closed = defects.boundary_edges == 0 && defects.non_manifold_edges == 0;
    let extras = obj.extras();
    Ok(Info {
        file: path.display().to_string(),
        bytes: obj.bytes().len(),
        vertex_lines: obj.positions().len(),
        uv_lines: obj.uvs().len(),
        normal_lines: obj.normals().len(),
        faces: obj.faces().len(),
        triangles: surface.triangle_corners().len(),
        polygons: obj.faces().iter().filter(|f| f.len() > 3).count(),
        objects: extras.objects,
        groups: extras.groups,
        smoothing_groups: extras.smoothing_groups,
        lines: extras.lines,
        points: extras.points,
        vertices_with_colour_or_w: extras.extended_vertices,
        other_statements: extras.other,
        vertices: topology.vertex_count(),
        edges: topology.edges().len(),
        // Isolated vertices are reported as what they are, not as pieces of the surface.
        components: topology.components().1 - defects.isolated_vertices,
        closed,
        area: surface.area(),
        volume: closed.then(|| surface.volume()),
        mean_edge: surface.mean_edge(),
        bounds: surface.bounds().map(|p| p.to_array()),
        defects,
        layout,
        materials,
        notes,
    })
}

/// What is wrong, in words, with the first line at fault where there is one.
fn notes(model: &Model, d: &Defects) -> Vec<String> {
    let mut notes = Vec::new();
    let welded = model.weld().vertex_of().len() - model.weld().first().len();
    let mut note = |n: usize, one: &str, many: &str, what: String| {
        if n > 0 {
            notes.push(format!("{}{what}", count(n, one, many)));
        }
    };
    let first = |line: Option<u32>| line.map(|line| format!(", the first in line {line}")).unwrap_or_default();
    note(welded, "`v` line is", "`v` lines are", " welded to another one at the same place".to_owned());
    note(d.isolated_vertices, "vertex is", "vertices are", " used by no face".to_owned());
    note(d.boundary_edges, "edge has", "edges have", " one face only: the mesh is open there".to_owned());
    note(d.non_manifold_edges, "edge has", "edges have", " three faces or more".to_owned());
    note(d.non_manifold_vertices, "vertex joins", "vertices join", " sheets that are otherwise apart".to_owned());
    note(d.misoriented_edges, "edge lies", "edges lie", " between faces that look to different sides".to_owned());
    note(
        d.degenerate_faces,
        "face has",
        "faces have",
        format!(" fewer than three different vertices{}", first(d.first_degenerate_line)),
    );
    note(
        d.duplicate_faces,
        "face repeats",
        "faces repeat",
        format!(" an earlier one{}", first(d.first_duplicate_line)),
    );
    note(d.zero_area_faces, "face has", "faces have", " no area".to_owned());
    notes
}

fn find_materials(path: &Path, model: &Model, notes: &mut Vec<String>) -> Vec<Material> {
    let mut known = Vec::new();
    for library in input::libraries(path, model.obj()) {
        let shown = library.path.display().to_string();
        let Some(bytes) = library.bytes else {
            notes.push(format!("the material library {shown} cannot be read"));
            continue;
        };
        match materials::read(&bytes) {
            Ok(materials) => known.extend(materials.into_iter().map(|m| (m, library.path.clone()))),
            Err(e) => notes.push(format!("{shown}: {e}")),
        }
    }
    let used = model.obj().extras().materials.iter().map(|name| String::from_utf8_lossy(name).into_owned());
    let describe = |name: String| {
        let found = known.iter().find(|(m, _)| m.name == name);
        let texture = found.and_then(|(m, library)| {
            let texture = m.diffuse_texture.clone()?;
            let place = library.parent().unwrap_or(Path::new("")).join(texture.replace('\\', "/"));
            Some((texture, place.is_file()))
        });
        let library = found.map(|(_, library)| library.display().to_string());
        let (diffuse_texture, texture_found) = texture.unzip();
        Material { name, library, diffuse_texture, texture_found }
    };
    used.map(describe).collect()
}

fn text(info: &Info) -> String {
    let mut out = String::new();
    let mut line = |head: &str, text: String| {
        let _ = writeln!(out, "{head:10} {text}");
    };
    line("file", format!("{} ({} bytes)", info.file, info.bytes));
    line(
        "holds",
        format!(
            "{} v, {} vt, {} vn, {} f ({} with more than three corners)",
            info.vertex_lines, info.uv_lines, info.normal_lines, info.faces, info.polygons
        ),
    );
    let kept = [
        count(info.objects, "object", "objects"),
        count(info.groups, "group", "groups"),
        count(info.smoothing_groups, "smoothing group", "smoothing groups"),
        count(info.lines, "line", "lines"),
        count(info.points, "point element", "point elements"),
        count(info.other_statements, "other statement", "other statements"),
    ];
    let kept: Vec<_> = kept.into_iter().filter(|text| !text.starts_with("0 ")).collect();
    if !kept.is_empty() {
        line("besides", kept.join(", "));
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
    if let Some(l) = &info.layout {
        let c = &l.charts;
        line(
            "layout",
            format!(
                "{}, {} along seams, {} on seams",
                count(c.charts, "chart", "charts"),
                count(c.seam_edges, "edge", "edges"),
                count(c.seam_vertices, "vertex", "vertices")
            ),
        );
        if l.findings.mirrored_faces + c.unmapped_faces + l.findings.out_of_range_vertices > 0 {
            line(
                "",
                format!(
                    "{} mirrored, {} without texture coordinates, {} outside [0, 1]",
                    count(l.findings.mirrored_faces, "face", "faces"),
                    count(c.unmapped_faces, "face", "faces"),
                    count(l.findings.out_of_range_vertices, "vertex", "vertices")
                ),
            );
        }
        line("map size", l.size_reason.clone());
    }
    for m in &info.materials {
        let texture = match (&m.diffuse_texture, m.texture_found) {
            (Some(t), Some(true)) => format!(" with {t}"),
            (Some(t), _) => format!(" with {t}, which is missing"),
            (None, _) => String::new(),
        };
        let library = m.library.as_ref().map_or(", which no library holds".to_owned(), |l| format!(" from {l}"));
        line("material", format!("{}{library}{texture}", m.name));
    }
    for note in &info.notes {
        line("note", note.clone());
    }
    out
}
