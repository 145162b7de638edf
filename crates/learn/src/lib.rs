//! Networks that learn from recorded searches and simulations.
//!
//! [`fusion`] is the network of Aali et al. ("Sequence-Based Evolutionary and Neural Strategies for
//! Reducing Zone Crossings in Toolpaths"), which looks at a layer and proposes the next move of a
//! search: its training ([`fusion::train`]), trained models ([`fusion::model`]), proposals
//! ([`fusion::propose`]) and walks that follow them ([`fusion::walk`]).
//! [`weights`] reads and writes parameters under the names that PyTorch gives them, [`checkpoint`]
//! whole runs; [`adamw`] is the optimiser.
//!
//! All runs on libtorch, through `tch`: `cargo xtask setup` provides it.
//! Nothing else in the workspace links it.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use beadwork_base::Control;
//! use beadwork_grid::{Layout, LayoutSpec, Region, Start};
//! use beadwork_learn::Device;
//! use beadwork_learn::fusion::layer::Layer;
//! use beadwork_learn::fusion::model::Model;
//! use beadwork_learn::fusion::propose::Asked;
//! use beadwork_learn::fusion::walk::{Task, WalkSettings, walk};
//!
//! let region = Region::rectangle(30, 30)?;
//! let zones = LayoutSpec::new(Layout::Islands).zones(&region, 0)?;
//! let layer = Layer::new(&region, &zones);
//! let start = Start::RowZigzag.path(&region, &Control::default())?;
//! let model = Model::open(Path::new("models/fusion-small"), Device::Cpu)?;
//! let task = Task { layer: &layer, start: &start, target: 30, seed: 0 };
//! let walked = walk(&[task], &mut Asked::new(&model.network, Device::Cpu), &WalkSettings::default());
//! assert!(walked[0].crossings <= walked[0].initial);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//! This crate reads and writes the files of weights and runs, and prints nothing. libtorch computes
//! on threads of its own, as many as [`Training::threads`](fusion::train::Training::threads) says;
//! the same number of them on the same processor gives the same bytes, another processor may round
//! otherwise.

pub mod adamw;
pub mod checkpoint;
pub mod fusion;
pub mod weights;

pub use tch::{Cuda, Device};
