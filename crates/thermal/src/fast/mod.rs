//! The fast stepper: long steps far from the nozzle, short steps near it.
//!
//! # Method
//!
//! Behind the nozzle temperatures change within milliseconds, a few millimetres away within
//! seconds, and farther away within minutes.
//! The naive scheme takes the shortest step everywhere; this stepper takes longer steps wherever
//! temperatures change slowly.
//! It combines four methods:
//!
//! - **Local time stepping** (multi-rate integration) on nested boxes, as in adaptive mesh
//!   refinement (Berger and Oliger, J. Comput. Phys. 53 (1984) 484-512), but on one mesh: only
//!   steps are refined, not voxels (`stepper.rs`, `window.rs`, `clusters.rs`, `nested.rs`).
//! - **Stabilised explicit steps** (Runge-Kutta-Chebyshev), whose cost grows only with the square
//!   root of their length (`chebyshev.rs`).
//! - **Spatial coarsening** far from the nozzle, for large parts only (`far`, `composite.rs`).
//! - **Vectorised sweeps in place** (`crate::kernel`).
//!
//! There are five levels, from single births to steps of several hundred births on blocks
//! (`level.rs`).
//! With [`Accuracy::Draft`], all but the last part of a call has three coarser levels.
//!
//! # Accuracy
//!
//! Every kind of step is second order in its length, and so is the interpolation at the borders of
//! windows.
//! Two approximations remain.
//! A long step does not know of the births within it, so outside its window the first heat of these
//! births arrives one step late.
//! Wide **margins** around the births keep that heat small.
//! Heat that is older than the **age** of a level counts as smooth enough for its long step.
//! Both are chosen for maximum errors of 1 to 2 K (RMS 0.03 K), or of 0.3 to 0.5 K (RMS 0.01 K)
//! ([`Accuracy`]).
//!
//! The heat of births that reaches the border of a window within a step is lost: about 0.02 % of
//! the heat moved in a print (`tests/energy.rs` allows 0.1 %).
//! The border of a far-field region loses nothing.
//!
//! # Cost
//!
//! On a large part, a birth costs about as much as the region around recent births, whatever the
//! size of the part, plus a few per cent for the blocks.
//! Recent births are those of about the last three steps on blocks, half a minute for the paper's
//! ABS.
//! An order that jumps about has several windows at a time (`clusters.rs`), and costs more, but is
//! as accurate.

mod chebyshev;
mod clusters;
mod composite;
mod far;
mod groups;
mod level;
mod nested;
mod stepper;
mod window;

#[cfg(test)]
mod tests;

pub use self::level::Accuracy;
pub(crate) use self::stepper::{FastStepper, INTERVALS_PER_RUN};
