//! Time steps of all blocks.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for its instruction set"
)]
#![expect(
    clippy::needless_range_loop,
    reason = "one index runs through a dozen rows of the same length"
)]

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

use super::assembly::Assembly;
use super::births::Counts;
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
    /// Sides in the air per deposited voxel of each block of the printed layer.
    pub(super) open_sides: Vec<f32>,
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
    /// 1 over the voxels of the printed layer in each block; 0 without any.
    inverse_voxels: Vec<f32>,
    /// θ of voxels that are deposited, K.
    birth_k: f32,
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
    /// Conductance to the level below over the pivot of that level, or 1 if that keeps its
    /// temperatures; `None` without a level below.
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
    /// Tops and bottoms that face the air.
    pub(super) faces: Plane,
    /// A side that faces the air.
    pub(super) side: f32,
    /// Conductance to the level below.
    pub(super) below: Plane,
    /// Surface of the second level that the layer covers.
    pub(super) covered: Plane,
}

impl Stepper {
    /// Steps of `step_s`, with surfaces of each level below the first at its mean θ, `level_k`.
    ///
    /// Levels that have no mean keep their temperatures; the first two must have one.
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
        for number in (1..level_k.len()).rev() {
            let sides = levels.last().map_or(&first.sides, |before| &before.sides);
            let loss = coefficients.loss_at(level_k[number]) as f32;
            let (level, eliminated) = assembly.level(number, loss, lower.take(), sides);
            levels.push(level);
            lower = Some(eliminated);
        }
        levels.reverse();
        let Blocks { width, height, .. } = *blocks;
        let inverse = |&voxels: &f32| if voxels > 0.0 { 1.0 / voxels } else { 0.0 };
        let inverse_voxels = blocks.levels[0].voxels.iter().map(inverse).collect();
        let birth_k = coefficients.birth_k as f32;
        let loss = coefficients.loss;
        Self { step_s, width, height, levels, first, inverse_voxels, birth_k, loss }
    }

    /// Sets what of each block of the printed layer is deposited, but no temperatures, and resets
    /// the numbers of new voxels to 0.
    pub(super) fn refresh(&self, state: &mut State, counts: &mut Counts) {
        let shares =
            counts.new.iter().zip(&self.inverse_voxels).map(|(&new, inverse)| new as f32 * inverse);
        state.deposited = shares.collect();
        let per_voxel = |(&open, &new): (&i32, &i32)| open as f32 / new.max(1) as f32;
        state.open_sides = counts.open_sides.iter().zip(&counts.new).map(per_voxel).collect();
        counts.new.fill(0);
    }

    /// Deposits the new voxels of each block of the printed layer, and resets their numbers to 0.
    pub(super) fn deposit(&self, state: &mut State, counts: &mut Counts) {
        Arch::new().dispatch(Deposition {
            birth_k: self.birth_k,
            inverse_voxels: &self.inverse_voxels,
            theta: &mut state.theta[0],
            deposited: &mut state.deposited,
            open_sides: &mut state.open_sides,
            counts,
        });
    }

    /// Advances a state by one step; `next` is overwritten, and becomes its temperatures.
    pub(super) fn step(&self, state: &mut State, next: &mut Vec<Vec<f32>>, known: &mut Vec<f32>) {
        known.resize((self.levels.len() + 1) * (self.width - 2), 0.0);
        Arch::new().dispatch(Sweep { stepper: self, state, next, known });
        std::mem::swap(&mut state.theta, next);
    }
}

/// Voxels that are deposited in all blocks of the printed layer.
struct Deposition<'a> {
    birth_k: f32,
    inverse_voxels: &'a [f32],
    theta: &'a mut [f32],
    deposited: &'a mut [f32],
    open_sides: &'a mut [f32],
    counts: &'a mut Counts,
}

