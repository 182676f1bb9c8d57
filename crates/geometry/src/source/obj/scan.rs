//! Statements and tokens of an OBJ file as byte ranges, so that statements without a meaning to planish can be copied.

use memchr::memchr;
use std::ops::Range;

/// A keyword with its arguments, which may span several physical lines.
#[derive(Clone, Debug)]
pub(super) struct Statement {
    /// Line of the keyword, counted from 1.
    pub(super) line: u32,
    /// Start of the physical line of the keyword.
    pub(super) line_start: usize,
    /// Range of the keyword.
    pub(super) keyword: Range<usize>,
    /// End of the physical line of the last argument, without its terminator.
    pub(super) end: usize,
    /// End of the physical line of the last argument, with its terminator.
    pub(super) line_end: usize,
}

/// Iterator over the statements; it skips empty lines and comments.
pub(super) struct Statements<'a> {
    bytes: &'a [u8],
    terminator: u8,
    at: usize,
    line: u32,
}

/// Byte that ends a line: a line feed, or a carriage return in files without any line feed.
pub(super) fn terminator(bytes: &[u8]) -> u8 {
    if memchr(b'\n', bytes).is_none() && memchr(b'\r', bytes).is_some() { b'\r' } else { b'\n' }
}

pub(super) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// Returns true if the arguments of a statement are numbers. In all others a backslash at the end may be part of a name.
fn is_numeric(keyword: &[u8]) -> bool {
    matches!(keyword, b"v" | b"vt" | b"vn" | b"f" | b"fo" | b"l" | b"p")
}

impl<'a> Statements<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        // A byte order mark would become part of the first keyword.
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, terminator: terminator(bytes), at, line: 0 }
    }

    /// End of the physical line that starts at `from`, without its terminator.
    fn physical_end(&self, from: usize) -> usize {
        memchr(self.terminator, &self.bytes[from..]).map_or(self.bytes.len(), |n| from + n)
    }

    /// Returns true if a backslash at the very end of a line, outside a comment, continues it in the next line.
    fn continues(&self, start: usize, end: usize) -> bool {
        let mut last = end;
        if last > start && self.bytes[last - 1] == b'\r' {
            last -= 1;
        }
        last > start
            && self.bytes[last - 1] == b'\\'
            && end < self.bytes.len()
            && memchr(b'#', &self.bytes[start..last]).is_none()
    }
}

impl Iterator for Statements<'_> {
    type Item = Statement;

    fn next(&mut self) -> Option<Statement> {
        while self.at < self.bytes.len() {
            let line_start = self.at;
            self.line += 1;
            let line = self.line;
            let mut end = self.physical_end(line_start);
            self.at = (end + 1).min(self.bytes.len());
            let Some(skip) = self.bytes[line_start..end].iter().position(|&b| !is_space(b)) else {
                continue;
            };
            let start = line_start + skip;
            if self.bytes[start] == b'#' {
                continue;
            }
            let length = self.bytes[start..end].iter().position(|&b| is_space(b));
            let mut keyword = start..length.map_or(end, |n| start + n);
            // The backslash of a continuation may touch the keyword.
            let glued = self.bytes[keyword.clone()].strip_suffix(b"\\");
            if glued.is_some_and(is_numeric) {
                keyword.end -= 1;
            }
            if is_numeric(&self.bytes[keyword.clone()]) {
                let mut physical_start = line_start;
                while self.continues(physical_start, end) {
                    physical_start = end + 1;
                    end = self.physical_end(physical_start);
                    self.line += 1;
                    self.at = (end + 1).min(self.bytes.len());
                }
            }
            return Some(Statement { line, line_start, keyword, end, line_end: self.at });
        }
        None
    }
}

/// Iterator over the arguments of a numeric statement as byte ranges.
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8], statement: &Statement) -> Self {
        Self { bytes, at: statement.keyword.end, end: statement.end }
    }

    /// Returns true if there is a continuation (a backslash and a line end) at `at`.
    fn continuation(&self, at: usize) -> bool {
        self.bytes[at] == b'\\' && matches!(self.bytes[at + 1..self.end], [] | [b'\n' | b'\r', ..])
    }
    /// Returns true if a comment begins at `at`, within a token. `1.#IND` is none: some C libraries spell NaN like this.
    fn comment(&self, at: usize) -> bool {
        self.bytes[at] == b'#' && self.bytes[at - 1] != b'.'
    }
}

impl Iterator for Tokens<'_> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        while self.at < self.end
            && (is_space(self.bytes[self.at]) || self.bytes[self.at] == b'\n' || self.continuation(self.at))
        {
            self.at += 1;
        }
        if self.at == self.end || self.bytes[self.at] == b'#' {
            self.at = self.end;
            return None;
        }
        let start = self.at;
        while self.at < self.end
            && !is_space(self.bytes[self.at])
            && self.bytes[self.at] != b'\n'
            && !self.comment(self.at)
            && !self.continuation(self.at)
        {
            self.at += 1;
        }
        Some(start..self.at)
    }
}

/// Argument of a statement that has a name as its argument: the rest of the line without blanks at its ends.
pub(super) fn name<'a>(bytes: &'a [u8], statement: &Statement) -> &'a [u8] {
    bytes[statement.keyword.end..statement.end].trim_ascii()
}
