//! Samples of a print at regular times.

mod steps;

use beadwork_base::Control;
use ndarray::{Array3, ArrayView3};

use crate::event::DepositionEvent;
use crate::interval::Interval;
use crate::run_control::RunControl;
use crate::simulation::{DepositError, Simulation};

/// Times this close to a multiple of the sampling interval count as the multiple, as a fraction of
/// the interval.
const TOLERANCE: f64 = 1e-9;

impl Simulation {
    /// Runs through events like [`Simulation::run`], and calls `sample` at regular times.
    ///
    /// Samples are due at multiples of `interval_s` since the start of the *print*, so that layers
    /// can be sampled in one call each.
    /// Pauses are cut at these times.
    /// Depositions are not: a sample that is due during one is taken at its end, and if several are
    /// due, only one is taken.
    /// None is taken at the start or the end of the call unless it is due then.
    ///
    /// The result differs from that of [`Simulation::run`] by at most the method's error.
    /// An interval shorter than the long steps of [`Method::Fast`](crate::simulation::Method::Fast)
    /// cuts these steps and takes more time.
    /// Progress counts the events of the call.
    /// [`Simulation::run`] describes the state after an interrupted call; all samples that were due
    /// until then have been taken.
    ///
    /// # Panics
    /// If the interval is not more than 0.
    pub fn run_sampled(
        &mut self,
        events: &[DepositionEvent],
        interval_s: f64,
        mut sample: impl FnMut(&Self),
        control: &Control<'_>,
    ) -> Result<(), DepositError> {
        assert!(interval_s > 0.0, "the sampling interval must be more than 0");
        control.check()?;
        let intervals = self.validate(events)?;
        let mut run = RunControl::new(control, events.len());
        let next = |now_s: f64| ((now_s / interval_s + TOLERANCE).floor() + 1.0) * interval_s;
        let (mut now_s, mut due_s) = (self.seconds(), next(self.seconds()));
        // What is to be run before the next sample.
        let (mut batch, mut batch_intervals) = (Vec::new(), Vec::new());
        let lasting = events.iter().filter(|event| event.seconds > 0.0);
        for (&event, interval) in lasting.zip(intervals) {
            let mut left_s = event.seconds;
            while left_s > 0.0 {
                let is_cut = event.voxel.is_none() && now_s + left_s > due_s;
                let seconds = if is_cut { due_s - now_s } else { left_s };
                now_s += seconds;
                left_s -= seconds;
                let completes = interval.completes.filter(|_| left_s <= 0.0);
                batch.push(DepositionEvent { seconds, ..event });
                batch_intervals.push(Interval { seconds, completes, ..interval });
                if now_s >= due_s - TOLERANCE * interval_s {
                    self.advance(&batch, &batch_intervals, control.threads, &mut run)?;
                    batch.clear();
                    batch_intervals.clear();
                    sample(self);
                    control.check()?;
                    now_s = self.seconds();
                    due_s = next(now_s);
                }
            }
        }
        self.advance(&batch, &batch_intervals, control.threads, &mut run)?;
        run.finish();
        Ok(())
    }
}

/// The temperatures of some voxels over time.
///
/// ```no_run
/// # use beadwork_base::Control;
/// # use beadwork_thermal::sampling::Probes;
/// # use beadwork_thermal::simulation::DepositError;
/// # use beadwork_thermal::{DepositionEvent, Simulation};
/// # fn run(print: &mut Simulation, events: &[DepositionEvent]) -> Result<(), DepositError> {
/// let mut probes = Probes::new(vec![[0, 0, 0], [5, 3, 1]]);
/// print.run_sampled(events, 0.5, |print| probes.sample(print), &Control::default())?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Probes {
    voxels: Vec<[u32; 3]>,
    seconds: Vec<f64>,
    /// `[sample, probe]`.
    celsius: Vec<Option<f64>>,
}

impl Probes {
    /// Probes at the voxels with these x, y and z.
    pub fn new(voxels: Vec<[u32; 3]>) -> Self {
        Self { voxels, seconds: Vec::new(), celsius: Vec::new() }
    }

    /// Records the present temperatures.
    pub fn sample(&mut self, simulation: &Simulation) {
        self.seconds.push(simulation.seconds());
        self.celsius.extend(self.voxels.iter().map(|&voxel| simulation.temperature_c(voxel)));
    }

    /// Positions of the probes: x, y and z of each.
    pub fn voxels(&self) -> &[[u32; 3]] {
        &self.voxels
    }

    /// Times of the samples, s.
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// The temperatures at a probe, °C, one per sample; `None` as long as its voxel is not
    /// deposited.
    ///
    /// # Panics
    /// If there is no such probe.
    pub fn celsius(&self, probe: usize) -> impl Iterator<Item = Option<f64>> {
        assert!(probe < self.voxels.len(), "probe {probe} does not exist");
        self.celsius.iter().skip(probe).step_by(self.voxels.len()).copied()
    }
}

/// The time each voxel has spent above a temperature, for example above the glass transition, where
/// beads weld.
///
/// A voxel that is above the temperature at a sample counts as above it since the sample before.
/// So each period above the temperature is wrong by up to one sampling interval in either
/// direction, by 0 on average, and periods shorter than the interval may be missed.
/// The memory is 8 bytes per voxel of the part's bounding box.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAbove {
    above_c: f64,
    /// Time of the last sample, s.
    last_s: f64,
    /// `[z, y, x]`.
    seconds: Array3<f64>,
}

impl TimeAbove {
    /// Counts the time above a temperature in °C, from the simulation's present time on.
    pub fn new(simulation: &Simulation, above_c: f64) -> Self {
        let part = simulation.part();
        let shape = [part.depth, part.frame.height as usize, part.frame.width as usize];
        Self { above_c, last_s: simulation.seconds(), seconds: Array3::zeros(shape) }
    }

    /// Adds the time since the last sample to all voxels that are above the temperature now.
    /// Linear in the bounding box of all layers up to the highest deposited voxel.
    pub fn sample(&mut self, simulation: &Simulation) {
        let passed_s = simulation.seconds() - self.last_s;
        self.last_s = simulation.seconds();
        for ([x, y, z], celsius) in simulation.deposited(0..simulation.part().depth) {
            if celsius > self.above_c {
                self.seconds[[z as usize, y as usize, x as usize]] += passed_s;
            }
        }
    }

    /// The temperature, °C.
    pub fn above_c(&self) -> f64 {
        self.above_c
    }

    /// The time each voxel of the part's bounding box was above the temperature, s, with the axes
    /// `[z, y, x]`; 0 where nothing is deposited.
    pub fn seconds(&self) -> ArrayView3<'_, f64> {
        self.seconds.view()
    }

    /// The time the voxel at x, y and z was above the temperature, s; `None` outside the part's
    /// bounding box.
    pub fn at(&self, [x, y, z]: [u32; 3]) -> Option<f64> {
        self.seconds.get([z as usize, y as usize, x as usize]).copied()
    }
}

#[cfg(test)]
mod tests;
