//! Vertices by name, in a text that people write.

use crate::mesh::jagged::Index;
use crate::mesh::topology::Topology;
use crate::mesh::weld::Weld;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Vertices that are picked out: the boundary of the mesh, source vertices by number, or both.
///
/// As text: words with blanks, commas or line breaks between them. `7` is the seventh source vertex (of an OBJ, the
/// seventh `v` line), `3-9` are seven of them, `boundary` is the boundary of the mesh; from `#` on a line is a comment. In JSON the same text on one line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Mask {
    boundary: bool,
    /// First and last source vertex of each run, counted from 1; ascending, with a gap between two.
    runs: Vec<[Index; 2]>,
}

/// Why a text is no mask.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: `{word}` {problem}")]
pub struct MaskError {
    /// Counted from 1.
    pub line: usize,
    /// The word at fault.
    pub word: String,
    /// Description of the fault.
    pub problem: String,
}

/// The word for the boundary of the mesh.
const BOUNDARY: &str = "boundary";

impl Mask {
    /// The vertices of edges with one face.
    pub fn boundary() -> Self {
        Self { boundary: true, runs: Vec::new() }
    }
    /// The source vertices with these indices, which count from 0.
    pub fn of_indices(indices: impl IntoIterator<Item = Index>) -> Self {
        let mut mask = Self { boundary: false, runs: indices.into_iter().map(|v| [v + 1, v + 1]).collect() };
        mask.join_runs();
        mask
    }
    /// Indices of the source vertices that are named, ascending, counted from 0; without those of the boundary.
    pub fn indices(&self) -> impl Iterator<Item = Index> {
        self.runs.iter().flat_map(|[first, last]| first - 1..*last)
    }
    /// Reads the text for a mesh with so many source vertices.
    pub fn parse(text: &str, source_vertices: usize) -> Result<Self, MaskError> {
        let mut mask = Self::default();
        for (line, words) in (1..).zip(text.lines()) {
            let words = words.split('#').next().unwrap_or_default();
            let words = words.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
            for word in words {
                match run(word, source_vertices) {
                    _ if word == BOUNDARY => mask.boundary = true,
                    Ok(run) => mask.runs.push(run),
                    Err(problem) => return Err(MaskError { line, word: word.to_owned(), problem }),
                }
            }
        }
        mask.join_runs();
        Ok(mask)
    }
    /// Whether nothing is picked out.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
    /// The vertices of both.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.boundary |= other.boundary;
        self.runs.extend(other.runs);
        self.join_runs();
        self
    }
    /// Number of source vertices that are named; without those of the boundary.
    pub fn count(&self) -> usize {
        self.runs.iter().map(|[first, last]| (last - first) as usize + 1).sum()
    }
    /// Whether the source vertex of this index, which counts from 0, is named.
    pub fn contains(&self, index: Index) -> bool {
        let run = self.runs.partition_point(|[_, last]| *last <= index);
        self.runs.get(run).is_some_and(|[first, _]| *first <= index.saturating_add(1))
    }
    /// The highest number of a source vertex that is named; 0 where none is.
    pub fn highest(&self) -> Index {
        self.runs.last().map_or(0, |run| run[1])
    }
    /// Whether each vertex is picked out; one of several source vertices is enough. #V
    pub(super) fn of(&self, topology: &Topology, weld: &Weld) -> Vec<bool> {
        let on_boundary = |v| self.boundary && topology.is_boundary(v);
        let mut picked: Vec<bool> = (0..topology.vertex_count() as Index).map(on_boundary).collect();
        for [first, last] in &self.runs {
            let vertices = weld.vertex_of().get(*first as usize - 1..*last as usize).unwrap_or_default();
            vertices.iter().for_each(|&v| picked[v as usize] = true);
        }
        picked
    }

    fn join_runs(&mut self) {
        self.runs.sort_unstable();
        self.runs.dedup_by(|next, run| {
            let touches = next[0] <= run[1].saturating_add(1);
            if touches {
                run[1] = run[1].max(next[1]);
            }
            touches
        });
    }
}

