//! Sweeps: the loops over all voxels of a patch, in which the solver spends its time.
//!
//! A sweep evaluates the seven-point stencil of the heat equation at every voxel below the first
//! empty layer.
//! There are two of them:
//!
//! - [`EulerSweep`]: one forward Euler step from one array into another.
//! - [`TwoStageSweep`]: two stages of an explicit method at once, in place, so that each
//!   temperature is read and written once for both.
//!   The second stage lags the first by one plane (wavefront, or temporal, blocking).
//!
//! Four choices make them fast:
//!
//! - **Vector lanes.**
//!   Loops are generic over the vector width and compiled for each instruction set; the widest that
//!   the processor has is chosen at run time (`lanes.rs`).
//! - **No branches per voxel.**
//!   Missing neighbours hold 0 and need no test (`coefficients.rs`).
//!   Sixteen voxels share a code byte, and runs of lines with the same code share a loop; the loop
//!   for interior voxels takes seven loads and eight arithmetic instructions per vector (`runs.rs`,
//!   `equation.rs`).
//! - **Wavefront blocking.**
//!   Intermediate values exist for three planes only, which stay in the cache (`slab.rs`).
//! - **Two layouts of the loop.**
//!   Patches of up to 4,096 elements are swept as one flat range, because there the start of each
//!   plane and run costs as much as its voxels (`flat.rs`).
//!
//! With AVX-512 a line of 16 interior voxels takes about 7 cycles; `docs/thermal.md` has what
//! limits it.
//! The cost is linear in the voxels below the first empty layer, active or not.
//!
//! **Bits.**
//! Results do not depend on the vector width, on the number of threads or on which of the layouts
//! is used, and they are the same for a mirrored or transposed part.
//! Tests compare the bits, so the order of floating-point operations is part of the definition.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for the vector width of the sweep"
)]

mod equation;
mod euler;
mod flat;
mod lanes;
mod runs;
mod slab;
mod stages;
mod two_stage;

#[cfg(test)]
mod tests;

pub(crate) use self::euler::EulerSweep;
pub(crate) use self::lanes::dispatch;
pub(crate) use self::stages::{Quadratic, TwoSteps};
pub(crate) use self::two_stage::{SweepBuffers, TwoStageSweep};
