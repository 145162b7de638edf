//! The environment that prints a part, one layer a step.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_heat::model::{Solver, ThermalModel};

use super::super::environment::{Environment, EpisodeEnd, Observation, Space, Step};
use super::task::{HeatTask, LayerTask};

/// The printing of a part, one layer a step; an action is the index of a candidate order.
///
/// - Observation: temperatures in the layers below, `[1, z, y, x]`, from 0 (ambient, or nothing
///   deposited) to 1 (nozzle), the highest layer last; the filled share of the layer that is
///   printed next and of the one above it, `[2, y, x]`; the share of layers that are printed, the
///   nozzle's position, from 0 to 1, and the time that may be lost in the next layer relative to
///   the baseline, as a share of the baseline's time for a layer, 0 without a limit, `[4]`.
///   With a [window](super::HeatSettings::window) there are two more numbers, the size of observed
///   cells and the number of layers, that share is from 0 to 1, 1 without a limit, and a last
///   tensor has five numbers for each candidate, `[candidates, 5]`: its printing time and two crude
///   estimates of its unevenness, all relative to the baseline's, and the position of its end.
///   With [estimates](super::HeatSettings::estimated), the two are the estimate of its cost
///   relative to the baseline's, and how far it is above the lowest one, from 0 to 3, the price of
///   time included.
/// - Reward: the cost of the layer when the baseline is printed in all layers, minus the actual
///   one, K (or percent of the part's, [`relative`](super::HeatSettings::relative)), as the
///   [`Solver`] defines costs; the paper's is the standard deviation of all deposited voxels at the
///   layer's end.
///   So the reward is minus the cost plus a number that depends on the layer alone.
///   As every episode has all layers, no policy gains or loses by it, but the critic need not learn
///   what the layer alone explains.
///   The return is what the plan gains over the baseline.
///   With a [price of time](super::TimePrice), each second beyond the baseline's time for the layer
///   is subtracted at that price; episodes still [score](Environment::score) what they gain.
/// - An episode ends after the last layer; all episodes start alike, whatever their seed.
/// - Candidates that repeat an earlier one of their layer are masked, and those that exceed
///   [`max_time_ratio`](super::HeatSettings::max_time_ratio).
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

    /// Number of layers that are printed.
    pub fn printed(&self) -> usize {
        self.layer
    }

    /// Time that is left for the next layer, s; infinite without a limit.
    fn time_left_s(&self, layer: &LayerTask) -> f64 {
        let ratio = self.task.settings.max_time_ratio.unwrap_or(f64::INFINITY);
        ratio * layer.baseline_end_s - self.seconds
    }

    /// Time that printing each candidate of a layer would take, with travel, s.
    pub(super) fn candidate_seconds(&self, layer: &LayerTask) -> Vec<f64> {
        let seconds = |(order, own): (&Vec<Cell>, &f64)| {
            let ends = self.solver.last_cell().zip(order.first());
            own + ends.map_or(0.0, |(from, &to)| self.task.travel_s(from, to))
        };
        layer.orders.iter().zip(&layer.seconds).map(seconds).collect()
    }

    /// Which candidates of a layer, which take these times, may be printed next.
    fn permitted(&self, layer: &LayerTask, seconds: &[f64]) -> Vec<bool> {
        let mut permitted = layer.distinct.clone();
        let limit = self.time_left_s(layer);
        for (permitted, &seconds) in permitted.iter_mut().zip(seconds) {
            *permitted &= seconds <= limit;
        }
        if !permitted.contains(&true) {
            let fastest = (0..seconds.len()).min_by(|&a, &b| seconds[a].total_cmp(&seconds[b]));
            permitted[fastest.unwrap_or(0)] = true;
        }
        permitted
    }

    /// Whether each candidate of the next layer can be completed by the baseline in the layers
    /// above, such that the whole print takes at most `max_seconds`.
    pub(super) fn completable(&self, max_seconds: f64) -> Vec<bool> {
        let task = &self.task;
        let baseline = task.settings.baseline;
        let cells = |layer: &LayerTask| {
            Some((*layer.orders[baseline].first()?, *layer.orders[baseline].last()?))
        };
        let above = &task.layers[self.layer + 1..];
        // Of the layers above with cells, the baseline's first cell, and the time without travel to
        // it.
        let mut first = None;
        let mut seconds = 0.0;
        let mut last = None;
        for layer in above {
            let Some((begin, end)) = cells(layer) else { continue };
            seconds += layer.seconds[baseline];
            seconds += last.map_or(0.0, |last| task.travel_s(last, begin));
            first = first.or(Some(begin));
            last = Some(end);
        }
        let layer = &task.layers[self.layer];
        let times = self.candidate_seconds(layer);
        let total = |(order, own): (&Vec<Cell>, f64)| {
            let ends = order.last().zip(first);
            let travel = ends.map_or(0.0, |(&from, to)| task.travel_s(from, to));
            self.seconds + own + travel + seconds
        };
        layer.orders.iter().zip(times).map(|of| total(of) <= max_seconds).collect()
    }

    /// The numbers that describe each candidate of a layer, which take the given times.
    fn described(&self, layer: &LayerTask, seconds: &[f64]) -> Vec<f32> {
        let task = &self.task;
        let baseline = task.settings.baseline;
        let width = self.solver.part().frame.width;
        let relative = |value: f64, baseline: f64, factor: f64| {
            let relative = if baseline > 0.0 { value / baseline - 1.0 } else { 0.0 };
            (factor * relative).clamp(-3.0, 3.0) as f32
        };
        let missed = missed(layer, seconds, task.time_price);
        let mut numbers = Vec::with_capacity(5 * seconds.len());
        for (candidate, order) in layer.orders.iter().enumerate() {
            let uneven = |measure: usize| {
                let of = |candidate: usize| layer.unevenness[candidate][measure];
                relative(of(candidate), of(baseline), 4.0)
            };
            let estimate = |candidate: usize| layer.estimates[candidate];
            numbers.push(relative(seconds[candidate], seconds[baseline], 10.0));
            numbers.extend(match missed.get(candidate) {
                Some(&missed) => [relative(estimate(candidate), estimate(baseline), 4.0), missed],
                None => [uneven(0), uneven(1)],
            });
            let last = order.last().map_or(0, |&cell| cell);
            numbers.extend(task.view.share_of([last % width, last / width]));
        }
        numbers
    }

    fn observation(&self) -> Observation {
        let HeatTask { view, layers, settings, .. } = &*self.task;
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
            let baseline_s = self.task.baseline_layer_s(self.layer);
            let slack = (self.time_left_s(layer) - baseline_s) / baseline_s;
            if slack.is_finite() { slack as f32 } else { 0.0 }
        };
        let mut vector = vec![printed, self.nozzle[0], self.nozzle[1], next.map_or(0.0, slack)];
        let seconds = next.map_or_else(Vec::new, |layer| self.candidate_seconds(layer));
        let mut tensors = vec![field, designs];
        if settings.window.is_some() {
            if settings.max_time_ratio.is_some() {
                vector[3] = vector[3].clamp(0.0, 1.0);
            } else {
                vector[3] = 1.0;
            }
            vector.extend([view.cell as f32 / 8.0, part.depth as f32 / 64.0]);
            let described = next.map(|layer| self.described(layer, &seconds));
            let none = || vec![0.0; 5 * self.task.candidates()];
            tensors.extend([vector, described.unwrap_or_else(none)]);
        } else {
            tensors.push(vector);
        }
        // After the last layer nothing is chosen.
        let all = || vec![true; self.task.candidates()];
        let permitted = next.map_or_else(all, |layer| self.permitted(layer, &seconds));
        Observation { tensors, permitted }
    }
}

