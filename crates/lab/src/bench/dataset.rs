//! `bench dataset`: speed of the generation of training data.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use beadwork_base::Threads;
use beadwork_console::{control, machine, output};
use beadwork_dataset::{Config, Factory, Manifest, generate};
use serde_json::json;

use crate::args::positive;
use crate::statistics::median;

/// Measure the generation of training data, preset `paper` of gen-data, alternately on one thread
/// and on two.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench dataset --count 200
  beadwork bench dataset --repeats 3 --scratch /data/tmp --json > dataset.json")]
pub(super) struct DatasetArgs {
    /// Number of trajectories; the preset's by default.
    #[arg(long, value_name = "N", value_parser = positive::<u64>())]
    count: Option<u64>,
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = positive::<u64>())]
    repeats: u64,
    /// Folder for the datasets, which are removed afterwards; the system's folder for temporary
    /// files by default.
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,
    /// Print one JSON document instead of a list.
    #[arg(long)]
    json: bool,
}

/// Generates the dataset on one thread and on two, and prints the figures.
pub(super) fn run(args: &DatasetArgs) -> anyhow::Result<()> {
    let mut config = Config::preset("paper").expect("the preset is built in");
    config.count = args.count.unwrap_or(config.count);
    let factory = Factory::new(config, Vec::new(), &control::cancellable(Threads::One)?)?;
    let scratch = args.scratch.clone().unwrap_or_else(std::env::temp_dir);
    let mut seconds = [Vec::new(), Vec::new()];
    let mut manifest = None;
    for repeat in 0..args.repeats {
        for threads in [1, 2] {
            let name = format!("beadwork-bench-{}-{repeat}-{threads}", std::process::id());
            let run = generate_and_remove(&factory, &scratch.join(name), threads)?;
            seconds[threads - 1].push(run.1);
            manifest = Some(run.0);
        }
    }
    let manifest = manifest.expect("there is at least one run");
    let [one, two] = seconds.map(median);
    let bytes: u64 = manifest.shards.iter().map(|shard| shard.bytes).sum();
    let raw_bytes: u64 = manifest.shards.iter().map(|shard| shard.raw_bytes).sum();
    let mut facts = json!({
        "trajectories": manifest.records,
        "moves": manifest.moves,
        "bytes": bytes,
        "raw_bytes": raw_bytes,
        "bytes_per_move": bytes as f64 / manifest.moves as f64,
        "compression": raw_bytes as f64 / bytes as f64,
        "seconds_1_thread": one,
        "seconds_2_threads": two,
        "speed_up": one / two,
        "peak_memory_bytes": machine::peak_memory_bytes(),
    });
    if args.json {
        facts["machine"] = machine::facts();
        return output::json(&facts);
    }
    let mut text =
        format!("Machine: {}. Preset paper, median of {} runs.\n\n", machine::line(), args.repeats);
    for (key, value) in facts.as_object().expect("the facts are an object") {
        writeln!(text, "- {}: {value}", key.replace('_', " "))?;
    }
    output::text(&text)
}

/// Generates the dataset in a new folder, and removes the folder.
/// Returns the manifest and the seconds of the generation.
fn generate_and_remove(
    factory: &Factory,
    folder: &Path,
    threads: usize,
) -> anyhow::Result<(Manifest, f64)> {
    let pool = control::pool(threads)?;
    let settings = generate::Settings::default();
    let begin = Instant::now();
    let generated = control::with_bar("trajectories", Threads::Pool(&pool), |control| {
        generate(factory, folder, &settings, control)
    })?;
    let seconds = begin.elapsed().as_secs_f64();
    let removed = fs::remove_dir_all(folder);
    let generated = generated?;
    removed.with_context(|| format!("cannot remove '{}'", folder.display()))?;
    if let Some(interrupted) = generated.interrupted {
        return Err(interrupted.into());
    }
    let manifest = generated.manifest.expect("a run that is not interrupted finishes the dataset");
    Ok((manifest, seconds))
}
