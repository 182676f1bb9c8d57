//! Materials of a glTF file, with their textures and images.

use super::document::{Document, Entry, entries};
use super::glb::Buffer;
use super::wedges::{Group, Sides};
use super::{Carrier, Filter, Map, Picture, ShadingMap, Textures};
use crate::map::displacement::MapKind;
use crate::map::manifest::Layout;
use crate::map::pages::Part;
use crate::mesh::jagged::Index;
use crate::source::gltf::percent_decoded;
use crate::source::materials::{CARRIER_MATERIAL, Material};
use rustc_hash::FxHashMap;
use serde_json::{Map as Object, Value, json};

mod properties;

/// Base colour of materials without one, as for [`CARRIER_MATERIAL`] in material libraries.
const GREY: [f32; 3] = [0.8; 3];
const ROUGHNESS: f64 = 0.8;

const CLAMP_TO_EDGE: u32 = 33071;

/// Number that is no page's.
const ANY_PAGE: Index = Index::MAX;

/// Media type of an image file, by its first bytes.
pub(super) fn media_type(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xff, 0xd8, 0xff, ..] => "image/jpeg",
        [0x76, 0x2f, 0x31, 0x01, ..] => "image/x-exr",
        [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => "image/tiff",
        _ => "application/octet-stream",
    }
}

/// Sampler with a filter, which goes on beyond the unit square as at its border.
fn sampler(filter: Filter) -> Value {
    let filter = match filter {
        Filter::Nearest => 9728,
        Filter::Linear => 9729,
    };
    json!({ "magFilter": filter, "minFilter": filter, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE })
}

/// True if glTF allows textures of this media type.
fn is_texture(media_type: &str) -> bool {
    matches!(media_type, "image/png" | "image/jpeg")
}

/// Sets of texture coordinates of a document.
#[derive(Clone, Copy)]
pub(super) struct Sets {
    /// Set at which the displacement map is sampled.
    pub(super) samples: usize,
    /// Set at which shading maps with one texel for each source vertex are sampled.
    pub(super) vertices: usize,
    /// Set of the texture coordinates that were made for the maps; `None` if these lie in those of the document.
    pub(super) unwrapped: Option<usize>,
}

impl Sets {
    /// The sets of planish beside one set of the mesh, with which it may share the texture coordinates that were made for the maps.
    fn beside_one(carrier: &Carrier) -> Self {
        Self { samples: 1, vertices: 1 + usize::from(carrier.vertex_texels.is_some()), unwrapped: None }
    }
    /// The sets of planish from a free one of a document on.
    pub(super) fn from(free: usize, carrier: &Carrier) -> Self {
        let unwrapped = carrier.original.map(|_| free);
        // A document without texture coordinates has a set 0 all the same.
        let samples = unwrapped.map_or(free.max(1), |set| set + 1);
        Self { samples, vertices: samples + usize::from(carrier.vertex_texels.is_some()), unwrapped }
    }
}

/// Lists of materials, textures, images and samplers of a document.
pub(super) struct Materials<'a> {
    carrier: &'a Carrier<'a>,
    /// Texture files; `None` if the mesh has no texture coordinates.
    files: Option<Textures<'a>>,
    /// Description of the maps of each page, which the materials of the page repeat.
    extras: Vec<Value>,
    /// Index of the texture with ambient occlusion, if it lies in the texture coordinates of the mesh.
    occlusion: Option<usize>,
    materials: Vec<Entry>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    /// Sets of texture coordinates at which the maps of planish are sampled.
    sets: Sets,
    /// Materials of the document that describe the maps, by their index in the source, `None` for the default one, and the page.
    described: FxHashMap<(Option<usize>, Index), usize>,
    /// Textures by their pictures; `None` if there is none or glTF does not allow its type.
    known: FxHashMap<Picture<'a>, Option<usize>>,
    /// Materials of the libraries by their name; if several define one, the first counts.
    defined: FxHashMap<&'a str, &'a Material>,
}

