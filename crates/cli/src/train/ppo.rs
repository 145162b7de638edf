//! `train ppo`: trains a policy that chooses the order of each layer of a part, or of any part.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, ensure};
use beadwork_base::{Control, Threads};
use beadwork_console::part::PartArgs;
use beadwork_console::printer::PrinterArgs;
use beadwork_console::{cancel, control, machine, output, progress};
use beadwork_dataset::random_part;
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_learn::Device;
use beadwork_learn::ppo::{
    End, Environment, Event, HeatEnvironment, HeatSettings, HeatTask, Kept, Policy, PolicyTask,
    RandomHeatEnvironment, RandomHeatTask, Run, TrainingConfig, last_checkpoint, train,
};
use beadwork_part::Order;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use clap::ValueEnum;
use rayon::ThreadPool;
use serde_json::json;

use super::ppo_log::Log;

/// Prefix of the name of a preset of random parts.
const RANDOM: &str = "random:";

/// Train a policy that chooses the order of each layer of a part, for even temperatures.
///
/// Proximal policy optimisation, as in Kim et al. 2026: a step prints a layer, and its reward is
/// minus the standard deviation of all temperatures at the layer's end, relative to the
/// conventional order's.
/// The part random:policy stands for random parts of 15 to 32 layers, another one in every episode:
/// the policy then acts on any part, with plan --objective heat --planner ppo.
/// Writes to a folder: the policies (config.toml, space.toml, best.safetensors of the highest mean
/// return of 100 episodes, greedy.safetensors of the best evaluation, last.safetensors), the state
/// of the run (last.checkpoint), episodes.csv, updates.csv and evaluations.csv, and events for
/// TensorBoard.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork train ppo example:rectangular --preset small --out runs/rectangular
  beadwork train ppo example:rectangular --preset small --out runs/rectangular --resume
  beadwork train ppo example:u-shape --preset estimated --orders all --max-time 1.02 --out runs/u
  beadwork train ppo random:policy --preset general --max-time 1.05 --out runs/general")]
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
    /// For random parts it is the largest limit: half of the episodes have a random one from 1 to
    /// RATIO, the others have none.
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
    /// Built-in configuration: small (minutes), estimated (minutes; candidates are described by
    /// estimates of what they cost), general (for random parts, an hour), paper (each voxel is
    /// observed, a large network, 500,000 steps; days).
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
    /// Configuration file.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Preset {
    Small,
    Estimated,
    General,
    Paper,
}

