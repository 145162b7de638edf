//! `eval thermal`: how much the pattern of deposition is worth, on parts like the paper's three.

mod table;

use std::sync::Arc;

use beadwork_base::{Control, Threads};
use beadwork_console::accuracy::AccuracyName;
use beadwork_console::{cancel, control, machine, output, progress};
use beadwork_grid::Cell;
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use beadwork_thermal::section::Plane;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::warpage::WarpageEstimator;
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use rayon::ThreadPool;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;

use crate::heat_parts::{HeatPart, all_orders};

/// Rewards of the 38 patterns on parts like the paper's three, beside its figures.
///
/// The reward of a layer is the standard deviation of the temperatures of all voxels deposited so
/// far, at the layer's end, with its sign turned; that of a part is the sum (Kim et al. 2026).
/// Each part is printed in ABS at the paper's settings: with one pattern in all its layers, with
/// each of the 38 in turn; and greedily, each layer with the pattern that leaves it at its most
/// even.
/// The paper does not give its parts' sizes: ours are rectangular 120 x 40 x 12, a U of 90 x 50 x
/// 12 and a pyramid of 77 layers, 60 x 60 at its foot, so gains can be compared, rewards can't.
///
/// Examples: beadwork eval thermal beadwork eval thermal --part u --json > u.json
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct ThermalArgs {
    /// Parts: the paper's three if not given.
    #[arg(long, value_name = "PART")]
    part: Vec<HeatPart>,
    /// How exact the solver is.
    #[arg(long, value_name = "NAME", default_value = "standard")]
    accuracy: AccuracyName,
    /// Threads; 0 for one a core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// What one part is worth in one way to print it.
#[derive(Clone, Serialize)]
struct Printed {
    /// The pattern of all layers, or `greedy`.
    pattern: String,
    /// Minus the sum of the layers' standard deviations, K.
    reward: f64,
    print_seconds: f64,
    /// Largest difference between the mean and a voxel on the upright section through the middle,
    /// K, once the nozzle has left the finished part for [`REST_S`].
    deviation_k: f64,
}

/// All ways to print one part.
#[derive(Serialize)]
struct PartRow {
    part: &'static str,
    voxels: usize,
    layers: usize,
    /// The 38 patterns in the order of their numbers.
    patterns: Vec<Printed>,
    greedy: Printed,
    /// The greedy pattern of each layer.
    greedy_patterns: Vec<&'static str>,
    /// Estimated corner lifts of the conventional, the best single and the greedy plan, mm.
    lifts_mm: [f64; 3],
    seconds: f64,
}

impl PartRow {
    fn conventional(&self) -> &Printed {
        &self.patterns[Pattern::CONVENTIONAL.number()]
    }

    /// The number of the best of one pattern in all layers.
    fn best_number(&self) -> usize {
        let reward = |number: usize| self.patterns[number].reward;
        (0..Pattern::COUNT)
            .max_by(|&a, &b| reward(a).total_cmp(&reward(b)))
            .expect("there are 38 patterns")
    }

    fn best(&self) -> &Printed {
        &self.patterns[self.best_number()]
    }
}

pub(super) fn run(args: &ThermalArgs) -> anyhow::Result<()> {
    let parts = if args.part.is_empty() { &HeatPart::PAPER[..] } else { &args.part };
    let pool = control::pool(args.threads)?;
    let bench = Bench {
        method: Method::Fast(args.accuracy.into()),
        material: ThermalMaterial::abs(),
        process: ProcessParameters::default(),
    };
    let rows =
        parts.iter().map(|&part| bench.part(part, &pool)).collect::<anyhow::Result<Vec<_>>>()?;
    if args.json {
        let threads = pool.current_num_threads();
        return output::json(
            &json!({ "machine": machine::facts(), "threads": threads, "parts": rows }),
        );
    }
    output::text(&table::text(&rows)?)
}

/// What all parts are printed with.
struct Bench {
    method: Method,
    material: ThermalMaterial,
    process: ProcessParameters,
}

/// Seconds from the end of a print to its thermal deviation.
/// With the nozzle still on the part, the deviation would tell only how near the last voxel is to
/// the section.
const REST_S: f64 = 1.0;

/// Seconds between the looks of the warpage estimate.
const LOOK_S: f64 = 0.5;

impl Bench {
    fn part(&self, which: HeatPart, pool: &ThreadPool) -> anyhow::Result<PartRow> {
        let begin = std::time::Instant::now();
        let part = Arc::new(which.voxels());
        let orders = all_orders(&part)?;
        let cancel = Some(cancel::token()?);
        let bar = progress::bar((Pattern::COUNT + part.depth) as u64, which.name());
        let plan_of = |number: usize| {
            orders.iter().map(|orders| &orders[number][..]).collect::<Vec<&[Cell]>>()
        };
        let one = |&pattern: &Pattern| -> anyhow::Result<Printed> {
            let printed = self.print(&part, pattern.name(), &plan_of(pattern.number()))?;
            bar.inc(1);
            Ok(printed)
        };
        let patterns =
            pool.install(|| Pattern::ALL.par_iter().map(one).collect::<anyhow::Result<Vec<_>>>())?;
        let mut simulation =
            Simulation::new(part.clone(), &self.material, &self.process, self.method)?;
        let mut greedy_patterns = Vec::new();
        for (layer, orders) in orders.iter().enumerate() {
            let even = |end: &Simulation| end.statistics().map_or(f64::INFINITY, |all| all.std_c);
            let control = Control { cancel, ..Control::on(Threads::Pool(pool)) };
            let deviations = simulation.try_orders(layer as u32, orders, even, &control)?;
            let best = (0..Pattern::COUNT)
                .min_by(|&a, &b| deviations[a].total_cmp(&deviations[b]))
                .expect("there are 38 patterns");
            simulation.deposit(layer as u32, &orders[best], &control)?;
            greedy_patterns.push(Pattern::ALL[best]);
            bar.inc(1);
        }
        bar.finish_and_clear();
        let chosen: Vec<&[Cell]> = orders
            .iter()
            .zip(&greedy_patterns)
            .map(|(orders, best)| &orders[best.number()][..])
            .collect();
        let mut row = PartRow {
            part: which.name(),
            voxels: part.count(),
            layers: part.depth,
            greedy: self.print(&part, "greedy", &chosen)?,
            patterns,
            greedy_patterns: greedy_patterns.iter().map(|pattern| pattern.name()).collect(),
            lifts_mm: [0.0; 3],
            seconds: 0.0,
        };
        let plans = [plan_of(Pattern::CONVENTIONAL.number()), plan_of(row.best_number()), chosen];
        let lifts = pool
            .install(|| plans.par_iter().map(|plan| self.lift_mm(&part, plan)).collect::<Vec<_>>());
        for (lift, own) in lifts.into_iter().zip(&mut row.lifts_mm) {
            *own = lift?;
        }
        row.seconds = begin.elapsed().as_secs_f64();
        Ok(row)
    }

    fn print(
        &self,
        part: &Arc<Voxels>,
        pattern: &str,
        plan: &[&[Cell]],
    ) -> anyhow::Result<Printed> {
        let mut simulation =
            Simulation::new(part.clone(), &self.material, &self.process, self.method)?;
        let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
        let mut reward = 0.0;
        for (layer, order) in plan.iter().enumerate() {
            simulation.deposit(layer as u32, order, &control)?;
            reward -= simulation.statistics().map_or(0.0, |all| all.std_c);
        }
        let print_seconds = simulation.seconds();
        simulation.pause(REST_S, &control)?;
        let section = simulation.section(Plane::Y(part.frame.height / 2));
        Ok(Printed {
            pattern: pattern.to_owned(),
            reward,
            print_seconds,
            deviation_k: section.max_deviation_k().unwrap_or(0.0),
        })
    }

    fn lift_mm(&self, part: &Arc<Voxels>, plan: &[&[Cell]]) -> anyhow::Result<f64> {
        let mut simulation =
            Simulation::new(part.clone(), &self.material, &self.process, self.method)?;
        let control = Control { cancel: Some(cancel::token()?), ..Control::default() };
        let mut warpage = WarpageEstimator::new(part, &self.material);
        for (layer, order) in plan.iter().enumerate() {
            let events = simulation.layer_events(layer as u32, order);
            let sample = |simulation: &Simulation| warpage.sample(simulation);
            simulation.run_sampled(&events, LOOK_S, sample, &control)?;
        }
        Ok(warpage.finish(&simulation, &control)?.corner_lift_mm)
    }
}
