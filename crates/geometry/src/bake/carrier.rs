//! The carrier: the mesh that a client loads together with the map.

use super::Request;
use super::draft::Draft;
use super::maps::MapImage;
use crate::bake::gltf::{self, Filter, GltfError};
use crate::map::displace::{self, SamplingRule};
use crate::map::displacement::SampleAt;
use crate::map::manifest::{self, Layout, Manifest, MapEntry, PageEntry};
use crate::map::pages::Pages;
use crate::map::{Size, per_vertex};
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::source::MeshData;
use crate::source::materials;
use crate::source::model::Model;
use crate::source::obj::{Obj, ObjError};
use glam::{DVec3, Vec2, Vec3};
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde_json::{Map as Object, Value, json};

/// Carrier OBJ, parsed back from the bytes that will be written.
pub(super) struct CarrierFile {
    pub(super) obj: Obj,
    pub(super) sha256: String,
}

impl CarrierFile {
    /// Prints the carrier and parses it back. Its normals are those of the vertices (#V×3); `uvs` are texture coordinates
    /// of the source vertices (#v×2) for a mesh that has none.
    pub(super) fn make(
        model: &Model,
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        library_file: &str,
    ) -> Result<Self, ObjError> {
        let welded: Vec<DVec3> = model.weld().spread(model.surface().positions());
        let bytes = model.source().carrier(&welded, &source_normals(model, normals), uvs, library_file);
        let sha256 = manifest::sha256(&bytes);
        Ok(Self { obj: Obj::parse(bytes)?, sha256 })
    }
}

/// Texture coordinates at which the source vertices sample a map with one texel for each. #v×2, v up
pub(super) fn texel_uvs(model: &Model) -> Vec<Vec2> {
    let count = model.data().positions().len();
    let size = per_vertex::size(count);
    (0..count as Index).map(|v| per_vertex::uv(v, size)).collect()
}

/// Makes the carrier as binary glTF, with the unit normals (#V×3) that the map displaces along.
/// `original` is the model before unwrapping, if it was unwrapped.
pub(super) fn glb(
    request: &Request,
    normals: &[Vec3],
    draft: &Draft,
    original: Option<&Model>,
) -> Result<Vec<u8>, GltfError> {
    let Request { model, names, side_files, .. } = *request;
    let Draft { manifest, maps, shading, carrier, .. } = draft;
    let entry = &manifest.displacement;
    let data = carrier.obj.data();
    let pages = maps.paging.as_ref().map(|paging| &paging.pages);
    let (sample_at, copies) = match pages {
        Some(pages) => samples_on_pages(data, manifest, pages),
        None => {
            let vertices = displace::carrier_vertices(data, &SamplingRule::of(manifest), entry.origin);
            (vertices.iter().map(|v| v.sample_at.map(|at| place(at, entry.size()))).collect(), FxHashMap::default())
        }
    };
    let denoised = &maps.offsets.positions;
    let denoised_normals = normals::vertex_normals(&model.surface().at(denoised.clone()), FaceWeight::Angle);
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

/// Unit normals of the source vertices. #v×3
///
/// A vertex without a normal has height zero, so any direction serves; a client would normalise a zero vector to NaN.
fn source_normals(model: &Model, normals: &[Vec3]) -> Vec<Vec3> {
    let mut normals = model.weld().spread(normals);
    for n in normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        *n = Vec3::Z;
    }
    normals
}
