//! Decision trees that read the statistics of a region: the evidence for noise.
//!
//! They were fitted, one after the other to what those before had left open (gradient boosting), to clean meshes with and without synthetic
//! noise, by the commands in `training/README.md` of this crate. They are in `forest.json`.

use super::statistics::COUNT;
use serde::Deserialize;
use std::sync::OnceLock;

/// Trees, and the limits of their evidence beyond which a mesh has noise. All are log-odds.
#[derive(Deserialize)]
pub(super) struct Forest {
    /// Mean evidence of the regions of a connected component from which it is noisy.
    pub(super) component_threshold: f64,
    /// Mean evidence of the quarter of the regions with the most of it, from which a component is noisy in parts.
    pub(super) quarter_threshold: f64,
    /// Evidence before anything is known.
    start: f64,
    trees: Vec<Tree>,
}

/// A tree as the table of its nodes; the first one is its root, and children come after their parents.
#[derive(Deserialize)]
struct Tree {
    /// Statistic that each node asks for; −1 for a leaf.
    asks: Vec<i32>,
    /// The left child is next where the statistic is at most this; for a leaf, what it adds to the evidence.
    values: Vec<f64>,
    left: Vec<u32>,
    right: Vec<u32>,
}

impl Forest {
    /// The trees that are a part of this crate.
    pub(super) fn built_in() -> &'static Self {
        static FOREST: OnceLock<Forest> = OnceLock::new();
        FOREST.get_or_init(|| serde_json::from_str(include_str!("forest.json")).expect("a test reads it"))
    }

    /// Log-odds that a region with these statistics has noise at all.
    pub(super) fn evidence(&self, statistics: &[f64; COUNT]) -> f64 {
        self.start + self.trees.iter().map(|tree| tree.value(statistics)).sum::<f64>()
    }
}

impl Tree {
    fn value(&self, statistics: &[f64; COUNT]) -> f64 {
        let mut at = 0;
        // A negative number is that of a leaf.
        while let Ok(asked) = usize::try_from(self.asks[at]) {
            let next = if statistics[asked] <= self.values[at] { &self.left } else { &self.right };
            at = next[at] as usize;
        }
        self.values[at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forest_that_is_built_in_ends_in_leaves() {
        let forest = Forest::built_in();
        assert!(forest.trees.len() > 20 && forest.start.is_finite());
        for tree in &forest.trees {
            let count = tree.asks.len();
            assert!([tree.values.len(), tree.left.len(), tree.right.len()].iter().all(|n| *n == count));
            for node in (0..count).filter(|&node| tree.asks[node] >= 0) {
                assert!((tree.asks[node] as usize) < COUNT && tree.values[node].is_finite());
                assert!([&tree.left, &tree.right].iter().all(|of| (node + 1..count).contains(&(of[node] as usize))));
            }
        }
    }

    #[test]
    fn a_tree_goes_left_up_to_its_value_and_right_beyond() {
        let tree =
            Tree { asks: vec![1, -1, -1], values: vec![0.5, -2.0, 3.0], left: vec![1, 0, 0], right: vec![2, 0, 0] };
        let forest = Forest { component_threshold: 0.0, quarter_threshold: 0.0, start: 1.0, trees: vec![tree] };
        let evidence = |x: f64| {
            let mut statistics = [0.0; COUNT];
            statistics[1] = x;
            forest.evidence(&statistics)
        };
        assert_eq!([0.4, 0.5, 0.6].map(evidence), [-1.0, -1.0, 4.0]);
    }
}
