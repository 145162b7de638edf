//! A plan of a whole part that changes tools and lifts the head as cheaply as can be.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use beadwork_grid::Path;
use rayon::ThreadPool;
use thiserror::Error;

use super::choice::{Chosen, Way, Weights, choose, frontier};
use super::cover::{LayerRef, tools};
use super::covers::{Wants, covers};
use super::options::Options;
use super::order::within::Within;
use super::{Constraints, FixedOrder, OrderError, ToolCosts, ToolOrder, fixed_order_cost, order};
use crate::ZoneCostsError;
use crate::exact::SolveError;

/// How layers may be printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Each layer whichever way makes the part cheaper, at the price of a lift.
    #[default]
    Cheapest,
    /// Without a lift wherever that is possible: pieces run on across zones, and the tool changes
    /// as they do.
    Continuous,
    /// Tool by tool: no piece runs on across zones, and every tool is used once in a layer.
    Free,
}

/// Of two equally good paths of a layer, which to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stacking {
    /// The one that has more links in common with the layer below: seams are stacked, and surfaces
    /// alike.
    Keep,
    /// The one that has fewer: beads cross those below and bind the layers.
    /// Straight stretches run along rows and columns in turn.
    Break,
}

/// How to plan.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// What changes of tools cost.
    pub costs: &'a ToolCosts,
    /// What a lift costs, in the same unit.
    pub lift_cost: u32,
    /// How layers may be printed.
    pub mode: Mode,
    /// What the order of the tools has to obey; [`Mode::Continuous`] can only obey
    /// [`Constraints::first`].
    pub constraints: &'a Constraints,
    /// Whether to try for each layer the path of the one below too, and what then decides.
    /// `None`: each layer by itself.
    pub stacking: Option<Stacking>,
    /// Seed of all random choices.
    pub seed: u64,
    /// Most attempts at each connected part of a layer.
    pub attempts: u32,
    /// Where to work; `None` for the calling thread alone.
    /// The plan does not depend on it.
    /// With [`Settings::stacking`] layers wait for the one below.
    pub pool: Option<&'a ThreadPool>,
    /// Stops the work soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told after each layer.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Settings<'a> {
    /// Any mode, lifts that cost nothing, seed 0, 50 attempts, layers by themselves, in the calling
    /// thread.
    pub fn new(costs: &'a ToolCosts, constraints: &'a Constraints) -> Self {
        Self {
            costs,
            lift_cost: 0,
            mode: Mode::default(),
            constraints,
            stacking: None,
            seed: 0,
            attempts: 50,
            pool: None,
            cancel: None,
            observer: None,
        }
    }
}

/// How far planning has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Layers done.
    pub done: usize,
    /// Layers in all.
    pub layers: usize,
}

/// How a layer is printed.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LayerPlan {
    /// Its path: every cell once, piece after piece.
    /// Where a piece of the cover happens to end beside the next one, they are one.
    pub path: Path,
    /// Whether its pieces run on across zones.
    pub is_continuous: bool,
    /// Pieces of the cover that the path is made of; each lies in one zone unless the layer is
    /// continuous.
    pub pieces: u32,
    /// Pieces of any cover of this kind, at least.
    /// Proven.
    pub piece_bound: u32,
    /// Steps of the path between two zones.
    pub crossings: u32,
    /// Of a continuous layer: what the crossings within its pieces cost as they are printed, and
    /// what those of any cover in so many pieces cost at least, in the unit of the tool costs.
    /// The bound is proven.
    pub crossing_cost: Option<[u64; 2]>,
    /// Links that it has in common with the layer below; `None` in the first layer.
    pub kept_links: Option<u32>,
}

impl LayerPlan {
    /// Breaks between the pieces of its path.
    pub fn lifts(&self) -> u32 {
        self.path.pieces() - 1
    }

    /// Whether it is proven that no cover of this kind has fewer pieces, or as few and cheaper
    /// crossings.
    pub fn is_optimal(&self) -> bool {
        self.pieces == self.piece_bound
            && self.crossing_cost.is_none_or(|[cost, bound]| cost == bound)
    }
}

/// A point of the frontier of lifts against tool changes, lifts counted before pieces that happen
/// to meet are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrontierPoint {
    /// Lifts of the whole part.
    pub lifts: u64,
    /// Cost of its tool changes.
    pub tool_cost: u64,
    /// The price of a lift up to which this point is as cheap as any, in units of tool cost, as a
    /// fraction; `None` for any price.
    pub up_to_price: Option<[u64; 2]>,
}

