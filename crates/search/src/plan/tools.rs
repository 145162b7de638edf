//! A plan of a whole part that changes tools and lifts the head as cheaply as can be.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use beadwork_grid::{Cell, Crossings, Path, Region};
use rayon::ThreadPool;
use thiserror::Error;

use super::arrange::{Group, arrange};
use super::choice::{Chosen, Way, Weights, choose, frontier};
use super::cover::{Cover, Effort, LayerRef, tools};
use super::order::within::{NEVER, Within};
use super::sequence::{Block, Sequence, blocks, sequences};
use super::{Constraints, FixedOrder, OrderError, ToolCosts, ToolOrder, fixed_order_cost, kept_links, order};
use crate::exact::SolveError;
use crate::parallel::in_parallel;
use crate::stop::is_cancelled;
use crate::{ZoneCosts, ZoneCostsError};

/// How layers may be printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Each layer whichever way makes the part cheaper, at the price of a lift.
    #[default]
    Cheapest,
    /// Without a lift wherever that is possible: pieces run on across zones, and the tool changes as they do.
    Continuous,
    /// Tool by tool: no piece runs on across zones, and every tool is used once in a layer.
    Free,
}

/// Of two equally good paths of a layer, which to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stacking {
    /// The one that has more links in common with the layer below: seams are stacked, and surfaces alike.
    Keep,
    /// The one that has fewer: beads cross those below and bind the layers. Straight stretches run along rows and columns in turn.
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
    /// What the order of the tools has to obey; [`Mode::Continuous`] can only obey [`Constraints::first`].
    pub constraints: &'a Constraints,
    /// Whether to try for each layer the path of the one below too, and what then decides. `None`: each layer by itself.
    pub stacking: Option<Stacking>,
    /// Seed of all random choices.
    pub seed: u64,
    /// Most attempts at each connected part of a layer.
    pub attempts: u32,
    /// Where to work; `None` for the calling thread alone. The plan does not depend on it. With [`Settings::stacking`] layers wait for the one below.
    pub pool: Option<&'a ThreadPool>,
    /// Stops the work soon after it turns true.
    pub cancel: Option<&'a AtomicBool>,
    /// Told after each layer.
    pub observer: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Settings<'a> {
    /// Any mode, lifts that cost nothing, seed 0, 50 attempts, layers by themselves, in the calling thread.
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
    pub path: Path,
    /// Whether its pieces run on across zones.
    pub is_continuous: bool,
    /// Pieces of any path of this kind, at least. Proven. Where a piece happens to end beside the next one, the path has fewer.
    pub piece_bound: u32,
    /// Steps of the path between two zones.
    pub crossings: u32,
    /// Of a continuous layer: what its crossings cost, and what those of any path in so many pieces cost at least. Proven.
    pub crossing_cost: Option<[u64; 2]>,
    /// Links that it has in common with the layer below; `None` in the first layer.
    pub kept_links: Option<u32>,
}

impl LayerPlan {
    /// Breaks between its pieces.
    pub fn lifts(&self) -> u32 {
        self.path.pieces() - 1
    }

    /// Whether it is proven that no path of this kind has fewer pieces, or as few and cheaper crossings.
    pub fn is_optimal(&self) -> bool {
        self.path.pieces() <= self.piece_bound && self.crossing_cost.is_none_or(|[cost, bound]| cost == bound)
    }
}

/// A point of the frontier of lifts against tool changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrontierPoint {
    /// Lifts of the whole part.
    pub lifts: u64,
    /// Cost of its tool changes.
    pub tool_cost: u64,
    /// The price of a lift up to which this point is as cheap as any, in units of tool cost, as a fraction; `None` for any price.
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
    /// What the order of tools could be if no piece ran across zones, with its bounds; `None` in [`Mode::Continuous`] with more than 12
    /// tools in a layer. Its [`bound`](ToolOrder::bound) holds for the tool changes of *every* plan, whatever its mode.
    pub order: Option<ToolOrder>,
    /// What printing the tools of every layer by rising number costs, for comparison; `None` with more than 12 tools in a layer.
    pub fixed: Option<FixedOrder>,
    /// Lifts against tool changes, from few lifts to cheap tools; one point unless the mode is [`Mode::Cheapest`].
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

