//! Numbers that start on a cache line.

/// Floats in one cache line.
pub(crate) const LINE_LEN: usize = 16;

/// A slice of `f32` whose first number lies at the start of a cache line of 64 bytes: wide loads
/// that are split between two lines cost twice.
#[derive(Debug, Default)]
pub(crate) struct AlignedBuffer {
    store: Vec<f32>,
    start: usize,
    len: usize,
}

impl AlignedBuffer {
    /// As many zeros.
    pub(crate) fn zeros(len: usize) -> Self {
        let mut aligned = Self::default();
        aligned.reset(len);
        aligned
    }

    /// As many zeros, in the same memory if it suffices.
    pub(crate) fn reset(&mut self, len: usize) {
        self.resize(len);
        self.fill(0.0);
    }

    /// As many numbers, of any values, in the same memory if it suffices.
    pub(crate) fn resize(&mut self, len: usize) {
        if self.store.len() < len + LINE_LEN {
            self.store = vec![0.0; len + LINE_LEN];
            // An allocator may refuse to say (`usize::MAX`): then any start will do.
            self.start = self.store.as_ptr().align_offset(64).min(LINE_LEN);
        }
        self.len = len;
    }
}

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
    fn copies_are_aligned_too() {
        for len in [0, 1, 16, 100, 4097] {
            let mut numbers = AlignedBuffer::zeros(len);
            numbers.iter_mut().zip(0u16..).for_each(|(number, i)| *number = i.into());
            let copy = numbers.clone();
            assert_eq!(copy[..], numbers[..]);
            assert_eq!((numbers.as_ptr() as usize % 64, copy.as_ptr() as usize % 64), (0, 0));
        }
    }
}
