//! `train ppo`: trains a policy that chooses the order of each layer of a part.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, ensure};
use beadwork_base::{Control, Threads};
use beadwork_console::part::PartArgs;
use beadwork_console::printer::PrinterArgs;
use beadwork_console::{cancel, control, machine, output, progress};
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_learn::Device;
use beadwork_learn::ppo::{
    End, Environment, Event, HeatEnvironment, HeatSettings, HeatTask, Kept, Policy, Run,
    TrainingConfig, last_checkpoint, train,
};
use beadwork_part::Order;
use beadwork_part::slice::Voxels;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use clap::ValueEnum;
use serde_json::json;

use super::ppo_log::Log;

/// Train a policy that chooses the order of each layer of a part, for even temperatures.
///
/// Proximal policy optimisation, as in Kim et al. 2026: a step prints a layer, and its reward is
/// minus the standard deviation of all temperatures at the layer's end, relative to the
/// conventional order's.
/// Writes to a folder: the policies (config.toml, space.toml, best.safetensors of the highest mean
/// return of 100 episodes, greedy.safetensors of the best evaluation, last.safetensors), the state
/// of the run (last.checkpoint), episodes.csv, updates.csv and evaluations.csv, and events for
/// TensorBoard.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork train ppo example:rectangular --preset small --out runs/rectangular
  beadwork train ppo example:rectangular --preset small --out runs/rectangular --resume
  beadwork train ppo example:u-shape --preset small --orders all --max-time 1.02 --out runs/u")]
pub(crate) struct Args {
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    printer: PrinterArgs,
    #[command(flatten)]
    source: Source,
    /// Orders that the policy chooses from: patterns (the 38), lines (interleaved, scattered,
    /// golden and bit-reversed orders of whole lines) or all.
    #[arg(long, value_name = "SET", default_value = "patterns")]
    orders: OrderSet,
    /// What is minimised: reward (the paper's), no_travel, time_averaged or peak.
    #[arg(long, value_name = "NAME", default_value = "reward")]
    objective: Objective,
    /// Limit on the printing time as a ratio to that of the conventional order, at the end of each
    /// layer; none by default, and then the policy may gain by waiting.
    #[arg(long, value_name = "RATIO")]
    max_time: Option<f64>,
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = "runs/ppo")]
    out: PathBuf,
    /// Resume the run in the folder.
    #[arg(long)]
    resume: bool,
    /// Number of steps, each of a layer; overrides the configuration.
    #[arg(long, value_name = "N")]
    steps: Option<u64>,
    /// Seed; overrides the configuration.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Threads on which layers are simulated; 0 for one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document at the end.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Source {
    /// Built-in configuration: small (minutes), paper (each voxel is observed, a large network,
    /// 500,000 steps; days).
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
    /// Configuration file.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Preset {
    Small,
    Paper,
}

impl Source {
    fn read(&self) -> anyhow::Result<TrainingConfig> {
        let Some(path) = &self.config else {
            return Ok(match self.preset {
                Some(Preset::Paper) => TrainingConfig::paper(),
                _ => TrainingConfig::small(),
            });
        };
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read '{}'", path.display()))?;
        TrainingConfig::from_toml(&text)
            .with_context(|| format!("'{}' is not a training configuration", path.display()))
    }
}

/// Refuses a folder in which files would be overwritten.
fn check_folder(out: &Path, resume: bool) -> anyhow::Result<()> {
    if last_checkpoint(out).exists() {
        ensure!(
            resume,
            "'{}' contains a run: continue it with --resume, or choose another folder",
            out.display()
        );
        return Ok(());
    }
    let kept = [Kept::Training, Kept::Evaluation, Kept::Last];
    let policies = kept.map(|kept| Policy::weights_file(out, kept));
    for file in [Policy::config_file(out)].into_iter().chain(policies) {
        ensure!(
            !file.exists(),
            "'{}' would be overwritten, and there is no checkpoint to resume from: choose another \
             folder",
            file.display()
        );
    }
    Ok(())
}

/// The task of printing a part in one of the given orders in each layer.
fn task(
    part: Voxels,
    orders: &[Order],
    objective: Objective,
    settings: &HeatSettings,
) -> anyhow::Result<Arc<HeatTask>> {
    let cells = |layer| {
        let region = part.region(layer)?;
        Ok(orders.iter().map(|order| order.order(&region)).collect())
    };
    let cells = (0..part.depth).map(cells).collect::<anyhow::Result<Vec<_>>>()?;
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let cost = LayerCost::of(objective)?;
    let unprinted = Solver::new(Arc::new(part), &material, &process, Method::default(), cost)?;
    Ok(Arc::new(HeatTask::new(unprinted, cells, settings)?))
}

/// A plan of all layers.
struct Plan {
    /// Index of each layer's order.
    actions: Vec<usize>,
    /// Gain over the conventional plan, K.
    gain: f64,
    /// Printing time, s.
    seconds: f64,
}

