//! Travel of planned layers beside that of long searches.

use std::fmt::Write;
use std::path::Path;
use std::slice::from_ref;
use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_console::part::PartArgs;
use beadwork_console::printer::Profile;
use beadwork_part::toolpath::{self, Island};
use beadwork_search::plan::beads::{self, Settings};
use beadwork_search::travel::Order;
use beadwork_search::{CostMatrix, Stop};
use rayon::ThreadPool;
use serde::Serialize;

/// Maximum number of layers of a part.
const LAYERS: usize = 20;

/// Runs of the long search, with different seeds.
const LONG_RUNS: u64 = 10;

/// Kicks of the long search for each bead, an order of magnitude more than those of a plan.
const LONG_KICKS: u32 = 100;

/// The layers of a part in one kind of order.
#[derive(Clone, Serialize)]
pub(super) struct Row {
    part: String,
    order: &'static str,
    layers: usize,
    /// Mean number of beads of a layer.
    beads: f64,
    /// Travel of the plan, relative to the shortest of all long runs of that layer: mean.
    mean_ratio: f64,
    /// The same of the worst layer.
    max_ratio: f64,
    /// Time of the plan for each layer in s, with linking: mean.
    seconds: f64,
    /// Time of one long run for each layer in s.
    long_seconds: f64,
}

/// Orders layers spread evenly over the height of a part, each for itself.
pub(super) fn measure(path: &Path, pool: &ThreadPool) -> anyhow::Result<Vec<Row>> {
    let cut = PartArgs::usual(path.into()).cut(Profile::for_tables().bed_mm(), pool)?;
    let toolpath = toolpath::Settings::default();
    let part = cut.into_beads(&toolpath, Threads::Pool(pool))?;
    let count = part.islands.len();
    let chosen: Vec<&Vec<Island>> = if count > LAYERS {
        (0..LAYERS).map(|number| &part.islands[number * (count - 1) / (LAYERS - 1)]).collect()
    } else {
        part.islands.iter().collect()
    };
    let costs = CostMatrix::uniform(part.model.materials.len().max(1));
    let mut rows = Vec::new();
    for (name, order) in [("islands", Order::Stages), ("free", Order::Free)] {
        let plan = |islands: &Vec<Island>, kicks: Option<u32>, seed: u64| {
            let settings = Settings { order, seed, ..Settings::default() };
            let kicks_per_bead = kicks.unwrap_or(settings.kicks_per_bead);
            let settings = Settings { kicks_per_bead, ..settings };
            let control = control::cancellable(Threads::One)?;
            let begin = Instant::now();
            let plan = beads::solve(from_ref(islands), &toolpath, &costs, &settings, &control)?;
            let seconds = begin.elapsed().as_secs_f64();
            if plan.stop == Stop::Cancelled {
                control.check()?;
            }
            anyhow::Ok((plan.travel_mm, plan.total().beads, seconds))
        };
        let layer = |islands: &&Vec<Island>| {
            let (travel_mm, beads, seconds) = plan(islands, None, 0)?;
            let long = (1..=LONG_RUNS).map(|seed| plan(islands, Some(LONG_KICKS), seed));
            let long = long.collect::<anyhow::Result<Vec<_>>>()?;
            let best_mm = long.iter().map(|run| run.0).fold(f64::INFINITY, f64::min);
            let ratio = if travel_mm > 0.0 { travel_mm / best_mm } else { 1.0 };
            let long_seconds = long.iter().map(|run| run.2).sum::<f64>() / LONG_RUNS as f64;
            anyhow::Ok([ratio, beads as f64, seconds, long_seconds])
        };
        let layers = control::quiet(Threads::Pool(pool), |control| {
            control.threads.map(&chosen, |islands| layer(islands))
        })?;
        let layers = layers.into_iter().collect::<anyhow::Result<Vec<_>>>()?;
        let mean = |at: usize| layers.iter().map(|row| row[at]).sum::<f64>() / layers.len() as f64;
        rows.push(Row {
            part: part.name.clone(),
            order: name,
            layers: layers.len(),
            beads: mean(1),
            mean_ratio: mean(0),
            max_ratio: layers.iter().map(|row| row[0]).fold(0.0, f64::max),
            seconds: mean(2),
            long_seconds: mean(3),
        });
    }
    Ok(rows)
}

pub(super) fn table(rows: &[Row]) -> Result<String, std::fmt::Error> {
    let mut text = format!(
        "Travel of each layer, relative to the best of {LONG_RUNS} runs with {LONG_KICKS} kicks \
         for each bead.\n\n\
         | part | order | layers | beads of a layer | mean | worst | plan, ms | long run, ms |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    for row in rows {
        writeln!(
            text,
            "| {} | {} | {} | {:.0} | {:.4} | {:.4} | {:.1} | {:.1} |",
            row.part,
            row.order,
            row.layers,
            row.beads,
            row.mean_ratio,
            row.max_ratio,
            1e3 * row.seconds,
            1e3 * row.long_seconds,
        )?;
    }
    Ok(text)
}