/// How far the estimate of each candidate, which takes the given time, is above the lowest one, the
/// price of time included: the root of the difference in standard deviations of all estimates, from
/// 0 to 3. The root makes differences between good candidates large.
/// Empty without estimates.
fn missed(layer: &LayerTask, seconds: &[f64], time_price: f64) -> Vec<f32> {
    let score = |(estimate, seconds): (&f64, &f64)| estimate + time_price * seconds;
    let scores: Vec<f64> = layer.estimates.iter().zip(seconds).map(score).collect();
    let lowest = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let count = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / count;
    let variance = scores.iter().map(|score| (score - mean) * (score - mean)).sum::<f64>() / count;
    let share = |score: f64| {
        if variance > 0.0 {
            ((score - lowest) / variance.sqrt()).sqrt().min(3.0) as f32
        } else {
            0.0
        }
    };
    scores.into_iter().map(share).collect()
}

impl Environment for HeatEnvironment {
    fn identity(&self) -> String {
        self.task.identity()
    }

    fn space(&self) -> Space {
        let task = &self.task;
        let candidates = task.candidates();
        Space { observation: task.settings.shapes(task.view.size, candidates), actions: candidates }
    }

    fn reset(&mut self, _: u64) -> Observation {
        *self = Self::new(self.task.clone());
        self.observation()
    }

    /// # Panics
    /// If the action is out of range, if its order lacks a cell of the layer, or if all layers are
    /// printed.
    fn step(&mut self, action: usize) -> Step {
        let task = self.task.clone();
        let layer = &task.layers[self.layer];
        let order = &layer.orders[action];
        let before_s = self.seconds;
        self.seconds += self.solver.path_seconds(self.layer as u32, order);
        let deposit = |solver: &mut Solver| {
            solver
                .deposit(self.layer as u32, order, &Control::default())
                .expect("a candidate is an order of its layer")
        };
        let cost = if order.is_empty() { 0.0 } else { deposit(&mut self.solver) };
        let frame = &self.solver.part().frame;
        if let Some(&last) = order.last() {
            let share = |at: u32, count: u32| at as f32 / count as f32;
            let (x, y) = (last % frame.width, last / frame.width);
            self.nozzle = match task.settings.window {
                Some(_) => task.view.share_of([x, y]),
                None => [share(x, frame.width), share(y, frame.height)],
            };
        }
        let excess_s = self.seconds - before_s - task.baseline_layer_s(self.layer);
        let reward = task.reward_scale * (layer.baseline_cost - cost - task.time_price * excess_s);
        self.layer += 1;
        let end = (self.layer == task.layers.len()).then_some(EpisodeEnd::Terminated);
        Step { observation: self.observation(), reward, end }
    }

    /// What the plan gains over the baseline, without the price of time.
    fn score(&self, rewards: f64) -> f64 {
        let task = &self.task;
        let excess_s = self.seconds - task.baseline_seconds();
        rewards + task.reward_scale * task.time_price * excess_s
    }
}
