//! A linear model of a layer, and the order of lines that it calls most even, line by line.
//!
//! This is the method of SmartScan (Ramani et al. 2022), made for laser powder bed fusion, for
//! comparison: a linear model of the heat equation, reduced in size, predicts the temperatures
//! after each of the features that are left, and the one that leaves the most even temperatures
//! comes next.
//! Features are lines here.
//! The model is reduced by blocks of cells and levels of layers instead of by a singular value
//! decomposition, and the layer is complete from the start, as a bed of powder is.

use beadwork_grid::Cell;
use beadwork_thermal::{Simulation, ThermalMaterial};

use super::coefficients::Coefficients;
use super::geometry::{Blocks, Extent};
use super::stepper::{State, Stepper};
use super::{RATIO, start};

/// Layers of each level below the printed layer, from the top.
const LEVELS: [usize; 8] = [1, 1, 2, 2, 3, 4, 6, 8];

/// Maximum number of blocks of a level, which bounds the memory for the effects of all lines.
const MAX_BLOCKS: usize = 1 << 12;

/// A linear model of a layer of which nothing is deposited yet.
#[derive(Clone, Debug)]
pub struct LinearLayer {
    coefficients: Coefficients,
    level_k: Vec<f64>,
    blocks: Blocks,
    start: State,
    /// Cells in a row of the part's frame.
    width: u32,
    /// Time to deposit a cell, s.
    cell_s: f64,
}

/// What a line does.
struct Effect {
    /// Steps that its deposition takes.
    steps: usize,
    /// Temperatures of the printed layer at its end, less their mean, K.
    rise: Vec<f32>,
    /// Sum of their squares over the voxels of the layer.
    squares: f64,
}

/// Steps of one length.
struct Model {
    stepper: Stepper,
    /// What a step makes of temperatures of 0.
    constant: Vec<Vec<f32>>,
    /// What the filament adds to the temperature of a voxel, K.
    rise_k: f32,
}

impl LinearLayer {
    /// The model of a layer of which nothing is deposited yet.
    ///
    /// Takes time and memory linear in the voxels of the part's bounding box.
    ///
    /// # Panics
    /// If the part has no such layer.
    pub fn new(simulation: &Simulation, layer: u32, material: &ThermalMaterial) -> Self {
        let (part, process) = (simulation.part(), simulation.process());
        let extent = Extent::new(part, layer as usize, &LEVELS);
        let coefficients = Coefficients::new(&part.frame, material, process);
        let theta = simulation.temperatures_c() - process.ambient_c;
        let mut blocks = Blocks::new(part, &extent, 2);
        while blocks.len() > MAX_BLOCKS {
            blocks = blocks.coarser(&extent);
        }
        let mut start = start(&blocks, &extent, theta.view());
        // The layer begins at the temperatures of what is below it.
        let plate = coefficients.plate_k.unwrap_or(0.0) as f32;
        start.theta[0] = start.theta.get(1).cloned().unwrap_or_else(|| vec![plate; blocks.len()]);
        start.deposited.fill(1.0);
        let sides =
            |(&sides, &voxels): (&f32, &f32)| if voxels > 0.0 { sides / voxels } else { 0.0 };
        let layer = &blocks.levels[0];
        start.open_sides = layer.sides.iter().zip(&layer.voxels).map(sides).collect();
        let levels = blocks.levels.iter().zip(&start.theta);
        let level_k: Vec<f64> =
            levels.map(|(level, theta)| weighted_mean(&level.voxels, theta)).collect();
        let coefficients = coefficients.linear(level_k[0]);
        let cell_s = part.frame.cell_mm / process.print_mm_s;
        Self { coefficients, level_k, blocks, start, width: part.frame.width, cell_s }
    }

