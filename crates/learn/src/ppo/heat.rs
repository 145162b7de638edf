//! The environment of the paper on toolpaths for even temperature (Kim et al. 2026): a step prints
//! a layer.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_thermal::Simulation;
use beadwork_thermal::simulation::DepositError;
use thiserror::Error;

use super::environment::{Environment, EpisodeEnd, Observation, Space, Step};

/// Candidates for the order of each layer of a part, of which an agent chooses.
///
/// Environments share it by an [`Arc`].
#[derive(Debug)]
pub struct HeatTask {
    identity: String,
    /// Nothing is deposited yet.
    unprinted: Simulation,
    /// For each layer, the candidates.
    orders: Vec<Vec<Vec<Cell>>>,
    /// For each layer, whether each candidate may be chosen.
    permitted: Vec<Vec<bool>>,
    /// Standard deviation at the end of each layer when the baseline is printed, K.
    baseline_std_k: Vec<f64>,
    view: View,
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
    /// The observation has no depth, or its cells have no size.
    #[error("observation of {depth} layers in cells of {cell} voxels: expected at least 1 and 1")]
    View {
        /// Layers of the observation.
        depth: usize,
        /// Side of its cells, in voxels.
        cell: usize,
    },
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
    /// A task that prints a part, from a simulation in which nothing is deposited.
    ///
    /// `orders` holds for each layer the same number of candidates, each with all cells of its
    /// layer.
    /// `baseline` is the index of the candidate with which rewards are compared.
    /// An observation shows `depth` layers below the one that is printed next, in cells of `cell` x
    /// `cell` voxels.
    ///
    /// Simulates the part once, with the baseline.
    pub fn new(
        unprinted: Simulation,
        orders: Vec<Vec<Vec<Cell>>>,
        baseline: usize,
        depth: usize,
        cell: usize,
    ) -> Result<Self, HeatError> {
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
        }
        if depth == 0 || cell == 0 {
            return Err(HeatError::View { depth, cell });
        }
        let mut simulation = unprinted.clone();
        let mut baseline_std_k = Vec::new();
        let mut permitted = Vec::new();
        for (layer, candidates) in orders.iter().enumerate() {
            let cells: Vec<Cell> = part.cells(layer).collect();
            for (candidate, order) in candidates.iter().enumerate() {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                if sorted != cells {
                    return Err(HeatError::Order { layer, candidate });
                }
            }
            simulation.deposit(layer as u32, &candidates[baseline], &Control::default())?;
            baseline_std_k.push(std_k(&simulation));
            permitted.push(distinct(candidates));
        }
        let identity = format!(
            "task = \"heat\"\nlayers = {}\nvoxels = {}\ncandidates = {expected}\nfingerprint = \
             {:?}\ndepth = {depth}\ncell = {cell}",
            part.depth,
            part.count(),
            fingerprint(&orders, &baseline_std_k),
        );
        let view = View::new(part, depth, cell);
        Ok(Self { identity, unprinted, orders, permitted, baseline_std_k, view })
    }

    /// The paper's reward when the baseline is printed, °C: minus the sum of the standard
    /// deviations at the ends of the layers.
    pub fn baseline_reward(&self) -> f64 {
        -self.baseline_std_k.iter().sum::<f64>()
    }
}

/// Whether each candidate differs from all before it: copies are masked, so that no action is
/// learned twice.
fn distinct(candidates: &[Vec<Cell>]) -> Vec<bool> {
    let is_new = |index: usize| !candidates[..index].contains(&candidates[index]);
    (0..candidates.len()).map(is_new).collect()
}

/// A number that differs between tasks: FNV-1a of all orders and of the baseline's deviations.
fn fingerprint(orders: &[Vec<Vec<Cell>>], baseline_std_k: &[f64]) -> String {
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
    baseline_std_k.iter().for_each(|std_k| add(std_k.to_bits()));
    format!("{hash:016x}")
}

/// Standard deviation of all deposited voxels, K.
fn std_k(simulation: &Simulation) -> f64 {
    simulation.statistics().map_or(0.0, |all| all.std_c)
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
///   printed next and of the one above it, `[2, y, x]`; the share of layers that are printed and
///   the nozzle's position, from 0 to 1, `[3]`.
/// - Reward: the standard deviation of all deposited voxels at the layer's end when the baseline is
///   printed in all layers, minus the actual one, K. It is the paper's reward plus a number that
///   depends on the layer alone.
///   As every episode has all layers, no policy gains or loses by it, but the critic need not learn
///   what the layer alone explains.
///   The return is what the plan gains over the baseline.
/// - An episode ends after the last layer; all episodes start alike, whatever their seed.
/// - Candidates that repeat an earlier one of their layer are masked.
#[derive(Clone, Debug)]
pub struct HeatEnvironment {
    task: Arc<HeatTask>,
    simulation: Simulation,
    layer: usize,
    /// Position of the last voxel, from 0 to 1 along x and y.
    nozzle: [f32; 2],
}

impl HeatEnvironment {
    /// An environment before the first layer.
    pub fn new(task: Arc<HeatTask>) -> Self {
        let simulation = task.unprinted.clone();
        Self { task, simulation, layer: 0, nozzle: [0.0; 2] }
    }

    fn observation(&self) -> Observation {
        let HeatTask { view, orders, permitted, .. } = &*self.task;
        let part = self.simulation.part();
        let width = part.frame.width as usize;
        let place = |cell: Cell| view.cell_of(cell as usize % width, cell as usize / width);

        let process = self.simulation.process();
        let (ambient, range) = (process.ambient_c, process.extrusion_c - process.ambient_c);
        let mut field = vec![0.0; view.depth * view.cells()];
        for (slot, of_layer) in field.chunks_exact_mut(view.cells()).enumerate() {
            let Some(layer) = (self.layer + slot).checked_sub(view.depth) else { continue };
            let mut counts = vec![0_u32; view.cells()];
            for (cell, celsius) in self.simulation.cell_temperatures_c(layer as u32) {
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
        let vector = vec![printed, self.nozzle[0], self.nozzle[1]];
        // After the last layer nothing is chosen.
        let none = || vec![true; orders.first().map_or(0, Vec::len)];
        let permitted = permitted.get(self.layer).cloned().unwrap_or_else(none);
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
            observation: vec![vec![1, depth, y, x], vec![2, y, x], vec![3]],
            actions: self.task.orders.first().map_or(0, Vec::len),
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
        let order = &task.orders[self.layer][action];
        self.simulation
            .deposit(self.layer as u32, order, &Control::default())
            .expect("a candidate is an order of its layer");
        let frame = &self.simulation.part().frame;
        if let Some(&last) = order.last() {
            let share = |at: u32, count: u32| at as f32 / count as f32;
            let (x, y) = (last % frame.width, last / frame.width);
            self.nozzle = [share(x, frame.width), share(y, frame.height)];
        }
        let reward = task.baseline_std_k[self.layer] - std_k(&self.simulation);
        self.layer += 1;
        let end = (self.layer == task.orders.len()).then_some(EpisodeEnd::Terminated);
        Step { observation: self.observation(), reward, end }
    }
}
