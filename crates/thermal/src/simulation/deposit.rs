//! How a simulation advances: by orders of layers, by deposition events, and by pauses.

use beadwork_base::{Control, Interrupted, Threads};
use beadwork_grid::Cell;
use beadwork_part::Frame;
use thiserror::Error;

use super::setup::{Simulation, Stepper, with_halo};
use crate::event::{DepositionEvent, layer_events};
use crate::explicit::Scheme;
use crate::interval::Interval;
use crate::run_control::RunControl;

/// Why events cannot be simulated.
///
/// All but [`DepositError::Interrupted`] leave the simulation unchanged.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DepositError {
    /// The part has no such voxel.
    #[error("voxel {voxel:?} is not part of the print")]
    Outside {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// The voxel is deposited already.
    #[error("voxel {voxel:?} is deposited twice")]
    Repeated {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// The order of a layer leaves out one of the layer's voxels.
    #[error("voxel {voxel:?} is missing from the order of its layer")]
    Missing {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// The part has a voxel below this one, but that is not deposited yet.
    #[error("voxel {voxel:?} has no support: the voxel below it is not deposited yet")]
    Unsupported {
        /// x, y and z.
        voxel: [u32; 3],
    },
    /// The duration of an event is negative or not finite, or 0 with a voxel.
    #[error(
        "deposition event {event} lasts {seconds} s: it must last at least 0 s, and longer if it \
         deposits a voxel"
    )]
    Duration {
        /// Index of the event.
        event: usize,
        /// Its duration, s.
        seconds: f64,
    },
    /// [`Method::Naive`](super::Method::Naive) takes one step per voxel, and this step would not be
    /// stable.
    #[error(
        "voxel {voxel:?} takes {seconds} s to deposit, longer than the maximum stable step of \
         {limit} s"
    )]
    Unstable {
        /// x, y and z.
        voxel: [u32; 3],
        /// Duration of the event, s.
        seconds: f64,
        /// The maximum stable step, s.
        limit: f64,
    },
    /// The call was interrupted; [`Simulation::run`] says in which state it leaves the simulation.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl Simulation {
    /// Deposits all cells of a layer in the given order, at the process's speed, with travel
    /// between cells that are not neighbours, and returns how long that takes, s.
    ///
    /// Progress counts deposition events, as [`Simulation::layer_events`] lists them.
    /// [`Simulation::run`] describes the state after an interrupted call.
    pub fn deposit(
        &mut self,
        layer: u32,
        order: &[Cell],
        control: &Control<'_>,
    ) -> Result<f64, DepositError> {
        control.check()?;
        let events = self.layer_events(layer, order);
        let before = self.seconds;
        let intervals = self.validate(&events)?;
        self.check_complete(layer, &events)?;
        let mut run = RunControl::new(control, events.len());
        self.advance(&events, &intervals, control.threads, &mut run)?;
        run.finish();
        Ok(self.seconds - before)
    }

    /// The events that [`Simulation::deposit`] would run through now.
    /// The first travel move starts at the last deposited voxel.
    pub fn layer_events(&self, layer: u32, order: &[Cell]) -> Vec<DepositionEvent> {
        let from = self.last.map(|[x, y, _]| y * self.part.frame.width + x);
        layer_events(order, layer, from, &self.part.frame, &self.process)
    }

    /// Runs through events: depositions of any voxels in any order, and pauses.
    ///
    /// Progress counts the events of the call.
    /// The result is the same bit for bit on any number of threads.
    /// Several threads shorten the sweeps of [`Method::Reference`](super::Method::Reference) on
    /// layers of some hundred thousand voxels; they gain little with
    /// [`Method::Fast`](super::Method::Fast), whose sweeps are mostly too short to share.
    /// To try many orders or to simulate many parts, use one thread for each of them instead.
    ///
    /// # Interruption
    /// An interrupted call has run up to some moment between its start and its end, and
    /// [`Simulation::seconds`] is the time of that moment.
    /// All events before it are complete, and those after it have not begun.
    /// The event at that moment may be cut short: its voxel, if it has one, may be deposited, and
    /// the nozzle no longer holds it at the extrusion temperature.
    /// The simulation is in a valid state: it can be read, and run through other events.
    /// Voxels that are deposited must not be deposited again.
    pub fn run(
        &mut self,
        events: &[DepositionEvent],
        control: &Control<'_>,
    ) -> Result<(), DepositError> {
        control.check()?;
        let intervals = self.validate(events)?;
        let mut run = RunControl::new(control, events.len());
        self.advance(events, &intervals, control.threads, &mut run)?;
        run.finish();
        Ok(())
    }

    /// Lets time pass without deposition.
    ///
    /// Progress counts 1 event.
    /// An interrupted call has let some of the time pass.
    ///
    /// # Panics
    /// If the time is negative or not finite.
    pub fn pause(&mut self, seconds: f64, control: &Control<'_>) -> Result<(), Interrupted> {
        match self.run(&[DepositionEvent::pause(seconds)], control) {
            Ok(()) => Ok(()),
            Err(DepositError::Interrupted(interrupted)) => Err(interrupted),
            Err(error) => panic!("a pause is not possible: {error}"),
        }
    }

    /// Runs through events that [`Simulation::validate`] has turned into intervals.
    pub(crate) fn advance(
        &mut self,
        events: &[DepositionEvent],
        intervals: &[Interval],
        threads: Threads<'_>,
        run: &mut RunControl<'_>,
    ) -> Result<(), Interrupted> {
        run.restart_clock();
        let Self { state, stepper, coefficients, .. } = self;
        // `RunControl` is not `Sync`, so a shared reference to it could not be sent to a thread of
        // the pool; a mutable one can.
        let run_here = &mut *run;
        let mut step = move |threads| {
            let (state, run) = (state.make_mut(), &*run_here);
            match stepper {
                Stepper::Explicit(stepper) => {
                    stepper.run(state, coefficients, intervals, threads, run)
                }
                Stepper::Fast(stepper) => stepper.run(state, coefficients, intervals, threads, run),
            }
        };
        let result = match threads {
            Threads::One => step(1),
            Threads::Current => step(threads.count()),
            Threads::Pool(pool) => pool.install(|| step(threads.count())),
        };
        let Err(interrupted) = result else {
            self.seconds += events.iter().map(|event| event.seconds).sum::<f64>();
            self.last = events.iter().rev().find_map(|event| event.voxel).or(self.last);
            return Ok(());
        };
        self.seconds += run.passed_s();
        let deposited = |&voxel: &[u32; 3]| self.temperature_c(voxel).is_some();
        let last = events.iter().filter_map(|event| event.voxel).take_while(deposited).last();
        self.last = last.or(self.last);
        Err(interrupted)
    }

    /// Returns an error if events leave out a voxel of a layer.
    ///
    /// Linear in the events and in the grid's cells.
    pub fn check_complete(
        &self,
        layer: u32,
        events: &[DepositionEvent],
    ) -> Result<(), DepositError> {
        let Frame { width, height, .. } = self.part.frame;
        let mut deposited = vec![false; (width * height) as usize];
        for [x, y, z] in events.iter().filter_map(|event| event.voxel) {
            if z == layer && x < width && y < height {
                deposited[(y * width + x) as usize] = true;
            }
        }
        let missing = self.cells(layer).find(|&cell| !deposited[cell as usize]);
        missing.map_or(Ok(()), |cell| {
            Err(DepositError::Missing { voxel: [cell % width, cell / width, layer] })
        })
    }

    /// Length of the longest step of the method on the part as printed so far, s; `None` if it has
    /// a step for each event.
    pub(crate) fn longest_step_s(&self) -> Option<f64> {
        match &self.stepper {
            Stepper::Explicit(_) => None,
            Stepper::Fast(stepper) => {
                Some(stepper.longest_step_s(self.state.patch.shape, self.state.top))
            }
        }
    }

    /// Checks events and turns those that take time into intervals.
    pub(crate) fn validate(
        &self,
        events: &[DepositionEvent],
    ) -> Result<Vec<Interval>, DepositError> {
        let is_naive = matches!(
            &self.stepper,
            Stepper::Explicit(stepper) if stepper.scheme == Scheme::Euler
        );
        let shape = self.state.patch.shape;
        let mut fresh = vec![false; shape.len()];
        let mut intervals = Vec::with_capacity(events.len());
        for (number, &DepositionEvent { voxel, seconds }) in events.iter().enumerate() {
            let born = voxel.is_some();
            if !(seconds.is_finite() && (seconds > 0.0 || (!born && seconds == 0.0))) {
                return Err(DepositError::Duration { event: number, seconds });
            }
            if let Some(voxel) = voxel {
                let [x, y, z] = voxel;
                if self.part.material(x, y, z as usize).is_none() {
                    return Err(DepositError::Outside { voxel });
                }
                let index = shape.index(with_halo(voxel));
                if self.state.occupancy.is_active(index) || fresh[index] {
                    return Err(DepositError::Repeated { voxel });
                }
                if z > 0 && self.part.material(x, y, z as usize - 1).is_some() {
                    let below = shape.index(with_halo([x, y, z - 1]));
                    if !self.state.occupancy.is_active(below) && !fresh[below] {
                        return Err(DepositError::Unsupported { voxel });
                    }
                }
                if is_naive && seconds > self.max_stable_step_s {
                    let limit = self.max_stable_step_s;
                    return Err(DepositError::Unstable { voxel, seconds, limit });
                }
                fresh[index] = true;
            }
            if seconds > 0.0 {
                let (held, completes) = (voxel.map(with_halo), Some(number + 1));
                intervals.push(Interval { held, born, seconds, completes });
            }
        }
        Ok(intervals)
    }
}
