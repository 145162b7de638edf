//! The task of printing one part: the candidates of each layer, and what the baseline does there.

use beadwork_base::{Control, Threads};
use beadwork_grid::{Cell, RegionError};
use beadwork_heat::allotment::{Choice, allot};
use beadwork_heat::fill::Fill;
use beadwork_heat::model::{Screen, Solver, ThermalModel};
use beadwork_part::{Order, Pattern};
use beadwork_thermal::event::layer_events;
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use super::super::range::{RangeError, require};
use super::view::{View, unevenness};

/// What a second of printing time costs an agent, beside what the layer costs.
///
/// Under a limit on the printing time, time that a layer saves is worth what layers above gain by
/// it.
/// An agent with a low discount is not rewarded for that; with a price of time, the Lagrange
/// multiplier of the limit, it is rewarded at once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TimePrice {
    /// Nothing: the paper's reward.
    #[default]
    Free,
    /// This much, K/s, at least 0.
    Given(f64),
    /// The price below which the candidates that are cheapest by their
    /// [estimates](HeatSettings::estimated) exceed the limit; nothing without a limit.
    Estimated,
}

/// What an agent is compared with, limited by, and sees.
///
/// Construct it with `..HeatSettings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatSettings {
    /// Index of the candidate that is the baseline.
    pub baseline: usize,
    /// Limit on the printing time, as a ratio to that of the baseline; `None` for no limit.
    ///
    /// At the end of every layer, the print may have taken at most this ratio of what the baseline
    /// takes to that layer's end.
    /// Candidates that would take longer are masked.
    /// If all would, the fastest one is permitted, and the limit is exceeded; travel to its first
    /// cell alone can cause that, if the ratio is close to 1.
    pub max_time_ratio: Option<f64>,
    /// What a second of printing time costs.
    /// It changes rewards, but not how episodes [score](super::super::Environment::score).
    pub time_price: TimePrice,
    /// Observed layers below the one that is printed next, at least 1.
    pub depth: usize,
    /// Side of an observed cell, in voxels, at least 1. Without effect if there is a `window`.
    pub cell: usize,
    /// Cells along each side of the observation, at least 1: observations then have the same size
    /// for all parts, and show what candidates have in common between parts.
    /// `None` shows the part's bounding box.
    pub window: Option<usize>,
    /// Whether candidates are described by the model's [screen](ThermalModel::screen), in place of
    /// two crude estimates; without effect if there is no `window`.
    ///
    /// Each candidate is estimated once, above layers that are printed as the baseline, at a
    /// fraction of a millisecond to a few milliseconds each.
    pub estimated: bool,
    /// Whether rewards are in percent of what the baseline costs for the whole part, rather than in
    /// K, so that parts count alike.
    pub relative: bool,
}

impl Default for HeatSettings {
    fn default() -> Self {
        Self {
            baseline: Pattern::CONVENTIONAL.number(),
            max_time_ratio: None,
            time_price: TimePrice::Free,
            depth: 4,
            cell: 4,
            window: None,
            estimated: false,
            relative: false,
        }
    }
}

impl HeatSettings {
    /// Observes each voxel of the part in up to 128 layers below, as the paper does.
    pub fn paper() -> Self {
        Self { depth: 128, cell: 1, ..Self::default() }
    }

    /// For policies of one part that choose among many candidates: they are described by estimates.
    pub fn estimated() -> Self {
        Self { window: Some(16), estimated: true, ..Self::default() }
    }

    /// For policies that act on any part: observations of 16 x 16 cells, and rewards in percent.
    pub fn general() -> Self {
        Self { window: Some(16), relative: true, ..Self::default() }
    }

    /// Checks that all fields are in their ranges.
    pub(super) fn check(&self) -> Result<(), RangeError> {
        let &Self { max_time_ratio, depth, cell, window, .. } = self;
        require(depth > 0, "depth", &depth, "at least 1")?;
        require(cell > 0, "cell", &cell, "at least 1")?;
        let window = window.unwrap_or(1);
        require((1..=1024).contains(&window), "window", &window, "1 to 1024")?;
        if let TimePrice::Given(price) = self.time_price {
            require(price >= 0.0 && price.is_finite(), "time_price", &price, "0 or more")?;
        }
        let ratio = max_time_ratio.unwrap_or(1.0);
        require(ratio >= 1.0 && ratio.is_finite(), "max_time_ratio", &ratio, "1 or more")
    }

