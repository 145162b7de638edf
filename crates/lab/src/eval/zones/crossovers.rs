//! Crossovers of the genetic algorithm compared, each on the same first populations.

use std::fmt::Write;
use std::path::Path;

use beadwork_base::{Control, Threads};
use beadwork_console::{cancel, control, machine, output};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
use beadwork_search::bound::Bounds;
use beadwork_search::genetic::{self, Crossover, Evolution, Preset, Settings};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::args::ZonesArgs;
use crate::eval::store::Store;
use crate::paper::{self, Cell};
use crate::statistics::{Interval, mean};

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
const SIDES: [u32; 2] = [30, 60];

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
    /// By how many per cent of the start's crossings a way saves more than the first population, or
    /// than another way.
    fn saved(&self, way: usize, on: Option<usize>) -> f64 {
        let before = on.map_or(self.seeded, |other| self.crossings[other]);
        100.0 * (before - self.crossings[way]) as f64 / self.initial.max(1) as f64
    }
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(if args.smoke { 2 } else { 30 });
    let usual =
        if args.smoke { "datasets/eval-crossovers-smoke" } else { "datasets/eval-crossovers" };
    let out = args.out.as_deref().unwrap_or(Path::new(usual));
    let (preset, sides) =
        if args.smoke { (Preset::Short, &SIDES[..1]) } else { (Preset::Paper, &SIDES[..]) };
    let compared =
        |cell: &Cell| cell.size.width == cell.size.height && sides.contains(&cell.size.width);
    let cells: Vec<Cell> = paper::cells().filter(compared).collect();
    let pool = args.pool()?;
    let threads = pool.current_num_threads();
    let settings =
        json!({ "eval": "crossovers", "seeds": seeds, "smoke": args.smoke, "threads": threads });
    let store = Store::open(out, &settings)?;
    let jobs: Vec<(Cell, u64)> =
        cells.iter().flat_map(|&cell| (0..seeds).map(move |seed| (cell, seed))).collect();
    let name = |(cell, seed): &(Cell, u64)| format!("{}-{}-{seed}", cell.layout, cell.size);
    let runs = store.results(&pool, &jobs, name, |(cell, seed)| compare(cell, *seed, preset))?;
    let mut runs = runs.into_iter().map(|(run, _)| run);
    let all: Vec<(Cell, Vec<Run>)> = cells
        .into_iter()
        .map(|cell| (cell, runs.by_ref().take(seeds as usize).collect()))
        .collect();

    let mut text = format!("Machine: {}. Seeds 0..{seeds}.\n", machine::one_line(store.machine()));
    table(&mut text, &all)?;
    let names = ways(Evolution::default()).map(|(name, _)| name);
    let document = json!({
        "machine": store.machine(), "seeds": seeds, "ways": names,
        "cells": all
            .iter()
            .map(|(cell, runs)| json!({"layout": cell.layout.name(), "size": cell.size.to_string(), "runs": runs}))
            .collect::<Vec<_>>(),
    });
    store.write("crossovers.md", &text)?;
    store.write("crossovers.json", &format!("{document:#}\n"))?;
    if args.json {
        return output::json(&document);
    }
    output::text(&text)
}

fn compare(cell: &Cell, seed: u64, preset: Preset) -> anyhow::Result<Run> {
    let region = Region::rectangle(cell.size.width, cell.size.height)?;
    let zones = LayoutSpec::new(cell.layout).zones(&region, seed)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, &Control::default())?;
    let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
    let bounds = control::quiet(Threads::One, |control| Bounds::new(&region, &zones, control))??;
    let settings = Settings {
        proven_bound: Some(i64::from(bounds.crossings())),
        ..Settings::preset(preset, seed)
    };
    let population = genetic::annealed(&start, &crossings, &settings, &control);
    let (mut initial, mut seeded) = (0, 0);
    let mut by_way = Vec::new();
    for (_, evolution) in ways(Evolution {
        crossover: Evolution::default().crossover,
        mutations: 0,
        ..settings.evolution
    }) {
        let outcome = genetic::evolve(
            &start,
            &crossings,
            &population,
            &Settings { evolution, ..settings.clone() },
            &control,
        );
        (initial, seeded) = (outcome.initial, outcome.generations[0].best);
        by_way.push(outcome.cost);
    }
    Ok(Run { seed, initial, seeded, crossings: by_way })
}

