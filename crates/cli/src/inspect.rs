//! `inspect`: shows and checks the contents of a dataset.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use beadwork_base::{Control, Threads};
use beadwork_console::progress::ProgressBar;
use beadwork_console::{cancel, control, output, progress};
use beadwork_dataset::{Dataset, ShardReader, Trajectory, search_times};
use rayon::prelude::*;
use serde_json::json;

/// Show the contents of a dataset or a shard, and check them.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork inspect datasets/smoke
  beadwork inspect datasets/smoke --verify
  beadwork inspect datasets/smoke/shard-00001.bws --records 3 --json")]
pub(crate) struct Args {
    /// Folder of a dataset, or one shard.
    #[arg(value_name = "DIR | SHARD")]
    path: PathBuf,
    /// Show the first N records.
    #[arg(long, value_name = "N", default_value_t = 0)]
    records: usize,
    /// Check every byte and replay every trajectory move by move.
    #[arg(long)]
    verify: bool,
    /// Threads of --verify; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// A shard that is inspected.
struct Shard {
    path: PathBuf,
    first_record: u64,
    records: u64,
    blocks: u32,
    bytes: u64,
    raw_bytes: u64,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let metadata = fs::metadata(&args.path)
        .with_context(|| format!("cannot read '{}'", args.path.display()))?;
    let dataset = if metadata.is_dir() { Some(Dataset::open(&args.path)?) } else { None };
    let shards = match &dataset {
        Some(dataset) => listed_shards(dataset, &args.path),
        None => vec![read_shard(&args.path)?],
    };
    let shown = first_records(&shards, args.records)?;
    if args.verify {
        verify(&shards, dataset.as_ref(), args.threads)?;
    }

    let sum = |of: fn(&Shard) -> u64| shards.iter().map(of).sum::<u64>();
    let records = sum(|shard| shard.records);
    let (bytes, raw_bytes) = (sum(|shard| shard.bytes), sum(|shard| shard.raw_bytes));
    let manifest = dataset.as_ref().map(Dataset::manifest);
    if args.json {
        return output::json(&json!({
            "path": args.path.display().to_string(), "shards": shards.len(), "records": records,
            "bytes": bytes, "raw_bytes": raw_bytes,
            "moves": manifest.map(|manifest| manifest.moves),
            "strata": manifest.map(|manifest| &manifest.strata),
            "config": manifest.map(|manifest| &manifest.config),
            "verified": args.verify,
            "shown": shown,
        }));
    }