/// The plan of a policy that always chooses the most likely order.
fn plan(policy: &Policy, task: &Arc<HeatTask>) -> Plan {
    let mut environment = HeatEnvironment::new(task.clone());
    let mut observation = environment.reset(0);
    let (mut actions, mut gain) = (Vec::new(), 0.0);
    loop {
        let action = policy.act(&observation);
        let step = environment.step(action);
        actions.push(action);
        gain += step.reward;
        if step.end.is_some() {
            let seconds = environment.seconds();
            return Plan { actions, gain, seconds };
        }
        observation = step.observation;
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let mut config = args.source.read()?;
    config.steps = args.steps.unwrap_or(config.steps);
    config.seed = args.seed.unwrap_or(config.seed);
    config.check()?;
    let pool = control::pool(args.threads)?;
    let bed_mm = args.printer.load()?.printer.bed_mm;
    let (name, part) = args.part.load(bed_mm, &pool)?.printed_voxels()?;
    let orders = args.orders.orders();
    let observed = match args.source.preset {
        Some(Preset::Paper) => HeatSettings::paper(),
        _ => HeatSettings::default(),
    };
    let settings = HeatSettings { max_time_ratio: args.max_time, ..observed };
    // The conventional order is in each set.
    let baseline = orders.iter().position(|&order| order == Order::CONVENTIONAL);
    let settings = HeatSettings { baseline: baseline.unwrap_or(0), ..settings };
    let task = task(part, &orders, args.objective, &settings)?;
    check_folder(&args.out, args.resume)?;
    fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot create '{}'", args.out.display()))?;

    let begin = Instant::now();
    let conventional = task.baseline_reward();
    let percent = |gain: f64| -100.0 * gain / conventional;
    let mut log = Log::open(&args.out, args.resume)?;
    let bar = progress::bar(config.updates() * config.steps_per_update() as u64, "steps");
    let cancel = cancel::token()?;
    let mut failed = None;
    let (mut steps, mut episodes) = (0, 0);
    let mut observer = |event: &Event| {
        match event {
            Event::Started { steps: made, episodes: of } => {
                (steps, episodes) = (*made, *of);
                bar.set_position(*made);
                bar.reset_eta();
            }
            Event::Updated(update) => {
                (steps, episodes) = (update.steps, update.episodes);
                if let Some(mean) = update.mean_return {
                    bar.set_prefix(format!("mean gain {:.2} %, steps", percent(mean)));
                }
                bar.set_position(update.steps);
            }
            Event::Evaluated { steps, evaluation, best, .. } => bar.suspend(|| {
                eprintln!(
                    "beadwork: step {steps}: gain {:.2} %{}",
                    percent(evaluation.mean()),
                    if *best { ", the best so far" } else { "" },
                );
            }),
            _ => {}
        }
        if let Err(error) = log.write(event) {
            failed.get_or_insert(error);
            // Results of a run without logs cannot be judged, so stop early.
            cancel.cancel();
        }
    };
    let run = Run { device: Device::Cpu, out: &args.out, observer: &mut observer };
    let control = Control { cancel: Some(cancel), ..Control::on(Threads::Pool(&pool)) };
    let end = train(&|| HeatEnvironment::new(task.clone()), &config, run, &control);
    bar.finish_and_clear();
    if let Some(error) = failed {
        return Err(error.context(format!("cannot log to '{}'", args.out.display())));
    }
    let end = end?;
    let done = Done { name, end, steps, episodes, seconds: begin.elapsed().as_secs_f64() };
    report(args, &task, &orders, &done)
}

/// What a run did.
struct Done {
    /// Name of the part.
    name: String,
    end: End,
    steps: u64,
    episodes: u64,
    seconds: f64,
}

/// Reports a run, and the plan of its best policy.
fn report(args: &Args, task: &Arc<HeatTask>, orders: &[Order], done: &Done) -> anyhow::Result<()> {
    let Done { name, end, steps, episodes, seconds } = done;
    let conventional = task.baseline_reward();
    let percent = |gain: f64| -100.0 * gain / conventional;
    let file = Policy::weights_file(&args.out, Kept::Evaluation);
    let plan = file
        .exists()
        .then(|| anyhow::Ok(plan(&Policy::open(&args.out, Kept::Evaluation, Device::Cpu)?, task)))
        .transpose()?;
    let names = |plan: &Plan| -> Vec<String> {
        plan.actions.iter().map(|&action| orders[action].to_string()).collect()
    };
    if args.json {
        return output::json(&json!({
            "network": "ppo",
            "part": name,
            "end": format!("{end:?}").to_lowercase(),
            "steps": steps,
            "episodes": episodes,
            "conventional_reward": conventional,
            "conventional_print_seconds": task.baseline_seconds(),
            "plan": plan.as_ref().map(|plan| json!({
                "reward": conventional + plan.gain,
                "gain_percent": percent(plan.gain),
                "print_seconds": plan.seconds,
                "orders": names(plan),
            })),
            "seconds": seconds,
            "machine": machine::facts(),
        }));
    }
    let how = match end {
        End::Done => "all steps are made",
        End::Cancelled | End::TimeUp => "stopped; --resume continues",
    };
    let found = plan.map_or("no policy was evaluated yet".into(), |plan| {
        format!(
            "best policy: reward {:.3}, {:+.2} % over the conventional order's {conventional:.3}; \
             printing time {:+.2} %\norders: {}",
            conventional + plan.gain,
            percent(plan.gain),
            100.0 * (plan.seconds / task.baseline_seconds() - 1.0),
            names(&plan).join(" "),
        )
    });
    output::text(&format!("{name}: {how}; {episodes} episodes in {seconds:.0} s\n{found}\n"))
}
