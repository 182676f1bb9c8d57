//! Writer of meshes that did not come from an OFF file.

use crate::source::convert::Attributes;
use crate::source::patch::push_number;

/// Prints a mesh, with those normals, colours and texture coordinates that belong to its vertices.
pub(in crate::source) fn print(mesh: &Attributes) -> Vec<u8> {
    let data = mesh.data;
    let word = |has: bool, word: &'static str| if has { word } else { "" };
    let has_colours = !data.colours().is_empty();
    let uvs = word(mesh.vertex_uvs.is_some(), "ST");
    let (colours, normals) = (word(has_colours, "C"), word(mesh.vertex_normals.is_some(), "N"));
    let (v, f) = (data.positions().len(), data.faces().len());
    let mut out = format!("{uvs}{colours}{normals}OFF\n{v} {f} 0\n").into_bytes();
    for (v, p) in data.positions().iter().enumerate() {
        push_number(&mut out, p.x);
        let push = |out: &mut Vec<u8>, x: f64| {
            out.push(b' ');
            push_number(out, x);
        };
        [p.y, p.z].into_iter().for_each(|x| push(&mut out, x));
        mesh.vertex_normals.iter().flat_map(|normals| normals[v].to_array()).for_each(|x| push(&mut out, x));
        if let Some(colour) = data.colours().get(v) {
            // Whole numbers, which more programs read than fractions.
            for x in colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8).into_iter().chain([u8::MAX]) {
                out.push(b' ');
                out.extend(itoa::Buffer::new().format(x).as_bytes());
            }
        }
        mesh.vertex_uvs.iter().flat_map(|uvs| uvs[v].to_array()).for_each(|x| push(&mut out, x));
        out.push(b'\n');
    }
    for face in data.faces().iter() {
        out.extend(itoa::Buffer::new().format(face.len()).as_bytes());
        for corner in face {
            out.push(b' ');
            out.extend(itoa::Buffer::new().format(corner.position).as_bytes());
        }
        out.push(b'\n');
    }
    out
}
