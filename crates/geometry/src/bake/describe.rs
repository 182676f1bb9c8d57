//! Manifest of a bake, and statements about the maps in the carrier's materials.

use super::maps::Maps;
use super::{Request, VertexDisplacements};
use crate::denoise::auto::DenoiseChoice;
use crate::map::displace;
use crate::map::manifest::{
    Carrier, Clients, DominantUv, Layout, Manifest, MapEntry, NormalMapEntry, PrivateTexel, Report, SourceEntry,
    UvSource,
};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::source::materials::{self, MapStatements};
use crate::source::model::Model;

/// Manifest without checksums, carrier and report, which are known only when the files are made.
pub(super) fn manifest_of(
    request: &Request,
    displacements: &VertexDisplacements,
    atlas: Option<&Atlas>,
    maps: &Maps,
) -> Manifest {
    let Request { model, names, settings, .. } = *request;
    let size = maps.size;
    let is_uv = maps.plan.is_uv();
    let normal_map = maps.normal_map.as_ref().map(|(_, size)| NormalMapEntry {
        file: format!("{}.normal.png", names.stem),
        width: size.width,
        height: size.height,
        convention: settings.convention,
    });
    Manifest {
        planish: if maps.private.is_empty() { 1 } else { 2 },
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
            file: format!("{}.displacement.{}", names.stem, settings.texel.file().extension()),
            map: settings.map,
            layout: if is_uv { Layout::Uv } else { Layout::Vertex },
            interpolation: is_uv.then_some(settings.interpolation),
            texels: is_uv.then_some(settings.texels),
            uvs: UvSource::Mesh,
            width: size.width,
            height: size.height,
            texel: settings.texel,
            bias: maps.encoding.bias.into(),
            scale: maps.encoding.scale.into(),
            lambda: settings.lambda.0,
            origin: displace::origin(model.surface().bounds()),
        },
        dominant_uv: atlas.filter(|_| is_uv).map(|atlas| dominant_uv(model, atlas)),
        private_texels: private_texels(model, maps),
        normal_map,
        occlusion: None,
        curvature: None,
        carrier: Carrier::default(),
        files: Vec::new(),
        report: Report { tolerance_quanta: settings.tolerance.0, ..Report::default() },
        clients: Clients::new(settings.map, displacements.source, maps.encoding, settings.lambda.0),
    }
}

/// Statements that reference the maps in the carrier's materials.
///
/// A client samples every map that a material names at the texture coordinates of the mesh, so the displacement map is
/// named only if it was baked for those.
pub(super) fn statements(manifest: &Manifest, has_own_uvs: bool) -> MapStatements<'_> {
    // Where most vertices read private texels, the rest of the map would be more wrong than none.
    let has_places = 2 * manifest.report.private_vertices <= manifest.source.vertices;
    let fits_uvs = (manifest.displacement.layout == Layout::Uv && has_places) || !has_own_uvs;
    let displacement = manifest.clients.mtl.filter(|_| fits_uvs).map(|mtl| materials::DisplacementStatement {
        file: &manifest.displacement.file,
        base: mtl.base,
        gain: mtl.gain,
    });
    MapStatements { displacement, normal: manifest.normal_map.as_ref().map(|map| map.file.as_str()) }
}

/// Lists the private texels of source vertices.
fn private_texels(model: &Model, maps: &Maps) -> Vec<PrivateTexel> {
    let mut of_vertex = vec![None; model.surface().positions().len()];
    for &[v, texel] in &maps.private {
        of_vertex[v as usize] = Some(texel);
    }
    let width = maps.size.width;
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
