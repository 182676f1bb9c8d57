//! Pages: parts of a mesh that have images of their own, by UDIM tile, by material, or because the mesh was cut.
//!
//! A page is that of a face, because vertices and texture coordinates on the border between two tiles belong to both. A vertex
//! samples one of the pages of its faces, and all of them hold its height.
//!
//! ```
//! use planish_geometry::map::pages::{PageRule, Pages, Part};
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::Obj};
//!
//! // Two triangles, of which the second lies one tile farther.
//! let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 1.2 0.1\nvt 1.8 0.9\nvt 1.2 0.9\nf 1/1 2/2 3/3\nf 1/4 3/5 4/6\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! let pages = Pages::of(model.data(), PageRule::Udim)?.unwrap();
//! assert_eq!(pages.parts(), [Part::Tile(1001), Part::Tile(1002)]);
//! assert_eq!(Pages::of(model.data(), PageRule::None)?, None);
//!
//! // A mesh that was cut between its first three vertices and the fourth one. A face is on the page of its first corner.
//! let cut = Pages::of_cut(model.data(), [0, 1], &[Some(0), Some(0), Some(0), Some(1)]);
//! assert_eq!((cut.parts(), cut.of_face(1)), (&[Part::Cut(0), Part::Cut(1)][..], 0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::mesh::atlas::{Atlas, AtlasError};
use crate::mesh::jagged::Index;
use crate::named;
use crate::source::materials::CARRIER_MATERIAL;
use crate::source::model::Model;
use crate::source::{Corner, MeshData};
use glam::{DVec2, Vec2};
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

named! {
    /// Rule that divides a map into pages.
    #[derive(Default)]
    pub enum PageRule {
        /// One image for the whole mesh.
        #[default]
        None = "none",
        /// One image for each UDIM tile, which is a square of the integer grid in the texture coordinates.
        Udim = "udim",
        /// One image for each material.
        Material = "material",
    }
}

named! {
    /// Division that the pages of a map follow.
    pub enum Division {
        /// Each UDIM tile has a page.
        Udim = "udim",
        /// Each material has a page.
        Material = "material",
        /// The mesh was cut into parts because it is large, and each part has a page with one texel for each of its vertices.
        Cut = "cut",
    }
}

impl Division {
    /// Rule that divides a mesh like this; `None` for a mesh that was cut, as the mesh alone does not say where.
    pub fn rule(self) -> Option<PageRule> {
        match self {
            Self::Udim => Some(PageRule::Udim),
            Self::Material => Some(PageRule::Material),
            Self::Cut => None,
        }
    }
}

/// Part of a mesh that has a page.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// UDIM tile, 1001 + u + 10 · v for the square [u, u + 1] × [v, v + 1].
    Tile(u32),
    /// Name of a material; of faces without one, [`CARRIER_MATERIAL`].
    Material(String),
    /// Number of a part of a mesh that was cut.
    Cut(u32),
}

/// Number of the UDIM tile [0, 1]².
pub const FIRST_TILE: u32 = 1001;

/// Number of tiles in a row.
const COLUMNS: u32 = 10;

/// Number of rows whose tiles have numbers of four digits.
const ROWS: u32 = 899;

/// Largest number of pages of a map.
pub const MOST_PAGES: usize = 1000;

impl Part {
    /// Texture coordinate of the lower left corner of the part's image.
    pub fn offset(&self) -> Vec2 {
        match self {
            Self::Tile(tile) => {
                let index = tile.saturating_sub(FIRST_TILE);
                Vec2::new((index % COLUMNS) as f32, (index / COLUMNS) as f32)
            }
            Self::Material(_) | Self::Cut(_) => Vec2::ZERO,
        }
    }

    /// Texture coordinate within the part's image, in single precision as shaders compute it.
    pub fn uv_in_image(&self, uv: DVec2) -> Vec2 {
        uv.as_vec2() - self.offset()
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tile(number) | Self::Cut(number) => write!(f, "{number}"),
            Self::Material(name) => f.write_str(name),
        }
    }
}