impl NullaryFnOnce for Deposition<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { birth_k, inverse_voxels, theta, deposited, open_sides, counts } = self;
        let count = theta.len();
        let (inverse_voxels, deposited) = (&inverse_voxels[..count], &mut deposited[..count]);
        let (new, open) = (&mut counts.new[..count], &counts.open_sides[..count]);
        let open_sides = &mut open_sides[..count];
        for block in 0..count {
            let share = new[block] as f32 * inverse_voxels[block];
            deposited[block] += share;
            let inverse = 1.0 / deposited[block].max(f32::MIN_POSITIVE);
            open_sides[block] = open[block] as f32 * inverse_voxels[block] * inverse;
            theta[block] += share * inverse * (birth_k - theta[block]);
        }
        new.fill(0);
    }
}

/// A step of all rows.
///
/// It is a type because pulp compiles only implementations of [`WithSimd`] for the widest lanes of
/// the machine.
struct Sweep<'a> {
    stepper: &'a Stepper,
    state: &'a State,
    next: &'a mut [Vec<f32>],
    /// Of each level but the first, a row of what is known before the first level is solved; and
    /// the temperatures of the level below them, which does not change.
    known: &'a mut [f32],
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { stepper, state, next, known } = self;
        for y in 1..stepper.height - 1 {
            let width = stepper.width;
            let row = Row { simd, y, width, count: (width - 2) / S::F32_LANES };
            row.step(stepper, state, next, known);
        }
    }
}

/// A row of blocks.
#[derive(Clone, Copy)]
struct Row<S> {
    simd: S,
    y: usize,
    /// Blocks in a row, with the border.
    width: usize,
    /// Vectors in a row, without the border.
    ///
    /// All slices of a row are cut to this length, so that the compiler can drop the bounds checks
    /// of loops up to it.
    count: usize,
}

impl<S: Simd> Row<S> {
    /// Values of the row `rows` rows further and `blocks` blocks further to the right, without the
    /// border, as vectors.
    #[inline(always)]
    fn of(self, values: &[f32], rows: isize, blocks: isize) -> &[S::f32s] {
        let first = (self.y.wrapping_add_signed(rows)) * self.width;
        let first = (first + 1).wrapping_add_signed(blocks);
        self.vectors(&values[first..][..self.width - 2])
    }

    #[inline(always)]
    fn of_mut(self, values: &mut [f32]) -> &mut [S::f32s] {
        let first = self.y * self.width + 1;
        &mut S::as_mut_simd_f32s(&mut values[first..][..self.width - 2]).0[..self.count]
    }

    #[inline(always)]
    fn of_plane(self, plane: &Plane) -> &[S::f32s] {
        self.vectors(plane.inside(self.y, self.width - 2))
    }

    #[inline(always)]
    fn vectors(self, values: &[f32]) -> &[S::f32s] {
        &S::as_simd_f32s(values).0[..self.count]
    }

    #[inline(always)]
    fn step(self, stepper: &Stepper, state: &State, next: &mut [Vec<f32>], known: &mut [f32]) {
        let known = S::as_mut_simd_f32s(known).0;
        let (count, moving) = (self.count, stepper.levels.len());
        if let Some(below) = state.theta.get(moving + 1) {
            known[moving * count..].copy_from_slice(self.of(below, 0, 0));
        }
        for (number, level) in stepper.levels.iter().enumerate().rev() {
            let (known, lower) = known[number * count..].split_at_mut(count);
            let flow = Flow::new(self, &state.theta[number + 1], &level.sides);
            self.explicit(known, &flow, level, lower);
        }
        self.upper_levels(stepper, state, next, &known[..count]);
        for (number, level) in stepper.levels.iter().enumerate().skip(1) {
            let (upper, lower) = next.split_at_mut(number + 1);
            let (up, out) = (self.of(&upper[number], 0, 0), self.of_mut(&mut lower[0]));
            self.back(out, level, &known[number * count..][..count], up);
        }
    }

    /// What is known of a level from its sides and from the level below, `lower`.
    #[inline(always)]
    fn explicit(
        self,
        known: &mut [S::f32s],
        flow: &Flow<'_, S>,
        level: &LevelStepper,
        lower: &[S::f32s],
    ) {
        let simd = self.simd;
        let count = self.count;
        let known = &mut known[..count];
        for x in 0..count {
            known[x] = simd.add_f32s(flow.centre[x], flow.sum(x));
        }
        if let Some(source) = &level.source {
            let source = self.of_plane(source);
            for x in 0..count {
                known[x] = simd.add_f32s(known[x], source[x]);
            }
        }
        if let Some(passed_up) = &level.passed_up {
            let (passed_up, lower) = (self.of_plane(passed_up), &lower[..count]);
            for x in 0..count {
                known[x] = simd.mul_add_f32s(passed_up[x], lower[x], known[x]);
            }
        }
    }

