//! Statements and tokens of an OBJ file as byte ranges, so that statements without a meaning to planish can be copied.

use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::patch::lenient_number;
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

/// Ranges of whole statements, each as short as one of `size` bytes or more can be. They depend on the bytes alone, so that what is
/// made of them is the same on any number of threads.
pub(super) fn pieces(bytes: &[u8], size: usize) -> Vec<Range<usize>> {
    let terminator = terminator(bytes);
    // Whatever the statement, a line that ends without a backslash does not continue.
    let is_cut = |end: usize| {
        let line = &bytes[..end];
        !line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\")
    };
    let (mut pieces, mut start) = (Vec::with_capacity(bytes.len() / size + 1), 0);
    while start < bytes.len() {
        let least = start.saturating_add(size - 1).min(bytes.len());
        let cut = memchr::memchr_iter(terminator, &bytes[least..]).map(|n| least + n).find(|end| is_cut(*end));
        let end = cut.map_or(bytes.len(), |end| end + 1);
        pieces.push(start..end);
        start = end;
    }
    pieces
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
        Self::of_piece(bytes, 0..bytes.len())
    }
    /// Statements of a piece, with lines counted from the start of the piece.
    pub(super) fn of_piece(bytes: &'a [u8], piece: Range<usize>) -> Self {
        // A byte order mark would become part of the first keyword.
        let mark = if piece.start == 0 && bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes: &bytes[..piece.end], terminator: terminator(bytes), at: piece.start + mark, line: 0 }
    }
    /// Number of physical lines so far.
    pub(super) fn lines(&self) -> u32 {
        self.line
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

    /// Takes the next argument if it is a corner of the usual spelling, which exporters write millions of: indices that count from 1,
    /// of at most nine digits.
    pub(super) fn plain_corner(&mut self) -> Option<Corner> {
        let start = self.skip_blanks();
        let mut at = start;
        let position = self.plain_index(&mut at)?;
        let [mut uv, mut normal] = [None; 2];
        if self.is_slash(at) {
            at += 1;
            if !self.is_slash(at) {
                uv = Some(self.plain_index(&mut at)?);
            }
            if self.is_slash(at) {
                at += 1;
                normal = Some(self.plain_index(&mut at)?);
            }
        }
        if at < self.end && !is_space(self.bytes[at]) {
            return None;
        }
        self.at = at;
        Some(Corner::new(position, uv, normal))
    }
    /// Takes the next argument as a number; the number is `None` if it is none.
    pub(super) fn number(&mut self) -> Option<(Range<usize>, Option<f64>)> {
        let start = self.skip_blanks();
        // Mostly the number ends where the argument does, and need not be looked at twice.
        if let Ok((x, length)) = fast_float2::parse_partial(&self.bytes[start..self.end]) {
            let end = start + length;
            if end == self.end || is_space(self.bytes[end]) {
                self.at = end;
                return Some((start..end, Some(x)));
            }
        }
        let token = self.next()?;
        let number = lenient_number(&self.bytes[token.clone()]);
        Some((token, number))
    }
    fn skip_blanks(&self) -> usize {
        let rest = &self.bytes[self.at..self.end];
        self.at + rest.iter().position(|b| !is_space(*b)).unwrap_or(rest.len())
    }
    fn is_slash(&self, at: usize) -> bool {
        at < self.end && self.bytes[at] == b'/'
    }
    /// Index from 0 of the digits at `at`, which becomes their end.
    fn plain_index(&self, at: &mut usize) -> Option<Index> {
        let mut number: Index = 0;
        let rest = &self.bytes[*at..self.end];
        let digits = rest.iter().take_while(|b| b.is_ascii_digit()).take(10);
        let mut length = 0;
        for digit in digits {
            number = number.wrapping_mul(10).wrapping_add(Index::from(digit - b'0'));
            length += 1;
        }
        *at += length;
        if length > 9 { None } else { number.checked_sub(1) }
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
    &bytes[name_range(bytes, statement)]
}

/// Range of [`name`].
pub(super) fn name_range(bytes: &[u8], statement: &Statement) -> Range<usize> {
    let rest = &bytes[statement.keyword.end..statement.end];
    let start = statement.end - rest.trim_ascii_start().len();
    start..start + rest.trim_ascii().len()
}

/// Parses a decimal integer of at most 18 digits.
pub(super) fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}
