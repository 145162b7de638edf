//! The recursion over levels of time steps.
//!
//! Each level divides a span of time into groups of births that fit into one of its steps.
//! For each group, on a given patch:
//!
//! 1. The **window** around all births of the group, and around recent ones whose heat is still too
//!    concentrated for this step, is copied.
//!    Births that are far apart have several windows (`clusters.rs`), which do not overlap.
//! 2. The **long step** is taken on the whole patch, as if nothing were born in it.
//!    Far from all births this is accurate; inside the window it is not.
//! 3. The copy is taken through the same time by the **next lower level**, in shorter steps, while
//!    its halo follows the long step.
//!    This recursion ends at level 0, where each birth is a step of its own.
//! 4. The temperatures inside the window **replace** those of the long step.
//!
//! ```text
//! level 2   |----------------------- long step --------------------------|  patch
//! level 1   |------ step ------|------ step ------|------ step ----------|  window
//! level 0   |-birth-|-birth-|..|-birth-|-birth-|..|                         window of the window
//! ```
//!
//! Windows that would not save time are left out: the level below then steps the whole patch.
//! A pause is cut where a step is full, so short travel moves do not shorten the steps.
//! So the steps near the nozzle are the same for every order of births; only the cost depends on
//! how far apart consecutive births are.
//!
//! Births are recorded in a list of changes, and each patch applies those that it does not have yet
//! (`crate::occupancy`).
//! The patch around a window applies them after its long step.

use beadwork_base::Interrupted;

use crate::coefficients::Coefficients;
use crate::interval::{self, Interval};
use crate::kernel::{Quadratic, SweepBuffers, TwoStageSweep};
use crate::occupancy::VoxelChange;
use crate::patch::Patch;
use crate::run_control::RunControl;
use crate::shape::Shape;
use crate::state::{OccupancyMut, StateMut};

use super::clusters::{self, Birth, BirthTime};
use super::far::FarField;
use super::groups::Groups;
use super::level::{Accuracy, Level, StepMethod, early_levels, levels};
use super::nested::{HaloSource, NestedPatch};
use super::window::Window;

/// Maximum number of intervals that share one list of changes, which bounds its length.
pub(crate) const INTERVALS_PER_RUN: usize = 4096;

/// Cost of copying a window and writing it back, in sweeps over its voxels.
const COPY_STAGES: f64 = 3.0;

/// Cost of copying a region of the far field and writing it back, in sweeps over its voxels: its
/// blocks have to be restricted and interpolated, too.
const REGION_STAGES: f64 = 20.0;

/// Minimum number of voxels, halo included, for steps on blocks: on smaller parts, the time they
/// save is not worth their error.
const MIN_BLOCK_VOXELS: usize = 1 << 18;

/// Maximum cost of a step with a window, relative to that without: each window costs some accuracy,
/// so it must save at least 20 % of the time.
const MAX_WINDOW_COST: f64 = 0.8;

/// Maximum number of windows of a step on voxels.
const MAX_WINDOWS: usize = 32;

/// Steps a part in several levels of time steps.
///
/// Clones share no buffers.
#[derive(Debug)]
pub(crate) struct FastStepper {
    /// Shortest steps first.
    pub(super) levels: Vec<Level>,
    /// Levels of the early part of a call, where they differ.
    early: Option<Early>,
    /// Recent births, oldest first: position, and time at which each was complete, s.
    history: Vec<([usize; 3], f64)>,
    /// Time since the stepper was created, s.
    pub(super) now: f64,
    /// Minimum number of voxels, halo included, for steps on blocks.
    pub(super) min_block_voxels: usize,
    pub(super) buffers: Buffers,
}

/// Coarser levels for all but the last part of a call.
#[derive(Clone, Debug)]
struct Early {
    levels: Vec<Level>,
    /// Length of the last part of a call, s.
    late_s: f64,
}

/// Memory that is reused from step to step.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    /// Patches for windows that are not in use at present.
    pub(super) windows: Vec<Patch>,
    sweep: SweepBuffers,
    pub(super) far: FarField,
    /// Changes of the births since the start of the run, in their order.
    pub(super) changes: Vec<VoxelChange>,
}

impl Clone for FastStepper {
    fn clone(&self) -> Self {
        let Self { levels, early, history, now, min_block_voxels, .. } = self;
        Self {
            levels: levels.clone(),
            early: early.clone(),
            history: history.clone(),
            now: *now,
            min_block_voxels: *min_block_voxels,
            buffers: Buffers::default(),
        }
    }
}

