//! `zones`: finds a path with few zone crossings for one layer.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use beadwork_base::{Control, Progress, Threads};
use beadwork_console::learned::{self, Fusion};
use beadwork_console::output::usage_error;
use beadwork_console::search::{Breeding, Choice, MethodName, Row, Search};
use beadwork_console::{control, output, progress};
use beadwork_dataset::StartChoice;
use beadwork_grid::{Cell, Path, cover};
use beadwork_part::{Panel, svg};
use beadwork_search::bound::Bounds;
use beadwork_search::exact::{self, Observers, Stage};
use beadwork_search::{CostMatrix, anneal, genetic};
use serde_json::json;

use crate::generations;
use crate::instance::{Instance, InstanceArgs};
use crate::path_file;
use crate::terminals::{TerminalName, read_costs};

/// Find a path with few zone crossings for one layer.
///
/// A zone is the part of a layer that consists of one material; a crossing is a step of the path
/// from one zone to another, which costs a tool change.
/// Flags whose help begins with the name of a method apply to that method only.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork zones --layout voronoi --size 50x50 --seed 3 --svg layer.svg
  beadwork zones --layout voronoi --size 100x100 --zones 12 --start-at left --end-at 99,50
  beadwork zones --layout islands --size 60x60 --shape disc --costs purge.csv
  beadwork zones --layout voronoi --size 50x50 --seed 3 --method anneal
  beadwork zones --layout islands --size 100x100 --preset fast --svg islands.svg
  beadwork zones --layout islands --size 50x50 --method genetic --plot generations.svg
  beadwork zones --layout voronoi --size 30x30 --seed 3 --method fusion --svg learned.svg
  beadwork zones --image logo.png --preset fast --svg logo.svg --path logo.csv")]
