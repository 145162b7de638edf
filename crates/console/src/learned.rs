//! Learned methods of `zones`, in builds that learn.

use std::path::Path as Folder;

use anyhow::ensure;
use beadwork_grid::{Path, Region, Zones};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::propose::Asked;
use beadwork_learn::fusion::walk::{Progress, Task, WalkSettings, walk};
use beadwork_learn::{Cuda, Device};
use beadwork_search::Stop;

pub use beadwork_learn::fusion::model::Model;

use crate::search::FusionRow;
use crate::{cancel, progress};

/// How `FusionNet` is to walk.
#[derive(Clone, Copy)]
pub struct Fusion<'a> {
    /// What proposes moves.
    pub model: &'a Model,
    /// Crossings that are enough.
    pub target: u32,
    /// Most moves.
    pub budget: usize,
}

/// The model of a folder, which is to walk on a region.
pub fn open(folder: &Folder, region: &Region) -> anyhow::Result<Model> {
    let model = Model::open(folder, Device::Cpu)?;
    check_size(&model, (region.width(), region.height()))?;
    Ok(model)
}

/// Whether a model knows all places of a layer of so many columns and rows.
pub fn check_size(model: &Model, (width, height): (u32, u32)) -> anyhow::Result<()> {
    let most = model.network.config().places as u32;
    ensure!(
        width <= most && height <= most,
        "the network knows places of layers up to {most} x {most} cells, this one has {width} x {height}"
    );
    Ok(())
}

/// The best path on a walk from a start, the moves to it, and what the walk took.
pub fn fusion(
    of: &Fusion<'_>,
    region: &Region,
    zones: &Zones,
    start: &Path,
    seed: u64,
) -> anyhow::Result<(Path, u64, FusionRow)> {
    let layer = Layer::new(region, zones);
    let task = Task { layer: &layer, start, target: of.target, seed };
    let bar = progress::bar(of.budget as u64, "moves");
    let observer = |come: Progress| {
        bar.set_prefix(format!("{} crossings, moves", come.crossings));
        bar.set_position(come.made as u64);
    };
    let settings = WalkSettings {
        budget: of.budget,
        cancel: Some(cancel::token()?.as_flag()),
        observer: Some(&observer),
        ..WalkSettings::default()
    };
    let mut walked = walk(&[task], &mut Asked::new(&of.model.network, Device::Cpu), &settings);
    bar.finish_and_clear();
    let walked = walked.pop().expect("one task");
    ensure!(walked.stop != Stop::Cancelled, "stopped");
    let row = FusionRow {
        target: of.target,
        reached: walked.stop == Stop::Optimal,
        made: walked.made as u64,
        perturbed: walked.perturbed as u64,
    };
    Ok((walked.path, walked.moves.len() as u64, row))
}

/// The device of this name.
pub fn device(name: &str) -> anyhow::Result<Device> {
    if name == "cpu" {
        return Ok(Device::Cpu);
    }
    ensure!(
        Cuda::is_available(),
        "no graphics card, or a libtorch without CUDA: see 'cargo xtask setup --cuda'"
    );
    Ok(Device::Cuda(0))
}