impl Source {
    fn read(&self) -> anyhow::Result<TrainingConfig> {
        let Some(path) = &self.config else {
            return Ok(match self.preset {
                Some(Preset::Paper) => TrainingConfig::paper(),
                Some(Preset::General) => TrainingConfig::general(),
                Some(Preset::Estimated) => TrainingConfig::estimated(),
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

/// The preset of random parts that the part names; `None` if it is a part.
fn random_parts(part: &PartArgs) -> anyhow::Result<Option<random_part::Preset>> {
    let name = part.only().and_then(Path::to_str).and_then(|name| name.strip_prefix(RANDOM));
    Ok(name.map(str::parse).transpose()?)
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
    let orders = args.orders.orders();
    // The conventional order is in each set.
    let baseline = orders.iter().position(|&order| order == Order::CONVENTIONAL).unwrap_or(0);
    let cost = LayerCost::of(args.objective)?;
    let random = random_parts(&args.part)?;
    let observed = match (random, args.source.preset) {
        (Some(_), _) => HeatSettings::general(),
        (None, Some(Preset::Paper)) => HeatSettings::paper(),
        (None, Some(Preset::Estimated)) => HeatSettings::estimated(),
        (None, _) => HeatSettings::default(),
    };
    let settings = HeatSettings { baseline, max_time_ratio: args.max_time, ..observed };
    let Some(preset) = random else {
        let bed_mm = args.printer.load()?.printer.bed_mm;
        let (name, part) = args.part.load(bed_mm, &pool)?.printed_voxels()?;
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let method = Method::default();
        let unprinted = Solver::new(Arc::new(part), &material, &process, method, cost)?;
        let task = Arc::new(HeatTask::named(unprinted, &orders, &settings)?);
        create_folder(args)?;
        let make = || HeatEnvironment::new(task.clone());
        let conventional = task.baseline_reward();
        let done = train_in(args, &config, &make, &|gain| -100.0 * gain / conventional, &pool)?;
        return report(args, &name, &task, &orders, &done);
    };
    let parts = random_part::Settings::preset(preset);
    let task = RandomHeatTask { parts, ..RandomHeatTask::new(orders, cost, settings) };
    let environment = RandomHeatEnvironment::new(Arc::new(task))?;
    create_folder(args)?;
    let task = PolicyTask {
        orders: args.orders,
        objective: args.objective,
        depth: settings.depth,
        window: settings.window.context("no window")?,
    };
    output::file(&PolicyTask::file(&args.out), task.to_toml())?;
    // Returns are in percent already.
    let done = train_in(args, &config, &|| environment.clone(), &|gain| gain, &pool)?;
    report_random(args, preset, config.evaluation_episodes, &done)
}

/// Creates the folder to write to.
fn create_folder(args: &Args) -> anyhow::Result<()> {
    check_folder(&args.out, args.resume)?;
    fs::create_dir_all(&args.out).with_context(|| format!("cannot create '{}'", args.out.display()))
}

/// Trains in an environment; `percent` converts a return to a gain over the conventional order.
fn train_in<E: Environment>(
    args: &Args,
    config: &TrainingConfig,
    make: &dyn Fn() -> E,
    percent: &dyn Fn(f64) -> f64,
    pool: &ThreadPool,
) -> anyhow::Result<Done> {
    let begin = Instant::now();
    let mut log = Log::open(&args.out, args.resume)?;
    let bar = progress::bar(config.updates() * config.steps_per_update() as u64, "steps");
    let cancel = cancel::token()?;
    let mut failed = None;
    let (mut steps, mut episodes, mut best_gain) = (0, 0, None);
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
                let gain = percent(evaluation.mean());
                if *best {
                    best_gain = Some(gain);
                }
                eprintln!(
                    "beadwork: step {steps}: gain {gain:.2} %{}",
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
    let control = Control { cancel: Some(cancel), ..Control::on(Threads::Pool(pool)) };
    let end = train(make, config, run, &control);
    bar.finish_and_clear();
    if let Some(error) = failed {
        return Err(error.context(format!("cannot log to '{}'", args.out.display())));
    }
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Done { end: end?, steps, episodes, best_gain, seconds })
}

/// What a run did.
struct Done {
    end: End,
    steps: u64,
    episodes: u64,
    /// Mean gain of the best evaluation, in percent; `None` if no policy was kept since the run was
    /// started or resumed.
    best_gain: Option<f64>,
    seconds: f64,
}

impl Done {
    /// Why the run ended, in words.
    fn how(&self) -> &'static str {
        match self.end {
            End::Done => "all steps are made",
            End::Cancelled | End::TimeUp => "stopped; --resume continues",
        }
    }
}

/// Reports a run on random parts.
fn report_random(
    args: &Args,
    preset: random_part::Preset,
    evaluated: usize,
    done: &Done,
) -> anyhow::Result<()> {
    let Done { end, steps, episodes, best_gain, seconds } = done;
    if args.json {
        return output::json(&json!({
            "network": "ppo",
            "part": format!("{RANDOM}{preset}"),
            "end": format!("{end:?}").to_lowercase(),
            "steps": steps,
            "episodes": episodes,
            "evaluated_parts": evaluated,
            "gain_percent": best_gain,
            "seconds": seconds,
            "machine": machine::facts(),
        }));
    }
    let found = best_gain.map_or("no better policy was found".into(), |gain| {
        format!("best policy: gain {gain:.2} % over the conventional order on {evaluated} parts")
    });
    let how = done.how();
    output::text(&format!(
        "{RANDOM}{preset}: {how}; {episodes} episodes in {seconds:.0} s\n{found}\n\
         use it: beadwork plan PART --objective heat --planner ppo --policy {}\n",
        args.out.display(),
    ))
}

/// Reports a run on one part, and the plan of its best policy.
fn report(
    args: &Args,
    name: &str,
    task: &Arc<HeatTask>,
    orders: &[Order],
    done: &Done,
) -> anyhow::Result<()> {
    let Done { end, steps, episodes, seconds, .. } = done;
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
    let how = done.how();
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
