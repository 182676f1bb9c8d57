//! Contents of a mesh that its binary glTF carrier lacks, in words.

use planish_geometry::bake::{Bundle, gltf};
use planish_geometry::source::Source;
use planish_geometry::source::format::Format;
use std::collections::BTreeSet;

/// Names the contents of a mesh that came as glTF which its binary glTF carrier lacks, if the document could not be kept.
pub(super) fn document(source: &Source, bundle: &Bundle) -> Option<String> {
    let (name, file) = (bundle.manifest.carrier.glb.as_ref()?, source.file()?);
    if !matches!(file.format(), Format::Glb | Format::Gltf) || gltf::keeps_document(source) {
        return None;
    }
    let contents = file.contents();
    let lost = if contents.is_empty() { String::new() } else { format!(" {},", contents.join(", ")) };
    let reason = "an animation of the mesh gives weights to its morph targets, and would have too few";
    Some(format!("{name} lacks{lost} nodes and extras of the mesh: {reason}"))
}

/// Says which maps of the materials in libraries the binary glTF carrier does not have, because glTF has no place for them.
pub(super) fn maps(libraries: &[Vec<u8>], bundle: &Bundle) -> Option<String> {
    let name = bundle.manifest.carrier.glb.as_ref()?;
    let text: Vec<_> = libraries.iter().map(|library| String::from_utf8_lossy(library)).collect();
    let keywords = text.iter().flat_map(|text| text.lines()).filter_map(|line| line.split_whitespace().next());
    let is_lost = |keyword: &&str| {
        // A library may have anything for a name.
        let is_word = keyword.len() < 20 && keyword.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        let is_map = is_word && (keyword.starts_with("map_") || matches!(*keyword, "decal" | "refl"));
        // The carrier has bumps of its own.
        let has_place = ["map_kd", "map_d", "map_ke", "map_pr", "map_pm", "map_bump"];
        is_map && !has_place.contains(&keyword.to_lowercase().as_str())
    };
    let lost: BTreeSet<&str> = keywords.filter(is_lost).collect();
    let lost = Vec::from_iter(lost).join(", ");
    (!lost.is_empty()).then(|| format!("{name} lacks {lost} of the materials, for which glTF has no place"))
}
