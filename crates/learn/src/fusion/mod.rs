//! FusionNet: a U-Net over a layer, modulated by the last moves, that proposes where to move next
//! and how.
//!
//! Aali et al., "Sequence-Based Evolutionary and Neural Strategies for Reducing Zone Crossings in
//! Toolpaths", section FusionNet.
//! Details that the text leaves open follow its public implementation, including the names of the
//! parameters: a PyTorch state dict loads by name and shape.
//!
//! From a dataset to a better path, in the order of use:
//! - [`episode`]: a recorded search, with the moves that its gains depended on;
//! - [`samples`]: batches of examples, streamed from a dataset, as `ndarray` arrays;
//! - [`layer`] and [`inputs`]: a state of a path, and the image of it that the network sees;
//! - [`FusionNet`] and its [`Config`], [`loss`], [`train`] with its [`TrainingConfig`];
//! - [`evaluate`] and [`baseline`]: accuracy on held-out examples, and accuracy without a network;
//! - [`model`]: a trained network in a folder;
//! - [`propose`] and [`walk`]: proposals for a state, and walks that follow them.
//!
//! Tensors of images have the axes `[batch, channel, y, x]`, arrays `[example, y, x, channel]`.

pub mod baseline;
mod blocks;
mod config;
pub mod episode;
pub mod evaluate;
mod history;
pub mod inputs;
pub mod layer;
pub mod loss;
pub mod model;
mod network;
#[cfg(feature = "oracle")]
pub mod parity;
mod prefetch;
pub mod propose;
pub mod samples;
pub mod train;
mod training_config;
pub mod walk;

pub use self::config::{ACTIONS, Ablation, CHANNELS, Config, MAX_SIDE, Precision};
pub use self::history::History;
pub use self::network::{FusionNet, Proposals};
pub use self::training_config::{TrainingConfig, TrainingConfigError};
pub use tch::nn::VarStore;
