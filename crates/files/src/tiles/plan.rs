//! Which vertex belongs to which tile.

use super::records::{failed, write_json};
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::weld::Welding;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A mesh that was spread into tiles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name by which the caller knows the mesh and its cut.
    pub key: String,
    /// Number of source vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of source vertices in each tile.
    pub tiles: Vec<usize>,
    /// Rule of welding: source vertices that become one are in one tile.
    pub welding: Welding,
    /// Lowest and highest corner of the box around all vertices, model units.
    pub bounds: [DVec3; 2],
}

/// A halving of space, again and again.
#[derive(Clone, Debug, PartialEq)]
pub enum Split {
    /// All that is here belongs to one tile.
    Tile(u16),
    /// Positions below a plane, and all others.
    At {
        /// Axis that the plane is perpendicular to.
        axis: usize,
        /// Coordinate of the plane, model units.
        plane: f64,
        /// The parts below and above the plane.
        parts: Box<[Split; 2]>,
    },
}

impl Split {
    /// Cuts positions into `tiles` parts of about as many each, by planes across the longest sides. The order of positions changes.
    pub fn of(positions: &mut [DVec3], tiles: usize) -> Self {
        let mut next = 0;
        Self::build(positions, tiles, &mut next)
    }

    fn build(positions: &mut [DVec3], tiles: usize, next: &mut u16) -> Self {
        if tiles <= 1 {
            *next += 1;
            return Self::Tile(*next - 1);
        }
        let box_of = |[low, high]: [DVec3; 2], p: &DVec3| [low.min(*p), high.max(*p)];
        let [low, high] = positions.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], box_of);
        let side = (high - low).max(DVec3::ZERO).to_array();
        let axis = (1..3).fold(0, |longest, axis| if side[axis] > side[longest] { axis } else { longest });
        let below = tiles / 2;
        let middle = positions.len() * below / tiles;
        let plane = match positions.len() {
            0 => 0.0,
            _ => positions.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis])).1[axis],
        };
        let (first, second) = positions.split_at_mut(middle);
        let parts = Box::new([Self::build(first, below, next), Self::build(second, tiles - below, next)]);
        Self::At { axis, plane, parts }
    }

    /// Tile of a position. Equal positions have the same one, and 0 has no sign.
    pub fn tile(&self, position: DVec3) -> u16 {
        match self {
            Self::Tile(tile) => *tile,
            Self::At { axis, plane, parts } => parts[usize::from(position[*axis] >= *plane)].tile(position),
        }
    }
}

impl Plan {
    /// Reads the plan of a working folder; `None` if nothing was spread there.
    pub fn read(folder: &Path) -> Result<Option<Self>, Failure> {
        let path = Self::path(folder);
        match std::fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map(Some).map_err(Failure::internal),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(failed(&path)(e)),
        }
    }

    /// Reads the plan of a working folder in which a mesh was spread.
    pub fn of(folder: &Path) -> Result<Self, Failure> {
        Self::read(folder)?.ok_or_else(|| Failure::at(folder, "holds no tiles of a mesh"))
    }

    fn path(folder: &Path) -> PathBuf {
        folder.join("plan.json")
    }

    /// Writes the plan, which says that all tiles are there.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        write_json(&Self::path(folder), self)
    }
}

/// Position of each source vertex before. #v×3
pub(super) fn positions(folder: &Path) -> PathBuf {
    folder.join("positions")
}

/// A file of one tile.
pub(super) fn of_tile(folder: &Path, tile: usize, what: &str) -> PathBuf {
    folder.join(format!("tile-{tile:04}.{what}"))
}
