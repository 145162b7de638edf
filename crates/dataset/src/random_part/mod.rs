//! Random parts to train thermal models and policies on.
//!
//! The generator follows the paper (Kim et al. 2026): the first layer is a random rectangle, and
//! each next layer is the layer below, changed in one of two ways.
//!
//! - **Indentation**: rectangles of random sizes, centred on random cells of the outer contour, are
//!   removed.
//!   An opening with an elliptical kernel smooths what is left.
//! - **Overhang**: the layer grows into a random subset of the cells beside it.
//!   An opening with a square kernel smooths what has grown.
//!
//! Only the largest component is kept.
//! A part ends at its maximum number of layers, or below the first layer of which nothing is left.
//! Shorter parts than the minimum are thrown away, and the next attempt continues the same random
//! stream.
//!
//! Numbers that the paper does not state (sizes, chances and kernels) are [`Settings`]; the presets
//! choose them so that parts are as long as the paper's: 53 layers on average of at most 128.
//!
//! Three further kinds of part ([`Kind`]) are not made by the two changes alone, to test models on
//! shapes that they were not trained on.
//!
//! # Guarantees
//! For every kind, settings and seed:
//! - Every voxel above the first layer is supported: it, or one of its four neighbours in the
//!   layer, is filled in the layer below.
//! - Every component of a layer overlaps the layer below, so voxels are connected to the first
//!   layer through faces.
//!   Parts of kinds other than [`Kind::Islands`] are connected.
//! - The same settings and seed give the same part on every machine.
//!
//! # Example
//! ```
//! use beadwork_dataset::random_part::{Kind, Preset, Settings, random_part};
//!
//! let settings = Settings { kind: Kind::Holes, ..Settings::preset(Preset::Grid32) };
//! let part = random_part(&settings, 7)?;
//! assert_eq!((part.frame.width, part.frame.height), (32, 32));
//! assert!((15..=32).contains(&part.depth));
//! # Ok::<(), beadwork_dataset::random_part::RandomPartError>(())
//! ```

mod cavity;
mod generator;
mod mask;
mod settings;

pub use self::generator::{RandomPartError, random_part};
pub use self::settings::{Kind, Preset, Settings, SettingsError};

#[cfg(test)]
mod tests;
