//! Disjoint sets of indices, each represented by its lowest member.

use crate::mesh::jagged::Index;

/// Partition of indices into sets that can be joined.
pub(crate) struct UnionFind {
    parent: Vec<Index>,
}

impl UnionFind {
    /// Puts each index into a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self { parent: (0..count as Index).collect() }
    }
    /// Finds the lowest member of the set of `i`.
    pub(crate) fn lowest(&mut self, mut i: Index) -> Index {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }
    /// Joins the sets of `a` and `b`; returns true if they were two.
    pub(crate) fn join(&mut self, a: Index, b: Index) -> bool {
        let (a, b) = (self.lowest(a), self.lowest(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }
    /// Finds the lowest member of the set of each index.
    pub(crate) fn into_lowest(mut self) -> Vec<Index> {
        (0..self.parent.len() as Index).map(|i| self.lowest(i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_known_by_their_lowest_member() {
        let mut sets = UnionFind::new(6);
        assert!(sets.join(5, 3) && sets.join(3, 4) && sets.join(0, 2) && !sets.join(4, 5));
        assert_eq!(sets.into_lowest(), [0, 1, 0, 3, 3, 3]);
    }
}