    /// The numbers of the lines, each next one such that the layer's temperatures at its end are
    /// most even; of equal ones, the first.
    ///
    /// For n lines and b blocks, takes O(n² b) time and O(n b) memory; there are at most 4,096
    /// blocks.
    ///
    /// # Panics
    /// If a line has a cell outside of the layer's bounding box.
    pub fn greedy_sequence(&self, lines: &[&[Cell]]) -> Vec<usize> {
        let Some(model) = self.model(lines) else { return Vec::new() };
        let effects: Vec<Effect> = lines.iter().map(|line| self.effect(&model, line)).collect();
        let longest = effects.iter().map(|effect| effect.steps).max().unwrap_or(0);
        let voxels = &self.blocks.levels[0].voxels;
        let mut state = self.start.clone();
        let mut left: Vec<usize> = (0..lines.len()).collect();
        let mut sequence = Vec::with_capacity(lines.len());
        while !left.is_empty() {
            // Temperatures after each number of steps without any line.
            let mut states = vec![state.clone()];
            for steps in 0..longest {
                states.push(stepped(&model.stepper, &states[steps]));
            }
            let centred: Vec<Vec<f32>> =
                states.iter().map(|state| centred(voxels, &state.theta[0])).collect();
            let squares: Vec<f64> =
                centred.iter().map(|theta| product(voxels, theta, theta)).collect();
            let score = |&line: &usize| {
                let Effect { steps, rise, squares: own } = &effects[line];
                squares[*steps] + 2.0 * product(voxels, &centred[*steps], rise) + own
            };
            let scores: Vec<f64> = left.iter().map(score).collect();
            let best = (0..left.len())
                .min_by(|&a, &b| scores[a].total_cmp(&scores[b]))
                .expect("lines are left");
            let line = left.remove(best);
            let mut after = states.swap_remove(effects[line].steps);
            let effect = self.whole_effect(&model, lines[line], effects[line].steps);
            for (theta, rise) in after.theta.iter_mut().zip(&effect.theta) {
                theta.iter_mut().zip(rise).for_each(|(theta, rise)| *theta += rise);
            }
            state = after;
            sequence.push(line);
        }
        sequence
    }

    /// Steps that are about as long as a line takes, but stable; `None` without cells.
    fn model(&self, lines: &[&[Cell]]) -> Option<Model> {
        let cells: usize = lines.iter().map(|line| line.len()).sum();
        if cells == 0 {
            return None;
        }
        let side = f64::from(self.blocks.side);
        let longest_s = RATIO * side * side / self.coefficients.lateral;
        let step_s = longest_s.min(self.cell_s * cells as f64 / lines.len() as f64);
        let stepper = Stepper::new(&self.blocks, &self.coefficients, &self.level_k, step_s);
        let Coefficients { birth_k, hold, .. } = self.coefficients;
        let rise_k = ((1.0 + hold) * (birth_k - self.level_k[0])) as f32;
        let constant = stepped(&stepper, &self.zero()).theta;
        Some(Model { stepper, constant, rise_k })
    }

    /// Temperatures of 0 everywhere.
    fn zero(&self) -> State {
        let mut zero = self.start.clone();
        zero.theta.iter_mut().for_each(|theta| theta.fill(0.0));
        zero
    }

    /// What a line does to all levels by its end, half of its time after its deposition.
    ///
    /// It is computed again for the line that is chosen, since all levels of all lines would take
    /// too much memory.
    fn whole_effect(&self, model: &Model, line: &[Cell], steps: usize) -> State {
        let mut state = self.zero();
        for &cell in line {
            let block = self.blocks.block([cell % self.width, cell / self.width]);
            state.theta[0][block] += model.rise_k / self.blocks.levels[0].voxels[block];
        }
        for _ in 0..steps.div_ceil(2) {
            state = stepped(&model.stepper, &state);
            for (theta, constant) in state.theta.iter_mut().zip(&model.constant) {
                theta.iter_mut().zip(constant).for_each(|(theta, constant)| *theta -= constant);
            }
        }
        state
    }

    fn effect(&self, model: &Model, line: &[Cell]) -> Effect {
        let seconds = self.cell_s * line.len() as f64;
        let steps = (seconds / model.stepper.step_s).round().max(1.0) as usize;
        let whole = self.whole_effect(model, line, steps);
        let voxels = &self.blocks.levels[0].voxels;
        let rise = centred(voxels, &whole.theta[0]);
        let squares = product(voxels, &rise, &rise);
        Effect { steps, rise, squares }
    }
}

/// The state after a step.
fn stepped(stepper: &Stepper, state: &State) -> State {
    let (mut state, mut next) = (state.clone(), state.theta.clone());
    stepper.step(&mut state, &mut next, &mut Vec::new());
    state
}

