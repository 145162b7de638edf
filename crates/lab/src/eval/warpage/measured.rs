//! Simulated prints of the published measurements.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_heat::model::{LayerCost, Solver};
use beadwork_heat::trials::try_orders;
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::warpage::{WarpageEstimate, WarpageEstimator};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use serde::Serialize;

use super::published::{Case, Measured, Plan, block, publications};
use crate::heat_parts::{all_orders, orders};
use crate::statistics::rank_correlation;

/// All publications, and how often the estimate orders their cases as they were measured.
#[derive(Serialize)]
pub(super) struct MeasuredTable {
    pub(super) publications: Vec<PublicationRows>,
    pub(super) pairs: Pairs,
}

/// The cases of one publication.
#[derive(Serialize)]
pub(super) struct PublicationRows {
    pub(super) source: &'static str,
    pub(super) note: &'static str,
    pub(super) cases: Vec<MeasuredRow>,
    /// Spearman's rank correlation of the estimate with the measurements.
    pub(super) rank_correlation: f64,
    pub(super) pairs: Pairs,
}

/// One measured print and its estimate.
#[derive(Serialize)]
pub(super) struct MeasuredRow {
    pub(super) case: &'static str,
    pub(super) measured: Measured,
    pub(super) lift_mm: f64,
    /// Mean curvatures along x and y, 1/m.
    pub(super) curvatures_1_m: [f64; 2],
}

/// Pairs of cases of one publication whose measurements differ.
#[derive(Clone, Copy, Default, Serialize)]
pub(super) struct Pairs {
    /// Pairs that the estimate orders as measured.
    pub(super) agree: usize,
    pub(super) all: usize,
}

/// A block of one height.
#[derive(Serialize)]
pub(super) struct HeightRow {
    pub(super) layers: u32,
    pub(super) lift_mm: f64,
    pub(super) curvature_1_m: f64,
}

/// Simulates all published cases.
pub(super) fn rows(method: Method, control: &Control<'_>) -> anyhow::Result<MeasuredTable> {
    let published = publications();
    let cases: Vec<&Case> = published.iter().flat_map(|publication| &publication.cases).collect();
    let own = control.on_one_thread().without_progress();
    let estimate = |case: &&Case| {
        let part = Arc::new(case.part.clone());
        let plan = match case.plan {
            Plan::Constant(pattern) => orders(&part, pattern)?,
            Plan::Even => even_plan(&part, &case.process, method, &own)?,
        };
        warpage(&part, &case.process, method, &plan, case.sample_s, &own)
    };
    let estimates = control.threads.map(&cases, estimate);
    let mut estimates = estimates.into_iter().collect::<anyhow::Result<Vec<_>>>()?.into_iter();
    let (mut all_pairs, mut rows) = (Pairs::default(), Vec::new());
    for publication in published {
        let row = |case: &Case, estimate: WarpageEstimate| MeasuredRow {
            case: case.name,
            measured: case.measured,
            lift_mm: estimate.corner_lift_mm,
            curvatures_1_m: estimate.axis_curvatures_1_m,
        };
        let cases: Vec<MeasuredRow> = publication
            .cases
            .iter()
            .zip(estimates.by_ref())
            .map(|(case, estimate)| row(case, estimate))
            .collect();
        let pairs = pairs(&cases);
        all_pairs.agree += pairs.agree;
        all_pairs.all += pairs.all;
        let measured: Vec<f64> = cases.iter().map(|case| case.measured.value()).collect();
        let lifts: Vec<f64> = cases.iter().map(|case| case.lift_mm).collect();
        rows.push(PublicationRows {
            source: publication.source,
            note: publication.note,
            rank_correlation: rank_correlation(&lifts, &measured),
            cases,
            pairs,
        });
    }
    Ok(MeasuredTable { publications: rows, pairs: all_pairs })
}

fn pairs(cases: &[MeasuredRow]) -> Pairs {
    let mut pairs = Pairs::default();
    for (number, a) in cases.iter().enumerate() {
        for b in &cases[..number] {
            let measured = a.measured.value().total_cmp(&b.measured.value());
            if measured.is_ne() {
                pairs.all += 1;
                pairs.agree += usize::from(measured == a.lift_mm.total_cmp(&b.lift_mm));
            }
        }
    }
    pairs
}

/// Estimates blocks of 60 x 20 mm with the paper's settings, in the conventional order.
pub(super) fn heights(method: Method, control: &Control<'_>) -> anyhow::Result<Vec<HeightRow>> {
    let own = control.on_one_thread().without_progress();
    let estimate = |&layers: &u32| {
        let part = Arc::new(block([120, 40, layers], [0.5, 0.25]));
        let plan = orders(&part, Pattern::CONVENTIONAL)?;
        let estimate = warpage(&part, &ProcessParameters::default(), method, &plan, 0.5, &own)?;
        let (lift_mm, curvature_1_m) = (estimate.corner_lift_mm, estimate.curvature_1_m);
        Ok(HeightRow { layers, lift_mm, curvature_1_m })
    };
    control.threads.map(&[32, 16, 12, 8, 4, 3, 2, 1], estimate).into_iter().rev().collect()
}

/// Chooses for each layer, from the bottom up, the pattern after which the standard deviation of
/// all temperatures is smallest.
fn even_plan(
    part: &Arc<Voxels>,
    process: &ProcessParameters,
    method: Method,
    control: &Control<'_>,
) -> anyhow::Result<Vec<Vec<Cell>>> {
    let cost = LayerCost::of(Objective::Reward)?;
    let mut model = Solver::new(part.clone(), &ThermalMaterial::abs(), process, method, cost)?;
    let mut plan = Vec::new();
    for (layer, mut orders) in (0..).zip(all_orders(part)?) {
        let trials = try_orders(&model, layer, &orders, 1, |_, cost| cost, control)?;
        trials.interrupted.map_or(Ok(()), Err)?;
        let best = trials.best.into_iter().next().expect("patterns were tried");
        plan.push(orders.swap_remove(best.index));
        model = best.model;
    }
    Ok(plan)
}

fn warpage(
    part: &Arc<Voxels>,
    process: &ProcessParameters,
    method: Method,
    plan: &[Vec<Cell>],
    sample_s: f64,
    control: &Control<'_>,
) -> anyhow::Result<WarpageEstimate> {
    let material = ThermalMaterial::abs();
    let mut simulation = Simulation::new(part.clone(), &material, process, method)?;
    let mut warpage = WarpageEstimator::new(part, &material);
    for (layer, order) in (0..).zip(plan) {
        let events = simulation.layer_events(layer, order);
        simulation.run_sampled(&events, sample_s, |print| warpage.sample(print), control)?;
    }
    Ok(warpage.finish(&simulation, control)?)
}
