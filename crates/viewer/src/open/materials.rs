//! Textures that the materials of a mesh name.

use super::texture;
use crate::image_file;
use planish_files::failure::Failure;
use planish_files::input::{self, LARGEST_PICTURE, NamedFile, Trust};
use planish_files::named_path;
use planish_geometry::source::Source;
use planish_geometry::source::materials::{self, Material};
use planish_geometry::source::model::Model;
use planish_render::texture::{Content, Texture, Textures};
use std::path::Path;

/// Each triangle gets the texture of its face's material. What cannot be read is left out, with a word about it: the mesh
/// can be seen without.
pub(super) fn textures(mesh: &Path, model: &Model, trust: Trust, warnings: &mut Vec<String>) -> Textures {
    let known = materials(mesh, model.source(), trust, warnings);
    let read = |file: &str| {
        let path = named_path::find(input::folder_of(mesh), file, trust).path;
        let named = NamedFile { path: &path, folder: input::folder_of(mesh), trust, largest: LARGEST_PICTURE };
        let embedded = model.source().file().and_then(|source| source.embedded_texture(file));
        let bytes = embedded.map_or_else(|| named.read(), Ok)?;
        texture(image_file::decode(&bytes, &path)?, Content::Colour, &path)
    };
    let (mut all, mut files): (Vec<Texture>, Vec<(String, Option<u32>)>) = (Vec::new(), Vec::new());
    let mut texture_of = |name: &[u8]| -> Option<u32> {
        let material = known.iter().find(|material| material.name.as_bytes() == name.trim_ascii())?;
        let file = material.diffuse_texture.clone()?;
        if let Some((_, index)) = files.iter().find(|(known, _)| *known == file) {
            return *index;
        }
        let index = match read(&file) {
            Ok(texture) => {
                all.push(texture);
                Some(all.len() as u32 - 1)
            }
            Err(e) => {
                warnings.push(format!("{e}; its faces are drawn without a texture"));
                None
            }
        };
        files.push((file, index));
        index
    };
    let of_materials: Vec<Option<u32>> = model.data().materials().iter().map(|name| texture_of(name)).collect();
    let of_face = |face: &u32| of_materials[model.data().face_material(*face)? as usize];
    let of_triangles = planish_render::input::faces_of_triangles(model).iter().map(of_face).collect();
    Textures::by_triangle(all, of_triangles).unwrap_or_default()
}

/// All materials of the libraries that the mesh names.
fn materials(mesh: &Path, source: &Source, trust: Trust, warnings: &mut Vec<String>) -> Vec<Material> {
    let (mut all, mut problems) = (Vec::new(), Vec::new());
    for library in input::libraries(mesh, source, trust) {
        let read = library.bytes.and_then(|b| materials::read(&b).map_err(|e| Failure::at(&library.path, e)));
        match read {
            Ok(materials) => all.extend(materials),
            Err(reason) => problems.push(reason.to_string()),
        }
    }
    warnings.extend(input::summary(problems));
    all
}
