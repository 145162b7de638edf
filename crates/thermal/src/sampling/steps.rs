//! Samples at the ends of the method's own steps.

use beadwork_base::{Control, Interrupted};

use crate::event::DepositionEvent;
use crate::fast::INTERVALS_PER_RUN;
use crate::interval::Interval;
use crate::run_control::RunControl;
use crate::simulation::Simulation;

impl Simulation {
    /// Runs through events that [`Simulation::validate`] has turned into intervals, and calls
    /// `sample` whenever the next interval would make the time since the last sample longer than
    /// `max_s`, and at the end.
    ///
    /// Pauses longer than `max_s` are split into equal ones, with a sample at the end of each;
    /// depositions are never cut.
    /// The fast method groups intervals into steps in the same way, so that with the length of its
    /// longest step the samples fall on the ends of steps, and change no bit of the result as long
    /// as no step is on blocks.
    pub(crate) fn run_in_steps(
        &mut self,
        events: &[DepositionEvent],
        intervals: &[Interval],
        max_s: f64,
        mut sample: impl FnMut(&Self),
        control: &Control<'_>,
    ) -> Result<(), Interrupted> {
        let mut run = RunControl::new(control, events.len());
        let (mut batch, mut batch_intervals) = (Vec::new(), Vec::new());
        let (mut batch_s, mut after_long) = (0.0, false);
        let lasting = events.iter().filter(|event| event.seconds > 0.0);
        for (number, (event, &interval)) in lasting.zip(intervals).enumerate() {
            let is_long = interval.seconds > max_s;
            let is_cut = is_long && event.voxel.is_none();
            for part in interval.split(if is_cut { max_s } else { f64::INFINITY }) {
                let is_due = batch_s + part.seconds > max_s
                    || is_long
                    || after_long
                    || number % INTERVALS_PER_RUN == 0;
                after_long = is_long;
                if is_due && !batch.is_empty() {
                    self.advance(&batch, &batch_intervals, control.threads, &mut run)?;
                    batch.clear();
                    batch_intervals.clear();
                    batch_s = 0.0;
                    sample(self);
                    control.check()?;
                }
                batch_s += part.seconds;
                batch.push(DepositionEvent { seconds: part.seconds, ..*event });
                batch_intervals.push(part);
            }
        }
        if !batch.is_empty() {
            self.advance(&batch, &batch_intervals, control.threads, &mut run)?;
            sample(self);
        }
        run.finish();
        Ok(())
    }
}
