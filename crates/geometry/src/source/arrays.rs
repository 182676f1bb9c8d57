//! Arrays as a source: a mesh that a program holds in memory.

use super::mesh_data::{Corner, MaterialRun, MeshData};
use crate::mesh::jagged::{Index, Ragged};
use glam::{DVec2, DVec3};

/// Arrays of a mesh, which [`MeshData::try_from`] checks. An array is empty if the mesh does not have that attribute.
///
/// ```
/// use planish_geometry::source::model::Model;
/// use planish_geometry::source::{Arrays, MeshData};
/// use planish_geometry::mesh::weld::Welding;
///
/// let arrays = Arrays {
///     positions: vec![[0.0, 0.0, 0.0].into(), [1.0, 0.0, 0.0].into(), [0.0, 1.0, 0.0].into()],
///     faces: [vec![0, 1, 2]].into_iter().collect(),
///     ..Arrays::default()
/// };
/// let model = Model::new(MeshData::try_from(arrays)?, Welding::Exact);
/// assert_eq!(model.surface().area(), 0.5);
/// # Ok::<(), planish_geometry::source::ArrayError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrays {
    /// Positions of the source vertices. #v×3, model units
    pub positions: Vec<DVec3>,
    /// Source vertices around each face, counter-clockwise seen from outside. #f
    pub faces: Ragged<Index>,
    /// Colours of the source vertices: red, green and blue, 0..=1. #v×3
    pub colours: Vec<[f32; 3]>,
    /// Texture coordinates, v up. #vt×2
    pub uvs: Vec<DVec2>,
    /// Index of the texture coordinate of each corner, face after face. If this is empty and there are texture coordinates,
    /// each source vertex has its own. #c
    pub corner_uvs: Vec<Option<Index>>,
    /// Normals of any length. #vn×3
    pub normals: Vec<DVec3>,
    /// Index of the normal of each corner, face after face. If this is empty and there are normals, each source vertex has
    /// its own. #c
    pub corner_normals: Vec<Option<Index>>,
    /// Names of the materials, one line each.
    pub materials: Vec<String>,
    /// Index of the material of each face. #f
    pub face_materials: Vec<Option<Index>>,
}

/// Reasons why arrays are no mesh; `array` is the name of a field of [`Arrays`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrayError {
    /// The array is empty, but a mesh needs positions and faces.
    #[error("`{array}` is empty")]
    Empty {
        /// Name of the array.
        array: &'static str,
    },
    /// The array has another length than the one that its elements belong to.
    #[error("`{array}` has {found} elements and needs {needed}, one for each {each}")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Number of its elements.
        found: usize,
        /// Number of elements that it should have.
        needed: usize,
        /// Kind of thing that has one element: position, corner or face.
        each: &'static str,
    },
    /// The element is NaN or infinite.
    #[error("`{array}[{index}]` is not finite")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Index of the element.
        index: usize,
    },
    /// The face has fewer than three corners.
    #[error("`faces[{face}]` has {corners} corners and needs at least three")]
    TooFewCorners {
        /// Index of the face.
        face: usize,
        /// Number of its corners.
        corners: usize,
    },
    /// The element is an index of another array and names no element there.
    #[error("`{array}[{index}]` names element {named} of `{target}`, which has {count}")]
    OutOfRange {
        /// Name of the array.
        array: &'static str,
        /// Index of the face for `faces` and `face_materials`, else of the corner.
        index: usize,
        /// Value of the element, which is out of range.
        named: Index,
        /// Name of the array that the value should index.
        target: &'static str,
        /// Number of elements of `target`.
        count: usize,
    },
    /// The name of the material is longer than one line.
    #[error("`materials[{index}]` contains a line break")]
    LineBreak {
        /// Index of the material.
        index: usize,
    },
    /// The array has more elements than 32 bits can count.
    #[error("`{array}` has more than 2^32 − 2 elements")]
    TooLarge {
        /// Name of the array.
        array: &'static str,
    },
}

impl TryFrom<Arrays> for MeshData {
    type Error = ArrayError;

