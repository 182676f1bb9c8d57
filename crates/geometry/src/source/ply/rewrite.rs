//! Writer that copies the bytes of a PLY file and replaces the numbers of its vertices.

use super::Ply;
use super::parse::Cursor;
use super::scalar::{Encoding, Scalar};
use crate::mesh::jagged::Index;
use crate::source::patch::Patch;
use glam::DVec3;

/// Number of a property of a vertex: an axis of its position or of its normal.
#[derive(Clone, Copy)]
enum Role {
    Position(usize),
    Normal(usize),
    Other,
}

pub(super) fn with_positions(ply: &Ply, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
    let (data, encoding) = (&ply.data, ply.header.encoding);
    assert_eq!(positions.len(), data.positions.len(), "one position for each vertex");
    assert!(normals.is_none_or(|normals| normals.len() == data.normals.len()), "one normal for each normal");
    let normals = normals.filter(|_| ply.vertex.normal.is_some());
    let properties = &ply.header.elements[ply.header.vertex].properties;
    let role = |p: usize| {
        let axis = |at: [usize; 3]| at.iter().position(|q| *q == p);
        if let Some(axis) = axis(ply.vertex.position) {
            return Role::Position(axis);
        }
        ply.vertex.normal.and_then(axis).map_or(Role::Other, Role::Normal)
    };
    let roles: Vec<Role> = (0..properties.len()).map(role).collect();
    let mut patch = Patch::new(&ply.bytes);
    let mut cursor = Cursor::new(&ply.bytes, encoding, ply.vertices_at, ply.vertices_line);
    for (v, position) in positions.iter().enumerate() {
        let moves = data.moves(v as Index, *position);
        for (property, role) in properties.iter().zip(&roles) {
            if let Some(list) = property.list {
                let count = cursor.next(list).map_or(0, |range| count_of(&ply.bytes[range], list, encoding));
                (0..count).for_each(|_| _ = cursor.next(property.scalar));
                continue;
            }
            let Some(range) = cursor.next(property.scalar) else { continue };
            let [before, after] = match *role {
                Role::Position(axis) if moves => [data.positions[v][axis], position[axis]],
                Role::Normal(axis) => match normals {
                    Some(normals) => [data.normals[v][axis], normals[v][axis]],
                    None => continue,
                },
                Role::Position(_) | Role::Other => continue,
            };
            if let Some(number) = replaced(property.scalar, before, after) {
                property.scalar.write(number, encoding, patch.replace(range));
            }
        }
    }
    patch.finish()
}

/// Number to write in place of `before`; `None` where the file has it already, or cannot have it.
pub(super) fn replaced(scalar: Scalar, before: f64, after: f64) -> Option<f64> {
    let is_new = |x: f64| x.to_bits() != before.to_bits();
    (is_new(after) && is_new(scalar.nearest(after)) && after.is_finite()).then_some(after)
}

/// Number of items of a list, which the reader has checked.
fn count_of(bytes: &[u8], scalar: Scalar, encoding: Encoding) -> usize {
    match encoding {
        Encoding::Text => fast_float2::parse::<f64, _>(bytes).unwrap_or(0.0) as usize,
        encoding => scalar.read(bytes, encoding) as usize,
    }
}
