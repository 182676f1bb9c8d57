//! Two triangles that give a part a mean distance of neighbouring faces that is known to the bit.
//!
//! Filters of face normals measure in that mean, over the mesh that they get. A part of a mesh has another mean than the whole, which
//! would change all bits. So a part gets two triangles more, joined to nothing, whose distance is so much larger than all others that these are lost in
//! rounding: the mean becomes a power of two, and the settings can be given in it without any rounding.

use super::part::Part;
use glam::DVec3;
use planish_geometry::mesh::jagged::Index;

/// Bits by which the distance of the triangles exceeds the sum of all others; a double has 53.
const ABOVE: i32 = 60;

/// Ring of the vertices of the triangles, which belong to no tile.
pub(super) const RING: u16 = u16::MAX;

/// Adds the triangles to a part whose triangles share `edges` edges, for a mesh in a box with this diagonal. Returns the mean distance of
/// the part with them, model units.
pub(super) fn add(part: &mut Part, edges: usize, diagonal: f64) -> f64 {
    let mean = f64::powi(2.0, diagonal.max(f64::MIN_POSITIVE).log2().ceil() as i32 + ABOVE);
    // The centroids are 8 units apart: a third of twice twelve. All numbers are exact.
    let unit = (edges + 1) as f64 * mean / 8.0;
    let first = part.positions.len() as Index;
    let corners = [[0.0, -5.0], [0.0, 5.0], [12.0, 0.0], [-12.0, 0.0]];
    part.positions.extend(corners.map(|[x, y]| DVec3::new(x * unit, y * unit, 0.0)));
    part.ids.extend([Index::MAX; 4]);
    part.tiles.extend([u16::MAX; 4]);
    part.rings.extend([RING; 4]);
    part.faces.push([first, first + 1, first + 2]);
    part.faces.push([first + 1, first, first + 3]);
    mean
}
