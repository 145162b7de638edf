//! Time steps of all blocks.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for its instruction set"
)]
#![expect(
    clippy::needless_range_loop,
    reason = "one index runs through a dozen rows of the same length"
)]

use pulp::{Arch, NullaryFnOnce};

use super::assembly::Assembly;
use super::coefficients::Coefficients;
use super::geometry::Blocks;
use super::plane::Plane;

/// Temperatures of all blocks, and how much of the layer is printed.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// θ of the blocks of each level, from the top, K.
    pub(super) theta: Vec<Vec<f32>>,
    /// Share of the voxels of the printed layer in each block that are deposited.
    pub(super) deposited: Vec<f32>,
}

/// Steps of one length.
///
/// Heat flows sideways by an explicit step, then up and down by an implicit one: the levels of a
/// block are a tridiagonal system, which is solved from the bottom to the top and back.
/// The pivots of all levels but the upper two do not change, so they are computed once.
/// All coefficients are per voxel of their block, and times the step over the heat capacity.
#[derive(Clone, Debug)]
pub(super) struct Stepper {
    pub(super) step_s: f64,
    width: usize,
    height: usize,
    levels: Vec<LevelStepper>,
    first: FirstLevel,
    /// See [`Coefficients::loss`].
    loss: [f32; 4],
}

/// A level below the printed layer.
#[derive(Clone, Debug)]
pub(super) struct LevelStepper {
    /// Conductances to the neighbours at larger x, smaller x, larger y and smaller y.
    pub(super) sides: [Plane; 4],
    /// Heat from the plate, K; `None` if the level does not lie on it.
    pub(super) source: Option<Plane>,
    /// Conductance to the level above.
    pub(super) above: Plane,
    /// Conductance to the level below over the pivot of that level; `None` in the lowest level.
    pub(super) passed_up: Option<Plane>,
    /// 1 / pivot; in the second level the pivot, without what depends on the first.
    pub(super) pivot: Plane,
}

/// The printed layer.
#[derive(Clone, Debug)]
pub(super) struct FirstLevel {
    pub(super) sides: [Plane; 4],
    /// Heat from the plate, K.
    pub(super) source: Plane,
    /// Conductance to the plate.
    pub(super) plate: Plane,
    /// Surface that faces the air.
    pub(super) surface: Plane,
    /// Conductance to the level below.
    pub(super) below: Plane,
    /// Surface of the second level that the layer covers.
    pub(super) covered: Plane,
}

impl Stepper {
    /// Steps of `step_s`, with surfaces of each level below the first at its mean θ, `level_k`.
    pub(super) fn new(
        blocks: &Blocks,
        coefficients: &Coefficients,
        level_k: &[f64],
        step_s: f64,
    ) -> Self {
        let assembly = Assembly { blocks, coefficients, step_s };
        let first = assembly.first_level();
        let mut levels: Vec<LevelStepper> = Vec::new();
        let mut lower = None;
        for number in (1..blocks.levels.len()).rev() {
            let sides = levels.last().map_or(&first.sides, |before| &before.sides);
            let loss = coefficients.loss_at(level_k[number]) as f32;
            let (level, eliminated) = assembly.level(number, loss, lower.take(), sides);
            levels.push(level);
            lower = Some(eliminated);
        }
        levels.reverse();
        let Blocks { width, height, .. } = *blocks;
        Self { step_s, width, height, levels, first, loss: coefficients.loss }
    }

    /// Advances a state by one step; `next` is overwritten, and becomes the state.
    pub(super) fn step(&self, state: &mut State, next: &mut State, known: &mut Vec<f32>) {
        known.clear();
        known.resize((self.levels.len() + 1) * self.width, 0.0);
        Arch::new().dispatch(Sweep { stepper: self, state, next: &mut *next, known });
        std::mem::swap(&mut state.theta, &mut next.theta);
    }

    #[inline(always)]
    fn step_row(&self, y: usize, state: &State, next: &mut State, known: &mut [f32]) {
        let width = self.width;
        for (number, level) in self.levels.iter().enumerate().rev() {
            let (upper, lower) = known.split_at_mut((number + 1) * width);
            let known = &mut upper[number * width..][..width];
            let flow = Flow::new(&state.theta[number + 1], &level.sides, y, width);
            for x in 1..width - 1 {
                known[x] = flow.centre[x] + flow.at(x);
            }
            if let Some(source) = &level.source {
                let source = source.row(y);
                for x in 1..width - 1 {
                    known[x] += source[x];
                }
            }
            if let Some(passed_up) = &level.passed_up {
                let (passed_up, lower) = (passed_up.row(y), &lower[..width]);
                for x in 1..width - 1 {
                    known[x] += passed_up[x] * lower[x];
                }
            }
        }
        self.step_first(y, state, next, known);
        for (number, level) in self.levels.iter().enumerate().skip(1) {
            let (upper, lower) = next.theta.split_at_mut(number + 1);
            let up = &upper[number][y * width..][..width];
            let out = &mut lower[0][y * width..][..width];
            let (above, inverse) = (level.above.row(y), level.pivot.row(y));
            let known = &known[number * width..][..width];
            for x in 1..width - 1 {
                out[x] = (known[x] + above[x] * up[x]) * inverse[x];
            }
        }
    }