/// A mesh would need more pages than [`MOST_PAGES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the mesh has {0} parts, and a map has at most {MOST_PAGES} pages")]
pub struct TooManyPages(pub usize);

/// Division of a mesh into pages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pages {
    by: Division,
    parts: Vec<Part>,
    of_face: Vec<Index>,
}

impl Pages {
    /// Divides a mesh; `None` if it needs no pages, because all faces with texture coordinates are on tile 1001 or have one
    /// material.
    ///
    /// A face that crosses the border of a tile, or lies where there is no tile, is on the tile that is nearest to its middle. A face
    /// without texture coordinates is on the first page.
    pub fn of(mesh: &MeshData, rule: PageRule) -> Result<Option<Self>, TooManyPages> {
        let (by, found) = match rule {
            PageRule::None => return Ok(None),
            PageRule::Udim => (Division::Udim, by_tile(mesh)),
            PageRule::Material => (Division::Material, by_material(mesh)),
        };
        let mut pages: BTreeMap<u32, Index> = found.iter().flatten().map(|key| (*key, 0)).collect();
        let is_single = match rule {
            PageRule::Udim => pages.keys().all(|tile| *tile == FIRST_TILE),
            _ => pages.len() < 2,
        };
        if is_single {
            return Ok(None);
        }
        if pages.len() > MOST_PAGES {
            return Err(TooManyPages(pages.len()));
        }
        pages.values_mut().zip(0..).for_each(|(page, i)| *page = i);
        let of_face = found.iter().map(|key| key.map_or(0, |key| pages[&key])).collect();
        let name = |material: u32| match mesh.materials().get(material as usize) {
            Some(name) => String::from_utf8_lossy(name).into_owned(),
            None => CARRIER_MATERIAL.to_owned(),
        };
        let part = |key: &u32| if rule == PageRule::Udim { Part::Tile(*key) } else { Part::Material(name(*key)) };
        Ok(Some(Self { by, parts: pages.keys().map(part).collect(), of_face }))
    }

    /// Division of a mesh that was cut into parts with these numbers, given the page that each source vertex samples (#v). A face is
    /// on the page of its first corner, or on the first page if that corner samples none.
    pub fn of_cut(mesh: &MeshData, numbers: impl IntoIterator<Item = u32>, of_vertices: &[Option<Index>]) -> Self {
        let page = |face: &[Corner]| face.first().and_then(|corner| of_vertices[corner.position as usize]);
        Self {
            by: Division::Cut,
            parts: numbers.into_iter().map(Part::Cut).collect(),
            of_face: mesh.faces().iter().map(|face| page(face).unwrap_or(0)).collect(),
        }
    }

    /// Division that the pages follow.
    pub fn by(&self) -> Division {
        self.by
    }

    /// Parts of the mesh that have pages: tiles by their number, or materials in the order of their first use.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Page of a face of the source.
    pub fn of_face(&self, face: Index) -> Index {
        self.of_face[face as usize]
    }

    /// Page of each corner of the source. #c
    pub fn of_corners(&self, mesh: &MeshData) -> Vec<Index> {
        let faces = (0..).zip(mesh.faces().iter());
        faces.flat_map(|(f, face)| std::iter::repeat_n(self.of_face(f), face.len())).collect()
    }

    /// Page of a corner of the surface.
    fn of_corner(&self, model: &Model, corner: Index) -> Index {
        self.of_face(model.source_face(model.surface().topology().face(corner)))
    }

    /// Returns whether each vertex has a face on a page. #V
    pub fn touch(&self, model: &Model, page: Index) -> Vec<bool> {
        let topology = model.surface().topology();
        let on_page = |v: Index| topology.corners(v).iter().any(|c| self.of_corner(model, *c) == page);
        (0..topology.vertex_count() as Index).map(on_page).collect()
    }

