//! The plain steppers: every voxel is stepped in every step.

use beadwork_base::Interrupted;

use crate::aligned::AlignedBuffer;
use crate::coefficients::Coefficients;
use crate::interval::Interval;
use crate::kernel::{EulerSweep, Quadratic, SweepBuffers, TwoStageSweep, TwoSteps, dispatch};
use crate::occupancy::Change;
use crate::run_control::RunControl;
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
pub(crate) struct ExplicitStepper {
    pub(crate) scheme: Scheme,
    /// Longest stretch in a pause that takes as many steps as a birth, s; with Heun's method, in a
    /// birth too.
    pub(crate) longest_s: f64,
    scratch: AlignedBuffer,
    kept: SweepBuffers,
    changes: Vec<Change>,
}

impl Clone for ExplicitStepper {
    fn clone(&self) -> Self {
        Self::new(self.scheme, self.longest_s)
    }
}

impl ExplicitStepper {
    pub(crate) fn new(scheme: Scheme, longest_s: f64) -> Self {
        Self {
            scheme,
            longest_s,
            scratch: AlignedBuffer::default(),
            kept: SweepBuffers::default(),
            changes: Vec::new(),
        }
    }

    /// In so many threads of the current pool; births of the plain scheme take one.
    pub(crate) fn run(
        &mut self,
        mut state: StateMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
        threads: usize,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        self.kept.threads = threads;
        if self.scheme == Scheme::Euler {
            self.scratch.clone_from(&state.patch.theta);
        }
        for interval in intervals {
            if let Some(at) = interval.held.filter(|_| interval.born) {
                state.voxels.birth(at, state.patch, coefficients, &mut self.changes);
                state.patch.apply(&self.changes, coefficients);
                self.changes.clear();
            }
            let held = interval.held.map(|at| state.patch.shape.index(at));
            // A birth that takes longer than others is one step all the same by the plain scheme's
            // definition.
            let whole = held.is_some() && self.scheme == Scheme::Euler;
            let steps = if whole { 1 } else { interval.split(self.longest_s).count() };
            let seconds = interval.seconds / steps as f64;
            match self.scheme {
                Scheme::Euler => {
                    self.euler(&mut state, coefficients, seconds, steps, held, run)?;
                }
                Scheme::Heun { steps: parts } => {
                    self.heun(
                        &mut state,
                        coefficients,
                        seconds / f64::from(parts),
                        steps * parts as usize,
                        held,
                        run,
                    )?;
                }
            }
            run.complete(interval);
        }
        Ok(())
    }

    fn euler(
        &mut self,
        state: &mut StateMut<'_>,
        coefficients: &Coefficients,
        step_s: f64,
        steps: usize,
        held: Option<usize>,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        let patch = &mut *state.patch;
        let (shape, top, seconds) = (patch.shape, state.voxels.top(), step_s as f32);
        let updates = shape.row * shape.planes * top;
        for _ in 0..steps / 2 {
            run.poll(2 * updates)?;
            TwoStageSweep { coefficients, patch, stages: TwoSteps { seconds }, held, top }
                .sweep(&mut self.kept);
            run.pass(2.0 * step_s);
        }
        if steps % 2 == 1 {
            run.poll(updates)?;
            let (arrays, from, to) = (&patch.arrays, &patch.theta, &mut self.scratch);
            dispatch(EulerSweep { coefficients, shape, arrays, from, to, top, seconds });
            std::mem::swap(&mut patch.theta, &mut self.scratch);
            if let Some(held) = held {
                patch.theta[held] = coefficients.birth_theta;
            }
            run.pass(step_s);
        }
        Ok(())
    }

    fn heun(
        &mut self,
        state: &mut StateMut<'_>,
        coefficients: &Coefficients,
        seconds: f64,
        steps: usize,
        held: Option<usize>,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        let (patch, top) = (&mut *state.patch, state.voxels.top());
        let updates = 2 * patch.shape.row * patch.shape.planes * top;
        let stages = Quadratic { a: seconds as f32, b: (seconds * seconds / 2.0) as f32 };
        for _ in 0..steps {
            run.poll(updates)?;
            TwoStageSweep { coefficients, patch, stages, held, top }.sweep(&mut self.kept);
            run.pass(seconds);
        }
        Ok(())
    }
}
