//! `bench grid`: speed of annealing and of the moves that it makes.

use std::fmt::Write;
use std::hint::black_box;

use beadwork_base::Threads;
use beadwork_console::{control, machine, output, progress};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Path, Region, Start, Switch, VariantKind};
use beadwork_search::anneal::{self, Preset, Settings};
use serde::Serialize;
use serde_json::json;

use super::timing::median_seconds;
use crate::args::positive;

/// Measure the speed of annealing and of its moves, on one thread and 30x30 to 500x500 cells.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork bench grid
  beadwork bench grid --repeats 9 --json > grid.json")]
pub(super) struct GridArgs {
    /// Runs of each measurement, of which the median is reported.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = positive::<u64>())]
    repeats: u64,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

/// Figures of one size.
#[derive(Serialize)]
struct Row {
    size: String,
    /// Time of the preset `paper`, 5000 iterations, in milliseconds.
    paper_ms: f64,
    /// Proposals of the preset `fast`, in millions per second.
    proposals_m_per_s: f64,
    /// Share of the proposals of `fast` that were accepted.
    accepted: f64,
    /// Crossings before `fast`.
    initial: i64,
    /// Crossings after `fast`.
    fast_crossings: i64,
    /// Pairs of switches checked for validity, in millions per second.
    pair_checks_m_per_s: f64,
    /// Windows of the grid checked for applicable variants, in millions per second.
    windows_m_per_s: f64,
}

/// Sides of the square grids, in cells.
const SIDES: [u32; 6] = [30, 50, 100, 200, 300, 500];

/// Runs all measurements, and prints their table.
pub(super) fn run(args: &GridArgs) -> anyhow::Result<()> {
    let bar = progress::bar(SIDES.len() as u64, "bench grid");
    let rows = SIDES.into_iter().map(|side| {
        let row = row(side, args.repeats);
        bar.inc(1);
        row
    });
    let rows = rows.collect::<anyhow::Result<Vec<_>>>()?;
    bar.finish_and_clear();
    if args.json {
        let machine = machine::facts();
        return output::json(
            &json!({ "machine": machine, "repeats": args.repeats, "threads": 1, "rows": rows }),
        );
    }
    output::text(&table(&rows, args.repeats)?)
}

fn table(rows: &[Row], repeats: u64) -> Result<String, std::fmt::Error> {
    let mut text = format!(
        "Machine: {}. One thread, Voronoi of 3 zones, median of {repeats} runs.\n\n\
         | size | preset paper, ms | fast, M proposals/s | accepted | crossings \
         | pair checks, M/s | windows, M/s |\n\
         |---|---|---|---|---|---|---|\n",
        machine::line()
    );
    for row in rows {
        writeln!(
            text,
            "| {} | {:.2} | {:.1} | {:.1} % | {} -> {} | {:.1} | {:.1} |",
            row.size,
            row.paper_ms,
            row.proposals_m_per_s,
            100.0 * row.accepted,
            row.initial,
            row.fast_crossings,
            row.pair_checks_m_per_s,
            row.windows_m_per_s
        )?;
    }
    Ok(text)
}

fn row(side: u32, repeats: u64) -> anyhow::Result<Row> {
    let control = &control::cancellable(Threads::One)?;
    let region = Region::rectangle(side, side)?;
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 0)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, control)?;
    let anneal = |preset, seed| {
        let outcome = anneal::solve(&start, &crossings, &Settings::preset(preset, seed), control);
        control.check()?;
        anyhow::Ok(outcome)
    };
    let paper = median_seconds(repeats, |seed| anneal(Preset::Paper, seed).map(drop))?;
    let fast = anneal(Preset::Fast, 0)?;
    let fast_seconds = median_seconds(repeats, |_| anneal(Preset::Fast, 0).map(drop))?;

    let pairs = shuffled_pairs(&fast.path, side);
    let checks = median_seconds(repeats, |_| {
        let valid =
            pairs.iter().filter(|[first, second]| fast.path.allows_pair(*first, *second)).count();
        assert!(black_box(valid) > 0, "some pairs are valid");
        Ok(())
    })?;
    let windows = median_seconds(repeats, |_| {
        let kinds = [VariantKind::Transpose, VariantKind::Flip];
        let mut found = 0;
        fast.path.for_each_variant(&kinds, |_| found += 1);
        black_box(found);
        Ok(())
    })?;
    Ok(Row {
        size: format!("{side}x{side}"),
        paper_ms: paper * 1e3,
        proposals_m_per_s: fast.proposals as f64 / fast_seconds / 1e6,
        accepted: fast.accepted as f64 / fast.proposals as f64,
        initial: fast.initial,
        fast_crossings: fast.cost,
        pair_checks_m_per_s: pairs.len() as f64 / checks / 1e6,
        windows_m_per_s: f64::from(side * side) / windows / 1e6,
    })
}

/// A million pairs of switches at random positions, the second one or two cells from the first.
///
/// Each switch removes two links of the path, so that validity depends on the positions of the
/// cells on the path, which is the slow case of the check.
fn shuffled_pairs(path: &Path, side: u32) -> Vec<[Switch; 2]> {
    let corners: Vec<u32> =
        (0..side * side).filter(|&corner| path.sides(corner).is_some()).collect();
    // Knuth's 64-bit linear congruential generator is random enough to visit memory out of order.
    let mut state = 1_u64;
    let mut random = |count: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % count
    };
    let steps = [side + 1, side - 1, 2, 2 * side];
    let mut pairs = Vec::new();
    while pairs.len() < 1_000_000 {
        let corner = corners[random(corners.len())];
        let other = corner + steps[random(steps.len())];
        if let (Some(from), Some(other_from)) = (path.sides(corner), path.sides(other)) {
            pairs.push([Switch::new(corner, from), Switch::new(other, other_from)]);
        }
    }
    pairs
}
