//! `bench dataset`: the factory.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::{cancel, control, machine, output};
use beadwork_dataset::{Config, Factory, generate};
use serde_json::{Value, json};

use super::middle;

/// The factory: preset `paper` of gen-data with one thread and with two, in turn.
#[derive(clap::Args)]
pub(super) struct DatasetArgs {
    /// Trajectories; the preset's own number if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Times each is measured; the median is shown.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
    /// Folder for the datasets, which are removed afterwards; the system's for temporary files if
    /// not given.
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &DatasetArgs) -> anyhow::Result<()> {
    let mut config = Config::preset("paper").expect("it is built in");
    config.count = args.count.unwrap_or(config.count);
    let factory = Factory::new(config, Vec::new(), &Control::default())?;
    let scratch = args.scratch.clone().unwrap_or_else(std::env::temp_dir);
    let mut seconds = [Vec::new(), Vec::new()];
    let mut facts = Value::Null;
    for repeat in 0..args.repeats {
        for threads in [1, 2] {
            let folder =
                scratch.join(format!("beadwork-bench-{}-{repeat}-{threads}", std::process::id()));
            let settings = generate::Settings::default();
            let begin = Instant::now();
            let pool = control::pool(threads)?;
            let control =
                Control { cancel: Some(cancel::token()?), ..Control::on(Threads::Pool(&pool)) };
            let generated = generate(&factory, &folder, &settings, &control);
            seconds[threads - 1].push(begin.elapsed().as_secs_f64());
            let removed = fs::remove_dir_all(&folder);
            let Some(manifest) = generated?.manifest else { bail!("stopped") };
            removed.with_context(|| format!("cannot remove '{}'", folder.display()))?;
            let bytes: u64 = manifest.shards.iter().map(|shard| shard.bytes).sum();
            let raw_bytes: u64 = manifest.shards.iter().map(|shard| shard.raw_bytes).sum();
            facts = json!({
                "trajectories": manifest.records, "moves": manifest.moves, "bytes": bytes, "raw_bytes": raw_bytes,
                "bytes_per_move": bytes as f64 / manifest.moves as f64,
                "compression": raw_bytes as f64 / bytes as f64,
            });
        }
    }
    let [one, two] = seconds.map(middle);
    facts["seconds_1_thread"] = json!(one);
    facts["seconds_2_threads"] = json!(two);
    facts["speed_up"] = json!(one / two);
    facts["peak_memory_bytes"] = json!(machine::peak_memory_bytes());
    if args.json {
        facts["machine"] = machine::facts();
        return output::json(&facts);
    }
    let mut text =
        format!("Machine: {}. Preset paper, median of {} runs.\n\n", machine::line(), args.repeats);
    for (key, value) in facts.as_object().expect("it was made as one") {
        writeln!(text, "- {}: {value}", key.replace('_', " "))?;
    }
    output::text(&text)
}
