//! Carrier as binary glTF 2.0: the mesh of the carrier OBJ, and the denoised surface as a morph target, so that every
//! viewer shows λ as a slider.
//!
//! No ratified extension displaces vertices, so the file holds the map as data, and `extras.planish` of each material
//! describes it. A client that reads these extras displaces at `TEXCOORD_1`; other clients morph.
//! <https://registry.khronos.org/glTF/specs/2.0>
//!
//! ```
//! use planish_geometry::bake::{self, BakeSettings, BundleNames, SideFiles, gltf};
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let names = BundleNames { source: "tent.obj".into(), stem: "tent".into(), carrier: "tent".into() };
//! let settings = BakeSettings { target: Denoiser::named("laplacian").unwrap().into(), ..BakeSettings::default() };
//! let bundle = bake::bake(&model, &names, SideFiles::NONE, &settings, &Silent)?;
//!
//! let carrier = bundle.files.iter().find(|file| file.name == "tent.glb").expect("a carrier");
//! // The JSON stands behind 20 bytes of headers, the last eight of which are its length and its type.
//! let length = u32::from_le_bytes(carrier.bytes[12..16].try_into()?) as usize;
//! let document: serde_json::Value = serde_json::from_slice(&carrier.bytes[20..20 + length])?;
//! assert_eq!(document["meshes"][0]["extras"]["targetNames"][0], gltf::TARGET);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod document;
mod glb;
mod kept;
mod materials;
mod split;
mod wedges;

use crate::map::manifest::Layout;
use crate::map::pages;
use crate::mesh::jagged::Index;
use crate::source::Source;
use crate::source::backs::Backs;
use crate::source::colours;
use crate::source::materials::Material;
use crate::source::model::Model;
use document::{Document, Entry};
use glam::{DVec3, Vec2, Vec3};
use materials::Materials;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde_json::{Map as Object, Value, json};
use wedges::Wedges;

pub use glb::TooLarge;

/// Name of the morph target in the file.
pub const TARGET: &str = "denoised";

/// A baked mesh with its displacement map, to be written as glTF.
#[derive(Clone)]
pub struct Carrier<'a> {
    /// Name of the mesh and its node.
    pub name: &'a str,
    /// Model that was baked.
    pub model: &'a Model,
    /// Backs of the mesh. The surface of the model has those with a side of their own.
    pub backs: &'a Backs,
    /// Model before it got new texture coordinates for the map; `None` if it has its own.
    pub original: Option<&'a Model>,
    /// Unit normals that the map displaces along; zero where there is none. #V×3
    pub normals: &'a [Vec3],
    /// Texture coordinates at which each source vertex samples the map, v up; `None` if it is not displaced. #v×2
    pub sample_at: &'a [Option<Vec2>],
    /// Texture coordinates of the texels that source vertices have in shading maps of [`Layout::Vertex`], v up; `None` if there is no
    /// such map, or if `sample_at` has them. #v×2
    pub vertex_texels: Option<&'a [Vec2]>,
    /// Positions at λ = 1. #V×3, model units
    pub denoised: &'a [DVec3],
    /// Unit normals of the denoised surface; zero where there is none. #V×3
    pub denoised_normals: &'a [DVec3],
    /// Point that is subtracted from positions before they become single precision, and added again by the node. Model units
    pub origin: DVec3,
    /// Initial weight of the morph target; finite.
    pub lambda: f64,
    /// Materials of all libraries, in the order in which the mesh names them.
    pub materials: &'a [Material],
    /// Displacement map; with pages, the first of them.
    pub map: Map<'a>,
    /// Pages of the map; `None` if it has one image.
    pub pages: Option<Pages<'a>>,
    /// Function that turns the path of a texture into one from the folder of the carrier.
    pub relocate: &'a (dyn Fn(&str) -> String + Sync),
    /// Description of the normal map for clients, as `extras.planish.normalMap` of each material, with `texCoord` where the mesh's
    /// own texture coordinates are not the set 0.
    pub normal_map: Value,
    /// Ambient occlusion map, which becomes the `occlusionTexture` of each material if it lies in the texture coordinates of the
    /// mesh.
    pub occlusion: Option<ShadingMap<'a>>,
    /// Curvature map.
    pub curvature: Option<ShadingMap<'a>>,
}