impl FastStepper {
    /// A stepper for a part of which nothing is printed yet.
    pub(crate) fn new(accuracy: Accuracy, coefficients: &Coefficients) -> Self {
        let early = early_levels(accuracy, coefficients);
        Self {
            levels: levels(accuracy, coefficients),
            early: early.map(|(levels, late_s)| Early { levels, late_s }),
            history: Vec::new(),
            now: 0.0,
            min_block_voxels: MIN_BLOCK_VOXELS,
            buffers: Buffers::default(),
        }
    }

    /// The level of the longest steps of a whole part, of which rows from `top` on are empty.
    fn top_level(&self, shape: Shape, top: usize) -> usize {
        let blocks = shape.row_len * shape.planes * top >= self.min_block_voxels;
        // The last level is the one on blocks.
        self.levels.len() - if blocks { 1 } else { 2 }
    }

    /// Length of the longest steps of a whole part, of which rows from `top` on are empty, s.
    pub(crate) fn longest_step_s(&self, shape: Shape, top: usize) -> f64 {
        self.levels[self.top_level(shape, top)].seconds
    }

    /// Steps a state through some intervals.
    ///
    /// Sweeps may use `threads` threads of the current pool.
    /// The call can be interrupted whenever all voxels of the part have reached the same time, so
    /// the state it leaves is valid.
    pub(crate) fn run(
        &mut self,
        state: StateMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
        threads: usize,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        self.buffers.sweep.threads = threads;
        let StateMut { patch, mut occupancy } = state;
        let (early, late) = intervals.split_at(self.early_count(intervals));
        if !early.is_empty() {
            self.exchange_levels();
            let result = self.run_part(patch, &mut occupancy, coefficients, early, run);
            self.exchange_levels();
            result?;
        }
        self.run_part(patch, &mut occupancy, coefficients, late, run)
    }

    /// Number of the intervals of a call that belong to its early part.
    fn early_count(&self, intervals: &[Interval]) -> usize {
        let Some(early) = &self.early else { return 0 };
        let mut left_s = interval::total_seconds(intervals);
        let is_early = |interval: &&Interval| {
            left_s -= interval.seconds;
            left_s > early.late_s
        };
        intervals.iter().take_while(is_early).count()
    }

    /// Exchanges the levels of the early part of a call for those of the late part, or back.
    fn exchange_levels(&mut self) {
        if let Some(early) = &mut self.early {
            std::mem::swap(&mut self.levels, &mut early.levels);
        }
    }

    /// Steps a state through some intervals with the present levels.
    fn run_part(
        &mut self,
        patch: &mut Patch,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        let mut result = Ok(());
        for intervals in intervals.chunks(INTERVALS_PER_RUN) {
            let mut whole = NestedPatch::whole(patch, run);
            let level = self.top_level(whole.patch.shape, occupancy.top());
            result = self.advance(&mut whole, occupancy, coefficients, level, intervals);
            whole.apply(&self.buffers.changes, coefficients);
            self.buffers.changes.clear();
            if result.is_err() {
                break;
            }
        }
        self.end_far_field(patch, occupancy, coefficients);
        let max_age_s = self.levels.iter().map(Level::pause_age_s).fold(0.0, f64::max);
        let oldest = self.now - max_age_s;
        let past = self.history.partition_point(|&(_, time)| time < oldest);
        self.history.drain(..past);
        result
    }

