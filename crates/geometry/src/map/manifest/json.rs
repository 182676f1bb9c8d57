//! Reading and writing a manifest, and the checks of its fields.

use super::{FileEntry, LARGEST_SIDE, Layout, Manifest, Method, PrivateTexel, VERSION};
use crate::mesh::atlas::FARTHEST_TILE;
use crate::mesh::jagged::Index;
use glam::IVec2;
use serde::Deserialize;

/// Largest absolute strength. A value near it is a mistake, and far beyond it single precision would overflow.
const LARGEST_LAMBDA: f64 = 1e6;

/// Reasons why bytes are not a manifest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// The bytes are no JSON, or fields are missing or have the wrong type; the text names line and column.
    #[error("not a planish manifest: {0}")]
    Json(String),
    /// The manifest has another version of the format.
    #[error("the manifest has version {0}, but this planish reads versions 1 to {VERSION}")]
    Version(String),
    /// A field has a value that is not allowed.
    #[error("field `{field}`: {problem}")]
    Value {
        /// Path of the field.
        field: &'static str,
        /// Text on what is wrong with the value.
        problem: String,
    },
}

impl Manifest {
    /// Reads and checks a manifest.
    pub fn from_json(bytes: &[u8]) -> Result<Self, ManifestError> {
        let json = |e: serde_json::Error| ManifestError::Json(e.to_string());
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(json)?;
        match value.get("planish") {
            None => return Err(ManifestError::Json("there is no field `planish` with the version".to_owned())),
            Some(version) if !version.as_u64().is_some_and(|version| (1..=VERSION).contains(&version)) => {
                return Err(ManifestError::Version(version.to_string()));
            }
            Some(_) => {}
        }
        if let Some(method) = value.get("method") {
            let fault = |e: serde_json::Error| ManifestError::Value { field: "method", problem: e.to_string() };
            Method::deserialize(method).map_err(fault)?;
        }
        let manifest: Self = serde_json::from_slice(bytes).map_err(json)?;
        manifest.check()?;
        Ok(manifest)
    }

    fn check(&self) -> Result<(), ManifestError> {
        let ensure = |is_valid: bool, field, problem: String| {
            if is_valid { Ok(()) } else { Err(ManifestError::Value { field, problem }) }
        };
        let map = &self.displacement;
        for (side, field) in [(map.width, "displacement.width"), (map.height, "displacement.height")] {
            ensure((1..=LARGEST_SIDE).contains(&side), field, format!("{side} is not in 1..={LARGEST_SIDE}"))?;
        }
        let is_single = |x: f64| x.is_finite() && (x as f32).is_finite();
        ensure(is_single(map.bias), "displacement.bias", format!("{:e} is too large", map.bias))?;
        ensure(
            is_single(map.scale) && map.scale >= 0.0,
            "displacement.scale",
            format!("{:e} is not a scale", map.scale),
        )?;
        let is_strength = map.lambda.abs() <= LARGEST_LAMBDA;
        ensure(is_strength, "displacement.lambda", format!("{:e} is not a strength", map.lambda))?;
        let is_near = map.origin.to_array().into_iter().all(is_single);
        ensure(is_near, "displacement.origin", format!("{} is too large", map.origin))?;
        let tile = map.tile;
        let is_near = tile.to_array().iter().all(|corner| (-FARTHEST_TILE..=FARTHEST_TILE).contains(corner));
        ensure(is_near && (tile == IVec2::ZERO || self.pages.is_none()), "displacement.tile", {
            format!("{tile} is farther than {FARTHEST_TILE} tiles away, or goes with pages")
        })?;
        let highest = self.backs.highest() as usize;
        let problem = format!("names {highest}, but there are {} vertices", self.source.vertices);
        ensure(highest <= self.source.vertices, "backs", problem)?;
        if let Some(pages) = &self.pages {
            pages.check(self).map_err(|problem| ManifestError::Value { field: "pages", problem })?;
        }
        let has_sample_positions = map.layout == Layout::Vertex || self.dominant_uv.is_some() || self.pages.is_some();
        ensure(has_sample_positions, "dominant_uv", "is missing, and the layout `uv` needs it".to_owned())?;
        let is_one = map.layout == Layout::Vertex && self.pages.is_none();
        let has_texels = !is_one || map.size().texels() >= self.source.vertices;
        let texels = map.size().texels();
        let problem = format!("{texels} texels are too few for {} vertices", self.source.vertices);
        ensure(has_texels, "displacement.width", problem)?;
        for (field, map) in self.shading_maps() {
            let problem = format!("{} × {} is no size for {} vertices", map.width, map.height, self.source.vertices);
            let sides = [map.width, map.height].iter().all(|side| (1..=LARGEST_SIDE).contains(side));
            let has_texels = map.layout == Layout::Uv || map.size().texels() >= self.source.vertices;
            ensure(sides && has_texels, field, problem)?;
        }
        let range = self.curvature.as_ref().map_or(0.0, |entry| entry.range);
        ensure(range.is_finite() && range >= 0.0, "curvature.range", format!("{range} is not a range"))?;
        let distance = self.occlusion.as_ref().and_then(|entry| entry.distance).unwrap_or(1.0);
        ensure(distance.is_finite() && distance > 0.0, "occlusion.distance", format!("{distance} is not above 0"))?;
        if !self.files.is_empty() {
            let listed = |name: &&str| self.files.iter().any(|entry| entry.file == **name);
            let absent = self.described().into_iter().find(|name| !listed(name));
            ensure(absent.is_none(), "files", format!("lacks {:?}", absent.unwrap_or_default()))?;
        }
        let pairs = self.dominant_uv.as_ref().map_or(&[][..], |uv| &uv.seam_vertices);
        let counted_from_one = pairs.iter().flatten().all(|&i| i > 0);
        ensure(counted_from_one, "dominant_uv.seam_vertices", "index 0: indices count from 1".to_owned())?;
        let in_mesh = |pair: &[Index; 2]| pair[0] as usize <= self.source.vertices;
        let stray = pairs.iter().find(|pair| !in_mesh(pair));
        ensure(stray.is_none(), "dominant_uv.seam_vertices", format!("{stray:?} names no vertex"))?;
        let has_uvs = map.layout == Layout::Uv || self.private_texels.is_empty();
        ensure(has_uvs, "private_texels", "does not go with the layout `vertex`".to_owned())?;
        let exists = |texel: &&PrivateTexel| {
            (1..=self.source.vertices).contains(&(texel.vertex as usize))
                && texel.column < map.width
                && texel.row < map.height
        };
        let stray = self.private_texels.iter().find(|texel| !exists(texel)).map(|texel| <[Index; 3]>::from(*texel));
        ensure(
            stray.is_none(),
            "private_texels",
            format!("{:?} names no vertex or no texel", stray.unwrap_or_default()),
        )
    }