/// Plans a part for as few and as cheap tool changes, and as few lifts, as can be: the least sum of purge costs and of lifts times their price.
///
/// 1. Each layer is covered in one or two ways ([`Mode`]) by [`crate::exact`]: in the fewest pieces, with the cheapest crossings; or zone by zone. Layers
///    that are equal are covered once.
/// 2. For each way, the cheapest order of its pieces from each tool to each other; zone by zone, up to 12 tools a layer.
/// 3. A shortest way through the layers, over the last tool of each, chooses among them all.
///
/// Steps 2 and 3 are exact for what step 1 gives them, with up to 10 blocks of pieces a layer. What any plan must pay for tools is bounded in
/// [`ToolPlan::order`]. Time is that of [`crate::exact::solve`] for each different layer.
pub fn tools_plan(layers: &[LayerRef<'_>], settings: &Settings<'_>) -> Result<ToolPlan, PlanError> {
    let Settings { costs, mode, constraints, .. } = *settings;
    if layers.is_empty() {
        return Err(PlanError::NoLayers);
    }
    let obeys_order = constraints.same_order || !constraints.before.is_empty();
    if obeys_order && mode == Mode::Continuous {
        return Err(PlanError::Constraint);
    }
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
    let fixed = fixed_order_cost(&sets, costs).ok();
    let wants = Wants { continuous: mode != Mode::Free && !obeys_order, by_zones: mode != Mode::Continuous };
    let covers = covers(layers, settings, wants)?;
    let mut options: Vec<Options<'_>> = Vec::with_capacity(layers.len());
    for ((layer, covers), set) in layers.iter().zip(&covers).zip(&sets) {
        options.push(Options::new(*layer, covers, set, costs, constraints));
    }
    if let (true, Some(order)) = (constraints.same_order, &tool_order) {
        options.iter_mut().zip(&order.orders).for_each(|(options, order)| options.keep_order(order));
    }
    let ways: Vec<Vec<Way>> =
        options.iter().map(|options| options.ways.iter().map(|(way, _)| *way).collect()).collect();
    let weights = Weights { tools: 1, lifts: u64::from(settings.lift_cost) };
    let no_first = || PlanError::First { first: constraints.first.unwrap_or_default() };
    let chosen = choose(&ways, costs, constraints.first, weights).ok_or_else(no_first)?;
    let points =
        if mode == Mode::Cheapest { frontier(&ways, costs, constraints.first) } else { vec![chosen.clone()] };
    let mut plan = ToolPlan {
        layers: Vec::with_capacity(layers.len()),
        visits: Vec::new(),
        tool_cost: 0,
        lifts: 0,
        order: tool_order,
        fixed,
        frontier: with_prices(&points),
    };
    for ((layer, options), &way) in layers.iter().zip(&options).zip(&chosen.ways) {
        let planned = options.plan(*layer, way, plan.layers.last());
        let zones = planned.path.order().iter().map(|&cell| layer.zones.id(cell));
        plan.visits.extend(zones);
        plan.visits.dedup();
        plan.lifts += u64::from(planned.lifts());
        plan.layers.push(planned);
    }
    plan.tool_cost = plan.visits.windows(2).map(|pair| u64::from(costs.cost(pair[0], pair[1]))).sum();
    Ok(plan)
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

/// Which covers are wanted.
#[derive(Clone, Copy)]
struct Wants {
    continuous: bool,
    by_zones: bool,
}

/// The covers of one layer.
#[derive(Clone)]
struct Covers {
    continuous: Option<Cover>,
    by_zones: Option<Cover>,
}

/// Covers of all layers: side by side, or one on top of the other.
fn covers(layers: &[LayerRef<'_>], settings: &Settings<'_>, wants: Wants) -> Result<Vec<Covers>, PlanError> {
    let costs = zone_costs(settings.costs)?;
    let columns_first = |number: usize| settings.stacking == Some(Stacking::Break) && number % 2 == 1;
    // Layers that come to the same, by the number of the first of them.
    let mut numbers: HashMap<(&Region, &[u8], bool), usize> = HashMap::new();
    let first_of: Vec<usize> = (0..layers.len())
        .map(|number| {
            let LayerRef { region, zones } = layers[number];
            *numbers.entry((region, zones.ids(), columns_first(number))).or_insert(number)
        })
        .collect();
    let done = AtomicUsize::new(0);
    let tell = |count: usize| {
        if let Some(observer) = settings.observer {
            observer(Progress {
                done: done.fetch_add(count, Ordering::Relaxed) + count,
                layers: layers.len(),
            });
        }
    };
    let cover = |number: usize, below: Option<&Covers>| -> Result<Covers, PlanError> {
        if is_cancelled(settings.cancel) {
            return Err(PlanError::Cancelled);
        }
        let layer = layers[number];
        let effort = Effort {
            seed: settings.seed,
            attempts: settings.attempts,
            columns_first: columns_first(number),
            cancel: settings.cancel,
        };
        // With one tool both are the same.
        let by_zones = wants.by_zones && (!wants.continuous || tools(layer).len() > 1);
        let path = |cover: &Option<Cover>| cover.as_ref().map(|cover| cover.path.clone());
        let [continuous_below, zones_below] = match below {
            Some(below) => {
                let (one, other) = (path(&below.continuous), path(&below.by_zones));
                [one.clone().or(other.clone()), other.or(one)]
            }
            None => [None, None],
        };
        let wrong = |source| PlanError::Layer { layer: number, source };
        Ok(Covers {
            continuous: wants
                .continuous
                .then(|| Cover::continuous(layer, &costs, continuous_below.as_ref(), effort))
                .transpose()
                .map_err(wrong)?,
            by_zones: by_zones
                .then(|| Cover::by_zones(layer, zones_below.as_ref(), effort))
                .transpose()
                .map_err(wrong)?,
        })
    };
    let firsts: Vec<usize> = (0..layers.len()).filter(|&number| first_of[number] == number).collect();
    let found = in_parallel(
        settings.pool,
        &firsts,
        || (),
        |(), &number| {
            let covers = cover(number, None);
            tell(if settings.stacking.is_some() {
                0
            } else {
                first_of.iter().filter(|&&first| first == number).count()
            });
            covers
        },
    );
    let found = firsts.iter().copied().zip(found).map(|(number, covers)| Ok((number, covers?)));
    let found = found.collect::<Result<HashMap<usize, Covers>, PlanError>>()?;
    if is_cancelled(settings.cancel) {
        return Err(PlanError::Cancelled);
    }
    let mut stacked: Vec<Covers> = Vec::with_capacity(layers.len());
    for (number, first) in first_of.iter().enumerate() {
        let alone = &found[first];
        let covers = match (settings.stacking, stacked.last()) {
            (Some(stacking), Some(below)) => {
                let aware = cover(number, Some(below))?;
                Covers {
                    continuous: better(
                        alone.continuous.as_ref(),
                        aware.continuous,
                        below.continuous.as_ref(),
                        stacking,
                    ),
                    by_zones: better(
                        alone.by_zones.as_ref(),
                        aware.by_zones,
                        below.by_zones.as_ref(),
                        stacking,
                    ),
                }
            }
            _ => alone.clone(),
        };
        if settings.stacking.is_some() {
            tell(1);
        }
        stacked.push(covers);
    }
    Ok(stacked)
}

/// The better of two covers; of equal ones the one that keeps more, or fewer, of the links below.
fn better(
    alone: Option<&Cover>,
    aware: Option<Cover>,
    below: Option<&Cover>,
    stacking: Stacking,
) -> Option<Cover> {
    let (alone, aware) = (alone?, aware?);
    let merit = |cover: &Cover| (cover.path.pieces(), cover.cost);
    let kept = |cover: &Cover| below.map_or(0, |below| kept_links(&below.path, &cover.path));
    let takes_aware = match merit(&aware).cmp(&merit(alone)) {
        std::cmp::Ordering::Less => true,
        std::cmp::Ordering::Greater => false,
        std::cmp::Ordering::Equal => match stacking {
            Stacking::Keep => kept(&aware) >= kept(alone),
            Stacking::Break => kept(&aware) < kept(alone),
        },
    };
    Some(if takes_aware { aware } else { alone.clone() })
}

/// Costs of crossings: 1 each if all changes cost the same, which is found faster.
fn zone_costs(costs: &ToolCosts) -> Result<ZoneCosts, ZoneCostsError> {
    let count = costs.tools() as u8;
    let all: Vec<u32> = (0..count).flat_map(|from| (0..count).map(move |to| costs.cost(from, to))).collect();
    let mut changes = (0..count)
        .flat_map(|from| (0..count).filter(move |&to| to != from).map(move |to| costs.cost(from, to)));
    let first = changes.next().unwrap_or(1);
    if first > 0 && changes.all(|cost| cost == first) {
        return Ok(ZoneCosts::uniform(count.into()));
    }
    ZoneCosts::new(count.into(), all)
}

/// All ways to print one layer.
struct Options<'a> {
    covers: &'a Covers,
    continuous_pieces: Vec<&'a [Cell]>,
    zone_pieces: Vec<&'a [Cell]>,
    blocks: Vec<Block>,
    ways: Vec<(Way, How)>,
}

/// What a way looks like.
enum How {
    /// A sequence of blocks.
    Continuous(Sequence),
    /// Tool after tool.
    ByZones(Vec<u8>),
}

impl<'a> Options<'a> {
    fn new(
        layer: LayerRef<'_>,
        covers: &'a Covers,
        set: &[u8],
        costs: &ToolCosts,
        constraints: &Constraints,
    ) -> Self {
        let mut options = Self {
            covers,
            continuous_pieces: Vec::new(),
            zone_pieces: Vec::new(),
            blocks: Vec::new(),
            ways: Vec::new(),
        };
        if let Some(cover) = &covers.continuous {
            options.continuous_pieces = cover.pieces(layer.zones, true);
            options.blocks = blocks(&options.continuous_pieces, layer.zones, costs);
            let lifts = options.continuous_pieces.len() as u64 - 1;
            for sequence in sequences(&options.blocks, costs) {
                let Sequence { first, last, cost, .. } = sequence;
                options.ways.push((Way { first, last, cost, lifts }, How::Continuous(sequence)));
            }
        }
        if let Some(cover) = &covers.by_zones {
            options.zone_pieces = cover.pieces(layer.zones, false);
            let lifts = options.zone_pieces.len() as u64 - 1;
            let within = Within::new(set, costs, &constraints.before);
            for (from, &first) in set.iter().enumerate() {
                for (to, &last) in set.iter().enumerate() {
                    let cost = within.cost(from, to);
                    if cost != NEVER {
                        let how = How::ByZones(within.order(from, to).to_vec());
                        options.ways.push((Way { first, last, cost, lifts }, how));
                    }
                }
            }
        }
        options
    }

    /// Leaves that one order only.
    fn keep_order(&mut self, order: &[u8]) {
        let is_it = |how: &How| matches!(how, How::ByZones(other) if other == order);
        if let Some(at) = self.ways.iter().position(|(_, how)| is_it(how)) {
            self.ways.swap(0, at);
            self.ways.truncate(1);
        }
    }

    /// The layer printed in one of the ways.
    fn plan(&self, layer: LayerRef<'_>, way: usize, below: Option<&LayerPlan>) -> LayerPlan {
        let LayerRef { region, zones } = layer;
        let (_, how) = &self.ways[way];
        let (groups, cover, is_continuous): (Vec<Group<'_>>, _, _) = match how {
            How::Continuous(sequence) => {
                let group = |&(block, turned): &(usize, bool)| {
                    let block = &self.blocks[block];
                    let pieces: Vec<&[Cell]> =
                        block.pieces.iter().map(|&piece| self.continuous_pieces[piece]).collect();
                    if block.is_plain() { Group::Any(pieces) } else { Group::Fixed(pieces[0], turned) }
                };
                let cover = self.covers.continuous.as_ref().expect("the way is one of its");
                (sequence.blocks.iter().map(group).collect(), cover, true)
            }
            How::ByZones(order) => {
                let group = |&tool: &u8| {
                    Group::Any(
                        self.zone_pieces.iter().copied().filter(|piece| zones.id(piece[0]) == tool).collect(),
                    )
                };
                let cover = self.covers.by_zones.as_ref().expect("the way is one of its");
                (order.iter().map(group).collect(), cover, false)
            }
        };
        let from = below.and_then(|below| below.path.order().last().copied());
        let path =
            Path::in_pieces(region, arrange(region, groups, from)).expect("the pieces hold every cell once");
        let crossings = Crossings::new(region, zones).count(&path);
        LayerPlan {
            is_continuous,
            piece_bound: cover.piece_bound,
            crossings,
            crossing_cost: is_continuous.then_some([cover.cost, cover.bound]),
            kept_links: below.map(|below| kept_links(&below.path, &path)),
            path,
        }
    }
}

#[cfg(test)]
mod tests;
