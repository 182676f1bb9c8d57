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

use rayon::prelude::*;

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
    /// Drops all lists and keeps their memory.
    pub(crate) fn clear(&mut self) {
        self.starts.truncate(1);
        self.items.clear();
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

impl<T: Copy> Ragged<T> {
    /// Appends the lists of another ragged array.
    pub(crate) fn append(&mut self, other: &Self) {
        let shift = self.items.len() as Index;
        self.items.extend_from_slice(&other.items);
        self.starts.extend(other.starts[1..].iter().map(|start| start + shift));
    }
}

impl<T: Sync> Ragged<T> {
    /// Ragged array of the same shape with other items.
    pub(crate) fn map<U: Send>(&self, item: impl Fn(&T) -> U + Sync) -> Ragged<U> {
        Ragged { starts: self.starts.clone(), items: self.items.par_iter().map(&item).collect() }
    }
}

impl Ragged<Index> {
    /// Groups the indices of `keys` into `count` lists by their key, each in ascending order.
    ///
    /// # Panics
    /// If a key is not below `count`.
    pub(crate) fn by_key(count: usize, keys: &[Index]) -> Self {
        // Each task has keys of its own to look for, so that it writes where no other does, in the order of the whole.
        let tasks = rayon::current_num_threads().clamp(1, MOST_TASKS);
        let width = count.div_ceil(tasks).max(1);
        let mut starts = vec![0; count + 1];
        starts[1..].par_chunks_mut(width).enumerate().for_each(|(task, counts)| {
            for key in keys {
                if let Some(count) = counts.get_mut((*key as usize).wrapping_sub(task * width)) {
                    *count += 1;
                }
            }
        });
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        assert_eq!(starts[count] as usize, keys.len(), "keys are below {count}");
        let mut items = vec![0; keys.len()];
        let mut rest = items.as_mut_slice();
        let mut parts = Vec::with_capacity(tasks);
        for low in (0..count).step_by(width) {
            let high = (low + width).min(count);
            let (part, after) = std::mem::take(&mut rest).split_at_mut((starts[high] - starts[low]) as usize);
            parts.push((low, &starts[low..high], part));
            rest = after;
        }
        parts.into_par_iter().for_each(|(low, starts, part)| {
            let mut next: Vec<Index> = starts.iter().map(|start| start - starts[0]).collect();
            for (item, key) in (0..).zip(keys) {
                if let Some(next) = next.get_mut((*key as usize).wrapping_sub(low)) {
                    part[*next as usize] = item;
                    *next += 1;
                }
            }
        });
        Self { starts, items }
    }
}

/// Number of tasks that group at most: each reads all keys.
const MOST_TASKS: usize = 8;

impl<T: Copy + Default> Ragged<T> {
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

    #[test]
    fn indices_are_grouped_by_their_keys_on_any_number_of_threads() {
        let keys: Vec<Index> = (0..1000).map(|i| i * i % 37).collect();
        let pairs = (0..).zip(&keys).map(|(i, key)| (*key, i));
        let expected = Ragged::group(38, pairs);
        for threads in [1, 2, 3, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| Ragged::by_key(38, &keys)), expected);
        }
        assert_eq!(Ragged::by_key(0, &[]), Ragged::default());
    }
}
