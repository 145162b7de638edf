//! Vector lanes, and the rules that all code on lanes follows.
//!
//! Sweeps implement [`pulp::WithSimd`] and are generic over [`pulp::Simd`], which has one
//! implementation for each instruction set.
//! [`dispatch`] detects the processor's and runs the matching copy of the sweep.
//!
//! - **Everything below `with_simd` is `#[inline(always)]`.**
//!   Only that function is compiled with the wide instructions enabled; whatever it calls without
//!   inlining runs on the narrowest vectors or on scalars, thirty times slower.
//!   For the same reason loops over runs of lines are iterators and not functions that take a
//!   closure: the compiler does not always inline closures, even if they are marked.
//! - **Products are fused into sums where the source says so (`mul_add_f32s`), and nowhere else.**
//!   The compiler never contracts `a * b + c` or reorders sums on its own.
//!   No sum runs across lanes either, so each element is computed by the same operations in the
//!   same order for every vector width, and the results are the same bits on every processor.
//! - **Slices are cut to one common length before a loop.**
//!   The compiler then proves that all accesses are in bounds and drops the checks; one remaining
//!   check would keep it from unrolling.

use pulp::{Arch, Simd, WithSimd};

/// Runs a sweep on the widest vectors that the processor has.
pub(crate) fn dispatch<W: WithSimd>(sweep: W) -> W::Output {
    Arch::new().dispatch(sweep)
}

/// A range of numbers as whole vectors; `len` is a multiple of the vector width.
/// The start may be unaligned, as that of the neighbours in x is.
#[inline(always)]
pub(super) fn lanes<S: Simd>(numbers: &[f32], start: usize, len: usize) -> &[S::f32s] {
    S::as_simd_f32s(&numbers[start..start + len]).0
}
