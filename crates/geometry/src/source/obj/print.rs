//! Writer of meshes that did not come from an OBJ file, and the lines that all writers share.

use crate::mesh::jagged::Index;
use crate::source::materials::CARRIER_MATERIAL;
use crate::source::patch::push_number;
use crate::source::{Corner, MeshData};
use glam::{DVec3, Vec2, Vec3};

const EOL: &[u8] = b"\n";

/// Prints mesh data as an OBJ file that reads back to the same numbers.
pub(crate) fn print(data: &MeshData) -> Vec<u8> {
    let mut out = Vec::new();
    push_positions(&mut out, data, data.positions());
    data.uvs().iter().for_each(|uv| push_numbers(&mut out, "vt", uv.to_array(), EOL));
    data.normals().iter().for_each(|n| push_numbers(&mut out, "vn", n.to_array(), EOL));
    push_faces(&mut out, data, Some(None), |corner| corner);
    out
}

/// Prints mesh data as the carrier of a displacement map; the parameters are those of
/// [`Source::carrier`](crate::source::Source::carrier).
///
/// # Panics
/// If a list has not one element for each source vertex.
pub(crate) fn print_carrier(
    data: &MeshData,
    positions: &[DVec3],
    normals: &[Vec3],
    uvs: Option<&[Vec2]>,
    material_library: &str,
) -> Vec<u8> {
    let count = data.positions().len();
    assert_eq!([positions.len(), normals.len()], [count; 2], "one position and one normal for each source vertex");
    assert!(uvs.is_none_or(|uvs| uvs.len() == count), "one texture coordinate for each source vertex");
    let mut out = Vec::new();
    push_line(&mut out, "mtllib", material_library.as_bytes(), EOL);
    push_positions(&mut out, data, positions);
    if uvs.is_none() {
        data.uvs().iter().for_each(|uv| push_numbers(&mut out, "vt", uv.to_array(), EOL));
    }
    push_attributes(&mut out, normals, uvs, EOL);
    push_faces(&mut out, data, None, |corner| {
        let uv = if uvs.is_some() { Some(corner.position) } else { corner.uv() };
        carrier_corner(corner.position, uv)
    });
    out
}

/// Printer of the lines of a carrier, one by one, for meshes that are larger than memory: first positions, then as many normals, and
/// then faces.
#[derive(Debug, Default)]
pub struct CarrierLines(Vec<u8>);

impl CarrierLines {
    /// Begins a carrier with this material library, whose faces have the material [`CARRIER_MATERIAL`].
    pub fn begin(material_library: &str) -> Self {
        let mut lines = Self::default();
        push_line(&mut lines.0, "mtllib", material_library.as_bytes(), EOL);
        push_line(&mut lines.0, "usemtl", CARRIER_MATERIAL.as_bytes(), EOL);
        lines
    }
    /// Appends the position of a source vertex.
    pub fn position(&mut self, p: DVec3) {
        push_numbers(&mut self.0, "v", p.to_array(), EOL);
    }
    /// Appends the normal of a source vertex.
    pub fn normal(&mut self, n: Vec3) {
        push_numbers(&mut self.0, "vn", n.to_array(), EOL);
    }
    /// Appends a face by the indices of its source vertices, each of which has the normal of the same index.
    pub fn face(&mut self, vertices: &[Index]) {
        self.0.push(b'f');
        for &v in vertices {
            self.0.push(b' ');
            push_corner(&mut self.0, carrier_corner(v, None));
        }
        self.0.extend_from_slice(EOL);
    }
    /// Number of bytes that have been printed since they were taken last.
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// Whether nothing has been printed since the bytes were taken last.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// Takes the bytes that have been printed.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.0)
    }
}

fn push_positions(out: &mut Vec<u8>, data: &MeshData, positions: &[DVec3]) {
    if data.colours().is_empty() {
        positions.iter().for_each(|p| push_numbers(out, "v", p.to_array(), EOL));
    }
    for (p, colour) in positions.iter().zip(data.colours()) {
        push_numbers(out, "v", p.to_array(), b"");
        push_numbers(out, "", *colour, EOL);
    }
}

/// Appends the faces with their materials. `current` is the material that a reader assumes before the first `usemtl`: `None`
/// makes a `usemtl` precede the first face in any case.
fn push_faces(out: &mut Vec<u8>, data: &MeshData, mut current: Option<Option<Index>>, new: impl Fn(Corner) -> Corner) {
    for (face, corners) in (0..).zip(data.faces().iter()) {
        let material = data.face_material(face);
        if current != Some(material) {
            let name = material.map_or(CARRIER_MATERIAL.as_bytes(), |m| &data.materials()[m as usize]);
            push_line(out, "usemtl", name, EOL);
            current = Some(material);
        }
        out.push(b'f');
        for corner in corners {
            out.push(b' ');
            push_corner(out, new(*corner));
        }
        out.extend_from_slice(EOL);
    }
}

/// Builds a corner of a carrier, whose normal has the index of the source vertex.
pub(super) fn carrier_corner(position: Index, uv: Option<Index>) -> Corner {
    Corner::new(position, uv, Some(position))
}

