//! `eval fusion`: what the network is worth, by the protocol of Aali et al., Table 2.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::ensure;
use beadwork_base::Control;
use beadwork_console::learned::check_size;
use beadwork_console::{machine, output, progress};
use beadwork_dataset::Dataset;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Path as Route, Region, Start, Zones};
use beadwork_learn::Device;
use beadwork_learn::fusion::baseline::Baseline;
use beadwork_learn::fusion::evaluate::{Evaluation, Hits, evaluate};
use beadwork_learn::fusion::layer::Layer;
use beadwork_learn::fusion::model::{Model, Origin};
use beadwork_learn::fusion::propose::{AllMoves, NetworkProposer, Proposer};
use beadwork_learn::fusion::samples::{Batches, Split};
use beadwork_learn::fusion::walk::{self, Outcome, Task};
use beadwork_search::anneal::{self, Preset, Settings};
use beadwork_search::{Stop, chains, exact};
use serde::Serialize;
use serde_json::json;

use super::statistics::mean;
use crate::paper;

/// How many moves and seconds FusionNet takes to the crossings that the paper's annealer reaches,
/// and what others take.
///
/// The target of an instance is the best of some runs of the annealer's preset `paper`; the
/// annealer's moves and seconds are those of the run that got there with the fewest moves.
/// Beside it stand the free annealer (`fast`), a walk that is the network's but for the network (of
/// all moves the one that gains most, else a random one), the search for chains that the network
/// learned from, and the exact search.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork eval fusion
  beadwork eval fusion --model runs/fusion --seeds 5 --sizes 30x30,50x50
  beadwork eval fusion --data datasets/chains --json > fusion.json")]
pub(super) struct FusionArgs {
    /// The model's folder.
    #[arg(long, value_name = "DIR", default_value = "models/fusion-small")]
    model: PathBuf,
    /// Seeds for each layout and size up to 60x60 and 30x100.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Seeds for each layout of 80x80 and 100x100.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    large_seeds: u64,
    /// Sizes, with commas; the paper's six if not given.
    #[arg(long, value_name = "WxH", value_delimiter = ',')]
    sizes: Vec<beadwork_dataset::Size>,
    /// The first layout seed.
    #[arg(long, value_name = "N", default_value_t = 0)]
    first_seed: u64,
    /// Runs of the annealer on each instance.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    runs: u64,
    /// Most moves of a walk.
    #[arg(long, value_name = "N", default_value_t = walk::Settings::default().budget)]
    budget: usize,
    /// Places that the network proposes.
    #[arg(long, value_name = "N", default_value_t = 32)]
    places: usize,
    /// Moves without a new best after which some are made at random.
    #[arg(long, value_name = "N", default_value_t = walk::Settings::default().patience)]
    patience: usize,
    /// The dataset it was trained on: also tell how often it meets the moves of those instances
    /// that were kept for the end.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Moves of each of their trajectories.
    #[arg(long, value_name = "N", default_value_t = 20, requires = "data")]
    per_trajectory: usize,
    /// Where the network computes.
    #[arg(long, value_name = "DEVICE", default_value = "cpu", value_parser = ["cpu", "cuda"])]
    device: String,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Layouts of the paper's Table 2.
const LAYOUTS: [Layout; 2] = [Layout::Voronoi, Layout::Islands];

/// Cells from which on instances are `--large-seeds` for a layout.
const LARGE_CELLS: u32 = 80 * 80;

/// An instance with its target.
struct Instance {
    layout: Layout,
    width: u32,
    height: u32,
    seed: u64,
    region: Region,
    zones: Zones,
    layer: Layer,
    start: Route,
    initial: u32,
    target: u32,
    annealer: Taken,
}

/// What a method took to the target.
#[derive(Clone, Copy, Debug, Serialize)]
struct Taken {
    reached: bool,
    moves: usize,
    seconds: f64,
    crossings: u32,
}

/// What all methods took on one instance.
#[derive(Debug, Serialize)]
struct Row {
    layout: &'static str,
    width: u32,
    height: u32,
    seed: u64,
    initial: u32,
    target: u32,
    methods: BTreeMap<&'static str, Taken>,
}

impl Instance {
    fn new(
        layout: Layout,
        (width, height): (u32, u32),
        seed: u64,
        runs: u64,
    ) -> anyhow::Result<Self> {
        let region = Region::rectangle(width, height)?;
        let zones = LayoutSpec::new(layout).zones(&region, seed)?;
        let start = Start::RowZigzag.path(&region, &Control::default())?;
        let crossings = Crossings::new(&region, &zones);
        let initial = crossings.count(&start);
        let mut best: Option<Taken> = None;
        for run in 0..runs {
            let begin = Instant::now();
            let outcome = anneal::solve(
                &start,
                &crossings,
                &Settings::preset(Preset::Paper, run),
                &Control::default(),
            );
            let seconds = begin.elapsed().as_secs_f64();
            let this = Taken {
                reached: true,
                moves: outcome.moves.len(),
                seconds,
                crossings: outcome.cost as u32,
            };
            if best.is_none_or(|best| (this.crossings, this.moves) < (best.crossings, best.moves)) {
                best = Some(this);
            }
        }
        let annealer = best.expect("there are runs");
        let layer = Layer::new(&region, &zones);
        let target = annealer.crossings;
        Ok(Self {
            layout,
            width,
            height,
            seed,
            region,
            zones,
            layer,
            start,
            initial,
            target,
            annealer,
        })
    }

