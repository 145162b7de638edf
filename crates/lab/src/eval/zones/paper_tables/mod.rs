//! Tables 1, 3 and 5 of Aali et al. by every method, next to the paper's figures.

mod figures;
mod runs;
mod solve;
mod tables;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use beadwork_console::{machine, output};
use beadwork_search::genetic::Preset;
use serde_json::json;

use self::runs::{InstanceRow, Runs};
use crate::eval::store::Store;
use crate::eval::zones::args::ZonesArgs;
use crate::paper::{self, Cell};

/// The searches to run on one instance.
struct Job {
    cell: Cell,
    /// Seed of the searches.
    seed: u64,
    instance_seed: u64,
}

/// Runs all searches, and writes tables and figures to the output folder and stdout.
pub(in crate::eval::zones) fn run(args: &ZonesArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.unwrap_or(if args.smoke { 1 } else { 10 });
    let default = if args.smoke { "datasets/eval-zones-smoke" } else { "datasets/eval-zones" };
    let out = args.out.as_deref().unwrap_or(Path::new(default));
    let presets: &[Preset] =
        if args.smoke { &[Preset::Short] } else { &[Preset::Paper, Preset::Window, Preset::Fast] };
    let mut cells: Vec<Cell> = paper::cells().collect();
    if args.smoke {
        cells.retain(|cell| cell.size.width * cell.size.height == 900);
    }
    let pool = args.pool()?;
    let threads = pool.current_num_threads();
    let settings =
        json!({ "eval": "zones", "seeds": seeds, "smoke": args.smoke, "threads": threads });
    let store = Store::open(out, &settings)?;
    let jobs = jobs(&cells, seeds)?;
    let begin = Instant::now();
    let results = store.results(&pool, &jobs, Job::name, |job| job.run(presets))?;
    let seconds_now = begin.elapsed().as_secs_f64();
    let search_seconds: f64 = results.iter().map(|(_, seconds)| seconds).sum();
    // Jobs are sorted by cell, with the same number of seeds for each.
    let mut results = results.into_iter().map(|(rows, _)| rows);
    let all: Vec<Runs> = cells
        .into_iter()
        .map(|cell| Runs { cell, rows: results.by_ref().take(seeds as usize).flatten().collect() })
        .collect();

    let mut text = format!("Machine: {}. Seeds 0..{seeds}.\n", machine::one_line(store.machine()));
    writeln!(
        text,
        "{search_seconds:.0} s of searches on {threads} threads. This run took {seconds_now:.0} s \
         and loaded the results of {} of {} instances from earlier runs.",
        store.loaded(),
        jobs.len()
    )?;
    tables::markdown(&mut text, &all, presets)?;
    let document = json!({
        "machine": store.machine(), "seeds": seeds, "threads": threads,
        "search_seconds": search_seconds, "seconds_now": seconds_now, "kept": store.loaded(),
        "cells": all.iter().map(|runs| tables::summary(runs, presets)).collect::<Vec<_>>(),
        "rows": all.iter().flat_map(|runs| &runs.rows).collect::<Vec<_>>(),
    });
    store.write("zones.md", &text)?;
    store.write("zones.json", &format!("{document:#}\n"))?;
    store.write("convergence.svg", &figures::convergence(&all, presets)?)?;
    store.write("heat_map.svg", &figures::heat_maps(&all, presets)?)?;
    if args.json {
        return output::json(&document);
    }
    output::text(&text)?;
    output::text(&format!("\nTables and figures are in '{}'.\n", out.display()))
}

/// One job for each cell and seed, on instances like the paper's, sorted by cell.
fn jobs(cells: &[Cell], seeds: u64) -> anyhow::Result<Vec<Job>> {
    let mut jobs = Vec::new();
    for &cell in cells {
        let matching = cell.matching_seeds(seeds)?;
        jobs.extend((0..seeds).map(|seed| {
            let instance_seed = matching[seed as usize % matching.len()];
            Job { cell, seed, instance_seed }
        }));
    }
    Ok(jobs)
}

impl Job {
    /// Name of the file in which the result is stored.
    fn name(&self) -> String {
        format!("{}-{}-{}", self.cell.layout, self.cell.size, self.seed)
    }

    fn run(&self, presets: &[Preset]) -> anyhow::Result<Vec<InstanceRow>> {
        let instance_seed = self.instance_seed;
        let rows = solve::every_method(&self.cell, self.seed, instance_seed, presets)?;
        Ok(rows.into_iter().map(|row| InstanceRow { instance_seed, row }).collect())
    }
}