/// A plan of a whole part, and what can be proven about it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ToolPlan {
    /// The layers, from the bottom up.
    pub layers: Vec<LayerPlan>,
    /// The tools in the order of their use over the whole part.
    pub visits: Vec<u8>,
    /// Cost of all tool changes.
    pub tool_cost: u64,
    /// Lifts within layers.
    pub lifts: u64,
    /// What the order of tools could be if no piece ran across zones, with its bounds; `None` in
    /// [`Mode::Continuous`] with more than 12 tools in a layer.
    /// Its [`bound`](ToolOrder::bound) holds for the tool changes of *every* plan, whatever its
    /// mode.
    pub order: Option<ToolOrder>,
    /// What printing the tools of every layer by rising number costs, for comparison; `None` with
    /// more than 12 tools in a layer.
    pub fixed: Option<FixedOrder>,
    /// Lifts against tool changes, from few lifts to cheap tools, up to 256 points; one unless the
    /// mode is [`Mode::Cheapest`].
    pub frontier: Vec<FrontierPoint>,
}

impl ToolPlan {
    /// Number of tool changes.
    pub fn tool_changes(&self) -> u64 {
        self.visits.len().saturating_sub(1) as u64
    }

    /// Cost of tool changes and lifts.
    pub fn cost(&self, lift_cost: u32) -> u64 {
        self.tool_cost + u64::from(lift_cost) * self.lifts
    }
}

