//! Compares a trained policy with planners that need no training, on random parts that the policy
//! was not trained on.
//!
//! ```text
//! cargo run --release -p beadwork-learn --example random_parts -- models/ppo-small 20
//! ```
//!
//! The arguments are the folder of the policy and the number of parts; a third one limits the
//! planners, as in `greedy,policy`.
//! All plan for the policy's objective; plans are measured by a simulation of high accuracy.
//! Prints one row for each plan, and the means.

#![allow(clippy::print_stdout, reason = "an example reports on the terminal")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use beadwork_base::{Control, Threads};
use beadwork_heat::candidates::OrderSet;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::plan::{HeatPlan, same_order};
use beadwork_heat::planner::{Annealing, Planner, Settings, plan};
use beadwork_learn::Device;
use beadwork_learn::ppo::{HeatPolicy, RandomHeatTask};
use beadwork_part::Order;
use beadwork_thermal::objective::{self, HeatMeasures, Objective, measure_plan};
use beadwork_thermal::simulation::{Accuracy, Method};

/// Seed of the first part: the policy was trained on seeds below it.
const FIRST: u64 = 1_000_000;

/// Limits on the printing time, relative to the conventional order's.
const LIMITS: [f64; 2] = [f64::INFINITY, 1.02];

/// How a part is planned; `None` for the policy.
type Way = (&'static str, Option<(Planner, OrderSet, Option<Annealing>)>);

fn ways() -> [Way; 5] {
    let patterns = |planner| Some((planner, OrderSet::Patterns, None));
    let lines = |annealing| Some((Planner::Lines, OrderSet::All, annealing));
    [
        ("constant", patterns(Planner::Constant)),
        ("greedy", patterns(Planner::Greedy)),
        ("policy", None),
        ("lines-not-annealed", lines(None)),
        ("lines", lines(Some(Annealing::default()))),
    ]
}

/// The results of a way on all parts: gains in reward and without travel, printing time, all in
/// percent of the conventional order's, and planning time in s.
#[derive(Default)]
struct Column {
    rows: Vec<[f64; 4]>,
}

impl Column {
    fn mean(&self, column: usize) -> f64 {
        self.rows.iter().map(|row| row[column]).sum::<f64>() / self.rows.len() as f64
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, count, rest @ ..] = arguments.as_slice() else {
        return Err("expected: folder of the policy, number of parts".into());
    };
    let chosen: Option<Vec<&str>> = rest.first().map(|names| names.split(',').collect());
    let is_chosen = |name: &str| chosen.as_ref().is_none_or(|chosen| chosen.contains(&name));
    let policy = HeatPolicy::open(Path::new(folder), Device::Cpu)?;
    let cost = LayerCost::of(policy.task.objective)?;
    let task =
        RandomHeatTask::new(policy.task.orders.orders(), cost.clone(), policy.task.settings(None));
    let control = Control::on(Threads::Current);
    println!("| part | limit | planner | gain % | no travel % | time % | planning s |");
    println!("|---|---|---|---|---|---|---|");
    let mut columns: Vec<Column> =
        LIMITS.iter().flat_map(|_| ways()).map(|_| Column::default()).collect();
    for seed in FIRST..FIRST + count.parse::<u64>()? {
        let part = Arc::new(task.part(seed)?);
        let RandomHeatTask { material, process, .. } = &task;
        let unprinted = Solver::new(part.clone(), material, process, task.method, cost.clone())?;
        let measure = |plan: &HeatPlan| -> Result<HeatMeasures, Box<dyn Error>> {
            let (method, settings) = (Method::Fast(Accuracy::High), objective::Settings::default());
            let orders = plan.paths();
            Ok(measure_plan(&part, material, process, method, &orders, &settings, &control)?)
        };
        let conventional = same_order(&unprinted, Order::CONVENTIONAL, &control)?;
        let baseline = measure(&conventional)?;
        let both = LIMITS.iter().flat_map(|limit| ways().map(|way| (limit, way)));
        for ((limit, (name, way)), column) in both.zip(&mut columns) {
            // Without a limit, orders of lines have no reason not to travel.
            let is_lines = name.starts_with("lines");
            if !is_chosen(name) || is_lines && limit.is_infinite() {
                continue;
            }
            let max_seconds = limit * conventional.seconds();
            let begin = Instant::now();
            let plan = match way {
                None => policy.plan(&unprinted, max_seconds, &control)?,
                Some((planner, orders, annealing)) => {
                    let orders = orders.orders();
                    let settings =
                        Settings { planner, orders, max_seconds, annealing, ..Settings::default() };
                    plan(&unprinted, &settings, &control)?
                }
            };
            let seconds = begin.elapsed().as_secs_f64();
            let measures = measure(&plan)?;
            let gain = |objective: Objective| {
                objective.gain_percent(&measures, &baseline).unwrap_or(f64::NAN)
            };
            let longer = 100.0 * (measures.print_seconds() / baseline.print_seconds() - 1.0);
            let row = [gain(Objective::Reward), gain(Objective::NoTravel), longer, seconds];
            print_row(&seed.to_string(), *limit, name, row);
            column.rows.push(row);
        }
    }
    let both = LIMITS.iter().flat_map(|limit| ways().map(|(name, _)| (limit, name)));
    for ((limit, name), column) in both.zip(&columns).filter(|(_, column)| !column.rows.is_empty())
    {
        print_row("mean", *limit, name, [0, 1, 2, 3].map(|index| column.mean(index)));
    }
    for (limit, columns) in LIMITS.iter().zip(columns.chunks(ways().len())) {
        let (greedy, policy) = (&columns[1], &columns[2]);
        if greedy.rows.is_empty() || policy.rows.is_empty() {
            continue;
        }
        let shares: Vec<f64> =
            policy.rows.iter().zip(&greedy.rows).map(|(p, g)| 100.0 * p[0] / g[0]).collect();
        println!(
            "limit {limit}: policy gains {:.1} % of what greedy gains; by part: mean {:.1} %, \
             lowest {:.1} %",
            100.0 * policy.mean(0) / greedy.mean(0),
            shares.iter().sum::<f64>() / shares.len() as f64,
            shares.iter().copied().fold(f64::INFINITY, f64::min),
        );
    }
    Ok(())
}

fn print_row(part: &str, limit: f64, name: &str, [gain, no_travel, time, seconds]: [f64; 4]) {
    let limit = if limit.is_finite() {
        format!("{:+.0} %", 100.0 * (limit - 1.0))
    } else {
        "none".to_owned()
    };
    println!(
        "| {part} | {limit} | {name} | {gain:.2} | {no_travel:.2} | {time:+.2} | {seconds:.2} |"
    );
}
