//! What stands in for learned methods in builds that do not learn.

use std::path::Path as File;

use anyhow::bail;
use beadwork_grid::{Path, Region, Zones};

/// How `FusionNet` would walk.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "the fields are those of builds that learn")]
pub(crate) struct Fusion<'a> {
    pub(crate) model: &'a File,
    pub(crate) target: u32,
    pub(crate) budget: usize,
}

/// Tells how to come by a build that learns.
pub(crate) fn fusion(_: &Fusion<'_>, _: &Region, _: &Zones, _: &Path, _: u64) -> anyhow::Result<(Path, u64)> {
    bail!("this build has no networks: 'cargo xtask zones --method fusion' makes one that has")
}
