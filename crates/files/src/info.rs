//! Inspection of a mesh file: its content and its defects.
//!
//! ```
//! use planish_files::info;
//! use planish_files::input::Trust;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//! use std::path::Path;
//!
//! // A tent without a floor, and with a vertex that no face uses.
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nv 9 9 9\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let info = info::inspect(Path::new("tent.obj"), &model, Trust::Folder, &Silent)?;
//! assert_eq!((info.vertices, info.edges, info.components, info.volume), (6, 8, 1, None));
//! assert_eq!(info.defects.boundary_edges, 4);
//! assert_eq!(info.notes[0], "1 vertex is used by no face");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::disk;
use crate::failure::Failure;
use crate::input::{self, Trust};
use crate::named_path::{self, NamedPath};
use crate::text::{self, count, shown};
use planish_geometry::map::layout_issues::LayoutIssues;
use planish_geometry::map::map_size::{self, Spacing};
use planish_geometry::map::{Coverage, Size};
use planish_geometry::mesh::atlas::{AtlasError, Charts};
use planish_geometry::progress::Progress;
use planish_geometry::source::flaws::flaws;
use planish_geometry::source::format::Format;
use planish_geometry::source::materials;
use planish_geometry::source::mesh_file::MeshFile;
use planish_geometry::source::model::{Defects, Model};
use planish_geometry::source::obj::Obj;
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Side of the map in which overlaps are searched for, in texels.
const PROBE: u32 = 1024;

/// Side of the map in which overlaps are searched for, in texels. The more layers of charts there are, the fewer texels show it.
fn probe(layers: f64) -> u32 {
    const PLENTY: f64 = 4.0;
    let side = f64::from(PROBE) / (layers / PLENTY).max(1.0).sqrt();
    (side as u32).max(16)
}

/// Content and defects of a mesh file.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// Path of the file as it was given.
    pub file: String,
    /// Format of the file.
    pub format: Format,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Number of source vertices: `v` lines of an OBJ.
    pub vertex_lines: usize,
    /// Number of texture coordinates: `vt` lines of an OBJ.
    pub uv_lines: usize,
    /// Number of normals: `vn` lines of an OBJ.
    pub normal_lines: usize,
    /// Number of faces: `f` statements of an OBJ.
    pub faces: usize,
    /// Number of triangles of the surface, after polygons are cut and useless faces dropped.
    pub triangles: usize,
    /// Number of faces with more than three corners.
    pub polygons: usize,
    /// Number of `o` statements.
    pub objects: usize,
    /// Number of `g` statements.
    pub groups: usize,
    /// Number of `s` statements.
    pub smoothing_groups: usize,
    /// Number of `l` statements.
    pub lines: usize,
    /// Number of `p` statements.
    pub points: usize,
    /// Number of `v` lines with more than three numbers.
    pub vertices_with_colour_or_w: usize,
    /// Number of statements that planish keeps and does not understand.
    pub other_statements: usize,
    /// Contents besides the mesh, which are kept, each with its count.
    pub contents: Vec<String>,
    /// Number of vertices after welding.
    pub vertices: usize,
    /// Number of edges of the surface.
    pub edges: usize,
    /// Number of connected components with at least one face.
    pub components: usize,
    /// Whether every edge has two faces.
    pub closed: bool,
    /// Area in square model units.
    pub area: f64,
    /// Enclosed volume in cubic model units; `None` if the surface is open.
    pub volume: Option<f64>,
    /// Mean edge length in model units.
    pub mean_edge: f64,
    /// Lowest and highest coordinates, in model units.
    pub bounds: [[f64; 3]; 2],
    /// Counts of defects, such as boundary edges and repeated faces.
    pub defects: Defects,
    /// UV layout; `None` without usable texture coordinates.
    pub layout: Option<Layout>,
    /// Materials that faces use, in the order of their first use.
    pub materials: Vec<Material>,
    /// Problems of the file, one sentence each.
    pub notes: Vec<String>,
}

/// UV layout of a mesh, and what it means for a map.
#[derive(Clone, Debug, Serialize)]
pub struct Layout {
    /// Counts of charts and seams.
    #[serde(flatten)]
    pub charts: Charts,
    /// Side in texels of the map that the findings are about.
    pub probe: u32,
    /// Problems of the layout for a map of that size.
    #[serde(flatten)]
    pub findings: LayoutIssues,
    /// Smallest side in texels of a map that gives each vertex its height.
    pub size: u32,
    /// Reason for that side.
    pub size_reason: String,
}

/// A material that faces use.
#[derive(Clone, Debug, Serialize)]
pub struct Material {
    /// Name of the material in the mesh file.
    pub name: String,
    /// Path of the library that defines it; `None` if no library does.
    pub library: Option<String>,
    /// File name of the diffuse texture as the library gives it.
    pub diffuse_texture: Option<String>,
    /// Whether the texture file exists; `None` without a texture.
    pub texture_found: Option<bool>,
}

