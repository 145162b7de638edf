//! Disjoint sets of numbers (union-find).

/// The numbers 0..count in disjoint sets, each represented by one of its members.
///
/// Each set is a tree: each number points to its parent, and the representative, the root, to
/// itself.
/// [`DisjointSets::find`] halves the paths it follows, so both operations take O(log count)
/// amortised time.
#[derive(Clone, Debug, Default)]
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one number each.
    pub(crate) fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// Starts over with `count` sets of one number each, reusing the memory.
    pub(crate) fn reset(&mut self, count: usize) {
        self.parents.clear();
        self.parents.extend(0..count as u32);
    }

    /// The representative of a number's set.
    #[inline]
    pub(crate) fn find(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            let next = self.parents[self.parents[number as usize] as usize];
            self.parents[number as usize] = next;
            number = next;
        }
        number
    }

    /// Unites the sets of two numbers; the representative becomes that of `b`'s set.
    /// Returns whether they were different sets.
    #[inline]
    pub(crate) fn union(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a as usize] = b;
        a != b
    }
}
