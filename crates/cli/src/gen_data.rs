//! `gen-data`: recorded searches as training data.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use beadwork_base::{Control, Progress, Threads};
use beadwork_console::{cancel, control, output, progress};
use beadwork_dataset::{Config, Factory, ShardRange, generate};
use serde_json::json;

/// Write training data: recorded searches, in files with checksums (shards).
///
/// The same configuration gives the same bytes with any number of threads.
/// The same command resumes an interrupted run.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork gen-data --preset smoke
  beadwork gen-data --preset paper --out datasets/paper --threads 2
  beadwork gen-data --preset genetic --out datasets/genetic
  beadwork gen-data --preset pictures --pictures my/pictures
  beadwork gen-data --config configs/gen-data/paper.toml --shard 1/4 --out /data/paper")]
pub(crate) struct Args {
    #[command(flatten)]
    source: ConfigSource,
    /// Folder of PNG pictures; overrides the configuration.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Seed; overrides the configuration.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of trajectories; overrides the configuration.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Folder to write to; datasets/NAME by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Write only the I-th of N equal ranges of shards.
    /// All ranges in one folder give the same bytes as one complete run; the range that ends last
    /// writes the manifest.
    #[arg(long, value_name = "I/N", default_value_t = ShardRange::ALL)]
    shard: ShardRange,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct ConfigSource {
    /// Built-in configuration: smoke (takes seconds), paper (22,111 trajectories, as in Aali et
    /// al.), genetic (240 solutions of the genetic algorithm), chains (training data of FusionNet),
    /// pictures (a folder of PNG files).
    #[arg(
        long,
        value_name = "NAME",
        value_parser = ["smoke", "paper", "genetic", "chains", "pictures"]
    )]
    preset: Option<String>,
    /// Configuration file; see configs/gen-data.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let (name, mut config) = args.source.load()?;
    if let Some(pictures) = &args.pictures {
        if config.pictures.is_none() {
            output::usage_error(
                "--pictures requires a configuration of pictures, such as --preset pictures",
            );
        }
        config.pictures = Some(pictures.to_string_lossy().into_owned());
    }
    config.seed = args.seed.unwrap_or(config.seed);
    config.count = args.count.unwrap_or(config.count);
    let folder = args.out.clone().unwrap_or_else(|| Path::new("datasets").join(name));
    let pictures = match &config.pictures {
        Some(configured) => {
            read_pictures(args.pictures.as_deref().unwrap_or(Path::new(configured)))?
        }
        None => Vec::new(),
    };
    let bar = progress::bar(0, "gen-data");
    let report = |Progress { done, total }: Progress| {
        if bar.length() != Some(total as u64) {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
            bar.reset_eta();
        }
        bar.set_position(done as u64);
    };
    let pool = control::pool(args.threads)?;
    let control = Control {
        threads: Threads::Pool(&pool),
        cancel: Some(cancel::token()?),
        progress: Some(&report),
        ..Control::default()
    };
    let factory = Factory::new(config, pictures, &control)?;
    let settings = generate::Settings { shards: args.shard };
    let generated = generate(&factory, &folder, &settings, &control);
    bar.finish_and_clear();
    let generated = generated?;
    if generated.interrupted.is_some() {
        bail!(
            "stopped; {} trajectories are in '{}'; the same command resumes the run",
            generated.made + generated.kept,
            folder.display()
        );
    }
    let (moves, bytes, raw_bytes) = generated.manifest.as_ref().map_or((0, 0, 0), |manifest| {
        let sum = |of: fn(&beadwork_dataset::ShardEntry) -> u64| {
            manifest.shards.iter().map(of).sum::<u64>()
        };
        (manifest.moves, sum(|shard| shard.bytes), sum(|shard| shard.raw_bytes))
    });
    if args.json {
        return output::json(&json!({
            "out": folder.display().to_string(),
            "slice": args.shard.to_string(),
            "made": generated.made,
            "kept": generated.kept,
            "missing_shards": generated.missing_shards,
            "complete": generated.manifest.is_some(),
            "moves": moves,
            "bytes": bytes,
            "raw_bytes": raw_bytes,
        }));
    }
    let trajectories = generated.made + generated.kept;
    output::text(&match generated.manifest {
        Some(manifest) => format!(
            "{} trajectories, {moves} moves, {:.1} MB in '{}'; {} made by this run\n",
            manifest.records,
            bytes as f64 / 1e6,
            folder.display(),
            generated.made
        ),
        None => format!(
            "shard range {}: {trajectories} trajectories in '{}'; {} shards of other ranges are \
             missing\n",
            args.shard,
            folder.display(),
            generated.missing_shards
        ),
    })
}

impl ConfigSource {
    /// The configuration and the name of its dataset.
    fn load(&self) -> anyhow::Result<(String, Config)> {
        if let Some(name) = &self.preset {
            let config = Config::preset(name).expect("clap checked the name");
            return Ok((name.clone(), config));
        }
        let path = self.config.as_ref().expect("clap requires one of the two");
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read '{}'", path.display()))?;
        let config = Config::from_toml(&text).with_context(|| format!("'{}'", path.display()))?;
        let name =
            path.file_stem().map_or("dataset".into(), |name| name.to_string_lossy().into_owned());
        Ok((name, config))
    }
}

/// Reads the PNG files of a folder; returns the name of each, without extension, and its bytes.
fn read_pictures(folder: &Path) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot list '{}'", folder.display()))?;
    let mut pictures = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("cannot list '{}'", folder.display()))?.path();
        let is_png =
            path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        if let (true, Some(name)) = (is_png, path.file_stem()) {
            let bytes =
                fs::read(&path).with_context(|| format!("cannot read '{}'", path.display()))?;
            pictures.push((name.to_string_lossy().into_owned(), bytes));
        }
    }
    if pictures.is_empty() {
        bail!("'{}' contains no PNG pictures", folder.display());
    }
    Ok(pictures)
}
