//! The fast stepper: long steps far from the nozzle, short ones near it.
//!
//! Behind the nozzle, temperatures change within milliseconds; a few millimetres away, within
//! seconds; farther still, within minutes.
//! So a long step is taken everywhere first, as if nothing was born in it.
//! It is wrong near the nozzle: in a **window** around all recent births, and around those of the
//! step itself, the step is then taken anew in shorter steps, from a copy of the old temperatures,
//! and the copy's **halo** follows the long step.
//! What comes out replaces the long step's result there.
//! The shorter steps do the same with a smaller window and steps that are shorter again, down to
//! single births.
//! This is local time stepping as in adaptive mesh refinement (Berger and Oliger 1984), on one
//! mesh.
//!
//! Steps of each level are explicit, but of as many stages as makes their length stable
//! (`chebyshev.rs`), so that the cost of a step grows with the root of its length only.
//! A window that would save nothing is not used.

mod chebyshev;
mod composite;
mod far;
mod level;
mod nested;
mod window;

use beadwork_base::Interrupted;

use crate::coefficients::Coefficients;
use crate::interval::{self, Interval};
use crate::kernel::{Quadratic, SweepBuffers, TwoStageSweep};
use crate::occupancy::Change;
use crate::patch::Patch;
use crate::run_control::RunControl;
use crate::state::{StateMut, Voxels};

use self::far::FarField;
use self::level::{Level, StepMethod, levels};
use self::nested::{HaloSource, NestedPatch};
use self::window::Window;

pub use self::level::Accuracy;

/// Pieces of a run before what births have changed is forgotten.
const RUN: usize = 4096;

/// Takes a copy of a window, and puts it back: in sweeps of as many voxels.
const COPY_STAGES: f64 = 3.0;

/// The same of a region of the far field, whose blocks have to be looked at, too.
const LOOK_STAGES: f64 = 20.0;

/// For fewer voxels steps on blocks save no time that anyone would notice, and cost some accuracy.
const MANY_VOXELS: usize = 1 << 18;

/// A window has to bring the time below this part of what it takes without one: each costs some
/// accuracy.
const WORTHWHILE: f64 = 0.8;

#[derive(Debug)]
pub(crate) struct FastStepper {
    levels: Vec<Level>,
    /// Births that are still of interest, oldest first: where, and when their slots ended.
    history: Vec<([usize; 3], f64)>,
    now: f64,
    /// Voxels, halo and all, from which on steps on blocks are taken.
    many_voxels: usize,
    memory: Memory,
}

/// Memory that is used again and again.
#[derive(Debug, Default)]
struct Memory {
    windows: Vec<Patch>,
    kept: SweepBuffers,
    far: FarField,
    /// What the births of the run have changed, in their order.
    changes: Vec<Change>,
}

impl Clone for FastStepper {
    fn clone(&self) -> Self {
        let Self { levels, history, now, many_voxels, .. } = self;
        Self {
            levels: levels.clone(),
            history: history.clone(),
            now: *now,
            many_voxels: *many_voxels,
            memory: Memory::default(),
        }
    }
}

impl FastStepper {
    pub(crate) fn new(accuracy: Accuracy, coefficients: &Coefficients) -> Self {
        Self {
            levels: levels(accuracy, coefficients),
            history: Vec::new(),
            now: 0.0,
            many_voxels: MANY_VOXELS,
            memory: Memory::default(),
        }
    }

    /// In so many threads of the current pool.
    pub(crate) fn run(
        &mut self,
        state: StateMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
        threads: usize,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        self.memory.kept.threads = threads;
        let StateMut { patch, mut voxels } = state;
        let mut result = Ok(());
        for intervals in intervals.chunks(RUN) {
            let mut whole = NestedPatch::whole(patch, run);
            let shape = whole.patch.shape;
            let many = shape.row * shape.planes * voxels.top() >= self.many_voxels;
            let level = self.levels.len() - if many { 1 } else { 2 };
            result = self.advance(&mut whole, &mut voxels, coefficients, level, intervals);
            whole.apply(&self.memory.changes, coefficients);
            self.memory.changes.clear();
            if result.is_err() {
                break;
            }
        }
        self.end_composite(patch, &voxels, coefficients);
        let oldest = self.now - self.levels.iter().map(Level::pause_age_s).fold(0.0, f64::max);
        let past = self.history.partition_point(|&(_, time)| time < oldest);
        self.history.drain(..past);
        result
    }

    /// Takes a patch through some intervals, in steps of a level or shorter ones.
    /// Only the whole part can be interrupted, never a window.
    fn advance(
        &mut self,
        nested: &mut NestedPatch<'_>,
        voxels: &mut Voxels<'_>,
        coefficients: &Coefficients,
        level: usize,
        mut intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        if level == 0 {
            return self.births(nested, voxels, coefficients, intervals);
        }
        let longest = self.levels[level].seconds;
        while let Some((&first, rest)) = intervals.split_first() {
            if first.seconds > longest {
                for part in first.split(longest) {
                    self.group(nested, voxels, coefficients, level, &[part])?;
                }
                intervals = rest;
                continue;
            }
            let mut seconds = 0.0;
            let fits = |interval: &&Interval| {
                seconds += interval.seconds;
                seconds <= longest
            };
            let (group, rest) = intervals.split_at(intervals.iter().take_while(fits).count());
            self.group(nested, voxels, coefficients, level, group)?;
            intervals = rest;
        }
        Ok(())
    }

