//! Follows the motions of a program and checks everything that does not depend on the part.

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Motion, Program};

use super::error::CheckError;
use super::heat::Heaters;
use super::purge::PurgeTracker;
use super::wipe::WipeTracker;
use super::{modes, rates, tolerance};
use crate::Frame;
use crate::print::settings::Settings;

/// What is to be printed besides the prime tower.
pub(super) trait Part {
    /// Number of layers, which are numbered from 0 without a gap.
    fn layers(&self) -> usize;

    /// Checks a motion that extrudes into the part in a layer: position, order, tool, speed and
    /// volume.
    /// Layers never descend.
    fn motion(&mut self, motion: &Motion, layer: usize) -> Result<(), CheckError>;

    /// Ends all layers; an error if anything was not printed.
    fn finish(&mut self) -> Result<(), CheckError>;
}

/// What the program prints, apart from the shape of the part.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MachineTotals {
    /// Volume of the part, in mm³.
    pub(super) part_mm3: f64,
    /// Volume of the prime tower, in mm³.
    pub(super) prime_tower_mm3: f64,
    /// Number of changes from one tool to another.
    pub(super) tool_changes: usize,
}

/// Events between two polls for interruption.
const EVENTS_PER_POLL: usize = 4096;

/// Checks that a program prints a part, which keeps track of what was printed, and a prime tower.
pub(super) fn check_program(
    program: &Program,
    part: &mut dyn Part,
    frame: &Frame,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<MachineTotals, CheckError> {
    let mut checker = Checker::new(part, frame, settings);
    for (number, event) in program.trace().enumerate() {
        if number % EVENTS_PER_POLL == 0 {
            control.check()?;
        }
        checker.event(&event?)?;
    }
    modes::check(program)?;
    checker.part.finish()?;
    Ok(checker.totals)
}

/// The state of the printer, and what was printed so far.
struct Checker<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    part: &'a mut dyn Part,
    /// Number of the highest layer in which anything was printed.
    highest_layer: Option<usize>,
    /// For each tool, the length of filament that is retracted, in mm.
    retracted_mm: Vec<f64>,
    purge: PurgeTracker<'a>,
    heaters: Heaters<'a>,
    wipe: WipeTracker,
    totals: MachineTotals,
}

impl<'a> Checker<'a> {
    fn new(part: &'a mut dyn Part, frame: &'a Frame, settings: &'a Settings) -> Self {
        Self {
            frame,
            settings,
            part,
            highest_layer: None,
            retracted_mm: vec![settings.process.retract_mm; settings.tools.len()],
            purge: PurgeTracker::new(frame, settings),
            heaters: Heaters::new(settings),
            wipe: WipeTracker::new(settings.process.wipe_mm),
            totals: MachineTotals::default(),
        }
    }

    fn event(&mut self, event: &Event) -> Result<(), CheckError> {
        self.heaters.event(event);
        match *event {
            Event::Motion(ref motion) => self.motion(motion),
            Event::ToolChange { from: Some(from), to, line } => {
                self.filament_mm2(to, line)?;
                self.check_deselected(from, line)?;
                self.totals.tool_changes += 1;
                self.purge.tool_change(from, to);
                Ok(())
            }
            Event::ToolChange { from: None, to, line } => self.filament_mm2(to, line).map(drop),
            _ => Ok(()),
        }
    }

    /// Cross-sectional area of the filament of a tool, in mm²; an error if there is no such tool.
    fn filament_mm2(&self, tool: u8, line: usize) -> Result<f64, CheckError> {
        let tools = &self.settings.tools;
        let known = tools.get(usize::from(tool)).ok_or(CheckError::UnknownTool {
            line,
            tool,
            tools: tools.len(),
        })?;
        Ok(known.filament_mm2())
    }

