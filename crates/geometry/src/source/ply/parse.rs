//! Reader of the elements of a PLY file.

use super::header::{Element, Header};
use super::scalar::{Encoding, Scalar};
use super::{Ply, VertexProperties};
use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::mesh_data::MaterialRun;
use crate::source::mesh_file::Builder;
use crate::source::patch::lenient_number;
use crate::source::read_error::{Place, ReadError, ReadErrorKind, shown};
use crate::source::text::Words;
use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Place in the elements of a file, from which numbers are taken one after the other.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    pub(super) at: usize,
    /// Line of the last token in a text file, counted from 1.
    pub(super) line: u32,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding, at: usize, line: u32) -> Self {
        Self { bytes, encoding, at, line }
    }

    /// Takes the next number, and returns its bytes; `None` at the end of the file.
    pub(super) fn next(&mut self, scalar: Scalar) -> Option<Range<usize>> {
        if self.encoding != Encoding::Text {
            let range = self.at..self.at + scalar.size();
            self.at = range.end;
            return (range.end <= self.bytes.len()).then_some(range);
        }
        let mut words = Words { bytes: self.bytes, at: self.at, line: self.line };
        let word = words.next_word();
        (self.at, self.line) = (words.at, words.line);
        word
    }

    /// Value of a number; `None` if the token is none.
    fn value(&self, range: Range<usize>, scalar: Scalar) -> Option<f64> {
        let bytes = &self.bytes[range];
        match self.encoding {
            Encoding::Text => lenient_number(bytes),
            encoding => Some(scalar.read(bytes, encoding)),
        }
    }

    fn place(&self) -> Place {
        if self.encoding == Encoding::Text { Place::Line(self.line) } else { Place::Byte(self.at as u64) }
    }
}

/// Cursor with the element that it is at, for errors.
struct Walk<'a> {
    cursor: Cursor<'a>,
    element: &'a str,
    index: u64,
}

impl Walk<'_> {
    fn error(&self, kind: ReadErrorKind) -> ReadError {
        kind.at(self.cursor.place())
    }
    fn ends(&self) -> ReadError {
        let (element, index) = (self.element.to_owned(), self.index);
        ReadErrorKind::Ends { element, index }.at(Place::Byte(self.cursor.bytes.len() as u64))
    }
    fn number(&mut self, scalar: Scalar) -> Result<f64, ReadError> {
        let range = self.cursor.next(scalar).ok_or_else(|| self.ends())?;
        self.cursor.value(range.clone(), scalar).ok_or_else(|| {
            let token = shown(&self.cursor.bytes[range]);
            self.error(ReadErrorKind::NotANumber { element: self.element.to_owned(), index: self.index, token })
        })
    }
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), ReadError> {
        if self.cursor.encoding == Encoding::Text {
            for _ in 0..count {
                self.cursor.next(scalar).ok_or_else(|| self.ends())?;
            }
        } else {
            let end = count.checked_mul(scalar.size()).and_then(|n| self.cursor.at.checked_add(n));
            self.cursor.at = end.filter(|end| *end <= self.cursor.bytes.len()).ok_or_else(|| self.ends())?;
        }
        Ok(())
    }
    /// Takes the number of items of a list.
    fn count(&mut self, scalar: Scalar) -> Result<usize, ReadError> {
        let count = self.number(scalar)?;
        if count >= 0.0 && count.fract() == 0.0 && count <= self.cursor.bytes.len() as f64 {
            return Ok(count as usize);
        }
        let reason = format!("{} {}: a list cannot have {count} items", self.element, self.index);
        Err(self.error(ReadErrorKind::Malformed(reason)))
    }
    fn skip_element(&mut self, element: &Element) -> Result<(), ReadError> {
        for property in &element.properties {
            let count = property.list.map_or(Ok(1), |list| self.count(list))?;
            self.skip(property.scalar, count)?;
        }
        Ok(())
    }
}

