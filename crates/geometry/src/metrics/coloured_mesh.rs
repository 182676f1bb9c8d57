//! Files of meshes with a colour for each vertex, for display in other programs.
//!
//! ```
//! use planish_geometry::metrics::{Triangles, coloured_mesh};
//! use planish_geometry::source::obj::{Obj, ObjError};
//!
//! let obj = Obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec())?;
//! let bytes = coloured_mesh::obj(&Triangles::from(obj.data()), &[[255, 0, 51]; 3], "errors");
//! let text = String::from_utf8(bytes).unwrap();
//! assert!(text.starts_with("# errors\nv 0 0 0 1.0000 0.0000 0.2000\n") && text.ends_with("\nf 1 2 3\n"), "{text}");
//! # Ok::<(), ObjError>(())
//! ```

use crate::metrics::Triangles;
use std::fmt::Write as _;

/// Writes a binary little-endian PLY file: positions in double precision, colours (#V×3, encoded sRGB of 8 bits), and
/// triangles. The number that a colour stands for (#V) becomes the property `quality`, as MeshLab calls it. `comment` is one
/// line of the header.
///
/// # Panics
/// If there is not one colour and one number for each vertex.
pub fn ply(mesh: &Triangles, colours: &[[u8; 3]], quality: &[f64], comment: &str) -> Vec<u8> {
    let (positions, faces) = (mesh.positions(), mesh.triangles());
    assert_eq!([colours.len(), quality.len()], [positions.len(); 2], "one colour and one number for each vertex");
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        comment.replace(char::is_control, " "),
        positions.len(),
        faces.len()
    );
    let mut out = header.into_bytes();
    out.reserve(31 * positions.len() + 13 * faces.len());
    for ((p, colour), x) in positions.iter().zip(colours).zip(quality) {
        p.to_array().iter().for_each(|c| out.extend(c.to_le_bytes()));
        out.extend(colour);
        out.extend((*x as f32).to_le_bytes());
    }
    for face in faces {
        out.push(3);
        face.iter().for_each(|v| out.extend(v.to_le_bytes()));
    }
    out
}

/// Writes an OBJ file with colours (#V×3, encoded sRGB of 8 bits) as numbers 0 to 1 after the coordinates of each `v` line, as
/// MeshLab and Blender read them. `comment` is its first line.
///
/// # Panics
/// If there is not one colour for each vertex.
pub fn obj(mesh: &Triangles, colours: &[[u8; 3]], comment: &str) -> Vec<u8> {
    assert_eq!(colours.len(), mesh.positions().len(), "one colour for each vertex");
    let mut out = format!("# {}\n", comment.replace(char::is_control, " "));
    for (p, colour) in mesh.positions().iter().zip(colours) {
        let [r, g, b] = colour.map(|c| f32::from(c) / 255.0);
        let _ = writeln!(out, "v {} {} {} {r:.4} {g:.4} {b:.4}", p.x, p.y, p.z);
    }
    for [a, b, c] in mesh.triangles() {
        let _ = writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    out.into_bytes()
}