/// Pages of a displacement map. Each becomes primitives of its own, because a primitive has one texture.
#[derive(Clone)]
pub struct Pages<'a> {
    /// Page of each face.
    pub of_faces: &'a pages::Pages,
    /// Images of the pages, each with the description of its normal map.
    pub maps: Vec<(Map<'a>, Value)>,
    /// Texture coordinates, v up, at which a source vertex samples a page that is not its own, by page and source vertex.
    pub copies: FxHashMap<[Index; 2], Vec2>,
}

/// A map of the shading of the denoised surface as an image file, with its description.
#[derive(Clone, Debug)]
pub struct ShadingMap<'a> {
    /// Image file: PNG.
    pub bytes: &'a [u8],
    /// Layout of the image.
    pub layout: Layout,
    /// Description of the map for clients, its name `file` included. It becomes `extras.planish.occlusion` or `curvature` of each
    /// material, together with `texture`, `mimeType` and `texCoord`, which is left out for the set 0 as in glTF.
    pub entry: Object<String, Value>,
}

/// A displacement map as an image file, with its description.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// Image file: PNG becomes a texture, other formats a view of the buffer.
    pub bytes: &'a [u8],
    /// Filter between texel centres.
    pub filter: Filter,
    /// Description of the map for clients, its name `file` included. It becomes `extras.planish.displacement` of each
    /// material, together with `texture` or `bufferView`, `mimeType` and `texCoord`.
    pub entry: Object<String, Value>,
}

/// Texture filter between texel centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Nearest texel, for layouts whose neighbouring texels belong to unrelated vertices.
    Nearest,
    /// Bilinear interpolation.
    Linear,
}

/// Returns whether the carrier of a mesh keeps the document that it came as, with all that the file has. A mesh of another format has
/// none, and a document cannot be kept if an animation gives weights to morph targets, as it would have too few.
pub fn keeps_document(source: &Source) -> bool {
    match source {
        Source::Gltf(file) => kept::is_possible(file),
        _ => false,
    }
}

/// A picture of a material, by the names of its files in the material library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Picture<'a> {
    /// The picture of a file.
    File(&'a str),
    /// Roughness as green and metalness as blue, each from the greys of a file; 1 where there is none. One of them is there.
    MetallicRoughness {
        /// File of the roughness (`map_Pr`).
        roughness: Option<&'a str>,
        /// File of the metalness (`map_Pm`).
        metallic: Option<&'a str>,
    },
    /// Colours with the opacity as alpha; white where there are no colours.
    ColourWithOpacity {
        /// File of the colours (`map_Kd`).
        colour: Option<&'a str>,
        /// File of the opacity (`map_d`): its alpha channel, or its greys if it has none.
        opacity: &'a str,
    },
}

impl Picture<'_> {
    /// Names of the files that it is made of.
    fn name(&self) -> String {
        let files = match *self {
            Self::File(file) => [Some(file), None],
            Self::MetallicRoughness { roughness, metallic } => [roughness, metallic],
            Self::ColourWithOpacity { colour, opacity } => [colour, Some(opacity)],
        };
        Vec::from_iter(files.into_iter().flatten()).join(" + ")
    }
}

/// Function that gives the bytes of a picture; `None` if there is none.
pub type Textures<'a> = &'a dyn Fn(Picture) -> Option<Vec<u8>>;

/// Reasons why a glTF file cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// A position or normal is not finite in single precision, and glTF allows neither infinity nor NaN.
    #[error("a position or normal is too large for single precision or not finite, and glTF cannot hold it")]
    NotFinite,
    /// A mesh that came as glTF has vertices that would have to be split at the seams of new texture coordinates, but an attribute of
    /// them cannot be read.
    #[error("accessor {accessor} cannot be read, so that vertices with its values cannot be split at seams")]
    Attribute {
        /// Index of the accessor in the document.
        accessor: usize,
    },
    /// The file would be longer than 4 GiB.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// Writes the surface of a carrier as a `.glb` file: one mesh with a primitive for each page and material that have faces.