    /// Steps a patch through some intervals, in steps of a level or lower ones.
    /// Returns an error only for the whole part, never for a window.
    pub(super) fn advance(
        &mut self,
        nested: &mut NestedPatch<'_>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        if level == 0 {
            return self.step_births(nested, occupancy, coefficients, intervals);
        }
        let max_s = self.levels[level].seconds;
        let mut groups = Groups::new(intervals, max_s);
        while let Some(group) = groups.next(|_| true) {
            if let &[long] = group
                && long.seconds > max_s
            {
                for part in long.split(max_s) {
                    self.step_group(nested, occupancy, coefficients, level, &[part])?;
                }
            } else {
                self.step_group(nested, occupancy, coefficients, level, group)?;
            }
        }
        Ok(())
    }

    /// Steps a patch through intervals that together fit into one step of a level.
    fn step_group(
        &mut self,
        nested: &mut NestedPatch<'_>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        // For a step on blocks, this counts far more updates than it makes; but such a step takes
        // long enough to poll each time.
        nested.poll(self.levels[level].stages() as usize, occupancy.top())?;
        let on_blocks = matches!(self.levels[level].method, StepMethod::Blocks);
        let seconds = interval::total_seconds(intervals);
        let windows = self.windows(nested.patch, occupancy.top(), level, intervals, seconds);
        if !windows.is_empty() && !self.saves_time(&windows, nested.patch, level, seconds) {
            if on_blocks {
                self.end_far_field(nested.patch, occupancy, coefficients);
            }
            return self.advance(nested, occupancy, coefficients, level - 1, intervals);
        }
        if on_blocks {
            let window = windows.first().copied();
            self.step_composite(nested, occupancy, coefficients, level, intervals, window);
            nested.pass(intervals);
            return Ok(());
        }
        // All births so far, before the windows are copied and the long step is taken.
        nested.apply(&self.buffers.changes, coefficients);
        let copy = |&window: &Window| {
            let mut inner = self.buffers.windows.pop().unwrap_or_default();
            inner.copy_window(window, nested.patch);
            inner
        };
        let inner: Vec<Patch> = windows.iter().map(copy).collect();
        nested.advance_halo(seconds, occupancy.top());
        self.step(nested.patch, occupancy, coefficients, level, seconds, None);
        if inner.is_empty() {
            self.now += seconds;
        } else {
            self.step_windows(nested, inner, occupancy, coefficients, level - 1, intervals);
        }
        nested.pass(intervals);
        Ok(())
    }

    /// Steps windows of a patch, which has taken a step through `intervals` already, through the
    /// same intervals in steps of `level`, and writes them back.
    ///
    /// No window overlaps another one, so each can be stepped through the whole time before the
    /// next: a birth concerns one of them, and is a pause for all others.
    fn step_windows(
        &mut self,
        nested: &mut NestedPatch<'_>,
        windows: Vec<Patch>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
    ) {
        let seconds = interval::total_seconds(intervals);
        let (start, applied, several) = (self.now, nested.applied, windows.len() > 1);
        let older = self.history.len();
        let mut own = Vec::new();
        for mut inner in windows {
            let intervals = if several {
                interval::within(intervals, |position| inner.index(position).is_some(), &mut own);
                &own
            } else {
                intervals
            };
            // The lowest level of the recursion advances the time.
            self.now = start;
            let source = HaloSource::Patch(&*nested.patch);
            let mut finer = NestedPatch::new(&mut inner, applied, source, seconds);
            self.advance(&mut finer, occupancy, coefficients, level, intervals)
                .expect("a window is not interrupted");
            nested.apply(&self.buffers.changes, coefficients);
            inner.write_back(nested.patch);
            self.buffers.windows.push(inner);
        }
        if several {
            self.history[older..].sort_by(|(_, a), (_, b)| a.total_cmp(b));
        }
    }

    /// Steps a patch through intervals at the lowest level: births happen here, and each interval
    /// is one step or more.
    fn step_births(
        &mut self,
        nested: &mut NestedPatch<'_>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        if self.levels[0].shared_birth_s > 0.0 {
            return self.step_births_together(nested, occupancy, coefficients, intervals);
        }
        let seconds = interval::total_seconds(intervals);
        // Once for all intervals: during these few births, the halo hardly changes.
        nested.advance_halo(seconds, occupancy.top());
        for interval in intervals {
            nested.poll(self.levels[0].stages() as usize, occupancy.top())?;
            if let Some(position) = interval.held.filter(|_| interval.born) {
                occupancy.birth(position, nested.patch, coefficients, &mut self.buffers.changes);
                self.history.push((position, self.now + interval.seconds));
            }
            nested.apply(&self.buffers.changes, coefficients);
            let held = interval.held.map(|position| {
                nested.patch.index(position).expect("a window contains all births of its steps")
            });
            for part in interval.split(self.levels[0].seconds) {
                self.step(nested.patch, occupancy, coefficients, 0, part.seconds, held);
            }
            self.now += interval.seconds;
            nested.pass(std::slice::from_ref(interval));
        }
        Ok(())
    }

    /// Steps a patch through intervals at the lowest level, where births share a step: they happen
    /// together at its start.
    fn step_births_together(
        &mut self,
        nested: &mut NestedPatch<'_>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        let Level { seconds: max_s, shared_birth_s, .. } = self.levels[0];
        let mut groups = Groups::new(intervals, max_s);
        let may_share = |interval: &Interval| {
            interval.held.is_none() || interval.born && interval.seconds <= shared_birth_s
        };
        while let Some(group) = groups.next(may_share) {
            nested.poll(self.levels[0].stages() as usize, occupancy.top())?;
            let seconds = interval::total_seconds(group);
            nested.advance_halo(seconds, occupancy.top());
            let start = self.now;
            for interval in group {
                self.now += interval.seconds;
                if let Some(position) = interval.held.filter(|_| interval.born) {
                    occupancy.birth(
                        position,
                        nested.patch,
                        coefficients,
                        &mut self.buffers.changes,
                    );
                    self.history.push((position, self.now));
                }
            }
            self.now = start + seconds;
            nested.apply(&self.buffers.changes, coefficients);
            // Of several births, only the last is held.
            let held = group.last().and_then(|interval| interval.held);
            for birth in group.iter().filter(|birth| birth.born && birth.held != held) {
                nested.patch.add_held_heat(birth, coefficients);
            }
            let held = held.map(|position| {
                nested.patch.index(position).expect("a window contains all births of its steps")
            });
            let whole = Interval { held: None, born: false, seconds, completes: None };
            for part in whole.split(max_s) {
                self.step(nested.patch, occupancy, coefficients, 0, part.seconds, held);
            }
            nested.pass(group);
        }
        Ok(())
    }

    /// Takes one step of a level on the voxels of a patch: one sweep for each factor of the
    /// stability polynomial.
    fn step(
        &mut self,
        patch: &mut Patch,
        occupancy: &OccupancyMut<'_>,
        coefficients: &Coefficients,
        level: usize,
        seconds: f64,
        held: Option<usize>,
    ) {
        // The first empty row, counted in this patch.
        // If the first birth of a layer has nothing below it, its window may lie above everything
        // printed so far: hence the lower limit.
        let top = occupancy.top().saturating_sub(patch.origin[2]).clamp(1, patch.shape.rows - 1);
        let StepMethod::Voxels(polynomial) = &self.levels[level].method else {
            unreachable!("steps on blocks are taken by `step_composite`")
        };
        for factor in &polynomial.factors {
            // Scaled in double precision, so that each coefficient is rounded only once.
            let scheme = Quadratic {
                a: (factor.a * seconds) as f32,
                b: (factor.b * seconds * seconds) as f32,
            };
            TwoStageSweep { coefficients, patch, scheme, held, top }.sweep(&mut self.buffers.sweep);
        }
    }

    /// The windows of a patch in which one step of a level, through `intervals`, is not accurate;
    /// none if it is accurate everywhere, and at most one for a level on blocks.
    /// The intervals take `seconds` together.
    fn windows(
        &self,
        patch: &Patch,
        top: usize,
        level: usize,
        intervals: &[Interval],
        seconds: f64,
    ) -> Vec<Window> {
        let level = &self.levels[level];
        let coming = intervals.iter().filter_map(|interval| interval.held);
        let coming = coming.map(|position| Birth { position, time: BirthTime::Coming });
        let births_s = interval::total_seconds(intervals.iter().filter(|interval| interval.born));
        // A step counts as a pause if births take less than 90 % of it: short travel moves between
        // births are not enough.
        let pause = births_s < 0.9 * seconds;
        let left_s = self.now - level.pause_age_s();
        let since_s = if pause { left_s } else { self.now - level.age_s };
        // While one of several windows is stepped, the history has births of the others, too.
        // Some of these may be later than now, but all are later than the start of the common step,
        // so those before the first that is too old are too old as well.
        let past = self.history.iter().rev().take_while(|&&(_, time)| time > left_s);
        let past = past.filter(|(position, _)| patch.index(*position).is_some());
        let past = past.map(|&(position, time)| Birth {
            position,
            time: if time > since_s { BirthTime::Recent } else { BirthTime::Old },
        });
        let max_windows = if matches!(level.method, StepMethod::Blocks) { 1 } else { MAX_WINDOWS };
        clusters::windows(past.chain(coming), level.margins, patch, top, max_windows)
    }

    /// Whether a long step of a patch with shorter steps in windows costs sufficiently less than
    /// shorter steps of the whole patch, in voxels times sweeps.
    fn saves_time(&self, windows: &[Window], patch: &Patch, level: usize, seconds: f64) -> bool {
        let (long, short) =
            (&self.levels[level], self.levels[level - 1].stages_per_second() * seconds);
        let part = windows.iter().map(|window| window.shape.len()).sum::<usize>() as f64;
        let whole = patch.shape.len() as f64;
        let copy =
            if matches!(long.method, StepMethod::Blocks) { REGION_STAGES } else { COPY_STAGES };
        whole * long.stages() + part * (short + copy) < MAX_WINDOW_COST * whole * short
    }
}