/// Description of the maps for faces whose normals are turned round: heights have the opposite sign. Vectors in object space stay. What
/// cannot be said in other numbers is left out: vectors in tangent space and maps of shading.
fn turned(extras: &Value) -> Value {
    let mut map = extras["displacement"].clone();
    if map["map"] == json!(MapKind::VectorTangent) {
        return json!({});
    }
    if map["map"] != json!(MapKind::VectorObject) {
        for number in ["bias", "scale"] {
            if let Some(value) = map[number].as_f64() {
                map[number] = (-value).into();
            }
        }
    }
    json!({ "displacement": map })
}

impl<'a> Materials<'a> {
    /// Adds the displacement map, but no materials yet.
    pub(super) fn new(buffer: &mut Buffer, carrier: &'a Carrier, files: Option<Textures<'a>>) -> Self {
        let mut new = Self { files, ..Self::empty(carrier, Sets::beside_one(carrier)) };
        for material in carrier.materials {
            new.defined.entry(material.name.as_str()).or_insert(material);
        }
        new.add_maps(buffer);
        new
    }

    /// Adds the displacement map to the lists of a document, at sets of texture coordinates that it does not have.
    pub(super) fn continuing(
        buffer: &mut Buffer,
        carrier: &'a Carrier,
        document: &mut Object<String, Value>,
        sets: Sets,
    ) -> Self {
        let mut take = |name: &str| match document.remove(name) {
            Some(Value::Array(list)) => list,
            _ => Vec::new(),
        };
        let (materials, textures) = (take("materials"), take("textures"));
        let (images, samplers) = (take("images"), take("samplers"));
        let materials = entries(materials);
        let mut new = Self { materials, textures, images, samplers, ..Self::empty(carrier, sets) };
        new.add_maps(buffer);
        new
    }

    /// Lists without any entry.
    fn empty(carrier: &'a Carrier, sets: Sets) -> Self {
        Self {
            carrier,
            files: None,
            extras: Vec::new(),
            occlusion: None,
            materials: Vec::new(),
            textures: Vec::new(),
            images: Vec::new(),
            samplers: Vec::new(),
            sets,
            described: FxHashMap::default(),
            known: FxHashMap::default(),
            defined: FxHashMap::default(),
        }
    }

    /// Describes the maps of a page in a material of the document, or in a new one for `None`, and returns its index. The first page
    /// of a material is described in itself, each other one in a copy.
    pub(super) fn describe(&mut self, material: Option<usize>, page: Index) -> usize {
        if let Some(known) = self.described.get(&(material, page)) {
            return *known;
        }
        let first = self.described.get(&(material, ANY_PAGE)).copied();
        let entry = match (first, material) {
            (Some(first), _) => {
                let mut copy = self.materials[first].value();
                self.rename(&mut copy, page);
                self.materials.push(Entry::of(&copy));
                self.materials.len() - 1
            }
            (None, Some(material)) => material,
            (None, None) => {
                self.materials.push(Entry::of(&json!({ "name": CARRIER_MATERIAL })));
                self.materials.len() - 1
            }
        };
        self.described.entry((material, ANY_PAGE)).or_insert(entry);
        self.described.insert((material, page), entry);
        self.describe_in(entry, page);
        entry
    }

    /// Gives a copy of a material the name of its page in addition.
    fn rename(&self, copy: &mut Value, page: Index) {
        let part = self.carrier.pages.as_ref().map(|pages| &pages.of_faces.parts()[page as usize]);
        if let (Some(part), Some(name)) = (part, copy["name"].as_str()) {
            copy["name"] = format!("{name}.{part}").into();
        }
    }

