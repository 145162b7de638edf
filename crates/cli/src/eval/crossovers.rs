//! Crossovers of the genetic algorithm compared, each on the same first populations.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::{Context, bail};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
use beadwork_search::bound::Bounds;
use beadwork_search::genetic::{self, Crossover, Evolution, Preset, Settings};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::ZonesArgs;
use super::statistics::{Interval, mean};
use super::store::Store;
use crate::paper::{self, Cell};
use crate::{cancel, machine, output, progress};

/// What is compared; the first is the paper's, which the others are compared with.
fn ways(paper: Evolution) -> [(&'static str, Evolution); 5] {
    let way = |crossover, mutations| Evolution { crossover, mutations, ..paper };
    [
        ("one-point", paper),
        ("one-point, mutation", way(paper.crossover, 1)),
        ("two-point", way(Crossover::TwoPoint, 0)),
        ("window", way(Crossover::Window, 0)),
        ("window, mutation", way(Crossover::Window, 1)),
    ]
}

/// Sizes that are compared, of the paper's.
const SIDES: [u32; 3] = [30, 60, 100];

/// All ways from one first population.
#[derive(Serialize, Deserialize)]
struct Run {
    /// Of the search and of the instance.
    seed: u64,
    initial: i64,
    /// Best of the first population.
    seeded: i64,
    /// By each way.
    crossings: Vec<i64>,
}

impl Run {
    /// By how many per cent of the start's crossings a way saves more than the first population, or than another way.
    fn saved(&self, way: usize, on: Option<usize>) -> f64 {
        let before = on.map_or(self.seeded, |other| self.crossings[other]);
        100.0 * (before - self.crossings[way]) as f64 / self.initial.max(1) as f64
    }
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(if args.smoke { 2 } else { 30 });
    let out = args.out.as_deref().unwrap_or(Path::new("datasets/eval-crossovers"));
    let (preset, sides) = if args.smoke { (Preset::Short, &SIDES[..1]) } else { (Preset::Paper, &SIDES[..]) };
    let compared = |cell: &Cell| cell.size.width == cell.size.height && sides.contains(&cell.size.width);
    let cells: Vec<Cell> = paper::cells().filter(compared).collect();
    let settings = json!({ "eval": "crossovers", "seeds": seeds, "smoke": args.smoke });
    let mut store = Store::open(out, &settings)?;
    let pool = args.pool()?;
    let bar = progress::bar(cells.len() as u64 * seeds, "eval zones");
    let mut all: Vec<(Cell, Vec<Run>)> = Vec::new();
    for cell in cells {
        let search = || {
            let run = |seed: u64| {
                let run = compare(&cell, seed, preset);
                bar.inc(1);
                run
            };
            let seeds: Vec<u64> = (0..seeds).collect();
            pool.install(|| seeds.into_par_iter().with_max_len(1).map(run).collect())
        };
        let runs = store.part(&format!("{}-{}", cell.layout, cell.size), search).with_context(|| {
            format!("{} cells are done, and the same command goes on from '{}'", all.len(), out.display())
        })?;
        all.push((cell, runs));
        bar.set_position(all.len() as u64 * seeds);
    }
    bar.finish_and_clear();

    let text = table(&all, seeds)?;
    let names = ways(Evolution::default()).map(|(name, _)| name);
    let document = json!({
        "machine": machine::facts(), "seeds": seeds, "ways": names,
        "cells": all
            .iter()
            .map(|(cell, runs)| json!({"layout": cell.layout.name(), "size": cell.size.to_string(), "runs": runs}))
            .collect::<Vec<_>>(),
    });
    store.result("crossovers.md", &text)?;
    store.result("crossovers.json", &format!("{document:#}\n"))?;
    if args.json {
        return output::json(&document);
    }
    output::text(&text)
}

fn compare(cell: &Cell, seed: u64, preset: Preset) -> anyhow::Result<Run> {
    let region = Region::rectangle(cell.size.width, cell.size.height)?;
    let zones = LayoutSpec::new(cell.layout).zones(&region, seed)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region)?;
    let cancel = cancel::token()?;
    let settings = Settings {
        bound: Some(i64::from(Bounds::new(&region, &zones).crossings())),
        cancel: Some(cancel),
        ..Settings::preset(preset, seed)
    };
    let population = genetic::annealed(&start, &crossings, &settings);
    let (mut initial, mut seeded) = (0, 0);
    let mut by_way = Vec::new();
    for (_, evolution) in
        ways(Evolution { crossover: Evolution::default().crossover, mutations: 0, ..settings.evolution })
    {
        let outcome =
            genetic::evolve(&start, &crossings, &population, &Settings { evolution, ..settings.clone() });
        (initial, seeded) = (outcome.initial, outcome.generations[0].best);
        by_way.push(outcome.cost);
    }
    if cancel.load(Ordering::Relaxed) {
        bail!("stopped");
    }
    Ok(Run { seed, initial, seeded, crossings: by_way })
}

fn table(all: &[(Cell, Vec<Run>)], seeds: u64) -> Result<String, std::fmt::Error> {
    let ways = ways(Evolution::default()).map(|(name, _)| name);
    let mut text = format!("Machine: {}. Seeds 0..{seeds}, of instance and search.\n", machine::line());
    writeln!(
        text,
        "\nReduction of the start's crossings in points of per cent, on the best annealing run of the first population; for all but one-point: on \
         one-point. Mean of the seeds with its confidence interval of 95 %; an interval that leaves out 0 is marked *.\n"
    )?;
    let heads = ways[1..].iter().map(|name| format!("{name}: more")).collect::<Vec<_>>().join(" | ");
    writeln!(text, "| layout | size | annealed | {}: saves | {heads} |", ways[0])?;
    writeln!(text, "|---|---|---|---|{}", "---|".repeat(ways.len() - 1))?;
    let mut row = |layout: &str, size: &str, runs: &[&Run]| {
        let annealed =
            mean(runs.iter().map(|run| 100.0 * (1.0 - run.seeded as f64 / run.initial.max(1) as f64)));
        let cells = (0..ways.len()).map(|way| {
            let saved: Vec<f64> = runs.iter().map(|run| run.saved(way, (way > 0).then_some(0))).collect();
            let interval = Interval::of(&saved);
            let mark = if interval.tells() { " *" } else { "" };
            format!("{:.2} +- {:.2}{mark}", interval.mean, interval.half_width)
        });
        writeln!(text, "| {layout} | {size} | {annealed:.1} | {} |", cells.collect::<Vec<_>>().join(" | "))
    };
    for (cell, runs) in all {
        row(cell.layout.name(), &cell.size.to_string(), &runs.iter().collect::<Vec<_>>())?;
    }
    for layout in Layout::PAPER {
        let here = all.iter().filter(|(cell, _)| cell.layout == layout);
        row(layout.name(), "all", &here.flat_map(|(_, runs)| runs).collect::<Vec<_>>())?;
    }
    row("all", "all", &all.iter().flat_map(|(_, runs)| runs).collect::<Vec<_>>())?;
    Ok(text)
}
