//! Weights that say how far each vertex may go.

use crate::mesh::jagged::Index;
use crate::mesh::weld::Weld;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Weights of the source vertices, 0..=1 in steps of 1/255, by which displacements are multiplied.
///
/// As text: words with blanks between them. `3-9=128` gives seven source vertices, counted from 1, the weight 128/255, and `7=0` keeps
/// one where it is. The words ascend; source vertices that are not named have the weight 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Weights {
    /// Runs of source vertices with the same weight, ascending.
    runs: Vec<Run>,
}

/// Source vertices with the same weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// First and last source vertex, counted from 1.
    ends: [Index; 2],
    /// Weight in steps of 1/255; below 255.
    weight: u8,
}

/// The text is no list of weights.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no weight of vertices, like 3-9=128, after those before it")]
pub struct WeightsError(String);

impl Weights {
    /// Rounds weights (#v) to steps of 1/255; what is outside of 0..=1 counts as the nearer end, and NaN as 1.
    pub fn new(weights: &[f32]) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        for (vertex, weight) in (1..).zip(weights) {
            let weight = if weight.is_nan() { u8::MAX } else { (weight.clamp(0.0, 1.0) * 255.0).round() as u8 };
            match runs.last_mut() {
                _ if weight == u8::MAX => {}
                Some(run) if run.weight == weight && run.ends[1] + 1 == vertex => run.ends[1] = vertex,
                _ => runs.push(Run { ends: [vertex; 2], weight }),
            }
        }
        Self { runs }
    }
    /// Returns true if all weights are 1.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }
    /// Highest number of a source vertex that is named; 0 if none is.
    pub fn highest(&self) -> Index {
        self.runs.last().map_or(0, |run| run.ends[1])
    }
    /// Weight of each vertex: the lowest of its source vertices; empty if all weights are 1. #V
    pub fn of(&self, vertices: usize, weld: &Weld) -> Vec<f64> {
        if self.is_empty() {
            return Vec::new();
        }
        let mut weights = vec![1.0; vertices];
        for Run { ends: [first, last], weight } in &self.runs {
            let named = weld.vertex_of().get(*first as usize - 1..*last as usize).unwrap_or_default();
            for &v in named {
                let known = &mut weights[v as usize];
                *known = f64::min(*known, f64::from(*weight) / 255.0);
            }
        }
        weights
    }
}

impl fmt::Display for Weights {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let word = |Run { ends: [first, last], weight }: &Run| match first == last {
            true => format!("{first}={weight}"),
            false => format!("{first}-{last}={weight}"),
        };
        f.write_str(&self.runs.iter().map(word).collect::<Vec<_>>().join(" "))
    }
}

impl FromStr for Weights {
    type Err = WeightsError;

    fn from_str(text: &str) -> Result<Self, WeightsError> {
        let mut weights = Self::default();
        for word in text.split_whitespace() {
            let run = run(word).filter(|run| weights.highest() < run.ends[0] && run.ends[0] <= run.ends[1]);
            weights.runs.push(run.ok_or_else(|| WeightsError(word.to_owned()))?);
        }
        Ok(weights)
    }
}

fn run(word: &str) -> Option<Run> {
    let (ends, weight) = word.split_once('=')?;
    let (first, last) = ends.split_once('-').unwrap_or((ends, ends));
    Some(Run { ends: [first.parse().ok()?, last.parse().ok()?], weight: weight.parse().ok()? })
}

impl TryFrom<String> for Weights {
    type Error = WeightsError;

    fn try_from(text: String) -> Result<Self, WeightsError> {
        text.parse()
    }
}

impl From<Weights> for String {
    fn from(weights: Weights) -> Self {
        weights.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::weld::Welding;
    use glam::DVec3;

    #[test]
    fn weights_survive_their_text() {
        let weights = Weights::new(&[1.0, 0.0, 0.0, 0.5, 2.0, -1.0, f32::NAN, 0.5, 0.5]);
        assert_eq!(weights.to_string(), "2-3=0 4=128 6=0 8-9=128");
        assert_eq!(weights.to_string().parse(), Ok(weights.clone()));
        assert_eq!((weights.highest(), weights.is_empty()), (9, false));
        assert!(Weights::new(&[1.0; 9]).is_empty());
    }

    #[test]
    fn other_texts_are_refused_with_the_word() {
        for word in ["7", "0=1", "9-7=1", "2=1", "7=256", "7=-1", "a=1", "7=", "4294967296=1"] {
            let error = format!("3=7 {word}").parse::<Weights>().unwrap_err();
            assert!(error.to_string().contains(&format!("`{word}`")), "{error}");
        }
    }

    #[test]
    fn a_welded_vertex_has_the_lowest_weight() {
        let weld = Weld::new(&[DVec3::ZERO, DVec3::X, DVec3::ZERO], Welding::Exact);
        assert_eq!(Weights::new(&[0.2, 1.0, 0.6]).of(2, &weld), [0.2, 1.0]);
        assert!(Weights::default().of(2, &weld).is_empty());
    }
}
