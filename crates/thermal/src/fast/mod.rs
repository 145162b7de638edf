//! The fast stepper: long steps far from the nozzle, short steps near it.
//!
//! # Method
//!
//! Behind the nozzle temperatures change within milliseconds, a few millimetres away within
//! seconds, and farther away within minutes.
//! The naive scheme takes the shortest step everywhere; this stepper takes, at each place, steps as
//! long as the changes there allow.
//! It combines four methods:
//!
//! - **Local time stepping** (multi-rate integration) on nested boxes, as in adaptive mesh
//!   refinement (Berger and Oliger, J. Comput. Phys. 53 (1984) 484-512), but on one mesh: only
//!   steps are refined, not voxels (`stepper.rs`, `window.rs`, `nested.rs`).
//! - **Stabilised explicit steps** (Runge-Kutta-Chebyshev), whose cost grows only with the square
//!   root of their length (`chebyshev.rs`).
//! - **Spatial coarsening** far from the nozzle, for large parts only (`far`, `composite.rs`).
//! - **Vectorised sweeps in place** (`crate::kernel`).
//!
//! There are five levels, from single births to steps of several hundred births on blocks
//! (`level.rs`).
//!
//! # Accuracy
//!
//! Every kind of step is second order in its length, and so is the interpolation at the borders of
//! windows.
//! Two approximations remain.
//! Outside its window, a long step does not know of the births that happen in it, so the first heat
//! that would cross the border is late; **margins** make that heat small.
//! Heat that is older than the **age** of a level counts as smooth enough for its long step.
//! Both are chosen for maximum errors of 1 to 2 K (RMS 0.03 K), or of 0.3 to 0.5 K (RMS 0.01 K)
//! ([`Accuracy`]).
//!
//! What is late at the border of a window is lost: about 0.02 % of the heat moved in a print
//! (`tests/energy.rs` allows 0.1 %).
//! The border of a far-field region loses nothing.
//!
//! # Cost
//!
//! Per birth, about that of the region around the births of the last ten seconds, whatever the size
//! of the part; plus a few per cent for the blocks.
//! An order that jumps about has larger windows and costs more, but is as accurate.

mod chebyshev;
mod composite;
mod far;
mod level;
mod nested;
mod stepper;
mod window;

#[cfg(test)]
mod tests;

pub use self::level::Accuracy;
pub(crate) use self::stepper::FastStepper;
