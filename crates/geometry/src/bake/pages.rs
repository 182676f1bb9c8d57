//! Bake of a map with pages: each page is filled like a map of its own.

use super::fill::{self, Filled, Placed};
use super::layout::{Fallback, Plan};
use super::layout_choice::LayoutChoice;
use super::normal_maps::NormalMaps;
use super::{BakeError, Request};
use crate::map::Coverage;
use crate::map::layout_issues::{self, LayoutIssues};
use crate::map::manifest::{Manifest, PageEntry};
use crate::map::map_size::Spacing;
use crate::map::pages::{Pages, Part};
use crate::mesh::atlas::{Atlas, AtlasError};
use crate::mesh::jagged::Index;
use crate::progress::Progress;
use crate::source::model::Model;

/// Division of a mesh into pages, and where its vertices sample them.
pub(super) struct Paging {
    pub(super) pages: Pages,
    /// Page that each vertex samples; `None` for vertices that stay. #V
    pub(super) of_vertices: Vec<Option<Index>>,
    /// For each page, ascending pairs of the numbers of a source vertex and of the texture coordinate at which it samples the page,
    /// both counted from 1.
    pub(super) seam_vertices: Vec<Vec<[Index; 2]>>,
    /// Number of vertices of faces without texture coordinates.
    pub(super) unmapped_vertices: usize,
}

/// Texels of a map before encoding.
pub(super) struct Texels {
    pub(super) plan: Plan,
    /// Texels of the map, or of each page.
    pub(super) filled: Vec<Filled>,
    pub(super) paging: Option<Paging>,
}

/// Name of the rule by which a vertex has its page and its texture coordinate there, as it is written to manifests.
pub(super) const RULE: &str = "largest-uv-area-on-page, first-page; inside-image, largest-uv-area, lowest-vt-index";

/// Fills the pages with channels (#V each, model units), or one image with a texel for each vertex if a page has no room. `atlas` is
/// the layout of the whole mesh.
pub(super) fn fill(
    request: &Request,
    atlas: &Atlas,
    pages: Pages,
    channels: &[Vec<f64>],
    normals: &NormalMaps,
) -> Result<Texels, BakeError> {
    let Request { model, settings, progress, .. } = *request;
    let mut of_vertices = pages.of_vertices(model, atlas);
    let (mut filled, mut seam_vertices, mut plans) = (Vec::new(), Vec::new(), Vec::new());
    let corners = pages.of_corners(model.data());
    let at_texels = |part: &Part, reason: Option<Fallback>| -> Result<Texels, BakeError> {
        let of_page = |reason| Fallback::Page { page: part.to_string(), reason: Box::new(reason) };
        let plan = Plan::Vertex { fallback: reason.map(of_page) };
        let mut one = fill::at_texels(request, Some(atlas), channels)?;
        normals.add(&mut one)?;
        Ok(Texels { plan, filled: vec![one], paging: None })
    };
    for (page, part) in (0..).zip(pages.parts()) {
        progress.stage("spacing");
        let of_page = match pages.atlas(model, page) {
            Err(AtlasError::NoUvs) if settings.layout == LayoutChoice::Auto => {
                return at_texels(part, Some(Fallback::NoLayout));
            }
            other => other?,
        };
        let spacing = Spacing::new(&of_page);
        let touch = pages.touch(model, page);
        let is_used = |v: Index| touch[v as usize];
        let vertices = touch.iter().filter(|touches| **touches).count();
        let placed = Placed { atlas: &of_page, spacing: &spacing, is_used: &is_used, vertices };
        let plan = Plan::make(model.surface(), Some(placed.layout()), channels, settings, progress)?;
        let (plan, mut of_image) = fill::fill(request, plan, Some(placed), channels)?;
        if let Plan::Vertex { fallback } = plan {
            return at_texels(part, fallback);
        }
        // What has no texel stays where it is, on no page.
        for (of_vertex, v) in of_vertices.iter_mut().zip(0..).filter(|(of_vertex, _)| **of_vertex == Some(page)) {
            let is_private = || of_image.private.binary_search_by_key(&v, |pair| pair[0]).is_ok();
            *of_vertex = of_vertex.filter(|_| of_page.dominant(v).is_some() || is_private());
        }
        normals.add(&mut of_image)?;
        // It takes more memory than the texels, and only maps of shading would need it.
        of_image.coverage = None;
        seam_vertices.push(seams(model, &of_page, &touch, (part, page, &corners)));
        filled.push(of_image);
        plans.push(plan);
    }
    // The largest page tells why it has its size.
    let size = |plan: &Plan| if let Plan::Uv { sides, .. } = plan { sides.first().copied() } else { None };
    let largest = plans.into_iter().max_by_key(size).unwrap_or(Plan::Vertex { fallback: None });
    let unmapped_vertices = layout_issues::unmapped(model.surface(), atlas);
    Ok(Texels { plan: largest, filled, paging: Some(Paging { pages, of_vertices, seam_vertices, unmapped_vertices }) })
}

