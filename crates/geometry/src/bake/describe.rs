//! Manifest of a bake, and statements about the maps in the carrier's materials.

use super::maps::{MapImage, Maps};
use super::pages::{Paging, RULE};
use super::{Request, VertexDisplacements};
use crate::denoise::auto::DenoiseChoice;
use crate::denoise::limits::Mask;
use crate::map::displace;
use crate::map::manifest::{
    Carrier, Clients, DominantUv, Layout, Manifest, MapEntry, NormalMapEntry, PageEntry, PagesEntry, PrivateTexel,
    Report, SourceEntry, UvSource,
};
use crate::map::pages::Part;
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::source::materials::{self, MapStatements};
use crate::source::model::Model;
use glam::IVec2;
use std::collections::BTreeSet;

/// Manifest without checksums, carrier and report, which are known only when the files are made. `tile` is that of `atlas`.
pub(super) fn manifest_of(
    request: &Request,
    displacements: &VertexDisplacements,
    atlas: Option<&Atlas>,
    tile: IVec2,
    maps: &Maps,
) -> Manifest {
    let Request { model, names, settings, backs, .. } = *request;
    let is_uv = maps.plan.is_uv();
    let pages = maps.paging.as_ref().map(|paging| pages_entry(request, paging, maps));
    let one = maps.images.first().filter(|_| pages.is_none());
    let private_texels = one.map_or_else(Vec::new, |image| private_texels(model, image));
    let extension = settings.texel.file().extension();
    let (file, size) = match &pages {
        Some(pages) => (pages.maps[0].file.clone(), pages.maps[0].size()),
        None => (format!("{}.displacement.{extension}", names.stem), maps.images[0].size),
    };
    Manifest {
        planish: match (&pages, private_texels.as_slice()) {
            _ if !backs.vertices().is_empty() => 5,
            (Some(_), _) => 3,
            _ if tile != IVec2::ZERO => 4,
            (None, [_, ..]) => 2,
            (None, []) => 1,
        },
        source: SourceEntry {
            file: names.source.clone(),
            sha256: String::new(),
            vertices: model.data().positions().len(),
            faces: model.data().faces().len(),
        },
        method: settings.target.method(settings.map),
        // Numbers of the vertices are no part of a manifest.
        choice: displacements.choice.clone().map(|choice| DenoiseChoice { deviations: Vec::new(), ..choice }),
        welding: settings.welding,
        normals: displacements.source,
        displacement: MapEntry {
            file,
            map: settings.map,
            layout: if is_uv { Layout::Uv } else { Layout::Vertex },
            interpolation: is_uv.then_some(settings.interpolation),
            texels: is_uv.then_some(settings.texels),
            uvs: UvSource::Mesh,
            tile,
            width: size.width,
            height: size.height,
            texel: settings.texel,
            bias: maps.encoding.bias.into(),
            scale: maps.encoding.scale.into(),
            lambda: settings.lambda.0,
            origin: displace::origin(model.surface().bounds()),
        },
        dominant_uv: atlas.filter(|_| is_uv && pages.is_none()).map(|atlas| dominant_uv(model, atlas)),
        private_texels,
        backs: Mask::of_indices(backs.vertices().iter().copied()),
        pages,
        normal_map: one.and_then(|image| normal_map(request, image, format!("{}.normal.png", names.stem))),
        occlusion: None,
        curvature: None,
        carrier: Carrier::default(),
        files: Vec::new(),
        report: Report { tolerance_quanta: settings.tolerance.0, ..Report::default() },
        clients: Clients::new(settings.map, displacements.source, maps.encoding, settings.lambda.0),
    }
}

/// Statements that reference the maps in a material of the carrier.
///
/// A client samples every map that a material names at the texture coordinates of the mesh, so the displacement map is
/// named only if it was baked for those. A material has one image, so it names a page if that is the page of the material.
pub(super) fn statements<'a>(manifest: &'a Manifest, has_own_uvs: bool, material: &str) -> MapStatements<'a> {
    let is_of_material = |page: &&PageEntry| matches!(&page.part, Part::Material(name) if name == material);
    let page = manifest.page_entries().iter().find(is_of_material);
    if manifest.pages.is_some() && page.is_none() {
        return MapStatements::default();
    }
    let (file, normal_map) = match page {
        Some(page) => (&page.file, &page.normal_map),
        None => (&manifest.displacement.file, &manifest.normal_map),
    };
    // Where most vertices read private texels, the rest of the map would be more wrong than none.
    let has_places = 2 * manifest.report.private_vertices <= manifest.source.vertices;
    let fits_uvs = (manifest.displacement.layout == Layout::Uv && has_places) || !has_own_uvs;
    let displacement = manifest.clients.mtl.filter(|_| fits_uvs).map(|mtl| materials::DisplacementStatement {
        file,
        base: mtl.base,
        gain: mtl.gain,
    });
    let normal = normal_map.as_ref().map(|map| map.file.as_str());
    MapStatements { displacement, normal, tile: manifest.displacement.tile }
}

