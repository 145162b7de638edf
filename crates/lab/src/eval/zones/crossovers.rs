//! Variants of crossover in the genetic algorithm, compared from the same first populations.

use std::fmt::Write;
use std::path::Path;

use beadwork_base::Threads;
use beadwork_console::{control, machine, output};
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
use beadwork_search::bound::Bounds;
use beadwork_search::genetic::{self, Crossover, Evolution, Preset, Settings};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::args::ZonesArgs;
use crate::eval::store::Store;
use crate::paper::{self, Cell};
use crate::statistics::{Interval, mean};

/// Number of variants.
const VARIANTS: usize = 5;

/// The variants with their names, the paper's first; all other settings are those of `paper`.
fn variants(paper: Evolution) -> [(&'static str, Evolution); VARIANTS] {
    let variant = |crossover, mutations| Evolution { crossover, mutations, ..paper };
    [
        ("one-point", paper),
        ("one-point, mutation", variant(paper.crossover, 1)),
        ("two-point", variant(Crossover::TwoPoint, 0)),
        ("window", variant(Crossover::Window, 0)),
        ("window, mutation", variant(Crossover::Window, 1)),
    ]
}

fn variant_names() -> [&'static str; VARIANTS] {
    variants(Evolution::default()).map(|(name, _)| name)
}

/// Sides of the paper's square sizes that are compared, in cells.
const SIDES: [u32; 2] = [30, 60];

/// The results of all variants from one first population.
#[derive(Serialize, Deserialize)]
struct Run {
    /// Seed of the search and of the instance.
    seed: u64,
    /// Crossings of the start path.
    initial: i64,
    /// Crossings of the best individual of the first population.
    seeded: i64,
    /// Crossings of the best individual of each variant.
    crossings: Vec<i64>,
}

impl Run {
    /// Crossings that a variant saves in addition to a baseline, in per cent of the crossings of
    /// the start path.
    ///
    /// The baseline is another variant, or the first population if `baseline` is `None`.
    fn saved(&self, variant: usize, baseline: Option<usize>) -> f64 {
        let before = baseline.map_or(self.seeded, |other| self.crossings[other]);
        100.0 * (before - self.crossings[variant]) as f64 / self.initial.max(1) as f64
    }
}

/// Runs all variants, and writes the table to the output folder and stdout.
pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(if args.smoke { 2 } else { 30 });
    let default =
        if args.smoke { "datasets/eval-crossovers-smoke" } else { "datasets/eval-crossovers" };
    let out = args.out.as_deref().unwrap_or(Path::new(default));
    let (preset, sides) =
        if args.smoke { (Preset::Short, &SIDES[..1]) } else { (Preset::Paper, &SIDES[..]) };
    let is_compared =
        |cell: &Cell| cell.size.width == cell.size.height && sides.contains(&cell.size.width);
    let cells: Vec<Cell> = paper::cells().filter(is_compared).collect();
    let pool = args.pool()?;
    let threads = pool.current_num_threads();
    let settings =
        json!({ "eval": "crossovers", "seeds": seeds, "smoke": args.smoke, "threads": threads });
    let store = Store::open(out, &settings)?;
    let jobs: Vec<(Cell, u64)> =
        cells.iter().flat_map(|&cell| (0..seeds).map(move |seed| (cell, seed))).collect();
    let name = |(cell, seed): &(Cell, u64)| format!("{}-{}-{seed}", cell.layout, cell.size);
    let runs = store.results(&pool, &jobs, name, |(cell, seed)| compare(cell, *seed, preset))?;
    // Jobs are sorted by cell, with the same number of seeds for each.
    let mut runs = runs.into_iter().map(|(run, _)| run);
    let all: Vec<(Cell, Vec<Run>)> = cells
        .into_iter()
        .map(|cell| (cell, runs.by_ref().take(seeds as usize).collect()))
        .collect();

    let mut text = format!("Machine: {}. Seeds 0..{seeds}.\n", machine::one_line(store.machine()));
    table(&mut text, &all)?;
    let cells = all.iter().map(|(cell, runs)| {
        json!({
            "layout": cell.layout.name(), "size": cell.size.to_string(), "runs": runs,
        })
    });
    let document = json!({
        "machine": store.machine(), "seeds": seeds, "ways": variant_names(),
        "cells": cells.collect::<Vec<_>>(),
    });
    store.write("crossovers.md", &text)?;
    store.write("crossovers.json", &format!("{document:#}\n"))?;
    if args.json {
        return output::json(&document);
    }
    output::text(&text)
}

