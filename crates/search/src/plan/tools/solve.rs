//! Planning of whole parts.

use beadwork_base::Control;

use super::error::PlanError;
use super::outcome::{FrontierPoint, ToolPlan};
use super::settings::{Mode, Settings};
use crate::CostMatrix;
use crate::plan::choice::{Begin, Chosen, Way, Weights, choose, frontier};
use crate::plan::cover::{LayerRef, tools};
use crate::plan::covers::{Wants, covers};
use crate::plan::options::Options;
use crate::plan::order::{Constraints, OrderError, Solution, fixed_order_cost, order_and_tables};

/// Plans a part with the minimum sum of the costs of tool changes and lifts.
///
/// All layers must lie on grids of the same size; `costs` are those of the tool changes.
///
/// 1. Each layer is covered in one or two ways, depending on the [`Mode`], by [`crate::exact`]:
///    with the fewest pieces and of those the cheapest crossings, or zone by zone.
///    Equal layers are covered once, unless layers are stacked.
/// 2. For each cover, the cheapest order of its pieces is found for each pair of a first and a last
///    tool: a sequence of continuous pieces, in which pieces of a single tool stay together, or an
///    order of the tools.
/// 3. A shortest path through the layers chooses among all these ways.
///
/// Step 3 is exact for the ways that step 2 found.
/// Step 2 is exact for up to 10 blocks of continuous pieces in a layer, where all pieces of a
/// single tool count as one block; and for up to 12 tools in a layer that is printed tool by tool.
/// Keeping the pieces of a tool together is optimal unless a detour over another tool is cheaper
/// than a direct change.
/// [`ToolPlan::order`] bounds the tool costs of every plan.
///
/// Progress counts layers.
/// Takes the time of [`crate::exact::solve`] for each different layer, plus that of
/// [`order`](crate::plan::order()).
/// Works on `control.threads`, which do not change the result; stacked layers wait for the layer
/// below.
pub fn solve(
    layers: &[LayerRef<'_>],
    costs: &CostMatrix,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<ToolPlan, PlanError> {
    let Settings { mode, constraints, .. } = settings;
    check(layers, costs, settings)?;
    let sets: Vec<Vec<u8>> = layers.iter().map(|&layer| tools(layer)).collect();
    if let Some(&tool) = sets.iter().flatten().find(|&&tool| usize::from(tool) >= costs.size()) {
        return Err(OrderError::UnknownTool { tool, tools: costs.size() }.into());
    }
    let solution = order_and_tables(&sets, costs, constraints, &control.without_progress())?;
    let Solution { order, tables } = solution;
    control.check()?;
    let wants = Wants {
        continuous: *mode != Mode::Free && !restricts_order(constraints),
        by_zones: *mode != Mode::Continuous,
    };
    let covers = covers(layers, costs, settings, wants, control)?;
    let mut options: Vec<Options<'_>> = Vec::with_capacity(layers.len());
    for (number, ((layer, covers), set)) in layers.iter().zip(&covers).zip(&sets).enumerate() {
        control.check()?;
        let mut of_layer = Options::new(*layer, covers, costs);
        of_layer.add_sequences();
        if constraints.same_order {
            let order = &order.orders[number];
            let cost = order.windows(2).map(|pair| costs.step(pair[0], pair[1])).sum();
            of_layer.add_order(order.clone(), cost);
        } else {
            of_layer.add_orders(&tables[set]);
        }
        options.push(of_layer);
    }
    let ways: Vec<Vec<Way>> = options.iter().map(|options| options.ways.clone()).collect();
    let begin = Begin { loaded: constraints.loaded, first: constraints.first };
    let no_first = || PlanError::First { first: constraints.first.unwrap_or_default() };
    let weights = weights(settings.lift_cost, costs);
    let chosen = choose(&ways, costs, begin, weights).ok_or_else(no_first)?;
    let points =
        if *mode == Mode::Cheapest { frontier(&ways, costs, begin) } else { vec![chosen.clone()] };
    let mut plan = ToolPlan {
        layers: Vec::with_capacity(layers.len()),
        loaded: constraints.loaded,
        visits: Vec::new(),
        tool_cost: 0.0,
        lifts: 0,
        order,
        fixed: fixed_order_cost(&sets, costs, constraints.loaded)?,
        frontier: with_lift_costs(&points, costs),
    };
    for ((layer, options), &way) in layers.iter().zip(&options).zip(&chosen.ways) {
        let planned = options.plan(way, plan.layers.last());
        let zones = planned.path.order().iter().map(|&cell| layer.zones.id(cell));
        plan.visits.extend(zones);
        plan.visits.dedup();
        plan.lifts += u64::from(planned.lifts());
        plan.layers.push(planned);
    }
    // Counted from the paths, which may have joined pieces; joining adds no tool changes.
    let uses: Vec<u8> = constraints.loaded.iter().chain(&plan.visits).copied().collect();
    let changes = uses.windows(2).map(|pair| costs.step(pair[0], pair[1]));
    plan.tool_cost = costs.unscaled(changes.sum());
    Ok(plan)
}

fn check(
    layers: &[LayerRef<'_>],
    costs: &CostMatrix,
    settings: &Settings,
) -> Result<(), PlanError> {
    let &Settings { lift_cost, mode, ref constraints, .. } = settings;
    let size = |layer: &LayerRef<'_>| [layer.region.width(), layer.region.height()];
    let expected = layers.first().map(size).ok_or(PlanError::NoLayers)?;
    if let Some(layer) = layers.iter().position(|layer| size(layer) != expected) {
        return Err(PlanError::GridSize { layer, expected, got: size(&layers[layer]) });
    }
    if !(lift_cost.is_finite() && lift_cost >= 0.0) {
        return Err(PlanError::LiftCost(lift_cost));
    }
    if mode == Mode::Continuous && restricts_order(constraints) {
        return Err(PlanError::Constraint);
    }
    if let Some([from, to]) = costs.first_forbidden().filter(|_| mode != Mode::Free) {
        return Err(PlanError::Forbidden { mode, from, to });
    }
    Ok(())
}

/// Whether the constraints restrict the order of the tools, so that layers have to be printed tool
/// by tool.
fn restricts_order(constraints: &Constraints) -> bool {
    constraints.same_order || !constraints.before.is_empty()
}

/// Integer weights of a unit of scaled tool cost and of a lift.
fn weights(lift_cost: f64, costs: &CostMatrix) -> Weights {
    /// Number of parts of a unit of scaled tool cost, if the cost of a lift is not a whole number
    /// of units.
    const PARTS: u64 = 1 << 20;

    let scaled = lift_cost * costs.scale();
    if scaled.fract() == 0.0 {
        return Weights { tools: 1, lifts: scaled as u64 };
    }
    Weights { tools: PARTS, lifts: (scaled * PARTS as f64).round() as u64 }
}

/// The points, each with the cost of a lift above which the next point with fewer lifts is cheaper.
fn with_lift_costs(points: &[Chosen], costs: &CostMatrix) -> Vec<FrontierPoint> {
    let point = |(number, chosen): (usize, &Chosen)| {
        let fewer_lifts = number.checked_sub(1).map(|before| &points[before]);
        let up_to_lift_cost = fewer_lifts.map(|fewer| {
            costs.unscaled(fewer.cost - chosen.cost) / (chosen.lifts - fewer.lifts) as f64
        });
        let tool_cost = costs.unscaled(chosen.cost);
        FrontierPoint { lifts: chosen.lifts, tool_cost, up_to_lift_cost }
    };
    points.iter().enumerate().map(point).collect()
}