fn weighted_mean(voxels: &[f32], theta: &[f32]) -> f64 {
    let count: f64 = voxels.iter().map(|&voxels| f64::from(voxels)).sum();
    let sum: f64 = voxels
        .iter()
        .zip(theta)
        .map(|(&voxels, &theta)| f64::from(voxels) * f64::from(theta))
        .sum();
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Temperatures less their mean over the voxels.
fn centred(voxels: &[f32], theta: &[f32]) -> Vec<f32> {
    let mean = weighted_mean(voxels, theta) as f32;
    theta.iter().map(|theta| theta - mean).collect()
}

/// Sum of products over the voxels.
fn product(voxels: &[f32], a: &[f32], b: &[f32]) -> f64 {
    let terms = voxels.iter().zip(a).zip(b);
    terms.map(|((&voxels, &a), &b)| f64::from(voxels * a * b)).sum()
}

#[cfg(test)]
mod tests {
    use beadwork_base::Control;
    use beadwork_part::{LineOrder, Pattern};
    use beadwork_thermal::ProcessParameters;
    use beadwork_thermal::simulation::Method;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::tests::random_part;
    use super::*;

    /// As [`LinearLayer::greedy_sequence`], but steps the model with each line that is left.
    fn slow_sequence(linear: &LinearLayer, lines: &[&[Cell]]) -> (Vec<usize>, Vec<Vec<f64>>) {
        let model = linear.model(lines).unwrap();
        let voxels = &linear.blocks.levels[0].voxels;
        let unevenness = |state: &State| {
            let theta = |block: usize| f64::from(state.theta[0][block]);
            let weight = |block: usize| f64::from(voxels[block]);
            let count: f64 = (0..voxels.len()).map(weight).sum();
            let mean =
                (0..voxels.len()).map(|block| weight(block) * theta(block)).sum::<f64>() / count;
            (0..voxels.len())
                .map(|block| weight(block) * (theta(block) - mean).powi(2))
                .sum::<f64>()
        };
        let after = |state: &State, line: &[Cell]| {
            let steps = linear.effect(&model, line).steps;
            let mut state = state.clone();
            for step in 0..steps {
                // The whole line at once, when half of its steps are left.
                if step == steps / 2 {
                    for &cell in line {
                        let block = linear.blocks.block([cell % linear.width, cell / linear.width]);
                        state.theta[0][block] += model.rise_k / voxels[block];
                    }
                }
                state = stepped(&model.stepper, &state);
            }
            state
        };
        let mut state = linear.start.clone();
        let mut left: Vec<usize> = (0..lines.len()).collect();
        let (mut sequence, mut all_scores) = (Vec::new(), Vec::new());
        while !left.is_empty() {
            let states: Vec<State> = left.iter().map(|&line| after(&state, lines[line])).collect();
            let scores: Vec<f64> = states.iter().map(unevenness).collect();
            let best = (0..left.len()).min_by(|&a, &b| scores[a].total_cmp(&scores[b])).unwrap();
            state = states[best].clone();
            sequence.push(left.remove(best));
            all_scores.push(scores);
        }
        (sequence, all_scores)
    }

    #[test]
    fn the_next_line_is_that_after_which_the_model_is_most_even() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        let mut same = 0;
        for _ in 0..60 {
            let part = random_part(&mut rng);
            let layer = rng.next_u64() as usize % 6;
            if part.cells(layer).next().is_none() {
                continue;
            }
            let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
            let mut print =
                Simulation::new(part.clone(), &abs, &process, Method::default()).unwrap();
            for below in (0..layer).filter(|&below| part.cells(below).next().is_some()) {
                let order = Pattern::CONVENTIONAL.order(&part.region(below).unwrap());
                print.deposit(below as u32, &order, &Control::default()).unwrap();
            }
            let linear = LinearLayer::new(&print, layer as u32, &abs);
            let order: LineOrder = "lines-x-golden-0".parse().unwrap();
            let lines = order.lines(&part.region(layer).unwrap());
            let lines: Vec<&[Cell]> = lines.iter().collect();
            let sequence = linear.greedy_sequence(&lines);
            let (slow, scores) = slow_sequence(&linear, &lines);
            // Equal scores may be rounded differently; from there on, sequences differ.
            match (0..slow.len()).find(|&at| sequence[at] != slow[at]) {
                None => same += 1,
                Some(at) => {
                    let mut left: Vec<usize> = (0..lines.len()).collect();
                    left.retain(|line| !slow[..at].contains(line));
                    let score =
                        |line| scores[at][left.iter().position(|&other| other == line).unwrap()];
                    let (own, best) = (score(sequence[at]), score(slow[at]));
                    assert!(own - best <= 1e-3 * best.max(1.0), "{own} {best}");
                }
            }
            let mut sorted = sequence.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..lines.len()).collect::<Vec<_>>());
        }
        assert!(same > 20, "{same}");
    }
}