    /// The upper two levels, between which heat flows only where the layer is printed.
    #[inline(always)]
    fn step_first(&self, y: usize, state: &State, next: &mut State, known: &[f32]) {
        let width = self.width;
        let first = FirstRow::new(self, state, y);
        let (out, rest) = next.theta.split_at_mut(1);
        let out = &mut out[0][y * width..][..width];
        let Some(second) = self.levels.first() else {
            for x in 1..width - 1 {
                out[x] = (first.flow.centre[x] + first.exchange(x)) / first.pivot(x);
            }
            return;
        };
        let second_out = &mut rest[0][y * width..][..width];
        let second_theta = &state.theta[1][y * width..][..width];
        let (above, pivot) = (second.above.row(y), second.pivot.row(y));
        let (below, covered) = (self.first.below.row(y), self.first.covered.row(y));
        let known = &known[..width];
        for x in 1..width - 1 {
            let share = first.share[x];
            // Of the second level, the share that is covered conducts to the first, and the rest
            // faces the air.
            let up = above[x] * share;
            let bare = covered[x] * (1.0 - share);
            let inverse = 1.0 / (pivot[x] + up + bare * first.loss(second_theta[x]));
            // What is not deposited takes the temperature of what is below.
            let passed = below[x] * inverse;
            let new = (first.flow.centre[x] + first.exchange(x) + passed * known[x])
                / (first.pivot(x) + below[x] - passed * up);
            out[x] = new;
            second_out[x] = (known[x] + up * new) * inverse;
        }
    }
}

/// A row of blocks of the printed layer.
struct FirstRow<'a> {
    flow: Flow<'a>,
    /// Shares that are deposited, of the blocks and of those at smaller and larger y.
    share: &'a [f32],
    north_share: &'a [f32],
    south_share: &'a [f32],
    source: &'a [f32],
    plate: &'a [f32],
    surface: &'a [f32],
    loss: [f32; 4],
}

impl<'a> FirstRow<'a> {
    #[inline(always)]
    fn new(stepper: &'a Stepper, state: &'a State, y: usize) -> Self {
        let (first, width) = (&stepper.first, stepper.width);
        let share = &state.deposited;
        Self {
            flow: Flow::new(&state.theta[0], &first.sides, y, width),
            share: &share[y * width..][..width],
            north_share: &share[(y - 1) * width..][..width],
            south_share: &share[(y + 1) * width..][..width],
            source: first.source.row(y),
            plate: first.plate.row(y),
            surface: first.surface.row(y),
            loss: stepper.loss,
        }
    }

    /// What flows to a voxel from the sides and from the plate.
    #[inline(always)]
    fn exchange(&self, x: usize) -> f32 {
        let flow = &self.flow;
        let own = flow.centre[x];
        flow.right[x] * self.share[x + 1] * (flow.centre[x + 1] - own)
            + flow.left[x] * self.share[x - 1] * (flow.centre[x - 1] - own)
            + flow.down[x] * self.south_share[x] * (flow.south[x] - own)
            + flow.up[x] * self.north_share[x] * (flow.north[x] - own)
            + self.source[x]
    }

    /// Pivot of a voxel without conduction to the level below.
    #[inline(always)]
    fn pivot(&self, x: usize) -> f32 {
        1.0 + self.surface[x] * self.loss(self.flow.centre[x]) + self.plate[x]
    }

    #[inline(always)]
    fn loss(&self, theta: f32) -> f32 {
        let [a, b, c, d] = self.loss;
        a + theta * (b + theta * (c + theta * d))
    }
}

/// A step of all rows, compiled for each instruction set.
struct Sweep<'a> {
    stepper: &'a Stepper,
    state: &'a State,
    next: &'a mut State,
    known: &'a mut [f32],
}

impl NullaryFnOnce for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for y in 1..self.stepper.height - 1 {
            self.stepper.step_row(y, self.state, self.next, self.known);
        }
    }
}

/// What flows sideways between the blocks of a row and their neighbours.
struct Flow<'a> {
    centre: &'a [f32],
    north: &'a [f32],
    south: &'a [f32],
    right: &'a [f32],
    left: &'a [f32],
    down: &'a [f32],
    up: &'a [f32],
}

impl<'a> Flow<'a> {
    #[inline(always)]
    fn new(theta: &'a [f32], sides: &'a [Plane; 4], y: usize, width: usize) -> Self {
        let row = |y: usize| &theta[y * width..][..width];
        let [right, left, down, up] = sides.each_ref().map(|side| side.row(y));
        Self { centre: row(y), north: row(y - 1), south: row(y + 1), right, left, down, up }
    }

    #[inline(always)]
    fn at(&self, x: usize) -> f32 {
        let own = self.centre[x];
        self.right[x] * (self.centre[x + 1] - own)
            + self.left[x] * (self.centre[x - 1] - own)
            + self.down[x] * (self.south[x] - own)
            + self.up[x] * (self.north[x] - own)
    }
}