/// Appends a corner as `v`, `v/vt`, `v//vn` or `v/vt/vn`.
pub(super) fn push_corner(out: &mut Vec<u8>, corner: Corner) {
    push_index(out, corner.position);
    if corner.uv().is_some() || corner.normal().is_some() {
        out.push(b'/');
    }
    if let Some(uv) = corner.uv() {
        push_index(out, uv);
    }
    if let Some(normal) = corner.normal() {
        out.push(b'/');
        push_index(out, normal);
    }
}

/// Appends `vt` lines and then `vn` lines.
pub(super) fn push_attributes(out: &mut Vec<u8>, normals: &[Vec3], uvs: Option<&[Vec2]>, eol: &[u8]) {
    uvs.into_iter().flatten().for_each(|uv| push_numbers(out, "vt", uv.to_array(), eol));
    normals.iter().for_each(|n| push_numbers(out, "vn", n.to_array(), eol));
}

/// Appends a statement with one argument, which may be in any encoding.
pub(super) fn push_line(out: &mut Vec<u8>, keyword: &str, argument: &[u8], eol: &[u8]) {
    out.extend_from_slice(keyword.as_bytes());
    out.push(b' ');
    out.extend_from_slice(argument);
    out.extend_from_slice(eol);
}

fn push_numbers<const N: usize>(out: &mut Vec<u8>, keyword: &str, numbers: [impl ryu::Float; N], eol: &[u8]) {
    out.extend_from_slice(keyword.as_bytes());
    for x in numbers {
        out.push(b' ');
        push_number(out, x);
    }
    out.extend_from_slice(eol);
}

fn push_index(out: &mut Vec<u8>, index: Index) {
    out.extend_from_slice(itoa::Buffer::new().format(u64::from(index) + 1).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Arrays;
    use crate::source::obj::Obj;
    use glam::DVec2;

    /// A mesh with every attribute, and numbers that need all their digits.
    fn mesh() -> MeshData {
        let third = 1.0 / 3.0;
        let arrays = Arrays {
            positions: vec![DVec3::splat(third), DVec3::new(1e-300, -0.0, 7e22), DVec3::Y, DVec3::NEG_X],
            faces: [vec![0, 1, 2], vec![0, 2, 3], vec![3, 2, 1, 0]].into_iter().collect(),
            colours: vec![[0.1, 0.5, 1.0]; 4],
            uvs: vec![DVec2::splat(third), DVec2::ONE],
            corner_uvs: [0, 1, 1, 0, 1, 0, 1, 0, 1, 1].map(Some).to_vec(),
            normals: vec![DVec3::splat(third)],
            corner_normals: [vec![None; 6], vec![Some(0); 4]].concat(),
            materials: vec!["two words".into()],
            face_materials: vec![None, Some(0), None],
        };
        arrays.try_into().unwrap()
    }

    fn corners(data: &MeshData) -> Vec<&[Corner]> {
        data.faces().iter().collect()
    }

    #[test]
    fn a_printed_mesh_reads_back_bit_for_bit() {
        let mesh = mesh();
        let read = Obj::parse(print(&mesh)).unwrap();
        let read = read.data();
        let bits =
            |data: &MeshData| data.positions().iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(read), bits(&mesh));
        assert_eq!((read.uvs(), read.normals()), (mesh.uvs(), mesh.normals()));
        assert_eq!(read.colours(), mesh.colours());
        assert_eq!(corners(read), corners(&mesh));
        // OBJ has no statement that ends the use of a material.
        let names = |data: &MeshData, f| data.face_material(f).map(|m| data.materials()[m as usize].clone());
        assert_eq!([0, 1].map(|f| names(read, f)), [0, 1].map(|f| names(&mesh, f)));
        assert_eq!(names(read, 2).unwrap(), CARRIER_MATERIAL.as_bytes());
    }

    #[test]
    fn a_printed_carrier_is_that_of_the_printed_mesh() {
        let mesh = mesh();
        let obj = Obj::parse(print(&mesh)).unwrap();
        let positions: Vec<DVec3> = mesh.positions().iter().map(|p| *p * 3.0).collect();
        let normals: Vec<Vec3> = (0..4).map(|k| Vec3::new(0.1, 0.7, k as f32)).collect();
        let new_uvs: Vec<Vec2> = (0..4).map(|k| Vec2::new(0.1, k as f32)).collect();
        for uvs in [None, Some(new_uvs.as_slice())] {
            let printed = Obj::parse(print_carrier(&mesh, &positions, &normals, uvs, "a b.mtl")).unwrap();
            let patched = Obj::parse(obj.carrier(&positions, &normals, uvs, "a b.mtl")).unwrap();
            let (printed, patched, extras) = (printed.data(), patched.data(), printed.extras());
            assert_eq!(printed.positions(), patched.positions());
            assert_eq!(printed.normals(), patched.normals());
            assert_eq!(printed.uvs(), patched.uvs());
            assert_eq!(printed.colours(), patched.colours());
            assert_eq!(corners(printed), corners(patched));
            assert_eq!(printed.materials(), patched.materials());
            assert!(!printed.has_faces_without_material());
            assert_eq!(extras.material_libraries, [b"a b.mtl".to_vec()]);
        }
    }
}