    /// Temperatures of a level from those of the level above, `up`.
    #[inline(always)]
    fn back(self, out: &mut [S::f32s], level: &LevelStepper, known: &[S::f32s], up: &[S::f32s]) {
        let (simd, count) = (self.simd, self.count);
        let above = self.of_plane(&level.above);
        let inverse = self.of_plane(&level.pivot);
        let (out, known, up) = (&mut out[..count], &known[..count], &up[..count]);
        for x in 0..count {
            let sum = simd.mul_add_f32s(above[x], up[x], known[x]);
            out[x] = simd.mul_f32s(sum, inverse[x]);
        }
    }

    /// The upper two levels, between which heat flows only where the layer is printed.
    #[inline(always)]
    fn upper_levels(
        self,
        stepper: &Stepper,
        state: &State,
        next: &mut [Vec<f32>],
        known: &[S::f32s],
    ) {
        let simd = self.simd;
        let one = simd.splat_f32s(1.0);
        let (out, rest) = next.split_at_mut(1);
        let out = self.of_mut(&mut out[0]);
        let count = self.count;
        let first = FirstRow::new(self, stepper, state);
        let Some(second) = stepper.levels.first() else {
            for x in 0..count {
                let sum = simd.add_f32s(first.flow.centre[x], first.exchange(x));
                out[x] = simd.div_f32s(sum, first.pivot(x));
            }
            return;
        };
        let second_out = self.of_mut(&mut rest[0]);
        let theta = self.of(&state.theta[1], 0, 0);
        let above = self.of_plane(&second.above);
        let pivot = self.of_plane(&second.pivot);
        let below = self.of_plane(&stepper.first.below);
        let covered = self.of_plane(&stepper.first.covered);
        let known = &known[..count];
        for x in 0..count {
            let share = first.share[x];
            // Of the second level, the share that is covered conducts to the first, and the rest
            // faces the air.
            let up = simd.mul_f32s(above[x], share);
            let bare = simd.mul_f32s(covered[x], simd.sub_f32s(one, share));
            let conducted = simd.add_f32s(pivot[x], up);
            let pivot = simd.mul_add_f32s(bare, first.loss(theta[x]), conducted);
            let inverse = simd.div_f32s(one, pivot);
            // What is not deposited takes the temperature of what is below.
            let passed = simd.mul_f32s(below[x], inverse);
            let sum = simd.add_f32s(first.flow.centre[x], first.exchange(x));
            let sum = simd.mul_add_f32s(passed, known[x], sum);
            let first_pivot = simd.add_f32s(first.pivot(x), below[x]);
            let first_pivot = simd.sub_f32s(first_pivot, simd.mul_f32s(passed, up));
            let new = simd.div_f32s(sum, first_pivot);
            out[x] = new;
            second_out[x] = simd.mul_f32s(simd.mul_add_f32s(up, new, known[x]), inverse);
        }
    }
}

/// A row of blocks of the printed layer, without the border.
struct FirstRow<'a, S: Simd> {
    simd: S,
    flow: Flow<'a, S>,
    /// Shares that are deposited, of the blocks and of their neighbours.
    share: &'a [S::f32s],
    east_share: &'a [S::f32s],
    west_share: &'a [S::f32s],
    south_share: &'a [S::f32s],
    north_share: &'a [S::f32s],
    source: &'a [S::f32s],
    plate: &'a [S::f32s],
    faces: &'a [S::f32s],
    side: S::f32s,
    open_sides: &'a [S::f32s],
    loss: [S::f32s; 4],
}