    fn methods(&self) -> anyhow::Result<BTreeMap<&'static str, Taken>> {
        let crossings = self.layer.crossings();
        let target = Some(i64::from(self.target));
        let begin = Instant::now();
        let fast = anneal::solve(
            &self.start,
            crossings,
            &Settings { target, ..Settings::preset(Preset::Fast, 0) },
            &Control::default(),
        );
        let fast = self.took(fast.moves.len(), begin, fast.cost);
        let begin = Instant::now();
        let chains = chains::solve(
            &self.start,
            crossings,
            &chains::Settings { target, ..chains::Settings::default() },
            &Control::default(),
        );
        let chains = self.took(chains.moves.len(), begin, chains.cost);
        let begin = Instant::now();
        let plan = exact::solve(
            &self.region,
            &self.zones,
            &exact::Settings::default(),
            &Control::default(),
        )?;
        let exact = self.took(0, begin, i64::from(crossings.count(&plan.path)));
        Ok(BTreeMap::from([
            ("annealer", self.annealer),
            ("fast", fast),
            ("chains", chains),
            ("exact", exact),
        ]))
    }

    fn took(&self, moves: usize, begin: Instant, cost: i64) -> Taken {
        let reached = cost <= i64::from(self.target);
        Taken { reached, moves, seconds: begin.elapsed().as_secs_f64(), crossings: cost as u32 }
    }
}

