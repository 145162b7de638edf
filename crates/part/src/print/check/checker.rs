//! Follows the motions of a program and checks each of them.

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Motion, Program};

use super::cells::CellTracker;
use super::error::CheckError;
use super::heat::Heaters;
use super::purge::PurgeTracker;
use super::{modes, tolerance};
use crate::Frame;
use crate::print::layer::Layer;
use crate::print::settings::Settings;
use crate::print::validate::validate;

/// Totals of a checked print.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Number of layers of the part.
    pub layers: usize,
    /// Number of cells in all layers; each is printed once, with the tool of its zone.
    pub cells: u64,
    /// Volume of the part, in mm³.
    pub part_mm3: f64,
    /// Volume of the prime tower, in mm³.
    pub prime_tower_mm3: f64,
    /// Number of changes from one tool to another.
    pub tool_changes: usize,
}

/// Events between two polls for interruption.
const EVENTS_PER_POLL: usize = 4096;

/// Checks that a program prints these layers, and nothing else besides the prime tower.
///
/// The layers must be numbered from 0 without a gap.
///
/// - Each cell is printed once, in the order of the path, with the tool of its zone and the volume
///   of the settings.
///   Motions run from edge to edge through the centres of the cells, no faster than the settings
///   allow.
///   Layers are printed upwards.
/// - The prime tower is printed within its position, with the bead cross-section of the part, and
///   in every layer up to the last one that has it.
///   After a tool change, the part continues only after the purge volume was extruded into the
///   tower.
/// - The nozzle never moves below the top of the highest layer begun, and never leaves the build
///   volume.
/// - Filament is retracted before a tool change, and unretracted before a bead.
///   Marlin and Klipper interpret every extrusion alike.
/// - Before anything is printed, the program sets the temperatures of nozzle and bed and waits for
///   them; the motors stay on until the last bead.
///
/// The travel speed, the fan, the shape of the prime tower, and travel across the layer that is
/// being printed are not checked.
///
/// Progress counts layers.
/// Takes time linear in the motions and cells.
pub fn check(
    program: &Program,
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Report, CheckError> {
    validate(layers, frame, settings)?;
    let mut checker = Checker::new(layers, frame, settings, control);
    for (number, event) in program.trace().enumerate() {
        if number % EVENTS_PER_POLL == 0 {
            control.check()?;
        }
        checker.event(&event?)?;
    }
    modes::check(program)?;
    checker.finish()
}

/// The state of the printer, and what was printed so far.
struct Checker<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    layer_count: usize,
    /// Number of the highest layer in which anything was printed.
    highest_layer: Option<usize>,
    /// For each tool, the length of filament that is retracted, in mm.
    retracted_mm: Vec<f64>,
    cells: CellTracker<'a>,
    purge: PurgeTracker<'a>,
    heaters: Heaters<'a>,
    report: Report,
}

impl<'a> Checker<'a> {
    fn new(
        layers: &'a [Layer<'a>],
        frame: &'a Frame,
        settings: &'a Settings,
        control: &'a Control<'a>,
    ) -> Self {
        Self {
            frame,
            settings,
            layer_count: layers.len(),
            highest_layer: None,
            retracted_mm: vec![settings.process.retract_mm; settings.tools.len()],
            cells: CellTracker::new(layers, frame, control),
            purge: PurgeTracker::new(frame, settings),
            heaters: Heaters::new(settings),
            report: Report { layers: layers.len(), ..Report::default() },
        }
    }

    fn event(&mut self, event: &Event) -> Result<(), CheckError> {
        self.heaters.event(event);
        match *event {
            Event::Motion(ref motion) => self.motion(motion),
            Event::ToolChange { from: Some(from), to, line } => {
                self.filament_mm2(to, line)?;
                self.check_deselected(from, line)?;
                self.report.tool_changes += 1;
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
        self.check_speed(motion, layer)?;
        let volume_mm3 = motion.extruded_mm * filament_mm2;
        let is_prime_tower = motion.feature == Feature::PrimeTower;
        if is_prime_tower {
            self.report.prime_tower_mm3 += volume_mm3;
            self.purge.tower_motion(motion, layer, volume_mm3)?;
        } else {
            self.report.part_mm3 += volume_mm3;
            self.purge.part_motion(line)?;
        }
        self.check_volume(motion, volume_mm3, filament_mm2)?;
        if is_prime_tower { Ok(()) } else { self.cells.motion(motion, layer) }
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
        Ok(())
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

    fn check_speed(&self, motion: &Motion, layer: usize) -> Result<(), CheckError> {
        let process = &self.settings.process;
        let max_mm_s = if layer == 0 { process.first_layer_mm_s } else { process.print_mm_s };
        let got_mm_s = motion.feed_mm_s;
        if got_mm_s <= max_mm_s + tolerance::SPEED_MM_S {
            return Ok(());
        }
        Err(CheckError::Speed { line: motion.line, got_mm_s, max_mm_s })
    }

    fn check_volume(
        &self,
        motion: &Motion,
        got_mm3: f64,
        filament_mm2: f64,
    ) -> Result<(), CheckError> {
        let bead_mm2 = self.settings.process.bead_mm2(self.frame);
        let expected_mm3 = motion.length_mm() * bead_mm2;
        // Both ends of the motion and the filament length were rounded.
        let rounding_mm3 =
            2.0 * tolerance::POSITION_MM * bead_mm2 + tolerance::FILAMENT_MM * filament_mm2;
        if (got_mm3 - expected_mm3).abs() > tolerance::VOLUME * expected_mm3 + rounding_mm3 {
            return Err(CheckError::Volume { line: motion.line, expected_mm3, got_mm3 });
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
            || layer >= self.layer_count
            || (self.frame.top_mm(layer) - to_mm).abs() > tolerance::POSITION_MM
        {
            return Err(CheckError::Height { line, z_mm: to_mm });
        }
        // The layer is not below the highest one so far: `check_clearance` refuses such motions.
        self.highest_layer = Some(layer);
        Ok(layer)
    }

    fn finish(mut self) -> Result<Report, CheckError> {
        self.report.cells = self.cells.finish()?;
        Ok(self.report)
    }
}
