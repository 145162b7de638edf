//! A fast estimate of the deviation of temperatures at a layer's end.
//!
//! Two facts make an estimate some twenty times faster than the heat equation:
//!
//! - **What was printed long ago has spread.**
//!   Heat that is `t` seconds old is spread over about `2 √(α t)`, so the beginning of a layer is
//!   computed on large blocks with long steps, and only its last second on single cells.
//! - **Layers below change slowly.**
//!   Levels of one, two, four, ... layers take their place, and deep ones keep their temperatures
//!   in the last second.
//!
//! A [`LayerProxy`] solves the heat equation on these blocks by finite volumes: an explicit step
//! sideways, then an implicit one up and down, with births, build plate, convection and radiation.
//! Its steps have a fixed diffusion number, so a step on blocks of one size is four times as long
//! as one on blocks half as wide.
//!
//! A line loses heat through its sides until the lines beside it are printed, which is what
//! distinguishes scattered lines from adjacent ones in layers that are small or high above the
//! plate.
//! So the sides of voxels that face the air or a voxel that is not deposited yet are counted
//! exactly, in blocks of any size.
//!
//! Estimates are off by 5 to 15 % and more in the first layer, but rank orders nearly as the solver
//! does; `docs/results/heat.md` has the correlations.

mod assembly;
mod births;
mod coefficients;
mod geometry;
mod linear;
mod moments;
mod plane;
mod stepper;

use beadwork_thermal::{DepositionEvent, Simulation, ThermalMaterial};

use self::births::Births;
use self::coefficients::Coefficients;
use self::geometry::{Blocks, Extent};
pub use self::linear::LinearLayer;
use self::moments::moments;
use self::stepper::{State, Stepper};

/// Layers of each level below the printed layer, from the top: 16 mm with layers of 0.25 mm.
///
/// A model that ends 27 layers deep ranks orders much worse in layer 29, since it has no plate.
const LEVELS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// Number of levels whose temperatures change in steps on single cells: the printed layer and the
/// seven layers below it, through which heat takes longer than the second of these steps.
const FAST_LEVELS: usize = 4;

/// Diffusion number of the steps: diffusivity times step over the square of a block's side.
const RATIO: f64 = 0.2;

/// Number of sizes of blocks: 1, 2, 4 and 8 cells wide.
const SIZES: usize = 4;

/// Steps on blocks of each size before the layer's end; those on the largest begin with the layer.
const STEPS: [usize; SIZES - 1] = [6, 16, 8];

/// Number of blocks of one cell times steps on them that every layer can afford: small layers,
/// which take little time, have more than [`STEPS`].
const BLOCK_STEPS: usize = 12_000;

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
        let extent = Extent::new(part, layer as usize, &LEVELS);
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
            let stepper = Stepper::new(&blocks, &coefficients, moving(&level_k, &blocks), step_s);
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
            let wanted = match number {
                0 => STEPS[0].max(BLOCK_STEPS / grid.blocks.len()),
                _ => STEPS.get(number).copied().unwrap_or(0),
            };
            if number + 1 == SIZES || left <= wanted as f64 * step_s {
                let steps = (left / step_s).ceil().max(1.0);
                phases.push(Phase { grid: number, steps: steps as usize, step_s: left / steps });
                break;
            }
            phases.push(Phase { grid: number, steps: wanted, step_s });
            left -= wanted as f64 * step_s;
        }
        phases.reverse();
        phases
    }

    /// Estimates the deviation of the temperatures of all deposited voxels at the end of some
    /// events, K: those of the layer, each of whose voxels is deposited once.
    ///
    /// Takes 0.2 to 0.35 ms for a layer of 4,800 cells, depending on the number of layers below.
    ///
    /// # Panics
    /// If an event deposits a voxel outside of the layer's bounding box.
    pub fn end_std_c(&self, events: &[DepositionEvent]) -> f64 {
        let mut births = Births::new(events, &self.grids[0].blocks);
        let phases = self.phases(events.iter().map(|event| event.seconds).sum());
        let mut state = self.grids[phases[0].grid].start.clone();
        let mut next = state.theta.clone();
        let mut known = Vec::new();
        let mut begin_s = 0.0;
        for (number, phase) in phases.iter().enumerate() {
            let grid = &self.grids[phase.grid];
            let sizes = self.grids[1..=phase.grid].iter().map(|grid| &grid.blocks);
            let mut counts = births.counts(sizes);
            if number > 0 {
                let coarse = &self.grids[phase.grid + 1].blocks;
                for theta in &mut state.theta {
                    *theta = grid.blocks.refine(coarse, theta);
                }
                next = state.theta.clone();
                grid.stepper.refresh(&mut state, &mut counts);
            }
            let own;
            let stepper = if (phase.step_s / grid.stepper.step_s - 1.0).abs() < 1e-9 {
                &grid.stepper
            } else {
                let level_k = moving(&self.level_k, &grid.blocks);
                own = Stepper::new(&grid.blocks, &self.coefficients, level_k, phase.step_s);
                &own
            };
            let mut deposit = |state: &mut State, until_s: f64| {
                births.count_until(until_s, &grid.blocks, &mut counts);
                stepper.deposit(state, &mut counts);
            };
            for step in 0..phase.steps {
                deposit(&mut state, begin_s + (step as f64 + 0.5) * phase.step_s);
                stepper.step(&mut state, &mut next, &mut known);
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

/// Of the levels, those whose temperatures change in steps on some blocks.
fn moving<'a>(levels: &'a [f64], blocks: &Blocks) -> &'a [f64] {
    if blocks.side > 1 { levels } else { &levels[..levels.len().min(FAST_LEVELS)] }
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
    let theta = extent.levels.iter().map(level).collect();
    State { theta, deposited: vec![0.0; blocks.len()], open_sides: vec![0.0; blocks.len()] }
}

#[cfg(test)]
mod tests;
