//! A tile with a halo.

use super::plan::{Plan, of_tile};
use super::records::Numbers;
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::jagged::{Index, Ragged};
use planish_geometry::mesh::weld::{Weld, Welding};
use planish_geometry::progress::Progress;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::path::Path;

/// Positions and faces of a tile and its halo, in the order of the whole mesh.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Source vertex of the whole mesh that each source vertex here is, ascending. #v
    pub ids: Vec<Index>,
    /// Positions of the source vertices. #v×3, model units
    pub positions: Vec<DVec3>,
    /// Tile of each source vertex. #v
    pub tiles: Vec<u16>,
    /// Number of rings between each source vertex and the tile; 0 in the tile. #v
    pub rings: Vec<u16>,
    /// Faces at all source vertices that are less than `halo` rings away. #f
    pub faces: Ragged<Index>,
}

/// Ring of a vertex that has not been reached.
const FAR: u16 = u16::MAX;

/// Corner of a face: its source vertex in the whole mesh, and the tile of that.
type Corner = (Index, u16);

/// A tile as it is on disk, and how far each of its vertices is.
struct Loaded {
    ids: Vec<Index>,
    positions: Vec<DVec3>,
    /// Index here of each source vertex.
    index: FxHashMap<Index, Index>,
    /// Vertices that source vertices of one place became; they are in one tile.
    weld: Weld,
    faces: Ragged<Corner>,
    face_ids: Vec<Index>,
    /// Faces at each vertex.
    vertex_faces: Ragged<Index>,
    /// Ring of each vertex.
    rings: Vec<u16>,
}

impl Loaded {
    fn read(folder: &Path, tile: u16, welding: Welding) -> Result<Self, Failure> {
        let (mut ids, mut positions) = (Vec::new(), Vec::new());
        let mut file = Numbers::open(of_tile(folder, tile.into(), "vertices"))?;
        while !file.is_at_end()? {
            ids.push(file.index()?);
            positions.push(file.position()?);
        }
        let index: FxHashMap<Index, Index> = ids.iter().copied().zip(0..).collect();
        let weld = Weld::new(&positions, welding);
        let (mut faces, mut face_ids) = (Ragged::default(), Vec::new());
        let mut file = Numbers::open(of_tile(folder, tile.into(), "faces"))?;
        let mut corners: Vec<Corner> = Vec::new();
        while !file.is_at_end()? {
            face_ids.push(file.index()?);
            corners.clear();
            for _ in 0..file.index()? {
                corners.push((file.index()?, file.index()? as u16));
            }
            faces.push(corners.iter().copied());
        }
        let own = (0..).zip(faces.iter()).flat_map(|(f, face)| {
            let own = face.iter().filter(|(_, of)| *of == tile);
            let (index, weld) = (&index, &weld);
            own.map(move |(v, _)| (weld.vertex_of()[index[v] as usize], f))
        });
        let vertex_faces = Ragged::group(weld.first().len(), own.collect::<Vec<_>>().into_iter());
        let rings = vec![FAR; weld.first().len()];
        Ok(Self { ids, positions, index, weld, faces, face_ids, vertex_faces, rings })
    }

    /// Vertex that a source vertex became.
    fn vertex(&self, id: Index) -> Index {
        self.weld.vertex_of()[self.index[&id] as usize]
    }
}

/// Tiles, which are read when a ring comes to them.
struct Tiles<'a> {
    folder: &'a Path,
    welding: Welding,
    loaded: BTreeMap<u16, Loaded>,
}

impl Tiles<'_> {
    fn get(&mut self, tile: u16) -> Result<&mut Loaded, Failure> {
        if !self.loaded.contains_key(&tile) {
            self.loaded.insert(tile, Loaded::read(self.folder, tile, self.welding)?);
        }
        Ok(self.loaded.get_mut(&tile).expect("it was just put there"))
    }

    /// Marks what is `ring` rings away from what is one less. Returns the vertices, each with its tile.
    fn grow(&mut self, from: &[(u16, Index)], ring: u16) -> Result<Vec<(u16, Index)>, Failure> {
        let mut near: Vec<Corner> = Vec::new();
        for (tile, v) in from {
            let loaded = self.get(*tile)?;
            for f in loaded.vertex_faces.get(*v) {
                near.extend(loaded.faces.get(*f));
            }
        }
        near.sort_unstable();
        near.dedup();
        let mut next = Vec::new();
        for (id, tile) in near {
            let loaded = self.get(tile)?;
            let vertex = loaded.vertex(id);
            if loaded.rings[vertex as usize] == FAR {
                loaded.rings[vertex as usize] = ring;
                next.push((tile, vertex));
            }
        }
        Ok(next)
    }
}

impl Part {
    /// Indices in this part of the source vertices of each tile, ascending.
    pub(super) fn sources_by_tile(&self) -> BTreeMap<u16, Vec<usize>> {
        let mut sources: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
        for (source, tile) in self.tiles.iter().enumerate() {
            sources.entry(*tile).or_default().push(source);
        }
        sources
    }

    /// Reads a tile with a halo of so many rings.
    pub fn read(folder: &Path, plan: &Plan, tile: usize, halo: u16, progress: &dyn Progress) -> Result<Self, Failure> {
        let Some(tile) = u16::try_from(tile).ok().filter(|tile| usize::from(*tile) < plan.tiles.len()) else {
            return Err(Failure::Input(format!("there is no tile {tile}: there are {}", plan.tiles.len())));
        };
        let mut tiles = Tiles { folder, welding: plan.welding, loaded: BTreeMap::new() };
        let own = tiles.get(tile)?;
        own.rings.fill(0);
        let mut front: Vec<(u16, Index)> = (0..own.rings.len() as Index).map(|v| (tile, v)).collect();
        for ring in 1..=halo {
            front = tiles.grow(&front, ring)?;
            progress.check()?;
        }
        Ok(Self::of(&tiles.loaded, halo))
    }

    fn of(loaded: &BTreeMap<u16, Loaded>, halo: u16) -> Self {
        let mut vertices = Vec::new();
        let mut faces: Vec<(Index, u16, Index)> = Vec::new();
        for (tile, loaded) in loaded {
            for (id, (position, v)) in loaded.ids.iter().zip(loaded.positions.iter().zip(loaded.weld.vertex_of())) {
                let ring = loaded.rings[*v as usize];
                vertices.extend((ring != FAR).then_some((*id, *position, *tile, ring)));
            }
            for (v, ring) in loaded.rings.iter().enumerate().filter(|(_, ring)| **ring < halo.max(1)) {
                debug_assert!(*ring != FAR);
                faces.extend(
                    loaded.vertex_faces.get(v as Index).iter().map(|f| (loaded.face_ids[*f as usize], *tile, *f)),
                );
            }
        }
        vertices.sort_unstable_by_key(|(id, ..)| *id);
        faces.sort_unstable();
        faces.dedup_by_key(|(id, ..)| *id);
        let index: FxHashMap<Index, Index> = vertices.iter().map(|(id, ..)| *id).zip(0..).collect();
        let mut part = Self::default();
        for (_, tile, f) in faces {
            let corners = loaded[&tile].faces.get(f);
            // Without a halo, faces that reach beyond the tile are left out.
            if let Some(corners) = corners.iter().map(|(id, _)| index.get(id).copied()).collect::<Option<Vec<Index>>>()
            {
                part.faces.push(corners);
            }
        }
        for (id, position, tile, ring) in vertices {
            part.ids.push(id);
            part.positions.push(position);
            part.tiles.push(tile);
            part.rings.push(ring);
        }
        part
    }
}