pub(super) fn parse(bytes: Vec<u8>) -> Result<Ply, ReadError> {
    let header = Header::parse(&bytes)?;
    let vertex = VertexProperties::of(&header.elements[header.vertex])?;
    let mut walk =
        Walk { cursor: Cursor::new(&bytes, header.encoding, header.end, header.end_line), element: "", index: 0 };
    let mut faces = Faces { builder: Builder::default(), header: &header, vertex: &vertex, uvs: FxHashMap::default() };
    let (mut vertices_at, mut vertices_line) = (0, 0);
    for (e, element) in header.elements.iter().enumerate() {
        walk.element = &element.name;
        if element.properties.is_empty() {
            continue;
        }
        if e == header.vertex {
            (vertices_at, vertices_line) = (walk.cursor.at, walk.cursor.line);
        }
        if let (Some(stride), true) = (element.stride(), header.encoding != Encoding::Text && e != header.vertex) {
            // The size was checked with the header.
            walk.skip(Scalar::U8, stride.saturating_mul(usize::try_from(element.count).unwrap_or(usize::MAX)))?;
            continue;
        }
        for index in 0..element.count {
            walk.index = index;
            match element.name.as_str() {
                _ if e == header.vertex => faces.vertex(&mut walk, element)?,
                "face" => faces.face(&mut walk, element)?,
                "tristrips" => faces.strips(&mut walk, element)?,
                _ => walk.skip_element(element)?,
            }
        }
    }
    let whole = |kind: ReadErrorKind| kind.at(Place::File);
    faces.check_indices().map_err(whole)?;
    let mut builder = faces.builder;
    builder.data.materials = material_names(&header.textures);
    if builder.data.material_runs.is_empty() && !header.textures.is_empty() {
        builder.data.material_runs.push(MaterialRun { first_face: 0, material: Some(0) });
    }
    if header.elements.iter().any(|e| e.name == "face" && e.find_all(["nx", "ny", "nz"]).is_some()) {
        builder.notes.push("the faces have normals of their own, which are kept as they are".to_owned());
    }
    let (data, notes) = builder.finish().map_err(whole)?;
    Ok(Ply { bytes, data, header, vertex, vertices_at, vertices_line, notes })
}

/// Names of the materials that stand for textures: their file names, each made different from all others.
pub(super) fn material_names(textures: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let stem = |texture: &Vec<u8>| {
        let name = texture.rsplit(|b| matches!(b, b'/' | b'\\')).next().unwrap_or_default();
        let stem = name.iter().rposition(|b| *b == b'.').filter(|dot| *dot > 0).map_or(name, |dot| &name[..dot]);
        if stem.is_empty() { b"texture".to_vec() } else { stem.to_vec() }
    };
    let stems: Vec<Vec<u8>> = textures.iter().map(stem).collect();
    let mut counts: FxHashMap<&[u8], usize> = FxHashMap::default();
    for stem in &stems {
        *counts.entry(stem).or_default() += 1;
    }
    let unique = |(i, stem): (usize, &Vec<u8>)| {
        if counts[stem.as_slice()] > 1 { [stem, format!("-{i}").as_bytes()].concat() } else { stem.clone() }
    };
    stems.iter().enumerate().map(unique).collect()
}