/// Source vertices of a word, or what is wrong with it.
fn run(word: &str, source_vertices: usize) -> Result<[Index; 2], String> {
    let (first, last) = word.split_once('-').unwrap_or((word, word));
    let number = |text: &str| text.parse::<Index>().ok().filter(|_| text.bytes().all(|b| b.is_ascii_digit()));
    let run = number(first).zip(number(last)).map(|(first, last)| [first, last]);
    let run = run.ok_or("is no number of a `v` line, no range of them like 3-9, and not `boundary`")?;
    let there_are = format!("there are {source_vertices} `v` lines, counted from 1");
    match run {
        [0, _] => Err(format!("names `v` line 0; {there_are}")),
        [first, last] if first > last => Err("ends before it begins".to_owned()),
        [_, last] if last as usize > source_vertices => Err(format!("names `v` line {last}; {there_are}")),
        run => Ok(run),
    }
}

impl fmt::Display for Mask {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let boundary = self.boundary.then(|| BOUNDARY.to_owned());
        let runs = self.runs.iter().map(|[a, b]| if a == b { a.to_string() } else { format!("{a}-{b}") });
        f.write_str(&boundary.into_iter().chain(runs).collect::<Vec<_>>().join(" "))
    }
}

impl FromStr for Mask {
    type Err = MaskError;

    fn from_str(text: &str) -> Result<Self, MaskError> {
        Self::parse(text, Index::MAX as usize)
    }
}

impl TryFrom<String> for Mask {
    type Error = MaskError;

    fn try_from(text: String) -> Result<Self, MaskError> {
        text.parse()
    }
}

impl From<Mask> for String {
    fn from(mask: Mask) -> Self {
        mask.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::weld::Welding;
    use glam::DVec3;

    #[test]
    fn runs_are_sorted_and_joined_and_read_back() {
        let mask = Mask::parse("# eyes\n9, 12-14 7-8\r\n\n 13-20#nose\n2", 20).unwrap();
        assert_eq!(mask.to_string(), "2 7-9 12-20");
        assert_eq!(mask.clone().and(Mask::boundary()).to_string(), "boundary 2 7-9 12-20");
        assert_eq!("boundary 2 7-9 12-20".parse(), Ok(mask.clone().and(Mask::boundary())));
        assert_eq!((mask.highest(), mask.is_empty(), Mask::default().highest()), (20, false, 0));
        assert!(Mask::parse("  # nothing\n", 3).unwrap().is_empty());
        // The largest index there is has no successor.
        assert_eq!("4294967295 4294967290-4294967295".parse::<Mask>().unwrap().to_string(), "4294967290-4294967295");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, line, words) in [
            ("1\n2 0", 2, "`0` names `v` line 0"),
            ("1\n#\n3-11", 3, "`3-11` names `v` line 11; there are 10"),
            ("5-3", 1, "`5-3` ends before it begins"),
            ("1 -2", 1, "`-2` is no number"),
            ("+3", 1, "`+3` is no number"),
            ("1-2-3", 1, "`1-2-3` is no number"),
            ("99999999999", 1, "`99999999999` is no number"),
            ("Boundary", 1, "not `boundary`"),
        ] {
            let error = Mask::parse(text, 10).unwrap_err();
            assert_eq!(error.line, line, "{text}");
            assert!(error.to_string().contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn one_of_the_lines_of_a_vertex_is_enough() {
        let weld = Weld::new(&[DVec3::X, DVec3::Y, DVec3::Z, DVec3::X], Welding::Exact);
        let topology = Topology::new(3, [vec![0, 1, 2]].into_iter().collect());
        assert_eq!(Mask::parse("4", 4).unwrap().of(&topology, &weld), [true, false, false]);
        assert_eq!(Mask::boundary().of(&topology, &weld), [true; 3]);
        let cube = shapes::cube();
        let weld = Weld::new(cube.positions(), Welding::None);
        assert_eq!(Mask::boundary().of(cube.topology(), &weld), [false; 8]);
    }
}
