//! Coefficients of the blocks of one level.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for its instruction set"
)]

use std::sync::Arc;

/// One coefficient per block of a level.
///
/// Levels of most parts are alike, and so are their blocks; a plane whose values are all the same
/// keeps a single row, and equal planes share their values, so that sweeps read little memory.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    values: Arc<[f32]>,
    /// Distance of two rows in `values`: 0 if all rows are the same.
    stride: usize,
}

impl Plane {
    /// A plane with rows of `width` blocks; values of blocks outside of `mask` do not matter.
    pub(super) fn new(values: Vec<f32>, mask: &[f32], width: usize) -> Self {
        let mut inside =
            values.iter().zip(mask).filter(|&(_, &voxels)| voxels > 0.0).map(|(value, _)| *value);
        let first = inside.next().unwrap_or(0.0);
        if inside.all(|value| value.to_bits() == first.to_bits()) {
            return Self { values: vec![first; width].into(), stride: 0 };
        }
        Self { values: values.into(), stride: width }
    }

    /// This plane; or a plane that shares its values with `other`, if they are equal.
    pub(super) fn shared_with(self, other: Option<&Self>) -> Self {
        match other {
            Some(other) if self.stride == other.stride && self.values == other.values => {
                other.clone()
            }
            _ => self,
        }
    }

    /// The first `count` coefficients of a row of blocks, without the border.
    #[inline(always)]
    pub(super) fn inside(&self, y: usize, count: usize) -> &[f32] {
        &self.values[y * self.stride + 1..][..count]
    }
}
