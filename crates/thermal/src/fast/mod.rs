//! The fast stepper: long steps far from the nozzle, short ones near it.
//!
//! Behind the nozzle, temperatures change within milliseconds; a few millimetres away, within
//! seconds; farther still, within minutes.
//! So a long step is taken everywhere first, as if nothing was born in it.
//! It is wrong near the nozzle: in a **window** around all recent births, and around those of the
//! step itself, the step is then taken anew in shorter steps, from a copy of the old temperatures,
//! and the copy's **rim** follows the long step.
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

use crate::kernel::{Kept, Pair, Quadratic};
use crate::law::Law;
use crate::occupancy::Change;
use crate::patch::Patch;
use crate::piece::{self, Piece};
use crate::state::{StateMut, Voxels};

use self::far::FarField;
use self::level::{Level, Step, levels};
use self::nested::{Nested, Outer};
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
pub(crate) struct Fast {
    levels: Vec<Level>,
    /// Births that are still of interest, oldest first: where, and when their slots ended.
    history: Vec<([usize; 3], f64)>,
    now: f64,
    /// Voxels, rim and all, from which on steps on blocks are taken.
    many_voxels: usize,
    memory: Memory,
}

/// Memory that is used again and again.
#[derive(Debug, Default)]
struct Memory {
    windows: Vec<Patch>,
    kept: Kept,
    far: FarField,
    /// What the births of the run have changed, in their order.
    changes: Vec<Change>,
}

impl Clone for Fast {
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

impl Fast {
    pub(crate) fn new(accuracy: Accuracy, law: &Law) -> Self {
        Self {
            levels: levels(accuracy, law),
            history: Vec::new(),
            now: 0.0,
            many_voxels: MANY_VOXELS,
            memory: Memory::default(),
        }
    }

    /// In so many threads of the current pool.
    pub(crate) fn run(&mut self, state: StateMut<'_>, law: &Law, pieces: &[Piece], threads: usize) {
        self.memory.kept.threads = threads;
        let StateMut { patch, mut voxels } = state;
        for pieces in pieces.chunks(RUN) {
            let mut whole = Nested::whole(patch);
            let shape = whole.patch.shape;
            let many = shape.row * shape.planes * voxels.top() >= self.many_voxels;
            let level = self.levels.len() - if many { 1 } else { 2 };
            self.advance(&mut whole, &mut voxels, law, level, pieces);
            whole.take_up(&self.memory.changes, law);
            self.memory.changes.clear();
        }
        self.end_composite(patch, &voxels, law);
        let oldest = self.now - self.levels.iter().map(Level::pause_age_s).fold(0.0, f64::max);
        let past = self.history.partition_point(|&(_, time)| time < oldest);
        self.history.drain(..past);
    }

    /// Takes a patch through some pieces, in steps of a level or shorter ones.
    fn advance(
        &mut self,
        nested: &mut Nested<'_>,
        voxels: &mut Voxels<'_>,
        law: &Law,
        level: usize,
        mut pieces: &[Piece],
    ) {
        if level == 0 {
            self.births(nested, voxels, law, pieces);
            return;
        }
        let longest = self.levels[level].seconds;
        while let Some((&first, rest)) = pieces.split_first() {
            if first.seconds > longest {
                for part in first.parts(longest) {
                    self.group(nested, voxels, law, level, &[part]);
                }
                pieces = rest;
                continue;
            }
            let mut seconds = 0.0;
            let fits = |piece: &&Piece| {
                seconds += piece.seconds;
                seconds <= longest
            };
            let (group, rest) = pieces.split_at(pieces.iter().take_while(fits).count());
            self.group(nested, voxels, law, level, group);
            pieces = rest;
        }
    }

