//! Datasets, layers and configurations that several tests use.

#![allow(dead_code, reason = "each test uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use beadwork_base::{Control, Threads};
use beadwork_dataset::{Config, Dataset, Factory, generate};
use beadwork_grid::{Layout, LayoutSpec, Region, Zones};
use beadwork_learn::fusion::TrainingConfig;
use beadwork_learn::fusion::layer::Layer;
use tempfile::{TempDir, tempdir};

/// Guards libtorch's random number generator, which is global to the process.
static GENERATOR: Mutex<()> = Mutex::new(());

/// Locks libtorch's random number generator: a test that draws from it holds the guard.
pub(crate) fn lock_generator() -> MutexGuard<'static, ()> {
    // A test that failed with the lock held does no harm: each test seeds the generator itself.
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
    let control = Control::on(Threads::Current);
    let config = Config::from_toml(config).unwrap();
    let factory = Factory::new(config, Vec::new(), &control).unwrap();
    let folder = tempdir().unwrap();
    generate(&factory, folder.path(), &generate::Settings::default(), &control).unwrap();
    let dataset = Dataset::open(folder.path()).unwrap();
    (folder, dataset)
}

/// A configuration whose training takes a second.
pub(crate) fn small() -> TrainingConfig {
    TrainingConfig {
        width: 4,
        hidden: 8,
        history: 4,
        steps: 12,
        batch: 8,
        per_trajectory: 64,
        pool: 2,
        warmup_steps: 3,
        evaluate_every: 5,
        valid_per_trajectory: 2,
        threads: 1,
        ..TrainingConfig::default()
    }
}

pub(crate) fn layer(width: u32, height: u32, seed: u64) -> (Region, Zones, Layer) {
    let region = Region::rectangle(width, height).unwrap();
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, seed).unwrap();
    let layer = Layer::new(&region, &zones);
    (region, zones, layer)
}