/// Lists the texture coordinates at which source vertices sample a page, as far as they do not follow from the corners of the vertex.
/// A corner may belong to a face that the surface leaves out, because clients draw those faces too.
fn seams(
    model: &Model,
    atlas: &Atlas,
    touch: &[bool],
    (part, page, of_corners): (&Part, Index, &[Index]),
) -> Vec<[Index; 2]> {
    let (data, vertex_of) = (model.data(), model.weld().vertex_of());
    let coordinates = |uv: Index| part.uv_in_image(data.uvs()[uv as usize]);
    // Vertices without corners have to be listed, too.
    let mut has_corner = vec![false; vertex_of.len()];
    let mut listed = vec![false; vertex_of.len()];
    for (corner, of_corner) in data.faces().items().iter().zip(of_corners) {
        let v = corner.position as usize;
        has_corner[v] = true;
        let dominant = atlas.dominant(vertex_of[v]).map(coordinates);
        listed[v] |= *of_corner != page || corner.uv().map(coordinates) != dominant;
    }
    let pair = |(source, &v): (Index, &Index)| {
        let needs = listed[source as usize] || !has_corner[source as usize];
        let uv = atlas.dominant(v).filter(|_| needs && touch[v as usize])?;
        Some([source + 1, uv + 1])
    };
    (0..).zip(vertex_of).filter_map(pair).collect()
}

/// Pages of a mesh whose manifest was read; `None` if its map has one image. Fails if the mesh has other parts.
pub(super) fn of_manifest(model: &Model, manifest: &Manifest) -> Result<Option<Pages>, BakeError> {
    let Some(entry) = &manifest.pages else { return Ok(None) };
    let pages = match entry.by.rule() {
        Some(rule) => Pages::of(model.data(), rule)?.ok_or(BakeError::OtherPages)?,
        None => of_cut(model, &entry.maps),
    };
    let is_same = pages.parts().iter().eq(entry.maps.iter().map(|page| &page.part));
    if is_same { Ok(Some(pages)) } else { Err(BakeError::OtherPages) }
}

/// Pages of a mesh that was cut as its manifest says.
fn of_cut(model: &Model, maps: &[PageEntry]) -> Pages {
    let mut of_vertices = vec![None; model.data().positions().len()];
    for (page, entry) in (0..).zip(maps) {
        entry.vertices.indices().for_each(|v| of_vertices[v as usize] = Some(page));
    }
    let number = |entry: &PageEntry| if let Part::Cut(number) = entry.part { Some(number) } else { None };
    Pages::of_cut(model.data(), maps.iter().filter_map(number), &of_vertices)
}

/// Finds the issues of the layouts of pages at the sizes of their images.
pub(super) fn issues(
    model: &Model,
    atlas: &Atlas,
    pages: &Pages,
    manifest: &Manifest,
    progress: &dyn Progress,
) -> Result<LayoutIssues, BakeError> {
    let of_page = |(page, entry): (Index, &PageEntry)| {
        let of_page = pages.atlas(model, page)?;
        let coverage = Coverage::new(model.surface(), &of_page, entry.size(), progress)?;
        let issues = LayoutIssues::of(model.surface(), &of_page, &Spacing::new(&of_page), &coverage);
        Ok((issues, entry.size().texels()))
    };
    let found = (0..).zip(manifest.page_entries()).map(of_page).collect::<Result<Vec<_>, BakeError>>()?;
    Ok(LayoutIssues::of_pages(&found, layout_issues::unmapped(model.surface(), atlas)))
}
