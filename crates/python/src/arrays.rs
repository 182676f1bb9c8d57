//! Arrays of NumPy as numbers and indices, and back.

use glam::{DVec2, DVec3};
use numpy::{
    IntoPyArray as _, PyArray2, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods as _,
};
use planish_files::failure::Failure;
use planish_geometry::mesh::jagged::Index;
use pyo3::prelude::*;
use std::borrow::Cow;

/// Rows of three numbers, borrowed from an array (n×3). `name` is that of the array in errors.
pub(crate) fn points<'a>(array: &'a PyReadonlyArray2<f64>, name: &str) -> Result<&'a [DVec3], Failure> {
    let points: &[DVec3] = bytemuck::try_cast_slice(numbers(array, name, 3)?).map_err(|e| unusable(name, e))?;
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(not_finite(name, i)),
        None => Ok(points),
    }
}

/// Rows of two numbers, borrowed from an array (n×2).
pub(crate) fn pairs<'a>(array: &'a PyReadonlyArray2<f64>, name: &str) -> Result<&'a [DVec2], Failure> {
    let pairs: &[DVec2] = bytemuck::try_cast_slice(numbers(array, name, 2)?).map_err(|e| unusable(name, e))?;
    match pairs.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(not_finite(name, i)),
        None => Ok(pairs),
    }
}

fn numbers<'a>(array: &'a PyReadonlyArray2<f64>, name: &str, columns: usize) -> Result<&'a [f64], Failure> {
    let [rows, found] = [array.shape()[0], array.shape()[1]];
    if found != columns {
        return Err(Failure::Input(format!("`{name}` has the shape ({rows}, {found}) and needs (n, {columns})")));
    }
    array.as_slice().map_err(|e| unusable(name, e))
}

fn unusable(name: &str, error: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("`{name}` cannot be read: {error}"))
}

fn not_finite(name: &str, index: usize) -> Failure {
    Failure::Input(format!("`{name}[{index}]` is not finite"))
}

/// Makes an array (n×3) of points, without a copy.
pub(crate) fn array(py: Python, points: Vec<DVec3>) -> PyResult<Bound<PyArray2<f64>>> {
    let rows = points.len();
    let numbers: Vec<f64> = bytemuck::allocation::cast_vec(points);
    numbers.into_pyarray(py).reshape([rows, 3])
}

/// Makes an array (n×2) of pairs, without a copy.
pub(crate) fn array_of_pairs(py: Python, pairs: Vec<DVec2>) -> PyResult<Bound<PyArray2<f64>>> {
    let rows = pairs.len();
    let numbers: Vec<f64> = pairs.iter().flat_map(DVec2::to_array).collect();
    numbers.into_pyarray(py).reshape([rows, 2])
}

