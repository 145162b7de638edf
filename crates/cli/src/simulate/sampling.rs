//! Measures that are sampled at intervals while a part is printed.

use anyhow::anyhow;
use beadwork_base::Control;
use beadwork_part::slice::Voxels;
use beadwork_thermal::sampling::{Probes, TimeAbove};
use beadwork_thermal::simulation::DepositError;
use beadwork_thermal::warpage::{WarpageEstimate, WarpageEstimator};
use beadwork_thermal::{DepositionEvent, Simulation, ThermalMaterial};
use serde::Serialize;

/// Seconds between samples of the warpage estimate and of the time above a temperature.
/// Estimates with different intervals cannot be compared, so the interval is the same for all
/// prints.
const INTERVAL_S: f64 = 0.5;

/// Tolerance of times, as a share of the interval: a time this close to a multiple of the interval
/// counts as that multiple.
const ROUNDING: f64 = 1e-9;

/// The measures that sample a print.
pub(super) struct Samplers {
    /// Seconds between samples; `None` if nothing is sampled.
    every_s: Option<f64>,
    probes: Option<(Rhythm, Probes)>,
    rhythm: Rhythm,
    above: Option<TimeAbove>,
    warpage: Option<WarpageEstimator>,
}

/// The measures that the flags request.
pub(super) struct Requested<'a> {
    /// Voxels whose temperature is recorded.
    pub(super) probes: Vec<[u32; 3]>,
    /// Seconds between their samples.
    pub(super) probe_seconds: f64,
    /// The temperature above which time is counted, in °C.
    pub(super) above_c: Option<f64>,
    /// The material, if its warpage is estimated.
    pub(super) warpage: Option<&'a ThermalMaterial>,
}

/// Results of all samples.
pub(super) struct Sampled {
    pub(super) probes: Option<Probes>,
    pub(super) above: Option<TimeAboveSummary>,
    pub(super) warpage: Option<WarpageEstimate>,
}

/// Time that voxels spent above a temperature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct TimeAboveSummary {
    /// The temperature in °C.
    pub(super) above_c: f64,
    /// Maximum over the voxels, in s.
    pub(super) longest_s: f64,
    /// Mean over all voxels of the part, in s.
    pub(super) mean_s: f64,
}

impl Samplers {
    /// Samplers that start at the current state of a simulation.
    pub(super) fn new(simulation: &Simulation, requested: Requested<'_>) -> Self {
        let Requested { probes, probe_seconds, above_c, warpage } = requested;
        let own_s = (above_c.is_some() || warpage.is_some()).then_some(INTERVAL_S);
        let probe_s = (!probes.is_empty()).then_some(probe_seconds);
        Self {
            every_s: own_s.into_iter().chain(probe_s).reduce(f64::min),
            probes: probe_s.map(|every_s| (Rhythm::new(every_s), Probes::new(probes))),
            rhythm: Rhythm::new(INTERVAL_S),
            above: above_c.map(|above_c| TimeAbove::new(simulation, above_c)),
            warpage: warpage.map(|material| WarpageEstimator::new(simulation.part(), material)),
        }
    }

    /// Runs deposition events and samples them.
    /// Without samplers they run uninterrupted, because samples would cut the long steps of the
    /// fast method and make it slower.
    pub(super) fn run(
        &mut self,
        simulation: &mut Simulation,
        events: &[DepositionEvent],
        control: &Control<'_>,
    ) -> anyhow::Result<()> {
        let result = match self.every_s {
            Some(every_s) => {
                let sample = |simulation: &Simulation| self.sample(simulation);
                simulation.run_sampled(events, every_s, sample, control)
            }
            None => simulation.run(events, control),
        };
        result.map_err(|error| match error {
            DepositError::Interrupted(_) => stopped(),
            error => error.into(),
        })
    }

    fn sample(&mut self, simulation: &Simulation) {
        let now_s = simulation.seconds();
        if let Some((rhythm, probes)) = &mut self.probes
            && rhythm.is_due(now_s)
        {
            probes.sample(simulation);
        }
        if self.rhythm.is_due(now_s) {
            self.above.iter_mut().for_each(|above| above.sample(simulation));
            self.warpage.iter_mut().for_each(|warpage| warpage.sample(simulation));
        }
    }

    /// Takes the last samples, and returns the results.
    pub(super) fn finish(
        self,
        simulation: &Simulation,
        control: &Control<'_>,
    ) -> anyhow::Result<Sampled> {
        let probes = self.probes.map(|(_, mut probes)| {
            if probes.seconds().last() != Some(&simulation.seconds()) {
                probes.sample(simulation);
            }
            probes
        });
        let above = self.above.map(|mut above| {
            above.sample(simulation);
            TimeAboveSummary::of(&above, simulation.part())
        });
        let warpage = self.warpage.map(|warpage| warpage.finish(simulation, control)).transpose();
        let warpage = warpage.map_err(|_| stopped())?;
        Ok(Sampled { probes, above, warpage })
    }
}

fn stopped() -> anyhow::Error {
    anyhow!("stopped; nothing was written")
}

impl TimeAboveSummary {
    fn of(above: &TimeAbove, part: &Voxels) -> Self {
        // The time is 0 outside the part, which changes neither the maximum nor the sum.
        let longest_s = above.seconds().iter().copied().fold(0.0, f64::max);
        let mean_s = above.seconds().iter().sum::<f64>() / part.count() as f64;
        Self { above_c: above.above_c(), longest_s, mean_s }
    }
}

/// Finds the first sample on or after each multiple of an interval.
struct Rhythm {
    every_s: f64,
    next_s: f64,
}

impl Rhythm {
    fn new(every_s: f64) -> Self {
        Self { every_s, next_s: every_s }
    }

    fn is_due(&mut self, now_s: f64) -> bool {
        let is_due = now_s >= self.next_s - ROUNDING * self.every_s;
        if is_due {
            self.next_s = ((now_s / self.every_s + ROUNDING).floor() + 1.0) * self.every_s;
        }
        is_due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_due_once_per_interval() {
        let mut rhythm = Rhythm::new(1.0);
        let due: Vec<bool> = [0.5, 1.0 - 1e-12, 1.5, 2.25, 2.5, 5.5, 5.9, 6.0]
            .map(|now_s| rhythm.is_due(now_s))
            .to_vec();
        assert_eq!(due, [false, true, false, true, false, true, false, true]);
    }
}
