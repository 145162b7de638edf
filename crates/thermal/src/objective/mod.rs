//! What plans are judged by: the paper's reward, and measures that are harder to game.
//!
//! A [`HeatMeter`] follows a simulation layer by layer and measures all that one run can yield;
//! [`measure_plan`] measures the orders of a whole part, and an [`Objective`] picks one measure of
//! the result.
//! All objectives are **costs**: lower is better.
//!
//! # How objectives can be gamed
//! No objective is safe alone.
//! Compare plans at equal printing time, or report the printing time beside them.
//!
//! | objective | cost | what lowers it without a better order |
//! |---|---|---|
//! | `reward` | minus the paper's reward (Kim et al. 2026) | waiting at the end of a layer |
//! | `no_travel` | the same, if travel and pauses took no time | nothing that takes time, but travel is free |
//! | `time_averaged` | deviation averaged over the print | printing slowly; waiting a little |
//! | `peak` | maximum deviation in each layer after the first | printing slowly; waiting a little |
//! | `warpage` | estimated lift of the outline | nothing known, but it is a model |
//!
//! - **`reward`** sees only the last moment of each layer.
//!   With the conventional order and a pause of 1 % of the printing time at the layers' ends, it
//!   falls by 43.5, 38.3 and 6.6 % on the paper's three kinds of parts (rectangle, U and pyramid);
//!   an order that ends with long travel moves gains in the same way.
//! - **`no_travel`** gives all orders the same time.
//!   It says nothing of what travel costs: single dots in a scattered order are good at it, and
//!   take many times as long.
//! - **`time_averaged`** hardly rewards pauses: one of 5 % of the printing time lowers it by 3 %.
//! - **`warpage`** depends mostly on the direction of lines, of which the other objectives know
//!   nothing: lines along the shorter side of a plate lift its corners a fraction as much as lines
//!   along the longer side.
//!   None of the others stands for it: of the 38 patterns on a plate, those with a lower `reward`
//!   cost even tend to lift more, because those along the longer side are more even; on square
//!   layers, they tend to lift less.
//!   [`WarpageEstimator`](crate::warpage::WarpageEstimator) describes its limits.
//!
//! A pause at each layer's end is a setting of its own ([`Settings::pause_s`]); its time is part of
//! the printing time.
//!
//! # Sampling in time
//! The deviation over time is integrated by the trapezoidal rule between samples.
//! By default these are at the ends of the method's longest steps, and at both ends of each layer:
//! they cut no step, so a measured run has the same temperatures as [`Simulation::deposit`], bit
//! for bit, on parts without steps on blocks (fewer than some 260,000 voxels).
//! Against samples every 0.02 s, the time average was off by -1.4 to +0.8 % on rectangle and U with
//! two orders each, and gains of one order over the other by up to 1.2 percentage points; with
//! samples every 0.1 s, by 0.3 %.
//! Maxima are more sensitive: those of the first layer, when few voxels are deposited, were half as
//! high, those of later layers 2 to 4 % lower.
//! So compare plans with the same [`Settings::sample_s`], and report final figures with 0.1 s.
//!
//! [`Simulation::deposit`]: crate::Simulation::deposit

mod meter;
mod named;
mod plan;

#[cfg(test)]
mod tests;

pub use self::meter::{HeatMeter, LayerHeat, Settings};
pub use self::named::{Objective, Weighted, WeightedError};
pub use self::plan::{HeatMeasures, MeasureError, measure_events, measure_plan};
