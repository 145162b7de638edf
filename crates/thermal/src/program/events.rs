//! A G-code program as deposition events.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::{Event, MotionLimits, Program, TraceError};
use beadwork_part::Frame;
use beadwork_part::print::Printer;
use beadwork_part::slice::Voxels;
use thiserror::Error;

use super::poll::Poll;
use super::rows::Rows;
use super::visit::{Visit, Visits};
use crate::event::DepositionEvent;

/// How a program is mapped to voxels.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Speed and acceleration limits of the printer, for programs that do not set their own.
    pub limits: MotionLimits,
    /// Largest share of the part's voxels that the program may leave out, 0 to 1.
    pub tolerated_share: f64,
}

impl Default for Settings {
    /// The limits of the default printer; no voxel may be left out.
    fn default() -> Self {
        Self { limits: Printer::default().limits(), tolerated_share: 0.0 }
    }
}

/// What a program deposits of a part, and when.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgramEvents {
    /// The events from the beginning of the program to its end.
    pub events: Vec<DepositionEvent>,
    /// For each layer, the number of events until its last deposited voxel is complete; 0 if none
    /// is deposited.
    pub layer_ends: Vec<usize>,
    /// x, y and z of the voxels that are not deposited, in the order of z, y and x;
    /// [`ProgramEvents::printed`] is the part without them.
    pub missed: Vec<[u32; 3]>,
}

/// Why a program cannot be mapped to a part.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProgramError {
    /// A line of the program is invalid.
    #[error(transparent)]
    Trace(TraceError),
    /// The program leaves out more of the part than is tolerated.
    #[error(
        "the program leaves out {missed} of {voxels} voxels of the part, the first at {voxel:?} \
         in layer {layer}"
    )]
    Missed {
        /// x, y and z of the first of them.
        voxel: [u32; 3],
        /// Its layer, counted from 1.
        layer: u32,
        /// Number of voxels left out.
        missed: usize,
        /// Number of voxels of the part.
        voxels: usize,
    },
    /// The call was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl From<TraceError> for ProgramError {
    fn from(error: TraceError) -> Self {
        match error {
            TraceError::Interrupted(interrupted) => Self::Interrupted(interrupted),
            error => Self::Trace(error),
        }
    }
}

/// Finds out when a program deposits each voxel of a part.
///
/// A bead deposits a voxel when the nozzle enters the voxel's cell, at the height of its layer, on
/// a path that passes within half a cell of the cell's centre.
/// The event lasts until the nozzle leaves the cell, at the speed that acceleration and corners
/// allow.
/// A bead in a layer of another height deposits the voxels whose centres lie within the layer, in
/// equal parts of that time; [`program_fit`](super::program_fit) measures the error.
/// Everything else is a pause: travel, retraction, beads next to the part (prime tower, skirt,
/// supports), and beads over voxels that are deposited already.
/// The events add up to [`Program::print_seconds`], which does not include waiting for heaters.
///
/// [`Simulation::run`](crate::Simulation::run) checks whether each voxel has a support; this
/// function does not.
/// Progress counts lines of the program.
/// Linear in the length of the program's path in cells and in the part's bounding box.
pub fn program_events(
    program: &Program,
    part: &Voxels,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<ProgramEvents, ProgramError> {
    control.check()?;
    let lines = program.lines.len();
    let mut builder = EventBuilder::new(part);
    let Frame { cell_mm, layer_mm, .. } = part.frame;
    let rows = Rows::of_program(program, cell_mm, layer_mm, control)?;
    let mut visits = Visits::new(part.frame);
    let mut poll = Poll::new(control, 0, lines);
    for step in program.timed_events(settings.limits) {
        let (event, pace) = step?;
        poll.count(&event)?;
        match event {
            Event::Motion(motion) if rows.is_part(&motion) => {
                let seconds_to = |length_mm| pace.seconds_to(length_mm);
                visits.add_bead(&motion, rows.of(&motion), seconds_to, &mut |visit| {
                    builder.visit(visit);
                });
            }
            _ => {
                visits.end_bead(&mut |visit| builder.visit(visit));
                builder.pause(pace.seconds());
            }
        }
    }
    visits.end_bead(&mut |visit| builder.visit(visit));
    let events = builder.finish(settings)?;
    control.report(lines, lines);
    Ok(events)
}

impl ProgramEvents {
    /// The events of each layer of the part, for a program that completes layers from the bed up:
    /// from where those of the layer below end, up to its last deposition.
    /// What follows the last layer is left out.
    pub fn layers(&self) -> Vec<Vec<DepositionEvent>> {
        let mut begin = 0;
        let of_layer = |&end: &usize| {
            let end = end.max(begin);
            self.events[std::mem::replace(&mut begin, end)..end].to_vec()
        };
        self.layer_ends.iter().map(of_layer).collect()
    }

    /// The part as the program prints it: without the voxels that it leaves out.
    pub fn printed(&self, part: &Voxels) -> Voxels {
        let mut materials = part.materials().to_owned();
        for &[x, y, z] in &self.missed {
            materials[[z as usize, y as usize, x as usize]] = Voxels::EMPTY;
        }
        Voxels::new(part.frame, materials)
    }
}

/// Turns visits and pauses into events.
struct EventBuilder<'a> {
    part: &'a Voxels,
    /// Whether a voxel is deposited, `[z, y, x]`.
    deposited: Vec<bool>,
    events: Vec<DepositionEvent>,
    layer_ends: Vec<usize>,
}