fn table(text: &mut String, all: &[(Cell, Vec<Run>)]) -> std::fmt::Result {
    let ways = ways(Evolution::default()).map(|(name, _)| name);
    writeln!(
        text,
        "\nReduction of the start's crossings in points of per cent: by the best annealing run of the first population; what one-point crossover saves on that; what \
         the others save on one-point. Means with their confidence intervals of 95 %; * where the interval leaves out 0, which chance alone would do in one of twenty. \
         Seeds draw the instance of islands and voronoi, and the searches; left_right and stripes have one instance. Rows of several sizes are means of their cells.\n"
    )?;
    let heads =
        ways[1..].iter().map(|name| format!("{name}: more")).collect::<Vec<_>>().join(" | ");
    writeln!(text, "| layout | size | annealed | {}: saves | {heads} |", ways[0])?;
    writeln!(text, "|---|---|---|---|{}", "---|".repeat(ways.len() - 1))?;
    let mut row = |layout: &str, size: &str, cells: &[&Vec<Run>]| {
        let annealed = |run: &Run| 100.0 * (1.0 - run.seeded as f64 / run.initial.max(1) as f64);
        let annealed = mean(cells.iter().map(|runs| mean(runs.iter().map(annealed))));
        let entries = (0..ways.len()).map(|way| {
            let saved = |run: &Run| run.saved(way, (way > 0).then_some(0));
            let groups: Vec<Vec<f64>> =
                cells.iter().map(|runs| runs.iter().map(saved).collect()).collect();
            let interval = Interval::of(&groups);
            format!("{interval}{}", if interval.excludes_zero() { " *" } else { "" })
        });
        writeln!(
            text,
            "| {layout} | {size} | {annealed:.1} | {} |",
            entries.collect::<Vec<_>>().join(" | ")
        )
    };
    for (cell, runs) in all {
        row(cell.layout.name(), &cell.size.to_string(), &[runs])?;
    }
    for layout in Layout::PAPER {
        let here: Vec<&Vec<Run>> =
            all.iter().filter(|(cell, _)| cell.layout == layout).map(|(_, runs)| runs).collect();
        if !here.is_empty() {
            row(layout.name(), "all", &here)?;
        }
    }
    row("all", "all", &all.iter().map(|(_, runs)| runs).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn ways_are_compared_run_by_run() {
        let run = |seed, crossings: [i64; 5]| Run {
            seed,
            initial: 50,
            seeded: 30,
            crossings: crossings.to_vec(),
        };
        // One-point saves 1 and 3 crossings of 50 on the first population, so 2 and 6 points;
        // window 2 and 3 crossings more than that.
        let runs = vec![run(0, [29, 29, 28, 27, 29]), run(1, [27, 27, 28, 24, 27])];
        assert!(
            (runs[0].saved(0, None) - 2.0).abs() < 1e-9
                && (runs[0].saved(3, Some(0)) - 4.0).abs() < 1e-9
        );
        let cell = paper::cells().next().unwrap();
        let mut text = String::new();
        table(&mut text, &[(cell, runs)]).unwrap();
        let line = text.lines().find(|line| line.starts_with("| left_right | 30x30")).unwrap();
        // Half widths are t(1) = 12.706 standard errors: of 2 points for one-point, of 1 point for
        // window.
        let entries: Vec<&str> = line.split('|').map(str::trim).collect();
        assert_eq!(entries[3..=4], ["40.0", "4.00 +- 25.41"], "{line}");
        assert_eq!(
            entries[5..=8],
            ["0.00 +- 0.00", "0.00 +- 25.41", "5.00 +- 12.71", "0.00 +- 0.00"],
            "{line}"
        );
    }
}