    /// Describes the maps of a page in a material.
    fn describe_in(&mut self, material: usize, page: Index) {
        let mut entry = self.materials[material].value();
        if !entry.is_object() {
            entry = json!({});
        }
        if !entry["extras"].is_object() {
            entry["extras"] = json!({});
        }
        let of_colours = entry["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"].as_u64().unwrap_or(0);
        let own_set = self.sets.unwrapped.map_or(of_colours, |set| set as u64);
        let mut extras = self.extras[page as usize].clone();
        if own_set != 0 {
            for name in ["normalMap", "occlusion", "curvature"] {
                if let Some(map) = extras.get_mut(name).and_then(Value::as_object_mut) {
                    map.entry("texCoord").or_insert(own_set.into());
                }
            }
        }
        entry["extras"]["planish"] = extras;
        // A map that the artist made stays.
        if let Some(texture) = self.occlusion.filter(|_| entry["occlusionTexture"].is_null()) {
            entry["occlusionTexture"] = json!({ "index": texture, "texCoord": own_set });
        }
        self.materials[material] = Entry::of(&entry);
    }

    /// Takes the files of images into the buffer, as far as `files` has them; the others keep their names, from the folder of
    /// the carrier, by `relocate`.
    pub(super) fn embed_images(&mut self, buffer: &mut Buffer, files: Textures, relocate: &dyn Fn(&str) -> String) {
        for image in &mut self.images {
            let Some(uri) = image["uri"].as_str().filter(|uri| !uri.starts_with("data:")) else { continue };
            let path = percent_decoded(uri);
            match files(Picture::File(&path)) {
                Some(bytes) => {
                    let mut entry = Object::new();
                    entry.insert("mimeType".to_owned(), media_type(&bytes).into());
                    entry.insert("bufferView".to_owned(), buffer.file(&bytes).into());
                    entry.insert("name".to_owned(), image.get("name").cloned().unwrap_or_else(|| path.into()));
                    if let Some(old) = image.as_object_mut() {
                        old.remove("uri");
                        old.extend(entry);
                    }
                }
                None => image["uri"] = relocate(&path).into(),
            }
        }
    }

    /// Adds all maps of the carrier, and describes them.
    fn add_maps(&mut self, buffer: &mut Buffer) {
        let carrier = self.carrier;
        let one = [(carrier.map.clone(), carrier.normal_map.clone())];
        for (map, normal_map) in carrier.pages.as_ref().map_or(&one[..], |pages| &pages.maps) {
            let displacement = self.displacement(buffer, map);
            self.extras.push(json!({ "displacement": displacement, "normalMap": normal_map }));
        }
        for (name, map) in [("occlusion", &carrier.occlusion), ("curvature", &carrier.curvature)] {
            let Some(map) = map else { continue };
            let (texture, description) = self.shading(buffer, map);
            self.extras.iter_mut().for_each(|extras| extras[name] = description.clone());
            if name == "occlusion" && map.layout == Layout::Uv {
                self.occlusion = Some(texture);
            }
        }
    }

    /// Adds a map of shading and returns the index of its texture and its description. Where it has a texel for each vertex, it is
    /// sampled at a set of its own; else at the texture coordinates of the mesh.
    fn shading(&mut self, buffer: &mut Buffer, map: &ShadingMap) -> (usize, Value) {
        let name = map.entry.get("file").and_then(Value::as_str).unwrap_or("shading");
        let image = self.image(buffer, name, map.bytes);
        let mut entry = Object::new();
        let texture = if map.layout == Layout::Vertex {
            self.samplers.push(sampler(Filter::Nearest));
            entry.insert("texCoord".to_owned(), self.sets.vertices.into());
            self.texture(json!({ "sampler": self.samplers.len() - 1, "source": image }))
        } else {
            self.texture(json!({ "source": image }))
        };
        entry.insert("texture".to_owned(), texture.into());
        entry.insert("mimeType".to_owned(), media_type(map.bytes).into());
        entry.extend(map.entry.clone());
        (texture, entry.into())
    }