    /// Layout of the faces of a page, in texture coordinates of its image.
    pub fn atlas(&self, model: &Model, page: Index) -> Result<Atlas, AtlasError> {
        let part = &self.parts[page as usize];
        let uvs: Vec<DVec2> = model.data().uvs().iter().map(|uv| part.uv_in_image(*uv).as_dvec2()).collect();
        let corners = 0..model.surface().topology().faces().items().len() as Index;
        let on_page = |c: Index| model.source_corner(c).uv().filter(|_| self.of_corner(model, c) == page);
        Atlas::new(model.surface(), &uvs, corners.map(on_page))
    }

    /// Page that each vertex samples: that on which its faces have the largest area in texture coordinates, of equal ones the first;
    /// `None` for vertices without faces. `atlas` is the layout of the
    /// whole mesh. #V
    pub fn of_vertices(&self, model: &Model, atlas: &Atlas) -> Vec<Option<Index>> {
        let topology = model.surface().topology();
        let mut areas: BTreeMap<Index, f64> = BTreeMap::new();
        let mut page = |v: Index| {
            areas.clear();
            for &c in topology.corners(v) {
                let area = atlas.face_area(model.surface(), topology.face(c)).map_or(0.0, f64::abs);
                *areas.entry(self.of_corner(model, c)).or_insert(0.0) += area;
            }
            let mut best = (0, f64::NEG_INFINITY);
            for (&page, &area) in &areas {
                if area > best.1 {
                    best = (page, area);
                }
            }
            best.0
        };
        let vertices = 0..topology.vertex_count() as Index;
        vertices.map(|v| (!topology.is_isolated(v)).then(|| page(v))).collect()
    }
}

/// Tile of each face of the source; `None` without texture coordinates.
fn by_tile(mesh: &MeshData) -> Vec<Option<u32>> {
    // The tiles of a face: one, or more if it lies on a line of the grid.
    let tiles = |face: &[Corner]| -> Vec<u32> {
        let uvs = || face.iter().filter_map(|c| c.uv()).map(|uv| mesh.uvs()[uv as usize].as_vec2());
        let Some(first) = uvs().next() else { return Vec::new() };
        let (low, high) = uvs().fold((first, first), |(low, high), uv| (low.min(uv), high.max(uv)));
        // Halves first: the sum of two finite numbers may be none.
        let middle = low * 0.5 + high * 0.5;
        let square = |axis: usize, count: u32| {
            let cell = middle[axis].floor();
            let is_on_line = low[axis] == high[axis] && low[axis] == cell;
            let clamped = |cell: f32| cell.clamp(0.0, (count - 1) as f32) as u32;
            [Some(clamped(cell)), is_on_line.then(|| clamped(cell - 1.0))].into_iter().flatten()
        };
        let columns = || square(0, COLUMNS);
        square(1, ROWS).flat_map(|row| columns().map(move |column| FIRST_TILE + column + COLUMNS * row)).collect()
    };
    let candidates: Vec<Vec<u32>> = mesh.faces().iter().map(tiles).collect();
    let settled: FxHashSet<u32> = candidates.iter().filter(|c| c.len() == 1).map(|c| c[0]).collect();
    let choose = |tiles: &Vec<u32>| tiles.iter().find(|tile| settled.contains(tile)).or(tiles.first()).copied();
    candidates.iter().map(choose).collect()
}

/// Index of the material of each face of the source, and the number of materials for faces without one; `None` without texture
/// coordinates.
fn by_material(mesh: &MeshData) -> Vec<Option<u32>> {
    let none = mesh.materials().len() as u32;
    let material = |(f, face): (Index, &[Corner])| {
        face.iter().any(|c| c.uv().is_some()).then(|| mesh.face_material(f).unwrap_or(none))
    };
    (0..).zip(mesh.faces().iter()).map(material).collect()
}
