//! The carrier as binary glTF 2.0: what the carrier OBJ holds, and the denoised surface as a morph target, so that
//! every viewer has λ as a slider.
//!
//! No extension that displaces is ratified, so the map travels in the file as `extras.planish` of each material says;
//! a client that reads it displaces at `TEXCOORD_1`, the others morph. <https://registry.khronos.org/glTF/specs/2.0>

mod glb;
mod materials;
mod wedges;

use crate::mesh::jagged::Index;
use crate::source::materials::Material;
use crate::source::model::Model;
use glam::{DVec3, Vec2, Vec3};
use materials::Materials;
use rayon::prelude::*;
use serde_json::{Map as Object, Value, json};
use wedges::Wedges;

pub use glb::TooLarge;

/// Name of the morph target.
pub const TARGET: &str = "denoised";

/// A mesh with its map.
#[derive(Clone, Debug)]
pub struct Carrier<'a> {
    /// Of the mesh.
    pub name: &'a str,
    /// The mesh that was baked.
    pub model: &'a Model,
    /// Unit normals along which the map displaces; zero where there is none. #V×3
    pub normals: &'a [Vec3],
    /// Where each source vertex samples the map, v up; none where it does not. #v×2
    pub places: &'a [Option<Vec2>],
    /// Positions at λ = 1, model units. #V×3
    pub denoised: &'a [DVec3],
    /// Unit normals there; zero where there is none. #V×3
    pub denoised_normals: &'a [DVec3],
    /// Subtracted from positions before they become single precision; the node moves them back. Model units
    pub origin: DVec3,
    /// Strength at first; finite.
    pub lambda: f64,
    /// Those of all libraries, in the order in which the file names them.
    pub materials: &'a [Material],
    /// The map.
    pub map: Map<'a>,
    /// What a client should know about the normal map: `extras.planish.normalMap` of each material.
    pub normal_map: Value,
}

/// A displacement map.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// The image file: a texture if it is a PNG, a view of the buffer if not.
    pub bytes: &'a [u8],
    /// How it is sampled.
    pub filter: Filter,
    /// What a client should know about it, its `file` among other things: `extras.planish.displacement` of each
    /// material, which gets `texture` or `bufferView`, `mimeType` and `texCoord` besides.
    pub entry: Object<String, Value>,
}

/// What is done between texel centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel: those of other vertices lie next to it.
    Nearest,
    /// Bilinear.
    Linear,
}

/// Gives the bytes of a texture by its name in the material library.
pub type Textures<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// Why there is no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GltfError {
    /// glTF allows neither infinity nor NaN.
    #[error("a position or normal is not a finite number in single precision, and glTF has no other")]
    NotFinite,
    /// As it says.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// Writes the surface of a carrier as a `.glb` file: one mesh with a primitive for each material that has faces.