    /// Whether candidates are estimated by the model's screen.
    fn needs_estimates(&self) -> bool {
        self.time_price == TimePrice::Estimated || self.estimated && self.window.is_some()
    }

    /// Shapes of the tensors of an observation of `size` cells.
    pub(super) fn shapes(&self, [x, y]: [usize; 2], candidates: usize) -> Vec<Vec<i64>> {
        let [x, y, depth] = [x, y, self.depth].map(|size| size as i64);
        let fields = [vec![1, depth, y, x], vec![2, y, x]];
        let rest = match self.window {
            None => vec![vec![4]],
            Some(_) => vec![vec![6], vec![candidates as i64, 5]],
        };
        fields.into_iter().chain(rest).collect()
    }
}

/// Candidates for the order of each layer of a part, of which an agent chooses.
///
/// Environments share it by an [`Arc`](std::sync::Arc).
#[derive(Debug)]
pub struct HeatTask {
    /// Nothing is deposited yet.
    pub(super) unprinted: Solver,
    pub(super) layers: Vec<LayerTask>,
    pub(super) settings: HeatSettings,
    pub(super) view: View,
    /// Factor of the differences between costs.
    pub(super) reward_scale: f64,
    /// What a second of printing time costs, K/s.
    pub(super) time_price: f64,
}

/// The candidates of a layer, and what the baseline does there.
#[derive(Debug)]
pub(super) struct LayerTask {
    pub(super) orders: Vec<Vec<Cell>>,
    /// Whether each candidate differs from all before it.
    pub(super) distinct: Vec<bool>,
    /// Time to print each candidate without the travel to its first cell, s.
    pub(super) seconds: Vec<f64>,
    /// How uneven each candidate alone is; empty without a window.
    pub(super) unevenness: Vec<[f64; 2]>,
    /// Cost of each candidate by the screen, above layers that are printed as the baseline, K;
    /// empty unless it is needed.
    pub(super) estimates: Vec<f64>,
    /// Cost of the layer when the baseline is printed, K.
    pub(super) baseline_cost: f64,
    /// Time when the baseline ends the layer, s.
    pub(super) baseline_end_s: f64,
}

