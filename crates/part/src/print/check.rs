//! Checks a print from its text alone.
//!
//! Nothing here knows how a program is written: it follows the motions, finds the cells each of
//! them passes, and compares that with the layers that were to be printed.
//! A cell is two halves, from the side the path enters by to the middle and on to the side it
//! leaves by, so that straight beads and corners alike make one cell each.

mod error;
mod heat;
mod modes;

use beadwork_base::Control;
use beadwork_gcode::{Event, Feature, Motion, Program};
use beadwork_grid::Cell;

pub use self::error::CheckError;
use self::heat::Heaters;
use super::{Layer, PrimeTower, Settings, layer};
use crate::Frame;

/// What a checked print holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Layers of the part.
    pub layers: usize,
    /// Cells of all layers: each is printed once, with the tool of its zone.
    pub cells: u64,
    /// Volume of the part, in mm³.
    pub part_mm3: f64,
    /// Volume of the tower, in mm³.
    pub tower_mm3: f64,
    /// Changes from one tool to another.
    pub tool_changes: usize,
}

/// A cell of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellPosition {
    /// Number of the layer.
    pub layer: usize,
    /// Column of the cell.
    pub x: u32,
    /// Row of the cell.
    pub y: u32,
}

impl std::fmt::Display for CellPosition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "layer {}, cell ({}, {})", self.layer, self.x, self.y)
    }
}

/// Places have three decimals: what may be lost at each end, in mm.
const PLACE_MM: f64 = 0.001;

/// Filament has five decimals: what may be lost or kept from the motions before, in mm.
const FILAMENT_MM: f64 = 2e-5;

/// Speeds have three decimals in mm/min: what may be lost, in mm/s.
const SPEED_MM_S: f64 = 1e-4;

/// Events between two polls for interruption.
const EVENTS_PER_POLL: usize = 4096;

/// Share by which volumes may differ.
const VOLUME: f64 = 0.01;

