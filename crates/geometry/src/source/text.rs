//! Words of text files as byte ranges, with their lines.

use std::ops::Range;

/// Place in a text, from which words are taken one after the other.
#[derive(Clone, Debug)]
pub(super) struct Words<'a> {
    pub(super) bytes: &'a [u8],
    /// Offset of the next byte.
    pub(super) at: usize,
    /// Line of the last word, counted from 1. Lines end in `\n`, `\r\n` or `\r`.
    pub(super) line: u32,
}

impl Words<'_> {
    /// Takes the next word, which may be in a later line; `None` at the end of the text.
    pub(super) fn next_word(&mut self) -> Option<Range<usize>> {
        while self.bytes.get(self.at)?.is_ascii_whitespace() || self.bytes[self.at] == 0x0b {
            self.line += u32::from(self.ends_line());
            self.at += 1;
        }
        let start = self.at;
        let is_end = |b: &u8| b.is_ascii_whitespace() || *b == 0x0b;
        self.at = self.bytes[start..].iter().position(is_end).map_or(self.bytes.len(), |n| start + n);
        Some(start..self.at)
    }
    /// Goes to the end of the line.
    pub(super) fn skip_line(&mut self) {
        let end = memchr::memchr2(b'\n', b'\r', &self.bytes[self.at..]);
        self.at = end.map_or(self.bytes.len(), |n| self.at + n);
    }
    /// Fills `words` with the words of the next line that has any before a comment (`#`). Returns false at the end of the text.
    pub(super) fn next_line(&mut self, words: &mut Vec<Range<usize>>) -> bool {
        words.clear();
        while let Some(word) = self.next_word() {
            let (line, after) = (self.line, self.at);
            if self.bytes[word.start] == b'#' {
                self.skip_line();
                if words.is_empty() {
                    continue;
                }
                return true;
            }
            words.push(word);
            // The rest of the line, as long as the next word is in it.
            let mut ahead = self.clone();
            if ahead.next_word().is_none() || ahead.line != line {
                self.at = after;
                return true;
            }
        }
        !words.is_empty()
    }

    /// Returns true if the byte at this place ends a line.
    fn ends_line(&self) -> bool {
        match self.bytes[self.at] {
            b'\n' => true,
            b'\r' => self.bytes.get(self.at + 1) != Some(&b'\n'),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_words_whatever_ends_them() {
        for eol in ["\n", "\r\n", "\r"] {
            let text = ["# head", "", "a b # c", "  d\t", "#", "e"].join(eol);
            let mut lines = Words { bytes: text.as_bytes(), at: 0, line: 1 };
            let (mut words, mut found) = (Vec::new(), Vec::new());
            while lines.next_line(&mut words) {
                let of_line: Vec<&str> = words.iter().map(|word| &text[word.clone()]).collect();
                found.push((lines.line, of_line.join(" ")));
            }
            assert_eq!(found, [(3, "a b".to_owned()), (4, "d".to_owned()), (6, "e".to_owned())], "{eol:?}");
        }
    }
}