    /// Takes a patch through intervals that fit into one step of a level.
    fn group(
        &mut self,
        nested: &mut NestedPatch<'_>,
        voxels: &mut Voxels<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        // Even on blocks a group is worth a poll; on voxels, each stage updates all of them.
        nested.poll(self.levels[level].stages() as usize, voxels.top())?;
        let blocks = matches!(self.levels[level].step, StepMethod::Blocks);
        let seconds = interval::total_seconds(intervals);
        let window = self.window(nested.patch, voxels.top(), level, intervals, seconds);
        if window.is_some_and(|window| !self.saves(window, nested.patch, level, seconds)) {
            if blocks {
                self.end_composite(nested.patch, voxels, coefficients);
            }
            return self.advance(nested, voxels, coefficients, level - 1, intervals);
        }
        if blocks {
            self.composite(nested, voxels, coefficients, level, intervals, window);
            nested.pass(intervals);
            return Ok(());
        }
        nested.apply(&self.memory.changes, coefficients);
        let inner = window.map(|window| {
            let mut inner = self.memory.windows.pop().unwrap_or_default();
            inner.copy_window(window, nested.patch);
            inner
        });
        nested.advance_halo(seconds, voxels.top());
        self.step(nested.patch, voxels, coefficients, level, seconds, None);
        if let Some(mut inner) = inner {
            let outer = HaloSource::Patch(&*nested.patch);
            let known = nested.known;
            let mut finer = NestedPatch::new(&mut inner, known, outer, seconds);
            self.advance(&mut finer, voxels, coefficients, level - 1, intervals)
                .expect("a window is not interrupted");
            nested.apply(&self.memory.changes, coefficients);
            inner.put_back(nested.patch);
            self.memory.windows.push(inner);
        } else {
            self.now += seconds;
        }
        nested.pass(intervals);
        Ok(())
    }

    /// Takes a patch through intervals, each in one step or more.
    fn births(
        &mut self,
        nested: &mut NestedPatch<'_>,
        voxels: &mut Voxels<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
    ) -> Result<(), Interrupted> {
        let seconds = interval::total_seconds(intervals);
        nested.advance_halo(seconds, voxels.top());
        for interval in intervals {
            nested.poll(self.levels[0].stages() as usize, voxels.top())?;
            if let Some(at) = interval.held.filter(|_| interval.born) {
                voxels.birth(at, nested.patch, coefficients, &mut self.memory.changes);
                self.history.push((at, self.now + interval.seconds));
            }
            nested.apply(&self.memory.changes, coefficients);
            let held = interval
                .held
                .map(|at| nested.patch.index(at).expect("windows hold all births of their steps"));
            for part in interval.split(self.levels[0].seconds) {
                self.step(nested.patch, voxels, coefficients, 0, part.seconds, held);
            }
            self.now += interval.seconds;
            nested.pass(std::slice::from_ref(interval));
        }
        Ok(())
    }

    /// One step of a level.
    fn step(
        &mut self,
        patch: &mut Patch,
        voxels: &Voxels<'_>,
        coefficients: &Coefficients,
        level: usize,
        seconds: f64,
        held: Option<usize>,
    ) {
        // A window may lie above all that is printed so far, where the first birth needs nothing to
        // lie on.
        let top = voxels.top().saturating_sub(patch.origin[2]).clamp(1, patch.shape.rows - 1);
        let StepMethod::Voxels(polynomial) = &self.levels[level].step else {
            unreachable!("steps on blocks are taken elsewhere")
        };
        for factor in &polynomial.factors {
            let stages = Quadratic {
                a: (factor.a * seconds) as f32,
                b: (factor.b * seconds * seconds) as f32,
            };
            TwoStageSweep { coefficients, patch, stages, held, top }.sweep(&mut self.memory.kept);
        }
    }

    /// Where a step over the given intervals, of so many seconds, has to be taken in shorter ones,
    /// if anywhere.
    fn window(
        &self,
        patch: &Patch,
        top: usize,
        level: usize,
        intervals: &[Interval],
        seconds: f64,
    ) -> Option<Window> {
        let level = &self.levels[level];
        let coming = intervals.iter().filter_map(|interval| interval.held);
        let pause = interval::total_seconds(intervals.iter().filter(|interval| interval.born))
            < 0.9 * seconds;
        let since_s = self.now - if pause { level.pause_age_s() } else { level.age_s };
        let recent = self.history.iter().rev().take_while(|&&(_, time)| time > since_s);
        Window::around(recent.map(|&(at, _)| at).chain(coming), level.margins, patch, top)
    }

    /// Whether a long step of a patch and short ones of a window take less time than short ones of
    /// the patch.
    fn saves(&self, window: Window, patch: &Patch, level: usize, seconds: f64) -> bool {
        let (long, short) =
            (&self.levels[level], self.levels[level - 1].stages_per_second() * seconds);
        let (whole, part) = (patch.shape.len() as f64, window.shape.len() as f64);
        let copy = if matches!(long.step, StepMethod::Blocks) { LOOK_STAGES } else { COPY_STAGES };
        whole * long.stages() + part * (short + copy) < WORTHWHILE * whole * short
    }
}

#[cfg(test)]
mod tests;
