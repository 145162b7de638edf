//! A fast estimate of the deviation of temperatures at a layer's end.
//!
//! Two facts make an estimate some twenty times faster than the heat equation:
//!
//! - **What was printed long ago has spread.**
//!   Heat that is `t` seconds old is spread over about `2 √(α t)`, so the beginning of a layer is
//!   computed on large blocks with long steps, and only its last second on single cells.
//! - **Layers below change slowly.**
//!   Levels of one to eight layers take their place.
//!
//! A [`LayerProxy`] solves the heat equation on these blocks by finite volumes: an explicit step
//! sideways, then an implicit one up and down, with births, build plate, convection and radiation.
//! Its steps have a fixed diffusion number, so a phase of eight steps on blocks of one size covers
//! four times the time of a phase on blocks half as wide.
//!
//! Estimates are off by 5 to 15 % and more in the first layer, but rank orders nearly as the solver
//! does; `docs/results/heat.md` has the correlations.

mod assembly;
mod coefficients;
mod geometry;
mod linear;
mod moments;
mod plane;
mod stepper;

use beadwork_thermal::{DepositionEvent, Simulation, ThermalMaterial};

use self::coefficients::Coefficients;
use self::geometry::{Blocks, Extent};
pub use self::linear::LinearLayer;
use self::moments::moments;
use self::stepper::{State, Stepper};

/// Diffusion number of the steps: diffusivity times step over the square of a block's side.
const RATIO: f64 = 0.2;

/// Number of sizes of blocks: 1, 2, 4 and 8 cells wide.
const SIZES: usize = 4;

/// Steps on blocks of each size before the layer's end; those on the largest begin with the layer.
const STEPS: [usize; SIZES - 1] = [4, 8, 8];

/// An estimate of the temperatures of one layer, from the state of a print before it.
///
/// ```
/// # use std::sync::Arc;
/// # use beadwork_base::Control;
/// # use beadwork_heat::proxy::LayerProxy;
/// # use beadwork_part::slice::Voxels;
/// # use beadwork_part::{Frame, Pattern};
/// # use beadwork_thermal::simulation::Method;
/// # use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
/// # let (left_mm, back_mm) = (0.0, 0.0);
/// # let (cell_mm, layer_mm, width, height) = (0.5, 0.25, 30, 20);
/// # let frame = Frame { left_mm, back_mm, cell_mm, layer_mm, width, height };
/// # let part = Arc::new(Voxels::new(frame, ndarray::Array3::zeros((4, 20, 30))));
/// # let (abs, process) = (ThermalMaterial::abs(), ProcessParameters::default());
/// # let mut simulation = Simulation::new(part.clone(), &abs, &process, Method::default())?;
/// # for layer in 0..3 {
/// #     let order = Pattern::CONVENTIONAL.order(&part.region(layer as usize)?);
/// #     simulation.deposit(layer, &order, &Control::default())?;
/// # }
/// let proxy = LayerProxy::new(&simulation, 3, &abs);
/// let region = part.region(3)?;
/// let estimate = |pattern: Pattern| {
///     proxy.end_std_c(&simulation.layer_events(3, &pattern.order(&region)))
/// };
/// let best = Pattern::ALL.into_iter().min_by(|&a, &b| estimate(a).total_cmp(&estimate(b)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LayerProxy {
    coefficients: Coefficients,
    /// Mean θ of each level at the start, K.
    level_k: Vec<f64>,
    /// From the smallest blocks to the largest.
    grids: Vec<Grid>,
    /// Number, sum and sum of squares of the θ of voxels that are not part of the model.
    outside: [f64; 3],
}

/// Blocks of one size.
#[derive(Clone, Debug)]
struct Grid {
    blocks: Blocks,
    stepper: Stepper,
    start: State,
}

/// Steps on one grid.
struct Phase {
    grid: usize,
    steps: usize,
    step_s: f64,
}

impl LayerProxy {
    /// The proxy of a layer of which nothing is deposited yet.
    ///
    /// Takes time and memory linear in the voxels of the part's bounding box.
    ///
    /// # Panics
    /// If the part has no such layer.
    pub fn new(simulation: &Simulation, layer: u32, material: &ThermalMaterial) -> Self {
        let (part, process) = (simulation.part(), simulation.process());
        let extent = Extent::new(part, layer as usize);
        let coefficients = Coefficients::new(&part.frame, material, process);
        let theta = simulation.temperatures_c() - process.ambient_c;
        let mut outside = [0.0; 3];
        let mut levels = vec![[0.0; 2]; extent.levels.len()];
        for ((z, y, x), &theta) in theta.indexed_iter().filter(|(_, theta)| !theta.is_nan()) {
            match extent.level([x as u32, y as u32], z) {
                None => {
                    outside = [outside[0] + 1.0, outside[1] + theta, outside[2] + theta * theta];
                }
                Some(level) => {
                    let [count, sum] = levels[level];
                    levels[level] = [count + 1.0, sum + theta];
                }
            }
        }
        let level_k: Vec<f64> = levels
            .iter()
            .map(|[count, sum]| if *count > 0.0 { sum / count } else { 0.0 })
            .collect();
        let mut sizes = vec![Blocks::new(part, &extent, 1)];
        for size in 1..SIZES {
            sizes.push(sizes[size - 1].coarser(&extent));
        }
        let grid = |blocks: Blocks| {
            let step_s = RATIO * f64::from(blocks.side * blocks.side) / coefficients.lateral;
            let stepper = Stepper::new(&blocks, &coefficients, &level_k, step_s);
            let start = start(&blocks, &extent, theta.view());
            Grid { blocks, stepper, start }
        };
        let grids = sizes.into_iter().map(grid).collect();
        Self { coefficients, level_k, grids, outside }
    }

