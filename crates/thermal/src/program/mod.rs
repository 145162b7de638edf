//! A printer's program as births and pauses.

mod visit;
mod voxels;

use beadwork_gcode::{Event, Feature, Motion, MotionLimits, Program, TraceError};
use beadwork_part::Frame;
use beadwork_part::print::Printer;
use beadwork_part::slice::Voxels;
use thiserror::Error;

use crate::timeline::Slot;

use self::visit::{Visit, Visits};

pub use self::voxels::{VoxelsError, program_voxels};

/// How a program is put on voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramSettings {
    /// What the printer can do, where the program does not say.
    pub limits: MotionLimits,
    /// Share of the part's voxels that the program may leave out, from 0 to 1.
    pub tolerated_share: f64,
}

impl Default for ProgramSettings {
    /// A usual printer, and no voxel left out.
    fn default() -> Self {
        Self { limits: Printer::default().limits(), tolerated_share: 0.0 }
    }
}

/// What a program does to a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramSlots {
    /// Births and pauses from the beginning of the program to its end.
    pub slots: Vec<Slot>,
    /// For each layer, how many slots it takes until the last of its voxels that are born is
    /// complete; 0 if none is.
    pub layer_ends: Vec<usize>,
    /// Voxels that are never born, by z, y and x; [`ProgramSlots::printed`] is the part without
    /// them.
    pub missed: Vec<[u32; 3]>,
}

/// Why a program can't be put on a part.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProgramError {
    /// The program makes no sense.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The program leaves out more of the part than is tolerated.
    #[error(
        "the program leaves out {missed} of {voxels} voxels of the part, first that at {voxel:?} in layer {layer}"
    )]
    Missed {
        /// x, y and z of the first of them.
        voxel: [u32; 3],
        /// Its layer, from 1 as people count.
        layer: u32,
        /// Voxels left out.
        missed: usize,
        /// Voxels of the part.
        voxels: usize,
    },
}

/// The births of a part's voxels by a program, and the time between them.
///
/// A voxel is born when the nozzle, laying a bead, enters its cell on a way that comes as near to
/// the cell's centre as half a cell, in the height of the cell's layer; its slot lasts until the
/// nozzle leaves the cell, at the speed that acceleration and corners allow.
/// All else is a pause: travel, retraction, beads beside the part (a purge tower, a skirt,
/// supports) and beads on voxels that are born already.
/// The slots add up to [`Program::print_seconds`], which knows nothing of how long heating takes.
///
/// Whether a voxel has something to lie on is for [`crate::Simulation`] to say.
/// Linear in the program's way and the part's box.
pub fn program_slots(
    program: &Program,
    part: &Voxels,
    settings: &ProgramSettings,
) -> Result<ProgramSlots, ProgramError> {
    let mut births = Births::new(part);
    let mut visits = Visits::new(part.frame);
    for step in program.timed_events(settings.limits) {
        let (event, pace) = step?;
        match event {
            Event::Motion(motion) if is_bead(&motion) => {
                visits.bead(&motion, |way_mm| pace.seconds_to(way_mm), &mut |visit| {
                    births.visit(visit)
                });
            }
            _ => {
                visits.end(&mut |visit| births.visit(visit));
                births.pause(pace.seconds());
            }
        }
    }
    visits.end(&mut |visit| births.visit(visit));
    births.finish(settings)
}

impl ProgramSlots {
    /// The part as the program prints it: without the voxels that it leaves out.
    pub fn printed(&self, part: &Voxels) -> Voxels {
        let mut materials = part.materials().to_owned();
        for &[x, y, z] in &self.missed {
            materials[[z as usize, y as usize, x as usize]] = Voxels::EMPTY;
        }
        Voxels::new(part.frame, materials)
    }
}

/// Whether it lays down what may be of the part.
fn is_bead(motion: &Motion) -> bool {
    let beside = [Feature::PrimeTower, Feature::Skirt, Feature::Support, Feature::Custom];
    motion.is_extrusion() && !beside.contains(&motion.feature)
}

/// Slots in the making.
struct Births<'a> {
    part: &'a Voxels,
    born: Vec<bool>,
    slots: Vec<Slot>,
    layer_ends: Vec<usize>,
}

impl<'a> Births<'a> {
    fn new(part: &'a Voxels) -> Self {
        let born = vec![false; part.materials().len()];
        Self { part, born, slots: Vec::new(), layer_ends: vec![0; part.depth] }
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let Frame { width, height, .. } = self.part.frame;
        (z as usize * height as usize + y as usize) * width as usize + x as usize
    }

    fn visit(&mut self, visit: &Visit) {
        let voxel =
            visit.voxel().filter(|&[x, y, z]| self.part.material(x, y, z as usize).is_some());
        if let Some(voxel) = voxel {
            let index = self.index(voxel);
            if !std::mem::replace(&mut self.born[index], true) {
                self.slots.push(Slot { voxel: Some(voxel), seconds: visit.seconds });
                self.layer_ends[voxel[2] as usize] = self.slots.len();
                return;
            }
        }
        self.pause(visit.seconds);
    }

    fn pause(&mut self, seconds: f64) {
        if seconds <= 0.0 {
            return;
        }
        match self.slots.last_mut() {
            Some(last) if last.voxel.is_none() => last.seconds += seconds,
            _ => self.slots.push(Slot::pause(seconds)),
        }
    }

    fn finish(self, settings: &ProgramSettings) -> Result<ProgramSlots, ProgramError> {
        let width = self.part.frame.width;
        let mut missed = Vec::new();
        for z in 0..self.part.depth as u32 {
            let voxels = self.part.cells(z as usize).map(|cell| [cell % width, cell / width, z]);
            missed.extend(voxels.filter(|&voxel| !self.born[self.index(voxel)]));
        }
        let voxels = self.part.count();
        if let Some(&voxel) = missed.first()
            && missed.len() as f64 > settings.tolerated_share * voxels as f64
        {
            let missed = missed.len();
            return Err(ProgramError::Missed { voxel, layer: voxel[2] + 1, missed, voxels });
        }
        Ok(ProgramSlots { slots: self.slots, layer_ends: self.layer_ends, missed })
    }
}

#[cfg(test)]
mod tests;
