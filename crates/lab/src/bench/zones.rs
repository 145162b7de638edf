//! `bench zones`: the genetic algorithm and the replays under it.

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use anyhow::bail;
use beadwork_base::{Control, Threads};
use beadwork_console::progress::ProgressBar;
use beadwork_console::{cancel, control, machine, output, progress};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Links, Path, PlacedVariant, Region, Start};
use beadwork_search::genetic::{self, Settings};
use beadwork_search::{Cost, Move, Stop};
use serde::Serialize;
use serde_json::json;

use super::{median, middle};

/// The genetic algorithm, with one thread and with two, and replays of moves, on 30x30 and 100x100
/// cells.
#[derive(clap::Args)]
pub(super) struct ZonesArgs {
    /// Times each figure is measured; the median is shown.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

const PRESETS: [genetic::Preset; 2] = [genetic::Preset::Paper, genetic::Preset::Window];
const THREADS: [usize; 2] = [1, 2];

/// Figures of one layer.
#[derive(Serialize)]
struct Row {
    layout: String,
    size: String,
    /// Moves of the population, replayed on links with their changes of the crossings, in millions
    /// a second.
    links_m_per_s: f64,
    /// The same on paths.
    path_m_per_s: f64,
    /// By preset.
    runs: Vec<Run>,
}

/// A whole run of a preset.
#[derive(Serialize)]
struct Run {
    preset: String,
    /// Annealing runs of the first population, by one thread and by two.
    seeding_seconds: [f64; 2],
    /// Generations, by one thread and by two.
    evolving_seconds: [f64; 2],
    /// Genes of the children.
    genes: u64,
    /// Of them, those that were known from a parent.
    spared: u64,
    /// Genes tried, without blanks.
    replayed: u64,
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    const SIDES: [u32; 2] = [30, 100];

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
    let mut text = format!(
        "Machine: {}. Population 200, 500 generations, seed 0, median of {} runs.\n\n",
        machine::line(),
        args.repeats
    );
    text += "| layer | replay on links, M/s | on paths, M/s | preset | seeding, s: 1 thread, 2 | evolving, s: 1 thread, 2 | genes, M | spared | replayed, M |\n";
    text += "|---|---|---|---|---|---|---|---|---|\n";
    for row in &rows {
        for run in &row.runs {
            writeln!(
                text,
                "| {} {} | {:.1} | {:.2} | {} | {:.2}, {:.2} | {:.2}, {:.2} | {:.1} | {:.0} % | {:.1} |",
                row.layout,
                row.size,
                row.links_m_per_s,
                row.path_m_per_s,
                run.preset,
                run.seeding_seconds[0],
                run.seeding_seconds[1],
                run.evolving_seconds[0],
                run.evolving_seconds[1],
                run.genes as f64 / 1e6,
                100.0 * run.spared as f64 / run.genes as f64,
                run.replayed as f64 / 1e6
            )?;
        }
    }
    output::text(&text)
}

fn row(side: u32, layout: Layout, repeats: u64, bar: &ProgressBar) -> anyhow::Result<Row> {
    let region = Region::rectangle(side, side)?;
    let zones = LayoutSpec::new(layout).zones(&region, 0)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, &Control::default())?;
    let mut runs = Vec::new();
    let mut lists: Vec<Vec<PlacedVariant>> = Vec::new();
    for preset in PRESETS {
        let (mut seeding, mut evolving) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
        let (mut genes, mut spared, mut replayed) = (0, 0, 0);
        for _ in 0..repeats {
            for (place, threads) in THREADS.into_iter().enumerate() {
                let pool = control::pool(threads)?;
                let control =
                    Control { cancel: Some(cancel::token()?), ..Control::on(Threads::Pool(&pool)) };
                let settings = Settings::preset(preset, 0);
                let begin = Instant::now();
                let population = genetic::annealed(&start, &crossings, &settings, &control);
                seeding[place].push(begin.elapsed().as_secs_f64());
                let begin = Instant::now();
                let outcome = genetic::evolve(&start, &crossings, &population, &settings, &control);
                evolving[place].push(begin.elapsed().as_secs_f64());
                if outcome.stop == Stop::Cancelled {
                    bail!("stopped");
                }
                let children = settings.evolution.population
                    - (settings.evolution.carry_over * settings.evolution.population as f64)
                        as usize;
                genes = ((outcome.generations.len() - 1) * children * outcome.length) as u64;
                (spared, replayed) = (outcome.spared, outcome.replayed);
                let variants = |list: &Vec<Move>| {
                    let placed = list.iter().map(|step| match step {
                        Move::Variant(placed) => Some(*placed),
                        Move::Pair(_) => None,
                    });
                    placed
                        .collect::<Option<Vec<PlacedVariant>>>()
                        .expect("the paper's annealers use variants")
                };
                bar.inc(1);
                lists = population.iter().map(variants).collect();
            }
        }
        runs.push(Run {
            preset: preset.name().to_owned(),
            seeding_seconds: seeding.map(middle),
            evolving_seconds: evolving.map(middle),
            genes,
            spared,
            replayed,
        });
    }
    let (links, change) = (Links::new(&start), |placed: PlacedVariant| {
        Cost::change(&crossings, placed.switches(side))
    });
    Ok(Row {
        layout: layout.name().to_owned(),
        size: format!("{side}x{side}"),
        links_m_per_s: replays(
            &lists,
            &links,
            Links::copy_from,
            Links::apply_variant,
            change,
            repeats,
        ),
        path_m_per_s: replays(
            &lists,
            &start,
            Path::copy_from,
            Path::apply_variant,
            change,
            repeats,
        ),
        runs,
    })
}

/// Millions of moves a second, each list replayed from the start, with the changes of those that
/// apply.
fn replays<S: Clone>(
    lists: &[Vec<PlacedVariant>],
    start: &S,
    copy: fn(&mut S, &S),
    apply: impl Fn(&mut S, PlacedVariant) -> bool,
    change: impl Fn(PlacedVariant) -> i64,
    repeats: u64,
) -> f64 {
    let mut state = start.clone();
    let seconds = median(repeats, |_| {
        let mut sum = 0;
        for list in lists {
            copy(&mut state, start);
            let applied = list.iter().filter(|&&placed| apply(&mut state, placed));
            sum += applied.map(|&placed| change(placed)).sum::<i64>();
        }
        black_box(sum);
    });
    lists.iter().map(Vec::len).sum::<usize>() as f64 / 1e6 / seconds
}
