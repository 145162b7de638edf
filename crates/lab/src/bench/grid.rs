//! `bench grid`: annealing and the moves under it.

use std::fmt::Write;
use std::hint::black_box;

use beadwork_base::Control;
use beadwork_console::{machine, output};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Path, Region, Start, Switch, VariantKind};
use beadwork_search::anneal::{self, Preset, Settings};
use serde::Serialize;
use serde_json::json;

use super::median;

/// Annealing and moves, one thread, from 30x30 to 500x500 cells.
#[derive(clap::Args)]
pub(super) struct GridArgs {
    /// Times each figure is measured; the median is shown.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..))]
    repeats: u64,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Figures of one size.
#[derive(Serialize)]
struct GridRow {
    size: String,
    /// Milliseconds of 5000 iterations of the preset `paper`.
    paper_ms: f64,
    /// Of `fast`, in millions a second.
    proposals_m_per_s: f64,
    /// Share of the proposals that were accepted.
    accepted: f64,
    /// Crossings before and after `fast`.
    initial: i64,
    fast_crossings: i64,
    /// Checks of pairs of switches, in millions a second.
    pair_checks_m_per_s: f64,
    /// Looks for variants that apply, over all windows, in millions of windows a second.
    windows_m_per_s: f64,
}

pub(super) fn run(args: &GridArgs) -> anyhow::Result<()> {
    let rows = [30, 50, 100, 200, 300, 500].map(|side| grid_row(side, args.repeats));
    let rows = rows.into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    if args.json {
        let machine = machine::facts();
        return output::json(
            &json!({ "machine": machine, "repeats": args.repeats, "threads": 1, "rows": rows }),
        );
    }
    let mut text = format!(
        "Machine: {}. One thread, Voronoi of 3 zones, median of {} runs.\n\n",
        machine::line(),
        args.repeats
    );
    text += "| size | preset paper, ms | fast, M proposals/s | accepted | crossings | pair checks, M/s | windows, M/s |\n";
    text += "|---|---|---|---|---|---|---|\n";
    for row in &rows {
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
    output::text(&text)
}

fn grid_row(side: u32, repeats: u64) -> anyhow::Result<GridRow> {
    let region = Region::rectangle(side, side)?;
    let zones = LayoutSpec::new(Layout::Voronoi).zones(&region, 0)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, &Control::default())?;
    let anneal =
        |settings: &Settings<'_>| anneal::solve(&start, &crossings, settings, &Control::default());
    let paper = median(repeats, |seed| {
        drop(anneal(&Settings::preset(Preset::Paper, seed)));
    });
    let fast = anneal(&Settings::preset(Preset::Fast, 0));
    let fast_seconds = median(repeats, |_| {
        drop(anneal(&Settings::preset(Preset::Fast, 0)));
    });

    let pairs = shuffled_pairs(&fast.path, side);
    let checks = median(repeats, |_| {
        let valid =
            pairs.iter().filter(|[first, second]| fast.path.allows_pair(*first, *second)).count();
        assert!(black_box(valid) > 0, "some pairs are valid");
    });
    let windows = median(repeats, |_| {
        let kinds = [VariantKind::Transpose, VariantKind::Flip];
        let mut found = 0;
        fast.path.for_each_variant(&kinds, |_| found += 1);
        black_box(found);
    });
    Ok(GridRow {
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

/// A million pairs of switches at random places, the second one or two cells from the first; both
/// take out two links that are there: the cases in which positions decide.
fn shuffled_pairs(path: &Path, side: u32) -> Vec<[Switch; 2]> {
    let corners: Vec<u32> =
        (0..side * side).filter(|&corner| path.sides(corner).is_some()).collect();
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
