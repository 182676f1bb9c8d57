//! Properties of a material of a library in the terms of glTF: metalness and roughness, emission, opacity and normals.

use super::{Buffer, GREY, Materials, ROUGHNESS};
use crate::bake::gltf::Picture;
use crate::source::materials::Material;
use serde_json::{Map as Object, Value, json};

impl<'a> Materials<'a> {
    /// Entry of a material of a library, or of grey for `None`, without name.
    pub(super) fn properties(&mut self, buffer: &mut Buffer, material: Option<&'a Material>) -> Object<String, Value> {
        let Some(material) = material else {
            let [r, g, b] = GREY;
            let grey =
                json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS });
            return Object::from_iter([("pbrMetallicRoughness".to_owned(), grey)]);
        };
        let mut entry = Object::new();
        let colours = self.colours(buffer, material, &mut entry);
        let default = if material.diffuse_texture.is_some() && colours.is_some() { [1.0; 3] } else { GREY };
        let [r, g, b] = colour(material.diffuse).unwrap_or(default).map(|x| x.clamp(0.0, 1.0));
        let [roughness, metallic] = [&material.roughness_texture, &material.metallic_texture].map(Option::as_deref);
        let has_picture = roughness.is_some() || metallic.is_some();
        let picture = has_picture.then_some(Picture::MetallicRoughness { roughness, metallic });
        let surface = picture.and_then(|picture| self.picture(buffer, picture));
        // A picture counts in place of the number.
        let factor = |file: Option<&str>, number: Option<f32>, default: f64| match number.filter(|x| x.is_finite()) {
            _ if file.is_some() && surface.is_some() => 1.0,
            Some(number) => f64::from(number.clamp(0.0, 1.0)),
            None => default,
        };
        let mut shading = json!({
            "baseColorFactor": [r, g, b, 1.0],
            "metallicFactor": factor(metallic, material.metallic, 0.0),
            "roughnessFactor": factor(roughness, material.roughness, ROUGHNESS),
        });
        if let Some(texture) = colours {
            shading["baseColorTexture"] = json!({ "index": texture });
        }
        if let Some(texture) = surface {
            shading["metallicRoughnessTexture"] = json!({ "index": texture });
        }
        entry.insert("pbrMetallicRoughness".to_owned(), shading);
        self.add_emission(buffer, material, &mut entry);
        // Heights of bumps have no place in glTF.
        let normals = material.normal_texture.as_deref();
        if let Some(texture) = normals.and_then(|file| self.picture(buffer, Picture::File(file))) {
            entry.insert("normalTexture".to_owned(), json!({ "index": texture }));
        }
        entry
    }

    /// Texture of the colours, with the opacity as alpha. What is less than half opaque is cut out: blending would need an order of
    /// drawing, and leaves and hair have none.
    fn colours(
        &mut self,
        buffer: &mut Buffer,
        material: &'a Material,
        entry: &mut Object<String, Value>,
    ) -> Option<usize> {
        let [colour, opacity] = [&material.diffuse_texture, &material.opacity_texture].map(Option::as_deref);
        let together = match (colour, opacity) {
            (Some(colour), Some(opacity)) if colour == opacity => Some(Picture::File(colour)),
            (colour, Some(opacity)) => Some(Picture::ColourWithOpacity { colour, opacity }),
            (_, None) => None,
        };
        if let Some(texture) = together.and_then(|picture| self.picture(buffer, picture)) {
            entry.insert("alphaMode".to_owned(), "MASK".into());
            return Some(texture);
        }
        colour.and_then(|file| self.picture(buffer, Picture::File(file)))
    }

    fn add_emission(&mut self, buffer: &mut Buffer, material: &'a Material, entry: &mut Object<String, Value>) {
        let file = material.emission_texture.as_deref();
        let texture = file.and_then(|file| self.picture(buffer, Picture::File(file)));
        let glowing = colour(material.emission).map(|c| c.map(|x| x.max(0.0))).filter(|c| *c != [0.0; 3]);
        // Exporters write black beside a texture, which is not meant to put it out.
        let factor = match (glowing, texture) {
            (Some(colour), _) => {
                let brightest = colour.into_iter().fold(1.0, f32::max);
                colour.map(|x| x / brightest)
            }
            (None, Some(_)) => [1.0; 3],
            (None, None) => return,
        };
        entry.insert("emissiveFactor".to_owned(), json!(factor));
        if let Some(texture) = texture {
            entry.insert("emissiveTexture".to_owned(), json!({ "index": texture }));
        }
    }
}

/// A colour whose numbers are all finite.
fn colour(of: Option<[f32; 3]>) -> Option<[f32; 3]> {
    of.filter(|c| c.iter().all(|x| x.is_finite()))
}
