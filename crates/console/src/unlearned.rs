//! Stand-in for searches by a trained network, in builds without the feature `learn`.

use std::path::Path as Folder;

use anyhow::bail;
use beadwork_grid::{Path, Region, Zones};

use crate::row::FusionRow;

/// A trained network: builds without the feature `learn` cannot have one.
pub enum Model {}

/// A walk that follows the moves `FusionNet` proposes.
#[derive(Clone, Copy)]
pub struct Fusion<'a> {
    /// The trained network.
    pub model: &'a Model,
    /// Number of crossings at which the walk stops.
    pub target: u32,
    /// Maximum number of moves.
    pub budget: usize,
}

/// Always fails, with an error that explains how to get a build with networks.
pub fn open(_: &Folder, _: &Region) -> anyhow::Result<Model> {
    bail!(
        "this build cannot run networks: use 'cargo xtask zones --method fusion', \
         which builds one that can"
    )
}

/// Never called: a [`Model`] cannot exist.
pub fn fusion(
    of: &Fusion<'_>,
    _: &Region,
    _: &Zones,
    _: &Path,
    _: u64,
) -> anyhow::Result<(Path, u64, FusionRow)> {
    match *of.model {}
}
