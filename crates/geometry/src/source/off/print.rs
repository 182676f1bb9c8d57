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
        let mut separator = None;
        let mut push = |x: f64| {
            out.extend(separator);
            push_number(&mut out, x);
            separator = Some(b' ');
        };
        p.to_array().into_iter().for_each(&mut push);
        mesh.vertex_normals.iter().flat_map(|normals| normals[v].to_array()).for_each(&mut push);
        let colour = data.colours().get(v).map(|[r, g, b]| [*r, *g, *b, 1.0]);
        // The shortest decimal of single precision, as double precision.
        let decimal = |x: f32| ryu::Buffer::new().format(x).parse().unwrap_or(f64::from(x));
        colour.into_iter().flatten().map(decimal).for_each(&mut push);
        mesh.vertex_uvs.iter().flat_map(|uvs| uvs[v].to_array()).for_each(&mut push);
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
