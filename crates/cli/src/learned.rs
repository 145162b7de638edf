//! Learned methods of `zones`, in builds that learn.

use std::path::Path as File;

use anyhow::ensure;
use beadwork_grid::{Path, Region, Zones};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::model::Model;
use beadwork_learn::fusion::propose::Asked;
use beadwork_learn::fusion::walk::{Progress, Task, WalkSettings, walk};
use beadwork_search::Stop;

use crate::{cancel, progress};

/// How `FusionNet` is to walk.
#[derive(Clone, Copy)]
pub(crate) struct Fusion<'a> {
    /// The folder of the model.
    pub(crate) model: &'a File,
    /// Crossings that are enough.
    pub(crate) target: u32,
    /// Most moves.
    pub(crate) budget: usize,
}

/// The best path on a walk from a start, and the moves to it.
pub(crate) fn fusion(
    of: &Fusion<'_>,
    region: &Region,
    zones: &Zones,
    start: &Path,
    seed: u64,
) -> anyhow::Result<(Path, u64)> {
    let device = beadwork_learn::Device::Cpu;
    let model = Model::open(of.model, device)?;
    let most = model.network.config().places as u32;
    ensure!(
        region.width() <= most && region.height() <= most,
        "the network knows places of layers up to {most} x {most} cells, this one has {} x {}",
        region.width(),
        region.height()
    );
    let layer = Layer::new(region, zones);
    let task = Task { layer: &layer, start, target: of.target };
    let bar = progress::bar(of.budget as u64, "moves");
    let observer = |come: Progress| {
        bar.set_prefix(format!("{} crossings, moves", come.crossings));
        bar.set_position(come.made as u64);
    };
    let settings = WalkSettings {
        budget: of.budget,
        seed,
        cancel: Some(cancel::token()?),
        observer: Some(&observer),
        ..WalkSettings::default()
    };
    let mut walked = walk(&[task], &mut Asked::new(&model.network, device), &settings);
    bar.finish_and_clear();
    let walked = walked.pop().expect("one task");
    ensure!(walked.stop != Stop::Cancelled, "stopped");
    Ok((walked.path, walked.moves.len() as u64))
}
