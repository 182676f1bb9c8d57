//! Carrier of a mesh that came as glTF: its own document with the map added, so that materials, textures, skins, animations,
//! other morph targets and whatever else the file has stay.

use super::document::Document;
use super::glb::Buffer;
use super::materials::{Materials, Sets};
use super::split::{Made, Named, Split};
use super::{Carrier, GltfError, TARGET, Textures, v_down};
use crate::map::displacement::MapKind;
use crate::mesh::jagged::{Index, Ragged};
use crate::source::gltf::{Block, Gltf, index, list};
use glam::{DMat3, DVec3, Vec2, Vec3};
use rustc_hash::FxHashMap;
use serde_json::{Map as Object, Value, json};

/// Accessors that the vertices of a block get.
struct Added<'a> {
    block: &'a Block,
    /// New texture coordinates of the vertices, and where these are split; `None` if the map lies in those of the document.
    split: Option<Split<'a>>,
    /// Accessor of the new texture coordinates.
    unwrapped: Option<usize>,
    normals: usize,
    samples: usize,
    vertex_texels: Option<usize>,
    target: Value,
}

/// Writes the document of the source with, for each vertex of the surface, the normal that the map displaces along, the place
/// where it samples the map, and the denoised position as the last morph target. A primitive on several pages becomes one for each, and
/// vertices are split where new texture coordinates are cut.
/// `None` if the document cannot have that, see [`is_possible`], or if a view of it names no buffer.
pub(super) fn glb(carrier: &Carrier, gltf: &Gltf, textures: Textures) -> Result<Option<Vec<u8>>, GltfError> {
    let Some((mut document, mut buffer)) = opened(gltf) else { return Ok(None) };
    let sets = Sets::from(next_set(&Value::Object(document.clone())), carrier);
    let mut materials = Materials::continuing(&mut buffer, carrier, &mut document, sets);
    materials.embed_images(&mut buffer, textures, carrier.relocate);
    let describes = carrier.map.entry.get("map").is_none_or(|kind| can_describe(gltf, kind));
    let named = carrier.original.map(|_| Named::new(carrier.model));
    let mut added: FxHashMap<usize, Added> = FxHashMap::default();
    for block in gltf.position_blocks() {
        let split = named.as_ref().map(|named| named.split(block));
        added.insert(block.index, add(carrier, gltf, (block, split), &mut buffer)?);
    }
    let mut made = Made::default();
    let counts: Vec<usize> = accessor_counts(gltf);
    let mut meshes = match document.remove("meshes") {
        Some(Value::Array(meshes)) => meshes,
        _ => Vec::new(),
    };
    let mut targets_of_meshes = Vec::new();
    for mesh in &mut meshes {
        let own = list(mesh, "primitives").iter().map(|p| list(p, "targets").len()).max().unwrap_or(0);
        let is_baked =
            |p: &Value| is_surface(p) && index(&p["attributes"]["POSITION"]).is_some_and(|i| added.contains_key(&i));
        if !list(mesh, "primitives").iter().any(is_baked) {
            targets_of_meshes.push(None);
            continue;
        }
        targets_of_meshes.push(Some(own));
        let mut primitives = Vec::new();
        for mut primitive in list(mesh, "primitives").to_vec() {
            if !primitive.is_object() {
                primitives.push(primitive);
                continue;
            }
            let position = index(&primitive["attributes"]["POSITION"]);
            let Some(added) = position.and_then(|i| added.get(&i)).filter(|_| is_surface(&primitive)) else {
                let count = position.and_then(|i| counts.get(i).copied()).unwrap_or(0);
                add_target(&mut primitive, json!({ "POSITION": buffer.zeros(count) }));
                primitives.push(primitive);
                continue;
            };
            let material = index(&primitive["material"]).filter(|m| *m < list(gltf.document(), "materials").len());
            for PagePrimitive { mut primitive, page, samples } in
                divided(carrier, gltf, (primitive, added), &mut buffer)
            {
                if let Some(split) = &added.split {
                    split.apply(&mut primitive, gltf, &mut buffer, &mut made)?;
                }
                primitive["attributes"]["NORMAL"] = added.normals.into();
                set_samples(&mut primitive, sets, samples, added);
                if let Some(page) = page.filter(|_| describes) {
                    primitive["material"] = materials.describe(material, page).into();
                }
                add_target(&mut primitive, added.target.clone());
                primitives.push(primitive);
            }
        }
        mesh["primitives"] = primitives.into();
        let mut names: Vec<Value> = list(&mesh["extras"], "targetNames").to_vec();
        names.extend((names.len()..own).map(|k| format!("target-{k}").into()));
        names.truncate(own);
        names.push(TARGET.into());
        let weights = with_weight(mesh, own, carrier.lambda);
        mesh["weights"] = weights;
        if !mesh["extras"].is_object() {
            mesh["extras"] = json!({});
        }
        mesh["extras"]["targetNames"] = names.into();
    }
    document.insert("meshes".to_owned(), meshes.into());
    for node in document.get_mut("nodes").and_then(Value::as_array_mut).into_iter().flatten() {
        let own = index(&node["mesh"]).and_then(|mesh| targets_of_meshes.get(mesh).copied().flatten());
        if let (Some(own), true) = (own, node["weights"].is_array()) {
            node["weights"] = with_weight(node, own, carrier.lambda);
        }
    }
    let mut document = Document::from(document);
    materials.insert_into(&mut document);
    Ok(Some(buffer.finish(document)?))
}

