//! Networks that learn from recorded searches and simulations.
//!
//! [`fusion`] is the network of Aali et al. ("Sequence-Based Evolutionary and Neural Strategies for Reducing Zone Crossings
//! in Toolpaths"), which looks at a layer and proposes the next move of a search. [`weights`] reads and writes parameters
//! under the names that PyTorch gives them.
//!
//! All runs on libtorch, through `tch`: `cargo xtask setup` provides it. Nothing else in the workspace links it.

pub mod adamw;
pub mod checkpoint;
pub mod fusion;
pub mod weights;

pub use tch::{Cuda, Device};