/// Why a [`HeatTask`] cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HeatError {
    /// There are not as many candidates in each layer, or none.
    #[error("layer {layer} has {count} candidates: expected {expected}, at least 1")]
    Candidates {
        /// The layer.
        layer: usize,
        /// Number of its candidates.
        count: usize,
        /// Number of candidates of the first layer.
        expected: usize,
    },
    /// There are not candidates for each layer of the part.
    #[error("candidates are given for {count} layers: the part has {expected}")]
    Layers {
        /// Number of layers with candidates.
        count: usize,
        /// Number of layers of the part.
        expected: usize,
    },
    /// A setting is outside its range.
    #[error(transparent)]
    Settings(#[from] RangeError),
    /// A candidate does not hold each cell of its layer once.
    #[error("candidate {candidate} of layer {layer} does not hold each cell of the layer once")]
    Order {
        /// The layer.
        layer: usize,
        /// Index of the candidate.
        candidate: usize,
    },
    /// The region of a layer is invalid.
    #[error("layer {layer}: {source}")]
    Region {
        /// The layer.
        layer: usize,
        /// The error.
        source: RegionError,
    },
    /// Estimates are needed, but the model has none for these costs.
    #[error("model does not estimate these costs: train without estimates and their price of time")]
    NoEstimates,
    /// The baseline cannot be printed.
    #[error("the baseline cannot be printed")]
    Baseline(#[from] DepositError),
}

impl HeatTask {
    /// A task that prints a part, from a solver in which nothing is deposited.
    ///
    /// `orders` holds for each layer the same number of candidates, each with all cells of its
    /// layer.
    /// Simulates the part once, with the baseline.
    pub fn new(
        unprinted: Solver,
        orders: Vec<Vec<Vec<Cell>>>,
        settings: &HeatSettings,
    ) -> Result<Self, HeatError> {
        let part = unprinted.part();
        if orders.len() != part.depth {
            return Err(HeatError::Layers { count: orders.len(), expected: part.depth });
        }
        let expected = orders.first().map_or(0, Vec::len);
        for (layer, candidates) in orders.iter().enumerate() {
            let count = candidates.len();
            if count != expected || settings.baseline >= count {
                return Err(HeatError::Candidates { layer, count, expected });
            }
            let cells: Vec<Cell> = part.cells(layer).collect();
            for (candidate, order) in candidates.iter().enumerate() {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                if sorted != cells {
                    return Err(HeatError::Order { layer, candidate });
                }
            }
        }
        Self::of_valid(unprinted, orders, settings, None)
    }

    /// A task whose candidates are the same named orders in each layer.
    ///
    /// Layers without cells have empty candidates.
    pub fn named(
        unprinted: Solver,
        orders: &[Order],
        settings: &HeatSettings,
    ) -> Result<Self, HeatError> {
        Self::named_with(unprinted, orders, settings, None)
    }

    /// As [`HeatTask::named`]; the costs of the baseline are those given, if they are known from an
    /// earlier task of the same part.
    pub(super) fn named_with(
        unprinted: Solver,
        orders: &[Order],
        settings: &HeatSettings,
        baseline_costs: Option<&[f64]>,
    ) -> Result<Self, HeatError> {
        let part = unprinted.part();
        let count = orders.len();
        if settings.baseline >= count {
            return Err(HeatError::Candidates { layer: 0, count, expected: count });
        }
        let of_layer = |layer: usize| {
            if part.cells(layer).next().is_none() {
                return Ok(vec![Vec::new(); count]);
            }
            let region =
                part.region(layer).map_err(|source| HeatError::Region { layer, source })?;
            Ok(orders.iter().map(|order| order.order(&region)).collect())
        };
        let orders = (0..part.depth).map(of_layer).collect::<Result<Vec<_>, HeatError>>()?;
        Self::of_valid(unprinted, orders, settings, baseline_costs)
    }

    /// As [`HeatTask::new`], for candidates that hold each cell of their layer once.
    fn of_valid(
        unprinted: Solver,
        orders: Vec<Vec<Vec<Cell>>>,
        settings: &HeatSettings,
        baseline_costs: Option<&[f64]>,
    ) -> Result<Self, HeatError> {
        settings.check()?;
        let &HeatSettings { baseline, depth, cell, window, relative, .. } = settings;
        let part = unprinted.part();
        let (mut solver, mut end_s, mut last) = (unprinted.clone(), 0.0, None);
        let mut layers: Vec<LayerTask> = Vec::with_capacity(orders.len());
        for (layer, orders) in (0..).zip(orders) {
            let order = &orders[baseline];
            end_s += unprinted.fill().seconds(layer, last, order);
            last = order.last().copied().or(last);
            let mut estimates = Vec::new();
            if settings.needs_estimates() && !order.is_empty() {
                let screen = solver.screen(layer).ok_or(HeatError::NoEstimates)?;
                estimates = Threads::Current.map(&orders, |order| screen.cost(order));
            }
            let cost = match baseline_costs {
                Some(costs) if !settings.needs_estimates() => costs[layer as usize],
                _ if order.is_empty() => 0.0,
                _ => solver.deposit(layer, order, &Control::default())?,
            };
            // Nothing is deposited in `unprinted`, so its orders begin without travel.
            let frame = &part.frame;
            let events =
                |order: &Vec<Cell>| layer_events(order, layer, None, frame, unprinted.process());
            let (mut seconds, mut unevennesses) = (Vec::new(), Vec::new());
            for events in orders.iter().map(events) {
                seconds.push(events.iter().map(|event| event.seconds).sum());
                unevennesses.extend(window.map(|_| unevenness(&events, frame.width)));
            }
            layers.push(LayerTask {
                distinct: distinct(&orders),
                seconds,
                unevenness: unevennesses,
                estimates,
                baseline_cost: cost,
                baseline_end_s: end_s,
                orders,
            });
        }
        let view = View::new(part, depth, cell, window);
        let baseline_cost: f64 = layers.iter().map(|layer| layer.baseline_cost).sum();
        let reward_scale =
            if relative && baseline_cost > 0.0 { 100.0 / baseline_cost } else { 1.0 };
        let time_price = match settings.time_price {
            TimePrice::Free => 0.0,
            TimePrice::Given(price) => price,
            TimePrice::Estimated => estimated_price(&layers, settings),
        };
        Ok(Self { unprinted, layers, settings: *settings, view, reward_scale, time_price })
    }

    /// Text that differs between tasks.
    pub(super) fn identity(&self) -> String {
        let &HeatSettings { baseline, max_time_ratio, depth, cell, window, relative, .. } =
            &self.settings;
        let part = self.unprinted.part();
        let end: Vec<u64> = self.layers.iter().map(|layer| layer.baseline_cost.to_bits()).collect();
        let identity = format!(
            "task = \"heat\"\nlayers = {}\nvoxels = {}\ncandidates = {}\n\
             orders = \"{:016x}\"\nbaseline = \"{baseline}: {end:x?}\"\n\
             max_time_ratio = \"{max_time_ratio:?}\"\ndepth = {depth}\ncell = {cell}",
            part.depth,
            part.count(),
            self.candidates(),
            fingerprint(self.layers.iter().flat_map(|layer| &layer.orders)),
        );
        let observed = format!("\nwindow = \"{window:?}\"\nrelative = {relative}");
        let price = format!("\ntime_price = {:?}", self.time_price);
        let more = [
            (window.is_some() || relative, observed.as_str()),
            (self.settings.estimated, "\nestimated = true"),
            (self.time_price > 0.0, &price),
        ];
        let used = more.into_iter().filter_map(|(is_used, text)| is_used.then_some(text));
        used.fold(identity, |identity, text| identity + text)
    }

    /// Time that the baseline takes for a layer, with travel to it, s.
    pub(super) fn baseline_layer_s(&self, layer: usize) -> f64 {
        let below = layer.checked_sub(1).map_or(0.0, |below| self.layers[below].baseline_end_s);
        self.layers[layer].baseline_end_s - below
    }

    /// Minus the cost of the baseline, K: the paper's reward, if that is what the solver minimises.
    pub fn baseline_reward(&self) -> f64 {
        -self.layers.iter().map(|layer| layer.baseline_cost).sum::<f64>()
    }

    /// Printing time of the baseline, s.
    pub fn baseline_seconds(&self) -> f64 {
        self.layers.last().map_or(0.0, |layer| layer.baseline_end_s)
    }

    /// What a second of printing time costs, K/s: given, or as estimated.
    pub fn time_price(&self) -> f64 {
        self.time_price
    }

    /// Number of candidates of each layer.
    pub(super) fn candidates(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.orders.len())
    }

    /// Time of travel from a cell to another one of the next layer or the same, s.
    pub(super) fn travel_s(&self, from: Cell, to: Cell) -> f64 {
        let (frame, process) = (&self.unprinted.part().frame, self.unprinted.process());
        let seconds = |from: Option<Cell>| {
            let events = layer_events(&[to], 0, from, frame, process);
            events.iter().map(|event| event.seconds).sum::<f64>()
        };
        seconds(Some(from)) - seconds(None)
    }
}

