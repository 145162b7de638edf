//! The temperatures of a part while it is printed.
//!
//! A part is an array of voxels, each a piece of a bead.
//! Each **deposition event** adds a voxel at the temperature of the nozzle, which holds it there
//! until the event ends.
//! From then on it conducts heat to its neighbours, to the build plate and to the air.
//! A [`Simulation`] solves the heat equation of this growing part, and the rest of the crate
//! measures the result.
//!
//! # Modules
//! - [`simulation`]: [`Simulation`], its [methods](simulation::Method), and all temperatures as
//!   arrays, to read and to set.
//! - [`material`] and [`process`]: what is printed, and how, with presets.
//! - [`event`]: deposition events, and those of a layer that is printed in a given order.
//! - [`program`]: deposition events of a G-code program.
//! - [`statistics`]: how uniform temperatures are, in the part or in a layer.
//! - [`hot_spots`]: connected groups of hot voxels.
//! - [`interlayer`]: substrate temperatures, on which the welds between layers depend.
//! - [`report`]: these measures at the end of a layer, and the paper's reward of a part.
//! - [`objective`]: what plans are judged by: the paper's reward and measures that are harder to
//!   game.
//! - [`section`]: temperatures on a plane through the part.
//! - [`sampling`]: measures over time, such as probes and the time above a temperature.
//! - [`warpage`]: how much the part is likely to warp, to rank plans by.
//!
//! # Example
//! ```
//! use std::sync::Arc;
//!
//! use beadwork_base::Control;
//! use beadwork_part::slice::Voxels;
//! use beadwork_part::{Frame, Pattern};
//! use beadwork_thermal::simulation::Method;
//! use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
//! use ndarray::Array3;
//!
//! let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 30, 20);
//! let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height };
//! let part = Arc::new(Voxels::new(frame, Array3::zeros((2, 20, 30))));
//! let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
//! let mut simulation = Simulation::new(part.clone(), &material, &process, Method::default())?;
//!
//! let control = Control::default();
//! for layer in 0..2 {
//!     let order = Pattern::CONVENTIONAL.order(&part.region(layer as usize)?);
//!     simulation.deposit(layer, &order, &control)?;
//! }
//! let all = simulation.statistics().expect("voxels are deposited");
//! assert!(all.max_c > 200.0 && all.mean_c < 150.0);
//!
//! // Go on from a changed field, such as a prediction: here, 10 K colder.
//! let colder = simulation.temperatures_c() - 10.0;
//! simulation.set_temperatures_c(colder.view())?;
//! simulation.pause(2.0, &control)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! Positions are x, y and z in voxels from the left, the back and the bottom; arrays have the axes
//! `[z, y, x]`.
//! Temperatures are in °C, and names say so (`_c`).
//! Long calls take a [`Control`](beadwork_base::Control); their documentation says what progress
//! counts, and in which state an interruption leaves a simulation.
//! The same input gives the same bits on every machine and on any number of threads.
//!
//! # Features
//! - `oracle` (off by default): the module `oracle`, slow solvers to test against.
//!
//! # Limits
//! Material properties are constants, air has one temperature, beads fill their voxels, and a part
//! has one material.

mod aligned;
mod block_grid;
mod coefficients;
pub mod event;
mod explicit;
mod fast;
pub mod hot_spots;
pub mod interlayer;
mod interval;
mod kernel;
mod line_code;
pub mod material;
mod method;
pub mod objective;
mod occupancy;
#[cfg(any(test, feature = "oracle"))]
pub mod oracle;
mod patch;
pub mod process;
pub mod program;
mod property;
pub mod report;
mod rows;
mod run_control;
pub mod sampling;
pub mod section;
mod shape;
pub mod simulation;
mod state;
pub mod statistics;
#[cfg(test)]
mod testing;
pub mod warpage;

pub use event::DepositionEvent;
pub use hot_spots::HotSpots;
pub use interlayer::InterlayerTemperatures;
pub use material::ThermalMaterial;
pub use process::ProcessParameters;
pub use property::PropertyError;
pub use report::LayerReport;
pub use section::Section;
pub use simulation::Simulation;
pub use statistics::TemperatureStatistics;
