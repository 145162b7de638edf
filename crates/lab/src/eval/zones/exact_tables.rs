//! How often the exact search proves the fewest crossings, and in what time.

use std::fmt::Write;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::bail;
use beadwork_base::Control;
use beadwork_console::search::{Choice, Row, Search};
use beadwork_console::{cancel, machine, output, progress};
use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape, Start, Zones};
use beadwork_search::anneal::Preset;
use beadwork_search::exact;
use serde_json::{Value, json};

use super::args::ZonesArgs;
use super::growth;
use crate::paper;
use crate::statistics;

/// Instances of one kind.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) spec: LayoutSpec,
    pub(super) width: u32,
    pub(super) height: u32,
    shape: Option<RegionShape>,
    pub(super) seeds: u64,
    group: &'static str,
}

impl Case {
    fn instance(&self, seed: u64) -> anyhow::Result<(Region, Zones)> {
        let region = match self.shape {
            Some(shape) => shape.region(self.width, self.height, seed)?,
            None => Region::rectangle(self.width, self.height)?,
        };
        let zones = self.spec.zones(&region, seed)?;
        Ok((region, zones))
    }
}

/// All cases: the paper's 24 cells, harder layouts, larger ones and masks; so many seeds of each,
/// fewer of the largest.
fn cases(seeds: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add =
        |group, spec: LayoutSpec, (width, height), shape: Option<RegionShape>, seeds: u64| {
            let zones = spec.zones;
            let name = match (shape, spec.layout) {
                (Some(shape), layout) => format!("{shape} {layout}"),
                (None, Layout::Voronoi) => format!("voronoi {zones}"),
                (None, Layout::Islands) => {
                    format!("{} islands of {side}x{side}", zones - 1, side = spec.side)
                }
                (None, layout) => layout.name().to_owned(),
            };
            cases.push(Case { name, spec, width, height, shape, seeds, group });
        };
    for cell in paper::cells() {
        // A layout that is not drawn has one instance; it is solved with as many seeds of the
        // search.
        add(
            "the paper's layouts",
            LayoutSpec::new(cell.layout),
            (cell.size.width, cell.size.height),
            None,
            seeds,
        );
    }
    let voronoi = |zones| LayoutSpec { zones, ..LayoutSpec::new(Layout::Voronoi) };
    for zones in [8, 12, 30] {
        add("many zones", voronoi(zones), (100, 100), None, seeds);
    }
    let islands = LayoutSpec { layout: Layout::Islands, zones: 65, side: 4 };
    add("many zones", islands, (100, 100), None, seeds);
    add("many zones", LayoutSpec::new(Layout::Checkerboard), (100, 100), None, seeds);
    for (side, share) in [(200, 1), (500, 2), (1000, 5)] {
        add("large planes", voronoi(3), (side, side), None, seeds.div_ceil(share));
    }
    for shape in RegionShape::ALL {
        for layout in [Layout::LeftRight, Layout::Islands, Layout::Voronoi] {
            add("masks", LayoutSpec::new(layout), (60, 60), Some(shape), seeds.div_ceil(10));
        }
    }
    cases
}

/// The runs of one case.
struct Runs {
    case: Case,
    exact: Vec<Row>,
    zigzag: Vec<Row>,
    anneal: Vec<Row>,
    fast: Vec<Row>,
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(100);
    let mut cases = cases(seeds);
    if args.smoke {
        cases.retain(|case| case.width.max(case.height) <= 100);
    }
    let bar = progress::bar(cases.iter().map(|case| case.seeds).sum(), "eval zones");
    let cancel = cancel::token()?.as_flag();
    let mut runs = Vec::new();
    for case in cases {
        let mut here = Runs { exact: vec![], zigzag: vec![], anneal: vec![], fast: vec![], case };
        for seed in 0..here.case.seeds {
            if cancel.load(Ordering::Relaxed) {
                bail!("stopped");
            }
            here.add(seed)?;
            bar.inc(1);
        }
        runs.push(here);
    }
    let growth = growth::measure(&bar, args.smoke)?;
    bar.finish_and_clear();
    if let Some(file) = &args.plot {
        output::file(file, &growth.svg()?)?;
    }
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "seeds": seeds,
            "cases": runs.iter().map(Runs::summary).collect::<Vec<_>>(),
            "growth": growth.json(),
            "rows": runs.iter().flat_map(|runs| &runs.exact).collect::<Vec<_>>(),
        }));
    }
    let mut text = format!("Machine: {}. Seeds from 0.\n", machine::line());
    table(&mut text, &runs)?;
    growth.table(&mut text)?;
    output::text(&text)
}