/// Runs all variants on the instance of a seed, from one first population.
fn compare(cell: &Cell, seed: u64, preset: Preset) -> anyhow::Result<Run> {
    let control = &control::cancellable(Threads::One)?;
    let region = Region::rectangle(cell.size.width, cell.size.height)?;
    let zones = LayoutSpec::new(cell.layout).zones(&region, seed)?;
    let crossings = Crossings::new(&region, &zones);
    let start = Start::RowZigzag.path(&region, control)?;
    let bounds = Bounds::new(&region, &zones, control)?;
    let settings = Settings {
        proven_bound: Some(i64::from(bounds.crossings())),
        ..Settings::preset(preset, seed)
    };
    let population = genetic::annealed(&start, &crossings, &settings, control);
    let (mut initial, mut seeded) = (0, 0);
    let mut best = Vec::new();
    let paper =
        Evolution { crossover: Evolution::default().crossover, mutations: 0, ..settings.evolution };
    for (_, evolution) in variants(paper) {
        let settings = Settings { evolution, ..settings.clone() };
        let outcome = genetic::evolve(&start, &crossings, &population, &settings, control);
        (initial, seeded) = (outcome.initial, outcome.generations[0].best);
        best.push(outcome.cost);
    }
    Ok(Run { seed, initial, seeded, crossings: best })
}

fn table(text: &mut String, all: &[(Cell, Vec<Run>)]) -> std::fmt::Result {
    let names = variant_names();
    writeln!(
        text,
        "\nReduction of the crossings of the start path, in percentage points: by the best \
         annealing run of the first population; the additional reduction by one-point crossover; \
         and the further reduction by the other variants, compared with one-point crossover. \
         Means with their 95 % confidence intervals; * marks intervals that exclude 0, as one \
         interval in twenty does by chance alone. The seed determines the instance of islands \
         and voronoi, and the searches; left_right and stripes have one instance. Rows of several \
         sizes are means of their cells.\n"
    )?;
    let further =
        names[1..].iter().map(|name| format!("{name}: further")).collect::<Vec<_>>().join(" | ");
    writeln!(text, "| layout | size | annealed | {}: additional | {further} |", names[0])?;
    writeln!(text, "|---|---|---|---|{}", "---|".repeat(names.len() - 1))?;
    for (cell, runs) in all {
        row(text, cell.layout.name(), &cell.size.to_string(), &[runs])?;
    }
    for layout in Layout::PAPER {
        let of_layout = all.iter().filter(|(cell, _)| cell.layout == layout);
        let cells: Vec<&[Run]> = of_layout.map(|(_, runs)| &runs[..]).collect();
        if !cells.is_empty() {
            row(text, layout.name(), "all", &cells)?;
        }
    }
    row(text, "all", "all", &all.iter().map(|(_, runs)| &runs[..]).collect::<Vec<_>>())
}

/// A row of the table: means over some cells.
fn row(text: &mut String, layout: &str, size: &str, cells: &[&[Run]]) -> std::fmt::Result {
    let reduction = |run: &Run| 100.0 * (1.0 - run.seeded as f64 / run.initial.max(1) as f64);
    let annealed = mean(cells.iter().map(|runs| mean(runs.iter().map(reduction))));
    let entries = (0..VARIANTS).map(|variant| {
        let saved = |run: &Run| run.saved(variant, (variant > 0).then_some(0));
        let groups: Vec<Vec<f64>> =
            cells.iter().map(|runs| runs.iter().map(saved).collect()).collect();
        let interval = Interval::of(&groups);
        format!("{interval}{}", if interval.excludes_zero() { " *" } else { "" })
    });
    let entries = entries.collect::<Vec<_>>().join(" | ");
    writeln!(text, "| {layout} | {size} | {annealed:.1} | {entries} |")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use super::*;

    #[test]
    fn variants_are_compared_run_by_run() {
        let run = |seed, crossings: [i64; 5]| Run {
            seed,
            initial: 50,
            seeded: 30,
            crossings: crossings.to_vec(),
        };
        // One-point saves 1 and 3 crossings of 50 beyond the first population, so 2 and 6 points;
        // window 2 and 3 crossings beyond that.
        let runs = vec![run(0, [29, 29, 28, 27, 29]), run(1, [27, 27, 28, 24, 27])];
        assert!((runs[0].saved(0, None) - 2.0).abs() < 1e-9);
        assert!((runs[0].saved(3, Some(0)) - 4.0).abs() < 1e-9);
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