/// Part of a primitive on one page.
struct PagePrimitive {
    primitive: Value,
    /// Page of the faces; `None` if the primitive is not in the scene, so that its faces have no page.
    page: Option<Index>,
    /// Accessor of the places at which the vertices sample the page.
    samples: usize,
}

/// Divides a primitive by the pages of its faces. One that lies on a single page stays as it is.
fn divided(
    carrier: &Carrier,
    gltf: &Gltf,
    (primitive, added): (Value, &Added),
    buffer: &mut Buffer,
) -> Vec<PagePrimitive> {
    let Some(pages) = &carrier.pages else {
        return vec![PagePrimitive { primitive, page: Some(0), samples: added.samples }];
    };
    let Some(faces) = gltf.faces(&primitive).filter(|faces| !faces.is_empty()) else {
        return vec![PagePrimitive { primitive, page: None, samples: added.samples }];
    };
    let first = added.block.first as Index;
    let corners = carrier.model.data().faces();
    let of_page = Ragged::group(
        pages.of_faces.parts().len(),
        faces.map(|f| (pages.of_faces.of_face(f), [0, 1, 2].map(|k| corners.get(f)[k].position - first))),
    );
    let of_page: Vec<_> = (0..).zip(of_page.iter()).filter(|(_, triangles)| !triangles.is_empty()).collect();
    let is_whole = of_page.len() == 1;
    let part = |(page, triangles): (Index, &[[Index; 3]])| {
        let mut primitive = primitive.clone();
        if !is_whole {
            primitive["indices"] = buffer.indices(triangles, added.block.values().len()).into();
            primitive["mode"] = 4.into();
        }
        let mut drawn = triangles.as_flattened().to_vec();
        drawn.sort_unstable();
        drawn.dedup();
        let copy = |v: Index| Some((v, v_down(*pages.copies.get(&[page, first + v])?)));
        let copies: Vec<_> = drawn.into_iter().filter_map(copy).collect();
        let samples = match copies.as_slice() {
            [] => added.samples,
            copies => buffer.changed(added.samples, added.block.values().len(), copies),
        };
        PagePrimitive { primitive, page: Some(page), samples }
    };
    of_page.into_iter().map(part).collect()
}

/// Gives the vertices of a primitive the places at which they sample the maps.
fn set_samples(primitive: &mut Value, sets: Sets, samples: usize, added: &Added) {
    let attributes = &mut primitive["attributes"];
    if let Some((set, uvs)) = sets.unwrapped.zip(added.unwrapped) {
        attributes[format!("TEXCOORD_{set}")] = uvs.into();
    }
    // Sets are numbered from 0 without gaps.
    for k in 0..=sets.samples {
        let name = format!("TEXCOORD_{k}");
        if k == sets.samples || attributes[&name].is_null() {
            attributes[&name] = samples.into();
        }
    }
    if let Some(texels) = added.vertex_texels {
        attributes[format!("TEXCOORD_{}", sets.vertices)] = texels.into();
    }
}

/// Adds a morph target to a primitive.
fn add_target(primitive: &mut Value, target: Value) {
    let mut targets = list(primitive, "targets").to_vec();
    targets.push(target);
    primitive["targets"] = targets.into();
}

/// Returns whether the map can be described to clients, which displace in the numbers of the file: heights need meshes that their
/// nodes do not scale, vectors in object space meshes that they do not turn either.
fn can_describe(gltf: &Gltf, kind: &Value) -> bool {
    let turns = *kind != json!(MapKind::VectorObject);
    gltf.position_blocks().iter().all(|block| {
        let matrix = block.place.matrix3;
        matrix == DMat3::IDENTITY || (turns && (matrix * matrix.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-9))
    })
}

/// Returns whether the document can have another morph target: an animation that gives weights to morph targets would have too few.
pub(super) fn is_possible(gltf: &Gltf) -> bool {
    let animates = |a: &Value| list(a, "channels").iter().any(|c| c["target"]["path"] == "weights");
    gltf.document().is_object() && !list(gltf.document(), "animations").iter().any(animates)
}

