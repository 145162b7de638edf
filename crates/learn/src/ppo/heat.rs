//! The environment of the paper on toolpaths for even temperature (Kim et al. 2026): a step prints
//! a layer.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_heat::model::{Solver, ThermalModel};
use beadwork_part::Pattern;
use beadwork_part::slice::Voxels;
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use super::environment::{Environment, EpisodeEnd, Observation, Space, Step};
use super::range::{RangeError, require};

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
    /// Observed layers below the one that is printed next, at least 1.
    pub depth: usize,
    /// Side of an observed cell, in voxels, at least 1.
    pub cell: usize,
}

impl Default for HeatSettings {
    fn default() -> Self {
        Self { baseline: Pattern::CONVENTIONAL.number(), max_time_ratio: None, depth: 4, cell: 4 }
    }
}

impl HeatSettings {
    /// Observes each voxel of the part in up to 128 layers below, as the paper does.
    pub fn paper() -> Self {
        Self { depth: 128, cell: 1, ..Self::default() }
    }
}

/// Candidates for the order of each layer of a part, of which an agent chooses.
///
/// Environments share it by an [`Arc`].
#[derive(Debug)]
pub struct HeatTask {
    identity: String,
    /// Nothing is deposited yet.
    unprinted: Solver,
    layers: Vec<LayerTask>,
    max_time_ratio: Option<f64>,
    view: View,
}

/// The candidates of a layer, and what the baseline does there.
#[derive(Debug)]
struct LayerTask {
    orders: Vec<Vec<Cell>>,
    /// Whether each candidate differs from all before it.
    distinct: Vec<bool>,
    /// Time to print each candidate without the travel to its first cell, s.
    seconds: Vec<f64>,
    /// Cost of the layer when the baseline is printed, K.
    baseline_cost: f64,
    /// Time when the baseline ends the layer, s.
    baseline_end_s: f64,
}

/// The part of the temperature field that is observed.
#[derive(Clone, Copy, Debug)]
struct View {
    /// First column and row of the part's bounding box.
    corner: [usize; 2],
    /// Columns and rows of the observation.
    size: [usize; 2],
    /// Side of an observed cell, in voxels.
    cell: usize,
    /// Observed layers below the one that is printed next.
    depth: usize,
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
        let &HeatSettings { baseline, max_time_ratio, depth, cell } = settings;
        require(depth > 0, "depth", &depth, "at least 1")?;
        require(cell > 0, "cell", &cell, "at least 1")?;
        let ratio = max_time_ratio.unwrap_or(1.0);
        require(ratio >= 1.0 && ratio.is_finite(), "max_time_ratio", &ratio, "1 or more")?;
        let part = unprinted.part();
        if orders.len() != part.depth {
            return Err(HeatError::Layers { count: orders.len(), expected: part.depth });
        }
        let expected = orders.first().map_or(0, Vec::len);
        for (layer, candidates) in orders.iter().enumerate() {
            let count = candidates.len();
            if count != expected || baseline >= count {
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
        let fingerprint = fingerprint(&orders);
        let (mut solver, mut end_s) = (unprinted.clone(), 0.0);
        let mut layers = Vec::with_capacity(orders.len());
        for (layer, orders) in (0..).zip(orders) {
            end_s += solver.order_seconds(layer, &orders[baseline]);
            let cost = solver.deposit(layer, &orders[baseline], &Control::default())?;
            // Nothing is deposited in `unprinted`, so its orders begin without travel.
            let seconds = orders.iter().map(|order| unprinted.order_seconds(layer, order));
            layers.push(LayerTask {
                distinct: distinct(&orders),
                seconds: seconds.collect(),
                baseline_cost: cost,
                baseline_end_s: end_s,
                orders,
            });
        }
        let view = View::new(part, depth, cell);
        let end: Vec<u64> = layers.iter().map(|layer| layer.baseline_cost.to_bits()).collect();
        let identity = format!(
            "task = \"heat\"\nlayers = {}\nvoxels = {}\ncandidates = {expected}\n\
             orders = \"{fingerprint:016x}\"\nbaseline = \"{baseline}: {end:x?}\"\n\
             max_time_ratio = \"{max_time_ratio:?}\"\ndepth = {depth}\ncell = {cell}",
            part.depth,
            part.count(),
        );
        Ok(Self { identity, unprinted, layers, max_time_ratio, view })
    }

    /// Minus the cost of the baseline, K: the paper's reward, if that is what the solver minimises.
    pub fn baseline_reward(&self) -> f64 {
        -self.layers.iter().map(|layer| layer.baseline_cost).sum::<f64>()
    }

    /// Printing time of the baseline, s.
    pub fn baseline_seconds(&self) -> f64 {
        self.layers.last().map_or(0.0, |layer| layer.baseline_end_s)
    }

    /// Number of candidates of each layer.
    fn candidates(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.orders.len())
    }
}

