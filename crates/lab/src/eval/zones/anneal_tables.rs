//! Tables 3 and 5 of Aali et al. by the zigzag or by annealing, next to the paper's figures.

use std::fmt::Write;

use beadwork_base::Threads;
use beadwork_console::search::{Choice, MethodName, Row, Search};
use beadwork_console::{control, machine, output, progress};
use beadwork_grid::{LayoutSpec, Region, Start};
use beadwork_search::anneal::Preset;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::args::ZonesArgs;
use super::cell_table::{distinct, instances, percent, table};
use crate::paper::{self, AVERAGED, Cell};
use crate::statistics::mean;

/// A search to run.
struct Job {
    cell: Cell,
    /// `None` for the zigzag.
    preset: Option<Preset>,
    seed: u64,
    instance_seed: u64,
    /// Whether the instance was chosen to be like the paper's, for the table of best reductions.
    matched: bool,
}

/// The result of a search.
struct Run {
    job: Job,
    row: Row,
}

/// Runs all searches, and prints their tables.
pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(100);
    let presets: Vec<Option<Preset>> = match args.method {
        Some(MethodName::Anneal) if args.presets.is_empty() => Preset::ALL.map(Some).to_vec(),
        Some(MethodName::Anneal) => args.presets.iter().copied().map(Some).collect(),
        _ => vec![None],
    };
    let jobs = jobs(&presets, seeds)?;
    let pool = args.pool()?;
    let bar = progress::bar(jobs.len() as u64, "eval zones");
    let run = |job: Job| {
        let run = job.run();
        bar.inc(1);
        run
    };
    let runs: Vec<Run> = pool
        .install(|| jobs.into_par_iter().with_max_len(1).map(run).collect::<anyhow::Result<_>>())?;
    bar.finish_and_clear();
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "seeds": seeds,
            "cells": paper::cells().map(|cell| summary(&cell, &runs)).collect::<Vec<_>>(),
            "rows": runs.iter().map(json_row).collect::<Vec<_>>(),
        }));
    }
    output::text(&tables(&runs, seeds)?)
}

/// One job for each cell, preset and seed, on instances like the paper's.
///
/// Random layouts also get a job on the instance of the seed, for the tables of means.
fn jobs(presets: &[Option<Preset>], seeds: u64) -> anyhow::Result<Vec<Job>> {
    let mut jobs = Vec::new();
    for cell in paper::cells() {
        let matching = cell.matching_seeds(seeds)?;
        for &preset in presets {
            // A layout that is not random has one instance, which serves for all tables.
            let is_averaged = preset.is_none_or(|preset| AVERAGED.contains(&preset));
            let by_seed = cell.layout.is_random() && is_averaged;
            for seed in 0..seeds {
                let instance_seed = matching[seed as usize % matching.len()];
                jobs.push(Job { cell, preset, seed, instance_seed, matched: true });
                if by_seed {
                    jobs.push(Job { cell, preset, seed, instance_seed: seed, matched: false });
                }
            }
        }
    }
    Ok(jobs)
}

impl Job {
    fn run(self) -> anyhow::Result<Run> {
        let control = &control::cancellable(Threads::One)?;
        control.check()?;
        let Cell { layout, size, .. } = self.cell;
        let region = &Region::rectangle(size.width, size.height)?;
        let zones = &LayoutSpec::new(layout).zones(region, self.instance_seed)?;
        let start = Start::RowZigzag;
        let choice = self.preset.map_or(Choice::Zigzag, Choice::Anneal);
        let search = Search { region, zones, choice, seed: self.seed, start, bounds: None };
        let (_, row) = search.run(layout.name(), &start.path(region, control)?, control)?;
        Ok(Run { job: self, row })
    }
}

