//! `bench learn`: rates of training, of what feeds it and of asking a network; and a network beside
//! PyTorch's.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, ensure};
use beadwork_console::{machine, memory, output};
use beadwork_dataset::Dataset;
use beadwork_learn::Device;
use beadwork_learn::adamw::{self, AdamW};
use beadwork_learn::fusion::parity;
use beadwork_learn::fusion::samples::{Batch, Batches, Split};
use beadwork_learn::fusion::train::training_step;
use beadwork_learn::fusion::{FusionNet, Precision, TrainingConfig, VarStore};
use serde_json::json;

use super::middle;

/// Measure how fast networks are trained and asked, or compare one with PyTorch's.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork gen-data --preset chains --count 720 --out datasets/chains-few
  beadwork bench learn --data datasets/chains-few
  beadwork bench learn --parity fusion_weights.safetensors fusion_io.safetensors")]
pub(super) struct LearnArgs {
    /// A dataset whose examples are loaded.
    #[arg(long, value_name = "DIR", default_value = "datasets/chains")]
    data: PathBuf,
    /// Channels of the network, f.
    #[arg(long, value_name = "N", default_value_t = 32)]
    width: i64,
    /// Examples in a batch.
    #[arg(long, value_name = "N", default_value_t = 64)]
    batch: usize,
    /// Steps measured, after two that are not.
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Instead: the largest difference between a network and what PyTorch made of its weights and
    /// inputs, both in safetensors.
    #[arg(long, value_names = ["WEIGHTS", "IO"], num_args = 2)]
    parity: Option<Vec<PathBuf>>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// What must not be exceeded, by the most that the order of sums in single precision explains.
const TOLERANCE: f64 = 1e-4;

pub(super) fn run(args: &LearnArgs) -> anyhow::Result<()> {
    if let Some([weights, io]) = args.parity.as_deref() {
        return compare(weights, io, args.json);
    }
    memory::keep_freed();
    let dataset = Dataset::open(&args.data)?;
    let training =
        TrainingConfig { width: args.width, batch: args.batch, ..TrainingConfig::default() };
    training.check()?;
    let (loaded, loading) = load(&dataset, &training)?;
    let loaded = &loaded.context("the dataset has no full batch on a canvas of 32 x 32 cells")?;
    let mut rows = Vec::new();
    for precision in [Precision::Single, Precision::Half] {
        let training = TrainingConfig { precision, ..training.clone() };
        let seconds =
            middle(measure_steps(&training, loaded, args.steps as usize + 2).split_off(2));
        rows.push((precision, loaded.inputs.len() as f64 / seconds));
    }
    let asked = ask(&training, loaded);
    let memory = peak_memory_gb();
    if args.json {
        let rate = |precision| rows.iter().find(|row| row.0 == precision).map(|row| row.1);
        return output::json(&json!({
            "width": args.width,
            "batch": loaded.inputs.len(),
            "train_examples_per_second": { "single": rate(Precision::Single), "half": rate(Precision::Half) },
            "load_examples_per_second": loading,
            "forward_milliseconds": asked,
            "peak_memory_gb": memory,
            "machine": machine::facts(),
        }));
    }
    let mut lines = vec![machine::line()];
    for (precision, rate) in rows {
        lines.push(format!(
            "training, {precision:?}: {rate:.0} examples/s at f = {}, 32 x 32 cells",
            args.width
        ));
    }
    lines.push(format!("loading: {loading:.0} examples/s"));
    lines.push(format!("forward: {asked:.2} ms for an example of a batch"));
    lines.extend(memory.map(|memory| format!("peak memory: {memory:.2} GB")));
    output::text(&(lines.join("\n") + "\n"))
}

/// The first full batch on a canvas of 32 x 32 cells, and how many examples a second were made, of
/// all canvases by their cells.
fn load(dataset: &Dataset, training: &TrainingConfig) -> anyhow::Result<(Option<Batch>, f64)> {
    let settings = training.samples();
    let begin = Instant::now();
    let (mut full, mut cells) = (None, 0);
    for batch in Batches::new(dataset, Split::Train, &settings, 0) {
        let batch = batch?;
        let canvas = batch.inputs.canvas();
        cells += canvas.cells() * batch.inputs.len();
        if canvas.cells() == 32 * 32 && batch.inputs.len() == settings.batch {
            full.get_or_insert(batch);
        }
        if begin.elapsed().as_secs_f64() > 10.0 {
            break;
        }
    }
    Ok((full, cells as f64 / (32.0 * 32.0) / begin.elapsed().as_secs_f64()))
}

/// Seconds of training steps on one batch, by a network of its own, on the processor.
fn measure_steps(training: &TrainingConfig, batch: &Batch, steps: usize) -> Vec<f64> {
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), training.network());
    let mut optimiser = AdamW::new(variables.trainable_variables(), adamw::Settings::default());
    let seconds = (0..steps).map(|_| {
        let begin = Instant::now();
        let rate = training.learning_rate;
        training_step(&network, &mut optimiser, batch, training, rate, Device::Cpu);
        begin.elapsed().as_secs_f64()
    });
    seconds.collect()
}

/// Milliseconds of a forward pass, an example.
fn ask(training: &TrainingConfig, batch: &Batch) -> f64 {
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), training.network());
    let (state, history) = batch.inputs.tensors(Device::Cpu);
    let seconds = super::median(5, |_| {
        network.infer(&state, &history, Precision::Single);
    });
    1e3 * seconds / batch.inputs.len() as f64
}

fn compare(weights: &Path, io: &Path, as_json: bool) -> anyhow::Result<()> {
    let parity::Parity { config, position, action } = parity::compare(weights, io)?;
    if as_json {
        output::json(&json!({
            "width": config.width,
            "hidden": config.hidden,
            "history": config.history,
            "position": position,
            "action": action,
            "tolerance": TOLERANCE,
        }))?;
    } else {
        output::text(&format!(
            "f = {}, {} hidden units, {} moves remembered: largest difference {position:.2e} in positions, {action:.2e} in \
             actions\n",
            config.width, config.hidden, config.history
        ))?;
    }
    ensure!(position.max(action) <= TOLERANCE, "the differences are above {TOLERANCE:e}");
    Ok(())
}

/// The most memory that the process ever had, where the system tells.
fn peak_memory_gb() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0 / 1e9)
}
