//! The parts of a glTF file: JSON and buffers.

use super::{index, list};
use crate::source::format::Format;
use crate::source::read_error::{Place, ReadError, ReadErrorKind, shown};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde_json::Value;
use std::borrow::Cow;
use std::ops::Range;

/// A file with its buffers.
#[derive(Clone, Debug)]
pub(super) struct Container {
    bytes: Vec<u8>,
    /// JSON within the file.
    json: Range<usize>,
    /// Buffer within a binary file.
    binary: Option<Range<usize>>,
    buffers: Vec<Buffer>,
}

/// Where a buffer is.
#[derive(Clone, Debug)]
pub(super) enum Buffer {
    /// In the binary file itself.
    Binary,
    /// In the JSON, as a data URI.
    Inline(Vec<u8>),
    /// In a file beside.
    External(Vec<u8>),
}

const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";
const HEADER: usize = 12;

fn malformed(reason: impl Into<String>) -> ReadErrorKind {
    ReadErrorKind::Malformed(reason.into())
}

/// Number at an offset of a binary file.
fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let number = bytes.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(number)).ok()
}

impl Container {
    /// Finds the parts of a file, and parses its JSON.
    pub(super) fn open(bytes: Vec<u8>, beside: &dyn Fn(&str) -> Option<Vec<u8>>) -> Result<(Self, Value), ReadError> {
        if bytes.is_empty() {
            return Err(ReadErrorKind::Empty.at(Place::File));
        }
        let (json, binary) = if bytes.starts_with(MAGIC) { chunks(&bytes)? } else { (0..bytes.len(), None) };
        let start = if bytes[json.clone()].starts_with(b"\xef\xbb\xbf") { json.start + 3 } else { json.start };
        let json = start..json.end;
        let document: Value = serde_json::from_slice(&bytes[json.clone()]).map_err(|e| {
            let place =
                if binary.is_none() && !bytes.starts_with(MAGIC) { Place::Line(e.line() as u32) } else { Place::File };
            let format = if bytes.starts_with(MAGIC) { Format::Glb } else { Format::Gltf };
            ReadErrorKind::Foreign { format, reason: format!("its JSON is broken: {e}") }.at(place)
        })?;
        let mut new = Self { bytes, json, binary, buffers: Vec::new() };
        let version = document["asset"]["version"].as_str().unwrap_or_default();
        if !version.starts_with("2.") {
            let what = if version.is_empty() { "no version".to_owned() } else { format!("version {version}") };
            return Err(ReadErrorKind::Unsupported(format!("glTF of {what}")).at(Place::File));
        }
        for (i, entry) in list(&document, "buffers").iter().enumerate() {
            let buffer = new.open_buffer(i, entry, beside).map_err(|kind| kind.at(Place::File))?;
            new.buffers.push(buffer);
        }
        Ok((new, document))
    }

    fn open_buffer(
        &self,
        i: usize,
        entry: &Value,
        beside: &dyn Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Buffer, ReadErrorKind> {
        let buffer = match entry["uri"].as_str() {
            None if i == 0 && self.binary.is_some() => Buffer::Binary,
            // The compressed form of such a buffer is elsewhere.
            None => Buffer::Inline(Vec::new()),
            Some(uri) => match data_uri(uri) {
                Some(data) => {
                    Buffer::Inline(data.ok_or_else(|| malformed(format!("buffer {i}: its data URI is broken")))?)
                }
                None => {
                    let path = percent_decoded(uri);
                    let missing =
                        || malformed(format!("buffer {i}: the file {} cannot be read", shown(path.as_bytes())));
                    Buffer::External(beside(&path).ok_or_else(missing)?)
                }
            },
        };
        Ok(buffer)
    }

    pub(super) fn is_binary(&self) -> bool {
        self.bytes.starts_with(MAGIC)
    }
    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    /// JSON of the file.
    pub(super) fn json(&self) -> &[u8] {
        &self.bytes[self.json.clone()]
    }
    /// Bytes of a buffer; empty if there is none.
    pub(super) fn buffer(&self, i: usize) -> &[u8] {
        match self.buffers.get(i) {
            Some(Buffer::Binary) => &self.bytes[self.binary.clone().unwrap_or_default()],
            Some(Buffer::Inline(bytes) | Buffer::External(bytes)) => bytes,
            None => &[],
        }
    }
    /// Bytes of a view of the document; `None` if it lies outside of its buffer.
    pub(super) fn view(&self, document: &Value, view: usize) -> Option<&[u8]> {
        let entry = list(document, "bufferViews").get(view)?;
        let start = index(&entry["byteOffset"]).unwrap_or(0);
        let end = start.checked_add(index(&entry["byteLength"])?)?;
        self.buffer(index(&entry["buffer"])?).get(start..end)
    }
    /// Bytes of the file and of the buffers beside it.
    pub(super) fn with_external_buffers(&self) -> Cow<'_, [u8]> {
        let external =
            self.buffers.iter().filter_map(|b| if let Buffer::External(b) = b { Some(b.as_slice()) } else { None });
        let parts: Vec<&[u8]> = std::iter::once(self.bytes()).chain(external).collect();
        if parts.len() == 1 { Cow::Borrowed(self.bytes()) } else { Cow::Owned(parts.concat()) }
    }

