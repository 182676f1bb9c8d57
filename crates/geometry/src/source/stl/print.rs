//! Writer of meshes that did not come from an STL file: binary.

use super::HEADER;
use super::rewrite::facet_normal;
use crate::mesh::polygon;
use crate::source::MeshData;
use glam::{DVec3, Vec3};

/// Prints the triangles of a mesh in single precision.
pub(in crate::source) fn print(data: &MeshData) -> Vec<u8> {
    let mut out = vec![0; HEADER];
    let head = b"written by planish";
    out[..head.len()].copy_from_slice(head);
    let mut count: u32 = 0;
    for face in data.faces().iter() {
        let points: Vec<DVec3> = face.iter().map(|c| data.positions()[c.position as usize]).collect();
        polygon::triangulate(&points, |triangle| {
            let corners = triangle.map(|k| points[k].as_vec3());
            let normal = facet_normal(&corners.map(Vec3::as_dvec3));
            for x in [normal].iter().chain(&corners).flat_map(Vec3::to_array) {
                out.extend(x.to_le_bytes());
            }
            out.extend([0, 0]);
            count += 1;
        });
    }
    out[HEADER - 4..HEADER].copy_from_slice(&count.to_le_bytes());
    out
}