/// Entry of the normal map of an image.
fn normal_map(request: &Request, image: &MapImage, file: String) -> Option<NormalMapEntry> {
    let (_, size) = image.normal_map.as_ref()?;
    let convention = request.settings.convention;
    Some(NormalMapEntry { file, width: size.width, height: size.height, convention })
}

/// Entries of the pages.
fn pages_entry(request: &Request, paging: &Paging, maps: &Maps) -> PagesEntry {
    let Request { model, names, settings, .. } = *request;
    let extension = settings.texel.file().extension();
    let mut vertices = vec![Vec::new(); maps.images.len()];
    for (source, v) in (0..).zip(model.weld().vertex_of()) {
        if let Some(page) = paging.of_vertices[*v as usize] {
            vertices[page as usize].push(source);
        }
    }
    let file_names = file_names(paging.pages.parts());
    let entry = |(page, vertices): (usize, Vec<Index>)| {
        let (image, name) = (&maps.images[page], &file_names[page]);
        PageEntry {
            part: paging.pages.parts()[page].clone(),
            file: format!("{}.displacement.{name}.{extension}", names.stem),
            width: image.size.width,
            height: image.size.height,
            normal_map: normal_map(request, image, format!("{}.normal.{name}.png", names.stem)),
            vertices: Mask::of_indices(vertices),
            texels: Mask::default(),
            seam_vertices: paging.seam_vertices[page].clone(),
            private_texels: private_texels(model, image),
        }
    };
    PagesEntry {
        by: paging.pages.by(),
        rule: RULE.to_owned(),
        maps: vertices.into_iter().enumerate().map(entry).collect(),
    }
}

/// Words for the parts in names of files: different ones, without what file systems do not allow.
fn file_names(parts: &[Part]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let name = |part: &Part| {
        let is_plain = |c: char| c.is_alphanumeric() || "-_+=@".contains(c);
        let name: String = part.to_string().chars().take(80).map(|c| if is_plain(c) { c } else { '_' }).collect();
        let numbered = (2..).map(|k: usize| format!("{name}-{k}"));
        let mut free = std::iter::once(name.clone()).chain(numbered);
        // File systems may not tell cases apart.
        free.find(|name| taken.insert(name.to_lowercase())).unwrap_or(name)
    };
    parts.iter().map(name).collect()
}

/// Lists the private texels of source vertices.
fn private_texels(model: &Model, image: &MapImage) -> Vec<PrivateTexel> {
    let mut of_vertex = vec![None; model.surface().positions().len()];
    for &[v, texel] in &image.private {
        of_vertex[v as usize] = Some(texel);
    }
    let width = image.size.width;
    let entry = |(vertex, v): (Index, &Index)| {
        let texel = of_vertex[*v as usize]?;
        Some(PrivateTexel { vertex, column: texel % width, row: texel / width })
    };
    (1..).zip(model.weld().vertex_of()).filter_map(entry).collect()
}

/// Lists the dominant texture coordinates of source vertices at seams.
///
/// A source vertex is listed if its vertex has several wedges or if any corner names other texture coordinates than the
/// dominant ones. The corner may belong to a face that the surface leaves out, because clients draw those faces too.
fn dominant_uv(model: &Model, atlas: &Atlas) -> DominantUv {
    let (data, vertex_of) = (model.data(), model.weld().vertex_of());
    let coordinates = |uv: Index| data.uvs()[uv as usize];
    let mut listed: Vec<bool> = vertex_of.iter().map(|&v| atlas.wedges().get(v).len() > 1).collect();
    for corner in data.faces().items() {
        let v = corner.position as usize;
        listed[v] |= corner.uv().map(coordinates) != atlas.dominant(vertex_of[v]).map(coordinates);
    }
    let pair = |(v, &vertex): (Index, &Index)| {
        let uv = atlas.dominant(vertex).filter(|_| listed[v as usize])?;
        Some([v + 1, uv + 1])
    };
    let seam_vertices = (0..).zip(vertex_of).filter_map(pair).collect();
    DominantUv { rule: Atlas::DOMINANT_RULE.to_owned(), seam_vertices }
}