pub(super) fn run(args: &FusionArgs) -> anyhow::Result<()> {
    let device = beadwork_console::learned::device(&args.device)?;
    let model = Model::open(&args.model, device)?;
    let paper_sizes = || paper::SIZES.iter().map(|size| (size.width, size.height)).collect();
    let sizes: Vec<(u32, u32)> = if args.sizes.is_empty() {
        paper_sizes()
    } else {
        args.sizes.iter().map(|size| (size.width, size.height)).collect()
    };
    for &size in &sizes {
        check_size(&model, size)?;
    }
    let data = args.data.as_deref().map(Dataset::open).transpose()?;
    if let Some(data) = data.as_ref().filter(|data| Origin::of(data) != model.origin) {
        eprintln!(
            "beadwork: {} trajectories of dataset {} are not those that the network learned from: it may have seen their instances",
            data.manifest().records,
            Origin::of(data).dataset
        );
    }
    let settings = walk::Settings {
        budget: args.budget,
        patience: args.patience,
        ..walk::Settings::default()
    };
    let bar = progress::bar((sizes.len() * LAYOUTS.len()) as u64, "layouts and sizes");
    let mut rows = Vec::new();
    for &size in &sizes {
        for layout in LAYOUTS {
            let count = if size.0 * size.1 >= LARGE_CELLS { args.large_seeds } else { args.seeds };
            let instances: Vec<_> = (args.first_seed..args.first_seed + count)
                .map(|seed| Instance::new(layout, size, seed, args.runs))
                .collect::<Result<_, _>>()?;
            let mut network = NetworkProposer {
                positions: args.places,
                ..NetworkProposer::new(&model.network, device)
            };
            let fusion = walk_all(&instances, &mut network, &settings);
            // To give up sooner costs it targets, and to go back to its best path gains it none.
            let for_greedy = walk::Settings { patience: 32, returns: false, ..settings };
            let greedy = walk_all(&instances, &mut AllMoves { seed: 0 }, &for_greedy);
            for ((instance, fusion), greedy) in instances.iter().zip(fusion).zip(greedy) {
                let mut methods = instance.methods()?;
                methods.insert("fusion", fusion);
                methods.insert("greedy", greedy);
                rows.push(Row {
                    layout: instance.layout.name(),
                    width: instance.width,
                    height: instance.height,
                    seed: instance.seed,
                    initial: instance.initial,
                    target: instance.target,
                    methods,
                });
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let held_out =
        data.map(|data| held_out(&data, args.per_trajectory, &model, device)).transpose()?;
    if args.json {
        let layouts = held_out.iter().flat_map(|held_out| &held_out.by_layout);
        let layouts =
            layouts.map(|(name, (hits, baseline))| (name.clone(), accuracy_row(hits, baseline)));
        return output::json(&json!({
            "held_out": layouts.collect::<serde_json::Map<_, _>>(),
            "model": args.model,
            "runs": args.runs,
            "budget": args.budget,
            "places": args.places,
            "patience": args.patience,
            "machine": machine::facts(),
            "rows": rows,
        }));
    }
    let mut text = tables(&rows)?;
    if let Some(held_out) = held_out {
        accuracy_table(&mut text, &held_out)?;
    }
    output::text(&text)
}

/// The network on examples that training never saw.
fn held_out(
    dataset: &Dataset,
    per_trajectory: usize,
    model: &Model,
    device: Device,
) -> anyhow::Result<Evaluation> {
    let settings = model.config.held_out(per_trajectory);
    let examples: Vec<_> =
        Batches::new(dataset, Split::Test, &settings, 0).collect::<Result<_, _>>()?;
    ensure!(!examples.is_empty(), "the dataset has no instances that are kept for the end");
    Ok(evaluate(&model.network, &examples, &model.config, device, &Control::default())?)
}

/// Shares in per cent: of the network, of chance and of greed.
fn accuracy_row(hits: &Hits, baseline: &Baseline) -> serde_json::Value {
    let count = hits.count.max(1) as f64;
    let of_hits = |hits: u64| 100.0 * hits as f64 / count;
    let percent = |sum: f64| 100.0 * sum / count;
    json!({
        "examples": hits.count,
        "top_1": of_hits(hits.top_1), "top_5": of_hits(hits.top_5), "action": of_hits(hits.action),
        "chance_1": percent(baseline.chance_top_1), "chance_5": percent(baseline.chance_top_5), "chance_action": percent(baseline.chance_action),
        "greedy_1": percent(baseline.greedy_top_1), "greedy_5": percent(baseline.greedy_top_5),
    })
}

fn accuracy_table(text: &mut String, held_out: &Evaluation) -> std::fmt::Result {
    let columns = [
        "top_1",
        "greedy_1",
        "chance_1",
        "top_5",
        "greedy_5",
        "chance_5",
        "action",
        "chance_action",
    ];
    writeln!(
        text,
        "\nMoves of instances kept for the end, met by the network, by greed and by chance, %:\n"
    )?;
    writeln!(text, "| layout | examples | {} |", columns.join(" | "))?;
    writeln!(text, "|---|---|{}", "---|".repeat(columns.len()))?;
    for (layout, (hits, baseline)) in &held_out.by_layout {
        let row = accuracy_row(hits, baseline);
        let shares: Vec<_> = columns
            .iter()
            .map(|name| format!("{:.1}", row[name].as_f64().unwrap_or(0.0)))
            .collect();
        writeln!(text, "| {layout} | {} | {} |", hits.count, shares.join(" | "))?;
    }
    Ok(())
}

/// Walks all instances together; the seconds are shared out among them by their moves.
fn walk_all(
    instances: &[Instance],
    proposer: &mut dyn Proposer,
    settings: &walk::Settings<'_>,
) -> Vec<Taken> {
    let mut tasks = Vec::with_capacity(instances.len());
    for Instance { layer, start, target, seed, .. } in instances {
        tasks.push(Task { layer, start, target: *target, seed: *seed });
    }
    let begin = Instant::now();
    let outcomes = walk::solve(&tasks, proposer, settings, &Control::default());
    let seconds = begin.elapsed().as_secs_f64();
    let all: usize = outcomes.iter().map(|outcome| outcome.total_moves).sum();
    let reached = |walked: Outcome| {
        let reached = walked.stop == Stop::TargetReached;
        let moves = walked.total_moves;
        let share = walked.total_moves as f64 / all.max(1) as f64;
        Taken { reached, moves, seconds: seconds * share, crossings: walked.crossings }
    };
    outcomes.into_iter().map(reached).collect()
}

/// A row for each layout and size: means over its instances.
fn tables(rows: &[Row]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(text, "{}\n", machine::line())?;
    let mut cells: Vec<(&str, u32, u32)> =
        rows.iter().map(|row| (row.layout, row.width, row.height)).collect();
    cells.dedup();
    cells.sort_by_key(|&(layout, ..)| std::cmp::Reverse(layout));
    writeln!(
        text,
        "Moves to the target; in brackets of how many instances it was reached, if not of all:\n"
    )?;
    writeln!(
        text,
        "| layout | size | instances | start | target | annealer | FusionNet | share | greedy | chains | fast | exact: crossings |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|---|---|---|---|")?;
    for &(layout, width, height) in &cells {
        let of = || {
            rows.iter().filter(|row| (row.layout, row.width, row.height) == (layout, width, height))
        };
        let count = of().count();
        let moves = |method: &str| mean(of().map(|row| row.methods[method].moves as f64));
        let told = |method: &str| {
            let reached = of().filter(|row| row.methods[method].reached).count();
            let missed = if reached < count { format!(" ({reached})") } else { String::new() };
            format!("{:.0}{missed}", moves(method))
        };
        // Where the annealer found nothing, nobody needs a move.
        let share = match moves("annealer") {
            0.0 => "-".into(),
            all => format!("{:.0} %", 100.0 * moves("fusion") / all),
        };
        writeln!(
            text,
            "| {layout} | {width}x{height} | {count} | {:.1} | {:.1} | {} | {} | {share} | {} | {} | {} | {:.1} |",
            mean(of().map(|row| f64::from(row.initial))),
            mean(of().map(|row| f64::from(row.target))),
            told("annealer"),
            told("fusion"),
            told("greedy"),
            told("chains"),
            told("fast"),
            mean(of().map(|row| f64::from(row.methods["exact"].crossings))),
        )?;
    }
    writeln!(text, "\nMilliseconds:\n")?;
    writeln!(text, "| layout | size | annealer | FusionNet | greedy | chains | fast | exact |")?;
    writeln!(text, "|---|---|---|---|---|---|---|---|")?;
    for &(layout, width, height) in &cells {
        let of = || {
            rows.iter().filter(|row| (row.layout, row.width, row.height) == (layout, width, height))
        };
        write!(text, "| {layout} | {width}x{height} |")?;
        for method in ["annealer", "fusion", "greedy", "chains", "fast", "exact"] {
            write!(text, " {:.1} |", 1e3 * mean(of().map(|row| row.methods[method].seconds)))?;
        }
        writeln!(text)?;
    }
    let reached = rows.iter().filter(|row| row.methods["fusion"].reached).count();
    writeln!(text, "\nFusionNet reached the target on {reached} of {} instances.", rows.len())?;
    Ok(text)
}
