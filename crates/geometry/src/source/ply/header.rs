//! Header of a PLY file: its elements with their properties.

use super::scalar::{Encoding, Scalar};
use crate::source::format::Format;
use crate::source::read_error::{Place, ReadError, ReadErrorKind, shown};

/// Contents of the header of a PLY file.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Index of the element `vertex`.
    pub(super) vertex: usize,
    /// Files that comments `TextureFile` name. PLY names no encoding.
    pub(super) textures: Vec<Vec<u8>>,
    comments: usize,
    /// Offset of the first element.
    pub(super) end: usize,
    /// Line of the first element in a text file.
    pub(super) end_line: u32,
}

/// A kind of element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// A property of each element of a kind.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// Type of the number of items of a list; `None` for a single number.
    pub(super) list: Option<Scalar>,
    /// Type of the number or of the items.
    pub(super) scalar: Scalar,
}

impl Element {
    /// Index of a property by any of its names, a list or a single number.
    pub(super) fn find(&self, names: &[&str], is_list: bool) -> Option<usize> {
        self.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.list.is_some() == is_list)
    }
    /// Indices of single numbers by their names.
    pub(super) fn find_all<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut found = [0; N];
        for (index, name) in found.iter_mut().zip(names) {
            *index = self.find(&[name], false)?;
        }
        Some(found)
    }
    /// Smallest number of bytes that an element can have.
    fn least_size(&self, encoding: Encoding) -> usize {
        let of_property = |p: &Property| match encoding {
            // A digit and a blank.
            Encoding::Text => 2,
            _ => p.list.unwrap_or(p.scalar).size(),
        };
        self.properties.iter().map(of_property).sum()
    }
    /// Number of bytes of each element in a binary file; `None` if it has lists.
    pub(super) fn stride(&self) -> Option<usize> {
        self.properties.iter().map(|p| if p.list.is_some() { None } else { Some(p.scalar.size()) }).sum()
    }
}

/// A line of the header: its words, where the next line starts, and its number.
struct Line<'a> {
    text: &'a [u8],
    next: usize,
    number: u32,
}

/// Reads the line that starts at `at`. Lines end in `\n`, `\r\n` or `\r`.
fn line(bytes: &[u8], at: usize, number: u32) -> Option<Line<'_>> {
    let end = at + memchr::memchr2(b'\n', b'\r', &bytes[at..])?;
    let next = if bytes[end..].starts_with(b"\r\n") { end + 2 } else { end + 1 };
    Some(Line { text: &bytes[at..end], next, number })
}