/// Textures that are PNG or JPEG files are embedded, others are left out.
///
/// A model that came as glTF keeps its document, if [`keeps_document`] says so: the vertices get the normals, samples and target in
/// addition, and a primitive on several pages becomes one for each. New texture coordinates become a set of their own, and vertices are
/// split where these are cut.
///
/// Every face that the mesh draws is there: a back that the surface of the model lacks has the normals of its front turned round, and its
/// material describes the map with the opposite heights. Materials of faces with a back, and of backs, are not double-sided.
///
/// Vertices are the distinct pairs of source vertex and texture coordinates at corners of the triangles, in the order of
/// the source; positions are the welded ones. Texture coordinates have v down. `TEXCOORD_0` is (0, 0) where a corner names
/// no texture coordinates or some that are not finite. `COLOR_0` has the colours of the source vertices, linear, if they have some. If the mesh has none at all, `TEXCOORD_0` equals `TEXCOORD_1`, because
/// glTF numbers sets from 0. A vertex without a normal gets +Z.
///
/// At weight 1 the target gives the denoised positions but for one rounding of single precision: differences are
/// taken from the rounded positions. A surface without faces becomes a scene with an empty node.
///
/// # Errors
/// If a number is not finite in single precision, if an attribute of vertices that have to be split cannot be read, or if the file
/// would be longer than 4 GiB.
///
/// # Panics
/// If a list has not the length that its field states.
pub fn glb(carrier: &Carrier, textures: Textures) -> Result<Vec<u8>, GltfError> {
    let model = carrier.model;
    if let Source::Gltf(file) = carrier.original.unwrap_or(model).source()
        && let Some(kept) = kept::glb(carrier, file, textures)?
    {
        return Ok(kept);
    }
    let vertices = model.surface().positions().len();
    assert_eq!(carrier.normals.len(), vertices, "one normal for each vertex");
    assert_eq!(carrier.denoised.len(), vertices, "one denoised position for each vertex");
    assert_eq!(carrier.denoised_normals.len(), vertices, "one denoised normal for each vertex");
    assert_eq!(carrier.sample_at.len(), model.data().positions().len(), "one sample for each source vertex");
    let page_of = |face: Index| carrier.pages.as_ref().map_or(0, |pages| pages.of_faces.of_face(face));
    let wedges = Wedges::new(model, carrier.backs, &page_of);
    // Each wedge takes four vectors and two texture coordinates, each triangle three indices.
    let expected = wedges.len() * 64 + wedges.triangle_count() * 12 + carrier.map.bytes.len();
    let mut buffer = glb::Buffer::with_capacity(expected);
    let mut node = json!({ "name": carrier.name });
    let mut document = Document::default();
    let generator = concat!("planish ", env!("CARGO_PKG_VERSION"));
    document.insert("asset", json!({ "version": "2.0", "generator": generator }));
    document.insert("scene", 0.into());
    document.insert("scenes", json!([{ "nodes": [0] }]));
    if wedges.triangle_count() > 0 {
        let (attributes, target) = attributes(carrier, &wedges, &mut buffer)?;
        let mut materials = Materials::new(&mut buffer, carrier, wedges.have_uvs().then_some(textures));
        let mut primitives = Vec::new();
        for group in wedges.groups() {
            primitives.push(Entry::of(&json!({
                "attributes": attributes,
                "indices": buffer.indices(group.triangles, wedges.len()),
                "material": materials.add(&mut buffer, &group),
                "targets": [target],
            })));
        }
        node["mesh"] = 0.into();
        if carrier.origin != DVec3::ZERO {
            node["translation"] = json!(carrier.origin.to_array());
        }
        let mesh = Mesh {
            name: carrier.name,
            primitives,
            weights: [carrier.lambda],
            extras: json!({ "targetNames": [TARGET] }),
        };
        document.insert_list("meshes", vec![Entry::of(&mesh)]);
        materials.insert_into(&mut document);
    }
    document.insert("nodes", json!([node]));
    Ok(buffer.finish(document)?)
}