    /// Steps that end with the layer, the first ones on the coarsest grid.
    fn phases(&self, seconds: f64) -> Vec<Phase> {
        let mut phases = Vec::with_capacity(SIZES);
        let mut left = seconds;
        for (number, grid) in self.grids.iter().enumerate() {
            let step_s = grid.stepper.step_s;
            if number + 1 == SIZES || left <= STEPS[number] as f64 * step_s {
                let steps = (left / step_s).ceil().max(1.0);
                phases.push(Phase { grid: number, steps: steps as usize, step_s: left / steps });
                break;
            }
            phases.push(Phase { grid: number, steps: STEPS[number], step_s });
            left -= STEPS[number] as f64 * step_s;
        }
        phases.reverse();
        phases
    }

    /// Estimates the deviation of the temperatures of all deposited voxels at the end of some
    /// events, K: those of the layer, each of whose voxels is deposited once.
    ///
    /// Takes some 30 ns per cell and level: 0.15 to 0.3 ms for a layer of 4,800 cells.
    ///
    /// # Panics
    /// If an event deposits a voxel outside of the layer's bounding box.
    pub fn end_std_c(&self, events: &[DepositionEvent]) -> f64 {
        let seconds: f64 = events.iter().map(|event| event.seconds).sum();
        let phases = self.phases(seconds);
        let mut state = self.grids[phases[0].grid].start.clone();
        let mut next_state = state.clone();
        let mut known = Vec::new();
        let mut births = Births { events, next: 0, clock_s: 0.0 };
        let mut begin_s = 0.0;
        for (number, phase) in phases.iter().enumerate() {
            let grid = &self.grids[phase.grid];
            if number > 0 {
                let coarse = &self.grids[phase.grid + 1].blocks;
                for theta in &mut state.theta {
                    *theta = grid.blocks.refine(coarse, theta);
                }
                state.deposited = grid.stepper.shares(births.so_far(&grid.blocks));
                next_state = state.clone();
            }
            let own;
            let stepper = if (phase.step_s / grid.stepper.step_s - 1.0).abs() < 1e-9 {
                &grid.stepper
            } else {
                own = Stepper::new(&grid.blocks, &self.coefficients, &self.level_k, phase.step_s);
                &own
            };
            let mut counts = vec![0.0; grid.blocks.len()];
            let mut deposit = |state: &mut State, until_s: f64| {
                births.count_until(until_s, &grid.blocks, &mut counts);
                stepper.deposit(state, &mut counts);
            };
            for step in 0..phase.steps {
                deposit(&mut state, begin_s + (step as f64 + 0.5) * phase.step_s);
                stepper.step(&mut state, &mut next_state, &mut known);
            }
            begin_s += phase.steps as f64 * phase.step_s;
            if number + 1 == phases.len() {
                deposit(&mut state, f64::INFINITY);
            }
        }
        // The last phase is always on single cells.
        self.deviation(&self.grids[0].blocks, &state)
    }

    fn deviation(&self, blocks: &Blocks, state: &State) -> f64 {
        let [mut count, mut sum, mut squares] = self.outside;
        for (level, theta) in blocks.levels.iter().zip(&state.theta) {
            let [level_count, level_sum, level_squares] = moments(&level.voxels, theta);
            count += level_count;
            sum += level_sum;
            squares += level_squares;
        }
        let mean = sum / count;
        (squares / count - mean * mean).max(0.0).sqrt()
    }
}

/// The events of a layer, of which some have happened.
struct Births<'a> {
    events: &'a [DepositionEvent],
    /// The first event that has not happened.
    next: usize,
    /// Time at which it begins, s.
    clock_s: f64,
}

impl Births<'_> {
    /// Lets all events happen whose middle is at most `until_s`, and adds the number of voxels that
    /// they deposit in each block.
    fn count_until(&mut self, until_s: f64, blocks: &Blocks, counts: &mut [f32]) {
        let mut clock_s = self.clock_s;
        for event in &self.events[self.next..] {
            if clock_s + event.seconds * 0.5 > until_s {
                break;
            }
            if let Some([x, y, _]) = event.voxel {
                counts[blocks.block([x, y])] += 1.0;
            }
            clock_s += event.seconds;
            self.next += 1;
        }
        self.clock_s = clock_s;
    }

    /// Number of voxels in each block that have been deposited.
    fn so_far(&self, blocks: &Blocks) -> Vec<f32> {
        let mut counts = vec![0.0; blocks.len()];
        for [x, y, _] in self.events[..self.next].iter().filter_map(|event| event.voxel) {
            counts[blocks.block([x, y])] += 1.0;
        }
        counts
    }
}

/// Mean temperatures of the blocks of each level.
fn start(blocks: &Blocks, extent: &Extent, theta: ndarray::ArrayView3<'_, f64>) -> State {
    let level = |layers: &std::ops::Range<usize>| {
        let mut sums = vec![[0.0; 2]; blocks.len()];
        for z in layers.clone() {
            for [x, y] in extent.positions() {
                let theta = theta[[z, y as usize, x as usize]];
                if !theta.is_nan() {
                    let [count, sum] = &mut sums[blocks.block([x, y])];
                    *count += 1.0;
                    *sum += theta;
                }
            }
        }
        sums.iter()
            .map(|[count, sum]| if *count > 0.0 { (sum / count) as f32 } else { 0.0 })
            .collect()
    };
    State { theta: extent.levels.iter().map(level).collect(), deposited: vec![0.0; blocks.len()] }
}

#[cfg(test)]
mod tests;
