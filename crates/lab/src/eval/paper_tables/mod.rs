//! The tables of Aali et al. by every method, with ours beside them.

mod figures;
mod tables;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_console::search::{Breeding, Choice, Row, Search};
use beadwork_console::{cancel, control, machine, output};
use beadwork_grid::{Crossings, LayoutSpec, Region, Start};
use beadwork_search::anneal::Preset;
use beadwork_search::bound::Bounds;
use beadwork_search::genetic::{self, Seeding};
use beadwork_search::{Move, exact};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::ZonesArgs;
use super::store::Store;
use crate::paper::{self, AVERAGED, Cell};

/// What all methods came to on the instances of one cell.
struct Runs {
    cell: Cell,
    rows: Vec<Tagged>,
}

/// A row with what its instance was drawn from.
#[derive(Serialize, Deserialize)]
struct Tagged {
    instance_seed: u64,
    #[serde(flatten)]
    row: Row,
}

/// A column of a table: some of the rows.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Zigzag,
    /// Annealing by one preset.
    Anneal(Preset),
    /// By any preset of the paper.
    AnnealPaper,
    /// By those of [`AVERAGED`].
    AnnealAveraged,
    Genetic(genetic::Preset),
    /// By any preset.
    GeneticAny,
    AnnealAny,
    Exact,
}

impl Column {
    fn holds(self, row: &Row) -> bool {
        let (method, preset) = (row.method.as_str(), row.preset.as_deref().unwrap_or_default());
        match self {
            Self::Zigzag => method == "zigzag",
            Self::Anneal(asked) => method == "anneal" && preset == asked.name(),
            Self::AnnealPaper => method == "anneal" && preset != Preset::Fast.name(),
            Self::AnnealAveraged => {
                AVERAGED.iter().any(|&averaged| Self::Anneal(averaged).holds(row))
            }
            Self::AnnealAny => method == "anneal",
            Self::Genetic(asked) => method == "genetic" && preset == asked.name(),
            Self::GeneticAny => method == "genetic",
            Self::Exact => method == "exact",
        }
    }
}

impl Runs {
    fn column(&self, column: Column) -> impl Iterator<Item = &Row> {
        self.rows.iter().map(|tagged| &tagged.row).filter(move |row| column.holds(row))
    }

    /// Largest reduction in %; not a number if the column is empty.
    fn best(&self, column: Column) -> f64 {
        self.column(column).map(Row::reduction).fold(f64::NAN, f64::max)
    }

    /// Mean of some number; not a number if the column is empty.
    fn mean(&self, column: Column, value: impl Fn(&Row) -> f64) -> f64 {
        super::statistics::mean(self.column(column).map(value))
    }

    /// How many instances there are.
    fn instances(&self) -> usize {
        let mut seeds: Vec<u64> = self.rows.iter().map(|tagged| tagged.instance_seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds.len()
    }
}

pub(super) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(if args.smoke { 1 } else { 10 });
    let usual = if args.smoke { "datasets/eval-zones-smoke" } else { "datasets/eval-zones" };
    let out = args.out.as_deref().unwrap_or(Path::new(usual));
    let presets: &[genetic::Preset] = if args.smoke {
        &[genetic::Preset::Short]
    } else {
        &[genetic::Preset::Paper, genetic::Preset::Window, genetic::Preset::Fast]
    };
    let mut cells: Vec<Cell> = paper::cells().collect();
    if args.smoke {
        cells.retain(|cell| cell.size.width * cell.size.height == 900);
    }
    let pool = args.pool()?;
    let threads = pool.current_num_threads();
    let settings =
        json!({ "eval": "zones", "seeds": seeds, "smoke": args.smoke, "threads": threads });
    let store = Store::open(out, &settings)?;
    let mut jobs = Vec::new();
    for &cell in &cells {
        let matching = cell.matching_seeds(seeds)?;
        jobs.extend((0..seeds).map(|seed| (cell, seed, matching[seed as usize % matching.len()])));
    }
    let begin = Instant::now();
    let name = |(cell, seed, _): &(Cell, u64, u64)| format!("{}-{}-{seed}", cell.layout, cell.size);
    let parts = store.parts(&pool, &jobs, name, |(cell, seed, instance_seed)| {
        let rows = every_method(cell, *seed, *instance_seed, presets)?.into_iter();
        Ok(rows.map(|row| Tagged { instance_seed: *instance_seed, row }).collect::<Vec<Tagged>>())
    })?;
    let now = begin.elapsed().as_secs_f64();
    let seconds: f64 = parts.iter().map(|(_, seconds)| seconds).sum();
    let mut rows = parts.into_iter().map(|(rows, _)| rows);
    let all: Vec<Runs> = cells
        .into_iter()
        .map(|cell| Runs { cell, rows: rows.by_ref().take(seeds as usize).flatten().collect() })
        .collect();

