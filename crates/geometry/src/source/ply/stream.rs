//! Binary PLY files piece by piece.

use super::VertexProperties;
use super::header::{Element, Header};
use super::rewrite::replaced;
use super::scalar::{Encoding, Scalar};
use crate::mesh::jagged::Index;
use crate::source::read_error::{Place, ReadError, ReadErrorKind};
use crate::source::stream::piece::{Change, Piece, Receiver};
use glam::DVec3;
use std::ops::Range;

/// State of a file that is read or rewritten piece by piece.
#[derive(Debug)]
pub(crate) struct PlyStream {
    header: Header,
    vertex: VertexProperties,
    /// Offset of each coordinate in the bytes of a vertex.
    offsets: [usize; 3],
    is_in_header: bool,
    /// Element that comes next, and its index among those of its kind.
    element: usize,
    index: u64,
    faces: usize,
}

/// An element in a piece.
enum Found<'a> {
    /// Bytes of a vertex.
    Vertex(Range<usize>),
    /// Vertices of a face.
    Face(&'a [Index]),
}

impl PlyStream {
    pub(crate) fn begin(first: &[u8], size: u64) -> Result<Self, ReadError> {
        let header = Header::parse_of(first, usize::try_from(size).unwrap_or(usize::MAX))?;
        let vertices = &header.elements[header.vertex];
        let vertex = VertexProperties::of(vertices)?;
        let unsupported = |what: &str| {
            let reason = format!("{what} cannot be read piece by piece: convert it to a binary PLY or an OBJ");
            Err(ReadErrorKind::Malformed(reason).at(Place::File))
        };
        if header.encoding == Encoding::Text {
            return unsupported("a PLY text file");
        }
        if vertices.stride().is_none() {
            return unsupported("vertices with lists");
        }
        if header.elements.iter().any(|e| e.name == "tristrips") {
            return unsupported("triangle strips");
        }
        if vertices.count >= Index::MAX.into() {
            return Err(ReadErrorKind::TooLarge.at(Place::File));
        }
        let offset = |axis: usize| vertices.properties[..vertex.position[axis]].iter().map(|p| p.scalar.size()).sum();
        let offsets = [0, 1, 2].map(offset);
        Ok(Self { header, vertex, offsets, is_in_header: true, element: 0, index: 0, faces: 0 })
    }

    pub(crate) fn read(&mut self, piece: Piece, receiver: &mut dyn Receiver) -> Result<usize, ReadError> {
        let (scalars, offsets, encoding) = (self.scalars(), self.offsets, self.header.encoding);
        let first = if self.element == self.header.vertex { self.index } else { 0 };
        let mut vertex = first;
        self.walk(piece, &mut |found| match found {
            Found::Vertex(range) => {
                let coordinate = |axis: usize| {
                    let at = range.start + offsets[axis];
                    scalars[axis].read(&piece.bytes[at..at + scalars[axis].size()], encoding)
                };
                let position = DVec3::from_array([0, 1, 2].map(coordinate));
                if !position.is_finite() {
                    return Err(ReadErrorKind::Malformed(format!(
                        "vertex {vertex} has a coordinate that is not finite"
                    )));
                }
                vertex += 1;
                receiver.vertex(position);
                Ok(())
            }
            Found::Face(vertices) => {
                receiver.face(vertices);
                Ok(())
            }
        })
    }

    pub(crate) fn finish(&self) -> Result<(), ReadError> {
        let element = self.header.elements[self.element.min(self.header.elements.len())..].iter().find(|e| e.count > 0);
        if let Some(element) = element {
            let (element, index) = (element.name.clone(), self.index);
            return Err(ReadErrorKind::Ends { element, index }.at(Place::File));
        }
        if self.header.elements[self.header.vertex].count == 0 {
            return Err(ReadErrorKind::NoVertices.at(Place::File));
        }
        if self.faces == 0 { Err(ReadErrorKind::NoFaces.at(Place::File)) } else { Ok(()) }
    }

