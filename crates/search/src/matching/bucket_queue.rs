//! A priority queue for small whole priorities.

/// A queue that returns the items of the lowest priority first, and of these the last one pushed.
///
/// An array of stacks, one for each priority: pushing takes O(1) amortised time, popping the number
/// of empty stacks passed.
#[derive(Default)]
pub(super) struct BucketQueue<T> {
    buckets: Vec<Vec<T>>,
    /// All buckets below this one are empty.
    first: usize,
}

impl<T> BucketQueue<T> {
    /// Removes all items; keeps the memory.
    pub(super) fn clear(&mut self) {
        self.buckets.iter_mut().skip(self.first).for_each(Vec::clear);
        self.first = self.buckets.len();
    }

    #[inline]
    pub(super) fn push(&mut self, priority: u32, item: T) {
        let priority = priority as usize;
        if priority >= self.buckets.len() {
            self.buckets.resize_with(priority + 1, Vec::new);
        }
        self.buckets[priority].push(item);
        self.first = self.first.min(priority);
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<T> {
        while let Some(bucket) = self.buckets.get_mut(self.first) {
            if let Some(item) = bucket.pop() {
                return Some(item);
            }
            self.first += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lowest_priority_comes_first_then_the_last_pushed() {
        let mut queue = BucketQueue::default();
        for (priority, item) in [(3, 'a'), (1, 'b'), (3, 'c'), (1, 'd')] {
            queue.push(priority, item);
        }
        assert_eq!((queue.pop(), queue.pop()), (Some('d'), Some('b')));
        queue.push(0, 'e');
        let rest: Vec<char> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(rest, ['e', 'c', 'a']);
        queue.push(2, 'f');
        queue.clear();
        assert_eq!(queue.pop(), None);
    }
}
