//! Simulated annealing of a path.
//!
//! An annealer proposes random moves.
//! It accepts every move that does not raise the cost, and a move that raises it by d with the
//! probability exp(-d / T), where the temperature T falls during the run (Metropolis et al.,
//! "Equation of State Calculations by Fast Computing Machines", 1953).
//! At high temperatures the path changes almost freely; as the temperature falls, it settles in a
//! state of low cost.
//!
//! The two methods differ in the moves that they propose: [`Pooled`] draws from a pool of the
//! paper's variants, [`Free`] combines any two switches.
//!
//! ```
//! use beadwork_base::Control;
//! use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
//! use beadwork_search::anneal::{self, Preset, Settings};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Stripes).zones(&region, 0)?;
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let cost = Crossings::new(&region, &zones);
//! let settings = Settings::preset(Preset::Paper, 7);
//! let outcome = anneal::solve(&start, &cost, &settings, &Control::default());
//! assert!(outcome.cost < outcome.initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod free;
mod method;
mod pooled;
mod preset;
mod run;
mod settings;
#[cfg(test)]
mod tests;

use beadwork_base::Control;
use beadwork_grid::Path;

pub use method::{Free, Method, Pooled};
pub use preset::Preset;
pub use settings::{Outcome, Progress, Settings};

use self::run::Run;
use crate::Cost;

/// Anneals a path.
///
/// Progress counts proposals; `control` is polled after every thousand of them, or with [`Pooled`]
/// each time that the pool is filled.
/// Works on the calling thread.
///
/// A proposal costs O(1), an accepted move the number of cells between its first and its last cut.
/// Each new best path costs a pass over the cells, and so does each pool of [`Pooled`].
pub fn solve<C: Cost>(
    start: &Path,
    cost: &C,
    settings: &Settings<'_>,
    control: &Control<'_>,
) -> Outcome {
    let run = Run::new(start, cost, settings, control);
    match settings.method {
        Method::Pooled(pooled) => pooled::anneal(&pooled, run, cost),
        Method::Free(free) => free::anneal(&free, run, cost),
    }
}