/// `textures` that are PNG or JPEG files are embedded, others left out.
///
/// Vertices are the distinct pairs of source vertex and texture coordinates at corners of the triangles, in the order of
/// the source; positions are the welded ones. Texture coordinates have v down. `TEXCOORD_0` is (0, 0) where a corner names
/// none or some that are not finite, and the same as `TEXCOORD_1` where the mesh has none, because sets must be numbered from 0. Where
/// there is no normal it is +Z.
///
/// At weight 1 the target gives the denoised positions but for one rounding of single precision: differences are
/// taken from the rounded positions. A surface without faces becomes a scene with an empty node.
///
/// # Panics
/// If a list has not the length that it should have.
pub fn glb(carrier: &Carrier, textures: Textures) -> Result<Vec<u8>, GltfError> {
    let model = carrier.model;
    let vertices = model.surface().positions().len();
    assert_eq!(carrier.normals.len(), vertices, "one normal for each vertex");
    assert_eq!(carrier.denoised.len(), vertices, "one denoised position for each vertex");
    assert_eq!(carrier.denoised_normals.len(), vertices, "one denoised normal for each vertex");
    assert_eq!(carrier.places.len(), model.data().positions().len(), "one place for each source vertex");
    let wedges = Wedges::new(model);
    let triangles = wedges.triangles(model);
    // Per wedge four vectors and two texture coordinates, per triangle three indices.
    let expected = wedges.len() * 64 + triangles.items().len() * 12 + carrier.map.bytes.len();
    let mut buffer = glb::Buffer::with_capacity(expected);
    let mut node = json!({ "name": carrier.name });
    let mut document = Object::new();
    let generator = concat!("planish ", env!("CARGO_PKG_VERSION"));
    document.insert("asset".to_owned(), json!({ "version": "2.0", "generator": generator }));
    document.insert("scene".to_owned(), 0.into());
    document.insert("scenes".to_owned(), json!([{ "nodes": [0] }]));
    if !triangles.items().is_empty() {
        let (attributes, target) = attributes(carrier, &wedges, &mut buffer)?;
        let mut materials = Materials::new(&mut buffer, carrier, wedges.have_uvs().then_some(textures));
        let mut primitives = Vec::new();
        for (list, triangles) in (0..).zip(triangles.iter()).filter(|(_, triangles)| !triangles.is_empty()) {
            let material = Index::checked_sub(list, 1);
            primitives.push(json!({
                "attributes": attributes,
                "indices": buffer.indices(triangles, wedges.len()),
                "material": materials.add(&mut buffer, material),
                "targets": [target],
            }));
        }
        node["mesh"] = 0.into();
        if carrier.origin != DVec3::ZERO {
            node["translation"] = json!(carrier.origin.to_array());
        }
        let mesh = json!({
            "name": carrier.name, "primitives": primitives, "weights": [carrier.lambda],
            "extras": { "targetNames": [TARGET] },
        });
        document.insert("meshes".to_owned(), json!([mesh]));
        materials.insert_into(&mut document);
    }
    document.insert("nodes".to_owned(), json!([node]));
    Ok(buffer.finish(document)?)
}

/// The accessors of the vertices and of the morph target.
fn attributes(carrier: &Carrier, wedges: &Wedges, buffer: &mut glb::Buffer) -> Result<(Value, Value), GltfError> {
    let model = carrier.model;
    let vertex_of = model.weld().vertex_of();
    let of_vertex = |source: &Index| vertex_of[*source as usize] as usize;
    let near = |p: DVec3| p - carrier.origin;
    let position = |v: usize| near(model.surface().positions()[v]).as_vec3();
    let towards = |v: usize| (near(carrier.denoised[v]) - position(v).as_dvec3()).as_vec3();
    let normal = |v: usize| if carrier.normals[v] == Vec3::ZERO { Vec3::Z } else { carrier.normals[v] };
    let turn = |v: usize| match carrier.denoised_normals[v] {
        DVec3::ZERO => Vec3::ZERO,
        denoised => (denoised - normal(v).as_dvec3()).as_vec3(),
    };
    let mut vectors = |of: &(dyn Fn(usize) -> Vec3 + Sync)| {
        let values: Vec<[f32; 3]> = wedges.sources.par_iter().map(|source| of(of_vertex(source)).to_array()).collect();
        let finite = values.as_flattened().par_iter().all(|x| x.is_finite());
        if finite { Ok(buffer.attribute(&values)) } else { Err(GltfError::NotFinite) }
    };
    let (position, normal) = (vectors(&position)?, vectors(&normal)?);
    let target = json!({ "POSITION": vectors(&towards)?, "NORMAL": vectors(&turn)? });

    let place = |source: &Index| carrier.places[*source as usize].map_or(Vec2::ZERO, |p| Vec2::new(p.x, 1.0 - p.y));
    let places = buffer.attribute(&wedges.sources.par_iter().map(|source| finite(place(source))).collect::<Vec<_>>());
    let uv = |vt: Index| {
        let uv = model.data().uvs()[vt as usize];
        finite(Vec2::new(uv.x as f32, (1.0 - uv.y) as f32))
    };
    let uvs = if wedges.have_uvs() {
        buffer.attribute(&wedges.uvs.par_iter().map(|vt| vt.map_or([0.0; 2], uv)).collect::<Vec<_>>())
    } else {
        places
    };
    let attributes = json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uvs, "TEXCOORD_1": places });
    Ok((attributes, target))
}

fn finite(uv: Vec2) -> [f32; 2] {
    if uv.is_finite() { uv.to_array() } else { [0.0; 2] }
}

#[cfg(test)]
mod tests;
