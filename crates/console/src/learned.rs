//! Searches by a trained network, in builds with the feature `learn`.

use std::path::Path as Folder;

use anyhow::ensure;
use beadwork_base::Control;
use beadwork_grid::{Path, Region, Zones};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::propose::NetworkProposer;
use beadwork_learn::fusion::walk::{self, Status, Task};
use beadwork_learn::{Cuda, Device};
use beadwork_search::Stop;

pub use beadwork_learn::fusion::model::Model;

use crate::row::FusionRow;
use crate::{cancel, progress};

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

/// Opens the model in a folder, and checks that it handles a region of this size.
pub fn open(folder: &Folder, region: &Region) -> anyhow::Result<Model> {
    let model = Model::open(folder, Device::Cpu)?;
    check_size(&model, (region.width(), region.height()))?;
    Ok(model)
}

/// Checks that a layer of this width and height is within the size the model was built for.
pub fn check_size(model: &Model, (width, height): (u32, u32)) -> anyhow::Result<()> {
    let most = model.network.config().max_side as u32;
    ensure!(
        width <= most && height <= most,
        "layer is {width} x {height} cells, the network handles at most {most} x {most}"
    );
    Ok(())
}

/// Walks from a start path; returns the best path, the number of moves to it, and the figures for
/// the row.
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
    let observer = |status: Status| {
        bar.set_prefix(format!("{} crossings, moves", status.crossings));
        bar.set_position(status.moves as u64);
    };
    let settings = walk::Settings {
        budget: of.budget,
        observer: Some(&observer),
        ..walk::Settings::default()
    };
    let mut proposer = NetworkProposer::new(&of.model.network, Device::Cpu);
    let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
    let mut outcomes = walk::solve(&[task], &mut proposer, &settings, &control);
    bar.finish_and_clear();
    let walked = outcomes.pop().expect("one task");
    ensure!(walked.stop != Stop::Cancelled, "stopped");
    let row = FusionRow {
        target: of.target,
        reached: walked.stop == Stop::TargetReached,
        made: walked.total_moves as u64,
        perturbed: walked.random_moves as u64,
    };
    Ok((walked.path, walked.moves.len() as u64, row))
}

/// Device by name: `cpu`, or `cuda` for the first graphics card.
pub fn device(name: &str) -> anyhow::Result<Device> {
    if name == "cpu" {
        return Ok(Device::Cpu);
    }
    ensure!(
        Cuda::is_available(),
        "device cuda: no graphics card, or libtorch lacks CUDA; run 'cargo xtask setup --cuda'"
    );
    Ok(Device::Cuda(0))
}
