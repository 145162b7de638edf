//! Sets that only ever unite.

/// Numbers in disjoint sets, each named by one of its members, the root.
#[derive(Clone, Debug, Default)]
pub(crate) struct Union {
    towards_root: Vec<u32>,
}

impl Union {
    /// So many numbers, each in a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self { towards_root: (0..count as u32).collect() }
    }

    /// The same, without allocating where there is room.
    pub(crate) fn reset(&mut self, count: usize) {
        self.towards_root.clear();
        self.towards_root.extend(0..count as u32);
    }

    /// The root of a number's set; ways to it are halved as they are walked.
    #[inline]
    pub(crate) fn root(&mut self, mut number: u32) -> u32 {
        while self.towards_root[number as usize] != number {
            let next = self.towards_root[self.towards_root[number as usize] as usize];
            self.towards_root[number as usize] = next;
            number = next;
        }
        number
    }

    /// Makes the sets of two numbers one, whose root is that of the second; false if they were one
    /// before.
    #[inline]
    pub(crate) fn unite(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.towards_root[a as usize] = b;
        a != b
    }
}