/// Figures of one cell, in %; NaN if there are no runs.
struct Totals {
    /// Mean reduction by the preset `paper`, or by the zigzag.
    mean: f64,
    /// Mean of the mean reductions by the presets [`AVERAGED`].
    mean_of_presets: f64,
    /// Best reduction by the paper's presets, or by the zigzag.
    best: f64,
    best_preset: String,
    /// Best reduction by the preset `fast`.
    best_fast: f64,
    /// Number of instances like the paper's.
    matching: usize,
}

impl Totals {
    fn of(cell: &Cell, all: &[Run]) -> Self {
        let runs = || all.iter().filter(|run| run.job.cell.is_same(cell));
        let by_seed = || runs().filter(|run| !run.job.matched || !cell.layout.is_random());
        let mean_of = |preset: Option<Preset>| {
            mean(by_seed().filter(|run| run.job.preset == preset).map(|run| run.row.reduction()))
        };
        let matched = || runs().filter(|run| run.job.matched);
        let is_fast = |run: &&Run| run.job.preset == Some(Preset::Fast);
        let best = best(matched().filter(|run| !is_fast(run)));
        let best_fast = self::best(matched().filter(is_fast));
        let is_zigzag = runs().all(|run| run.job.preset.is_none());
        Self {
            mean: mean_of((!is_zigzag).then_some(Preset::Paper)),
            mean_of_presets: mean(AVERAGED.into_iter().map(|preset| mean_of(Some(preset)))),
            best: best.map_or(f64::NAN, |run| run.row.reduction()),
            best_preset: best.and_then(|run| run.row.preset.clone()).unwrap_or_default(),
            best_fast: best_fast.map_or(f64::NAN, |run| run.row.reduction()),
            matching: distinct(matched().map(|run| run.job.instance_seed)),
        }
    }
}

fn best<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<&'a Run> {
    runs.max_by(|a, b| a.row.reduction().total_cmp(&b.row.reduction()))
}

fn summary(cell: &Cell, runs: &[Run]) -> Value {
    let totals = Totals::of(cell, runs);
    json!({
        "layout": cell.layout.name(), "size": cell.size.to_string(),
        "zigzag_of_the_paper": cell.zigzag, "matching_instances": totals.matching,
        "mean_percent": totals.mean, "mean_percent_of_presets": totals.mean_of_presets,
        "paper_mean_percent": cell.mean,
        "best_percent": totals.best, "best_preset": totals.best_preset,
        "best_percent_fast": totals.best_fast, "paper_best_percent": cell.best,
    })
}

fn json_row(run: &Run) -> Value {
    let mut row = json!(run.row);
    row["instance_seed"] = json!(run.job.instance_seed);
    row["matched"] = json!(run.job.matched);
    row
}

fn tables(runs: &[Run], seeds: u64) -> Result<String, std::fmt::Error> {
    let mut text = format!("Machine: {}. Seeds 0..{seeds}.\n", machine::line());
    writeln!(
        text,
        "\n## Mean reduction of crossings by the preset `paper`, in % (the paper's Table 5)\n"
    )?;
    let totals = |cell: &Cell| Totals::of(cell, runs);
    table(&mut text, |cell| format!("{} ({:.1})", percent(totals(cell).mean), cell.mean))?;
    let averaged = AVERAGED.map(|preset| format!("`{preset}`")).join(", ");
    writeln!(text, "\n## Mean over the presets {averaged}, in % (the paper's Table 5)\n")?;
    table(&mut text, |cell| {
        format!("{} ({:.1})", percent(totals(cell).mean_of_presets), cell.mean)
    })?;
    writeln!(
        text,
        "\n## Best reduction of crossings, in %: by the paper's presets / by `fast` (the paper's \
         Table 3)\n"
    )?;
    table(&mut text, |cell| {
        let totals = totals(cell);
        format!("{} / {} ({:.1})", percent(totals.best), percent(totals.best_fast), cell.best)
    })?;
    instances(&mut text, paper::cells().map(|cell| (cell, totals(&cell).matching)))?;
    Ok(text)
}