    /// Writes the JSON text: indented, but with each list of indices in one line.
    pub fn to_json(&self) -> String {
        // Strings, numbers and lists cannot fail to become JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        let lists = [("/dominant_uv/seam_vertices", "seam_vertices"), ("/private_texels", "private_texels")];
        let mut lists = lists.map(|(pointer, name)| (pointer.to_owned(), name)).to_vec();
        for page in 0..self.page_entries().len() {
            lists.extend(["seam_vertices", "private_texels"].map(|name| (format!("/pages/maps/{page}/{name}"), name)));
        }
        // In the order in which they stand in the text.
        let take = |(pointer, name): (String, _)| (name, value.pointer_mut(&pointer).map(std::mem::take));
        let lists: Vec<(&str, Option<serde_json::Value>)> = lists.into_iter().map(take).collect();
        let mut text = serde_json::to_string_pretty(&value).unwrap_or_default();
        for (name, list) in lists {
            if let Some(list) = list {
                text = text.replacen(&format!("\"{name}\": null"), &format!("\"{name}\": {list}"), 1);
            }
        }
        text + "\n"
    }
}

/// Finds the files that a manifest names, even one that this version cannot use: an old one, a newer one, or one that was edited. A
/// file without a known SHA-256 has an empty one. `None` if the bytes are no manifest at all.
pub fn named_files(bytes: &[u8]) -> Option<Vec<FileEntry>> {
    let value: serde_json::Value = serde_json::from_slice(bytes).ok()?;
    value.get("planish")?;
    let text = |pointer: &str| value.pointer(pointer).and_then(serde_json::Value::as_str).map(str::to_owned);
    let mut files: Vec<FileEntry> =
        value.get("files").and_then(|files| Vec::deserialize(files).ok()).unwrap_or_default();
    let pointers = [
        "/displacement/file",
        "/normal_map/file",
        "/occlusion/file",
        "/curvature/file",
        "/carrier/obj",
        "/carrier/mtl",
        "/carrier/glb",
    ];
    let pages = value.pointer("/pages/maps").and_then(serde_json::Value::as_array).map_or(0, Vec::len);
    let of_pages = (0..pages).flat_map(|page| ["file", "normal_map/file"].map(|of| format!("/pages/maps/{page}/{of}")));
    let pointers = pointers.into_iter().map(str::to_owned).chain(of_pages);
    for file in pointers.filter_map(|pointer| text(&pointer)) {
        if files.iter().all(|known| known.file != file) {
            files.push(FileEntry { file, sha256: String::new() });
        }
    }
    Some(files)
}
