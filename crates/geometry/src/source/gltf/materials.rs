//! Materials of a glTF file as those of a material library.

use super::container::{Container, data_uri, percent_decoded};
use super::{index, list};
use rustc_hash::FxHashMap;
use serde_json::Value;
use std::fmt::Write as _;

/// Names of all materials, each different from all others.
pub(super) fn names(document: &Value) -> Vec<Vec<u8>> {
    let materials = list(document, "materials");
    let name = |m: &Value| m["name"].as_str().unwrap_or("").replace(char::is_control, " ").trim().to_owned();
    let all: Vec<String> = materials.iter().map(name).collect();
    let mut counts: FxHashMap<&str, usize> = FxHashMap::default();
    for name in &all {
        *counts.entry(name).or_default() += 1;
    }
    let unique = |(i, name): (usize, &String)| {
        let is_taken = name.is_empty() || counts[name.as_str()] > 1;
        match (is_taken, name.as_str()) {
            (false, name) => name.to_owned(),
            (true, "") => format!("material-{i}"),
            (true, name) => format!("{name}-{i}"),
        }
    };
    all.iter().enumerate().map(|named| unique(named).into_bytes()).collect()
}

/// The materials as a material library: base colours and their textures.
pub(super) fn library(document: &Value) -> Vec<u8> {
    let mut out = Vec::new();
    for (name, material) in names(document).iter().zip(list(document, "materials")) {
        out.extend([b"newmtl ", &name[..], b"\n"].concat());
        let shading = &material["pbrMetallicRoughness"];
        let factor: Vec<f64> = list(shading, "baseColorFactor").iter().filter_map(Value::as_f64).collect();
        let mut text = String::new();
        if let [r, g, b, ..] = factor[..] {
            let _ = writeln!(text, "Kd {r} {g} {b}");
        }
        let texture = index(&shading["baseColorTexture"]["index"]);
        if let Some(image) = texture.and_then(|t| image_of(document, t)) {
            let _ = writeln!(text, "map_Kd {}", image_name(document, image));
        }
        out.extend(text.into_bytes());
    }
    out
}

/// Image of a texture.
fn image_of(document: &Value, texture: usize) -> Option<usize> {
    let texture = list(document, "textures").get(texture)?;
    index(&texture["source"]).filter(|image| *image < list(document, "images").len())
}

/// File name of an image: its own where it is a file beside, else one that is made from its index.
fn image_name(document: &Value, image: usize) -> String {
    let entry = &list(document, "images")[image];
    if let Some(uri) = entry["uri"].as_str().filter(|uri| data_uri(uri).is_none()) {
        return percent_decoded(uri).replace(char::is_control, " ");
    }
    let media_type = entry["mimeType"].as_str().or_else(|| entry["uri"].as_str()?.strip_prefix("data:"));
    let extension = if media_type.is_some_and(|t| t.starts_with("image/jpeg")) { "jpg" } else { "png" };
    format!("image-{image}.{extension}")
}

/// Bytes of an image within the file, by the name that [`library`] gives it.
pub(super) fn embedded_texture(document: &Value, container: &Container, name: &str) -> Option<Vec<u8>> {
    let images = list(document, "images");
    let image = (0..images.len()).find(|image| image_name(document, *image) == name)?;
    match images[image]["uri"].as_str() {
        Some(uri) => data_uri(uri).flatten(),
        None => Some(container.view(document, index(&images[image]["bufferView"])?)?.to_vec()),
    }
}
