//! Reader of OFF files.

use super::Off;
use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::format::{Format, is_off};
use crate::source::mesh_file::Builder;
use crate::source::patch::lenient_number;
use crate::source::read_error::{Place, ReadError, ReadErrorKind, shown};
use crate::source::text::Words;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Attributes that the first word of a file promises.
#[derive(Clone, Copy, Default)]
struct Attributes {
    uv: bool,
    colour: bool,
    normal: bool,
}

pub(super) fn parse(bytes: Vec<u8>) -> Result<Off, ReadError> {
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty.at(Place::File));
    }
    let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let mut lines = Words { bytes: &bytes, at, line: 1 };
    let mut words = Vec::new();
    let (attributes, [vertices, faces]) = header(&mut lines, &mut words)?;
    let mut reader = Reader {
        lines,
        words,
        builder: Builder::default(),
        raw_colours: Vec::new(),
        whole_colours: true,
        has_bytes: false,
    };
    // A vertex needs at least six bytes, a face two; the last line may lack its end.
    let left = bytes.len() - reader.lines.at + 1;
    let needed = u128::from(vertices) * 6 + u128::from(faces) * 2;
    if needed > left as u128 {
        let (element, count) =
            if u128::from(vertices) * 6 > left as u128 { ("vertex", vertices) } else { ("face", faces) };
        let kind = ReadErrorKind::Truncated { element: element.to_owned(), count, needed, left };
        return Err(kind.at(Place::Line(reader.lines.line)));
    }
    let vertices_at = (reader.lines.at, reader.lines.line);
    for index in 0..vertices {
        reader.vertex(index, attributes)?;
    }
    let mut coloured_faces = 0;
    for index in 0..faces {
        coloured_faces += usize::from(reader.face(index, attributes)?);
    }
    reader.colours();
    let (data, notes) = reader.builder.finish().map_err(|kind| kind.at(Place::File))?;
    Ok(Off { data, vertices_at, has_normals: attributes.normal, coloured_faces, notes, bytes })
}

/// Reads the first word, if there is one, and the numbers of vertices and faces.
fn header(lines: &mut Words, words: &mut Vec<Range<usize>>) -> Result<(Attributes, [u64; 2]), ReadError> {
    let foreign = |reason: &str| ReadErrorKind::Foreign { format: Format::Off, reason: reason.to_owned() };
    if !lines.next_line(words) {
        return Err(foreign("it has no words").at(Place::File));
    }
    let mut attributes = Attributes::default();
    let first = &lines.bytes[words[0].clone()];
    if is_off(first) {
        if first.contains(&b'4') || first.contains(&b'n') {
            let used = format!("`{}`, vertices with another number of dimensions than three", shown(first));
            return Err(ReadErrorKind::Unsupported(used).at(Place::Line(lines.line)));
        }
        let prefix = first.strip_suffix(b"OFF").unwrap_or_default();
        attributes.uv = prefix.starts_with(b"ST");
        attributes.colour = prefix.strip_prefix(b"ST").unwrap_or(prefix).contains(&b'C');
        attributes.normal = prefix.contains(&b'N');
        if words.get(1).is_some_and(|word| lines.bytes[word.clone()].eq_ignore_ascii_case(b"BINARY")) {
            return Err(ReadErrorKind::Unsupported("binary OFF".to_owned()).at(Place::Line(lines.line)));
        }
        words.remove(0);
        if words.is_empty() && !lines.next_line(words) {
            return Err(foreign("the numbers of vertices and faces are missing").at(Place::File));
        }
    }
    let count = |k: usize| words.get(k).and_then(|w| std::str::from_utf8(&lines.bytes[w.clone()]).ok()?.parse().ok());
    let counts = count(0).zip(count(1));
    let (vertices, faces) =
        counts.ok_or_else(|| foreign("the numbers of vertices and faces are missing").at(Place::Line(lines.line)))?;
    Ok((attributes, [vertices, faces]))
}

struct Reader<'a> {
    lines: Words<'a>,
    words: Vec<Range<usize>>,
    builder: Builder,
    /// Colours as the file has them, before it is known whether they are bytes or fractions.
    raw_colours: Vec<[f32; 3]>,
    /// True as long as all numbers of colours are whole.
    whole_colours: bool,
    /// True if a number of a colour, opacity among them, is more than 1.
    has_bytes: bool,
}

