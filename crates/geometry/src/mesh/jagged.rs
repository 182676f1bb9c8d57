//! Lists of varying length in one allocation, in compressed row storage (CSR).
//!
//! ```
//! use planish_geometry::mesh::jagged::Ragged;
//!
//! let faces: Ragged<u32> = [vec![0, 1, 2], vec![2, 1, 3, 4]].into_iter().collect();
//! assert_eq!((faces.len(), faces.get(1), faces.range(1)), (2, &[2, 1, 3, 4][..], 3..7));
//! // Which faces each vertex has.
//! let pairs = (0..).zip(faces.iter()).flat_map(|(f, face)| face.iter().map(move |&v| (v, f)));
//! assert_eq!(Ragged::<u32>::group(5, pairs).get(1), [0, 1]);
//! ```

/// Index of a vertex, face, corner, edge or uv vertex.
pub type Index = u32;

/// Ragged array, or jagged array: list `i` is `items[starts[i]..starts[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ragged<T> {
    starts: Vec<Index>,
    items: Vec<T>,
}

impl<T> Default for Ragged<T> {
    fn default() -> Self {
        Self { starts: vec![0], items: Vec::new() }
    }
}

impl<T> Ragged<T> {
    /// Adds a list at the end.
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        self.close();
    }
    /// Adds an item to the list that is not closed yet.
    pub(crate) fn extend_open(&mut self, item: T) {
        self.items.push(item);
    }
    /// Ends the list that [`Self::extend_open`] has been filling and gives its length.
    pub(crate) fn close(&mut self) -> usize {
        let start = self.starts[self.starts.len() - 1];
        self.starts.push(self.items.len() as Index);
        self.items.len() - start as usize
    }
    /// Ends the list that [`Self::extend_open`] has been filling if it has `least` items or more, else drops it. Returns whether it
    /// was kept.
    pub(crate) fn close_if(&mut self, least: usize) -> bool {
        let start = self.starts[self.starts.len() - 1] as usize;
        let kept = self.items.len() - start >= least;
        if kept {
            self.close();
        } else {
            self.items.truncate(start);
        }
        kept
    }
    /// Number of lists.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }
    /// Returns true if there is no list at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Range of list `i` in [`Self::items`].
    pub fn range(&self, i: Index) -> std::ops::Range<usize> {
        self.starts[i as usize] as usize..self.starts[i as usize + 1] as usize
    }
    /// Items of list `i`.
    pub fn get(&self, i: Index) -> &[T] {
        &self.items[self.range(i)]
    }
    /// Iterates over the lists in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> + Clone {
        self.starts.windows(2).map(|w| &self.items[w[0] as usize..w[1] as usize])
    }
    /// Items of all lists, list after list, to be changed in place.
    pub(crate) fn items_mut(&mut self) -> &mut [T] {
        &mut self.items
    }
    /// Items of all lists, list after list.
    pub fn items(&self) -> &[T] {
        &self.items
    }
}

impl<T: Copy + Default> Ragged<T> {
    /// Appends the lists of another ragged array.
    pub(crate) fn append(&mut self, other: &Self) {
        let shift = self.items.len() as Index;
        self.items.extend_from_slice(&other.items);
        self.starts.extend(other.starts[1..].iter().map(|start| start + shift));
    }
    /// Groups pairs into `count` lists by their key; within a list the order of the pairs is kept.
    pub fn group<I>(count: usize, pairs: I) -> Self
    where
        I: Iterator<Item = (Index, T)> + Clone,
    {
        let mut starts = vec![0; count + 1];
        for (key, _) in pairs.clone() {
            starts[key as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut items = vec![T::default(); starts[count] as usize];
        let mut next = starts.clone();
        for (key, item) in pairs {
            let slot = &mut next[key as usize];
            items[*slot as usize] = item;
            *slot += 1;
        }
        Self { starts, items }
    }
    /// Calls `edit` on each list, which may change it in place.
    pub(crate) fn for_each_mut(&mut self, mut edit: impl FnMut(&mut [T])) {
        for w in self.starts.windows(2) {
            edit(&mut self.items[w[0] as usize..w[1] as usize]);
        }
    }
}

impl<T> FromIterator<Vec<T>> for Ragged<T> {
    fn from_iter<I: IntoIterator<Item = Vec<T>>>(lists: I) -> Self {
        let mut out = Self::default();
        for list in lists {
            out.push(list);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grouping_keeps_the_order_within_a_list() {
        let pairs = [(2, 'a'), (0, 'b'), (2, 'c'), (0, 'd')];
        let grouped = Ragged::group(3, pairs.into_iter());
        assert_eq!(grouped.iter().collect::<Vec<_>>(), [&['b', 'd'][..], &[], &['a', 'c']]);
    }
}
