//! The tables of Aali et al. by the zigzag and by annealing, with ours beside them.

use std::fmt::Write;
use std::sync::atomic::Ordering;

use anyhow::bail;
use beadwork_base::Control;
use beadwork_console::search::{Choice, MethodName, Row, Search};
use beadwork_console::{cancel, machine, output, progress};
use beadwork_grid::{LayoutSpec, Region, Start};
use beadwork_search::anneal::Preset;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::args::ZonesArgs;
use super::cell_table::{instances, percent, table};
use crate::paper::{self, AVERAGED, Cell};
use crate::statistics::mean;

/// One search to run.
struct Job {
    cell: Cell,
    /// `None` for the zigzag alone.
    preset: Option<Preset>,
    seed: u64,
    instance_seed: u64,
    /// Whether the instance was chosen to be like the paper's, for the table of bests.
    matched: bool,
}

/// A search that was run.
struct Run {
    job: Job,
    row: Row,
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(100);
    let presets = if args.presets.is_empty() { Preset::ALL.to_vec() } else { args.presets.clone() };
    let methods: Vec<Option<Preset>> = match args.method {
        Some(MethodName::Anneal) => presets.into_iter().map(Some).collect(),
        _ => vec![None],
    };
    let mut jobs = Vec::new();
    for cell in paper::cells() {
        let matching = cell.matching_seeds(seeds)?;
        for &preset in &methods {
            for seed in 0..seeds {
                let instance_seed = matching[seed as usize % matching.len()];
                jobs.push(Job { cell, preset, seed, instance_seed, matched: true });
                // Fixed layouts have one instance, which serves for all tables.
                if cell.layout.is_random() && preset.is_none_or(|preset| AVERAGED.contains(&preset))
                {
                    jobs.push(Job { cell, preset, seed, instance_seed: seed, matched: false });
                }
            }
        }
    }

    let pool = args.pool()?;
    let bar = progress::bar(jobs.len() as u64, "eval zones");
    let cancel = cancel::token()?.as_flag();
    let run = |job: Job| {
        if cancel.load(Ordering::Relaxed) {
            bail!("stopped");
        }
        let run = search(job);
        bar.inc(1);
        run
    };
    let runs: anyhow::Result<Vec<Run>> =
        pool.install(|| jobs.into_par_iter().with_max_len(1).map(run).collect());
    bar.finish_and_clear();
    let runs = runs?;
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

fn search(job: Job) -> anyhow::Result<Run> {
    let Cell { layout, size, .. } = job.cell;
    let region = &Region::rectangle(size.width, size.height)?;
    let zones = &LayoutSpec::new(layout).zones(region, job.instance_seed)?;
    let start = Start::RowZigzag;
    let choice = job.preset.map_or(Choice::Zigzag, Choice::Anneal);
    let search = Search { region, zones, choice, seed: job.seed, start, bounds: None };
    let control = Control::default();
    let (_, row) = search.run(layout.name(), &start.path(region, &control)?, &control)?;
    Ok(Run { job, row })
}

/// What the runs of one cell come to, in %.
struct Totals {
    /// Mean reduction by the preset `paper`, or by the zigzag's method.
    mean: f64,
    /// Mean of the means of the presets [`AVERAGED`].
    mean_of_presets: f64,
    best: f64,
    best_preset: String,
    best_fast: f64,
    /// Instances that are like the paper's.
    matching: usize,
}

fn totals(cell: &Cell, runs: &[Run]) -> Totals {
    let here = || {
        runs.iter()
            .filter(|run| (run.job.cell.layout, run.job.cell.size) == (cell.layout, cell.size))
    };
    let by_seed = || here().filter(|run| !run.job.matched || !cell.layout.is_random());
    let mean_of = |preset: Option<Preset>| {
        mean(by_seed().filter(|run| run.job.preset == preset).map(|run| run.row.reduction()))
    };
    let matched = || here().filter(|run| run.job.matched);
    let is_fast = |run: &&Run| run.job.preset == Some(Preset::Fast);
    let best = best(matched().filter(|run| !is_fast(run)));
    let mut seeds: Vec<u64> = matched().map(|run| run.job.instance_seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let zigzag = here().all(|run| run.job.preset.is_none());
    Totals {
        mean: mean_of((!zigzag).then_some(Preset::Paper)),
        mean_of_presets: mean(AVERAGED.into_iter().map(|preset| mean_of(Some(preset)))),
        best: best.map_or(f64::NAN, |run| run.row.reduction()),
        best_preset: best.and_then(|run| run.row.preset.clone()).unwrap_or_default(),
        best_fast: self::best(matched().filter(is_fast))
            .map_or(f64::NAN, |run| run.row.reduction()),
        matching: seeds.len(),
    }
}

fn best<'a>(runs: impl Iterator<Item = &'a Run>) -> Option<&'a Run> {
    runs.max_by(|a, b| a.row.reduction().total_cmp(&b.row.reduction()))
}

fn summary(cell: &Cell, runs: &[Run]) -> Value {
    let totals = totals(cell, runs);
    json!({
        "layout": cell.layout.name(), "size": cell.size.to_string(), "zigzag_of_the_paper": cell.zigzag,
        "matching_instances": totals.matching,
        "mean_percent": totals.mean, "mean_percent_of_presets": totals.mean_of_presets, "paper_mean_percent": cell.mean,
        "best_percent": totals.best, "best_preset": totals.best_preset, "best_percent_fast": totals.best_fast,
        "paper_best_percent": cell.best,
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
        "\n## Mean reduction of crossings, preset `paper`, in % (the paper's Table 5 in brackets)\n"
    )?;
    table(&mut text, |cell| format!("{} ({:.1})", percent(totals(cell, runs).mean), cell.mean))?;
    let averaged = AVERAGED.map(|preset| format!("`{preset}`")).join(", ");
    writeln!(
        text,
        "\n## Mean over the presets {averaged}, in % (the paper's Table 5 in brackets)\n"
    )?;
    table(&mut text, |cell| {
        format!("{} ({:.1})", percent(totals(cell, runs).mean_of_presets), cell.mean)
    })?;
    writeln!(
        text,
        "\n## Best reduction of crossings, in %: by the paper's presets / by `fast` (the paper's Table 3 in brackets)\n"
    )?;
    table(&mut text, |cell| {
        let totals = totals(cell, runs);
        format!("{} / {} ({:.1})", percent(totals.best), percent(totals.best_fast), cell.best)
    })?;
    instances(&mut text, paper::cells().map(|cell| (cell, totals(&cell, runs).matching)))?;
    Ok(text)
}
