//! `bench learn`: speed of training, of loading examples and of forward passes; and the difference
//! between a network here and in PyTorch.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, ensure};
use beadwork_base::{Control, Threads};
use beadwork_console::{control, machine, memory, output, progress};
use beadwork_dataset::Dataset;
use beadwork_learn::Device;
use beadwork_learn::adamw::{self, AdamW};
use beadwork_learn::fusion::parity::{self, Parity};
use beadwork_learn::fusion::samples::{Batch, Batches, Split};
use beadwork_learn::fusion::train::training_step;
use beadwork_learn::fusion::{FusionNet, Precision, TrainingConfig, VarStore};
use serde_json::json;

use super::timing::median_seconds;
use crate::args::positive;
use crate::statistics::median;

/// Measure the speed of training, of loading examples and of forward passes, or compare a network
/// with PyTorch's.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork gen-data --preset chains --count 720 --out datasets/chains-few
  beadwork bench learn --data datasets/chains-few
  beadwork bench learn --parity fusion_weights.safetensors fusion_io.safetensors")]
pub(super) struct LearnArgs {
    /// Dataset whose examples are loaded.
    #[arg(long, value_name = "DIR", default_value = "datasets/chains")]
    data: PathBuf,
    /// Width of the network, f: channels of its first level.
    #[arg(long, value_name = "N", default_value_t = 32)]
    width: i64,
    /// Examples in a batch.
    #[arg(long, value_name = "N", default_value_t = 64)]
    batch: usize,
    /// Number of training steps, of which the median time is reported, after two that do not count.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = positive::<u64>())]
    steps: u64,
    /// Instead of measuring, print the largest difference between the outputs of a network here and
    /// in PyTorch.
    /// WEIGHTS contains its weights, IO its inputs and PyTorch's outputs, both as safetensors.
    #[arg(long, value_names = ["WEIGHTS", "IO"], num_args = 2)]
    parity: Option<Vec<PathBuf>>,
    /// Print one JSON document instead of a list.
    #[arg(long)]
    json: bool,
}

/// Maximum difference of outputs that the order of summation in single precision can cause.
const TOLERANCE: f64 = 1e-4;

/// Cells of the canvas on which training is measured.
const CANVAS_CELLS: usize = 32 * 32;

/// Steps before the measured ones, in which libtorch allocates memory and chooses kernels.
const WARMUP_STEPS: usize = 2;

/// Runs all measurements, or the comparison, and prints the figures.
pub(super) fn run(args: &LearnArgs) -> anyhow::Result<()> {
    if let Some([weights, io]) = args.parity.as_deref() {
        return compare(weights, io, args.json);
    }
    memory::keep_freed();
    let control = &control::cancellable(Threads::One)?;
    let dataset = Dataset::open(&args.data)?;
    let config =
        TrainingConfig { width: args.width, batch: args.batch, ..TrainingConfig::default() };
    config.check()?;
    let (batch, loading) = load(&dataset, &config, control)?;
    let batch = &batch.context("dataset: no full batch on a canvas of 32 x 32 cells")?;
    let mut rates = Vec::new();
    for precision in [Precision::Single, Precision::Half] {
        let config = TrainingConfig { precision, ..config.clone() };
        let seconds = step_seconds(&config, batch, args.steps as usize, control)?;
        rates.push((precision, batch.inputs.len() as f64 / seconds));
    }
    let forward = forward_milliseconds(&config, batch)?;
    let memory = machine::peak_memory_bytes().map(|bytes| bytes as f64 / 1e9);
    if args.json {
        let rate = |precision| rates.iter().find(|rate| rate.0 == precision).map(|rate| rate.1);
        return output::json(&json!({
            "width": args.width,
            "batch": batch.inputs.len(),
            "train_examples_per_second": {
                "single": rate(Precision::Single), "half": rate(Precision::Half),
            },
            "load_examples_per_second": loading,
            "forward_milliseconds": forward,
            "peak_memory_gb": memory,
            "machine": machine::facts(),
        }));
    }
    let mut lines = vec![machine::line()];
    for (precision, rate) in rates {
        lines.push(format!(
            "training, {precision:?}: {rate:.0} examples/s at f = {}, 32 x 32 cells",
            args.width
        ));
    }
    lines.push(format!("loading: {loading:.0} examples/s"));
    lines.push(format!("forward pass: {forward:.2} ms per example of a batch"));
    lines.extend(memory.map(|memory| format!("peak memory: {memory:.2} GB")));
    output::text(&(lines.join("\n") + "\n"))
}

/// Loads examples for ten seconds, or until there are no more.
///
/// Returns the first full batch on a canvas of [`CANVAS_CELLS`], if there is one, and the examples
/// loaded per second, where examples on other canvases count in proportion to their cells.
fn load(
    dataset: &Dataset,
    config: &TrainingConfig,
    control: &Control<'_>,
) -> anyhow::Result<(Option<Batch>, f64)> {
    let settings = config.samples();
    let begin = Instant::now();
    let (mut full, mut cells) = (None, 0);
    for batch in Batches::new(dataset, Split::Train, &settings, 0) {
        control.check()?;
        let batch = batch?;
        let canvas = batch.inputs.canvas();
        cells += canvas.cells() * batch.inputs.len();
        if canvas.cells() == CANVAS_CELLS && batch.inputs.len() == settings.batch {
            full.get_or_insert(batch);
        }
        if begin.elapsed().as_secs_f64() > 10.0 {
            break;
        }
    }
    Ok((full, cells as f64 / CANVAS_CELLS as f64 / begin.elapsed().as_secs_f64()))
}

/// Median time of a training step of a new network on one batch, on the processor, in seconds.
fn step_seconds(
    config: &TrainingConfig,
    batch: &Batch,
    steps: usize,
    control: &Control<'_>,
) -> anyhow::Result<f64> {
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), config.network());
    let mut optimiser = AdamW::new(variables.trainable_variables(), adamw::Settings::default());
    let mut seconds = Vec::new();
    let bar = progress::bar((WARMUP_STEPS + steps) as u64, "training steps");
    for _ in 0..WARMUP_STEPS + steps {
        control.check()?;
        let begin = Instant::now();
        let rate = config.learning_rate;
        training_step(&network, &mut optimiser, batch, config, rate, Device::Cpu);
        seconds.push(begin.elapsed().as_secs_f64());
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(median(seconds.split_off(WARMUP_STEPS)))
}

/// Median time of a forward pass divided by the examples of the batch, in milliseconds.
fn forward_milliseconds(config: &TrainingConfig, batch: &Batch) -> anyhow::Result<f64> {
    let variables = VarStore::new(Device::Cpu);
    let network = FusionNet::new(&variables.root(), config.network());
    let (image, history) = batch.inputs.tensors(Device::Cpu);
    let seconds = median_seconds(5, |_| {
        network.infer(&image, &history, Precision::Single);
        Ok(())
    })?;
    Ok(1e3 * seconds / batch.inputs.len() as f64)
}

/// Prints the differences between the outputs here and PyTorch's.
///
/// # Errors
/// If one is above [`TOLERANCE`].
fn compare(weights: &Path, io: &Path, as_json: bool) -> anyhow::Result<()> {
    let Parity { config, position, action } = parity::compare(weights, io)?;
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
            "f = {}, {} hidden units, history of {} moves: largest difference {position:.2e} in \
             positions, {action:.2e} in actions\n",
            config.width, config.hidden, config.history
        ))?;
    }
    let difference = position.max(action);
    ensure!(
        difference <= TOLERANCE,
        "largest difference is {difference:.2e}: expected at most {TOLERANCE:e}"
    );
    Ok(())
}
