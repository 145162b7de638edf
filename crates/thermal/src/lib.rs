//! The heat of a print: which voxels are laid down when, and how warm all of them are.
//!
//! - [`Simulation`]: a part as it is printed, layer by layer or birth by birth, by one of three
//!   [`Method`]s.
//! - [`Material`] and [`Process`]: what it is made of and how, with presets.
//! - [`Spread`]: how even temperatures are, in all of the part or in a layer.
//! - [`HotSpots`]: where heat gathers.
//! - [`LayerReport`]: these measures at a layer's end, and the paper's [`reward`] of a part.
//! - [`Section`]: temperatures on a plane through the part, and how far each is from their mean.
//! - [`Simulation::run_watched`]: looks at a print every so often; [`Probes`] and [`TimeAbove`] are
//!   such looks.
//! - [`Simulation::bonds`]: how warm the ground is on which beads land.
//! - [`Simulation::try_orders`]: many orders of a layer, tried from one state.
//! - [`Warpage`]: how much the part is likely to warp, to rank plans by.
//!
//! ```
//! use std::sync::Arc;
//!
//! use beadwork_part::slice::Voxels;
//! use beadwork_part::{Frame, Pattern};
//! use beadwork_thermal::{Material, Method, Process, Simulation};
//! use ndarray::Array3;
//!
//! let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 30, height: 20 };
//! let part = Arc::new(Voxels::new(frame, Array3::zeros((2, 20, 30))));
//! let mut simulation = Simulation::new(part.clone(), &Material::abs(), &Process::default(), Method::default())?;
//! for layer in 0..2 {
//!     let order = Pattern::CONVENTIONAL.order(&part.region(layer as usize)?);
//!     simulation.deposit(layer, &order)?;
//! }
//! let hottest = simulation.layer_c(1).map(|(_, celsius)| celsius).fold(0.0, f64::max);
//! assert!(hottest > 200.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aligned;
mod block_grid;
mod coefficients;
mod explicit;
mod fast;
mod hot_spots;
mod interlayer;
mod interval;
mod kernel;
mod material;
mod occupancy;
mod patch;
pub mod plain;
mod process;
mod program;
mod property;
mod report;
mod rows;
mod section;
mod simulation;
mod spread;
mod state;
#[cfg(test)]
mod testing;
mod timeline;
mod trials;
pub mod truth;
mod warpage;
mod watch;

pub use fast::Accuracy;
pub use hot_spots::{HotSpot, HotSpots};
pub use interlayer::Bond;
pub use material::Material;
pub use process::Process;
pub use program::{
    ProgramError, ProgramSettings, ProgramSlots, VoxelsError, program_slots, program_voxels,
};
pub use property::PropertyError;
pub use report::{LayerReport, reward};
pub use section::{Plane, Section};
pub use simulation::{DepositError, Method, SetupError, Simulation};
pub use spread::Spread;
pub use timeline::{Slot, layer_slots};
pub use warpage::{Warpage, WarpageEstimate};
pub use watch::{Probes, TimeAbove};
