//! The plain steppers: every voxel is stepped in every step.

use crate::aligned::Aligned;
use crate::kernel::{Euler, Pair, Rates, dispatch};
use crate::law::Law;
use crate::occupancy::Change;
use crate::piece::Piece;
use crate::state::StateMut;

/// How a step is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scheme {
    /// Forward Euler, one step a birth: the definition of all else (Kim et al. 2026).
    Euler,
    /// Heun's method, so many steps a birth, and more in births that take longer than others.
    Heun { steps: u32 },
}

/// Steps the whole part, again and again.
#[derive(Debug)]
pub(crate) struct Explicit {
    pub(crate) scheme: Scheme,
    /// Longest stretch in a pause that takes as many steps as a birth, s; with Heun's method, in a birth too.
    pub(crate) longest_s: f64,
    scratch: Aligned,
    rates: Rates,
    changes: Vec<Change>,
}

impl Clone for Explicit {
    fn clone(&self) -> Self {
        Self::new(self.scheme, self.longest_s)
    }
}

impl Explicit {
    pub(crate) fn new(scheme: Scheme, longest_s: f64) -> Self {
        Self { scheme, longest_s, scratch: Aligned::default(), rates: Rates::default(), changes: Vec::new() }
    }

    /// In so many threads of the current pool; the plain scheme takes one.
    pub(crate) fn run(&mut self, mut state: StateMut<'_>, law: &Law, pieces: &[Piece], threads: usize) {
        self.rates.threads = threads;
        self.scratch.clone_from(&state.patch.theta);
        for piece in pieces {
            if let Some(at) = piece.held.filter(|_| piece.born) {
                state.voxels.birth(at, state.patch, law, &mut self.changes);
                state.patch.take_up(&self.changes, law);
                self.changes.clear();
            }
            let held = piece.held.map(|at| state.patch.shape.index(at));
            // A birth that takes longer than others is one step all the same by the plain scheme's definition.
            let whole = held.is_some() && self.scheme == Scheme::Euler;
            let steps = if whole { 1 } else { piece.parts(self.longest_s).count() };
            for _ in 0..steps {
                self.step(&mut state, law, piece.seconds / steps as f64, held);
            }
        }
    }

    fn step(&mut self, state: &mut StateMut<'_>, law: &Law, seconds: f64, held: Option<usize>) {
        let patch = &mut *state.patch;
        let (shape, top) = (patch.shape, state.voxels.top());
        match self.scheme {
            Scheme::Euler => {
                let (activity, seconds) = (&patch.activity, seconds as f32);
                dispatch(Euler {
                    law,
                    shape,
                    activity,
                    from: &patch.theta,
                    to: &mut self.scratch,
                    top,
                    seconds,
                });
                std::mem::swap(&mut patch.theta, &mut self.scratch);
                if let Some(held) = held {
                    patch.theta[held] = law.birth;
                }
            }
            Scheme::Heun { steps } => {
                let seconds = seconds / f64::from(steps);
                let (a, b) = (seconds as f32, (seconds * seconds / 2.0) as f32);
                for _ in 0..steps {
                    Pair { law, patch, a, b, held, top }.sweep(&mut self.rates);
                }
            }
        }
    }
}