/// Checks that a program prints these layers, which are numbered from 0 without a gap, and
/// nothing else.
///
/// - Each cell is printed once, in the order of the path, with the tool of its zone and as much
///   as the settings say, by motions from edge to edge along the middles of the cells, no
///   faster than the settings say.
///   Layers are printed upwards.
/// - Beside the part only the tower is printed, within its place and with beads like the
///   part's, in each layer up to its last.
///   After a change of tools the part goes on when the tower has taken the volume the settings
///   ask for.
/// - Once anything is printed, the head stays above the highest layer begun; it never leaves
///   the bed.
/// - Filament is drawn back before a tool is put aside, and pushed out again before a bead.
///   Marlin and Klipper count it alike.
/// - Whatever prints was set to its temperature, and waited for, as was the bed; the motors
///   hold until the last bead.
///
/// Not checked are the speed of travel, the fan, the shape of the tower, and travel across the
/// layer that is being printed.
/// Linear in the motions and cells.
pub fn check(
    program: &Program,
    layers: &[Layer<'_>],
    frame: &Frame,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Report, CheckError> {
    settings.check(frame)?;
    layer::check(layers, frame, settings)?;
    let mut checker = Checker::new(layers, frame, settings, control);
    for (number, event) in program.trace().enumerate() {
        if number % EVENTS_PER_POLL == 0 {
            control.check()?;
        }
        let event = event?;
        checker.heaters.take(&event);
        match event {
            Event::Motion(motion) => checker.motion(&motion)?,
            Event::ToolChange { from: Some(from), to, line } => {
                checker.tool(to, line)?;
                checker.put_aside(from, line)?;
                checker.report.tool_changes += 1;
                checker.purge = Some((from, to));
                checker.purged_mm3 = 0.0;
            }
            Event::ToolChange { from: None, to, line } => _ = checker.tool(to, line)?,
            _ => {}
        }
    }
    modes::check(program)?;
    checker.finish()
}
struct Checker<'a> {
    layers: &'a [Layer<'a>],
    frame: &'a Frame,
    settings: &'a Settings,
    control: &'a Control<'a>,
    /// Index of the layer that is printed.
    at: usize,
    /// Number of the highest layer that anything was printed in.
    begun: Option<usize>,
    /// Number of the highest layer that has any of the tower.
    tower: Option<usize>,
    /// For each cell of the plane, which ways from its middle to its sides were printed in this
    /// layer, as bits; two make a cell.
    halves: Vec<u8>,
    /// How many halves of cells were printed in this layer.
    printed: usize,
    /// For each tool, how far its filament is drawn back.
    drawn_mm: Vec<f64>,
    /// The last change of tools, if the part has not gone on since.
    purge: Option<(u8, u8)>,
    /// What went into the tower since.
    purged_mm3: f64,
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
            layers,
            frame,
            settings,
            control,
            at: 0,
            begun: None,
            tower: None,
            halves: vec![0; frame.width as usize * frame.height as usize],
            printed: 0,
            drawn_mm: vec![settings.process.retract_mm; settings.tools.len()],
            purge: None,
            purged_mm3: 0.0,
            heaters: Heaters::new(settings),
            report: Report { layers: layers.len(), ..Report::default() },
        }
    }

    /// Area across the filament of a tool, in mm².
    fn tool(&self, tool: u8, line: usize) -> Result<f64, CheckError> {
        let tools = &self.settings.tools;
        let known = tools.get(usize::from(tool)).ok_or(CheckError::Tool {
            line,
            tool,
            tools: tools.len(),
        })?;
        Ok(known.filament_mm2())
    }

    /// A tool that waits must not drip.
    fn put_aside(&self, tool: u8, line: usize) -> Result<(), CheckError> {
        let Some(&drawn_mm) = self.drawn_mm.get(usize::from(tool)) else { return Ok(()) };
        if (drawn_mm - self.settings.process.retract_mm).abs() > FILAMENT_MM {
            return Err(CheckError::Retraction { line, tool, drawn_mm });
        }
        Ok(())
    }

    fn motion(&mut self, motion: &Motion) -> Result<(), CheckError> {
        let Motion { line, tool, .. } = *motion;
        self.room(motion)?;
        if !motion.is_extrusion() {
            // A tool without settings matters once it extrudes.
            if let Some(drawn_mm) = self.drawn_mm.get_mut(usize::from(tool)) {
                *drawn_mm -= motion.extruded_mm;
                if *drawn_mm < -FILAMENT_MM {
                    return Err(CheckError::Retraction { line, tool, drawn_mm: *drawn_mm });
                }
            }
            return Ok(());
        }
        let filament_mm2 = self.tool(tool, line)?;
        let drawn_mm = self.drawn_mm[usize::from(tool)];
        if drawn_mm.abs() > FILAMENT_MM {
            return Err(CheckError::Retraction { line, tool, drawn_mm });
        }
        self.heaters.check(tool, line)?;
        let layer = self.layer(motion)?;
        self.speed(motion, layer)?;
        let volume = motion.extruded_mm * filament_mm2;
        let in_tower = motion.feature == Feature::PrimeTower;
        if in_tower {
            self.purged_mm3 += volume;
            self.report.tower_mm3 += volume;
            self.tower_stroke(motion, layer)?;
        } else {
            self.report.part_mm3 += volume;
            self.purged(line)?;
        }
        let expected_mm3 = motion.length_mm() * self.settings.process.bead_mm2(self.frame);
        // Both ends and the filament were rounded.
        let rounding = 2.0 * PLACE_MM * self.settings.process.bead_mm2(self.frame)
            + FILAMENT_MM * filament_mm2;
        if (volume - expected_mm3).abs() > VOLUME * expected_mm3 + rounding {
            return Err(CheckError::Volume { line, expected_mm3, got_mm3: volume });
        }
        if in_tower { Ok(()) } else { self.stroke(motion, layer) }
    }

    /// The head must neither hit what is printed nor leave the bed.
    fn room(&self, motion: &Motion) -> Result<(), CheckError> {
        let Motion { line, from_mm, to_mm: place_mm, .. } = *motion;
        let bed_mm = self.settings.printer.bed_mm;
        if (0..3).any(|axis| !(-PLACE_MM..=bed_mm[axis] + PLACE_MM).contains(&place_mm[axis])) {
            return Err(CheckError::OffBed { line, place_mm });
        }
        let top_mm = self.begun.map_or(0.0, |layer| self.frame.top_mm(layer));
        let z_mm = from_mm[2].min(place_mm[2]);
        if z_mm < top_mm - PLACE_MM {
            Err(CheckError::NozzleTooLow { line, z_mm, top_mm })
        } else {
            Ok(())
        }
    }

    fn speed(&self, motion: &Motion, layer: usize) -> Result<(), CheckError> {
        let process = &self.settings.process;
        let most_mm_s = if layer == 0 { process.first_layer_mm_s } else { process.print_mm_s };
        let got_mm_s = motion.feed_mm_s;
        // Rounded in mm/min.
        if got_mm_s <= most_mm_s + SPEED_MM_S {
            return Ok(());
        }
        Err(CheckError::Speed { line: motion.line, got_mm_s, most_mm_s })
    }

    /// Number of the layer a motion extrudes in.
    fn layer(&mut self, motion: &Motion) -> Result<usize, CheckError> {
        let (from_mm, to_mm) = (motion.from_mm[2], motion.to_mm[2]);
        let line = motion.line;
        if (to_mm - from_mm).abs() > PLACE_MM {
            return Err(CheckError::Slope { line, from_mm, to_mm });
        }
        let number = (to_mm / self.frame.layer_mm - 1.0).round();
        let layer = number as usize;
        if number < 0.0
            || layer >= self.layers.len()
            || (self.frame.top_mm(layer) - to_mm).abs() > PLACE_MM
        {
            return Err(CheckError::Height { line, z_mm: to_mm });
        }
        // It is none below, or the head would be too low.
        self.begun = Some(layer);
        Ok(layer)
    }

    fn tower_stroke(&mut self, motion: &Motion, layer: usize) -> Result<(), CheckError> {
        let line = motion.line;
        let tower = self.settings.purge.as_ref().and_then(|purge| purge.tower);
        let PrimeTower { left_mm, front_mm, width_mm, depth_mm } =
            tower.ok_or(CheckError::PrimeTowerOutside { line })?;
        let half = self.frame.cell_mm / 2.0 - PLACE_MM;
        let sides = [(left_mm, left_mm + width_mm), (front_mm, front_mm + depth_mm)];
        let is_within = |place: [f64; 3]| {
            let mut sides = sides.iter().zip(place);
            sides.all(|(&(low, high), at)| low + half <= at && at <= high - half)
        };
        if !is_within(motion.from_mm) || !is_within(motion.to_mm) {
            return Err(CheckError::PrimeTowerOutside { line });
        }
        if self.tower.map_or(0, |below| below + 1) < layer {
            return Err(CheckError::PrimeTowerInAir { line, layer });
        }
        self.tower = Some(layer);
        Ok(())
    }

    /// The part goes on: enough must have been purged.
    fn purged(&mut self, line: usize) -> Result<(), CheckError> {
        let Some((from, to)) = self.purge.take() else { return Ok(()) };
        let asked_mm3 =
            self.settings.purge.as_ref().map_or(0.0, |purge| purge.prime_tower_mm3(from, to));
        // Rounded filament may lack a thousandth.
        if self.purged_mm3 < asked_mm3 * 0.999 {
            return Err(CheckError::Purge { line, from, to, asked_mm3, got_mm3: self.purged_mm3 });
        }
        Ok(())
    }

    /// Marks the halves of cells that a motion prints.
    fn stroke(&mut self, motion: &Motion, number: usize) -> Result<(), CheckError> {
        let line = motion.line;
        while self.layers[self.at].number < number {
            self.close()?;
        }
        let layer = self.layers[self.at];
        let off = || CheckError::OffCentre {
            line,
            layer: number,
            from_mm: [motion.from_mm[0], motion.from_mm[1]],
            to_mm: [motion.to_mm[0], motion.to_mm[1]],
        };
        let begin = self.halves_at(motion.from_mm).ok_or_else(off)?;
        let end = self.halves_at(motion.to_mm).ok_or_else(off)?;
        let axis = match (begin[0] == end[0], begin[1] == end[1]) {
            (false, true) => 0,
            (true, false) => 1,
            _ => return Err(off()),
        };
        // Middles are odd: the motion keeps to those of one row or column.
        if begin[1 - axis].rem_euclid(2) == 0 {
            return Err(off());
        }
        let rises = begin[axis] < end[axis];
        for step in 0..begin[axis].abs_diff(end[axis]) as i32 {
            // The half between two marks has the number of the lower one.
            let half = if rises { begin[axis] + step } else { begin[axis] - step - 1 };
            let mut cell = [begin[0].div_euclid(2), begin[1].div_euclid(2)];
            cell[axis] = half.div_euclid(2);
            let side = 2 * axis as u8 + half.rem_euclid(2) as u8;
            self.half(layer, cell, side, motion)?;
        }
        Ok(())
    }

    /// A place in halves of a cell from the corner of the plane; `None` if it is neither a middle
    /// nor an edge, or far away.
    fn halves_at(&self, place_mm: [f64; 3]) -> Option<[i32; 2]> {
        let half_mm = self.frame.cell_mm / 2.0;
        // A hundredth of a cell, and what rounding takes.
        let near = (0.01 * self.frame.cell_mm + PLACE_MM).min(0.4 * half_mm);
        let halves = [place_mm[0] - self.frame.left_mm, self.frame.back_mm - place_mm[1]]
            .map(|way| way / half_mm);
        let whole = halves.map(f64::round);
        let fits = (0..2).all(|axis| {
            (halves[axis] - whole[axis]).abs() * half_mm <= near
                && (-2.0..1e5).contains(&whole[axis])
        });
        fits.then(|| whole.map(|value| value as i32))
    }

    fn half(
        &mut self,
        layer: Layer<'_>,
        [x, y]: [i32; 2],
        side: u8,
        motion: &Motion,
    ) -> Result<(), CheckError> {
        let line = motion.line;
        // A cell left of or behind the plane is named by the one next to it.
        let place = CellPosition { layer: layer.number, x: x.max(0) as u32, y: y.max(0) as u32 };
        let inside = x >= 0 && y >= 0 && place.x < self.frame.width && place.y < self.frame.height;
        let cell = if inside { place.y * self.frame.width + place.x } else { u32::MAX };
        if !layer.region.contains(cell) {
            return Err(CheckError::Outside { line, place });
        }
        let (expected, got) = (layer.zones.id(cell), motion.tool);
        if expected != got {
            return Err(CheckError::WrongTool { line, place, expected, got });
        }
        let halves = &mut self.halves[cell as usize];
        if *halves & 1 << side != 0 || halves.count_ones() == 2 {
            return Err(CheckError::PrintedTwice { line, place });
        }
        *halves |= 1 << side;
        // No half came twice, so that there are not more of them than the path has.
        let next = layer.path.order()[self.printed / 2];
        if cell != next || side != way(layer, cell)[self.printed % 2] {
            return Err(CheckError::OffPath {
                line,
                place,
                expected: layer.region.xy(next).into(),
            });
        }
        self.printed += 1;
        Ok(())
    }

    /// The layer is over: nothing may lack.
    fn close(&mut self) -> Result<(), CheckError> {
        let layer = self.layers[self.at];
        for cell in layer.region.cells() {
            let halves = std::mem::take(&mut self.halves[cell as usize]).count_ones();
            if halves < 2 {
                let (x, y) = layer.region.xy(cell);
                let place = CellPosition { layer: layer.number, x, y };
                return Err(CheckError::Missing { place, share: f64::from(halves) / 2.0 });
            }
        }
        self.printed = 0;
        self.report.cells += u64::from(layer.region.cell_count());
        self.at += 1;
        self.control.report(self.at, self.layers.len());
        Ok(())
    }

    fn finish(mut self) -> Result<Report, CheckError> {
        while self.at < self.layers.len() {
            self.close()?;
        }
        Ok(self.report)
    }
}

/// The sides that a path enters and leaves a cell by: 0 left, 1 right, 2 behind, 3 in front.
/// A bead begins and ends straight, one of a single cell runs to the right.
fn way(layer: Layer<'_>, cell: Cell) -> [u8; 2] {
    let side = |other: Cell| {
        let ([x, y], [other_x, other_y]) = (layer.place(cell), layer.place(other));
        match (other_x - x, other_y - y) {
            (-1, _) => 0,
            (1, _) => 1,
            (_, -1) => 2,
            _ => 3,
        }
    };
    let (before, after) = (layer.path.previous(cell).map(side), layer.path.next(cell).map(side));
    // Opposite sides differ in the last bit.
    let enter = before.or(after.map(|side| side ^ 1)).unwrap_or(0);
    [enter, after.unwrap_or(enter ^ 1)]
}

#[cfg(test)]
mod tests;
