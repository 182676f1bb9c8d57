//! Mutations of inputs, the same ones for the same seed.

use super::pieces;

/// Longest input that is made.
const LONGEST: usize = 1 << 14;

/// A source of mutations.
#[derive(Clone, Debug)]
pub struct Mutator {
    state: u64,
}

impl Mutator {
    /// Starts with a seed.
    pub fn new(seed: u64) -> Self {
        Self { state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1 }
    }

    /// A random number (xorshift64*, Vigna 2016).
    fn next(&mut self) -> u64 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        self.state.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count.max(1)
    }

    /// Makes an input from one of the corpus, with parts of others.
    pub fn mutated(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let mut data = corpus[self.below(corpus.len())].clone();
        for _ in 0..1 + self.below(6) {
            self.mutate(&mut data, corpus);
        }
        data.truncate(LONGEST);
        data
    }

    fn mutate(&mut self, data: &mut Vec<u8>, corpus: &[Vec<u8>]) {
        let at = self.below(data.len() + 1);
        let longest = 1 << self.below(8);
        let end = (at + 1 + self.below(longest)).min(data.len());
        match self.below(9) {
            0 if at < data.len() => data[at] ^= 1 << self.below(8),
            1 if at < data.len() => data[at] = self.next() as u8,
            2 if at < end => drop(data.drain(at..end)),
            3 if at < end => {
                let copy = data[at..end].to_vec();
                let to = self.below(data.len() + 1);
                data.splice(to..to, copy);
            }
            4 => {
                let piece = pieces()[self.below(pieces().len())];
                data.splice(at..at, piece.bytes());
            }
            5 => self.replace_number(data, at),
            6 => {
                let other = &corpus[self.below(corpus.len())];
                let from = self.below(other.len() + 1);
                let longest = 1 << self.below(12);
                let length = self.below(longest).min(other.len() - from);
                data.splice(at..end.max(at), other[from..from + length].iter().copied());
            }
            7 => data.truncate(at),
            _ if at + 4 <= data.len() => {
                // Binary formats have lengths and sizes of four bytes.
                let number = [0, 1, 0x7fff_ffff, u32::MAX, 1 << self.below(32)][self.below(5)];
                let bytes = if self.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
                data[at..at + 4].copy_from_slice(&bytes);
            }
            _ => {}
        }
    }

    /// Replaces the number at or behind a place by a piece.
    fn replace_number(&mut self, data: &mut Vec<u8>, at: usize) {
        let is_digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'e');
        let Some(start) = data[at..].iter().position(is_digit).map(|n| at + n) else { return };
        let end = data[start..].iter().position(|b| !is_digit(b)).map_or(data.len(), |n| start + n);
        let piece = pieces()[self.below(11)];
        data.splice(start..end, piece.bytes());
    }
}
