//! Writer of meshes that did not come from a PLY file: binary, little-endian.

use super::scalar::{Encoding, Scalar};
use crate::source::convert::{Attributes, Precision};
use glam::{DVec2, DVec3};
use std::fmt::Write as _;

/// Prints a mesh. Attributes that all corners at a vertex share become properties of the vertices; other texture coordinates become
/// the list `texcoord` of each face, as MeshLab writes them, and other normals are left out.
pub(in crate::source) fn print(mesh: &Attributes, precision: Precision) -> Vec<u8> {
    let data = mesh.data;
    let number = if precision == Precision::Double { Scalar::F64 } else { Scalar::F32 };
    let coordinate = if precision == Precision::Double { "double" } else { "float" };
    let mut header = "ply\nformat binary_little_endian 1.0\n".to_owned();
    let _ = writeln!(header, "element vertex {}", data.positions().len());
    let mut properties = |kind: &str, names: &[&str]| {
        names.iter().for_each(|name| _ = writeln!(header, "property {kind} {name}"));
    };
    properties(coordinate, &["x", "y", "z"]);
    if mesh.vertex_normals.is_some() {
        properties("float", &["nx", "ny", "nz"]);
    }
    if !data.colours().is_empty() {
        properties("uchar", &["red", "green", "blue"]);
    }
    if mesh.vertex_uvs.is_some() {
        properties("float", &["s", "t"]);
    }
    let _ = writeln!(header, "element face {}\nproperty list uint uint vertex_indices", data.faces().len());
    let of_corners = mesh.vertex_uvs.is_none() && !data.uvs().is_empty();
    if of_corners {
        header.push_str("property list uint float texcoord\n");
    }
    header.push_str("end_header\n");
    let mut out = header.into_bytes();
    let mut push = |scalar: Scalar, x: f64| scalar.write(x, Encoding::Little, &mut out);
    for (v, p) in data.positions().iter().enumerate() {
        p.to_array().into_iter().for_each(|x| push(number, x));
        let normal = mesh.vertex_normals.as_ref().map(|normals| normals[v]);
        normal.iter().flat_map(DVec3::to_array).for_each(|x| push(Scalar::F32, x));
        let colour = data.colours().get(v);
        colour.into_iter().flatten().for_each(|x| push(Scalar::U8, (f64::from(*x) * 255.0).clamp(0.0, 255.0)));
        let uv = mesh.vertex_uvs.as_ref().map(|uvs| uvs[v]);
        uv.iter().flat_map(DVec2::to_array).for_each(|x| push(Scalar::F32, x));
    }
    for face in data.faces().iter() {
        push(Scalar::U32, face.len() as f64);
        face.iter().for_each(|corner| push(Scalar::U32, corner.position.into()));
        if of_corners {
            let uvs: Option<Vec<_>> = face.iter().map(|c| c.uv().map(|uv| data.uvs()[uv as usize])).collect();
            let uvs = uvs.unwrap_or_default();
            push(Scalar::U32, 2.0 * uvs.len() as f64);
            uvs.iter().flat_map(DVec2::to_array).for_each(|x| push(Scalar::F32, x));
        }
    }
    out
}
