//! Lists of numbers in one allocation.

/// A list of numbers for each of a range of items, in one allocation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lists {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Lists {
    /// Lists of `count` items from pairs of an item and an entry, each list in the order of the
    /// pairs.
    pub(crate) fn new(count: usize, pairs: impl Iterator<Item = (usize, u32)> + Clone) -> Self {
        let mut starts = vec![0_u32; count + 1];
        for (item, _) in pairs.clone() {
            starts[item + 1] += 1;
        }
        for item in 0..count {
            starts[item + 1] += starts[item];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; starts[count] as usize];
        for (item, entry) in pairs {
            entries[next[item] as usize] = entry;
            next[item] += 1;
        }
        Self { starts, entries }
    }

    /// The list of an item.
    #[inline]
    pub(crate) fn list(&self, item: usize) -> &[u32] {
        &self.entries[self.starts[item] as usize..self.starts[item + 1] as usize]
    }
}
