//! `zones`: a path of few crossings for one layer.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use beadwork_dataset::{StartChoice, write_whole};
use beadwork_grid::{Cell, Crossings, Path, Region, Start, Zones, cover};
use beadwork_part::{Panel, svg};
use beadwork_search::bound::{self, Bounds};
use beadwork_search::exact::{self, Progress, Stage};
use beadwork_search::{Preset, Settings, Stop, ZoneCosts, anneal};
use serde::Serialize;
use serde_json::json;

use crate::ends::{Place, read_costs};
use crate::instance::{Instance, InstanceArgs};
use crate::{cancel, output, progress};

/// Find a path of few zone crossings for one layer.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork zones --layout voronoi --size 50x50 --seed 3 --svg layer.svg
  beadwork zones --layout voronoi --size 100x100 --zones 12 --start-at left --end-at 99,50
  beadwork zones --layout islands --size 60x60 --shape disc --costs purge.csv
  beadwork zones --layout voronoi --size 50x50 --seed 3 --method anneal
  beadwork zones --layout islands --size 100x100 --preset fast --svg islands.svg
  beadwork zones --image logo.png --preset fast --svg logo.svg --json")]
pub(crate) struct Args {
    #[command(flatten)]
    instance: InstanceArgs,
    /// Seed of the layout and of the search.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How to choose the path; exact if not given, or anneal if a preset of it is.
    #[arg(long, value_name = "METHOD")]
    method: Option<MethodName>,
    /// Exact: seconds after which it gives the best it has.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    /// Exact: most attempts at each connected part of the region.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    attempts: u32,
    /// Exact: where the path begins: X,Y, left, top, right, bottom or any.
    #[arg(long, value_name = "PLACE", default_value = "any")]
    start_at: Place,
    /// Exact: where the path ends: X,Y, left, top, right, bottom or any.
    #[arg(long, value_name = "PLACE", default_value = "any")]
    end_at: Place,
    /// Exact: a file with what crossings cost: a row for each zone, a whole number for each zone to step to.
    #[arg(long, value_name = "FILE")]
    costs: Option<PathBuf>,
    /// Annealing preset: paper (if not given), short, medium, long, extra_long or fast.
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
    /// Path to start from: row_zigzag, column_zigzag, spiral, cover, or auto (the row zigzag where there is one, else the cover).
    #[arg(long, value_name = "START", default_value = "auto")]
    start: StartChoice,
    /// Draw the layer before and after.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Exact: draw the steps of its first attempt.
    #[arg(long, value_name = "FILE")]
    stages: Option<PathBuf>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// The methods of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum MethodName {
    /// The start itself.
    Zigzag,
    /// Simulated annealing from the start.
    Anneal,
    /// The fewest pieces, then the fewest crossings, with a proof where one is found.
    Exact,
}

impl MethodName {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Zigzag => "zigzag",
            Self::Anneal => "anneal",
            Self::Exact => "exact",
        }
    }
}

/// What `--json` prints for one layer.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) layout: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) zones: u32,
    pub(crate) seed: u64,
    pub(crate) method: String,
    pub(crate) preset: Option<String>,
    pub(crate) start: String,
    pub(crate) initial: u32,
    pub(crate) crossings: u32,
    /// Of the crossings, or of what they cost if they don't all cost 1.
    pub(crate) bound: Option<u64>,
    pub(crate) pieces: u32,
    pub(crate) piece_bound: u32,
    pub(crate) moves: u64,
    pub(crate) seconds: f64,
    /// What only the exact search has.
    #[serde(flatten)]
    pub(crate) exact: Option<ExactRow>,
}

/// What the exact search tells beside the common row.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ExactRow {
    /// What the crossings cost: their number, unless costs were given.
    pub(crate) cost: u64,
    pub(crate) optimal: bool,
    pub(crate) attempts: u32,
    pub(crate) stop: String,
}

/// Seconds as typed.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// How the path is chosen, with what the method needs to know.
#[derive(Clone, Copy)]
pub(crate) enum Choice<'a> {
    /// The start itself.
    Zigzag,
    Anneal(Preset),
    Exact(exact::Settings<'a>),
}

impl Choice<'_> {
    fn method(&self) -> MethodName {
        match self {
            Self::Zigzag => MethodName::Zigzag,
            Self::Anneal(_) => MethodName::Anneal,
            Self::Exact(_) => MethodName::Exact,
        }
    }
}