/// Document of the source without its buffers, and one buffer with all of their bytes.
fn opened(gltf: &Gltf) -> Option<(Object<String, Value>, Buffer)> {
    if !is_possible(gltf) {
        return None;
    }
    let mut document = gltf.document().as_object()?.clone();
    let (mut bytes, mut starts) = (Vec::new(), Vec::new());
    for i in 0..list(gltf.document(), "buffers").len() {
        bytes.resize(usize::next_multiple_of(bytes.len(), 4), 0);
        starts.push(bytes.len());
        // All bytes that there are, as views are read from them, whatever `byteLength` says.
        bytes.extend_from_slice(gltf.buffer(i));
    }
    let mut take = |name: &str| match document.remove(name) {
        Some(Value::Array(list)) => list,
        _ => Vec::new(),
    };
    let (mut views, accessors) = (take("bufferViews"), take("accessors"));
    document.remove("buffers");
    for view in &mut views {
        let start = starts.get(index(&view["buffer"])?)?;
        view["byteOffset"] = start.checked_add(index(&view["byteOffset"]).unwrap_or(0))?.into();
        view["buffer"] = 0.into();
    }
    Some((document, Buffer::continuing(bytes, views, accessors)))
}

/// Number of values of each accessor.
fn accessor_counts(gltf: &Gltf) -> Vec<usize> {
    list(gltf.document(), "accessors").iter().map(|accessor| index(&accessor["count"]).unwrap_or(0)).collect()
}

/// Returns whether a primitive is made of triangles.
fn is_surface(primitive: &Value) -> bool {
    primitive["mode"].as_u64().unwrap_or(4) >= 4
}

/// First set of texture coordinates that no primitive has.
fn next_set(document: &Value) -> usize {
    let of_primitive = |p: &Value| {
        let names = p["attributes"].as_object().into_iter().flatten().map(|(name, _)| name);
        let set = |name: &String| name.strip_prefix("TEXCOORD_")?.parse().ok();
        names.filter_map(set).map(|set: usize| set.min(100) + 1).max().unwrap_or(0)
    };
    let primitives = list(document, "meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
    primitives.map(of_primitive).max().unwrap_or(0)
}

/// Weights of a mesh or node that has `own` morph targets, and of one more.
fn with_weight(of: &Value, own: usize, lambda: f64) -> Value {
    let mut weights = list(of, "weights").to_vec();
    weights.resize(own, 0.0.into());
    weights.push(lambda.into());
    weights.into()
}

/// Adds what the vertices of a block get.
fn add<'a>(
    carrier: &Carrier,
    gltf: &Gltf,
    (block, split): (&'a Block, Option<Split<'a>>),
    buffer: &mut Buffer,
) -> Result<Added<'a>, GltfError> {
    let vertex_of = carrier.model.weld().vertex_of();
    let (mut normals, mut samples, mut moves, mut turns) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let unit = |n: DVec3| block.local_normal(n).try_normalize().unwrap_or(DVec3::Z);
    let copies = split.as_ref().map_or(&[][..], Split::copies);
    let vertices = || (0..block.values().len()).chain(copies.iter().map(|v| *v as usize));
    for k in vertices() {
        let source = block.values().start + k;
        let v = vertex_of[source] as usize;
        let normal =
            if carrier.normals[v] == Vec3::ZERO { Vec3::Z } else { unit(carrier.normals[v].as_dvec3()).as_vec3() };
        let denoised_normal = match carrier.denoised_normals[v] {
            DVec3::ZERO => normal,
            n => unit(n).as_vec3(),
        };
        normals.push(normal.to_array());
        samples.push(carrier.sample_at[source].map_or([0.0; 2], v_down));
        let stored = block.stored(gltf, k);
        let is_placed = carrier.model.data().unplaced().binary_search(&(source as u32)).is_err();
        let change = if is_placed { block.local(carrier.denoised[v]) - stored } else { DVec3::ZERO };
        moves.push(change.as_vec3().to_array());
        turns.push((denoised_normal - normal).to_array());
    }
    if [&normals, &moves].iter().any(|values| !values.as_flattened().iter().all(|x| x.is_finite())) {
        return Err(GltfError::NotFinite);
    }
    let target = json!({ "POSITION": buffer.attribute(&moves), "NORMAL": buffer.attribute(&turns) });
    let texel = |texels: &[Vec2], k: usize| v_down(texels[block.values().start + k]);
    let texels = |texels: &[Vec2]| buffer.attribute(&vertices().map(|k| texel(texels, k)).collect::<Vec<_>>());
    let vertex_texels = carrier.vertex_texels.map(texels);
    let unwrapped = split.as_ref().map(|split| buffer.attribute(&split.uvs()));
    let (normals, samples) = (buffer.attribute(&normals), buffer.attribute(&samples));
    Ok(Added { block, split, unwrapped, normals, samples, vertex_texels, target })
}