    fn try_from(arrays: Arrays) -> Result<Self, ArrayError> {
        arrays.check()?;
        let Arrays { positions, faces, colours, uvs, corner_uvs, normals, corner_normals, materials, face_materials } =
            arrays;
        let named = |of_corners: &[Option<Index>], values: usize, corner: usize, vertex: Index| {
            if of_corners.is_empty() { (values > 0).then_some(vertex) } else { of_corners[corner] }
        };
        let mut corners = Ragged::default();
        for face in 0..faces.len() as Index {
            let vertices = faces.range(face).zip(faces.get(face));
            corners.push(vertices.map(|(corner, &vertex)| {
                let uv = named(&corner_uvs, uvs.len(), corner, vertex);
                Corner::new(vertex, uv, named(&corner_normals, normals.len(), corner, vertex))
            }));
        }
        let mut material_runs: Vec<MaterialRun> = Vec::new();
        for (first_face, material) in (0..).zip(face_materials) {
            if material_runs.last().and_then(|run| run.material) != material {
                material_runs.push(MaterialRun { first_face, material });
            }
        }
        let materials = materials.into_iter().map(String::into_bytes).collect();
        let (face_lines, unplaced) = (Vec::new(), Vec::new());
        Ok(Self { positions, colours, uvs, normals, faces: corners, face_lines, materials, material_runs, unplaced })
    }
}

impl Arrays {
    fn check(&self) -> Result<(), ArrayError> {
        self.check_lengths()?;
        finite("positions", &self.positions, |p| p.is_finite())?;
        finite("colours", &self.colours, |c| c.iter().all(|x| x.is_finite()))?;
        finite("uvs", &self.uvs, |uv| uv.is_finite())?;
        finite("normals", &self.normals, |n| n.is_finite())?;
        for (index, face) in self.faces.iter().enumerate() {
            if face.len() < 3 {
                return Err(ArrayError::TooFewCorners { face: index, corners: face.len() });
            }
            let stray = face.iter().find(|&&v| v as usize >= self.positions.len());
            if let Some(&named) = stray {
                let (array, target, count) = ("faces", "positions", self.positions.len());
                return Err(ArrayError::OutOfRange { array, index, named, target, count });
            }
        }
        in_range("corner_uvs", &self.corner_uvs, "uvs", self.uvs.len())?;
        in_range("corner_normals", &self.corner_normals, "normals", self.normals.len())?;
        in_range("face_materials", &self.face_materials, "materials", self.materials.len())?;
        let broken = self.materials.iter().position(|name| name.contains(['\n', '\r']));
        broken.map_or(Ok(()), |index| Err(ArrayError::LineBreak { index }))
    }

    fn check_lengths(&self) -> Result<(), ArrayError> {
        let (vertices, faces, corners) = (self.positions.len(), self.faces.len(), self.faces.items().len());
        let [uvs, normals] = [self.uvs.len(), self.normals.len()];
        for (array, found) in [("positions", vertices), ("faces", faces)] {
            if found == 0 {
                return Err(ArrayError::Empty { array });
            }
        }
        for (array, found) in [("positions", vertices), ("faces", corners), ("uvs", uvs), ("normals", normals)] {
            if found >= Index::MAX as usize {
                return Err(ArrayError::TooLarge { array });
            }
        }
        // Attributes without indices for the corners belong to the source vertices.
        let of_vertices = |values: usize, of_corners: &[_]| if of_corners.is_empty() { values } else { 0 };
        for (array, found, needed, each) in [
            ("colours", self.colours.len(), vertices, "position"),
            ("uvs", of_vertices(uvs, &self.corner_uvs), vertices, "position"),
            ("corner_uvs", self.corner_uvs.len(), corners, "corner"),
            ("normals", of_vertices(normals, &self.corner_normals), vertices, "position"),
            ("corner_normals", self.corner_normals.len(), corners, "corner"),
            ("face_materials", self.face_materials.len(), faces, "face"),
        ] {
            if found != 0 && found != needed {
                return Err(ArrayError::Length { array, found, needed, each });
            }
        }
        Ok(())
    }
}

fn finite<T>(array: &'static str, values: &[T], is_finite: impl Fn(&T) -> bool) -> Result<(), ArrayError> {
    let stray = values.iter().position(|value| !is_finite(value));
    stray.map_or(Ok(()), |index| Err(ArrayError::NotFinite { array, index }))
}