    /// Returns the file with other JSON and another buffer within the binary file.
    pub(super) fn rebuilt(&self, json: &[u8], binary: Option<&[u8]>) -> Vec<u8> {
        if !self.is_binary() {
            return [&self.bytes[..self.json.start], json].concat();
        }
        let mut json = json.to_vec();
        if json.len() != self.json.len() {
            json.truncate(json.trim_ascii_end().len());
            json.resize(json.len().next_multiple_of(4), b' ');
        }
        let mut out = self.bytes[..self.json.start].to_vec();
        let length = json.len() + (self.json.start - HEADER - 8);
        out[HEADER..HEADER + 4].copy_from_slice(&(length as u32).to_le_bytes());
        out.extend(json);
        let end = out.len();
        out.extend(&self.bytes[self.json.end..]);
        if let (Some(range), Some(binary)) = (&self.binary, binary) {
            let start = end + range.start - self.json.end;
            out[start..start + binary.len()].copy_from_slice(binary);
        }
        let length = number(&self.bytes, 8).unwrap_or(0) + out.len() - self.bytes.len();
        out[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        out
    }
    /// Returns whether a buffer is in a file beside.
    pub(super) fn is_external(&self, i: usize) -> bool {
        matches!(self.buffers.get(i), Some(Buffer::External(_)))
    }
    /// Returns whether a buffer is within the binary file.
    pub(super) fn is_within(&self, i: usize) -> bool {
        matches!(self.buffers.get(i), Some(Buffer::Binary))
    }
}

/// Data URI of a buffer.
pub(super) fn to_data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", BASE64.encode(bytes))
}

/// Content of a data URI: `None` for other URIs, `Some(None)` if it is broken.
#[expect(clippy::option_option, reason = "no URI of this kind and a broken one are different things")]
pub(super) fn data_uri(uri: &str) -> Option<Option<Vec<u8>>> {
    let (head, data) = uri.strip_prefix("data:")?.split_once(',').unwrap_or_default();
    Some(head.ends_with(";base64").then(|| BASE64.decode(data).ok()).flatten())
}

/// Path of a URI whose special characters are written as `%20` and the like.
pub(crate) fn percent_decoded(uri: &str) -> String {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = tail.get(..2).and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        rest = match (first, code) {
            (b'%', Some(byte)) => {
                out.push(byte);
                &tail[2..]
            }
            _ => {
                out.push(*first);
                tail
            }
        };
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// JSON chunk and buffer chunk of a binary file.
fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), ReadError> {
    if number(bytes, 4) != Some(2) {
        let version = number(bytes, 4).map_or("no version".to_owned(), |v| format!("version {v}"));
        return Err(ReadErrorKind::Unsupported(format!("binary glTF of {version}")).at(Place::Byte(4)));
    }
    let mut at = HEADER;
    let mut found: Vec<(&[u8], Range<usize>)> = Vec::new();
    while at < bytes.len() && found.len() < 2 {
        let ends = |at: usize| {
            let (element, index) = ("chunk".to_owned(), found.len() as u64);
            ReadErrorKind::Ends { element, index }.at(Place::Byte(at as u64))
        };
        let length = number(bytes, at).ok_or_else(|| ends(at))?;
        let kind = bytes.get(at + 4..at + 8).ok_or_else(|| ends(at))?;
        let content = at + 8..at + 8 + length;
        if content.end > bytes.len() {
            return Err(ends(at));
        }
        at = content.end;
        found.push((kind, content));
    }
    match found.as_slice() {
        [(JSON, json), (BIN, binary), ..] => Ok((json.clone(), Some(binary.clone()))),
        [(JSON, json), ..] => Ok((json.clone(), None)),
        _ => {
            let reason = "its first chunk is not JSON".to_owned();
            Err(ReadErrorKind::Foreign { format: Format::Glb, reason }.at(Place::Byte(HEADER as u64)))
        }
    }
}