    /// Takes a patch through pieces that fit into one step of a level.
    fn group(
        &mut self,
        nested: &mut Nested<'_>,
        voxels: &mut Voxels<'_>,
        law: &Law,
        level: usize,
        pieces: &[Piece],
    ) {
        let blocks = matches!(self.levels[level].step, Step::Blocks);
        let seconds = piece::seconds(pieces);
        let window = self.window(nested.patch, voxels.top(), level, pieces, seconds);
        if window.is_some_and(|window| !self.saves(window, nested.patch, level, seconds)) {
            if blocks {
                self.end_composite(nested.patch, voxels, law);
            }
            self.advance(nested, voxels, law, level - 1, pieces);
            return;
        }
        if blocks {
            self.composite(nested, voxels, law, level, pieces, window);
            return;
        }
        nested.take_up(&self.memory.changes, law);
        let inner = window.map(|window| {
            let mut inner = self.memory.windows.pop().unwrap_or_default();
            inner.copy_window(window, nested.patch);
            inner
        });
        nested.move_rim(seconds, voxels.top());
        self.step(nested.patch, voxels, law, level, seconds, None);
        if let Some(mut inner) = inner {
            let outer = Outer::Patch(&*nested.patch);
            let known = nested.known;
            let mut finer = Nested::new(&mut inner, known, outer, seconds);
            self.advance(&mut finer, voxels, law, level - 1, pieces);
            nested.take_up(&self.memory.changes, law);
            inner.put_back(nested.patch);
            self.memory.windows.push(inner);
        } else {
            self.now += seconds;
        }
    }

    /// Takes a patch through pieces, each in one step or more.
    fn births(
        &mut self,
        nested: &mut Nested<'_>,
        voxels: &mut Voxels<'_>,
        law: &Law,
        pieces: &[Piece],
    ) {
        let seconds = piece::seconds(pieces);
        nested.move_rim(seconds, voxels.top());
        for piece in pieces {
            if let Some(at) = piece.held.filter(|_| piece.born) {
                voxels.birth(at, nested.patch, law, &mut self.memory.changes);
                self.history.push((at, self.now + piece.seconds));
            }
            nested.take_up(&self.memory.changes, law);
            let held = piece
                .held
                .map(|at| nested.patch.index(at).expect("windows hold all births of their steps"));
            for part in piece.parts(self.levels[0].seconds) {
                self.step(nested.patch, voxels, law, 0, part.seconds, held);
            }
            self.now += piece.seconds;
        }
    }

    /// One step of a level.
    fn step(
        &mut self,
        patch: &mut Patch,
        voxels: &Voxels<'_>,
        law: &Law,
        level: usize,
        seconds: f64,
        held: Option<usize>,
    ) {
        // A window may lie above all that is printed so far, where the first birth needs nothing to
        // lie on.
        let top = voxels.top().saturating_sub(patch.origin[2]).clamp(1, patch.shape.rows - 1);
        let Step::Voxels(polynomial) = &self.levels[level].step else {
            unreachable!("steps on blocks are taken elsewhere")
        };
        for factor in &polynomial.factors {
            let stages = Quadratic {
                a: (factor.a * seconds) as f32,
                b: (factor.b * seconds * seconds) as f32,
            };
            Pair { law, patch, stages, held, top }.sweep(&mut self.memory.kept);
        }
    }

    /// Where a step over the given pieces, of so many seconds, has to be taken in shorter ones, if
    /// anywhere.
    fn window(
        &self,
        patch: &Patch,
        top: usize,
        level: usize,
        pieces: &[Piece],
        seconds: f64,
    ) -> Option<Window> {
        let level = &self.levels[level];
        let coming = pieces.iter().filter_map(|piece| piece.held);
        let pause = piece::seconds(pieces.iter().filter(|piece| piece.born)) < 0.9 * seconds;
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
        let copy = if matches!(long.step, Step::Blocks) { LOOK_STAGES } else { COPY_STAGES };
        whole * long.stages() + part * (short + copy) < WORTHWHILE * whole * short
    }
}

#[cfg(test)]
mod tests;
