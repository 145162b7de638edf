//! The heat of a print: which voxels are laid down when, and how warm all of them are.
//!
//! ```
//! use std::sync::Arc;
//!
//! use beadwork_part::slice::Voxels;
//! use beadwork_part::{Frame, Pattern};
//! use beadwork_thermal::{Material, Method, Process, Simulation};
//!
//! let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 30, height: 20 };
//! let part = Arc::new(Voxels::new(frame, 2, vec![0; 30 * 20 * 2]));
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
mod explicit;
mod fast;
mod kernel;
mod law;
mod material;
mod occupancy;
mod patch;
mod piece;
mod process;
mod program;
mod property;
mod simulation;
mod state;
mod timeline;

pub use fast::Accuracy;
pub use material::Material;
pub use process::Process;
pub use program::{ProgramError, ProgramSettings, ProgramSlots, VoxelsError, program_slots, program_voxels};
pub use property::PropertyError;
pub use simulation::{DepositError, Method, SetupError, Simulation};
pub use timeline::{Slot, layer_slots};