/// Whether each candidate differs from all before it: copies are masked, so that no action is
/// learned twice.
fn distinct(candidates: &[Vec<Cell>]) -> Vec<bool> {
    let is_new = |index: usize| !candidates[..index].contains(&candidates[index]);
    (0..candidates.len()).map(is_new).collect()
}

/// A number that differs between lists of orders: FNV-1a of all of them.
fn fingerprint(orders: &[Vec<Vec<Cell>>]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |value: u64| {
        for byte in value.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for order in orders.iter().flatten() {
        add(order.len() as u64);
        order.iter().for_each(|&cell| add(u64::from(cell)));
    }
    hash
}

impl View {
    /// Shows the bounding box of a part's voxels.
    fn new(part: &Voxels, depth: usize, cell: usize) -> Self {
        let width = part.frame.width;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for filled in (0..part.depth).flat_map(|layer| part.cells(layer)) {
            for (axis, at) in [filled % width, filled / width].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
        }
        let low = low.map(|at| if at == u32::MAX { 0 } else { at });
        let size = [0, 1].map(|axis| ((high[axis] - low[axis]) as usize).div_ceil(cell).max(1));
        Self { corner: low.map(|at| at as usize), size, cell, depth }
    }

    /// Number of observed cells in a layer.
    fn cells(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Observed cell of a voxel.
    fn cell_of(&self, x: usize, y: usize) -> usize {
        (y - self.corner[1]) / self.cell * self.size[0] + (x - self.corner[0]) / self.cell
    }
}

/// The printing of a part, one layer a step; an action is the index of a candidate order.
///
/// - Observation: temperatures in the layers below, `[1, z, y, x]`, from 0 (ambient, or nothing
///   deposited) to 1 (nozzle), the highest layer last; the filled share of the layer that is
///   printed next and of the one above it, `[2, y, x]`; the share of layers that are printed, the
///   nozzle's position, from 0 to 1, and the time that may be lost in the next layer relative to
///   the baseline, as a share of the baseline's time for a layer, 0 without a limit, `[4]`.
/// - Reward: the cost of the layer when the baseline is printed in all layers, minus the actual
///   one, K, as the [`Solver`] defines costs; the paper's is the standard deviation of all
///   deposited voxels at the layer's end.
///   So the reward is minus the cost plus a number that depends on the layer alone.
///   As every episode has all layers, no policy gains or loses by it, but the critic need not learn
///   what the layer alone explains.
///   The return is what the plan gains over the baseline.
/// - An episode ends after the last layer; all episodes start alike, whatever their seed.
/// - Candidates that repeat an earlier one of their layer are masked, and those that exceed
///   [`HeatSettings::max_time_ratio`].
#[derive(Clone, Debug)]
pub struct HeatEnvironment {
    task: Arc<HeatTask>,
    solver: Solver,
    layer: usize,
    /// Printing time so far, s.
    seconds: f64,
    /// Position of the last voxel, from 0 to 1 along x and y.
    nozzle: [f32; 2],
}

impl HeatEnvironment {
    /// An environment before the first layer.
    pub fn new(task: Arc<HeatTask>) -> Self {
        let solver = task.unprinted.clone();
        Self { task, solver, layer: 0, seconds: 0.0, nozzle: [0.0; 2] }
    }

    /// The state of the print.
    pub fn solver(&self) -> &Solver {
        &self.solver
    }

    /// Printing time so far, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Time that is left for the next layer, s; infinite without a limit.
    fn time_left_s(&self, layer: &LayerTask) -> f64 {
        let ratio = self.task.max_time_ratio.unwrap_or(f64::INFINITY);
        ratio * layer.baseline_end_s - self.seconds
    }

    /// Which candidates of a layer may be printed next.
    fn permitted(&self, layer: &LayerTask) -> Vec<bool> {
        let mut permitted = layer.distinct.clone();
        if self.task.max_time_ratio.is_none() {
            return permitted;
        }
        let limit = self.time_left_s(layer);
        let number = self.layer as u32;
        let seconds = |(order, own): (&Vec<Cell>, &f64)| {
            // The travel to the first cell is what printing it alone takes longer than in an
            // unprinted part.
            let first = &order[..order.len().min(1)];
            let travel = self.solver.order_seconds(number, first)
                - self.task.unprinted.order_seconds(number, first);
            own + travel
        };
        let seconds: Vec<f64> = layer.orders.iter().zip(&layer.seconds).map(seconds).collect();
        for (permitted, &seconds) in permitted.iter_mut().zip(&seconds) {
            *permitted &= seconds <= limit;
        }
        if !permitted.contains(&true) {
            let fastest = (0..seconds.len()).min_by(|&a, &b| seconds[a].total_cmp(&seconds[b]));
            permitted[fastest.unwrap_or(0)] = true;
        }
        permitted
    }

    fn observation(&self) -> Observation {
        let HeatTask { view, layers, .. } = &*self.task;
        let part = self.solver.part();
        let width = part.frame.width as usize;
        let place = |cell: Cell| view.cell_of(cell as usize % width, cell as usize / width);

        let process = self.solver.process();
        let (ambient, range) = (process.ambient_c, process.extrusion_c - process.ambient_c);
        let mut field = vec![0.0; view.depth * view.cells()];
        for (slot, of_layer) in field.chunks_exact_mut(view.cells()).enumerate() {
            let Some(layer) = (self.layer + slot).checked_sub(view.depth) else { continue };
            let mut counts = vec![0_u32; view.cells()];
            for (cell, celsius) in self.solver.simulation().cell_temperatures_c(layer as u32) {
                of_layer[place(cell)] += ((celsius - ambient) / range) as f32;
                counts[place(cell)] += 1;
            }
            for (sum, &count) in of_layer.iter_mut().zip(&counts) {
                *sum /= count.max(1) as f32;
            }
        }

        let mut designs = vec![0.0; 2 * view.cells()];
        let share = 1.0 / (view.cell * view.cell) as f32;
        for (of_layer, layer) in designs.chunks_exact_mut(view.cells()).zip(self.layer..) {
            if layer < part.depth {
                part.cells(layer).for_each(|cell| of_layer[place(cell)] += share);
            }
        }

        let printed = self.layer as f32 / part.depth as f32;
        let next = layers.get(self.layer);
        let slack = |layer: &LayerTask| {
            let before =
                self.layer.checked_sub(1).map_or(0.0, |below| layers[below].baseline_end_s);
            let baseline_s = layer.baseline_end_s - before;
            let slack = (self.time_left_s(layer) - baseline_s) / baseline_s;
            if slack.is_finite() { slack as f32 } else { 0.0 }
        };
        let vector = vec![printed, self.nozzle[0], self.nozzle[1], next.map_or(0.0, slack)];
        // After the last layer nothing is chosen.
        let permitted =
            next.map_or_else(|| vec![true; self.task.candidates()], |layer| self.permitted(layer));
        Observation { tensors: vec![field, designs, vector], permitted }
    }
}

impl Environment for HeatEnvironment {
    fn identity(&self) -> String {
        self.task.identity.clone()
    }

    fn space(&self) -> Space {
        let View { size: [x, y], depth, .. } = self.task.view;
        let (x, y, depth) = (x as i64, y as i64, depth as i64);
        Space {
            observation: vec![vec![1, depth, y, x], vec![2, y, x], vec![4]],
            actions: self.task.candidates(),
        }
    }

    fn reset(&mut self, _: u64) -> Observation {
        *self = Self::new(self.task.clone());
        self.observation()
    }

    /// # Panics
    /// If there is no such action, if its order does not hold all cells of the layer, or if all
    /// layers are printed.
    fn step(&mut self, action: usize) -> Step {
        let task = self.task.clone();
        let layer = &task.layers[self.layer];
        let order = &layer.orders[action];
        self.seconds += self.solver.order_seconds(self.layer as u32, order);
        let cost = self
            .solver
            .deposit(self.layer as u32, order, &Control::default())
            .expect("a candidate is an order of its layer");
        let frame = &self.solver.part().frame;
        if let Some(&last) = order.last() {
            let share = |at: u32, count: u32| at as f32 / count as f32;
            let (x, y) = (last % frame.width, last / frame.width);
            self.nozzle = [share(x, frame.width), share(y, frame.height)];
        }
        let reward = layer.baseline_cost - cost;
        self.layer += 1;
        let end = (self.layer == task.layers.len()).then_some(EpisodeEnd::Terminated);
        Step { observation: self.observation(), reward, end }
    }
}
