//! Results of a tile on disk: positions of its vertices and of those in the band around it.

use super::records::Numbers;
use crate::failure::Failure;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;

/// A vertex in the result of a tile.
pub(super) struct Found {
    pub(super) id: Index,
    pub(super) ring: u16,
    pub(super) position: DVec3,
}

/// Reads the next vertex; `None` at the end.
pub(super) fn read(file: &mut Numbers) -> Result<Option<Found>, Failure> {
    if file.is_at_end()? {
        return Ok(None);
    }
    Ok(Some(Found { id: file.index()?, ring: file.index()? as u16, position: file.position()? }))
}

/// The next vertex of the tile itself.
pub(super) fn own(file: &mut Numbers) -> Result<Option<Found>, Failure> {
    while let Some(found) = read(file)? {
        if found.ring == 0 {
            return Ok(Some(found));
        }
    }
    Ok(None)
}
