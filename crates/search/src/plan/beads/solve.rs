//! Plans all layers of a part.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::Control;
use beadwork_part::toolpath::{Island, Settings as ToolpathSettings};
use thiserror::Error;

use super::layer::{LayerPlanner, PlannedLayer};
use super::outcome::BeadPlan;
use super::rectangle::Rectangle;
use super::seam::seams;
use super::settings::Settings;
use crate::link::LinksError;
use crate::plan::{OrderError, fixed_order_cost, order};
use crate::travel::TravelError;
use crate::{CostMatrix, Stop};

/// Number of layers that are planned one after the other, so that each continues where the one
/// below ends; the first layer of the next such group begins anywhere.
/// A fixed number, because the result must not depend on the number of threads.
const LAYERS_IN_SEQUENCE: usize = 16;

/// Reason why the beads of a part cannot be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BeadError {
    /// No order of the tools is possible.
    #[error(transparent)]
    Order(#[from] OrderError),
    /// The lines of a layer cannot be linked.
    #[error("layer {layer}: {source}")]
    Links {
        /// Number of the layer, from 0.
        layer: usize,
        /// What is wrong with them.
        source: LinksError,
    },
    /// The beads of a layer cannot be ordered.
    #[error("layer {layer}: {source}")]
    Travel {
        /// Number of the layer, from 0.
        layer: usize,
        /// What is wrong with them.
        source: TravelError,
    },
}

/// Plans the beads of a part, given as the islands of each layer from the bed up.
///
/// `toolpath` are the settings that the islands were made with.
/// Each layer uses each of its tools once, in the order of [`order`] for `costs`.
/// So the lifts do not depend on the order of the tools, and both are minimised separately.
/// Of the orders that cost as little, one is taken that leads from each tool to a near one.
///
/// An interrupted call returns a valid plan of less effort, with the reason in [`BeadPlan::stop`].
/// Progress counts layers.
/// Works on `control.threads`; the result does not depend on them.
pub fn solve(
    layers: &[Vec<Island>],
    toolpath: &ToolpathSettings,
    costs: &CostMatrix,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<BeadPlan, BeadError> {
    let tools: Vec<Vec<u8>> = layers
        .iter()
        .map(|islands| {
            // A tool is not fetched for islands that are too small to be printed.
            let printed = islands.iter().filter(|island| island.is_printed());
            let mut tools: Vec<u8> = printed.map(|island| island.material).collect();
            tools.sort_unstable();
            tools.dedup();
            tools
        })
        .collect();
    let quiet = control.without_progress();
    let mut order = order(&tools, costs, &settings.constraints, &quiet)?;
    if settings.tool_change_mm.is_none() && order.changes > 0 {
        let bounds_of: Vec<BTreeMap<u8, Rectangle>> = layers
            .iter()
            .zip(&tools)
            .map(|(islands, tools)| {
                let of = |&tool: &u8| Rectangle::around(islands, tool).map(|around| (tool, around));
                tools.iter().filter_map(of).collect()
            })
            .collect();
        let travel = |layers: [usize; 2], tools: [u8; 2]| {
            let [from, to] = [0, 1].map(|end| bounds_of[layers[end]][&tools[end]]);
            from.distance_to_mm(to)
        };
        order = order.with_minimum_travel(costs, &settings.constraints, travel);
    }
    let fixed = fixed_order_cost(&tools, costs, settings.constraints.loaded)?;
    let seams = seams(layers, settings.seam, settings.seed);

    let done = AtomicUsize::new(0);
    let sequences = layers.len().div_ceil(LAYERS_IN_SEQUENCE);
    let plan_sequence = |sequence: usize| {
        let quiet = quiet.on_one_thread();
        let mut planner = LayerPlanner { toolpath, settings, control: &quiet, before: None };
        let first = sequence * LAYERS_IN_SEQUENCE;
        let mut planned = Vec::new();
        for number in first..(first + LAYERS_IN_SEQUENCE).min(layers.len()) {
            let tools = &order.orders[number];
            planned.push(planner.plan(number, &layers[number], &seams[number], tools)?);
            control.report(done.fetch_add(1, Ordering::Relaxed) + 1, layers.len());
        }
        Ok(planned)
    };
    let planned = control.threads.map_numbers(sequences, plan_sequence);
    let planned = planned.into_iter().collect::<Result<Vec<Vec<PlannedLayer>>, BeadError>>()?;

    let mut plan = BeadPlan {
        layers: Vec::with_capacity(layers.len()),
        counts: Vec::with_capacity(layers.len()),
        order,
        fixed,
        travel_mm: 0.0,
        travel_bound_mm: Some(0.0),
        stop: Stop::Done,
    };
    let mut interrupted = None;
    for planned in planned.into_iter().flatten() {
        plan.travel_mm += planned.travel_mm;
        plan.travel_bound_mm =
            plan.travel_bound_mm.zip(planned.travel_bound_mm).map(|(sum, bound)| sum + bound);
        interrupted = interrupted.or(planned.interrupted);
        plan.counts.push(planned.counts);
        plan.layers.push(planned.layer);
    }
    let total = plan.total();
    plan.stop = match interrupted {
        Some(stop) => stop,
        None if total.beads == total.bead_bound && plan.order.is_optimal() => Stop::Optimal,
        None => Stop::Done,
    };
    Ok(plan)
}
