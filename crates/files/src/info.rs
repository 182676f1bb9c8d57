//! What is in a mesh file and what is wrong with it.

use crate::failure::Failure;
use crate::input;
use crate::text::count;
use planish_geometry::map::layout_issues::Findings;
use planish_geometry::map::map_size::{self, Spacing};
use planish_geometry::map::{Coverage, Size};
use planish_geometry::mesh::atlas::{AtlasError, Charts};
use planish_geometry::progress::Progress;
use planish_geometry::source::materials;
use planish_geometry::source::model::{Defects, Model};
use planish_geometry::source::obj::Obj;
use serde::Serialize;
use std::path::Path;

/// Side of the map in which overlaps are looked for, texels.
const PROBE: u32 = 1024;

/// What a mesh file holds.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// As given.
    pub file: String,
    /// Of the file.
    pub bytes: usize,
    /// `v` lines.
    pub vertex_lines: usize,
    /// `vt` lines.
    pub uv_lines: usize,
    /// `vn` lines.
    pub normal_lines: usize,
    /// `f` statements.
    pub faces: usize,
    /// Of the surface.
    pub triangles: usize,
    /// Faces with more than three corners.
    pub polygons: usize,
    /// `o` statements.
    pub objects: usize,
    /// `g` statements.
    pub groups: usize,
    /// `s` statements.
    pub smoothing_groups: usize,
    /// `l` statements.
    pub lines: usize,
    /// `p` statements.
    pub points: usize,
    /// `v` lines with more than three numbers.
    pub vertices_with_colour_or_w: usize,
    /// What is kept and not understood.
    pub other_statements: usize,
    /// After welding.
    pub vertices: usize,
    /// Of the surface.
    pub edges: usize,
    /// Connected pieces.
    pub components: usize,
    /// Whether each edge has two faces.
    pub closed: bool,
    /// Model units.
    pub area: f64,
    /// Of a closed surface, model units.
    pub volume: Option<f64>,
    /// Mean length of the edges, model units.
    pub mean_edge: f64,
    /// Lowest and highest coordinates.
    pub bounds: [[f64; 3]; 2],
    /// What is odd, counted.
    pub defects: Defects,
    /// None without texture coordinates.
    pub layout: Option<Layout>,
    /// In the order of their first use.
    pub materials: Vec<Material>,
    /// What is wrong, in words.
    pub notes: Vec<String>,
}

/// Its texture coordinates.
#[derive(Clone, Debug, Serialize)]
pub struct Layout {
    /// Counts of charts and seams.
    #[serde(flatten)]
    pub charts: Charts,
    /// Size of the map that the following numbers are about.
    pub probe: u32,
    /// What the layout makes hard for a map of that size.
    #[serde(flatten)]
    pub findings: Findings,
    /// Smallest side of a map that gives each vertex its height.
    pub size: u32,
    /// Why that one.
    pub size_reason: String,
}

/// A material that faces name.
#[derive(Clone, Debug, Serialize)]
pub struct Material {
    /// As in the file.
    pub name: String,
    /// Where it is defined.
    pub library: Option<String>,
    /// As the library names it.
    pub diffuse_texture: Option<String>,
    /// Whether that file is there.
    pub texture_found: Option<bool>,
}

/// Looks at a mesh that was read from `path`; its materials are looked for there.
pub fn look(path: &Path, model: &Model, progress: &dyn Progress) -> Result<Info, Failure> {
    let (data, surface) = (model.data(), model.surface());
    let obj = model.source().as_obj();
    let topology = surface.topology();
    let defects = model.defects();
    let mut notes = notes(model, &defects);
    let layout = match model.atlas() {
        Ok(atlas) => {
            let spacing = Spacing::new(&atlas);
            let choice = spacing.choose(&map_size::sides(map_size::LARGEST_SIDE));
            let coverage = Coverage::new(surface, &atlas, Size::square(PROBE), progress)?;
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
    let broken = obj.map_or(&[][..], Obj::non_finite_uvs);
    if let Some(&(_, line)) = broken.first() {
        let n = count(broken.len(), "`vt` line is", "`vt` lines are");
        notes.push(format!("{n} not finite, the first in line {line}: `bake` cannot use them"));
    }
    let materials = find_materials(path, model, &mut notes);
    let closed = defects.boundary_edges == 0 && defects.non_manifold_edges == 0;
    let extras = obj.map(|obj| obj.extras().clone()).unwrap_or_default();
    Ok(Info {
        file: path.display().to_string(),
        bytes: model.source().bytes().len(),
        vertex_lines: data.positions().len(),
        uv_lines: data.uvs().len(),
        normal_lines: data.normals().len(),
        faces: data.faces().len(),
        triangles: surface.triangle_corners().len(),
        polygons: data.faces().iter().filter(|f| f.len() > 3).count(),
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
    for library in input::libraries(path, model.source()) {
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
    let used = model.data().materials().iter().map(|name| String::from_utf8_lossy(name).into_owned());
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
