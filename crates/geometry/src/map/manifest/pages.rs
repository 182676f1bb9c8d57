//! Entries of a map with pages.

use super::{LARGEST_SIDE, Layout, Manifest, NormalMapEntry, PrivateTexel};
use crate::denoise::limits::Mask;
use crate::map::Size;
use crate::map::pages::{Division, Part};
use crate::mesh::jagged::Index;
use serde::{Deserialize, Serialize};

/// Pages of a map, which are images with one bias and scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PagesEntry {
    /// Division of the mesh into pages.
    pub by: Division,
    /// Rule by which a vertex on the border of several pages samples one of them, and one texture coordinate there: criteria, the
    /// most important first.
    pub rule: String,
    /// Pages, each of which is a map of a part of the mesh.
    pub maps: Vec<PageEntry>,
}

/// Page of a map. It holds the heights of all vertices of the faces of its part, also of those that sample another page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PageEntry {
    /// Part of the mesh; in JSON the field `tile`, `material` or `cut`.
    #[serde(flatten)]
    pub part: Part,
    /// Name of the image file.
    pub file: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Normal map of the page; `None` if the texture coordinates do not allow one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<NormalMapEntry>,
    /// Source vertices that sample this page.
    pub vertices: Mask,
    /// Source vertices that have a texel in this page: the j-th of them has texel (j mod width, j div width), row 0 on top. These are
    /// the vertices that sample the page, and the other ones of their faces. Only in a mesh that was cut.
    #[serde(default, skip_serializing_if = "Mask::is_empty")]
    pub texels: Mask,
    /// Pairs `[v, vt]`, both counted from 1 as in OBJ, in ascending order: in this page `v` samples at `vt`. Vertices that are not
    /// listed have only one texture coordinate.
    #[serde(default)]
    pub seam_vertices: Vec<[Index; 2]>,
    /// Source vertices that read texels of their own in this page, and those texels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub private_texels: Vec<PrivateTexel>,
}

impl PageEntry {
    /// Size of the image.
    pub fn size(&self) -> Size {
        Size { width: self.width, height: self.height }
    }

    /// Names of the files of the page.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let normal_map = self.normal_map.as_ref().map(|map| map.file.as_str());
        std::iter::once(self.file.as_str()).chain(normal_map)
    }

    fn check(&self, by: Division, vertices: usize) -> Result<(), String> {
        let normal_map = self.normal_map.as_ref().map(|map| [map.width, map.height]);
        let mut sides = [self.width, self.height].into_iter().chain(normal_map.into_iter().flatten());
        if let Some(side) = sides.find(|side| !(1..=LARGEST_SIDE).contains(side)) {
            return Err(format!("{side} is not in 1..={LARGEST_SIDE}"));
        }
        let is_vertex = |v: Index| (1..=vertices).contains(&(v as usize));
        if self.vertices.highest() as usize > vertices {
            return Err(format!("`vertices` names {}, but there are {vertices} vertices", self.vertices.highest()));
        }
        self.check_texels(by, vertices)?;
        if let Some(pair) = self.seam_vertices.iter().find(|pair| !is_vertex(pair[0]) || pair[1] == 0) {
            return Err(format!("`seam_vertices`: {pair:?} names no vertex or no texture coordinate"));
        }
        let exists = |t: &&PrivateTexel| is_vertex(t.vertex) && t.column < self.width && t.row < self.height;
        match self.private_texels.iter().find(|texel| !exists(texel)) {
            Some(t) => {
                let stray = <[Index; 3]>::from(*t);
                Err(format!("`private_texels`: {stray:?} names no vertex or no texel"))
            }
            None => Ok(()),
        }
    }

    /// Checks that a page of a mesh that was cut has a texel for each vertex that samples it, and nothing else.
    fn check_texels(&self, by: Division, vertices: usize) -> Result<(), String> {
        if by != Division::Cut {
            return if self.texels.is_empty() { Ok(()) } else { Err("`texels` goes with `cut` alone".to_owned()) };
        }
        if !(self.seam_vertices.is_empty() && self.private_texels.is_empty() && self.normal_map.is_none()) {
            return Err("`seam_vertices`, `private_texels` and `normal_map` do not go with `cut`".to_owned());
        }
        if self.texels.highest() as usize > vertices {
            return Err(format!("`texels` names {}, but there are {vertices} vertices", self.texels.highest()));
        }
        let (needed, there) = (self.texels.count(), self.size().texels());
        if needed > there {
            return Err(format!("{there} texels are too few for {needed} vertices"));
        }
        let lacking = self.vertices.indices().find(|v| !self.texels.contains(*v));
        lacking.map_or(Ok(()), |v| Err(format!("vertex {} samples the page and has no texel there", v + 1)))
    }
}

impl PagesEntry {
    /// Returns what is wrong with the pages of a manifest.
    pub(super) fn check(&self, manifest: &Manifest) -> Result<(), String> {
        let map = &manifest.displacement;
        let Some(first) = self.maps.first() else { return Err("there is none".to_owned()) };
        let layout = if self.by == Division::Cut { Layout::Vertex } else { Layout::Uv };
        if map.layout != layout {
            return Err(format!("by `{}` do not go with the layout `{}`", self.by.name(), map.layout.name()));
        }
        if (&map.file, map.size()) != (&first.file, first.size()) {
            return Err("the first page is not the map of `displacement`".to_owned());
        }
        let has_more = manifest.dominant_uv.is_some() || manifest.normal_map.is_some();
        if has_more || !manifest.private_texels.is_empty() {
            return Err("`dominant_uv`, `private_texels` and `normal_map` do not go with pages".to_owned());
        }
        let check = |page: &PageEntry| {
            page.check(self.by, manifest.source.vertices).map_err(|problem| format!("page {}: {problem}", page.part))
        };
        self.maps.iter().try_for_each(check)
    }
}