impl Reader<'_> {
    fn next_line(&mut self, element: &str, index: u64) -> Result<(), ReadError> {
        if self.lines.next_line(&mut self.words) {
            return Ok(());
        }
        Err(ReadErrorKind::Ends { element: element.to_owned(), index }.at(Place::Line(self.lines.line)))
    }
    fn place(&self) -> Place {
        Place::Line(self.lines.line)
    }
    fn number(&self, element: &str, index: u64, k: usize) -> Result<f64, ReadError> {
        let word = self.words.get(k);
        let word = word.ok_or_else(|| {
            let reason = format!("{element} {index} has {} numbers only", self.words.len());
            ReadErrorKind::Malformed(reason).at(self.place())
        })?;
        let token = &self.lines.bytes[word.clone()];
        lenient_number(token).ok_or_else(|| {
            let kind = ReadErrorKind::NotANumber { element: element.to_owned(), index, token: shown(token) };
            kind.at(self.place())
        })
    }

    fn vertex(&mut self, index: u64, attributes: Attributes) -> Result<(), ReadError> {
        self.next_line("vertex", index)?;
        let number = |k: usize| self.number("vertex", index, k);
        let p = DVec3::new(number(0)?, number(1)?, number(2)?);
        let normal = if attributes.normal { Some(DVec3::new(number(3)?, number(4)?, number(5)?)) } else { None };
        let after = if attributes.normal { 6 } else { 3 };
        let end = self.words.len();
        let uv_at = end.saturating_sub(2).max(after);
        let uv = if attributes.uv { Some(DVec2::new(number(uv_at)?, number(uv_at + 1)?)) } else { None };
        // Many programs write colours into files that promise none.
        let colour_end = if attributes.uv { uv_at } else { end };
        let has_colour = (3..=4).contains(&(colour_end - after.min(colour_end)));
        let has_bytes = (after..colour_end).any(|k| number(k).is_ok_and(|x| x > 1.0));
        let mut colour = [0.0; 3];
        if has_colour {
            for (k, x) in colour.iter_mut().enumerate() {
                *x = number(after + k)? as f32;
            }
            let is_whole = |k: &Range<usize>| !self.lines.bytes[k.clone()].contains(&b'.');
            self.whole_colours &= self.words[after..after + 3].iter().all(is_whole);
            self.raw_colours.push(colour);
            self.has_bytes |= has_bytes;
        }
        self.builder.data.positions.push(p);
        self.builder.data.normals.extend(normal);
        self.builder.data.uvs.extend(uv);
        Ok(())
    }

    /// Reads a face, and returns whether it has a colour.
    fn face(&mut self, index: u64, attributes: Attributes) -> Result<bool, ReadError> {
        self.next_line("face", index)?;
        let corners = self.number("face", index, 0)?;
        let count = self.builder.data.positions.len();
        if !(corners >= 0.0 && corners.fract() == 0.0 && corners < self.words.len() as f64) {
            let has = self.words.len() - 1;
            let reason = format!("face {index} promises {corners} corners and has {has} numbers");
            return Err(ReadErrorKind::Malformed(reason).at(self.place()));
        }
        for k in 1..=corners as usize {
            let vertex = self.number("face", index, k)?;
            if !(vertex >= 0.0 && vertex < count as f64 && vertex.fract() == 0.0) {
                let kind = ReadErrorKind::OutOfRange { face: index, vertex: vertex as i64, count };
                return Err(kind.at(self.place()));
            }
            let v = vertex as Index;
            let corner = Corner::new(v, attributes.uv.then_some(v), attributes.normal.then_some(v));
            self.builder.data.faces.extend_open(corner);
        }
        self.builder.close_face(Some(self.lines.line));
        Ok(self.words.len() > corners as usize + 1)
    }

    /// Hands the colours on, as fractions of 1.
    fn colours(&mut self) {
        let full = if self.whole_colours && self.has_bytes { 255.0 } else { 1.0 };
        let colours = self.raw_colours.iter().map(|c| c.map(|x| x / full));
        self.builder.data.colours = colours.filter(|c| c.iter().all(|x| x.is_finite())).collect();
    }
}