    let mut text = format!(
        "{}: {records} trajectories in {} shards, {:.2} MB, compressed by a factor of {:.2}\n",
        args.path.display(),
        shards.len(),
        bytes as f64 / 1e6,
        raw_bytes as f64 / bytes as f64
    );
    if let Some(manifest) = manifest {
        let per_move = bytes as f64 / manifest.moves.max(1) as f64;
        writeln!(
            text,
            "{} moves, {per_move:.2} bytes per move; made by version {}, seed {}",
            manifest.moves, manifest.crate_version, manifest.seed
        )?;
        writeln!(text, "config {}", manifest.config)?;
        write_strata(&mut text, &manifest.strata)?;
    }
    let times: Option<Vec<Vec<f64>>> =
        shards.iter().map(|shard| search_times(&shard.path)).collect();
    if let Some(times) = times.map(|times| times.concat()).filter(|times| !times.is_empty()) {
        let sum: f64 = times.iter().sum();
        let (mean, max) = (sum / times.len() as f64, times.iter().copied().fold(0.0, f64::max));
        writeln!(
            text,
            "searches took {:.1} s in total, {mean:.2} ms on average, {max:.1} ms at most",
            sum / 1e3
        )?;
    }
    shown.iter().try_for_each(|record| write_record(&mut text, record))?;
    if args.verify {
        writeln!(text, "verified: every byte, and {records} trajectories move by move")?;
    }
    output::text(&text)
}

fn listed_shards(dataset: &Dataset, folder: &Path) -> Vec<Shard> {
    let entries = dataset.manifest().shards.iter();
    let shards = entries.map(|entry| Shard {
        path: folder.join(&entry.file),
        first_record: entry.first,
        records: entry.records,
        blocks: entry.blocks,
        bytes: entry.bytes,
        raw_bytes: entry.raw_bytes,
    });
    shards.collect()
}

/// Reads a shard without a manifest, and checks all of its bytes.
fn read_shard(path: &Path) -> anyhow::Result<Shard> {
    let mut reader = open(path)?;
    let summary = control::with_bar("verify", Threads::One, |control| reader.verify(control))?
        .with_context(|| format!("cannot read '{}'", path.display()))?;
    Ok(Shard {
        path: path.to_owned(),
        first_record: reader.header().first_record,
        records: summary.records,
        blocks: summary.blocks,
        bytes: summary.bytes,
        raw_bytes: summary.raw_bytes,
    })
}

fn open(path: &Path) -> anyhow::Result<ShardReader<BufReader<File>>> {
    let file = File::open(path).with_context(|| format!("cannot read '{}'", path.display()))?;
    ShardReader::open(BufReader::new(file))
        .with_context(|| format!("cannot read '{}'", path.display()))
}

fn first_records(shards: &[Shard], count: usize) -> anyhow::Result<Vec<Trajectory>> {
    let mut shown = Vec::new();
    for shard in shards {
        if shown.len() == count {
            break;
        }
        for record in open(&shard.path)?.records().take(count - shown.len()) {
            shown.push(record.with_context(|| format!("cannot read '{}'", shard.path.display()))?);
        }
    }
    Ok(shown)
}

/// Checks every byte against the manifest and replays all trajectories, in parallel; stops at the
/// first fault.
fn verify(shards: &[Shard], dataset: Option<&Dataset>, threads: usize) -> anyhow::Result<()> {
    let pool = control::pool(threads)?;
    let cancel = cancel::token()?;
    let bar = progress::bar(shards.iter().map(|shard| shard.records).sum(), "verify");
    let blocks: Vec<(&Shard, u32)> = shards
        .iter()
        .flat_map(|shard| (0..shard.blocks).map(move |block| (shard, block)))
        .collect();
    let verified = pool.install(|| {
        if let Some(dataset) = dataset {
            let control = control::cancellable(Threads::One)?;
            (0..shards.len())
                .into_par_iter()
                .try_for_each(|shard| dataset.verify_shard(shard, &control).map(drop))?;
        }
        let moves = blocks.par_iter().map(|&(shard, block)| {
            if cancel.is_cancelled() {
                bail!("stopped");
            }
            verify_block(shard, block, &bar)
        });
        moves.try_reduce(|| 0, |a, b| Ok(a + b))
    });
    bar.finish_and_clear();
    let moves = verified?;
    match dataset.map(|dataset| dataset.manifest().moves) {
        Some(listed) if listed != moves => {
            bail!("manifest lists {listed} moves, the shards hold {moves}")
        }
        _ => Ok(()),
    }
}

/// Replays the trajectories of one block; returns the number of their moves.
fn verify_block(shard: &Shard, block: u32, bar: &ProgressBar) -> anyhow::Result<u64> {
    let in_shard = || format!("'{}'", shard.path.display());
    let mut reader = open(&shard.path)?;
    let first = shard.first_record + reader.first_of_block(block);
    let trajectories: Vec<Trajectory> = reader.read_block(block).with_context(in_shard)?;
    let mut moves = 0;
    for (number, trajectory) in (first..).zip(trajectories) {
        if trajectory.index != number {
            bail!(
                "'{}': trajectory {} found where {number} was expected",
                shard.path.display(),
                trajectory.index
            );
        }
        trajectory
            .replay(&Control::default())
            .with_context(|| format!("'{}', trajectory {number}", shard.path.display()))?;
        moves += trajectory.moves.len() as u64;
        bar.inc(1);
    }
    Ok(moves)
}

fn write_strata(text: &mut String, strata: &BTreeMap<String, u64>) -> std::fmt::Result {
    strata.iter().try_for_each(|(name, count)| writeln!(text, "{count:8}  {name}"))
}

fn write_record(text: &mut String, record: &Trajectory) -> std::fmt::Result {
    writeln!(
        text,
        "\ntrajectory {}: {} {}x{}, {} zones, {} from {} in {} pieces, seed {}",
        record.index,
        record.instance.name(),
        record.width,
        record.height,
        record.zones,
        record.search,
        record.start,
        record.pieces,
        record.seed
    )?;
    let bound = record.bound.map_or("none".to_owned(), |bound| bound.to_string());
    let effective = record.steps().filter(|step| step.effective).count();
    writeln!(
        text,
        "  {} -> {} crossings, bound {bound}; {} moves, {effective} of them effective",
        record.initial,
        record.best,
        record.moves.len()
    )?;
    for (index, step) in record.steps().take(5).enumerate() {
        let mark = if step.effective { "  effective" } else { "" };
        writeln!(text, "  {index:5}: {:?}  {} -> {}{mark}", step.action, step.before, step.after)?;
    }
    if record.moves.len() > 5 { writeln!(text, "  ...") } else { Ok(()) }
}