/// Why there is no plan.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanError {
    /// There are no layers.
    #[error("there are no layers")]
    NoLayers,
    /// A layer lies on another plane than those below.
    #[error("layer {layer} lies on {} x {} cells, the first one on {} x {}", .got[0], .got[1], .expected[0], .expected[1])]
    Plane {
        /// Its number, from 0.
        layer: usize,
        /// Width and height of the first layer's plane.
        expected: [u32; 2],
        /// Those of this layer's.
        got: [u32; 2],
    },
    /// A layer can't be covered.
    #[error("layer {layer}: {source}")]
    Layer {
        /// Its number, from 0.
        layer: usize,
        /// Why.
        source: SolveError,
    },
    /// A change of tools costs more than a crossing may.
    #[error(transparent)]
    Costs(#[from] ZoneCostsError),
    /// There is no order of the tools.
    #[error(transparent)]
    Order(#[from] OrderError),
    /// A constraint that continuous paths can't obey.
    #[error("continuous paths use the tools of a layer as they come: they can't obey an order")]
    Constraint,
    /// No plan begins with the tool asked for.
    #[error("no path of the first layer begins with tool {first}")]
    First {
        /// The tool.
        first: u8,
    },
    /// It was stopped.
    #[error("cancelled")]
    Cancelled,
}

/// Plans a part for as few and as cheap tool changes, and as few lifts, as can be: the least sum of
/// purge costs and of lifts times their price.
///
/// 1. Each layer is covered in one or two ways ([`Mode`]) by [`crate::exact`]: in the fewest
///    pieces, with the cheapest crossings; or zone by zone.
///    Layers that are equal are covered once, unless layers are stacked.
/// 2. For each way, the cheapest order of its pieces from each tool to each other; the pieces of
///    one tool together, and zone by zone up to 12 tools a layer.
/// 3. A shortest way through the layers, over the last tool of each, chooses among them all.
///
/// Step 3 is exact for what step 2 gives it, and step 2 with up to 10 blocks of pieces a layer, but
/// for what keeping the pieces of a tool together may cost where a detour over another tool is
/// cheaper than the direct change.
/// What any plan must pay for tools is bounded in [`ToolPlan::order`].
/// All layers lie on planes of one size.
/// Time is that of [`crate::exact::solve`] for each different layer, and that of [`order`].
pub fn tools_plan(layers: &[LayerRef<'_>], settings: &Settings<'_>) -> Result<ToolPlan, PlanError> {
    let Settings { costs, mode, constraints, .. } = *settings;
    check(layers, settings)?;
    let sets: Vec<Vec<u8>> = layers.iter().map(|&layer| tools(layer)).collect();
    if let Some(&tool) = sets.iter().flatten().find(|&&tool| usize::from(tool) >= costs.tools()) {
        return Err(OrderError::UnknownTool { tool, tools: costs.tools() }.into());
    }
    let tool_order = match order(&sets, costs, constraints) {
        Ok(order) => Some(order),
        // Of more tools than an order can be found for, continuous paths still can be.
        Err(OrderError::TooManyTools { .. }) if mode == Mode::Continuous => None,
        Err(error) => return Err(error.into()),
    };
    let wants = Wants {
        continuous: mode != Mode::Free && !asks_for_order(constraints),
        by_zones: mode != Mode::Continuous,
    };
    let covers = covers(layers, settings, wants)?;
    let mut tables: BTreeMap<&[u8], Within> = BTreeMap::new();
    let mut options: Vec<Options<'_>> = Vec::with_capacity(layers.len());
    for (number, ((layer, covers), set)) in layers.iter().zip(&covers).zip(&sets).enumerate() {
        let mut of_layer = Options::new(*layer, covers);
        of_layer.add_sequences(costs);
        if let (true, Some(order)) = (constraints.same_order, &tool_order) {
            let order = &order.orders[number];
            let cost = order.windows(2).map(|pair| u64::from(costs.cost(pair[0], pair[1]))).sum();
            of_layer.add_order(order.clone(), cost);
        } else if covers.by_zones.is_some() {
            let within = || Within::new(set, costs, &constraints.before);
            of_layer.add_orders(set, tables.entry(set).or_insert_with(within));
        }
        options.push(of_layer);
    }
    let ways: Vec<Vec<Way>> = options.iter().map(|options| options.ways.clone()).collect();
    let weights = Weights { tools: 1, lifts: u64::from(settings.lift_cost) };
    let no_first = || PlanError::First { first: constraints.first.unwrap_or_default() };
    let chosen = choose(&ways, costs, constraints.first, weights).ok_or_else(no_first)?;
    let points = if mode == Mode::Cheapest {
        frontier(&ways, costs, constraints.first)
    } else {
        vec![chosen.clone()]
    };
    let mut plan = ToolPlan {
        layers: Vec::with_capacity(layers.len()),
        visits: Vec::new(),
        tool_cost: 0,
        lifts: 0,
        order: tool_order,
        fixed: fixed_order_cost(&sets, costs).ok(),
        frontier: with_prices(&points),
    };
    for ((layer, options), &way) in layers.iter().zip(&options).zip(&chosen.ways) {
        let planned = options.plan(way, plan.layers.last());
        let zones = planned.path.order().iter().map(|&cell| layer.zones.id(cell));
        plan.visits.extend(zones);
        plan.visits.dedup();
        plan.lifts += u64::from(planned.lifts());
        plan.layers.push(planned);
    }
    plan.tool_cost =
        plan.visits.windows(2).map(|pair| u64::from(costs.cost(pair[0], pair[1]))).sum();
    Ok(plan)
}

fn check(layers: &[LayerRef<'_>], settings: &Settings<'_>) -> Result<(), PlanError> {
    let plane = |layer: &LayerRef<'_>| [layer.region.width(), layer.region.height()];
    let expected = layers.first().map(plane).ok_or(PlanError::NoLayers)?;
    if let Some(layer) = layers.iter().position(|layer| plane(layer) != expected) {
        return Err(PlanError::Plane { layer, expected, got: plane(&layers[layer]) });
    }
    if asks_for_order(settings.constraints) && settings.mode == Mode::Continuous {
        return Err(PlanError::Constraint);
    }
    Ok(())
}

/// Whether there are constraints that only tools used one after the other can obey.
fn asks_for_order(constraints: &Constraints) -> bool {
    constraints.same_order || !constraints.before.is_empty()
}

/// The price at which the next point with fewer lifts becomes cheaper.
fn with_prices(points: &[Chosen]) -> Vec<FrontierPoint> {
    let point = |(number, chosen): (usize, &Chosen)| {
        let fewer = number.checked_sub(1).map(|before| &points[before]);
        let up_to_price = fewer.map(|fewer| [fewer.cost - chosen.cost, chosen.lifts - fewer.lifts]);
        FrontierPoint { lifts: chosen.lifts, tool_cost: chosen.cost, up_to_price }
    };
    points.iter().enumerate().map(point).collect()
}

#[cfg(test)]
mod tests;