/// Inspects a mesh that was read from `path`. Its material libraries are read from the same folder.
pub fn inspect(path: &Path, model: &Model, trust: Trust, progress: &dyn Progress) -> Result<Info, Failure> {
    let (data, surface) = (model.data(), model.surface());
    let obj = model.source().as_obj();
    let topology = surface.topology();
    let defects = model.defects();
    let mut notes = notes(model, &defects);
    notes.extend(model.source().file().map_or(&[][..], MeshFile::notes).iter().cloned());
    let layout = inspect_layout(model, progress, &mut notes)?;
    let materials = inspect_materials(path, model, trust, &mut notes);
    let closed = defects.boundary_edges == 0 && defects.non_manifold_edges == 0;
    let extras = obj.map(|obj| obj.extras().clone()).unwrap_or_default();
    Ok(Info {
        file: path.display().to_string(),
        format: model.source().format(),
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
        contents: model.source().file().map(MeshFile::contents).unwrap_or_default(),
        vertices: topology.vertex_count(),
        edges: topology.edges().len(),
        // An isolated vertex counts as a defect, not as a component.
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

/// Inspects the UV layout and adds its problems to `notes`. Returns `None` without usable texture coordinates.
fn inspect_layout(model: &Model, progress: &dyn Progress, notes: &mut Vec<String>) -> Result<Option<Layout>, Failure> {
    let surface = model.surface();
    let tile = model.tile();
    let layout = match model.atlas_in(tile) {
        Ok(atlas) => {
            let spacing = Spacing::new(&atlas);
            let choice = spacing.choose(&map_size::sides(map_size::LARGEST_SIDE));
            let probe = probe(Coverage::layers(surface, &atlas));
            let coverage = Coverage::new(surface, &atlas, Size::square(probe), progress)?;
            let findings = LayoutIssues::of(surface, &atlas, &spacing, &coverage);
            notes.extend(findings.problems());
            notes.extend(text::in_tile(tile));
            Some(Layout {
                charts: atlas.charts(surface),
                probe,
                findings,
                size: choice.side,
                size_reason: choice.to_string(),
            })
        }
        Err(AtlasError::NoUvs) => {
            notes.push("no texture coordinates: `bake` gives each vertex a texel of its own".to_owned());
            None
        }
        Err(_) => None,
    };
    let non_finite = model.source().as_obj().map_or(&[][..], Obj::non_finite_uvs);
    if let Some(&(_, line)) = non_finite.first() {
        let n = count(non_finite.len(), "`vt` line is", "`vt` lines are");
        notes.push(format!("{n} not finite, the first in line {line}: faces have no texture coordinates there"));
    }
    Ok(layout)
}

/// Lists the defects of a mesh in words, with the first line at fault where it is known.
fn notes(model: &Model, d: &Defects) -> Vec<String> {
    let mut notes = Vec::new();
    let welded = model.weld().vertex_of().len() - model.weld().first().len();
    let mut note = |n: usize, one: &str, many: &str, what: String| {
        if n > 0 {
            notes.push(format!("{}{what}", count(n, one, many)));
        }
    };
    let first = |line: Option<u32>| line.map(|line| format!(", the first in line {line}")).unwrap_or_default();
    let (one, many) = match model.source().format() {
        Format::Obj => ("`v` line is", "`v` lines are"),
        _ => ("vertex is", "vertices are"),
    };
    note(welded, one, many, " welded to another one at the same position".to_owned());
    note(d.isolated_vertices, "vertex is", "vertices are", " used by no face".to_owned());
    note(d.boundary_edges, "edge has", "edges have", " one face only: the mesh is open there".to_owned());
    note(d.non_manifold_edges, "edge has", "edges have", " three faces or more".to_owned());
    note(
        d.non_manifold_vertices,
        "vertex joins",
        "vertices join",
        " parts of the surface that have no edge in common there".to_owned(),
    );
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
    notes.extend(flaws(model).iter().map(ToString::to_string));
    notes
}

/// Looks up the materials that faces use in the libraries, and adds problems to `notes`.
fn inspect_materials(path: &Path, model: &Model, trust: Trust, notes: &mut Vec<String>) -> Vec<Material> {
    // If several libraries define a name, the first one counts.
    let mut known: HashMap<String, (materials::Material, PathBuf)> = HashMap::new();
    let mut problems = Vec::new();
    let libraries = input::libraries(path, model.source(), trust);
    let mut found_elsewhere = input::library_notes(&libraries, model.data());
    for library in libraries {
        let read = library.bytes.map_err(|e| format!("material library {e}"));
        let read = read.and_then(|b| materials::read(&b).map_err(|e| format!("{}: {e}", shown(&library.path))));
        match read {
            Ok(materials) => {
                for material in materials {
                    known.entry(material.name.clone()).or_insert_with(|| (material, library.path.clone()));
                }
            }
            Err(problem) => problems.push(problem),
        }
    }
    notes.extend(input::summary(problems));
    let used = model.data().materials().iter().map(|name| String::from_utf8_lossy(name).into_owned());
    let mut describe = |name: String| {
        let found = known.get(&name);
        let texture = found.and_then(|(m, _)| {
            let texture = m.diffuse_texture.clone()?;
            if model.source().file().is_some_and(|file| file.embedded_texture(&texture).is_some()) {
                return Some((texture, true));
            }
            let NamedPath { path, note } = named_path::find(input::folder_of(path), &texture, trust);
            found_elsewhere.extend(note);
            Some((texture, disk::is_file(&path)))
        });
        let library = found.map(|(_, library)| library.display().to_string());
        let (diffuse_texture, texture_found) = texture.unzip();
        Material { name, library, diffuse_texture, texture_found }
    };
    let described = used.map(&mut describe).collect();
    notes.extend(input::summary_of_notes(found_elsewhere));
    described
}
