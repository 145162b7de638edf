//! Explicit steppers: the same step for the whole part, again and again.
//!
//! [`Scheme::Euler`] is the scheme of the paper and the definition that the fast stepper follows.
//! [`Scheme::Heun`] is second order and serves as a reference for errors.
//! Both take at least one step for each birth, and each step sweeps all that is printed so far, so
//! a print costs the square of its voxels.
//!
//! A forward Euler step is stable up to 2 / λ, where λ is the fastest decay rate
//! ([`Coefficients::max_rate`]); so is a step of Heun's method.
//! The caller checks this: it refuses births that take longer, or passes a shorter `max_step_s`.

use beadwork_base::Interrupted;

use crate::aligned::AlignedBuffer;
use crate::coefficients::Coefficients;
use crate::interval::Interval;
use crate::kernel::{EulerSweep, Quadratic, SweepBuffers, TwoStageSweep, TwoSteps, dispatch};
use crate::occupancy::VoxelChange;
use crate::run_control::RunControl;
use crate::state::StateMut;

/// How steps are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scheme {
    /// Forward Euler: one step for each birth, whatever its length (Kim et al. 2026), and equal
    /// steps no longer than `max_step_s` in pauses.
    Euler,
    /// Heun's method: births and pauses are split into equal intervals no longer than `max_step_s`,
    /// and each of these into `steps` steps.
    Heun { steps: u32 },
}

/// Steps a whole part in equal steps.
///
/// Clones share no buffers.
#[derive(Debug)]
pub(crate) struct ExplicitStepper {
    pub(crate) scheme: Scheme,
    /// Longest interval that is not split, s; see [`Scheme`].
    pub(crate) max_step_s: f64,
    /// Target of single Euler steps.
    scratch: AlignedBuffer,
    buffers: SweepBuffers,
    changes: Vec<VoxelChange>,
}

impl Clone for ExplicitStepper {
    fn clone(&self) -> Self {
        Self::new(self.scheme, self.max_step_s)
    }
}

impl ExplicitStepper {
    pub(crate) fn new(scheme: Scheme, max_step_s: f64) -> Self {
        Self {
            scheme,
            max_step_s,
            scratch: AlignedBuffer::default(),
            buffers: SweepBuffers::default(),
            changes: Vec::new(),
        }
    }

    /// Steps a state through some intervals.
    ///
    /// Sweeps may use `threads` threads of the current pool; single Euler steps use one.
    /// The call can be interrupted between any two steps.
    pub(crate) fn run(
        &mut self,
        mut state: StateMut<'_>,
        coefficients: &Coefficients,
        intervals: &[Interval],
        threads: usize,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        self.buffers.threads = threads;
        if self.scheme == Scheme::Euler {
            // Sweeps do not write the halo and empty rows, so both arrays must agree there.
            self.scratch.clone_from(&state.patch.theta);
        }
        for interval in intervals {
            if let Some(position) = interval.held.filter(|_| interval.born) {
                state.occupancy.birth(position, state.patch, coefficients, &mut self.changes);
                state.patch.apply(&self.changes, coefficients);
                self.changes.clear();
            }
            let held = interval.held.map(|position| state.patch.shape.index(position));
            let one_step = held.is_some() && self.scheme == Scheme::Euler;
            let count = if one_step { 1 } else { interval.split(self.max_step_s).count() };
            let seconds = interval.seconds / count as f64;
            match self.scheme {
                Scheme::Euler => {
                    self.step_euler(&mut state, coefficients, seconds, count, held, run)?;
                }
                Scheme::Heun { steps } => {
                    let (seconds, count) = (seconds / f64::from(steps), count * steps as usize);
                    self.step_heun(&mut state, coefficients, seconds, count, held, run)?;
                }
            }
            run.complete(interval);
        }
        Ok(())
    }

    /// Takes `count` Euler steps: as many as possible in pairs, which read and write each
    /// temperature once for both.
    fn step_euler(
        &mut self,
        state: &mut StateMut<'_>,
        coefficients: &Coefficients,
        step_s: f64,
        count: usize,
        held: Option<usize>,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        let patch = &mut *state.patch;
        let (shape, top, seconds) = (patch.shape, state.occupancy.top(), step_s as f32);
        let updates = shape.row_len * shape.planes * top;
        let scheme = TwoSteps { seconds };
        for _ in 0..count / 2 {
            run.poll(2 * updates)?;
            TwoStageSweep { coefficients, patch, scheme, held, top }.sweep(&mut self.buffers);
            run.pass(2.0 * step_s);
        }
        if count % 2 == 1 {
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

    /// Takes `count` steps of Heun's method.
    fn step_heun(
        &mut self,
        state: &mut StateMut<'_>,
        coefficients: &Coefficients,
        seconds: f64,
        count: usize,
        held: Option<usize>,
        run: &RunControl<'_>,
    ) -> Result<(), Interrupted> {
        let (patch, top) = (&mut *state.patch, state.occupancy.top());
        let updates = 2 * patch.shape.row_len * patch.shape.planes * top;
        let scheme = Quadratic { a: seconds as f32, b: (seconds * seconds / 2.0) as f32 };
        for _ in 0..count {
            run.poll(updates)?;
            TwoStageSweep { coefficients, patch, scheme, held, top }.sweep(&mut self.buffers);
            run.pass(seconds);
        }
        Ok(())
    }
}
