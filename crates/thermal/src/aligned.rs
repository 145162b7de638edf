//! Buffers aligned to cache lines.

/// Number of `f32` in a cache line of 64 bytes.
pub(crate) const LINE_LEN: usize = 16;

/// A growable buffer of `f32` whose first element lies at the start of a cache line.
///
/// A vector load that crosses from one cache line into the next costs two accesses instead of one.
/// Rows are multiples of [`LINE_LEN`], so with an aligned start every load of a row is aligned,
/// except for those of the neighbours in x, which are shifted by one element.
///
/// The buffer allocates one line more than it needs and starts at the first boundary inside: that
/// needs no `unsafe` code and no allocator of its own.
#[derive(Debug, Default)]
pub(crate) struct AlignedBuffer {
    store: Vec<f32>,
    start: usize,
    len: usize,
}

impl AlignedBuffer {
    /// A buffer of `len` zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        let mut buffer = Self::default();
        buffer.reset(len);
        buffer
    }

    /// Resizes the buffer to `len` zeros, in the same memory if it is large enough.
    pub(crate) fn reset(&mut self, len: usize) {
        self.resize(len);
        self.fill(0.0);
    }

    /// Resizes the buffer to `len` elements of unspecified values, in the same memory if it is
    /// large enough.
    pub(crate) fn resize(&mut self, len: usize) {
        if self.store.len() < len + LINE_LEN {
            self.store = vec![0.0; len + LINE_LEN];
            // `align_offset` may return `usize::MAX` if it cannot compute an offset.
            // Any start within the spare line is correct then, only slower.
            self.start = self.store.as_ptr().align_offset(64).min(LINE_LEN);
        }
        self.len = len;
    }
}

/// Copies the elements; the copy finds its own start, since its allocation lies elsewhere.
impl Clone for AlignedBuffer {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.resize(self.len);
        copy.copy_from_slice(self);
        copy
    }
}

impl std::ops::Deref for AlignedBuffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.store[self.start..self.start + self.len]
    }
}

impl std::ops::DerefMut for AlignedBuffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.store[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_are_aligned() {
        for len in [0, 1, 16, 100, 4097] {
            let mut numbers = AlignedBuffer::zeros(len);
            numbers.iter_mut().zip(0u16..).for_each(|(number, i)| *number = i.into());
            let copy = numbers.clone();
            assert_eq!(copy[..], numbers[..]);
            assert_eq!((numbers.as_ptr() as usize % 64, copy.as_ptr() as usize % 64), (0, 0));
        }
    }
}