/// What a search is asked to do with a layer.
pub(crate) struct Search<'a> {
    pub(crate) region: &'a Region,
    pub(crate) zones: &'a Zones,
    pub(crate) choice: Choice<'a>,
    pub(crate) seed: u64,
    pub(crate) start: Start,
    /// Lower bounds; `None` where only the pieces and the number of zone components shall bound the crossings.
    pub(crate) bounds: Option<Bounds>,
}

impl Search<'_> {
    /// Runs it from the path of its start; gives the best path and the row that tells of it.
    ///
    /// The exact search needs no start: it is there to compare with.
    pub(crate) fn run(&self, layout: &str, start: &Path) -> anyhow::Result<(Path, Row)> {
        let &Self { region, zones, choice, seed, bounds, .. } = self;
        let cancel = cancel::token()?;
        let crossings = Crossings::new(region, zones);
        let pieces = start.pieces();
        let lower = match bounds {
            Some(bounds) if bounds.pieces == pieces => bounds.crossings(),
            _ => bound::components(region, zones, pieces),
        };
        let (mut lower, mut piece_bound) = (u64::from(lower), bounds.map_or(1, |bounds| bounds.pieces));
        let mut exact = None;
        let begin = Instant::now();
        let (best, moves) = match choice {
            Choice::Zigzag => (start.clone(), 0),
            Choice::Anneal(preset) => {
                let settings = Settings {
                    bound: Some(lower as i64),
                    cancel: Some(cancel),
                    ..Settings::preset(preset, seed)
                };
                let outcome = anneal(start.clone(), &crossings, &settings);
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                (outcome.path, outcome.moves.len() as u64)
            }
            Choice::Exact(settings) => {
                let plan =
                    exact::solve(region, zones, &exact::Settings { seed, cancel: Some(cancel), ..settings })?;
                (lower, piece_bound) = (plan.bound, plan.piece_bound);
                let optimal = plan.is_optimal();
                let (cost, attempts) = (plan.cost, plan.attempts);
                let stop = format!("{:?}", plan.stop).to_lowercase();
                exact = Some(ExactRow { cost, optimal, attempts, stop });
                (plan.path, 0)
            }
        };
        let seconds = begin.elapsed().as_secs_f64();
        let row = Row {
            layout: layout.to_owned(),
            width: region.width(),
            height: region.height(),
            zones: zones.count(),
            seed,
            method: choice.method().name().to_owned(),
            preset: if let Choice::Anneal(preset) = choice { Some(preset.name().to_owned()) } else { None },
            start: self.start.name().to_owned(),
            initial: crossings.count(start),
            crossings: crossings.count(&best),
            bound: Some(lower),
            pieces: best.pieces(),
            piece_bound,
            moves,
            seconds,
            exact,
        };
        Ok((best, row))
    }
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let instance = args.instance.load(args.seed)?;
    let Instance { region, zones, .. } = &instance;
    let (chosen, start) = args.start.path(region, || cover(region))?;
    let costs = args.costs.as_ref().map(read_costs).transpose()?;
    let usual = if args.preset.is_some() { MethodName::Anneal } else { MethodName::Exact };
    let method = args.method.unwrap_or(usual);
    if args.preset.is_some() && method != MethodName::Anneal {
        bail!("--preset is for --method anneal");
    }
    if method != MethodName::Exact
        && (costs.is_some() || [args.start_at, args.end_at].iter().any(|&place| place != Place::Any))
    {
        bail!("--start-at, --end-at and --costs are for --method exact");
    }
    let begin = Instant::now();
    let time_is_up = || args.time.is_some_and(|time| begin.elapsed() >= time);
    let bar = progress::bar(u64::from(args.attempts), "attempts");
    let observer = |progress: Progress| {
        bar.set_position(u64::from(progress.attempts));
    };
    let drawn: Mutex<BTreeMap<Stage, BTreeSet<[Cell; 2]>>> = Mutex::default();
    let stages = |stage: Stage, links: &[[Cell; 2]]| {
        drawn.lock().expect("no drawing panics").entry(stage).or_default().extend(links);
    };
    let choice = match method {
        MethodName::Zigzag => Choice::Zigzag,
        MethodName::Anneal => Choice::Anneal(args.preset.unwrap_or(Preset::Paper)),
        MethodName::Exact => Choice::Exact(exact::Settings {
            attempts: args.attempts,
            costs: costs.as_ref(),
            start: args.start_at.terminal(region)?,
            end: args.end_at.terminal(region)?,
            time_is_up: Some(&time_is_up),
            observer: Some(&observer),
            stages: args.stages.is_some().then_some(&stages),
            ..exact::Settings::default()
        }),
    };
    let bounds = (method != MethodName::Exact).then(|| Bounds::new(region, zones));
    let search = Search { region, zones, choice, seed: args.seed, start: chosen, bounds };
    let (best, row) = search.run(&instance.name, &start)?;
    bar.finish_and_clear();
    if let Some(file) = &args.svg {
        let drawing = draw(&instance, &row, &start, &best);
        write_drawing(file, &drawing)?;
    }
    if let Some(file) = &args.stages {
        write_drawing(
            file,
            &draw_stages(&instance, &drawn.into_inner().expect("no drawing panics"), &row, &best),
        )?;
    }
    if args.json { output::json(&json!(row)) } else { output::text(&describe(&row, costs.as_ref())) }
}