pub(crate) struct Args {
    #[command(flatten)]
    instance: InstanceArgs,
    /// Seed of the layout and of the search.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Search method; exact by default, or anneal if --preset names one of its presets.
    #[arg(long, value_name = "METHOD")]
    method: Option<MethodName>,
    /// Exact: time limit in seconds, after which the best path so far is returned.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    /// Exact: maximum number of attempts at each component of the region; 50 by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    attempts: Option<u32>,
    /// Exact: where the path starts: a cell X,Y, left, top, right, bottom or any.
    #[arg(long, value_name = "WHERE", default_value = "any")]
    start_at: TerminalName,
    /// Exact: where the path ends: a cell X,Y, left, top, right, bottom or any.
    #[arg(long, value_name = "WHERE", default_value = "any")]
    end_at: TerminalName,
    /// Exact: file with the costs of crossings as a matrix: the row is the zone before the
    /// crossing, the column the zone after it.
    #[arg(long, value_name = "FILE")]
    costs: Option<PathBuf>,
    /// Anneal: paper (default), short, medium, long, extra_long or fast.
    /// Genetic: paper (default), two_point, window, short or fast.
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Fusion: folder of the trained network; models/fusion-small by default.
    #[arg(long, value_name = "DIR")]
    model: Option<PathBuf>,
    /// Fusion: number of crossings at which the walk stops; the proven bound by default.
    #[arg(long, value_name = "N")]
    target: Option<u32>,
    /// Fusion: maximum number of moves; 1000 by default.
    #[arg(long, value_name = "N")]
    budget: Option<usize>,
    /// Start path: row_zigzag, column_zigzag, spiral, cover (few pieces, for any region), or auto
    /// (the row zigzag where one exists, otherwise the cover).
    #[arg(long, value_name = "START", default_value = "auto")]
    start: StartChoice,
    /// Write the path as CSV: piece, x and y of each cell, in order.
    /// The JSON document always contains it.
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,
    /// Draw the layer with the start path and with the best path, as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Genetic: threads; 0 for one per core.
    /// The result does not depend on them.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Genetic: draw the crossings and the diversity of each generation, as SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Exact: draw the stages of the first attempt at each component, as SVG.
    #[arg(long, value_name = "FILE")]
    stages: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

impl Args {
    /// Refuses flags that the method would ignore.
    fn check(&self, method: MethodName) {
        let exact = [
            ("--time", self.time.is_some()),
            ("--attempts", self.attempts.is_some()),
            ("--start-at", self.start_at != TerminalName::Any),
            ("--end-at", self.end_at != TerminalName::Any),
            ("--costs", self.costs.is_some()),
            ("--stages", self.stages.is_some()),
        ];
        let genetic = [("--threads", self.threads.is_some()), ("--plot", self.plot.is_some())];
        let fusion = [
            ("--model", self.model.is_some()),
            ("--target", self.target.is_some()),
            ("--budget", self.budget.is_some()),
        ];
        let given = |flags: &[(&'static str, bool)]| {
            flags.iter().find(|(_, given)| *given).map(|(flag, _)| *flag)
        };
        if let Some(flag) = given(&exact).filter(|_| method != MethodName::Exact) {
            usage_error(&format!("{flag} is for --method exact"));
        }
        if let Some(flag) = given(&genetic).filter(|_| method != MethodName::Genetic) {
            usage_error(&format!("{flag} is for --method genetic"));
        }
        if let Some(flag) = given(&fusion).filter(|_| method != MethodName::Fusion) {
            usage_error(&format!("{flag} is for --method fusion"));
        }
        if self.preset.is_some() && !matches!(method, MethodName::Anneal | MethodName::Genetic) {
            usage_error("--preset is for --method anneal and --method genetic");
        }
        // Reports an unknown preset before any work.
        match method {
            MethodName::Anneal => drop(self.preset(anneal::Preset::Paper)),
            MethodName::Genetic => drop(self.preset(genetic::Preset::Paper)),
            MethodName::Zigzag | MethodName::Exact | MethodName::Fusion => (),
        }
    }

    /// The preset that `--preset` names, or `default` if the flag is not given.
    fn preset<P: FromStr<Err: Display>>(&self, default: P) -> P {
        let Some(name) = &self.preset else { return default };
        name.parse().unwrap_or_else(|error: P::Err| {
            let bred = self.method.is_none() && name.parse::<genetic::Preset>().is_ok();
            let hint = if bred { "; with --method genetic it is a preset" } else { "" };
            usage_error(&format!("{error}{hint}"))
        })
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let default = if args.preset.is_some() { MethodName::Anneal } else { MethodName::Exact };
    let method = args.method.unwrap_or(default);
    args.check(method);
    let instance = args.instance.load(args.seed)?;
    let Instance { region, zones, .. } = &instance;
    let (chosen, start) = args.start.path(region, || cover(region, &Control::default()))?;
    let costs = args.costs.as_ref().map(read_costs).transpose()?;
    let begin = Instant::now();
    let time_is_up = || args.time.is_some_and(|time| begin.elapsed() >= time);
    let bar = progress::bar(0, "zones");
    let report = |progress: Progress| {
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
    };
    let drawn: Mutex<BTreeMap<Stage, BTreeSet<[Cell; 2]>>> = Mutex::default();
    let stages = |stage: Stage, links: &[[Cell; 2]]| {
        drawn.lock().expect("no observer panics").entry(stage).or_default().extend(links);
    };
    let (pool, model);
    let mut threads = Threads::One;
    let choice = match method {
        MethodName::Zigzag => Choice::Zigzag,
        MethodName::Anneal => Choice::Anneal(args.preset(anneal::Preset::Paper)),
        MethodName::Genetic => {
            let preset = args.preset(genetic::Preset::Paper);
            pool = control::pool(args.threads.unwrap_or(0))?;
            threads = Threads::Pool(&pool);
            Choice::Genetic(Breeding { preset, population: None })
        }
        MethodName::Exact => {
            let attempts = args.attempts.unwrap_or(exact::Settings::default().attempts);
            Choice::Exact(exact::Settings {
                attempts,
                costs: costs.as_ref(),
                start: args.start_at.terminal(region)?,
                end: args.end_at.terminal(region)?,
                observers: Observers {
                    stage: args.stages.is_some().then_some(&stages),
                    ..Observers::default()
                },
                ..exact::Settings::default()
            })
        }
        MethodName::Fusion => {
            let folder = args.model.as_deref().unwrap_or("models/fusion-small".as_ref());
            model = learned::open(folder, region)?;
            let (target, budget) = (args.target.unwrap_or(0), args.budget.unwrap_or(1000));
            Choice::Fusion(Fusion { model: &model, target, budget })
        }
    };
    let bounds = if method == MethodName::Exact {
        None
    } else {
        Some(control::quiet(Threads::One, |control| Bounds::new(region, zones, control))??)
    };
    let search = Search { region, zones, choice, seed: args.seed, start: chosen, bounds };
    let control = Control {
        threads,
        time_is_up: Some(&time_is_up),
        progress: Some(&report),
        ..Control::default()
    };
    let (best, row) = search.run(&instance.name, &start, &control)?;
    bar.finish_and_clear();
    if let Some(file) = &args.svg {
        let drawing = draw(&instance, &row, &start, &best);
        output::file(file, &drawing)?;
    }
    if let Some(file) = &args.path {
        output::file(file, path_file::csv(region, &best))?;
    }
    if let (Some(file), Some(genetic)) = (&args.plot, &row.genetic) {
        output::file(file, &generations::chart(&row, genetic)?)?;
    }
    if let Some(file) = &args.stages {
        output::file(
            file,
            draw_stages(&instance, &drawn.into_inner().expect("no observer panics"), &row, &best),
        )?;
    }
    if args.json {
        output::json_with(&json!(row), "path", &path_file::json(region, &best))
    } else {
        output::text(&describe(&row, costs.as_ref()))
    }
}

/// The result on one line.
fn describe(row: &Row, costs: Option<&CostMatrix>) -> String {
    let Row { layout, width, height, zones, initial, crossings, seconds, .. } = row;
    let pieces = match row.pieces {
        1 => String::new(),
        pieces if pieces == row.piece_bound => format!(" in {pieces} pieces (proven minimum)"),
        pieces => format!(" in {pieces} pieces (at least {})", row.piece_bound),
    };
    let bound = row.bound.unwrap_or_default();
    let quality = match &row.exact {
        _ if row.is_proven() && costs.is_none() => ", proven minimum".to_owned(),
        Some(exact) if exact.optimal => {
            format!(" at a cost of {}, proven minimum", exact.cost)
        }
        Some(exact) if costs.is_some() => format!(" at a cost of {}, at least {bound}", exact.cost),
        _ => format!(", at least {bound}"),
    };
    let work = match (&row.exact, &row.genetic, &row.fusion) {
        (Some(exact), ..) => format!("{} attempts", exact.attempts),
        (_, Some(genetic), _) => format!(
            "{} by the best annealing run, {} moves after {} generations",
            genetic.seeded,
            row.moves,
            genetic.history.len() - 1
        ),
        (.., Some(fusion)) => format!("{} moves of {} made", row.moves, fusion.made),
        _ => format!("{} moves", row.moves),
    };
    format!(
        "{layout} {width}x{height}, {zones} zones: {initial} -> {crossings} crossings{pieces}\
         {quality}; {work} in {seconds:.3} s\n"
    )
}

/// Draws the stages of an attempt side by side, and the path.
fn draw_stages(
    instance: &Instance,
    stages: &BTreeMap<Stage, BTreeSet<[Cell; 2]>>,
    row: &Row,
    best: &Path,
) -> String {
    let Instance { region, zones, colours, .. } = instance;
    let crossings =
        |links: &[[Cell; 2]]| links.iter().filter(|[a, b]| zones.id(*a) != zones.id(*b)).count();
    let title = |stage: Stage, links: &[[Cell; 2]]| {
        let what = match stage {
            Stage::Ladders => "1. ladders inside the zones",
            Stage::Cheapest => "2. cheapest 2-matching",
            Stage::Linked => "3. all components connected",
            Stage::Merged => "4. cycles joined by switches",
            Stage::Settled => "5. the last cycles joined",
        };
        format!("{what}: {} crossings", crossings(links))
    };
    // A stage that was repeated, because a component needs more pieces than expected, is drawn
    // once.
    let stages: BTreeMap<Stage, Vec<[Cell; 2]>> =
        stages.iter().map(|(&stage, links)| (stage, links.iter().copied().collect())).collect();
    let titles: Vec<String> = stages.iter().map(|(&stage, links)| title(stage, links)).collect();
    let last = format!(
        "the path: {} crossings, at least {}",
        row.crossings,
        row.bound.unwrap_or_default()
    );
    let panel = |title, path, links| Panel { title, region, zones, path, links };
    let mut panels: Vec<Panel<'_>> =
        stages.values().zip(&titles).map(|(links, title)| panel(title, None, links)).collect();
    panels.push(panel(&last, Some(best), &[]));
    svg(&panels, colours.as_deref())
}

fn draw(instance: &Instance, row: &Row, start: &Path, best: &Path) -> String {
    let Instance { region, zones, colours, .. } = instance;
    let titles = [
        format!("{}: {} crossings", row.start, row.initial),
        format!(
            "{}{}: {} crossings{}",
            row.method,
            row.preset.as_ref().map_or_else(String::new, |preset| format!(" {preset}")),
            row.crossings,
            if row.is_proven() { ", optimal" } else { "" }
        ),
    ];
    let paths = [start, best];
    let panels = [0, 1].map(|i| Panel {
        title: &titles[i],
        region,
        zones,
        path: Some(paths[i]),
        links: &[],
    });
    let shown = if row.method == MethodName::Zigzag.name() { &panels[..1] } else { &panels[..] };
    svg(shown, colours.as_deref())
}
