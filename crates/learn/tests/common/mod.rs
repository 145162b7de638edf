//! What several tests need.

#![allow(dead_code, reason = "no test needs all of it")]
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard, PoisonError};

use beadwork_dataset::{Config, Dataset, Factory, GenerateSettings, Slice, generate};
use beadwork_grid::{Layout, LayoutSpec, Region, Zones};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::train::Training;
use tempfile::{TempDir, tempdir};

pub(crate) static NEVER: AtomicBool = AtomicBool::new(false);

/// libtorch's generator of random numbers belongs to the whole process: whoever draws from it holds
/// this, and has it alone.
pub(crate) static GENERATOR: Mutex<()> = Mutex::new(());

pub(crate) fn alone() -> MutexGuard<'static, ()> {
    // A test that failed while it had it leaves nothing behind: each seeds it anew.
    GENERATOR.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A dataset of chains on two small sizes.
pub(crate) const CHAINS: &str = "\
count = 80
per_shard = 16
source = 'chains'
sizes = ['14x11', '10x20']
presets = ['plain', 'noisy']
starts = ['row_zigzag']
layouts = [{ name = 'voronoi' }, { name = 'islands', side = 3 }]
";

pub(crate) fn dataset(config: &str) -> (TempDir, Dataset) {
    let factory = Factory::new(Config::from_toml(config).unwrap(), Vec::new()).unwrap();
    let folder = tempdir().unwrap();
    let settings =
        GenerateSettings { slice: Slice::WHOLE, threads: 2, cancel: &NEVER, observer: &|_| {} };
    generate(&factory, folder.path(), &settings).unwrap();
    let dataset = Dataset::open(folder.path()).unwrap();
    (folder, dataset)
}

/// A network and a training that take a second.
pub(crate) fn small() -> Training {
    Training {
        width: 4,
        hidden: 8,
        history: 4,
        steps: 12,
        batch: 8,
        per_trajectory: 64,
        pool: 2,
        warm_up: 3,
        evaluate_every: 5,
        valid_per_trajectory: 2,
        threads: 1,
        ..Training::default()
    }
}

pub(crate) fn layer(width: u32, height: u32, seed: u64) -> (Region, Zones, Layer) {
    let region = Region::rectangle(width, height).unwrap();
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
    let layer = Layer::new(&region, &zones);
    (region, zones, layer)
}