/// Indices, face after face, of one of the types that need no conversion by Python.
#[derive(FromPyObject)]
pub(crate) enum Indices<'py> {
    /// As NumPy makes them.
    Long(PyReadonlyArray1<'py, i64>),
    /// As planish has them; borrowed.
    Unsigned(PyReadonlyArray1<'py, u32>),
    /// As many readers of meshes make them.
    Int(PyReadonlyArray1<'py, i32>),
}

/// Number of corners of the faces.
#[derive(FromPyObject)]
pub(crate) enum Corners<'py> {
    /// Each face has its own number.
    Uneven(PyReadonlyArray1<'py, i64>),
    /// All faces have so many.
    Even(usize),
}

/// Faces that name elements of another array.
#[derive(Clone, Debug)]
pub(crate) struct Faces<'a> {
    /// Indices, face after face. #c
    indices: Cow<'a, [Index]>,
    corners: CornerCounts,
}

#[derive(Clone, Debug)]
enum CornerCounts {
    Even(usize),
    Uneven(Vec<usize>),
}

impl<'a> Faces<'a> {
    /// Checks faces: each has at least three corners, and each index is one of `count` elements of `target`.
    pub(crate) fn new(
        name: &str,
        indices: &'a Indices,
        corners: &Corners,
        target: &str,
        count: usize,
    ) -> Result<Self, Failure> {
        let corners = CornerCounts::new(name, corners)?;
        let place = |corner: usize| format!("`{name}[{}]`", corners.face(corner));
        let indices = match indices {
            Indices::Long(array) => Cow::Owned(converted(slice(array, name)?, place, target, count)?),
            Indices::Int(array) => Cow::Owned(converted(slice(array, name)?, place, target, count)?),
            Indices::Unsigned(array) => {
                let indices = slice(array, name)?;
                if let Some(c) = indices.iter().position(|&v| v as usize >= count) {
                    return Err(out_of_range(&place(c), indices[c], target, count));
                }
                Cow::Borrowed(indices)
            }
        };
        let needed = corners.total(indices.len());
        if needed != indices.len() {
            let found = indices.len();
            return Err(Failure::Input(format!(
                "`{name}` has {found} indices and needs {needed}, one for each corner"
            )));
        }
        if indices.is_empty() {
            return Err(Failure::Input(format!("`{name}` is empty")));
        }
        Ok(Self { indices, corners })
    }

    /// Indices of all corners. #c
    pub(crate) fn indices(&self) -> &[Index] {
        &self.indices
    }

    /// Number of faces.
    pub(crate) fn len(&self) -> usize {
        match &self.corners {
            CornerCounts::Even(corners) => self.indices.len() / corners,
            CornerCounts::Uneven(counts) => counts.len(),
        }
    }

    /// Indices of each face. #f
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[Index]> {
        let mut rest = &*self.indices;
        (0..self.len()).map(move |f| {
            let count = match &self.corners {
                CornerCounts::Even(count) => *count,
                CornerCounts::Uneven(counts) => counts[f],
            };
            let (face, after) = rest.split_at(count);
            rest = after;
            face
        })
    }
}

impl CornerCounts {
    fn new(name: &str, corners: &Corners) -> Result<Self, Failure> {
        let too_few = |face: usize, corners: i64| {
            Failure::Input(format!("`{name}[{face}]` has {corners} corners and needs at least three"))
        };
        match corners {
            Corners::Even(count @ 0..3) => Err(too_few(0, *count as i64)),
            Corners::Even(count) => Ok(Self::Even(*count)),
            Corners::Uneven(array) => {
                let counts = slice(array, name)?.iter().enumerate();
                let count = |(face, &count): (usize, &i64)| match usize::try_from(count) {
                    Ok(corners @ 3..) => Ok(corners),
                    _ => Err(too_few(face, count)),
                };
                Ok(Self::Uneven(counts.map(count).collect::<Result<_, _>>()?))
            }
        }
    }

    /// Number of corners of all faces, of which there are `found` indices.
    fn total(&self, found: usize) -> usize {
        match self {
            Self::Even(count) => found.div_ceil(*count) * count,
            Self::Uneven(counts) => counts.iter().fold(0, |sum: usize, count| sum.saturating_add(*count)),
        }
    }

    /// Index of the face of a corner.
    fn face(&self, corner: usize) -> usize {
        match self {
            Self::Even(count) => corner / count,
            Self::Uneven(counts) => {
                let ends = counts.iter().scan(0, |end: &mut usize, count| {
                    *end = end.saturating_add(*count);
                    Some(*end)
                });
                ends.take_while(|end| *end <= corner).count()
            }
        }
    }
}

/// Weights, borrowed from an array (n).
pub(crate) fn weights<'a>(array: Option<&'a PyReadonlyArray1<f32>>) -> Result<Option<&'a [f32]>, Failure> {
    array.map(|array| slice(array, "mask")).transpose()
}

fn slice<'a, T: numpy::Element>(array: &'a PyReadonlyArray1<T>, name: &str) -> Result<&'a [T], Failure> {
    array.as_slice().map_err(|e| unusable(name, e))
}

/// Converts indices, each of which has to be one of `count` elements.
fn converted<T: Copy + TryInto<Index> + std::fmt::Display>(
    indices: &[T],
    place: impl Fn(usize) -> String,
    target: &str,
    count: usize,
) -> Result<Vec<Index>, Failure> {
    let convert = |(corner, value): (usize, &T)| match (*value).try_into() {
        Ok(index) if (index as usize) < count => Ok(index),
        _ => Err(out_of_range(&place(corner), value, target, count)),
    };
    indices.iter().enumerate().map(convert).collect()
}

fn out_of_range(place: &str, named: impl std::fmt::Display, target: &str, count: usize) -> Failure {
    Failure::Input(format!("{place} names element {named} of `{target}`, which has {count}"))
}
