//! Plans for even temperature: in which order the cells, or the infill lines, of each layer are
//! printed.
//!
//! Uneven temperatures warp a part, and the order of deposition decides where it is hot.
//! A planner chooses one order per layer, such that the part's temperatures are even by an
//! objective of the caller's choice, and the part is printed within a time limit.
//! It extends the paper's method (Kim et al. 2026), which chooses among 38 patterns by
//! reinforcement learning.
//!
//! - [`planner`]: the planners, from one order for all layers to annealed orders of lines.
//! - [`plan`](mod@plan): what they return.
//! - [`fill`]: what the layers are printed from: [cells](fill::Cells) a bead wide, or the
//!   [beads](fill::Beads) of a slicer.
//! - [`model`]: what they try orders on: the heat equation, or whatever predicts its result; and
//!   what a layer costs.
//! - [`trials`]: many orders of one layer, tried from one state.
//! - [`candidates`]: sets of named orders.
//! - [`allotment`]: which option each layer takes within a time limit, and what a second is worth.
//! - [`bound`]: a limit on how even any order can be, by an argument.
//! - [`proxy`]: a fast estimate of how even an order leaves a layer, to rank many orders by.
//!
//! # Example
//! ```
//! use std::sync::Arc;
//!
//! use beadwork_base::{Control, Threads};
//! use beadwork_heat::model::{LayerCost, Solver};
//! use beadwork_heat::planner::{Planner, Settings, plan};
//! use beadwork_heat::plan::same_order;
//! use beadwork_part::slice::Voxels;
//! use beadwork_part::{Frame, Order};
//! use beadwork_thermal::objective::Objective;
//! use beadwork_thermal::simulation::Method;
//! use beadwork_thermal::{ProcessParameters, ThermalMaterial};
//!
//! let (left_mm, back_mm) = (0.0, 0.0);
//! let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 24, 16);
//! let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
//! let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((3, 16, 24))));
//! let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
//! let cost = LayerCost::of(Objective::Reward)?;
//! let model = Solver::new(part, &material, &process, Method::default(), cost)?;
//!
//! let control = Control::on(Threads::Current);
//! let conventional = same_order(&model, Order::CONVENTIONAL, &control)?;
//! let max_seconds = 1.05 * conventional.seconds();
//! let settings = Settings { planner: Planner::Lines, max_seconds, ..Settings::default() };
//! let plan = plan(&model, &settings, &control)?;
//! assert!(plan.cost() < conventional.cost() && plan.seconds() <= max_seconds);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! Temperatures and their deviations are in K, times in s.
//! Orders of cells are lists of cells, row-major with x fastest, as everywhere in beadwork.
//! Orders of beads are lists of their numbers and directions.
//! Nothing here does I/O or reads a clock.
//! The same seed gives the same plan on every machine and any number of threads.
//!
//! # Limits
//! A time limit is never exceeded, but plans are not proven to be the best within it.
//! The planners print whole lines, or patterns; they do not cut lines into pieces.

pub mod allotment;
pub mod bound;
pub mod candidates;
pub mod fill;
pub mod model;
pub mod plan;
pub mod planner;
pub mod proxy;
mod solver;
pub mod trials;

#[cfg(test)]
mod testing;
