//! Copies of files in which some byte ranges are replaced, for writers that keep all the rest.

use std::ops::Range;

/// Copy of a file in the making, where byte ranges are replaced in ascending order.
pub(super) struct Patch<'a> {
    source: &'a [u8],
    copied: usize,
    end: usize,
    out: Vec<u8>,
}

impl<'a> Patch<'a> {
    pub(super) fn new(source: &'a [u8]) -> Self {
        Self::of_piece(source, 0..source.len())
    }
    /// Copy of a piece of the file, whose ranges count from the start of the file.
    pub(super) fn of_piece(source: &'a [u8], piece: Range<usize>) -> Self {
        // Numbers in full precision are longer than those that most exporters write.
        let out = Vec::with_capacity(piece.len() + piece.len() / 2);
        Self { source, copied: piece.start, end: piece.end, out }
    }
    /// File that is copied.
    pub(super) fn source(&self) -> &'a [u8] {
        self.source
    }
    /// Copies all bytes before `range`, skips `range`, and returns the output, to which the replacement is appended.
    pub(super) fn replace(&mut self, range: Range<usize>) -> &mut Vec<u8> {
        self.out.extend_from_slice(&self.source[self.copied..range.start]);
        self.copied = range.end;
        &mut self.out
    }
    pub(super) fn finish(mut self) -> Vec<u8> {
        self.out.extend_from_slice(&self.source[self.copied..self.end]);
        self.out
    }
}

/// Appends the shortest decimal that reads back to the same number.
pub(super) fn push_number(out: &mut Vec<u8>, x: impl ryu::Float) {
    out.extend_from_slice(ryu::Buffer::new().format(x).as_bytes());
}

/// Parses a number. Every spelling of NaN and infinity becomes NaN or infinity, as some exporters write them; `None` if the token
/// is no number at all.
pub(super) fn lenient_number(token: &[u8]) -> Option<f64> {
    fast_float2::parse(token).ok().or_else(|| {
        let text = token.to_ascii_lowercase();
        let broken = [&b"nan"[..], b"inf", b"#ind", b"#qnan", b"#snan"];
        broken.iter().any(|word| memchr::memmem::find(&text, word).is_some()).then_some(f64::NAN)
    })
}