fn in_range(
    array: &'static str,
    indices: &[Option<Index>],
    target: &'static str,
    count: usize,
) -> Result<(), ArrayError> {
    let strays = indices.iter().enumerate().filter_map(|(index, named)| Some((index, (*named)?)));
    let stray = strays.into_iter().find(|(_, named)| *named as usize >= count);
    stray.map_or(Ok(()), |(index, named)| Err(ArrayError::OutOfRange { array, index, named, target, count }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles with every attribute.
    fn square() -> Arrays {
        Arrays {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            faces: [vec![0, 1, 2], vec![0, 2, 3]].into_iter().collect(),
            colours: vec![[0.5; 3]; 4],
            uvs: vec![DVec2::ZERO, DVec2::ONE],
            corner_uvs: vec![Some(0), None, Some(1), Some(0), Some(1), None],
            normals: vec![DVec3::Z],
            corner_normals: vec![Some(0); 6],
            materials: vec!["skin".into()],
            face_materials: vec![Some(0), None],
        }
    }

    #[test]
    fn corners_and_faces_name_what_the_arrays_say() {
        let mesh = MeshData::try_from(square()).unwrap();
        let named: Vec<_> = mesh.faces().get(1).iter().map(|c| (c.position, c.uv(), c.normal())).collect();
        assert_eq!(named, [(0, Some(0), Some(0)), (2, Some(1), Some(0)), (3, None, Some(0))]);
        assert_eq!([0, 1].map(|f| mesh.face_material(f)), [Some(0), None]);
        assert!(mesh.has_faces_without_material());
        assert_eq!(mesh.face_line(0), None);
    }

    #[test]
    fn attributes_without_indices_belong_to_the_source_vertices() {
        let uvs = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let mesh = MeshData::try_from(Arrays { uvs, corner_uvs: Vec::new(), ..square() }).unwrap();
        assert!(mesh.faces().items().iter().all(|c| c.uv() == Some(c.position)));
    }

    #[test]
    fn whatever_is_wrong_is_named_with_array_and_index() {
        let with = |edit: &dyn Fn(&mut Arrays)| {
            let mut arrays = square();
            edit(&mut arrays);
            MeshData::try_from(arrays).unwrap_err().to_string()
        };
        type Edit<'a> = &'a dyn Fn(&mut Arrays);
        let cases: [(Edit, &str); 13] = [
            (&|a| a.positions.clear(), "`positions` is empty"),
            (&|a| a.faces = Ragged::default(), "`faces` is empty"),
            (&|a| a.positions[2].y = f64::NAN, "`positions[2]` is not finite"),
            (&|a| a.colours[3][0] = f32::INFINITY, "`colours[3]` is not finite"),
            (&|a| a.uvs[1].x = f64::INFINITY, "`uvs[1]` is not finite"),
            (&|a| a.normals[0].z = f64::NAN, "`normals[0]` is not finite"),
            (&|a| a.colours.truncate(1), "`colours` has 1 elements and needs 4, one for each position"),
            (&|a| a.corner_uvs.truncate(5), "`corner_uvs` has 5 elements and needs 6, one for each corner"),
            (&|a| a.corner_uvs.clear(), "`uvs` has 2 elements and needs 4, one for each position"),
            (&|a| a.faces.push([1, 2]), "`corner_uvs` has 6 elements and needs 8, one for each corner"),
            (&|a| a.corner_normals[4] = Some(7), "`corner_normals[4]` names element 7 of `normals`, which has 1"),
            (&|a| a.face_materials[1] = Some(1), "`face_materials[1]` names element 1 of `materials`, which has 1"),
            (&|a| a.materials[0] = "a\nb".into(), "`materials[0]` contains a line break"),
        ];
        for (edit, words) in cases {
            assert_eq!(with(edit), words);
        }
        let plain = |faces: Vec<Vec<Index>>| {
            let positions = square().positions;
            MeshData::try_from(Arrays { positions, faces: faces.into_iter().collect(), ..Arrays::default() })
        };
        let error = plain(vec![vec![0, 1, 2], vec![1, 2]]).unwrap_err();
        assert_eq!(error.to_string(), "`faces[1]` has 2 corners and needs at least three");
        let error = plain(vec![vec![0, 1, 2], vec![1, 2, 4]]).unwrap_err();
        assert_eq!(error.to_string(), "`faces[1]` names element 4 of `positions`, which has 4");
    }
}