/// The mesh of a document that planish makes.
#[derive(Serialize)]
struct Mesh<'a> {
    name: &'a str,
    primitives: Vec<Entry>,
    weights: [f64; 1],
    extras: Value,
}

/// Accessors of the vertex attributes and of the morph target.
fn attributes(carrier: &Carrier, wedges: &Wedges, buffer: &mut glb::Buffer) -> Result<(Value, Value), GltfError> {
    let model = carrier.model;
    let vertex_of = model.weld().vertex_of();
    let from_origin = |p: DVec3| p - carrier.origin;
    let position = |v: usize| from_origin(model.surface().positions()[v]).as_vec3();
    let position_change = |v: usize| (from_origin(carrier.denoised[v]) - position(v).as_dvec3()).as_vec3();
    let normal = |v: usize| if carrier.normals[v] == Vec3::ZERO { Vec3::Z } else { carrier.normals[v] };
    let normal_change = |v: usize| match carrier.denoised_normals[v] {
        DVec3::ZERO => Vec3::ZERO,
        denoised => (denoised - normal(v).as_dvec3()).as_vec3(),
    };
    // Points are those of the vertex, normals may be turned.
    let mut vectors = |of: &(dyn Fn(usize) -> Vec3 + Sync), are_normals: bool| {
        let value = |(source, is_turned): (&Index, &bool)| {
            let value = of(vertex_of[*source as usize] as usize);
            (if are_normals && *is_turned { -value } else { value }).to_array()
        };
        let values: Vec<[f32; 3]> = wedges.sources.par_iter().zip(&wedges.is_turned).map(value).collect();
        let finite = values.as_flattened().par_iter().all(|x| x.is_finite());
        if finite { Ok(buffer.attribute(&values)) } else { Err(GltfError::NotFinite) }
    };
    let (position, normal) = (vectors(&position, false)?, vectors(&normal, true)?);
    let target = json!({ "POSITION": vectors(&position_change, false)?, "NORMAL": vectors(&normal_change, true)? });

    let sample_at = |(source, page): (&Index, &Index)| {
        let copy = carrier.pages.as_ref().and_then(|pages| pages.copies.get(&[*page, *source]).copied());
        copy.or(carrier.sample_at[*source as usize]).map_or([0.0; 2], v_down)
    };
    let sources = wedges.sources.par_iter().zip(&wedges.pages);
    let samples = buffer.attribute(&sources.map(sample_at).collect::<Vec<_>>());
    let texels = carrier.vertex_texels.map(|texels| {
        let values = wedges.sources.par_iter().map(|source| v_down(texels[*source as usize]));
        buffer.attribute(&values.collect::<Vec<_>>())
    });
    let uv = |vt: Index| {
        let uv = model.data().uvs()[vt as usize];
        finite(Vec2::new(uv.x as f32, (1.0 - uv.y) as f32))
    };
    let uvs = if wedges.have_uvs() {
        buffer.attribute(&wedges.uvs.par_iter().map(|vt| vt.map_or([0.0; 2], uv)).collect::<Vec<_>>())
    } else {
        samples
    };
    let mut attributes = json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uvs, "TEXCOORD_1": samples });
    if let Some(texels) = texels {
        attributes["TEXCOORD_2"] = texels.into();
    }
    if !model.data().colours().is_empty() {
        let colour = |source: &Index| model.data().colours()[*source as usize].map(colours::to_linear);
        attributes["COLOR_0"] = buffer.attribute(&wedges.sources.par_iter().map(colour).collect::<Vec<_>>()).into();
    }
    Ok((attributes, target))
}

/// Texture coordinates with v down for some with v up, or (0, 0) if they are not finite.
fn v_down(uv: Vec2) -> [f32; 2] {
    if uv.is_finite() { [uv.x, 1.0 - uv.y] } else { [0.0; 2] }
}

/// Texture coordinates, or (0, 0) if they are not finite.
fn finite(uv: Vec2) -> [f32; 2] {
    if uv.is_finite() { uv.to_array() } else { [0.0; 2] }
}

#[cfg(test)]
mod tests;