impl<'a> EventBuilder<'a> {
    fn new(part: &'a Voxels) -> Self {
        let deposited = vec![false; part.materials().len()];
        Self { part, deposited, events: Vec::new(), layer_ends: vec![0; part.depth] }
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let Frame { width, height, .. } = self.part.frame;
        (z as usize * height as usize + y as usize) * width as usize + x as usize
    }

    /// Deposits the voxels of a visit, one after the other, or waits if there is none to deposit.
    fn visit(&mut self, visit: &Visit) {
        let is_new = |&[x, y, z]: &[u32; 3]| {
            self.part.material(x, y, z as usize).is_some() && !self.deposited[self.index([x, y, z])]
        };
        let count = visit.voxels().take(self.part.depth).filter(is_new).count();
        if count == 0 {
            self.pause(visit.seconds);
            return;
        }
        let seconds = visit.seconds / count as f64;
        for voxel in visit.voxels().take(self.part.depth) {
            let [x, y, z] = voxel;
            let index = self.index(voxel);
            if self.part.material(x, y, z as usize).is_some()
                && !std::mem::replace(&mut self.deposited[index], true)
            {
                self.events.push(DepositionEvent { voxel: Some(voxel), seconds });
                self.layer_ends[z as usize] = self.events.len();
            }
        }
    }

    /// Adds a pause, or extends one.
    fn pause(&mut self, seconds: f64) {
        if seconds <= 0.0 {
            return;
        }
        match self.events.last_mut() {
            Some(last) if last.voxel.is_none() => last.seconds += seconds,
            _ => self.events.push(DepositionEvent::pause(seconds)),
        }
    }

    fn finish(self, settings: &Settings) -> Result<ProgramEvents, ProgramError> {
        let width = self.part.frame.width;
        let mut missed = Vec::new();
        for z in 0..self.part.depth as u32 {
            let voxels = self.part.cells(z as usize).map(|cell| [cell % width, cell / width, z]);
            missed.extend(voxels.filter(|&voxel| !self.deposited[self.index(voxel)]));
        }
        let voxels = self.part.count();
        if let Some(&voxel) = missed.first()
            && missed.len() as f64 > settings.tolerated_share * voxels as f64
        {
            let missed = missed.len();
            return Err(ProgramError::Missed { voxel, layer: voxel[2] + 1, missed, voxels });
        }
        Ok(ProgramEvents { events: self.events, layer_ends: self.layer_ends, missed })
    }
}
