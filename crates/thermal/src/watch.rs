//! Looking at a print while it goes on.

use crate::simulation::{DepositError, Simulation};
use crate::timeline::Slot;

/// Times closer to a multiple than this part of the interval are on it.
const ROUNDING: f64 = 1e-9;

impl Simulation {
    /// Runs through slots like [`Simulation::run`], and looks every so many seconds.
    ///
    /// Looks fall on multiples of `every_s` since the start of the *print*, so that layers can be
    /// watched one after the other.
    /// Pauses are cut there; the slot of a birth is not, so a look that is due in one comes at its
    /// end, and only one look if more are due.
    /// There is no look at the start and none at the end unless one is due then.
    ///
    /// What comes out differs from an unwatched run by no more than the method's error; with looks
    /// closer together than the long steps of the fast method, it costs more.
    ///
    /// # Panics
    /// If the interval is not more than 0.
    pub fn run_watched(
        &mut self,
        slots: &[Slot],
        every_s: f64,
        mut look: impl FnMut(&Self),
    ) -> Result<(), DepositError> {
        assert!(every_s > 0.0, "looks are some time apart");
        let pieces = self.check(slots)?;
        let next = |now_s: f64| ((now_s / every_s + ROUNDING).floor() + 1.0) * every_s;
        let (mut now_s, mut due_s) = (self.seconds(), next(self.seconds()));
        let (mut due_slots, mut due_pieces) = (Vec::new(), Vec::new());
        for (&slot, piece) in slots.iter().filter(|slot| slot.seconds > 0.0).zip(pieces) {
            let mut left_s = slot.seconds;
            while left_s > 0.0 {
                let is_cut = slot.voxel.is_none() && now_s + left_s > due_s;
                let seconds = if is_cut { due_s - now_s } else { left_s };
                due_slots.push(Slot { seconds, ..slot });
                due_pieces.push(crate::interval::Interval { seconds, ..piece });
                now_s += seconds;
                left_s -= seconds;
                if now_s >= due_s - ROUNDING * every_s {
                    self.step(&due_slots, &due_pieces);
                    due_slots.clear();
                    due_pieces.clear();
                    look(self);
                    now_s = self.seconds();
                    due_s = next(now_s);
                }
            }
        }
        self.step(&due_slots, &due_pieces);
        Ok(())
    }
}

/// Temperatures of some voxels over time.
///
/// ```no_run
/// # use beadwork_thermal::{Probes, Simulation, Slot};
/// # fn watch(simulation: &mut Simulation, slots: &[Slot]) -> Result<(), beadwork_thermal::DepositError> {
/// let mut probes = Probes::new(vec![[0, 0, 0], [5, 3, 1]]);
/// simulation.run_watched(slots, 0.5, |simulation| probes.look(simulation))?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Probes {
    voxels: Vec<[u32; 3]>,
    seconds: Vec<f64>,
    celsius: Vec<Option<f64>>,
}

impl Probes {
    /// At some voxels: x, y and z of each.
    pub fn new(voxels: Vec<[u32; 3]>) -> Self {
        Self { voxels, seconds: Vec::new(), celsius: Vec::new() }
    }

    /// Adds the temperatures of this moment.
    pub fn look(&mut self, simulation: &Simulation) {
        self.seconds.push(simulation.seconds());
        self.celsius.extend(self.voxels.iter().map(|&voxel| simulation.temperature_c(voxel)));
    }

    /// Where the probes are.
    pub fn voxels(&self) -> &[[u32; 3]] {
        &self.voxels
    }

    /// When they were read, s.
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// What a probe read at each of those times, °C; `None` before its voxel was born, and where
    /// there is none.
    ///
    /// # Panics
    /// If there is no such probe.
    pub fn celsius(&self, probe: usize) -> impl Iterator<Item = Option<f64>> {
        assert!(probe < self.voxels.len(), "there is a probe {probe}");
        self.celsius.iter().skip(probe).step_by(self.voxels.len()).copied()
    }
}

/// How long each voxel has been hotter than some temperature, for example the glass transition,
/// above which beads weld.
///
/// A voxel that is hotter at a look is taken to have been so since the look before.
/// So each stretch of time above the temperature is wrong by up to one interval in either
/// direction, by none on average, and stretches shorter than the interval may be missed.
/// Memory is 8 bytes for each voxel of the box around the part.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeAbove {
    above_c: f64,
    /// Columns and rows.
    plane: [usize; 2],
    last_s: f64,
    /// `[z, y, x]`.
    seconds: Vec<f64>,
}

impl TimeAbove {
    /// Hotter than so many °C, from the simulation's present on.
    pub fn new(simulation: &Simulation, above_c: f64) -> Self {
        let part = simulation.part();
        let plane = [part.frame.width as usize, part.frame.height as usize];
        let seconds = vec![0.0; plane[0] * plane[1] * part.depth];
        Self { above_c, plane, last_s: simulation.seconds(), seconds }
    }

    /// Counts the time since the last look.
    /// Linear in the box around the layers that are begun.
    pub fn look(&mut self, simulation: &Simulation) {
        let passed_s = simulation.seconds() - self.last_s;
        self.last_s = simulation.seconds();
        let [width, height] = self.plane;
        for row in simulation.rows(0..simulation.part().depth) {
            let start = (row.z as usize * height + row.y as usize) * width;
            for (x, celsius) in row.celsius() {
                if celsius > self.above_c {
                    self.seconds[start + x as usize] += passed_s;
                }
            }
        }
    }

    /// The temperature, °C.
    pub fn above_c(&self) -> f64 {
        self.above_c
    }

    /// How long each voxel of the box around the part was hotter, s, `[z, y, x]`; 0 where none is
    /// deposited.
    pub fn seconds(&self) -> &[f64] {
        &self.seconds
    }

    /// How long one voxel was hotter, s; `None` outside the box around the part.
    pub fn at(&self, [x, y, z]: [u32; 3]) -> Option<f64> {
        let [width, height] = self.plane;
        let (x, y, z) = (x as usize, y as usize, z as usize);
        let inside = x < width && y < height;
        self.seconds.get((z * height + y) * width + x).copied().filter(|_| inside)
    }
}

#[cfg(test)]
mod tests;
