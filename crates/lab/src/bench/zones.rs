//! `bench zones`: speed of the genetic algorithm, and of the replays of moves that it makes.

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::progress::ProgressBar;
use beadwork_console::{control, machine, output, progress};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Links, Path, PlacedVariant, Region, Start};
use beadwork_search::genetic::{self, Preset, Settings};
use beadwork_search::{Cost, Move};
use serde::Serialize;
use serde_json::json;

use super::timing::median_seconds;
use crate::args::positive;
use crate::statistics::median;

/// Measure the speed of the genetic algorithm on one thread and on two, and of replays of moves, on
/// 30x30 and 100x100 cells.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench zones
  beadwork bench zones --repeats 1 --json > zones.json")]
pub(super) struct ZonesArgs {
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = positive::<u64>())]
    repeats: u64,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

/// Sides of the square grids, in cells.
const SIDES: [u32; 2] = [30, 100];
const PRESETS: [Preset; 2] = [Preset::Paper, Preset::Window];
/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];

/// Figures of one layer.
#[derive(Serialize)]
struct Row {
    layout: String,
    size: String,
    /// Rate at which the moves of a population, and the changes of the crossings that they cause,
    /// are replayed on [`Links`], in millions per second.
    links_m_per_s: f64,
    /// The same on a [`Path`].
    path_m_per_s: f64,
    /// For each preset.
    runs: Vec<Run>,
}

/// Runs of one preset.
#[derive(Serialize)]
struct Run {
    preset: String,
    /// Time of the annealing runs of the first population, for each number of threads.
    seeding_seconds: [f64; 2],
    /// Time of the generations, for each number of threads.
    evolving_seconds: [f64; 2],
    /// Genes of all children.
    genes: u64,
    /// Genes whose replay a snapshot of a parent saved.
    spared: u64,
    /// Genes replayed, without blanks.
    replayed: u64,
}

/// Runs all measurements, and prints their table.
pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let cells = SIDES.into_iter().flat_map(|side| Layout::PAPER.map(|layout| (side, layout)));
    let runs = SIDES.len() * Layout::PAPER.len() * PRESETS.len() * THREADS.len();
    let bar = progress::bar(runs as u64 * args.repeats, "bench zones");
    let rows = cells.map(|(side, layout)| row(side, layout, args.repeats, &bar));
    let rows = rows.collect::<anyhow::Result<Vec<Row>>>()?;
    bar.finish_and_clear();
    if args.json {
        let machine = machine::facts();
        return output::json(&json!({ "machine": machine, "repeats": args.repeats, "rows": rows }));
    }
    output::text(&table(&rows, args.repeats)?)
}

fn table(rows: &[Row], repeats: u64) -> Result<String, std::fmt::Error> {
    let mut text = format!(
        "Machine: {}. Population 200, 500 generations, seed 0, median of {repeats} runs.\n\n\
         | layer | replay on links, M/s | on paths, M/s | preset | annealing runs, s: 1 thread, 2 \
         | generations, s: 1 thread, 2 | genes of children, M | not replayed | replayed, M |\n\
         |---|---|---|---|---|---|---|---|---|\n",
        machine::line()
    );
    for row in rows {
        for run in &row.runs {
            let ([seeding_1, seeding_2], [evolving_1, evolving_2]) =
                (run.seeding_seconds, run.evolving_seconds);
            writeln!(
                text,
                "| {} {} | {:.1} | {:.2} | {} | {seeding_1:.2}, {seeding_2:.2} \
                 | {evolving_1:.2}, {evolving_2:.2} | {:.1} | {:.0} % | {:.1} |",
                row.layout,
                row.size,
                row.links_m_per_s,
                row.path_m_per_s,
                run.preset,
                run.genes as f64 / 1e6,
                100.0 * run.spared as f64 / run.genes as f64,
                run.replayed as f64 / 1e6
            )?;
        }
    }
    Ok(text)
}