/// Largest number of elements and properties that a header may name.
const MOST: usize = 10_000;

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::parse_of(bytes, bytes.len())
    }

    /// Reads the header from the first bytes of a file of `size` bytes.
    pub(super) fn parse_of(bytes: &[u8], size: usize) -> Result<Self, ReadError> {
        let foreign = |reason: &str| ReadErrorKind::Foreign { format: Format::Ply, reason: reason.to_owned() };
        if bytes.is_empty() {
            return Err(ReadErrorKind::Empty.at(Place::File));
        }
        let first = line(bytes, 0, 1).filter(|line| line.text.trim_ascii() == b"ply");
        let mut at = first.ok_or_else(|| foreign("its first line is not `ply`").at(Place::File))?.next;
        let mut encoding = None;
        let mut header = Self {
            encoding: Encoding::Text,
            elements: Vec::new(),
            vertex: 0,
            textures: Vec::new(),
            comments: 0,
            end: 0,
            end_line: 0,
        };
        for number in 2.. {
            let Some(line) = line(bytes, at, number) else {
                return Err(ReadErrorKind::Malformed("the header has no line `end_header`".to_owned()).at(Place::File));
            };
            let place = Place::Line(line.number);
            at = line.next;
            let words: Vec<&[u8]> = line.text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
            match words.as_slice() {
                [b"format", format, ..] => encoding = Some(encoding_of(format).map_err(|kind| kind.at(place))?),
                [b"comment", rest @ ..] => header.comment(line.text, rest),
                [b"obj_info", ..] => header.comments += 1,
                [b"element", name, count, ..] => {
                    let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                    let count = count.ok_or_else(|| bad(line.text).at(place))?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    header.elements.push(Element { name, count, properties: Vec::new() });
                }
                [b"property", rest @ ..] => {
                    let property = property(rest).ok_or_else(|| bad(line.text).at(place))?;
                    let element = header.elements.last_mut();
                    let element = element.ok_or_else(|| {
                        ReadErrorKind::Malformed("a property precedes all elements".to_owned()).at(place)
                    })?;
                    element.properties.push(property);
                }
                [b"end_header", ..] => {
                    (header.end, header.end_line) = (at, number + 1);
                    break;
                }
                [] => {}
                _ => return Err(bad(line.text).at(place)),
            }
            if header.elements.len() + header.elements.last().map_or(0, |e| e.properties.len()) > MOST {
                return Err(ReadErrorKind::Malformed(format!("more than {MOST} elements and properties")).at(place));
            }
        }
        let no_format = || ReadErrorKind::Malformed("the header has no line `format`".to_owned()).at(Place::File);
        header.encoding = encoding.ok_or_else(no_format)?;
        let vertex = header.elements.iter().position(|e| e.name == "vertex");
        header.vertex = vertex.ok_or_else(|| ReadErrorKind::NoVertices.at(Place::File))?;
        header.check_size(size)?;
        Ok(header)
    }

    /// Fails if the file has no space for what the header promises, before any memory is taken for it.
    fn check_size(&self, size: usize) -> Result<(), ReadError> {
        // The last number of a text file needs no blank after it.
        let mut left = size - self.end + usize::from(self.encoding == Encoding::Text);
        for element in &self.elements {
            let needed = u128::from(element.count) * element.least_size(self.encoding) as u128;
            left = usize::try_from(needed).ok().and_then(|needed| left.checked_sub(needed)).ok_or_else(|| {
                let (element, count) = (element.name.clone(), element.count);
                ReadErrorKind::Truncated { element, count, needed, left }.at(Place::Byte(self.end as u64))
            })?;
        }
        Ok(())
    }

    fn comment(&mut self, line: &[u8], words: &[&[u8]]) {
        match words.first() {
            Some(word) if word.eq_ignore_ascii_case(b"TextureFile") && words.len() > 1 => {
                // The name may contain blanks.
                let start = memchr::memmem::find(line, word).unwrap_or(0) + word.len();
                self.textures.push(line[start..].trim_ascii().to_vec());
            }
            _ => self.comments += 1,
        }
    }

    /// Kinds of elements besides vertices and faces, and comments, each with its count.
    pub(super) fn contents(&self) -> Vec<String> {
        let counted = |n: u64, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let others = self.elements.iter().filter(|e| !["vertex", "face"].contains(&e.name.as_str()));
        let mut all: Vec<String> = others.map(|e| format!("{} × element `{}`", e.count, e.name)).collect();
        if self.comments > 0 {
            all.push(counted(self.comments as u64, "comment", "comments"));
        }
        let known = [
            "x",
            "y",
            "z",
            "nx",
            "ny",
            "nz",
            "red",
            "green",
            "blue",
            "s",
            "t",
            "u",
            "v",
            "texture_u",
            "texture_v",
            "vertex_indices",
            "vertex_index",
            "texcoord",
            "texnumber",
        ];
        for element in &self.elements {
            let unknown: Vec<&str> =
                element.properties.iter().map(|p| p.name.as_str()).filter(|name| !known.contains(name)).collect();
            if ["vertex", "face"].contains(&element.name.as_str()) && !unknown.is_empty() {
                all.push(format!("{} properties {}", element.name, unknown.join(", ")));
            }
        }
        all
    }
}

fn bad(line: &[u8]) -> ReadErrorKind {
    ReadErrorKind::Malformed(format!("`{}` is no line of a PLY header", shown(line)))
}

fn encoding_of(name: &[u8]) -> Result<Encoding, ReadErrorKind> {
    match name {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => Err(ReadErrorKind::Unsupported(format!("the PLY format `{}`", shown(name)))),
    }
}

fn property(words: &[&[u8]]) -> Option<Property> {
    let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
    match words {
        [b"list", count, item, name, ..] => {
            let count = Scalar::named(count).filter(|count| count.is_integer())?;
            Some(Property { name: text(name), list: Some(count), scalar: Scalar::named(item)? })
        }
        [scalar, name, ..] => Some(Property { name: text(name), list: None, scalar: Scalar::named(scalar)? }),
        _ => None,
    }
}