/// One line for people.
fn describe(row: &Row, costs: Option<&ZoneCosts>) -> String {
    let Row { layout, width, height, zones, initial, crossings, seconds, .. } = row;
    let pieces = match row.pieces {
        1 => String::new(),
        pieces if pieces == row.piece_bound => format!(" in {pieces} pieces, the fewest possible"),
        pieces => format!(" in {pieces} pieces (at least {})", row.piece_bound),
    };
    let bound = row.bound.unwrap_or_default();
    let quality = match &row.exact {
        Some(exact) if exact.optimal && costs.is_none() => ", proven to be the fewest".to_owned(),
        Some(exact) if exact.optimal => format!(" at a cost of {}, proven to be the least", exact.cost),
        Some(exact) if costs.is_some() => format!(" at a cost of {}, at least {bound}", exact.cost),
        _ => format!(", at least {bound}"),
    };
    let work = row
        .exact
        .as_ref()
        .map_or_else(|| format!("{} moves", row.moves), |exact| format!("{} attempts", exact.attempts));
    format!(
        "{layout} {width}x{height}, {zones} zones: {initial} -> {crossings} crossings{pieces}{quality}; {work} in {seconds:.3} s\n"
    )
}

fn write_drawing(file: &FilePath, drawing: &str) -> anyhow::Result<()> {
    // A terminal or a pipe must be written to, not replaced.
    if fs::metadata(file).is_ok_and(|metadata| !metadata.is_file()) {
        return fs::write(file, drawing).with_context(|| format!("cannot write '{}'", file.display()));
    }
    Ok(write_whole(file, |out| out.write_all(drawing.as_bytes()))?)
}

/// The steps of an attempt, side by side, and the path.
fn draw_stages(
    instance: &Instance,
    stages: &BTreeMap<Stage, BTreeSet<[Cell; 2]>>,
    row: &Row,
    best: &Path,
) -> String {
    let Instance { region, zones, colours, .. } = instance;
    let crossings = |links: &[[Cell; 2]]| links.iter().filter(|[a, b]| zones.id(*a) != zones.id(*b)).count();
    let title = |stage: Stage, links: &[[Cell; 2]]| {
        let what = match stage {
            Stage::Ladders => "1. ladders inside the zones",
            Stage::Cheapest => "2. cheapest 2-matching",
            Stage::Linked => "3. nothing left apart",
            Stage::Merged => "4. cycles joined by switches",
            Stage::Settled => "5. the last cycles joined",
        };
        format!("{what}: {} crossings", crossings(links))
    };
    // A step made anew, for a part that takes more pieces than thought, is drawn once.
    let stages: BTreeMap<Stage, Vec<[Cell; 2]>> =
        stages.iter().map(|(&stage, links)| (stage, links.iter().copied().collect())).collect();
    let titles: Vec<String> = stages.iter().map(|(&stage, links)| title(stage, links)).collect();
    let last = format!("the path: {} crossings, at least {}", row.crossings, row.bound.unwrap_or_default());
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
            "{}: {} crossings{}",
            row.preset.as_ref().unwrap_or(&row.method),
            row.crossings,
            if row.exact.as_ref().is_some_and(|exact| exact.optimal) { ", optimal" } else { "" }
        ),
    ];
    let paths = [start, best];
    let panels = [0, 1].map(|i| Panel { title: &titles[i], region, zones, path: Some(paths[i]), links: &[] });
    let shown = if row.method == MethodName::Zigzag.name() { &panels[..1] } else { &panels[..] };
    svg(shown, colours.as_deref())
}
