//! The carrier as binary glTF, which has the map and its materials inside.

use super::Request;
use super::carrier::texel_uvs;
use super::maps::{MapImage, Maps};
use super::shading_maps::ShadingMaps;
use crate::bake::gltf::{self, Filter, GltfError};
use crate::map::displace::{self, SamplingRule};
use crate::map::displacement::SampleAt;
use crate::map::manifest::{Layout, Manifest, MapEntry, PageEntry};
use crate::map::pages::Pages;
use crate::map::{Size, per_vertex};
use crate::mesh::jagged::Index;
use crate::mesh::normals::{FaceWeight, vertex_normals};
use crate::source::MeshData;
use crate::source::materials;
use crate::source::model::Model;
use glam::{Vec2, Vec3};
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde_json::{Map as Object, Value, json};

/// Parts of a bake that a binary glTF is made from.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) manifest: &'a Manifest,
    pub(super) maps: &'a Maps,
    pub(super) shading: &'a ShadingMaps,
    /// Mesh of the carrier.
    pub(super) carrier: &'a MeshData,
    /// Unit normals of the vertices, along which the map displaces. #V×3
    pub(super) normals: &'a [Vec3],
    /// Model before unwrapping, if it was unwrapped.
    pub(super) original: Option<&'a Model>,
}

/// Makes the carrier as binary glTF.
pub(super) fn make(request: &Request, parts: Parts) -> Result<Vec<u8>, GltfError> {
    let Request { model, names, side_files, backs, .. } = *request;
    let Parts { manifest, maps, shading, carrier: data, normals, original } = parts;
    let entry = &manifest.displacement;
    let pages = maps.paging.as_ref().map(|paging| &paging.pages);
    let (sample_at, copies) = match pages {
        Some(pages) => samples_on_pages(data, manifest, pages),
        None => {
            let vertices = displace::carrier_vertices(data, &SamplingRule::of(manifest), entry.origin);
            (vertices.iter().map(|v| v.sample_at.map(|at| place(at, entry.size()))).collect(), FxHashMap::default())
        }
    };
    let denoised = &maps.offsets.positions;
    let denoised_normals = vertex_normals(&model.surface().at(denoised.clone()), FaceWeight::Angle);
    // A library that cannot be parsed is still copied into the MTL of the carrier; in the glTF its materials are grey.
    let materials: Vec<_> = side_files.libraries.iter().flat_map(|l| materials::read(l).unwrap_or_default()).collect();
    let normal_map = manifest.normal_map.as_ref().map_or(Value::Null, |map| json!(map));
    let filter = if entry.layout == Layout::Uv { Filter::Linear } else { Filter::Nearest };
    let map = gltf::Map { bytes: &maps.images[0].displacement, filter, entry: entry_of(entry) };
    let pages = pages.map(|of_faces| gltf::Pages {
        of_faces,
        maps: manifest
            .page_entries()
            .iter()
            .zip(&maps.images)
            .map(|(page, image)| page_map(page, image, entry))
            .collect(),
        copies,
    });
    let shading_entries =
        [shading.occlusion.as_ref().map(|m| &m.entry.map), shading.curvature.as_ref().map(|m| &m.entry.map)];
    let is_per_vertex = shading_entries.iter().flatten().any(|entry| entry.layout == Layout::Vertex);
    let vertex_texels = (is_per_vertex && entry.layout != Layout::Vertex).then(|| texel_uvs(model));
    let carrier = gltf::Carrier {
        name: &names.stem,
        model,
        backs,
        original,
        normals,
        sample_at: &sample_at,
        vertex_texels: vertex_texels.as_deref(),
        denoised,
        denoised_normals: &denoised_normals,
        origin: entry.origin,
        lambda: entry.lambda,
        materials: &materials,
        map,
        pages,
        relocate: side_files.relocate,
        normal_map,
        occlusion: shading.occlusion.as_ref().map(|map| gltf::ShadingMap {
            bytes: &map.image,
            layout: map.entry.map.layout,
            entry: entry_of(&map.entry),
        }),
        curvature: shading.curvature.as_ref().map(|map| gltf::ShadingMap {
            bytes: &map.image,
            layout: map.entry.map.layout,
            entry: entry_of(&map.entry),
        }),
    };
    gltf::glb(&carrier, side_files.texture)
}

/// Image of a page with its description, and the description of its normal map. `entry` is that of the whole map.
fn page_map<'a>(page: &PageEntry, image: &'a MapImage, entry: &MapEntry) -> (gltf::Map<'a>, Value) {
    let (file, width, height) = (page.file.clone(), page.width, page.height);
    let mut described = entry_of(&MapEntry { file, width, height, ..entry.clone() });
    described.extend(entry_of(&page.part));
    let normal_map = page.normal_map.as_ref().map_or(Value::Null, |map| json!(map));
    (gltf::Map { bytes: &image.displacement, filter: Filter::Linear, entry: described }, normal_map)
}

/// Texture coordinate of a place in an image, v up.
fn place(sample_at: SampleAt, size: Size) -> Vec2 {
    match sample_at {
        SampleAt::Uv(uv) => uv,
        SampleAt::Texel(texel) => per_vertex::uv(texel, size),
    }
}

/// Texture coordinates at which source vertices sample their own pages (#v), and those at which they sample the other pages of their
/// faces, by page and source vertex.
fn samples_on_pages(
    carrier: &MeshData,
    manifest: &Manifest,
    pages: &Pages,
) -> (Vec<Option<Vec2>>, FxHashMap<[Index; 2], Vec2>) {
    let mut own = vec![None; carrier.positions().len()];
    let mut copies = FxHashMap::default();
    let of_corners = pages.of_corners(carrier);
    for (page, entry) in (0..).zip(manifest.page_entries()) {
        let in_page = displace::samples_in_page(carrier, entry);
        let at = |v: Index| in_page[v as usize].map(|at| place(at, entry.size()));
        let mut is_own = vec![false; own.len()];
        for v in entry.vertices.indices() {
            (own[v as usize], is_own[v as usize]) = (at(v), true);
        }
        let corners = carrier.faces().items().iter().zip(&of_corners).filter(|(_, of_corner)| **of_corner == page);
        for v in corners.map(|(corner, _)| corner.position).filter(|v| !is_own[*v as usize]) {
            copies.extend(at(v).map(|uv| ([page, v], uv)));
        }
    }
    (own, copies)
}

/// Entry of the manifest as an object of JSON.
fn entry_of(entry: &impl Serialize) -> Object<String, Value> {
    match json!(entry) {
        Value::Object(entry) => entry,
        _ => Object::new(),
    }
}