impl Runs {
    /// Solves one instance; the first ten also by the zigzag and by annealing, to compare.
    fn add(&mut self, seed: u64) -> anyhow::Result<()> {
        const COMPARED: u64 = 10;

        let (region, zones) = &self.case.instance(seed)?;
        let layout = self.case.spec.layout.name();
        let start = if Start::RowZigzag.path(region, &Control::default()).is_ok() {
            Start::RowZigzag
        } else {
            Start::Cover
        };
        let start_path = start.path(region, &Control::default())?;
        let search = |choice, control: &Control<'_>| {
            let search = Search { region, zones, choice, seed, start, bounds: None };
            search.run(layout, &start_path, control)
        };
        // A second is plenty up to 100 x 100 cells; larger planes get time in proportion.
        let cells = f64::from(self.case.width * self.case.height);
        let time = Duration::from_secs_f64((cells / 10_000.0).max(1.0));
        let begin = Instant::now();
        let time_is_up = || begin.elapsed() >= time;
        let timed = Control { time_is_up: Some(&time_is_up), ..Control::default() };
        let exact = search(Choice::Exact(exact::Settings::default()), &timed)?.1;
        if seed < COMPARED {
            self.zigzag.push(search(Choice::Zigzag, &Control::default())?.1);
            self.anneal.push(search(Choice::Anneal(Preset::Paper), &Control::default())?.1);
            self.fast.push(search(Choice::Anneal(Preset::Fast), &Control::default())?.1);
        }
        self.exact.push(exact);
        Ok(())
    }

    fn summary(&self) -> Value {
        let totals = Totals::of(&self.exact);
        json!({
            "group": self.case.group, "case": self.case.name,
            "width": self.case.width, "height": self.case.height, "runs": self.exact.len(),
            "optimal": totals.optimal, "worst_gap": totals.worst_gap,
            "pieces_met": totals.pieces_met, "worst_piece_gap": totals.worst_piece_gap,
            "ms_p50": totals.ms[0], "ms_p95": totals.ms[1], "ms_max": totals.ms[2],
            "crossings": mean(&self.exact, |row| f64::from(row.crossings)),
            "bound": mean(&self.exact, |row| row.bound.unwrap_or_default()),
            "compared": self.zigzag.len(),
            "exact_compared": mean(&self.exact[..self.zigzag.len()], |row| f64::from(row.crossings)),
            "zigzag": mean(&self.zigzag, |row| f64::from(row.crossings)),
            "anneal": mean(&self.anneal, |row| f64::from(row.crossings)),
            "anneal_ms": mean(&self.anneal, |row| 1e3 * row.seconds),
            "fast": mean(&self.fast, |row| f64::from(row.crossings)),
            "fast_ms": mean(&self.fast, |row| 1e3 * row.seconds),
        })
    }
}

/// What the exact search came to on the instances of one case.
pub(super) struct Totals {
    optimal: usize,
    worst_gap: u64,
    pieces_met: usize,
    worst_piece_gap: u32,
    /// The median, the 95th of 100, and the greatest.
    pub(super) ms: [f64; 3],
}

impl Totals {
    pub(super) fn of(rows: &[Row]) -> Self {
        let gap = |row: &Row| {
            let cost = row.exact.as_ref().map_or(0.0, |exact| exact.cost);
            (cost - row.bound.unwrap_or_default()) as u64
        };
        let mut ms: Vec<f64> = rows.iter().map(|row| 1e3 * row.seconds).collect();
        ms.sort_by(f64::total_cmp);
        let at = |share: usize| ms[(ms.len() * share / 100).min(ms.len() - 1)];
        Self {
            optimal: rows
                .iter()
                .filter(|row| row.exact.as_ref().is_some_and(|exact| exact.optimal))
                .count(),
            worst_gap: rows.iter().map(gap).max().unwrap_or(0),
            pieces_met: rows.iter().filter(|row| row.pieces == row.piece_bound).count(),
            worst_piece_gap: rows.iter().map(|row| row.pieces - row.piece_bound).max().unwrap_or(0),
            ms: [at(50), at(95), at(100)],
        }
    }
}

fn mean(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    statistics::mean(rows.iter().map(value))
}

fn table(text: &mut String, runs: &[Runs]) -> std::fmt::Result {
    let mut group = "";
    for runs in runs {
        let case = &runs.case;
        if case.group != group {
            group = case.group;
            writeln!(text, "\n## {}{}\n", group[..1].to_uppercase(), &group[1..])?;
            writeln!(
                text,
                "| case | size | proven | worst gap | pieces = bound | p50 / p95 / max, ms | crossings | first ten: exact | fast | anneal | zigzag |"
            )?;
            writeln!(text, "|---|---|---|---|---|---|---|---|---|---|---|")?;
        }
        let Totals { optimal, worst_gap, pieces_met, ms: [p50, p95, max], .. } =
            Totals::of(&runs.exact);
        let count = runs.exact.len();
        let crossings = |rows: &[Row]| mean(rows, |row| f64::from(row.crossings));
        writeln!(
            text,
            "| {} | {}x{} | {optimal} of {count} | {worst_gap} | {pieces_met} of {count} | {p50:.2} / {p95:.2} / {max:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
            case.name,
            case.width,
            case.height,
            crossings(&runs.exact),
            crossings(&runs.exact[..runs.zigzag.len()]),
            crossings(&runs.fast),
            crossings(&runs.anneal),
            crossings(&runs.zigzag),
        )?;
    }
    Ok(())
}
