//! The run that makes a dataset.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;

use beadwork_base::{Control, Interrupted};

use super::error::GenerateError;
use super::shard_range::ShardRange;
use super::shards::{FinishedShard, PackedShard, Shards};
use crate::factory::Factory;
use crate::file::FileError;
use crate::manifest::Manifest;

/// How to make a dataset.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// The shards to make; all of them by default.
    pub shards: ShardRange,
}

/// What a run of [`generate()`] did, and what is in the folder now.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The manifest, if the dataset is finished.
    pub manifest: Option<Manifest>,
    /// Number of trajectories made by this run.
    pub made: u64,
    /// Number of trajectories of this shard range that earlier runs had made.
    pub kept: u64,
    /// Number of shards of the whole dataset that are missing: those of other shard ranges, or
    /// those that an interrupted run did not reach.
    pub missing_shards: u32,
    /// Why the run ended early, if it did; running it again continues.
    pub interrupted: Option<Interrupted>,
}

/// Makes the dataset of a factory in a folder, or the part of it that is missing.
///
/// Shards that earlier runs left in the folder are checked and kept; finished shards also survive
/// an interruption of this run.
/// While the searches of a shard run on the threads of `control`, one more thread writes the
/// previous shard.
/// At most two shards are in memory.
///
/// Progress counts the trajectories of the shard range.
/// The first report, before the first search, counts the trajectories of earlier runs.
pub fn generate(
    factory: &Factory,
    folder: &Path,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Outcome, GenerateError> {
    fs::create_dir_all(folder).map_err(|cause| FileError::new("write", folder, cause))?;
    let layout = Shards::new(factory, folder);
    layout.check_manifest()?;

    // Shards of earlier runs.
    let mut shards: Vec<Option<FinishedShard>> = vec![None; layout.count as usize];
    layout.find_finished(&mut shards, control)?;
    let range = settings.shards.shards(layout.count);
    let (finished, missing): (Vec<u32>, Vec<u32>) =
        range.partition(|&number| shards[number as usize].is_some());
    let count = |numbers: &[u32]| -> u64 {
        numbers.iter().map(|&number| layout.records(number)).map(|it| it.end - it.start).sum()
    };
    let kept = count(&finished);
    let total = kept + count(&missing);
    let done = AtomicU64::new(kept);
    let report = |more: u64| {
        let done = done.fetch_add(more, Ordering::Relaxed) + more;
        control.report(done as usize, total as usize);
    };
    report(0);

    // The missing shards, one after the other; each is written while the next one is searched.
    let mut interrupted = None;
    let written = std::thread::scope(|scope| {
        let layout = &layout;
        let (sender, receiver) = mpsc::sync_channel::<PackedShard>(0);
        let writer = scope.spawn(move || {
            let write = |packed: PackedShard| Ok((packed.number, layout.write(&packed)?));
            receiver.into_iter().map(write).collect::<Result<Vec<_>, FileError>>()
        });
        for number in missing {
            let packed = match layout.make(number, control, &|| report(1)) {
                Ok(packed) => packed,
                Err(GenerateError::Interrupted(reason)) => {
                    interrupted = Some(reason);
                    break;
                }
                Err(error) => return Err(error),
            };
            if sender.send(packed).is_err() {
                // The writer has failed; its error is returned below.
                break;
            }
        }
        drop(sender);
        Ok(writer.join().expect("the writer does not panic")?)
    })?;
    let made = written.iter().map(|(_, shard)| shard.summary.records).sum();
    for (number, shard) in written {
        shards[number as usize] = Some(shard);
    }

    // Runs for other shard ranges may have finished shards meanwhile.
    layout.find_finished(&mut shards, &Control::on(control.threads))?;
    let missing_shards = shards.iter().filter(|shard| shard.is_none()).count() as u32;
    let manifest = match shards.into_iter().collect::<Option<Vec<_>>>() {
        Some(shards) => {
            let manifest = layout.manifest(shards);
            layout.store(&manifest)?;
            Some(manifest)
        }
        None => None,
    };
    Ok(Outcome { manifest, made, kept, missing_shards, interrupted })
}
