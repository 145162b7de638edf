//! `train fusion`: trains the network that proposes moves of a layer's path.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, ensure};
use beadwork_base::Control;
use beadwork_console::{cancel, machine, output, progress};
use beadwork_dataset::Dataset;
use beadwork_learn::fusion::TrainingConfig;
use beadwork_learn::fusion::model::Model;
use beadwork_learn::fusion::train::{End, Event, Run, last_checkpoint, train};
use serde_json::json;

use super::log::Log;

/// Train FusionNet, which proposes moves that lead to fewer crossings.
///
/// Reads a dataset of `gen-data` and writes to a folder: the model (config.toml, best.safetensors),
/// the state of the run (last.checkpoint), steps.csv and evaluations.csv, and events for
/// TensorBoard.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork gen-data --preset chains --out datasets/chains
  beadwork train fusion --preset small --data datasets/chains --out runs/fusion
  beadwork train fusion --preset small --data datasets/chains --out runs/fusion --resume
  tensorboard --logdir runs")]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// Folder of the dataset.
    #[arg(long, value_name = "DIR", default_value = "datasets/chains")]
    data: PathBuf,
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = "runs/fusion")]
    out: PathBuf,
    /// Resume the run in the folder.
    #[arg(long)]
    resume: bool,
    /// Number of steps; overrides the configuration.
    #[arg(long, value_name = "N")]
    steps: Option<u64>,
    /// Seed; overrides the configuration.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Device to train on: cpu, or cuda for the first graphics card.
    #[arg(long, value_name = "DEVICE", default_value = "cpu", value_parser = ["cpu", "cuda"])]
    device: String,
    /// Print one JSON document at the end.
    #[arg(long)]
    json: bool,
}

/// Names and texts of the built-in configurations.
const PRESETS: [(&str, &str); 3] = [
    ("smoke", include_str!("../../../../configs/train/fusion-smoke.toml")),
    ("small", include_str!("../../../../configs/train/fusion-small.toml")),
    ("paper", include_str!("../../../../configs/train/fusion-paper.toml")),
];

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Source {
    /// Built-in configuration: smoke (takes seconds), small (the committed weights; an hour), paper
    /// (f = 48; days).
    #[arg(long, value_name = "NAME", value_parser = PRESETS.map(|(name, _)| name))]
    preset: Option<String>,
    /// Configuration file; see configs/train.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

impl Source {
    fn read(&self) -> anyhow::Result<TrainingConfig> {
        if let Some(preset) = &self.preset {
            let (_, text) =
                PRESETS.iter().find(|(name, _)| name == preset).expect("clap checked the name");
            return Ok(
                TrainingConfig::from_toml(text).expect("tests parse the built-in configurations")
            );
        }
        let path = self.config.as_ref().expect("clap requires one of the two");
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read '{}'", path.display()))?;
        TrainingConfig::from_toml(&text)
            .with_context(|| format!("'{}' is not a training configuration", path.display()))
    }
}

/// Refuses a folder in which files would be overwritten.
fn check_folder(out: &Path, resume: bool) -> anyhow::Result<()> {
    let checkpoint = last_checkpoint(out);
    if checkpoint.exists() {
        ensure!(
            resume,
            "'{}' contains a run: continue it with --resume, or choose another folder",
            out.display()
        );
        return Ok(());
    }
    for file in [Model::config_file(out), Model::weights_file(out)] {
        ensure!(
            !file.exists(),
            "'{}' would be overwritten, and there is no checkpoint to resume from: choose another \
             folder",
            file.display()
        );
    }
    Ok(())
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let mut training = args.source.read()?;
    training.steps = args.steps.unwrap_or(training.steps);
    training.seed = args.seed.unwrap_or(training.seed);
    let device = beadwork_console::learned::device(&args.device)?;
    let dataset = Dataset::open(&args.data)?;
    check_folder(&args.out, args.resume)?;
    fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot create '{}'", args.out.display()))?;

    let begin = Instant::now();
    let mut log = Log::open(&args.out, args.resume)?;
    let bar = progress::bar(training.steps, "steps");
    let cancel = cancel::token()?;
    let mut failed = None;
    let (mut steps, mut examples) = (0, 0);
    let mut last_evaluation = None;
    let mut observer = |event: &Event| {
        match event {
            Event::Started { steps: made } => {
                steps = *made;
                bar.set_position(*made);
                bar.reset_eta();
            }
            Event::Step { step, examples: of_batch, loss, .. } => {
                steps = *step;
                examples += *of_batch as u64;
                let rate = examples as f64 / begin.elapsed().as_secs_f64();
                bar.set_prefix(format!("loss {loss:.3}, {rate:.0} examples/s, steps"));
                bar.set_position(*step);
            }
            Event::Evaluated { step, evaluation, best } => {
                let all = evaluation.all;
                let share = |hits: u64| 100.0 * hits as f64 / all.count.max(1) as f64;
                bar.suspend(|| {
                    eprintln!(
                        "beadwork: step {step}: loss {:.3}, position {:.1} % first, {:.1} % among \
                         five, action \
                         {:.1} %{}",
                        evaluation.loss,
                        share(all.top_1),
                        share(all.top_5),
                        share(all.action),
                        if *best { ", the best so far" } else { "" },
                    );
                });
                last_evaluation = Some(evaluation.clone());
            }
        }
        if let Err(error) = log.write(event) {
            failed.get_or_insert(error);
            // Results of a run without logs cannot be judged, so stop early.
            cancel.cancel();
        }
    };
    let run = Run { device, out: &args.out, observer: &mut observer };
    let control = Control { cancel: Some(cancel), ..Control::default() };
    let end = train(&dataset, &training, run, &control);
    bar.finish_and_clear();
    if let Some(error) = failed {
        return Err(error.context(format!("cannot log to '{}'", args.out.display())));
    }
    let end = end?;
    let seconds = begin.elapsed().as_secs_f64();
    let weights = Some(Model::weights_file(&args.out)).filter(|file| file.exists());
    if args.json {
        let evaluation = last_evaluation.map(|evaluation| {
            let all = evaluation.all;
            let hits = json!({
                "examples": all.count,
                "top_1": all.top_1,
                "top_5": all.top_5,
                "action": all.action,
            });
            json!({ "loss": evaluation.loss, "hits": hits })
        });
        return output::json(&json!({
            "network": "fusion",
            "end": format!("{end:?}").to_lowercase(),
            "steps": steps,
            "evaluation": evaluation,
            "examples": examples,
            "seconds": seconds,
            "weights": weights,
            "machine": machine::facts(),
        }));
    }
    let how = match end {
        End::Done => "all steps are made",
        End::Early => "stopped early, since evaluations no longer improve",
        End::Cancelled | End::TimeUp => "stopped; --resume continues",
    };
    let best = weights.map_or("none yet".into(), |file| file.display().to_string());
    output::text(&format!("{how}; {examples} examples in {seconds:.0} s; best weights: {best}\n"))
}
