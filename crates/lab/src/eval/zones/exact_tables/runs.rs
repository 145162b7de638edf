//! The searches on the instances of one case, and their figures.

use std::time::{Duration, Instant};

use beadwork_base::{Control, Threads};
use beadwork_console::control;
use beadwork_console::search::{Choice, Row, Search};
use beadwork_grid::Start;
use beadwork_search::anneal::Preset;
use beadwork_search::exact;
use serde_json::{Value, json};

use super::cases::Case;
use crate::statistics;

/// The results of the searches on the instances of one case.
pub(super) struct Runs {
    pub(super) case: Case,
    /// One for each instance.
    pub(super) exact: Vec<Row>,
    /// On the first [`COMPARED`] instances, as are all that follow.
    pub(super) zigzag: Vec<Row>,
    /// By the preset `paper`.
    pub(super) anneal: Vec<Row>,
    /// By the preset `fast`.
    pub(super) fast: Vec<Row>,
}

/// Number of instances of a case that the zigzag and annealing also solve.
const COMPARED: u64 = 10;

impl Runs {
    /// No results yet.
    pub(super) fn new(case: Case) -> Self {
        Self { case, exact: vec![], zigzag: vec![], anneal: vec![], fast: vec![] }
    }

    /// Solves the instance of a seed on one thread.
    pub(super) fn add(&mut self, seed: u64) -> anyhow::Result<()> {
        let control = &control::cancellable(Threads::One)?;
        control.check()?;
        let (region, zones) = &self.case.instance(seed)?;
        let layout = self.case.spec.layout.name();
        let start = if Start::RowZigzag.path(region, control).is_ok() {
            Start::RowZigzag
        } else {
            Start::Cover
        };
        let start_path = start.path(region, control)?;
        let search = |choice, control: &Control<'_>| {
            let search = Search { region, zones, choice, seed, start, bounds: None };
            anyhow::Ok(search.run(layout, &start_path, control)?.1)
        };
        // One second is more than enough up to 100 x 100 cells; larger grids get proportionally
        // more.
        let cells = f64::from(self.case.width * self.case.height);
        let limit = Duration::from_secs_f64((cells / 10_000.0).max(1.0));
        let begin = Instant::now();
        let time_is_up = || begin.elapsed() >= limit;
        let timed = Control { time_is_up: Some(&time_is_up), ..*control };
        self.exact.push(search(Choice::Exact(exact::Settings::default()), &timed)?);
        control.check()?;
        if seed < COMPARED {
            self.zigzag.push(search(Choice::Zigzag, control)?);
            self.anneal.push(search(Choice::Anneal(Preset::Paper), control)?);
            self.fast.push(search(Choice::Anneal(Preset::Fast), control)?);
        }
        Ok(())
    }

    /// The exact results on the instances that the other methods also solved.
    pub(super) fn exact_compared(&self) -> &[Row] {
        &self.exact[..self.zigzag.len()]
    }

    /// The figures as a JSON object.
    pub(super) fn summary(&self) -> Value {
        let totals = Totals::of(&self.exact);
        json!({
            "group": self.case.group, "case": self.case.name,
            "width": self.case.width, "height": self.case.height, "runs": self.exact.len(),
            "optimal": totals.optimal, "worst_gap": totals.max_gap,
            "pieces_met": totals.pieces_optimal, "worst_piece_gap": totals.max_piece_gap,
            "ms_p50": totals.ms[0], "ms_p95": totals.ms[1], "ms_max": totals.ms[2],
            "crossings": mean_crossings(&self.exact),
            "bound": mean(&self.exact, |row| row.bound.unwrap_or_default()),
            "compared": self.zigzag.len(),
            "exact_compared": mean_crossings(self.exact_compared()),
            "zigzag": mean_crossings(&self.zigzag),
            "anneal": mean_crossings(&self.anneal),
            "anneal_ms": mean(&self.anneal, |row| 1e3 * row.seconds),
            "fast": mean_crossings(&self.fast),
            "fast_ms": mean(&self.fast, |row| 1e3 * row.seconds),
        })
    }
}

/// Figures of the exact search on the instances of one case.
pub(super) struct Totals {
    /// Number of instances whose optimum is proven.
    pub(super) optimal: usize,
    /// Maximum difference between the crossings and their bound.
    pub(super) max_gap: u64,
    /// Number of instances with as few pieces as their bound.
    pub(super) pieces_optimal: usize,
    /// Maximum difference between the pieces and their bound.
    max_piece_gap: u32,
    /// Median, 95th percentile and maximum of the run time, in milliseconds.
    pub(super) ms: [f64; 3],
}

impl Totals {
    pub(super) fn of(rows: &[Row]) -> Self {
        let is_optimal = |row: &&Row| row.exact.as_ref().is_some_and(|exact| exact.optimal);
        let gap = |row: &Row| {
            let cost = row.exact.as_ref().map_or(0.0, |exact| exact.cost);
            (cost - row.bound.unwrap_or_default()) as u64
        };
        let mut ms: Vec<f64> = rows.iter().map(|row| 1e3 * row.seconds).collect();
        ms.sort_by(f64::total_cmp);
        let percentile = |percent: usize| ms[(ms.len() * percent / 100).min(ms.len() - 1)];
        Self {
            optimal: rows.iter().filter(is_optimal).count(),
            max_gap: rows.iter().map(gap).max().unwrap_or(0),
            pieces_optimal: rows.iter().filter(|row| row.pieces == row.piece_bound).count(),
            max_piece_gap: rows.iter().map(|row| row.pieces - row.piece_bound).max().unwrap_or(0),
            ms: [percentile(50), percentile(95), percentile(100)],
        }
    }
}

/// Mean of the crossings; NaN if there are no rows.
pub(super) fn mean_crossings(rows: &[Row]) -> f64 {
    mean(rows, |row| f64::from(row.crossings))
}

fn mean(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    statistics::mean(rows.iter().map(value))
}
