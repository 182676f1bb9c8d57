//! Reader of STL files.

use super::{FACET, HEADER, Stl};
use crate::mesh::jagged::{Index, Ragged};
use crate::source::Corner;
use crate::source::format::{Format, is_binary_stl};
use crate::source::mesh_file::Builder;
use crate::source::patch::lenient_number;
use crate::source::read_error::{Place, ReadError, ReadErrorKind, shown};
use crate::source::text::Words;
use glam::DVec3;
use rustc_hash::FxHashMap;

pub(super) fn parse(bytes: Vec<u8>) -> Result<Stl, ReadError> {
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty.at(Place::File));
    }
    let mut reader = Reader::default();
    let is_text = is_text(&bytes);
    if is_text {
        reader.text(&bytes)?;
    } else {
        reader.binary(&bytes)?;
    }
    let Reader { mut builder, facets, solids, .. } = reader;
    for (facet, line) in facets.iter().zip(reader.lines.iter().map(Some).chain(std::iter::repeat(None))) {
        facet.iter().for_each(|&v| builder.data.faces.extend_open(Corner::new(v, None, None)));
        builder.close_face(line.copied());
    }
    let (data, notes) = builder.finish().map_err(|kind| kind.at(Place::File))?;
    Ok(Stl { bytes, data, facets, is_text, solids, notes })
}

/// Returns true for a text file. A binary file may begin with `solid` too.
fn is_text(bytes: &[u8]) -> bool {
    // Bytes behind the header change with the positions, and a file must not become one of the other kind by that. The number of
    // facets at its end has a zero in all files of less than 16 million.
    let start = &bytes[..bytes.len().min(HEADER)];
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    let begins = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    begins && !is_binary_stl(bytes) && memchr::memchr(0, start).is_none()
}

#[derive(Default)]
struct Reader {
    builder: Builder,
    facets: Ragged<Index>,
    /// Line of each facet in a text file.
    lines: Vec<u32>,
    solids: usize,
    /// Source vertex at each position.
    vertices: FxHashMap<[u64; 3], Index>,
}

impl Reader {
    fn corner(&mut self, p: DVec3, place: Place) -> Result<(), ReadError> {
        if !p.is_finite() {
            let reason = format!("facet {} has a coordinate that is not finite", self.facets.len());
            return Err(ReadErrorKind::Malformed(reason).at(place));
        }
        let positions = &mut self.builder.data.positions;
        // −0 equals 0, as in welding.
        let vertex = *self.vertices.entry((p + 0.0).to_array().map(f64::to_bits)).or_insert_with(|| {
            positions.push(p);
            positions.len() as Index - 1
        });
        self.facets.extend_open(vertex);
        Ok(())
    }

    fn binary(&mut self, bytes: &[u8]) -> Result<(), ReadError> {
        let Some(count) = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok()) else {
            let reason = format!("it has {} bytes, and the header of a binary file has {HEADER}", bytes.len());
            return Err(ReadErrorKind::Foreign { format: Format::Stl, reason }.at(Place::File));
        };
        let (count, left) = (u32::from_le_bytes(count) as usize, bytes.len() - HEADER);
        let mut facets = count;
        if left != count.saturating_mul(FACET) {
            if left.is_multiple_of(FACET) {
                facets = left / FACET;
                self.builder.notes.push(format!("the header promises {count} facets, and the file has {facets}"));
            } else if left < count.saturating_mul(FACET) {
                let (element, count, needed) = ("facet".to_owned(), count as u64, count as u128 * FACET as u128);
                let at = Place::Byte(HEADER as u64);
                return Err(ReadErrorKind::Truncated { element, count, needed, left }.at(at));
            } else {
                let behind = left - count * FACET;
                self.builder.notes.push(format!("{behind} bytes behind the last facet are kept as they are"));
            }
        }
        for (i, facet) in bytes[HEADER..].chunks_exact(FACET).take(facets).enumerate() {
            for corner in facet[12..48].chunks_exact(12) {
                let number = |k: usize| f32::from_le_bytes([0, 1, 2, 3].map(|b| corner[4 * k + b])).into();
                let place = Place::Byte((HEADER + i * FACET) as u64);
                self.corner(DVec3::new(number(0), number(1), number(2)), place)?;
            }
            self.facets.close();
        }
        Ok(())
    }

    fn text(&mut self, bytes: &[u8]) -> Result<(), ReadError> {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let mut words = Words { bytes, at, line: 1 };
        let mut open = None;
        while let Some(word) = words.next_word() {
            let place = Place::Line(words.line);
            match bytes[word.clone()].to_ascii_lowercase().as_slice() {
                b"solid" | b"endsolid" => {
                    self.solids += usize::from(word.len() == 5);
                    words.skip_line();
                }
                b"facet" => {
                    self.ends_facet(open, place)?;
                    open = Some(words.line);
                }
                b"vertex" => {
                    let p = self.numbers(&mut words)?;
                    self.corner(p, place)?;
                }
                b"endfacet" => {
                    let line = open.take().unwrap_or(words.line);
                    self.facets.close();
                    self.lines.push(line);
                }
                b"normal" | b"outer" | b"loop" | b"endloop" => {}
                // Numbers of normals, and statements that some programs add.
                _ => {}
            }
        }
        self.ends_facet(open, Place::Line(words.line))
    }

    /// Fails if a facet is open, whose end is missing.
    fn ends_facet(&self, open: Option<u32>, place: Place) -> Result<(), ReadError> {
        open.map_or(Ok(()), |_| {
            let (element, index) = ("facet".to_owned(), self.facets.len() as u64);
            Err(ReadErrorKind::Ends { element, index }.at(place))
        })
    }

    fn numbers(&self, words: &mut Words) -> Result<DVec3, ReadError> {
        let mut numbers = [0.0; 3];
        let index = self.facets.len() as u64;
        for x in &mut numbers {
            let element = || "facet".to_owned();
            let ends = || ReadErrorKind::Ends { element: element(), index };
            let word = words.next_word().ok_or_else(|| ends().at(Place::Line(words.line)))?;
            let token = &words.bytes[word];
            let not_a_number = || ReadErrorKind::NotANumber { element: element(), index, token: shown(token) };
            *x = lenient_number(token).ok_or_else(|| not_a_number().at(Place::Line(words.line)))?;
        }
        Ok(numbers.into())
    }
}