impl<'a, S: Simd> FirstRow<'a, S> {
    #[inline(always)]
    fn new(row: Row<S>, stepper: &'a Stepper, state: &'a State) -> Self {
        let (first, share) = (&stepper.first, &state.deposited);
        Self {
            simd: row.simd,
            flow: Flow::new(row, &state.theta[0], &first.sides),
            share: row.of(share, 0, 0),
            east_share: row.of(share, 0, 1),
            west_share: row.of(share, 0, -1),
            south_share: row.of(share, 1, 0),
            north_share: row.of(share, -1, 0),
            source: row.of_plane(&first.source),
            plate: row.of_plane(&first.plate),
            faces: row.of_plane(&first.faces),
            side: row.simd.splat_f32s(first.side),
            open_sides: row.of(&state.open_sides, 0, 0),
            loss: stepper.loss.map(|coefficient| row.simd.splat_f32s(coefficient)),
        }
    }

    /// What flows to a voxel from the sides and from the plate.
    #[inline(always)]
    fn exchange(&self, x: usize) -> S::f32s {
        let (simd, flow) = (self.simd, &self.flow);
        let side = |conductance: S::f32s, share: S::f32s, theta: S::f32s, sum: S::f32s| {
            let difference = simd.sub_f32s(theta, flow.centre[x]);
            simd.mul_add_f32s(simd.mul_f32s(conductance, share), difference, sum)
        };
        let sum = side(flow.right[x], self.east_share[x], flow.east[x], self.source[x]);
        let sum = side(flow.left[x], self.west_share[x], flow.west[x], sum);
        let sum = side(flow.down[x], self.south_share[x], flow.south[x], sum);
        side(flow.up[x], self.north_share[x], flow.north[x], sum)
    }

    /// Pivot of a voxel without conduction to the level below.
    #[inline(always)]
    fn pivot(&self, x: usize) -> S::f32s {
        let simd = self.simd;
        let fixed = simd.add_f32s(simd.splat_f32s(1.0), self.plate[x]);
        let surface = simd.mul_add_f32s(self.open_sides[x], self.side, self.faces[x]);
        simd.mul_add_f32s(surface, self.loss(self.flow.centre[x]), fixed)
    }

    #[inline(always)]
    fn loss(&self, theta: S::f32s) -> S::f32s {
        let [a, b, c, d] = self.loss;
        let simd = self.simd;
        let slope = simd.mul_add_f32s(theta, simd.mul_add_f32s(theta, d, c), b);
        simd.mul_add_f32s(theta, slope, a)
    }
}

/// Temperatures of a row of blocks, without the border, and of their neighbours; and conductances.
struct Flow<'a, S: Simd> {
    simd: S,
    centre: &'a [S::f32s],
    east: &'a [S::f32s],
    west: &'a [S::f32s],
    south: &'a [S::f32s],
    north: &'a [S::f32s],
    right: &'a [S::f32s],
    left: &'a [S::f32s],
    down: &'a [S::f32s],
    up: &'a [S::f32s],
}

impl<'a, S: Simd> Flow<'a, S> {
    #[inline(always)]
    fn new(row: Row<S>, theta: &'a [f32], sides: &'a [Plane; 4]) -> Self {
        let [right, left, down, up] = sides;
        Self {
            simd: row.simd,
            centre: row.of(theta, 0, 0),
            east: row.of(theta, 0, 1),
            west: row.of(theta, 0, -1),
            south: row.of(theta, 1, 0),
            north: row.of(theta, -1, 0),
            right: row.of_plane(right),
            left: row.of_plane(left),
            down: row.of_plane(down),
            up: row.of_plane(up),
        }
    }

    /// What flows to a voxel from all sides.
    #[inline(always)]
    fn sum(&self, x: usize) -> S::f32s {
        let simd = self.simd;
        let difference = |theta: S::f32s| simd.sub_f32s(theta, self.centre[x]);
        let sum = simd.mul_f32s(self.right[x], difference(self.east[x]));
        let sum = simd.mul_add_f32s(self.left[x], difference(self.west[x]), sum);
        let sum = simd.mul_add_f32s(self.down[x], difference(self.south[x]), sum);
        simd.mul_add_f32s(self.up[x], difference(self.north[x]), sum)
    }
}