fn row(side: u32, layout: Layout, repeats: u64, bar: &ProgressBar) -> anyhow::Result<Row> {
    let control = &control::cancellable(Threads::One)?;
    let region = Region::rectangle(side, side)?;
    let zones = LayoutSpec::new(layout).zones(&region, 0)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, control)?;
    let mut runs = Vec::new();
    let mut population = Vec::new();
    for preset in PRESETS {
        let run;
        (run, population) = self::runs(preset, &start, &crossings, repeats, bar)?;
        runs.push(run);
    }
    let lists: Vec<Vec<PlacedVariant>> = population.iter().map(|list| variants(list)).collect();
    let links = Links::new(&start);
    let change = |placed: PlacedVariant| Cost::change(&crossings, placed.switches(side));
    let links_m_per_s =
        replays(&lists, &links, Links::copy_from, Links::apply_variant, change, repeats)?;
    let path_m_per_s =
        replays(&lists, &start, Path::copy_from, Path::apply_variant, change, repeats)?;
    control.check()?;
    Ok(Row {
        layout: layout.name().to_owned(),
        size: format!("{side}x{side}"),
        links_m_per_s,
        path_m_per_s,
        runs,
    })
}

/// Runs a preset `repeats` times on each number of threads; returns the figures and the first
/// population, which is the same in all runs.
fn runs(
    preset: Preset,
    start: &Path,
    crossings: &Crossings,
    repeats: u64,
    bar: &ProgressBar,
) -> anyhow::Result<(Run, Vec<Vec<Move>>)> {
    let settings = Settings::preset(preset, 0);
    let (mut seeding, mut evolving) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    let (mut genes, mut spared, mut replayed) = (0, 0, 0);
    let mut population = Vec::new();
    for _ in 0..repeats {
        for (number, threads) in THREADS.into_iter().enumerate() {
            let pool = control::pool(threads)?;
            let control = &control::cancellable(Threads::Pool(&pool))?;
            let begin = Instant::now();
            population = genetic::annealed(start, crossings, &settings, control);
            seeding[number].push(begin.elapsed().as_secs_f64());
            let begin = Instant::now();
            let outcome = genetic::evolve(start, crossings, &population, &settings, control);
            evolving[number].push(begin.elapsed().as_secs_f64());
            control.check()?;
            let size = settings.evolution.population;
            let children = size - (settings.evolution.carry_over * size as f64) as usize;
            genes = ((outcome.generations.len() - 1) * children * outcome.length) as u64;
            (spared, replayed) = (outcome.spared, outcome.replayed);
            bar.inc(1);
        }
    }
    let run = Run {
        preset: preset.name().to_owned(),
        seeding_seconds: seeding.map(median),
        evolving_seconds: evolving.map(median),
        genes,
        spared,
        replayed,
    };
    Ok((run, population))
}

/// The moves of an individual, all of which are variants.
fn variants(moves: &[Move]) -> Vec<PlacedVariant> {
    let placed = moves.iter().map(|step| match step {
        Move::Variant(placed) => Some(*placed),
        Move::Pair(_) => None,
    });
    placed.collect::<Option<_>>().expect("annealing by the paper's presets uses variants only")
}

/// Millions of moves per second: each list is replayed from the start, and the changes of the
/// crossings by the moves that apply are summed up.
fn replays<S: Clone>(
    lists: &[Vec<PlacedVariant>],
    start: &S,
    copy: fn(&mut S, &S),
    apply: impl Fn(&mut S, PlacedVariant) -> bool,
    change: impl Fn(PlacedVariant) -> i64,
    repeats: u64,
) -> anyhow::Result<f64> {
    let mut state = start.clone();
    let seconds = median_seconds(repeats, |_| {
        let mut sum = 0;
        for list in lists {
            copy(&mut state, start);
            let applied = list.iter().filter(|&&placed| apply(&mut state, placed));
            sum += applied.map(|&placed| change(placed)).sum::<i64>();
        }
        black_box(sum);
        Ok(())
    })?;
    Ok(lists.iter().map(Vec::len).sum::<usize>() as f64 / 1e6 / seconds)
}