    /// Checks that a tool is retracted when another one is selected, so that it does not drip.
    fn check_deselected(&self, tool: u8, line: usize) -> Result<(), CheckError> {
        let Some(&retracted_mm) = self.retracted_mm.get(usize::from(tool)) else { return Ok(()) };
        if (retracted_mm - self.settings.process.retract_mm).abs() > tolerance::FILAMENT_MM {
            return Err(CheckError::Retraction { line, tool, retracted_mm });
        }
        Ok(())
    }

    fn motion(&mut self, motion: &Motion) -> Result<(), CheckError> {
        let Motion { line, tool, .. } = *motion;
        self.check_clearance(motion)?;
        if !motion.is_extrusion() {
            return self.travel(motion);
        }
        let filament_mm2 = self.filament_mm2(tool, line)?;
        let retracted_mm = self.retracted_mm[usize::from(tool)];
        if retracted_mm.abs() > tolerance::FILAMENT_MM {
            return Err(CheckError::Retraction { line, tool, retracted_mm });
        }
        self.heaters.check(tool, line)?;
        let layer = self.layer(motion)?;
        self.wipe.extrusion(motion);
        let volume_mm3 = motion.extruded_mm * filament_mm2;
        if motion.feature == Feature::PrimeTower {
            self.totals.prime_tower_mm3 += volume_mm3;
            let process = &self.settings.process;
            rates::check_cell_speed(motion, layer, process)?;
            self.purge.tower_motion(motion, layer, volume_mm3)?;
            rates::check_volume(motion, filament_mm2, process.bead_mm2(self.frame))
        } else {
            self.totals.part_mm3 += volume_mm3;
            self.purge.part_motion(line)?;
            self.part.motion(motion, layer)
        }
    }

    /// A motion that prints nothing: travel, retraction or unretraction.
    fn travel(&mut self, motion: &Motion) -> Result<(), CheckError> {
        let Motion { line, tool, .. } = *motion;
        // A tool without settings is an error only when it prints or is selected.
        let Some(retracted_mm) = self.retracted_mm.get_mut(usize::from(tool)) else {
            return Ok(());
        };
        *retracted_mm -= motion.extruded_mm;
        if *retracted_mm < -tolerance::FILAMENT_MM {
            return Err(CheckError::Retraction { line, tool, retracted_mm: *retracted_mm });
        }
        self.wipe.other(motion)
    }

    /// Checks that the nozzle neither drags through printed layers nor leaves the build volume.
    fn check_clearance(&self, motion: &Motion) -> Result<(), CheckError> {
        let Motion { line, from_mm, to_mm, .. } = *motion;
        let bed_mm = self.settings.printer.bed_mm;
        let is_outside = |axis: usize| {
            let range = -tolerance::POSITION_MM..=bed_mm[axis] + tolerance::POSITION_MM;
            !range.contains(&to_mm[axis])
        };
        if (0..3).any(is_outside) {
            return Err(CheckError::OffBed { line, position_mm: to_mm });
        }
        let top_mm = self.highest_layer.map_or(0.0, |layer| self.frame.top_mm(layer));
        let z_mm = from_mm[2].min(to_mm[2]);
        if z_mm < top_mm - tolerance::POSITION_MM {
            return Err(CheckError::NozzleTooLow { line, z_mm, top_mm });
        }
        Ok(())
    }

    /// Number of the layer that a motion extrudes in.
    fn layer(&mut self, motion: &Motion) -> Result<usize, CheckError> {
        let (from_mm, to_mm) = (motion.from_mm[2], motion.to_mm[2]);
        let line = motion.line;
        if (to_mm - from_mm).abs() > tolerance::POSITION_MM {
            return Err(CheckError::Slope { line, from_mm, to_mm });
        }
        let number = (to_mm / self.frame.layer_mm - 1.0).round();
        let layer = number as usize;
        if number < 0.0
            || layer >= self.part.layers()
            || (self.frame.top_mm(layer) - to_mm).abs() > tolerance::POSITION_MM
        {
            return Err(CheckError::Height { line, z_mm: to_mm });
        }
        // The layer is not below the highest one so far: `check_clearance` refuses such motions.
        self.highest_layer = Some(layer);
        Ok(layer)
    }
}
