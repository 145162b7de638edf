//! What is looked at every so often while a part is printed, beside the ends of its layers.

use anyhow::anyhow;
use beadwork_base::Control;
use beadwork_part::slice::Voxels;
use beadwork_thermal::sampling::{Probes, TimeAbove};
use beadwork_thermal::simulation::DepositError;
use beadwork_thermal::warpage::{WarpageEstimate, WarpageEstimator};
use beadwork_thermal::{DepositionEvent, Simulation, ThermalMaterial};
use serde::Serialize;

/// Seconds between the looks of the warpage estimate and of the time above a temperature.
/// Estimates of different looks can't be compared, so it is the same for all prints.
const LOOK_S: f64 = 0.5;

/// Times closer to a multiple than this part of the interval are on it.
const ROUNDING: f64 = 1e-9;

/// All that is looked at.
pub(super) struct Watch {
    /// Seconds between looks; `None` if there is nothing to look at.
    every_s: Option<f64>,
    probes: Option<(Rhythm, Probes)>,
    rhythm: Rhythm,
    above: Option<TimeAbove>,
    warpage: Option<WarpageEstimator>,
}

/// What to look at.
pub(super) struct Wanted<'a> {
    /// Voxels whose temperature is followed.
    pub(super) probes: Vec<[u32; 3]>,
    /// Seconds between their readings.
    pub(super) probe_seconds: f64,
    /// The temperature whose excess is timed, °C.
    pub(super) above_c: Option<f64>,
    /// The material, if its warpage is estimated.
    pub(super) warpage: Option<&'a ThermalMaterial>,
}

/// What was seen.
pub(super) struct Seen {
    pub(super) probes: Option<Probes>,
    pub(super) above: Option<Excess>,
    pub(super) warpage: Option<WarpageEstimate>,
}

/// How long voxels were hotter than some temperature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Excess {
    pub(super) above_c: f64,
    /// Of the voxel that was so for longest.
    pub(super) longest_s: f64,
    /// Over all voxels of the part.
    pub(super) mean_s: f64,
}

impl Watch {
    /// From the simulation's present on.
    pub(super) fn new(simulation: &Simulation, wanted: Wanted<'_>) -> Self {
        let Wanted { probes, probe_seconds, above_c, warpage } = wanted;
        let own_s = (above_c.is_some() || warpage.is_some()).then_some(LOOK_S);
        let probe_s = (!probes.is_empty()).then_some(probe_seconds);
        Self {
            every_s: own_s.into_iter().chain(probe_s).reduce(f64::min),
            probes: probe_s.map(|every_s| (Rhythm::new(every_s), Probes::new(probes))),
            rhythm: Rhythm::new(LOOK_S),
            above: above_c.map(|above_c| TimeAbove::new(simulation, above_c)),
            warpage: warpage.map(|material| WarpageEstimator::new(simulation.part(), material)),
        }
    }

    /// Runs through slots; in one piece if there is nothing to look at, as looks cut the long steps
    /// of the fast method.
    pub(super) fn run(
        &mut self,
        simulation: &mut Simulation,
        slots: &[DepositionEvent],
        control: &Control<'_>,
    ) -> anyhow::Result<()> {
        let result = match self.every_s {
            Some(every_s) => {
                let sample = |simulation: &Simulation| self.look(simulation);
                simulation.run_sampled(slots, every_s, sample, control)
            }
            None => simulation.run(slots, control),
        };
        result.map_err(|error| match error {
            DepositError::Interrupted(_) => stopped(),
            error => error.into(),
        })
    }

    fn look(&mut self, simulation: &Simulation) {
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

    /// Looks a last time.
    pub(super) fn finish(
        self,
        simulation: &Simulation,
        control: &Control<'_>,
    ) -> anyhow::Result<Seen> {
        let probes = self.probes.map(|(_, mut probes)| {
            if probes.seconds().last() != Some(&simulation.seconds()) {
                probes.sample(simulation);
            }
            probes
        });
        let above = self.above.map(|mut above| {
            above.sample(simulation);
            Excess::of(&above, simulation.part())
        });
        let warpage = self.warpage.map(|warpage| warpage.finish(simulation, control)).transpose();
        let warpage = warpage.map_err(|_| stopped())?;
        Ok(Seen { probes, above, warpage })
    }
}

fn stopped() -> anyhow::Error {
    anyhow!("stopped; nothing was written")
}

impl Excess {
    fn of(above: &TimeAbove, part: &Voxels) -> Self {
        // Elsewhere in the box it is 0, which changes neither.
        let longest_s = above.seconds().iter().copied().fold(0.0, f64::max);
        let mean_s = above.seconds().iter().sum::<f64>() / part.count() as f64;
        Self { above_c: above.above_c(), longest_s, mean_s }
    }
}

/// Tells the first look on or after each multiple of an interval.
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
    fn looks_are_due_once_an_interval() {
        let mut rhythm = Rhythm::new(1.0);
        let due: Vec<bool> = [0.5, 1.0 - 1e-12, 1.5, 2.25, 2.5, 5.5, 5.9, 6.0]
            .map(|now_s| rhythm.is_due(now_s))
            .to_vec();
        assert_eq!(due, [false, true, false, true, false, true, false, true]);
    }
}