    /// Adds an image of the displacement map and returns its description.
    fn displacement(&mut self, buffer: &mut Buffer, map: &Map) -> Value {
        let media_type = media_type(map.bytes);
        let mut entry = Object::new();
        if is_texture(media_type) {
            self.samplers.push(sampler(map.filter));
            let name = map.entry.get("file").and_then(Value::as_str).unwrap_or("displacement");
            let image = self.image(buffer, name, map.bytes);
            entry.insert(
                "texture".to_owned(),
                self.texture(json!({ "sampler": self.samplers.len() - 1, "source": image })).into(),
            );
        } else {
            entry.insert("bufferView".to_owned(), buffer.file(map.bytes).into());
        }
        entry.insert("mimeType".to_owned(), media_type.into());
        entry.insert("texCoord".to_owned(), self.sets.samples.into());
        entry.extend(map.entry.clone());
        entry.into()
    }
    /// Adds an image and returns its index.
    fn image(&mut self, buffer: &mut Buffer, name: &str, bytes: &[u8]) -> usize {
        let view = buffer.file(bytes);
        self.images.push(json!({ "name": name, "bufferView": view, "mimeType": media_type(bytes) }));
        self.images.len() - 1
    }
    /// Adds a texture and returns its index.
    fn texture(&mut self, texture: Value) -> usize {
        self.textures.push(texture);
        self.textures.len() - 1
    }
    /// Index of the texture of a picture; `None` if it cannot be used.
    fn picture(&mut self, buffer: &mut Buffer, picture: Picture<'a>) -> Option<usize> {
        if let Some(texture) = self.known.get(&picture) {
            return *texture;
        }
        let bytes = self.files?(picture).filter(|bytes| is_texture(media_type(bytes)));
        let texture = bytes.map(|bytes| {
            let image = self.image(buffer, &picture.name(), &bytes);
            self.texture(json!({ "source": image }))
        });
        self.known.insert(picture, texture);
        texture
    }

    /// Adds the material of a group of triangles, which is the default material where the mesh has none, and returns its index.
    pub(super) fn add(&mut self, buffer: &mut Buffer, group: &Group) -> usize {
        let Group { page, material, sides, .. } = *group;
        let names = &self.carrier.model.data().materials();
        let name = material.map_or(CARRIER_MATERIAL.into(), |m| String::from_utf8_lossy(&names[m as usize]));
        let found = material.and_then(|_| self.defined.get(name.as_ref()).copied());
        let part = self.carrier.pages.as_ref().map(|pages| &pages.of_faces.parts()[page as usize]);
        // One material of the mesh may be on several tiles.
        let name = match part {
            Some(Part::Tile(tile)) => format!("{name}.{tile}").into(),
            _ => name,
        };
        let mut entry = Object::from_iter([("name".to_owned(), name.into())]);
        entry.extend(self.properties(buffer, found));
        let mut entry = Value::from(entry);
        entry["doubleSided"] = (sides == Sides::Both).into();
        // Maps of shading hold the front where a back shares its texels, and nothing where it has others.
        if let Some(texture) = self.occlusion.filter(|_| sides != Sides::OneTurned) {
            entry["occlusionTexture"] = json!({ "index": texture });
        }
        // The normal map is described, not attached as `normalTexture`: it changes the normals to those of the denoised
        // surface, which the morph target does as well, and together they would do it twice.
        let extras = &self.extras[page as usize];
        entry["extras"] = json!({ "planish": if sides == Sides::OneTurned { turned(extras) } else { extras.clone() } });
        self.materials.push(Entry::of(&entry));
        self.materials.len() - 1
    }

    /// Adds the lists to a document.
    pub(super) fn insert_into(self, document: &mut Document) {
        document.insert_list("materials", self.materials);
        document.insert_list("textures", entries(self.textures));
        document.insert_list("images", entries(self.images));
        document.insert_list("samplers", entries(self.samplers));
    }
}