/// The price of time by the estimates of the candidates; 0 without a limit.
fn estimated_price(layers: &[LayerTask], settings: &HeatSettings) -> f64 {
    let Some(ratio) = settings.max_time_ratio else { return 0.0 };
    let choice = |(&cost, &seconds): (&f64, &f64)| Choice { cost, seconds };
    let choices =
        |layer: &LayerTask| layer.estimates.iter().zip(&layer.seconds).map(choice).collect();
    // Layers without cells have no estimates.
    let printed = || layers.iter().filter(|layer| !layer.estimates.is_empty());
    let choices: Vec<Vec<Choice>> = printed().map(choices).collect();
    let baseline = |layer: &LayerTask| layer.seconds[settings.baseline];
    // Travel between layers is in neither sum.
    let limit_s = ratio * printed().map(baseline).sum::<f64>();
    allot(&choices, limit_s).map_or(0.0, |allotment| allotment.price)
}

/// Whether each candidate differs from all before it: copies are masked, so that no action is
/// learned twice.
fn distinct(candidates: &[Vec<Cell>]) -> Vec<bool> {
    let is_new = |index: usize| !candidates[..index].contains(&candidates[index]);
    (0..candidates.len()).map(is_new).collect()
}

/// A number that differs between lists of orders: FNV-1a of all of them.
fn fingerprint<'a>(orders: impl Iterator<Item = &'a Vec<Cell>>) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |value: u64| {
        for byte in value.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for order in orders {
        add(order.len() as u64);
        order.iter().for_each(|&cell| add(u64::from(cell)));
    }
    hash
}
