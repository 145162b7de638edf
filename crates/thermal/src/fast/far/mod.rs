//! The far field: slow changes far from the nozzle, on a coarse grid of blocks.
//!
//! # Idea
//!
//! Most of a large part changes slowly and smoothly, so most steps should not touch its voxels at
//! all.
//! Temperatures are split into two terms:
//!
//! - What each **voxel** stores, which steps on blocks do not touch.
//! - The **pending change**, which has accumulated since the voxels were written.
//!   It is smooth, so one number per **block** of voxels suffices: the difference between the
//!   block's mean temperature U and a reference mean.
//!   Blocks are about cubes: 2 x 2 x 4 voxels where these are twice as wide as high.
//!
//! The means follow the heat equation of the blocks, dU/dt = J U + s.
//! The matrix J contains the conduction between blocks and the linearised loss of their surfaces.
//! The constant s is the remainder of the heat exchanged with plate and air, computed from the
//! voxels at the last **restriction** (summing voxels up into blocks).
//! Where voxels are needed, the pending change is added to them by **prolongation** (linear
//! interpolation between blocks, corrected such that every block keeps its mean).
//! A step thus costs a few sweeps over the blocks, however long it is.
//! In the terms of multigrid methods this is a correction on the coarse grid (Brandt, Math. Comp.
//! 31 (1977) 333-390); here it is a correction over time.
//!
//! # Near the nozzle
//!
//! A **region** of whole blocks around recent births is stepped on voxels in a window, at the same
//! time as the blocks (`fast/composite.rs`).
//! The window's border is closed: instead of conducting to the voxels outside, it receives exactly
//! the heat that crosses between the blocks there.
//! The blocks outside gain what the window loses, so heat is conserved up to rounding, however near
//! the border is to the nozzle.
//! (Adaptive mesh refinement corrects the coarse grid afterwards by the fluxes of the fine grid,
//! "refluxing"; here the fine grid takes those of the coarse grid from the start.)
//!
//! # Accuracy
//!
//! Conduction between blocks and prolongation are second order in the size of a block.
//! The blocks' steps are second order in time.
//! Outside the region, changes of the differences *within* a block are not resolved; the region is
//! large enough that these differences have decayed (`fast/level.rs` has its margins and ages).
//!
//! Heat per block is measured in K voxels: a heat of 1 K voxel warms one voxel by one kelvin.

mod block_stepper;
mod conductances;
mod far_field;
mod flux_halo;
mod interpolation;
mod region;
mod restriction;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub(super) use self::far_field::FarField;
pub(super) use self::flux_halo::{BorderFluxes, FluxHalo};
pub(super) use self::region::Region;