impl VertexProperties {
    pub(super) fn of(element: &Element) -> Result<Self, ReadError> {
        let missing = || {
            let reason = "the element `vertex` lacks `x`, `y` or `z`".to_owned();
            ReadErrorKind::Malformed(reason).at(Place::File)
        };
        let any = |pairs: &[[&str; 2]]| pairs.iter().find_map(|names| element.find_all(*names));
        Ok(Self {
            position: element.find_all(["x", "y", "z"]).ok_or_else(missing)?,
            normal: element.find_all(["nx", "ny", "nz"]),
            colour: element
                .find_all(["red", "green", "blue"])
                .or_else(|| element.find_all(["diffuse_red", "diffuse_green", "diffuse_blue"]))
                .or_else(|| element.find_all(["r", "g", "b"])),
            uv: any(&[["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]),
        })
    }
}

/// Mesh data in the making.
struct Faces<'a> {
    builder: Builder,
    header: &'a Header,
    vertex: &'a VertexProperties,
    /// Index of each texture coordinate of a corner, by its bits.
    uvs: FxHashMap<[u64; 2], Index>,
}

impl Faces<'_> {
    fn vertex(&mut self, walk: &mut Walk, element: &Element) -> Result<(), ReadError> {
        // A vertex with more properties than this is rare; those beyond are only walked over.
        const MOST: usize = 32;
        let mut values = [f64::NAN; MOST];
        for (p, property) in element.properties.iter().enumerate() {
            if let Some(list) = property.list {
                let count = walk.count(list)?;
                walk.skip(property.scalar, count)?;
            } else if p < MOST {
                values[p] = walk.number(property.scalar)?;
            } else {
                walk.skip(property.scalar, 1)?;
            }
        }
        let value = |p: usize| values.get(p).copied().unwrap_or(f64::NAN);
        let data = &mut self.builder.data;
        data.positions.push(DVec3::from_array(self.vertex.position.map(value)));
        data.normals.extend(self.vertex.normal.map(|at| DVec3::from_array(at.map(value))));
        data.uvs.extend(self.vertex.uv.map(|at| DVec2::from_array(at.map(value))));
        let colour = self.vertex.colour.map(|at| at.map(|p| (value(p) / element.properties[p].scalar.full()) as f32));
        data.colours.extend(colour.filter(|c| c.iter().all(|x| x.is_finite())));
        Ok(())
    }

    fn corner(&self, vertex: f64) -> Corner {
        // Indices are checked when all vertices are known; those that are no index become one that is out of range.
        let index = if vertex >= 0.0 && vertex < f64::from(Index::MAX) { vertex as Index } else { Index::MAX };
        Corner::new(index, self.vertex.uv.map(|_| index), self.vertex.normal.map(|_| index))
    }

    fn face(&mut self, walk: &mut Walk, element: &Element) -> Result<(), ReadError> {
        let indices = element.find(&["vertex_indices", "vertex_index"], true);
        let texture = element.find(&["texcoord"], true);
        let number = element.find(&["texnumber"], false);
        let mut line = walk.cursor.line;
        let (mut corners, mut uvs, mut material) = (Vec::new(), Vec::new(), None);
        for (p, property) in element.properties.iter().enumerate() {
            let count = property.list.map_or(Ok(1), |list| walk.count(list))?;
            if p == 0 {
                line = walk.cursor.line;
            }
            if Some(p) == indices {
                for _ in 0..count {
                    let vertex = walk.number(property.scalar)?;
                    corners.push(self.checked_corner(walk, vertex)?);
                }
            } else if Some(p) == texture {
                for _ in 0..count {
                    uvs.push(walk.number(property.scalar)?);
                }
            } else if Some(p) == number {
                let texture = walk.number(property.scalar)?;
                let count = self.header.textures.len();
                material = Some((0..count as Index).find(|m| f64::from(*m) == texture));
            } else {
                walk.skip(property.scalar, count)?;
            }
        }
        let is_mapped = !corners.is_empty() && uvs.len() == 2 * corners.len();
        for (k, corner) in corners.iter().enumerate() {
            let uv = if is_mapped { Some(self.uv([uvs[2 * k], uvs[2 * k + 1]])) } else { corner.uv() };
            // Faces with texture coordinates of their own do not name those of their vertices.
            let uv = if texture.is_some() && !is_mapped { None } else { uv };
            self.builder.data.faces.extend_open(Corner::new(corner.position, uv, corner.normal()));
        }
        let first_face = self.builder.data.faces.len() as Index;
        let is_text = self.header.encoding == Encoding::Text;
        self.builder.close_face(is_text.then_some(line));
        if let Some(material) = material
            && (self.builder.data.faces.len() as Index) > first_face
        {
            let runs = &mut self.builder.data.material_runs;
            if runs.last().is_none_or(|last| last.material != material) {
                runs.push(MaterialRun { first_face, material });
            }
        }
        Ok(())
    }

    /// Corner at a vertex, which must be one if all vertices are known already.
    fn checked_corner(&self, walk: &Walk, vertex: f64) -> Result<Corner, ReadError> {
        let count = self.header.elements[self.header.vertex].count;
        if vertex >= 0.0 && vertex < count as f64 && vertex.fract() == 0.0 {
            return Ok(self.corner(vertex));
        }
        let (face, vertex, count) = (walk.index, vertex as i64, count as usize);
        Err(walk.error(ReadErrorKind::OutOfRange { face, vertex, count }))
    }

    fn uv(&mut self, uv: [f64; 2]) -> Index {
        let uvs = &mut self.builder.data.uvs;
        *self.uvs.entry(uv.map(f64::to_bits)).or_insert_with(|| {
            uvs.push(DVec2::from_array(uv));
            uvs.len() as Index - 1
        })
    }

    /// Triangle strips, as Stanford's archive has them: lists that −1 cuts into strips.
    fn strips(&mut self, walk: &mut Walk, element: &Element) -> Result<(), ReadError> {
        let indices = element.find(&["vertex_indices", "vertex_index"], true);
        for (p, property) in element.properties.iter().enumerate() {
            let count = property.list.map_or(Ok(1), |list| walk.count(list))?;
            if Some(p) != indices {
                walk.skip(property.scalar, count)?;
                continue;
            }
            let mut strip: Vec<Corner> = Vec::new();
            for _ in 0..count {
                let vertex = walk.number(property.scalar)?;
                if vertex == -1.0 {
                    strip.clear();
                    continue;
                }
                strip.push(self.checked_corner(walk, vertex)?);
                if let [.., a, b, c] = strip[..] {
                    // Every other triangle of a strip is wound the other way.
                    let [a, b] = if strip.len() % 2 == 1 { [a, b] } else { [b, a] };
                    [a, b, c].into_iter().for_each(|corner| self.builder.data.faces.extend_open(corner));
                    let is_text = self.header.encoding == Encoding::Text;
                    self.builder.close_face(is_text.then_some(walk.cursor.line));
                }
            }
        }
        Ok(())
    }

    /// Fails if the file has fewer vertices than its header promises, which faces may name.
    fn check_indices(&self) -> Result<(), ReadErrorKind> {
        let data = &self.builder.data;
        let count = data.positions.len();
        let stray = data.faces.items().iter().find(|corner| corner.position as usize >= count);
        stray.map_or(Ok(()), |corner| Err(ReadErrorKind::OutOfRange { face: 0, vertex: corner.position.into(), count }))
    }
}
