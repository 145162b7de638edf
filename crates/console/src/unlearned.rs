//! What stands in for learned methods in builds that do not learn.

use std::path::Path as Folder;

use anyhow::bail;
use beadwork_grid::{Path, Region, Zones};

use crate::search::FusionRow;

/// No build that does not learn has one.
pub enum Model {}

/// How `FusionNet` would walk.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "the fields are those of builds that learn")]
pub struct Fusion<'a> {
    pub model: &'a Model,
    pub target: u32,
    pub budget: usize,
}

/// Tells how to come by a build that learns.
pub fn open(_: &Folder, _: &Region) -> anyhow::Result<Model> {
    bail!("this build has no networks: 'cargo xtask zones --method fusion' makes one that has")
}

/// Is never called, for want of a model.
pub fn fusion(
    of: &Fusion<'_>,
    _: &Region,
    _: &Zones,
    _: &Path,
    _: u64,
) -> anyhow::Result<(Path, u64, FusionRow)> {
    match *of.model {}
}