    let mut text = format!("Machine: {}. Seeds 0..{seeds}.\n", machine::one_line(store.machine()));
    writeln!(
        text,
        "{seconds:.0} s of searches on {threads} threads; {now:.0} s in this run, {} of {} instances kept from earlier ones.",
        store.kept(),
        jobs.len()
    )?;
    tables::markdown(&mut text, &all, presets)?;
    let document = json!({
        "machine": store.machine(), "seeds": seeds, "threads": threads, "search_seconds": seconds, "seconds_now": now,
        "kept": store.kept(),
        "cells": all.iter().map(|runs| tables::summary(runs, presets)).collect::<Vec<_>>(),
        "rows": all.iter().flat_map(|runs| &runs.rows).map(|row| json!(row)).collect::<Vec<Value>>(),
    });
    store.result("zones.md", &text)?;
    store.result("zones.json", &format!("{document:#}\n"))?;
    store.result("convergence.svg", &figures::convergence(&all, presets)?)?;
    store.result("heat_map.svg", &figures::heat_maps(&all, presets)?)?;
    if args.json {
        return output::json(&document);
    }
    output::text(&text)?;
    output::text(&format!("\nTables and pictures are in '{}'.\n", out.display()))
}

/// Runs all methods on one instance.
fn every_method(
    cell: &Cell,
    seed: u64,
    instance_seed: u64,
    presets: &[genetic::Preset],
) -> anyhow::Result<Vec<Row>> {
    let region = &Region::rectangle(cell.size.width, cell.size.height)?;
    let zones = &LayoutSpec::new(cell.layout).zones(region, instance_seed)?;
    let start = Start::RowZigzag;
    let path = start.path(region, &Control::default())?;
    let bounds =
        Some(control::quiet(Threads::One, |control| Bounds::new(region, zones, control))??);
    let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
    // Presets with the same annealing runs share them.
    let mut populations: Vec<(Seeding, Vec<Vec<Move>>, f64)> = Vec::new();
    for &preset in presets {
        let proven_bound = bounds.map(|bounds| i64::from(bounds.crossings()));
        let settings =
            genetic::Settings { proven_bound, ..genetic::Settings::preset(preset, seed) };
        if populations.iter().all(|(made, ..)| *made != settings.seeding) {
            let begin = Instant::now();
            let crossings = Crossings::new(region, zones);
            let population = genetic::annealed(&path, &crossings, &settings, &control);
            populations.push((settings.seeding, population, begin.elapsed().as_secs_f64()));
        }
    }
    let search = |choice| {
        let search = Search { region, zones, choice, seed, start, bounds };
        Ok::<Row, anyhow::Error>(search.run(cell.layout.name(), &path, &Control::default())?.1)
    };
    let mut rows = vec![search(Choice::Zigzag)?];
    for preset in Preset::ALL {
        rows.push(search(Choice::Anneal(preset))?);
    }
    for &preset in presets {
        let (seeding, _) = preset.parameters();
        let (_, population, seconds) = populations
            .iter()
            .find(|(made, ..)| *made == seeding)
            .expect("there is a population for each preset");
        let population = Some((&population[..], *seconds));
        let mut row = search(Choice::Genetic(Breeding { preset, population }))?;
        if let Some(genetic) = &mut row.genetic {
            let last = genetic.history.len() as u32 - 1;
            genetic.history.retain(|it| it.number == last || is_milestone(it.number));
        }
        rows.push(row);
    }
    rows.push(search(Choice::Exact(exact::Settings::default()))?);
    // The exact search may prove more than the bounds alone.
    // What is proven holds for all.
    let bound = rows.iter().filter_map(|row| row.bound).reduce(f64::max);
    rows.iter_mut().for_each(|row| row.bound = bound);
    Ok(rows)
}

/// Generations that are kept for the plots: each about half as many again as the one before.
fn is_milestone(generation: u32) -> bool {
    let mut milestone = 0;
    while milestone < generation {
        milestone += milestone.div_ceil(2).max(1);
    }
    milestone == generation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milestones_grow_by_half() {
        let milestones: Vec<u32> =
            (0..=500).filter(|&generation| is_milestone(generation)).collect();
        assert_eq!(milestones[..8], [0, 1, 2, 3, 5, 8, 12, 18]);
        assert!(milestones.len() < 20);
    }
}