    pub(crate) fn rewrite(
        &mut self,
        piece: Piece,
        next: &mut dyn FnMut() -> Change,
        out: &mut Vec<u8>,
    ) -> Result<usize, ReadError> {
        let (scalars, offsets, encoding) = (self.scalars(), self.offsets, self.header.encoding);
        let mut copied = 0;
        let taken = self.walk(piece, &mut |found| {
            if let Found::Vertex(range) = found {
                out.extend_from_slice(&piece.bytes[copied..range.end]);
                copied = range.end;
                let vertex = out.len() - range.len();
                let change = next();
                for axis in 0..3 {
                    let [before, after] = change.map(|p| p[axis]);
                    if let Some(number) = replaced(scalars[axis], before, after) {
                        let mut bytes = Vec::with_capacity(8);
                        scalars[axis].write(number, encoding, &mut bytes);
                        out[vertex + offsets[axis]..][..bytes.len()].copy_from_slice(&bytes);
                    }
                }
            }
            Ok(())
        })?;
        out.extend_from_slice(&piece.bytes[copied..taken]);
        Ok(taken)
    }

    fn scalars(&self) -> [Scalar; 3] {
        let properties = &self.header.elements[self.header.vertex].properties;
        self.vertex.position.map(|p| properties[p].scalar)
    }

    /// Walks over the elements that are whole in a piece, and returns how many bytes they have.
    fn walk(
        &mut self,
        piece: Piece,
        on: &mut dyn FnMut(Found) -> Result<(), ReadErrorKind>,
    ) -> Result<usize, ReadError> {
        let mut at = 0;
        if self.is_in_header {
            if piece.bytes.len() < self.header.end {
                return Ok(0);
            }
            at = self.header.end;
            self.is_in_header = false;
        }
        let mut corners = Vec::new();
        let vertices = self.header.elements[self.header.vertex].count;
        while let Some(element) = self.header.elements.get(self.element) {
            if self.index == element.count {
                (self.element, self.index) = (self.element + 1, 0);
                continue;
            }
            corners.clear();
            let is_face = element.name == "face";
            let end = element_end(element, self.header.encoding, piece.bytes, at, is_face.then_some(&mut corners));
            let Some(end) = end else {
                if piece.is_last {
                    let (element, index) = (element.name.clone(), self.index);
                    return Err(ReadErrorKind::Ends { element, index }.at(Place::File));
                }
                return Ok(at);
            };
            if self.element == self.header.vertex {
                on(Found::Vertex(at..end)).map_err(|kind| kind.at(Place::File))?;
            } else if is_face {
                let checked: Result<Vec<Index>, f64> = corners.iter().map(|v| checked(*v, vertices)).collect();
                let checked = checked.map_err(|vertex| {
                    let (face, vertex, count) = (self.index, vertex as i64, vertices as usize);
                    ReadErrorKind::OutOfRange { face, vertex, count }.at(Place::File)
                })?;
                if checked.len() >= 3 {
                    self.faces += 1;
                    on(Found::Face(&checked)).map_err(|kind| kind.at(Place::File))?;
                }
            }
            at = end;
            self.index += 1;
        }
        // What follows the last element is nobody's.
        Ok(piece.bytes.len())
    }
}

fn checked(vertex: f64, count: u64) -> Result<Index, f64> {
    let is_index = vertex >= 0.0 && vertex < count as f64 && vertex.fract() == 0.0;
    if is_index { Ok(vertex as Index) } else { Err(vertex) }
}

/// End of the element that starts at `at`; `None` if it is not whole. The indices of a face are appended to `corners`.
fn element_end(
    element: &Element,
    encoding: Encoding,
    bytes: &[u8],
    mut at: usize,
    mut corners: Option<&mut Vec<f64>>,
) -> Option<usize> {
    let indices = element.find(&["vertex_indices", "vertex_index"], true);
    for (p, property) in element.properties.iter().enumerate() {
        let mut count = 1;
        if let Some(list) = property.list {
            count = list.read(bytes.get(at..at + list.size())?, encoding).max(0.0) as usize;
            at += list.size();
        }
        let size = property.scalar.size();
        let end = at.checked_add(count.checked_mul(size)?)?;
        let items = bytes.get(at..end)?;
        if let (Some(corners), true) = (corners.as_deref_mut(), Some(p) == indices) {
            corners.extend(items.chunks_exact(size).map(|item| property.scalar.read(item, encoding)));
        }
        at = end;
    }
    Some(at)
}
