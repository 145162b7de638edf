//! Objectives and estimated lifts of many orders of one part.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_part::{Axis, Corner, LineOrder, Order, Pattern};
use beadwork_thermal::objective::{Objective, Settings, measure_plan};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use serde::Serialize;

use crate::heat_parts::HeatPart;
use crate::statistics::rank_correlation;

/// Sequences of lines, each along both axes.
const SEQUENCES: [&str; 15] = [
    "interleaved-2",
    "interleaved-3",
    "interleaved-4",
    "interleaved-5",
    "interleaved-7",
    "interleaved-10",
    "interleaved-13",
    "scattered-3",
    "scattered-4",
    "scattered-5",
    "scattered-7",
    "scattered-10",
    "scattered-13",
    "golden",
    "bit-reversed",
];

/// Objectives that are compared with the lift.
pub(super) const OBJECTIVES: [Objective; 4] =
    [Objective::Reward, Objective::NoTravel, Objective::TimeAveraged, Objective::Peak];

/// All orders of one part.
#[derive(Serialize)]
pub(super) struct OrderRows {
    pub(super) part: &'static str,
    pub(super) rows: Vec<OrderRow>,
    pub(super) correlations: Vec<Correlation>,
}

/// One order, used in all layers.
#[derive(Serialize)]
pub(super) struct OrderRow {
    pub(super) order: String,
    /// Costs by the [`OBJECTIVES`], K.
    pub(super) costs: [f64; 4],
    pub(super) lift_mm: f64,
    pub(super) print_seconds: f64,
}

/// Rank correlations of the costs with the lift.
#[derive(Serialize)]
pub(super) struct Correlation {
    /// The orders that are compared.
    pub(super) among: &'static str,
    pub(super) count: usize,
    /// One number for each of the [`OBJECTIVES`]: 1 if lower costs always lift less.
    pub(super) rank_correlations: [f64; 4],
}

/// Simulates one part with all orders.
pub(super) fn rows(
    part: HeatPart,
    method: Method,
    control: &Control<'_>,
) -> anyhow::Result<OrderRows> {
    let name = part.name();
    let voxels = Arc::new(part.voxels());
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let settings = Settings { warpage: true, sample_s: Some(0.5), ..Settings::default() };
    let own = control.on_one_thread().without_progress();
    let row = |order: &Order| {
        let plan = (0..voxels.depth)
            .map(|layer| Ok(order.order(&voxels.region(layer)?)))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let measures = measure_plan(&voxels, &material, &process, method, &plan, &settings, &own)?;
        let cost = |objective: Objective| objective.cost(&measures).unwrap_or(f64::NAN);
        Ok(OrderRow {
            order: order.to_string(),
            costs: OBJECTIVES.map(cost),
            lift_mm: cost(Objective::Warpage),
            print_seconds: measures.print_seconds(),
        })
    };
    let rows = control.threads.map(&orders(), row);
    let rows = rows.into_iter().collect::<anyhow::Result<Vec<OrderRow>>>()?;
    let correlations = [
        correlation("all orders", &rows, |_| true),
        correlation("the 38 patterns", &rows, |order| !order.starts_with("lines")),
        correlation("zigzag, raster and lines along x", &rows, |order| runs_along(order, "x")),
        correlation("zigzag, raster and lines along y", &rows, |order| runs_along(order, "y")),
    ];
    Ok(OrderRows { part: name, rows, correlations: correlations.into() })
}

/// The 38 patterns and the orders of lines, from corner 0.
fn orders() -> Vec<Order> {
    let lines = |axis: Axis| {
        SEQUENCES.map(|name| {
            let sequence = name.parse().expect("the sequence exists");
            Order::from(LineOrder { sequence, axis, corner: Corner::MinXMinY })
        })
    };
    let patterns = Pattern::ALL.map(Order::from);
    patterns.into_iter().chain(Axis::ALL.into_iter().flat_map(lines)).collect()
}

/// Whether all lines of an order run along an axis.
fn runs_along(order: &str, axis: &str) -> bool {
    let mut words = order.split('-');
    let is_lines = matches!(words.next(), Some("lines" | "zigzag" | "raster"));
    is_lines && words.next() == Some(axis)
}

fn correlation(
    among: &'static str,
    rows: &[OrderRow],
    is_among: impl Fn(&str) -> bool,
) -> Correlation {
    let rows: Vec<&OrderRow> = rows.iter().filter(|row| is_among(&row.order)).collect();
    let lifts: Vec<f64> = rows.iter().map(|row| row.lift_mm).collect();
    let of = |objective: usize| {
        let costs: Vec<f64> = rows.iter().map(|row| row.costs[objective]).collect();
        rank_correlation(&costs, &lifts)
    };
    Correlation { among, count: rows.len(), rank_correlations: [of(0), of(1), of(2), of(3)] }
}
